"""Compares the level at which slant towers fall by statics and by the published equations, for many spacings and steps.

The tower is a four-stack whose levels are each shifted by the same step along the planks of level 1, built one plank at
a time. Only towers that fall at level 8 to 10 by the published equations count, around the level that the publication
reports for its own tower. Run it with `python -m benchmarks.slant_towers`.
"""

from collections import Counter
from itertools import product
from math import pi

from rich.console import Console

from benchmarks.figures.recording import parser, record
from benchmarks.plank_structures import plank_at
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from tests.stability.statics.published_model import published_model_says_stable

FRICTION = 0.5
SPACINGS = range(70, 95, 4)  # [mm] between the two planks of a level
STEPS = tuple(0.5 * half for half in range(20, 33))  # [mm] shift of each level
LEVELS = 14
REPORTED = range(8, 11)  # levels


def slant_tower(spacing: float, step: float) -> list[Placed]:
    """Return the planks in the order of building; lengths in metres."""
    found = []
    for level, side in product(range(1, LEVELS + 1), (-0.5, 0.5)):
        along, across, turned = step * (level - 1), side * spacing, level % 2 == 0
        at = (along + across, 0.0) if turned else (along, across)
        found.append(plank_at(f"L{level}.{1 if side < 0.0 else 2}", at, level, 0.5 * pi if turned else 0.0))
    return found


def level_by_statics(tower: list[Placed]) -> int | None:
    """Return the level of the plank at which it falls."""
    assembly = Assembly(friction=FRICTION)
    for number, each in enumerate(tower):
        if assembly.add(each.brick, each.pose).stability is not Stability.STABLE:
            return number // 2 + 1
    return None


def level_as_published(tower: list[Placed]) -> int | None:
    """Return the same by the published equations, without an engine."""
    falls = (number for number in range(len(tower)) if not published_model_says_stable(tower[: number + 1]))
    return next((number // 2 + 1 for number in falls), None)


def main() -> None:
    """Count and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    later: Counter[int] = Counter()
    for spacing, step in product(SPACINGS, STEPS):
        tower = slant_tower(1e-3 * spacing, 1e-3 * step)
        published = level_as_published(tower)
        truth = level_by_statics(tower)
        if published is not None and published in REPORTED and truth is not None:
            later[published - truth] += 1
    rows = {
        "towers": {
            "asked": len(SPACINGS) * len(STEPS),
            "reported": later.total(),
            "same": later[0],
            "one_later": later[1],
            "others": later.total() - later[0] - later[1],
        }
    }
    Console().print(rows)
    if write:
        record("slant-towers", "python -m benchmarks.slant_towers --write", {"levels": rows})


if __name__ == "__main__":
    main()
