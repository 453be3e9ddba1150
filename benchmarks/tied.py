"""Verifies verdicts on random tied boxes by independent linear programs, with tensions that are unknown within bounds.

Boxes of a random lattice are set on, under and beside one another, tied by one or two loops, and pushed. A verdict is
contradicted if the linear program on the other side of the circles of friction disagrees, and a needed tension if it is
outside both bounds. Verdicts on the same boxes without their ties show that the check can fail. Run it with `python -m
benchmarks.tied`; a minute.
"""

import random
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from re import findall

from rich.console import Console
from rich.progress import track

from benchmarks.equilibrium_programs import UprightBox
from benchmarks.figures.recording import parser, record
from benchmarks.joined import drawn
from benchmarks.tied_programs import Loop, Tied, least_tension
from stability.geometry.box import Box
from stability.loads import Load, Loads
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from stability.ties import Tie, loop_around, pulls_of

CASES = 400
ROUNDING = 1e-4  # share of a needed tension that is told in four digits, and [N] of the programs
ALL = 0.7  # share of the ties that go around all boxes
NORMALS: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def tied_case(seed: int) -> Tied:
    """Return a random case."""
    draw = random.Random(seed)
    boxes = drawn(draw, "dry", draw.randint(2, 6)).boxes
    weight = sum(box.mass for box in boxes) * 9.81
    loops = [_loop(draw, boxes, weight) for _ in range(draw.choice((1, 1, 2)))]
    push = draw.choice((0.0, 0.1, 0.3)) * weight
    return Tied(boxes, loops, draw.choice((0.3, 0.6)), draw.randrange(len(boxes)), (push * draw.choice((-1, 1)), 0.0))


def _loop(draw: random.Random, boxes: Sequence[UprightBox], weight: float) -> Loop:
    axis = draw.randrange(3)
    first = draw.choice(boxes)
    offset = first.middle[axis] + draw.uniform(-0.45, 0.45) * first.size[axis]
    around = tuple(range(len(boxes))) if draw.random() < ALL else tuple(sorted(draw.sample(range(len(boxes)), 2)))
    tension = draw.choice((0.0, 0.2, 1.0, 3.0)) * weight
    return Loop(around, axis, offset, tension, tension + draw.choice((0.0, 0.5, 5.0)) * weight)


def verdict_on(case: Tied) -> Verdict:
    """Return the verdict of statics."""
    placed = [
        Placed(Brick(f"b{number}", Box(box.size), box.mass), Pose(box.middle)) for number, box in enumerate(case.boxes)
    ]
    ties = []
    for number, loop in enumerate(case.loops):
        around = [placed[index] for index in loop.around]
        cable = loop_around(around, NORMALS[loop.axis], loop.offset)
        names = frozenset(each.brick.id for each in around)
        ties.append(Tie(f"t{number}", names, pulls_of(cable, around), loop.tension, loop.strength))
    loads = Loads((Load(f"b{case.pushed}", (*case.push, 0.0)),))
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), case.friction)
    assembly = Assembly((ground,), case.friction, 9.81, loads=loads, ties=ties)
    return assembly.add_all(placed)


def contradictions(case: Tied, verdict: Verdict) -> Iterator[str]:
    """Yield what the linear programs disprove."""
    around, within = least_tension(case, inside=False), least_tension(case, inside=True)
    if verdict.stability is Stability.STABLE and around is None:
        yield "stable, but no forces balance it"
    if verdict.stability is Stability.UNSTABLE and within is not None:
        yield "unstable, but forces balance it"
    tightened = [float(each) for each in findall(r"tension of (\S+) N", verdict.reason)]
    if verdict.stability is Stability.UNDECIDED and tightened:
        if around is None:
            yield "it needs a larger tension, but none balances it"
        elif len(case.loops) == 1:
            more, slack = tightened[0] - case.loops[0].tension, ROUNDING * (1.0 + tightened[0])
            if more < around - slack or (within is not None and more > within + slack):
                yield f"it needs {more} N more, which is not between {around} and {within} N"


def main() -> None:
    """Judge all cases, and write what was found if asked to."""
    asked = parser(__doc__).parse_args()
    console = Console(stderr=True)
    found = Counter({"cases": CASES, "stable": 0, "unstable": 0, "undecided": 0, "contradicted": 0, "without_ties": 0})
    for seed in track(range(CASES), console=console):
        case = tied_case(seed)
        verdict = verdict_on(case)
        found[str(verdict.stability)] += 1
        wrong = list(contradictions(case, verdict))
        found["contradicted"] += bool(wrong)
        found["without_ties"] += any(contradictions(case, verdict_on(replace(case, loops=()))))
        for each in wrong:
            console.print(f"seed {seed}: {each}")
    console.print(dict(found))
    if asked.write:
        record("tied", "python -m benchmarks.tied --write", {"tied": {"all": dict(found)}})


if __name__ == "__main__":
    main()
