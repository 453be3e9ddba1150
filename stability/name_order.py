"""Natural order of names, where L2.1 comes before L10.1, and lists of names with ranges."""

import re
from collections.abc import Iterable, Sequence
from itertools import zip_longest
from typing import Final

from stability.model import BodyId

_NUMBER = re.compile(r"(\d+)")
_PLACE = re.compile(r"(.*)L(\d+)\.(\d+)")  # name of a brick by level and place
MOST_NAMES: Final = 6  # names or ranges written out in one list
SHORTEST = 3  # names of a range
NO_NUMBER = "-1"  # stands for a missing last number, so that a name comes before its continuations


def natural_key(name: BodyId) -> tuple[tuple[tuple[str, int], ...], str]:
    """Return the sort key of a name: pairs of letters and the following number, then the name itself."""
    parts = _NUMBER.split(name)  # letters and numbers alternate
    pairs = zip_longest(parts[::2], parts[1::2], fillvalue=NO_NUMBER)
    return tuple((letters, int(number)) for letters, number in pairs), name


def in_order(names: Iterable[BodyId]) -> list[BodyId]:
    """Sort names in natural order."""
    return sorted(names, key=natural_key)


def names_text(names: Sequence[str], least: int = 2) -> str:
    """Format names on one line: `a, b, c, d, e, f and 3 more`, and runs of bricks as ranges: `L4.1 to L5.3`.

    A range joins names that follow each other: the next place on a level, or the first place on the next level. The
    number of bricks shows whether a level has more bricks than the range. At least `least` names are left out, or none.
    """
    items: list[tuple[str, int]] = []  # text, number of names
    for run in _runs(names):
        if len(run) >= SHORTEST:
            items.append((f"{run[0]} to {run[-1]}", len(run)))
        else:
            items += [(name, 1) for name in run]
    left_out = sum(count for _, count in items[MOST_NAMES:])
    shown = items[:MOST_NAMES] if left_out >= least else items
    text = ", ".join(item for item, _ in shown) + (f" and {left_out} more" if len(shown) < len(items) else "")
    return f"{text} ({len(names)} bricks)" if any(count > 1 for _, count in shown) else text


def _runs(names: Sequence[str]) -> list[list[str]]:
    """Split names into runs of bricks that follow each other."""
    runs: list[list[str]] = []
    expected: set[tuple[str, int, int]] = set()
    for name in names:
        place = _PLACE.fullmatch(name)
        at = (place[1], int(place[2]), int(place[3])) if place else None
        if at is not None and at in expected:
            runs[-1].append(name)
        else:
            runs.append([name])
        expected = {(at[0], at[1], at[2] + 1), (at[0], at[1] + 1, 1)} if at is not None else set()
    return runs
