"""Verifies verdicts and load factors of random joined assemblies by independent linear programs.

Boxes of a random lattice are set on, under and beside one another, and joined by studs, bonds or magnets, or by several
of these mixed with dry contacts. The strength of all joints is scaled so that the load factor, by the program, is close
to 1; half of the cases are within 3 %. A verdict is contradicted if the linear program on the other side of the
circles of friction disagrees, and a load factor if it is outside both bounds. Run it with `python -m
benchmarks.joined`; twenty minutes.
"""

import random
import sys
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import inf
from statistics import median
from time import process_time
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress

from benchmarks.equilibrium_programs import UprightBox
from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.joined_programs import Strength, load_factors
from stability.analysis.load_factor import load_factor
from stability.geometry.box import Box
from stability.joints import Bond, Joint, JointRule, Joints, Pull, Studs
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

UNIT = (0.008, 0.008, 0.0096)  # [m] of the lattice
FRICTION = 0.5
KINDS = ("studs", "bond", "pull", "mixed")
ROUNDING = 1e-6  # of the linear programs
BATCH = 50  # seeds that are judged before the next ones
SIZES = ((1, 1, 1), (2, 1, 1), (1, 2, 1), (2, 2, 1), (3, 2, 1), (2, 3, 1), (4, 2, 1), (2, 4, 1), (1, 1, 2), (2, 1, 2))
Cells = tuple[tuple[int, int, int], tuple[int, int, int]]  # lowest corner and size, in units of the lattice


@dataclass(frozen=True)
class Case:
    """Boxes in two groups, and the joints within and between the groups; None for a dry contact."""

    boxes: Sequence[UprightBox]
    groups: Sequence[int]
    joints: dict[tuple[int, int], Strength | None]  # by groups in rising order; the ground belongs to group 0

    def joint_of(self, one: int | None, other: int | None) -> Strength | None:
        """Return the joint of two boxes by number; None is the ground."""
        a, b = sorted(0 if each is None else self.groups[each] for each in (one, other))
        return self.joints[a, b]

    def times(self, factor: float) -> "Case":
        """Return the case with all strengths multiplied."""
        joints = {pair: None if each is None else each.times(factor) for pair, each in self.joints.items()}
        return Case(self.boxes, self.groups, joints)


def drawn(draw: random.Random, kind: str, count: int) -> Case:
    """Return a random case with strengths of one brick's weight."""
    placed: list[Cells] = [((0, 0, 0), draw.choice(SIZES))]
    while len(placed) < count:
        at, size = draw.choice(placed)
        new = draw.choice(SIZES)
        side = draw.choice(("top", "top", "top", "bottom", "beside"))
        place = [at[axis] + draw.randint(1 - new[axis], size[axis] - 1) for axis in range(3)]
        if side == "top":
            place[2] = at[2] + size[2]
        elif side == "bottom":
            place[2] = at[2] - new[2]
        else:
            axis = draw.choice((0, 1))
            place[axis] = draw.choice((at[axis] + size[axis], at[axis] - new[axis]))
        cells = (place[0], place[1], place[2]), new
        if place[2] >= 0 and not any(_overlap(cells, other) for other in placed):
            placed.append(cells)
    boxes = [_box(cells, draw.uniform(0.5, 2.0)) for cells in placed]
    groups = [draw.randint(0, 1) if kind == "mixed" else 0 for _ in placed]
    weight = sum(box.mass for box in boxes) * 9.81 / len(boxes)
    face = UNIT[0] * UNIT[1]

    def one(kind: str) -> Strength | None:
        match kind:
            case "studs":
                return Strength("studs", (UNIT[0], weight, draw.choice((0.5, 1.0, 5.0)) * weight))
            case "bond":
                tension = weight / face
                return Strength(
                    "bond", (tension, draw.choice((0.3, 1.0, 3.0)) * tension, draw.choice((inf, inf, 2.0 * tension)))
                )
            case "pull":
                return Strength("pull", (0.25 * weight,))
            case _:
                return None

    if kind != "mixed":
        return Case(boxes, groups, dict.fromkeys(((0, 0), (0, 1), (1, 1)), one(kind)))
    drawn_kinds = [draw.choice(("studs", "bond", "pull", "dry")) for _ in range(3)]
    return Case(
        boxes, groups, {pair: one(each) for pair, each in zip(((0, 0), (0, 1), (1, 1)), drawn_kinds, strict=True)}
    )


def _overlap(one: Cells, other: Cells) -> bool:
    (a, size_a), (b, size_b) = one, other
    return all(a[axis] < b[axis] + size_b[axis] and b[axis] < a[axis] + size_a[axis] for axis in range(3))


def _box(cells: Cells, density: float) -> UprightBox:
    at, size = cells
    x, y, z = (UNIT[axis] * (at[axis] + 0.5 * size[axis]) for axis in range(3))
    length, width, height = (UNIT[axis] * size[axis] for axis in range(3))
    return UprightBox((x, y, z), (length, width, height), 0.001 * density * size[0] * size[1] * size[2])


def assembly_of(case: Case) -> tuple[Assembly, list[Placed]]:
    """Return an empty assembly with the joints of a case, and its bricks."""
    names = [f"b{number:02}" for number in range(len(case.boxes))]
    members = [
        {*(name for name, group in zip(names, case.groups, strict=True) if group == own), *((GROUND,) * (own == 0))}
        for own in (0, 1)
    ]
    rules = tuple(
        JointRule(_joint(strength), (members[one], members[other]))
        for (one, other), strength in case.joints.items()
        if strength is not None
    )
    planes = (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),)
    bricks = [
        Placed(Brick(name, Box(box.size), box.mass), Pose(box.middle))
        for name, box in zip(names, case.boxes, strict=True)
    ]
    return Assembly(planes, FRICTION, joints=Joints(rules)), bricks


def _joint(strength: Strength) -> Joint:
    match strength.kind:
        case "studs":
            return Studs(*strength.numbers)
        case "pull":
            return Pull(*strength.numbers)
        case _:
            tension, cohesion, shear = strength.numbers
            return Bond(tension, cohesion, shear)


@dataclass(frozen=True)
class Judged:
    """Verdict and load factor of a random case, compared with programs written apart."""

    bricks: int
    verdict: Stability
    contradicted: bool
    factor_outside: bool
    factor_unproven: bool

    @property
    def noteworthy(self) -> bool:
        """True if the comparison shows an error, or if something is not proven."""
        undecided = self.verdict is Stability.UNDECIDED
        return undecided or self.contradicted or self.factor_outside or self.factor_unproven


@dataclass(frozen=True)
class Compared(Judged):
    """Comparison of one case."""

    kind: str
    open: bool  # the two programs disagree
    seconds: float  # of the verdict
    note: str


def compared(seed: int, most: int) -> Compared | None:
    """Compare one random case; None if no joint carries anything in it, or no linear program is solved."""
    draw = random.Random(seed)
    kind = KINDS[seed % len(KINDS)]
    case = drawn(draw, kind, draw.randint(2, most))
    try:
        low, high = load_factors(case.boxes, FRICTION, case.joint_of)
    except ArithmeticError:
        return None
    if inf in {low, high} or low < ROUNDING:
        return None
    near = draw.choice((0.03, 0.3))
    stronger = draw.uniform(1.0 - near, 1.0 + near) / (0.5 * (low + high))
    # Dry contacts are cones, so the load factor is proportional to the strength of all joints.
    case, low, high = case.times(stronger), stronger * low, stronger * high
    assembly, bricks = assembly_of(case)
    started = process_time()
    verdict = assembly.add_all(bricks)
    seconds = process_time() - started
    if verdict.stability is Stability.STABLE:
        assembly.forces()  # checks the sum of all proofs
    factor = load_factor(assembly.problem())
    outside = factor is not None and not (
        factor.factor <= high * (1.0 + ROUNDING) and factor.too_large >= low * (1.0 - ROUNDING)
    )
    contradicted = (verdict.stability is Stability.STABLE and high < 1.0 - ROUNDING) or (
        verdict.stability is Stability.UNSTABLE and low > 1.0 + ROUNDING
    )
    note = "" if verdict.stability is not Stability.UNDECIDED else f"{low:.7g} to {high:.7g}: {verdict.reason}"
    return Compared(
        len(bricks), verdict.stability, contradicted, outside, factor is None, kind, low < 1.0 < high, seconds, note
    )


def _row(cases: Sequence[Compared]) -> Row:
    verdicts = Counter(case.verdict for case in cases)
    return {
        "cases": len(cases),
        "stable": verdicts[Stability.STABLE],
        "unstable": verdicts[Stability.UNSTABLE],
        "undecided": verdicts[Stability.UNDECIDED],
        "contradicted": sum(case.contradicted for case in cases),
        "open": sum(case.open for case in cases),
        "factors_outside": sum(case.factor_outside for case in cases),
        "factors_unproven": sum(case.factor_unproven for case in cases),
        "median_ms": 1e3 * median(case.seconds for case in cases) if cases else None,
        "worst_ms": 1e3 * max(case.seconds for case in cases) if cases else None,
    }


Found = TypeVar("Found", bound=Judged)


def arguments_of(doc: str | None, cases: int, bricks: int) -> ArgumentParser:
    """Return the arguments of a benchmark on random cases."""
    arguments = parser(doc)
    arguments.add_argument("--cases", type=int, default=cases)
    arguments.add_argument("--bricks", type=int, default=bricks, help="the most of one case")
    arguments.add_argument("--seed", type=int, default=0, help="of the first case")
    arguments.add_argument("--processes", type=int, default=2)
    return arguments


def random_cases(compare: Callable[[int], Found | None], chosen: Namespace, console: Console) -> list[Found]:
    """Compare cases of successive seeds, without those that are None, and print the noteworthy ones."""
    cases: list[Found] = []
    with ProcessPoolExecutor(chosen.processes) as pool, Progress(console=console) as progress:
        told = progress.add_task("random cases", total=chosen.cases)
        for first in count(chosen.seed, BATCH):
            seeds = range(first, first + BATCH)
            for seed, found in zip(seeds, pool.map(compare, seeds), strict=True):
                if found is None or len(cases) == chosen.cases:
                    continue
                if found.noteworthy:
                    console.print(f"seed {seed}", found)
                cases.append(found)
                progress.advance(told)
            if len(cases) == chosen.cases:
                break
    return cases


def main() -> None:
    """Compare random cases and print the table; write it on request."""
    chosen = arguments_of(__doc__, cases=2000, bricks=12).parse_args()
    console = Console(stderr=True)
    cases = random_cases(partial(compared, most=chosen.bricks), chosen, console)
    by_kind = {kind: [case for case in cases if case.kind == kind] for kind in KINDS} | {"all": cases}
    table: Rows = {kind: _row(each) for kind, each in by_kind.items()}
    console.print(table)
    if chosen.write:
        record("joined", " ".join(["python -m benchmarks.joined", *sys.argv[1:]]), {"joined": table})


if __name__ == "__main__":
    main()
