"""A golden file of very many bricks, against a run: whose marks agree, and what is locked of these, in full."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Final

from stackdsl.outcome import GoldenDifference
from stackdsl.snapshots.compact import COLUMNS, DIGEST, LEVEL_KEYS, LEVELS, USUAL, digest_of
from stackdsl.snapshots.record import MalformedSnapshotError
from stackdsl.snapshots.rows import MARK, Object, Row, array_at, events_with, object_at, rows_of

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
