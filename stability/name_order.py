"""Natural order of names, where L2.1 comes before L10.1, and lists of names with ranges."""

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise, zip_longest
from typing import Final

from stability.model import BodyId

_NUMBER = re.compile(r"(\d+)")
_PLACE = re.compile(r"(.*)L\d+\.\d+")  # name of a brick: group, level, place
_COUNTED = re.compile(r"(.*?\D)(\d+)")  # other name that ends in a number
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


def names_text(names: Sequence[str], least: int = 2, among: Iterable[str] = ()) -> str:
    """Format names on one line: `a, b, c, d, e, f and 3 more`, and runs of bricks as ranges: `L4.1 to L5.3 (6 bricks)`.

    A range stands for all bricks of the assembly `among` from its first to its last. Without an assembly, it stays on
    one level, since names alone do not tell how many bricks a level has. At least `least` names are left out, or none.
    """
    runs = _runs(names, in_order(set(among)) if len(names) >= SHORTEST else [])
    items = [(_range_text(run, alone=len(runs) == 1), len(run)) for run in runs]
    left_out = sum(count for _, count in items[MOST_NAMES:])
    shown = items[:MOST_NAMES] if left_out >= least else items
    return ", ".join(item for item, _ in shown) + (f" and {left_out} more" if len(shown) < len(items) else "")


def _range_text(run: Sequence[str], *, alone: bool) -> str:
    """Format a run; its number of bricks is told where a reader cannot count them from the names."""
    if len(run) == 1:
        return run[0]
    in_turn = all(_next_name(name) == after for name, after in pairwise(run))
    return f"{run[0]} to {run[-1]}" + (f" ({len(run)} bricks)" if alone or not in_turn else "")


def _runs(names: Sequence[str], assembly: Sequence[str]) -> list[list[str]]:
    """Split names into runs of bricks that follow each other; runs too short for a range become single names."""
    after = dict(pairwise(assembly))
    runs: list[list[str]] = []
    for name in names:
        last = runs[-1][-1] if runs else ""
        if _group(name) is not None and _group(name) == _group(last) and name in (after.get(last), _next_name(last)):
            runs[-1].append(name)
        else:
            runs.append([name])
    return [part for run in runs for part in ([run] if len(run) >= SHORTEST else [[name] for name in run])]


def _group(name: str) -> str | None:
    """Return what the names of a range have in common: `east.` of `east.L2.1`, `C` of `C007`; None without a number."""
    if place := _PLACE.fullmatch(name):
        return f"{place[1]}L."
    counted = _COUNTED.fullmatch(name)
    return counted[1] if counted else None


def _next_name(name: str) -> str:
    """Return the next name of a level, or else of a count: `L2.2` after `L2.1`, `C010` after `C009`."""
    counted = _COUNTED.fullmatch(name)
    return f"{counted[1]}{int(counted[2]) + 1:0{len(counted[2])}}" if counted else ""
