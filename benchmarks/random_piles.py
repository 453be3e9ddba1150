"""Random falling piles of boxes, and the verdicts of linear programs on all remedies of `stackdsl suggest` for them.

The programs are those of `benchmarks.equilibrium_programs`, independent of the statics that they verify. Each remedy is
tested at its full amount and at a slightly smaller one: shifts smaller by 0.1 %, additional weight and friction, which
are reported with three digits, by 2 %, and props without each of them in turn.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import process_time

from benchmarks.equilibrium_programs import UprightBox, answer, prop_contacts
from stability.analysis.piling import Piling, Shift
from stability.analysis.repair import BrickShift, Propping, SeveralShifts
from stability.geometry.box import Box
from stability.model import BodyId, Brick, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import LEVEL_GROUND
from stackdsl.checking.cases import cases_of
from stackdsl.judging.proofs import piling_of, proofs_of
from stackdsl.judging.remedies import FallingBuild, HeavierBrick, MoreFriction, StrongerJoints, Suggestion, suggestions
from stackdsl.language.yaml.source import parse

FRICTION = 0.5
LESS_SHIFT = 0.001
LESS = 0.02
SIDES = 128  # of the pyramids for remedies by friction, so that inside and outside of the cone differ by 0.03 %
# the first one is reported as the remedy
MENDING = ("one shift", "several shifts", "counterweight", "friction", "props")


@dataclass(frozen=True)
class Checked:
    """One suggestion."""

    kind: str
    whole: bool  # whether it claims to repair the whole pile, not just the first fall
    stands: bool | None  # by the linear program, up to the claimed stage; None if undecided
    falls_with_less: bool


@dataclass(frozen=True)
class Mended:
    """Suggestions for one pile."""

    checked: Sequence[Checked]
    seconds: float  # processor time
    asked: int  # number of progress reports

    @property
    def how(self) -> str:
        """Return the first kind of suggestion that claims to repair the whole pile."""
        kinds = {one.kind for one in self.checked if one.whole}
        return next((kind for kind in MENDING if kind in kinds), "nothing")


def piles(seed: int) -> Iterator[Piling]:
    """Yield random falling piles: each box on a present one, with a large overhang, and without overlaps."""
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


def upright(placed: Placed) -> UprightBox:
    """Return the box for the linear program."""
    assert isinstance(placed.brick.shape, Box)
    return UprightBox(placed.pose.position_W, placed.brick.shape.size, placed.brick.mass)


def _overlap(one: Placed, other: Placed) -> bool:
    a, b = upright(one), upright(other)
    sides = zip(a.middle, b.middle, a.size, b.size, strict=True)
    return all(abs(m - n) < 0.5 * (s + t) - 1e-9 for m, n, s, t in sides)


def as_scenario(piling: Piling) -> str:
    """Return a pile as YAML, as an author would write it."""
    lines = ["scenario: pile", f"friction: {piling.friction}", "build:", "  - every: 1 s", "    bricks:"]
    for placed in piling.bricks:
        box = upright(placed)
        size, at = (", ".join(f"{x!r} m" for x in each) for each in (box.size, box.middle))
        lines.append(
            f"      - {{name: {placed.brick.id}, at: [{at}], brick: {{size: [{size}], mass: {box.mass!r} kg}}}}"
        )
    return "\n".join(lines) + "\n"


def mended(piling: Piling) -> Mended:
    """Return the checked suggestions of `suggest` for a pile."""
    cases, mistakes = cases_of(parse(as_scenario(piling), "pile.yaml"))
    assert not mistakes, mistakes
    timeline = cases[0].timeline
    started, reports = process_time(), 0

    def count_report() -> None:
        nonlocal reports
        reports += 1

    remedies = list(suggestions(FallingBuild(timeline, proofs_of(timeline)), piling_of(timeline), count_report))
    return Mended([checked(piling, each) for each in remedies], process_time() - started, reports)


def checked(piling: Piling, suggestion: Suggestion) -> Checked:
    """Check a suggestion by linear programs."""
    match suggestion:
        case BrickShift(brick, shift):
            share = (1.0 - LESS_SHIFT) * suggestion.too_little / suggestion.length
            enough, less = (_fall(_shifted(piling, {brick: shift}, part)) for part in (1.0, share))
            return Checked("one shift", True, enough.stands, less.falls)
        case SeveralShifts(shifts, too_little):
            enough, less = (
                _fall(_shifted(piling, dict(shifts), part)) for part in (1.0, (1.0 - LESS_SHIFT) * too_little)
            )
            return Checked("several shifts", True, enough.stands, less.falls)
        case HeavierBrick(brick, mass, later):
            enough, less = (_fall(_heavier(piling, brick, part * mass)) for part in (1.0, 1.0 - LESS))
            if not later:
                return Checked("counterweight", True, enough.stands, less.falls)
            first = _fall(piling.bricks).at
            return Checked("counterweight", False, enough.holds(first), less.at == first)
        case MoreFriction(_, coefficient):
            more = coefficient - FRICTION
            enough, less = (_fall(piling.bricks, FRICTION + part * more, sides=SIDES) for part in (1.0, 1.0 - LESS))
            return Checked("friction", True, enough.stands, less.falls)
        case StrongerJoints():
            raise ValueError("a pile has no joints")
        case Propping(bricks, later):
            enough = _fall(piling.bricks, props=bricks)
            fewer = [_fall(piling.bricks, props=[name for name in bricks if name != spared]) for spared in bricks]
            if not later:
                return Checked("props", True, enough.stands, all(each.falls for each in fewer))
            first = _fall(piling.bricks).at
            return Checked("props", False, enough.holds(first), all(each.at == first for each in fewer))


@dataclass(frozen=True)
class _Fall:
    """First fall of a pile while it is built, by the linear program."""

    at: int | None  # index of the box; None if no fall, or undecided
    is_decided: bool  # whether every box before it is decided

    @property
    def stands(self) -> bool | None:
        return None if not self.is_decided else self.at is None

    @property
    def falls(self) -> bool:
        return self.at is not None

    def holds(self, first: int | None) -> bool:
        """Return whether the first fall no longer happens, regardless of later ones."""
        return first is not None and (self.at is None or self.at > first)


def _fall(bricks: Sequence[Placed], friction: float = FRICTION, props: Sequence[BodyId] = (), sides: int = 16) -> _Fall:
    boxes = [upright(placed) for placed in bricks]
    held = prop_contacts(boxes, [turn for turn, placed in enumerate(bricks) if placed.brick.id in props])
    decided = True
    for count in range(1, len(boxes) + 1):
        stands = answer(boxes[:count], friction, [each for each in held if each[1] < count], sides)
        if stands is False:
            return _Fall(count - 1, decided)
        decided = decided and stands is not None
    return _Fall(None, decided)


def _shifted(piling: Piling, shifts: dict[str, Shift], share: float) -> list[Placed]:
    """Return the boxes with bricks shifted by a share, and the bricks on them carried along."""
    carried, sums = piling.carried(), dict[str, Shift]()
    for brick, (x, y) in shifts.items():
        for name in carried[brick]:
            ox, oy = sums.get(name, (0.0, 0.0))
            sums[name] = ox + share * x, oy + share * y
    return piling.shifted(sums).bricks


def _heavier(piling: Piling, brick: BodyId, more: float) -> list[Placed]:
    return [
        replace(each, brick=replace(each.brick, mass=each.brick.mass + more)) if each.brick.id == brick else each
        for each in piling.bricks
    ]
