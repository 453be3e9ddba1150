"""The compact format of snapshots of very many bricks."""

from base64 import b64encode
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from itertools import chain
from typing import Final, TypeAlias

from stackdsl.goldens.file_format import ENCODER, block, canonical_text, document, event_text, is_number
from stackdsl.goldens.snapshot import COMPACT_FORMAT, MARGIN, POSITION, SHARE, MalformedSnapshotError, Snapshot
from stackdsl.results import GoldenDifference

# What a document in full says of one brick, and the mark of that: for files that hold very many bricks in short.


MARK: Final = 3  # [characters of six bits] of a brick; another one has the same by one chance in 260,000
ALIKE: Final = 0.2  # of a tolerance: what numbers that are written as one may differ by

Object: TypeAlias = Mapping[str, object]  # of JSON


class Row:
    """All that a document in full says of one brick."""

    def __init__(self, name: str, final: Object, event: Object | None) -> None:
        self.name, self.final, self.event = name, final, event
        self.placed = object_at(object_at(event or {}, "placed"), name)

    @property
    def is_ordinary(self) -> bool:
        """Whether it was placed, and either ended there or its end is not locked."""
        return bool(self.placed) and (self.end is None or are_alike(self.end, self.placed["at_mm"], POSITION.tolerance))

    @property
    def end(self) -> object:
        return self.final.get("at_mm")

    @cached_property
    def digest(self) -> bytes:
        """A hash of what has no tolerance."""
        made = [self.placed.get(key) for key in ("at_mm", "turn_deg", "size_mm", "mass_g")]
        carriers = [sorted(object_at(each, "rests_on")) for each in (self.placed, self.final)]
        decided = [self.name, (self.event or {}).get("time_s"), *made, self.final.get("level"), *carriers]
        return sha256(ENCODER.encode(decided).encode()).digest()

    @property
    def mark(self) -> str:
        """The beginning of it."""
        return b64encode(self.digest, b"-_")[:MARK].decode()


def rows_of(full: Object) -> dict[str, Row]:
    """All bricks of a document in full."""
    placings = [event for event in array_at(full, "events") if isinstance(event, dict)]
    events = {name: event for event in placings for name in object_at(event, "placed")}
    bricks = object_at(full, "bricks")
    return {name: Row(name, object_at(bricks, name), events.get(name)) for name in bricks}


def events_with(full: Object, wanted: Callable[[str], bool]) -> Iterator[Object]:
    """The events, with the placings of some bricks only."""
    for event in array_at(full, "events"):
        placed = object_at(event, "placed") if isinstance(event, Mapping) else {}
        kept = {name: detail for name, detail in placed.items() if wanted(name)}
        if isinstance(event, Mapping) and (kept or not placed):
            yield {**event, "placed": kept} if placed else event


def are_alike(one: object, other: object, tolerance: float) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(are_alike(*pair, tolerance) for pair in zip(one, other, strict=True))
    if is_number(one) and is_number(other):
        return abs(one - other) <= ALIKE * tolerance
    return type(one) is type(other) and one == other


def object_at(holder: object, key: str) -> Object:
    value = holder.get(key, {}) if isinstance(holder, Mapping) else {}
    if not isinstance(value, Mapping):
        raise MalformedSnapshotError(f"{key!r} is not an object")
    return value


def array_at(holder: object, key: str) -> list[object]:
    value = holder.get(key, []) if isinstance(holder, Mapping) else []
    if not isinstance(value, list):
        raise MalformedSnapshotError(f"{key!r} is not an array")
    return value


# The snapshot of very many bricks, short enough to read: what those of a level have in common, and a mark of each.
#
# The mark of a brick is a hash of what has no tolerance: its name, when and where it is placed, how it is turned and
# made, which is compiled alike everywhere, and which bodies carry it. What a run finds out is locked in numbers, with
# their tolerances: shares and margins for as many bricks at a time as have them alike, once for all levels where most
# agree; and where a brick ended only if that is not where it was placed.


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


# A golden file of very many bricks, against a run: whose marks agree, and what is locked of these, in full.


PAIR: Final = 2


def lengthened(short: Object, got: Object) -> tuple[list[GoldenDifference], Object, Object]:
    """The differences of what has no tolerance, and both documents in full, without the bricks that differ so.

    Of a brick whose mark agrees, what has no tolerance is that of `got`. Raises MalformedSnapshotError.
    """
    rows, kept = rows_of(got), object_at(short, "bricks")
    levels: defaultdict[str, list[Row]] = defaultdict(list)
    for row in rows.values():
        if row.name not in kept:
            levels[str(row.final.get("level"))].append(row)
    known: dict[str, tuple[Object, Object]] = {}  # the final row, and what was found when it was placed
    differences: list[GoldenDifference] = []
    locked, usual = object_at(short, LEVELS), object_at(short, USUAL)
    for name in dict.fromkeys([*locked, *levels]):
        level = _Level(name, object_at(locked, name), usual)
        numbers = level.numbers(levels[name])
        known |= level.known(levels[name], numbers)
        differences += level.differences(levels[name], numbers)
    ordinary = [row for row in rows.values() if row.name not in kept]
    if not differences and short.get(DIGEST) != digest_of(ordinary):
        told = "how bricks are placed, and on what"
        differences.append(GoldenDifference("structure", told, "another digest", "that of this run", "exact"))
    expected = {
        **{key: value for key, value in short.items() if key not in (LEVELS, USUAL, DIGEST)},
        "events": [*array_at(short, "events"), *_expected_events(got, known)],
        "bricks": {**{name: final for name, (final, _) in known.items()}, **kept},
    }
    compared = known.keys() | kept.keys()
    bricks = {name: final for name, final in object_at(got, "bricks").items() if name in compared}
    return differences, expected, {**got, "events": [*events_with(got, compared.__contains__)], "bricks": bricks}


class _Level:
    """One level of a short document."""

    def __init__(self, level: str, locked: Object, usual: Object) -> None:
        self.level, self.locked, self.usual = level, locked, usual
        if not locked.keys() <= set(LEVEL_KEYS):
            raise MalformedSnapshotError(f"level {level} has an unknown key {min(locked.keys() - set(LEVEL_KEYS))!r}")
        marks = locked.get("marks", "")
        if not isinstance(marks, str) or len(marks) != MARK * self.count:
            raise MalformedSnapshotError(f"the marks of level {level} are not {MARK} characters a brick")
        self.marks = [marks[MARK * number : MARK * (number + 1)] for number in range(self.count)]

    @property
    def count(self) -> int:
        """How many bricks are locked; -1 where the file does not say."""
        count = self.locked.get("bricks", 0)
        return count if isinstance(count, int) and not isinstance(count, bool) else -1

    def numbers(self, rows: Sequence[Row]) -> dict[str, int]:
        """Which of the bricks that are locked each is, by its mark; in order, where some have the same."""
        left: defaultdict[str, list[int]] = defaultdict(list)
        for number, mark in enumerate(self.marks):
            left[mark].append(number)
        return {row.name: left[row.mark].pop(0) for row in rows if left[row.mark]}

    def known(self, rows: Sequence[Row], numbers: Mapping[str, int]) -> dict[str, tuple[Object, Object]]:
        """What is locked of each brick whose mark agrees: its final row, and what was found as it was placed."""
        columns = [self._column(key) for key in COLUMNS]
        found: dict[str, tuple[Object, Object]] = {}
        for row in (row for row in rows if row.name in numbers):
            margin, placed_on, end, rests_on = (column[numbers[row.name]] for column in columns)
            state, stayed = end if isinstance(end, list) and len(end) == PAIR else (end, True)
            final = {"level": row.final.get("level"), "state": state, **_named(row.final, rests_on)}
            final |= {"at_mm": row.placed.get("at_mm")} if stayed is True else {}
            found[row.name] = final, {"margin_mm": margin, **_named(row.placed, placed_on)}
        return found

    def differences(self, rows: Sequence[Row], numbers: Mapping[str, int]) -> Iterator[GoldenDifference]:
        """How many bricks there are, if that differs, and those whose marks do not agree."""
        if len(rows) != self.count:
            yield GoldenDifference(f"level {self.level}", "bricks", str(self.count), str(len(rows)), tolerance="exact")
        for row in (row for row in rows if row.name not in numbers):
            at = ", ".join(map(str, array_at(row.placed, "at_mm")))
            now = f"mark {row.mark}, placed at ({at}) mm" if row.placed else "not placed"
            yield GoldenDifference(row.name, "how it is placed, and on what", "another mark", now, tolerance="exact")

    def _column(self, key: str) -> list[object]:
        """What is locked of each brick, from runs of such as are alike."""
        runs = array_at(self.locked, key) if key in self.locked else [[self.count, self.usual.get(key)]]
        pairs = [run for run in runs if isinstance(run, list) and len(run) == PAIR and isinstance(run[0], int)]
        if len(pairs) < len(runs) or min((run[0] for run in pairs), default=0) < 0:
            raise MalformedSnapshotError(f"{key!r} of level {self.level} is not a list of pairs")
        if sum(run[0] for run in pairs) != self.count:
            raise MalformedSnapshotError(f"{key!r} of level {self.level} does not speak of {self.count} bricks")
        return list(chain.from_iterable([run[1]] * run[0] for run in pairs))


def _expected_events(got: Object, known: Mapping[str, tuple[Object, Object]]) -> Iterator[Object]:
    """The placings of a run, with what is locked of those bricks."""
    for event in array_at(got, "events"):
        placed = object_at(event, "placed")
        bricks = {name: _expected_placing(object_at(placed, name), known[name][1]) for name in placed if name in known}
        if bricks and isinstance(event, Mapping):
            margin = known[next(iter(bricks))][1]["margin_mm"]
            rest = {key: value for key, value in event.items() if key != "margin_mm"}
            yield {**rest, **({} if margin is None else {"margin_mm": margin}), "placed": bricks}


def _expected_placing(got: Object, found: Object) -> Object:
    decided = {key: value for key, value in got.items() if key != "rests_on"}
    return {**decided, **{key: value for key, value in found.items() if key == "rests_on"}}


def _named(holder: Object, shares: object) -> dict[str, object]:
    """Shares with the names of the carriers, which the mark says are the same."""
    if not isinstance(shares, list):
        return {}
    return {"rests_on": dict(zip(object_at(holder, "rests_on"), shares, strict=False))}
