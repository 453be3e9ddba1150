"""Counts how often two readings of the published equations give different verdicts, on piers and under hits.

The text does not define the point of application of each share of a load on more than two supports, the height at which
a passed load acts, and which moving bricks are "second impact objects" (`stability/stabilizers/published/support.py`).
Random planks on three to five piers are judged by the model and by statics, and a plank is thrown at the tower of 13
levels. Run it with `python -m benchmarks.readings_counted`; two minutes.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.capabilities import levels_standing
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability
from stability.stabilizers.published.support import AS_READ, ActsAt, Readings, SecondObjects
from stability.statics.assembly import Assembly
from stackdsl.checking.cases import Case, gather
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import EventKind, Trace
from tests.stability.statics.published_model import published_model_says_stable
from tests.stability.statics.random_piles import DENSITY, FRICTION, KAPLA

SCENARIOS = Path(__file__).parent.parent / "scenarios" / "capabilities"
SAMPLES, SEED = 1000, 30
ACROSS = (0.0, 0.0, sqrt(0.5), sqrt(0.5))  # a rotation by 90 degrees about z
ON_PIERS: Mapping[str, Readings] = {
    "each part acts at com above, as `thesis` reads it": AS_READ,
    "each part acts at its contact": Readings(equal_acts_at=ActsAt.CONTACT),
}
OF_HITS: Mapping[str, Readings] = {
    "as `thesis` reads it": AS_READ,
    "equivalent mass at the height of its contact": Readings(height_acts_at=ActsAt.CONTACT),
    "every moving brick can hit": Readings(second_objects=SecondObjects.NONE),
}


def main() -> None:
    """Judge and play, and print the tables; write them on request."""
    write = parser(__doc__).parse_args().write
    console = Console(stderr=True)
    piles = [on_piers(np.random.default_rng([SEED, number])) for number in range(SAMPLES)]
    stands = [Assembly(friction=FRICTION).add_all(pile).stability for pile in piles]
    piers = {name: judged(piles, stands, readings) for name, readings in ON_PIERS.items()}
    cases = thrown()
    hits = {
        name: {key: struck(case, readings) for key, case in cases.items()}
        for name, readings in track(OF_HITS.items(), "hits", console=console, transient=True)
    }
    for heading, rows in (("on three to five piers", piers), ("woken, and levels left whole", hits)):
        table = Table(heading, *next(iter(rows.values())))
        for name, values in rows.items():
            table.add_row(name, *map(str, values.values()))
        Console(width=160).print(table)
    if write:
        record("readings-counted", "python -m benchmarks.readings_counted --write", {"piers": piers, "hits": hits})


def on_piers(generator: np.random.Generator) -> tuple[Placed, ...]:
    """Return three to five piers side by side, and one to four planks on top.

    Each plank on top is offset by up to a fifth of a length.
    """
    length, width, thickness = KAPLA
    count = int(generator.integers(3, 6))
    while True:  # until piers do not overlap
        piers = np.sort(generator.uniform(-length / 2.0, length / 2.0, count))
        if min(np.diff(piers)) > width:
            break
    aside = np.cumsum(generator.uniform(-0.2, 0.2, int(generator.integers(1, 5)))) * length
    heights = (np.arange(len(aside)) + 1.5) * thickness
    return (
        *(plank(f"pier{number}", float(x), thickness / 2.0, ACROSS) for number, x in enumerate(piers)),
        *(
            plank(f"plank{number}", float(x), float(z))
            for number, (x, z) in enumerate(zip(aside, heights, strict=True))
        ),
    )


def plank(name: str, x: float, z: float, turned: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)) -> Placed:
    """Return a plank whose middle is above the x axis."""
    return Placed(Brick(name, Box(KAPLA), DENSITY * KAPLA[0] * KAPLA[1] * KAPLA[2]), Pose((x, 0.0, z), turned))


def judged(piles: list[tuple[Placed, ...]], stands: list[Stability], readings: Readings) -> Row:
    """The number of stacks for each pair of verdicts: of the published model, and of statics."""
    says = Counter(
        (published_model_says_stable(pile, readings), stability) for pile, stability in zip(piles, stands, strict=True)
    )
    return {
        "stacks": len(piles),
        "stand": sum(stability is Stability.STABLE for stability in stands),
        "stand_and_denied": says[False, Stability.STABLE],
        "fall_and_held": says[True, Stability.UNSTABLE],
    }


def thrown() -> dict[str, Case]:
    """Return the throws of the scenarios for the published method, by place and speed [m/s]."""
    cases = gather([SCENARIOS / f"impact-{where}.yaml" for where in ("level-3", "top")]).cases
    found = {}
    for case in cases:
        if case.system == "thesis" and not case.scenario.scenario.endswith("-slow"):
            where = "top" if "-top" in case.scenario.scenario else "level_3"
            (shot,) = (each for each in case.timeline.placements if each.brick.id == "shot")
            speed = max(map(abs, shot.velocity_W[:2]))
            found[f"{where}_{speed:.3g}"] = case
    return found


def struck(case: Case, readings: Readings) -> str:
    """Return the numbers of planks of the tower that wake, and of complete levels at the end."""
    trace = play(case.timeline, replace(SYSTEMS["thesis"], readings=readings))
    return f"{woken(trace)}, {levels_standing(trace)}"


def woken(trace: Trace) -> int:
    """The number of bricks that are woken at least once."""
    return len({name for event in trace.events if event.kind is EventKind.WOKEN for name in event.bricks})


if __name__ == "__main__":
    main()
