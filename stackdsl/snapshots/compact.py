"""The snapshot of very many bricks, short enough to read: what those of a level have in common, and a mark of each.

The mark of a brick is a hash of what has no tolerance: its name, when and where it is placed, how it is turned and
made, which is compiled alike everywhere, and which bodies carry it. What a run finds out is locked in numbers, with
their tolerances: shares and margins for as many bricks at a time as have them alike, once for all levels where most
agree; and where a brick ended only if that is not where it was placed.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from typing import Final

from stackdsl.snapshots.canonical import ENCODER, block, canonical_text, document, event_text
from stackdsl.snapshots.record import COMPACT_FORMAT, MARGIN, POSITION, SHARE, Snapshot
from stackdsl.snapshots.rows import Object, Row, are_alike, array_at, events_with, object_at, rows_of
from stackdsl.snapshots.unclear import is_number

MANY: Final = 1000  # bricks above which a file is written so; 1000 take 350 kB in full
LEVELS: Final = "levels"
DIGEST: Final = "sha256"
USUAL: Final = "usual"  # what most levels have in common
COLUMNS: Final = ("margins", "placed_on", "ends", "rests_on")
LEVEL_KEYS: Final = ("bricks", "mean_mm", "marks", *COLUMNS)


def golden_text(snapshot: Snapshot) -> str:
    """The text of a golden file: in full, or by level if there are very many bricks."""
    if len(snapshot.bricks) <= MANY:
        return canonical_text(snapshot)
    short = shortened(document(snapshot))
    head = {key: value for key, value in short.items() if key not in (LEVELS, "events", "bricks")}
    lines = [f"  {_json(key)}: {_json(value)}" for key, value in head.items()]
    for key in (LEVELS, "bricks"):
        entries = [f"    {_json(name)}: {_json(entry)}" for name, entry in object_at(short, key).items()]
        lines.append(f'  "{key}": ' + block("{}", entries, "  "))
    events = [event_text(event) for event in array_at(short, "events") if isinstance(event, Mapping)]
    lines.insert(-1, '  "events": ' + block("[]", events, "  "))
    return block("{}", lines, "") + "\n"


def _json(value: object) -> str:
    return ENCODER.encode(value)


def shortened(full: Object) -> dict[str, object]:
    """A document in full, by level; bricks that ended elsewhere than where they were placed stay in full."""
    rows = rows_of(full)
    levels: defaultdict[str, list[Row]] = defaultdict(list)
    for row in rows.values():
        if row.is_ordinary:
            levels[str(row.final.get("level"))].append(row)
    columns = {level: _columns(each) for level, each in levels.items()}
    usual = {key: _commonest([each[key] for each in columns.values()]) for key in COLUMNS}
    kept = {name for name, row in rows.items() if not row.is_ordinary}
    rest = {key: value for key, value in full.items() if key not in ("events", "bricks")}
    return {
        **rest,
        "format": COMPACT_FORMAT,
        DIGEST: digest_of(row for row in rows.values() if row.is_ordinary),
        USUAL: usual,
        LEVELS: {level: _level(each, columns[level], usual) for level, each in levels.items()},
        "events": list(events_with(full, kept.__contains__)),
        "bricks": {name: rows[name].final for name in rows if name in kept},
    }


def digest_of(rows: Iterable[Row]) -> str:
    """One digest of what the author decides of some bricks, for what marks are too short."""
    return sha256(b"".join(row.digest for row in rows)).hexdigest()


def _level(rows: Sequence[Row], columns: Mapping[str, list[object]], usual: Object) -> dict[str, object]:
    places = [row.placed["at_mm"] for row in rows]
    means = [_mean([place[axis] for place in places if isinstance(place, list)]) for axis in range(3)]
    own = {key: runs for key, runs in columns.items() if runs != [[len(rows), usual[key]]]}
    return {"bricks": len(rows), "mean_mm": means, "marks": "".join(row.mark for row in rows), **own}


def _columns(rows: Sequence[Row]) -> dict[str, list[object]]:
    """What a run found out of the bricks of a level."""
    return {
        "margins": _runs([(row.event or {}).get("margin_mm") for row in rows], MARGIN.tolerance),
        "placed_on": _runs([_shares(row.placed) for row in rows], SHARE.tolerance),
        "ends": _runs([_end(row) for row in rows], 0.0),
        "rests_on": _runs([_shares(row.final) for row in rows], SHARE.tolerance),
    }


def _commonest(columns: Iterable[list[object]]) -> object:
    """What most levels have alike of all their bricks; None if no level has."""
    alike = [runs[0][1] for runs in columns if len(runs) == 1 and isinstance(runs[0], list)]
    counted = Counter(map(_json, alike))
    return max(alike, key=lambda value: counted[_json(value)], default=None)


def _shares(holder: Object) -> object:
    return list(object_at(holder, "rests_on").values()) if "rests_on" in holder else None


def _end(row: Row) -> object:
    state = row.final.get("state")
    return state if row.end is not None else [state, False]


def _runs(values: Sequence[object], tolerance: float) -> list[object]:
    """Values as pairs of how many one after another are alike, and the first of these."""
    runs: list[tuple[int, object]] = []
    for value in values:
        if runs and are_alike(runs[-1][1], value, tolerance):
            runs[-1] = (runs[-1][0] + 1, runs[-1][1])
        else:
            runs.append((1, value))
    return [list(run) for run in runs]


def _mean(values: Sequence[object]) -> object:
    numbers = [value for value in values if is_number(value)]
    return round(sum(numbers) / len(numbers), POSITION.digits) + 0.0 if numbers else None
