"""Pulls from towers, and shifts that mend random piles, against linear programmes that are written apart from both.

Jenga towers of 18 levels, whole and thinned out, blocks side by side and with gaps: every single pull, with how long
one takes. 100 random piles of boxes that fall: what mends each, that it stands by a linear programme, and that with
0.1 % less it falls by one. Run it with `python -m benchmarks.mending`; some minutes.
"""

import random
import sys
from collections.abc import Iterator, Sequence
from statistics import median
from time import process_time

from rich.console import Console
from rich.progress import track

from benchmarks.equilibrium_programs import UprightBox, answer
from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from stability.model import Brick, Pose
from stability.shapes.box import Box
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stability.statics.facts import Placed, Stability
from stability.statics.mending.piling import Piling, Shift
from stability.statics.mending.shifts import Shifting
from stability.statics.orders.building import least_props
from stability.statics.orders.parts import Parts
from stability.statics.orders.props import props_of
from stability.statics.orders.pulls import carrying, longest_order, single_pulls, soonest_fall

BLOCK = (0.075, 0.025, 0.015)  # [m]
FRICTION = 0.5
GAP = 0.001  # [m] between blocks side by side
LESS = 0.999  # of a shift that mends


def jenga(levels: int, gap: float = 0.0) -> list[Placed]:
    """A tower of three blocks a level, each level across the one below."""
    length, width, thickness = BLOCK
    found = []
    for level in range(levels):
        for number in range(3):
            aside, height = (number - 1) * width, (level + 0.5) * thickness
            size = (length, width - gap, thickness) if level % 2 == 0 else (width - gap, length, thickness)
            at = (0.0, aside, height) if level % 2 == 0 else (aside, 0.0, height)
            found.append(Placed(Brick(f"L{level + 1}.{number + 1}", Box(size), 0.02), Pose(at)))
    return found


def thinned(levels: int, seed: int) -> Assembly:
    """A tower with gaps, less a third of its blocks, each pulled while the rest stood."""
    draw = random.Random(seed)
    design = Assembly()
    design.add_all(jenga(levels, GAP))
    names = sorted(carrying(design))
    draw.shuffle(names)
    for name in names[: len(names) // 2]:
        tried = design.copied()
        if tried.remove([name]).stability is Stability.STABLE:
            design = tried
    return design


def pulls(design: Assembly) -> dict[str, float | int]:
    """Every single pull of a tower, and how many are as a linear programme has them."""
    started = process_time()
    found = list(single_pulls(design))
    spent = process_time() - started
    wrong = open_ = 0
    for pull in found:
        rest = [upright(placed) for name, placed in design.bricks.items() if name != pull.brick]
        truth = answer(rest, FRICTION)
        open_ += truth is None
        said = pull.verdict.stability
        wrong += truth is not None and said is not (Stability.STABLE if truth else Stability.UNSTABLE)
    stands = sum(pull.verdict.stability is Stability.STABLE for pull in found)
    falls = sum(pull.verdict.stability is Stability.UNSTABLE for pull in found)
    parts = Parts(design)
    may_go = parts.part_of(carrying(design))
    started = process_time()
    longest, soonest = longest_order(parts, may_go, 5000), soonest_fall(parts, may_go, 5000)
    return {
        "pulls": len(found),
        "stand": stands,
        "fall": falls,
        "wrong": wrong,
        "not_said": open_,
        "pull_ms": 1e3 * spent / len(found),
        "longest": len(longest.order),
        "at_most": longest.at_most,
        "soonest": len(soonest.order),
        "orders_s": process_time() - started,
    }


def upright(placed: Placed) -> UprightBox:
    """The same for the linear programme."""
    assert isinstance(placed.brick.shape, Box)
    return UprightBox(placed.pose.position_W, placed.brick.shape.size, placed.brick.mass)


def piles(seed: int) -> Iterator[Piling]:
    """Random piles that fall: each box on one that is there, far out, and inside of none."""
    draw = random.Random(seed)
    while True:
        boxes: list[Placed] = []
        while len(boxes) < draw.randint(3, 9):
            size = (draw.uniform(0.05, 0.2), draw.uniform(0.05, 0.2), draw.uniform(0.02, 0.08))
            below = draw.choice(boxes) if boxes and draw.random() < 0.9 else None  # noqa: PLR2004 -- most lie on others
            x, y, top = draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 0.0
            if below is not None:
                (bx, by, bz), shape = below.pose.position_W, below.brick.shape
                assert isinstance(shape, Box)
                x, y = bx + draw.uniform(-0.6, 0.6) * shape.size[0], by + draw.uniform(-0.6, 0.6) * shape.size[1]
                top = bz + 0.5 * shape.size[2]
            mass = 600.0 * size[0] * size[1] * size[2]
            one = Placed(Brick(f"b{len(boxes)}", Box(size), mass), Pose((x, y, top + 0.5 * size[2])))
            if not any(_overlap(one, other) for other in boxes):
                boxes.append(one)
        piling = Piling((LEVEL_GROUND,), FRICTION, 9.81, [[box] for box in boxes])
        fall = piling.first_fall()
        if fall is not None and fall[1].stability is Stability.UNSTABLE:
            yield piling


def _overlap(one: Placed, other: Placed) -> bool:
    a, b = upright(one), upright(other)
    sides = zip(a.middle, b.middle, a.size, b.size, strict=True)
    return all(abs(m - n) < 0.5 * (s + t) - 1e-9 for m, n, s, t in sides)


def mended(piling: Piling) -> dict[str, float | int | str]:
    """What mends one pile, and whether a linear programme agrees with it and with a little less."""
    started = process_time()
    shifting = Shifting(piling)
    fall = piling.first_fall()
    assert fall is not None
    found = [one for brick in shifting.candidates(fall[1]) if (one := shifting.least(brick, {})) is not None]
    best = min(found, key=lambda each: each.length, default=None)
    shifts: dict[str, Shift] = {}
    if best is not None:
        how, shifts = "one shift", {best.brick: best.shift}
        share = best.too_little / best.length
    else:
        several = shifting.several()
        if several is not None:
            how, shifts, share = "several shifts", dict(several.shifts), several.too_little
        else:
            whole = piling.assembly()
            whole.add_all([placed for stage in piling.stages for placed in stage], names_smallest=False)
            parts = Parts(whole, props_of(whole))
            states = [
                parts.part_of(p.brick.id for stage in piling.stages[: n + 1] for p in stage)
                for n in range(len(piling.stages))
            ]
            props = least_props(parts, states)
            spent = process_time() - started
            how = "nothing" if props is None else "props"
            return {"how": how, "stands": props is not None, "falls": 0, "s": spent, "asked": shifting.asked}
    spent = process_time() - started
    stands = all(one is True for one in _stages(piling, shifting, shifts, 1.0))
    less = any(one is False for one in _stages(piling, shifting, shifts, LESS * share))
    return {"how": how, "stands": stands, "falls": less, "s": spent, "asked": shifting.asked}


def _stages(piling: Piling, shifting: Shifting, shifts: dict[str, Shift], share: float) -> Iterator[bool | None]:
    """What the linear programme says after each box that is set down."""
    boxes = _shifted(piling, shifting, shifts, share)
    return (answer(boxes[:count], FRICTION) for count in range(1, len(boxes) + 1))


def _shifted(piling: Piling, shifting: Shifting, shifts: dict[str, Shift], share: float) -> list[UprightBox]:
    sums: dict[str, Shift] = {}
    for brick, (x, y) in shifts.items():
        for name in shifting.carried[brick]:
            ox, oy = sums.get(name, (0.0, 0.0))
            sums[name] = ox + share * x, oy + share * y
    return [upright(placed) for stage in piling.shifted(sums).stages for placed in stage]


def main() -> None:
    """Pull, mend, print, and keep it if asked to."""
    arguments = parser(__doc__)
    arguments.add_argument("--piles", type=int, default=100)
    chosen = arguments.parse_args()
    whole, apart = Assembly(), Assembly()
    whole.add_all(jenga(18))
    apart.add_all(jenga(18, GAP))
    towers = {"18 levels, side by side": whole, "18 levels, with gaps": apart}
    towers |= {f"thinned out, seed {seed}": thinned(18, seed) for seed in range(3)}
    console = Console(stderr=True)
    of_towers: Rows = {name: pulls(tower) for name, tower in track(towers.items(), "towers", console=console)}
    drawn = piles(1)
    found = [mended(next(drawn)) for _ in track(range(chosen.piles), "piles", console=console)]
    hows = sorted({str(one["how"]) for one in found})
    kinds: dict[str, Row] = {how: _sums([one for one in found if one["how"] == how]) for how in hows}
    kinds["all"] = _sums(found)
    console.print(of_towers, kinds)
    if chosen.write:
        record(
            "mending", " ".join(["python -m benchmarks.mending", *sys.argv[1:]]), {"pulls": of_towers, "piles": kinds}
        )


def _sums(found: Sequence[dict[str, float | int | str]]) -> dict[str, float | int]:
    return {
        "piles": len(found),
        "stand": sum(int(one["stands"]) for one in found),
        "fall_with_less": sum(int(one["falls"]) for one in found),
        "median_s": median(float(one["s"]) for one in found),
        "worst_s": max(float(one["s"]) for one in found),
        "verdicts": sum(int(one["asked"]) for one in found),
    }


if __name__ == "__main__":
    main()
