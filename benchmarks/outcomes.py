"""Measures how often rest is decided to be unique for structures that need friction, at what cost, and how reliably.

Run it with `python -m benchmarks.outcomes`. The groups are random boxes that stand only by friction, and piles on a
slope of half their friction. An enumeration of all contact modes in the plane shows any contradiction.
"""

from collections.abc import Callable, Iterable, Mapping
from random import Random
from statistics import median
from time import process_time
from typing import Final

from rich.console import Console

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.analysis.uniqueness import outcome
from stability.statics.assembly import Assembly
from tests.stability.analysis.leaning_scenes import pile_on_a_slope
from tests.stability.analysis.planar_modes import starts
from tests.stability.analysis.random_leaning import on_each_other, on_planes, that_need_friction

SEED: Final = 16
GROUPS: Final[Mapping[str, Callable[[], Iterable[Assembly]]]] = {
    "a box on one to three planes": lambda: that_need_friction(Random(SEED), on_planes, 300),
    "two boxes on each other and on planes": lambda: that_need_friction(Random(SEED), on_each_other, 40, 5),
    "two in a pile on a slope": lambda: [pile_on_a_slope(2, 10.0, 0.35)],
    "three in a pile on a slope": lambda: [pile_on_a_slope(3, 10.0, 0.35)],
    "five in a pile on a slope": lambda: [pile_on_a_slope(5, 10.0, 0.35)],
}
MOST_BRICKS: Final = 2  # largest group whose modes in the plane are enumerated


def main() -> None:
    """Decide and print the rows; write them on request."""
    write = parser(__doc__).parse_args().write
    outcome(pile_on_a_slope(1, 10.0, 0.35).problem())  # so that imports and caches count for no row
    rows = {name: _row(groups()) for name, groups in GROUPS.items()}
    for name, row in rows.items():
        Console().print(name, row)
    if write:
        record("outcomes", "python -m benchmarks.outcomes --write", {"groups": rows})


def _row(groups: Iterable[Assembly]) -> Row:
    rests = lets_go = undecided = contradicted = 0
    times = []
    for assembly in groups:
        problem, forces = assembly.problem(), assembly.forces()
        began = process_time()
        found = outcome(problem, forces)
        times.append(1000.0 * (process_time() - began))
        rests += found.guaranteed
        lets_go += found.start is not None
        undecided += bool(found.undecided)
        if found.guaranteed and len(problem.bricks) <= MOST_BRICKS:
            contradicted += any(starts(problem))
    return {
        "groups": len(times),
        "rests": rests,
        "lets_go": lets_go,
        "undecided": undecided,
        "contradicted": contradicted,
        "median_ms": median(times),
        "worst_ms": max(times),
    }


if __name__ == "__main__":
    main()
