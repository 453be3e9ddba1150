"""Times verdicts and load factors of random structures of up to 200 studded bricks, and verifies them.

LEGO bricks of 1x1 to 2x8 of the catalogue are set on and under one another at random, with any overhang, on a base
plate. The strength of all studs is multiplied so that the load factor, by a linear program written apart, is close to
1: within 3 % for half of the structures, within 30 % for the others. Beside it stands the published score of StableLego
(`studded_programs`), whose capacity of a point is multiplied alike, and a linear program for the load factor of its own
points. A time is that of one verdict, with its proof, from the bricks on; that of the score is for a matrix that is
assembled, and a free solver, in the same run. Run it with `python -m benchmarks.studded`; half an hour.
"""

import random
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from statistics import median
from time import process_time

from rich.console import Console

from benchmarks.equilibrium_programs import UprightBox
from benchmarks.figures.data import Row
from benchmarks.figures.recording import record
from benchmarks.joined import Judged, arguments_of, random_cases
from benchmarks.studded_programs import PITCH, StudStrength, capacity_factor, load_factors, scored
from stability.analysis.load_factor import load_factor
from stability.geometry.box import Box
from stability.joints import JointRule, Joints, Studs
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.language.joints import LEGO_STUDS
from stackdsl.language.lego import LEGO, PLATES

FRICTION = 0.5
ROUNDING = 1e-6  # of the linear programs
CAPACITY = 0.98  # [N] of a point in the published score
FROM_ABOVE = 0.7  # share of bricks that are set on others rather than under them
SIZES = {
    "1 to 50": range(51),
    "51 to 100": range(51, 101),
    "101 to 150": range(101, 151),
    "151 to 200": range(151, 201),
}
LEGO_STRENGTH = StudStrength(LEGO_STUDS.pull, LEGO_STUDS.narrow_pull or LEGO_STUDS.pull, LEGO_STUDS.shear)
PARTS = tuple(part for part in LEGO.values() if part.plates == PLATES)


def drawn(draw: random.Random, count: int) -> list[UprightBox]:
    """Return bricks that are connected by their studs; the first one is on the base plate."""
    taken: set[tuple[int, int, int]] = set()
    placed: list[tuple[tuple[int, int, int], tuple[int, int]]] = []
    boxes: list[UprightBox] = []
    while len(boxes) < count:
        part = draw.choice(PARTS)
        studs = part.studs if draw.random() < 0.5 else part.studs[::-1]  # noqa: PLR2004 -- a half
        at = (0, 0, 0)
        if placed:
            (x, y, z), size = draw.choice(placed)
            z += 1 if draw.random() < FROM_ABOVE else -1
            at = (x + draw.randint(1 - studs[0], size[0] - 1), y + draw.randint(1 - studs[1], size[1] - 1), z)
        cells = {(at[0] + i, at[1] + j, at[2]) for i in range(studs[0]) for j in range(studs[1])}
        if at[2] < 0 or cells & taken:
            continue
        taken |= cells
        placed.append((at, studs))
        height = part.size[2]
        middle = (PITCH * (at[0] + 0.5 * studs[0]), PITCH * (at[1] + 0.5 * studs[1]), height * (at[2] + 0.5))
        boxes.append(UprightBox(middle, (PITCH * studs[0], PITCH * studs[1], height), float(part.mass)))
    return boxes


def assembly_of(boxes: Sequence[UprightBox], strength: StudStrength) -> tuple[Assembly, list[Placed]]:
    """Return an empty assembly with studs of this strength, and its bricks."""
    bricks = [
        Placed(Brick(f"b{number:03}", Box(box.size), box.mass), Pose(box.middle)) for number, box in enumerate(boxes)
    ]
    names = {placed.brick.id for placed in bricks} | {GROUND}
    studs = Studs(PITCH, strength.pull, strength.shear, strength.narrow_pull)
    planes = (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),)
    return Assembly(planes, FRICTION, joints=Joints((JointRule(studs, (names, names)),))), bricks


@dataclass(frozen=True)
class Compared(Judged):
    """Comparison of one structure."""

    verdict_ms: float
    factor_ms: float
    score_agrees: bool  # with the verdict
    score_wrong: bool  # by the load factor of its own points
    score_ms: float


def compared(seed: int, most: int) -> Compared | None:
    """Compare one random structure; None if it stands without studs."""
    draw = random.Random(seed)
    boxes = drawn(draw, draw.randint(2, most))
    low, high = load_factors(boxes, LEGO_STRENGTH)
    if high == inf:
        return None
    near = draw.choice((0.03, 0.3))
    stronger = draw.uniform(1.0 - near, 1.0 + near) / (0.5 * (low + high))
    low, high = stronger * low, stronger * high
    assembly, bricks = assembly_of(boxes, LEGO_STRENGTH.times(stronger))
    started = process_time()
    verdict = assembly.add_all(bricks)
    judged = process_time()
    if verdict.stability is Stability.STABLE:
        assembly.forces()  # checks the sum of all proofs
    problem = assembly.problem()
    asked = process_time()
    factor = load_factor(problem)
    found = process_time()
    stable = scored(boxes, stronger * CAPACITY)
    done = process_time()
    own = capacity_factor(boxes, stronger * CAPACITY)
    return Compared(
        len(boxes),
        verdict.stability,
        (verdict.stability is Stability.STABLE and high < 1.0 - ROUNDING)
        or (verdict.stability is Stability.UNSTABLE and low > 1.0 + ROUNDING),
        factor is not None
        and not (factor.factor <= high * (1.0 + ROUNDING) and factor.too_large >= low * (1.0 - ROUNDING)),
        factor is None,
        1e3 * (judged - started),
        1e3 * (found - asked),
        stable == (verdict.stability is Stability.STABLE),
        stable != (own > 1.0),
        1e3 * (done - found),
    )


def _row(cases: Sequence[Compared]) -> Row:
    verdicts = [case.verdict for case in cases]
    times = {name: [getattr(case, name) for case in cases] for name in ("verdict_ms", "factor_ms", "score_ms")}
    return {
        "cases": len(cases),
        "stable": verdicts.count(Stability.STABLE),
        "unstable": verdicts.count(Stability.UNSTABLE),
        "undecided": verdicts.count(Stability.UNDECIDED),
        "contradicted": sum(case.contradicted for case in cases),
        "factors_outside": sum(case.factor_outside for case in cases),
        "factors_unproven": sum(case.factor_unproven for case in cases),
        "score_differs": sum(not case.score_agrees for case in cases),
        "score_wrong": sum(case.score_wrong for case in cases),
        **{f"median_{name}": median(each) for name, each in times.items() if cases},
        **{f"worst_{name}": max(each) for name, each in times.items() if cases},
    }


def main() -> None:
    """Compare random structures and print the table; write it on request."""
    chosen = arguments_of(__doc__, cases=1000, bricks=200).parse_args()
    console = Console(stderr=True)
    cases = random_cases(partial(compared, most=chosen.bricks), chosen, console)
    by_size = {name: [case for case in cases if case.bricks in sizes] for name, sizes in SIZES.items()}
    table = {name: _row(each) for name, each in (by_size | {"all": cases}).items() if each}
    console.print(table)
    if chosen.write:
        record("studded", " ".join(["python -m benchmarks.studded", *sys.argv[1:]]), {"studded": table})


if __name__ == "__main__":
    main()
