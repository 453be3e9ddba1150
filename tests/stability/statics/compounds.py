"""Random assemblies of compounds, and a verdict on them by a program that knows nothing of compounds."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stability.geometry.box import Box
from stability.geometry.compound import parts_of
from stability.geometry.compound_making import FramedCompound, compound
from stability.geometry.placed_shape import part_pose
from stability.geometry.vectors import about, add, multiply, rotate
from stability.model import GROUND, IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed
from tests.stability.statics.independent import Answer, bottom, flat_touches, outline, overlap, top, verdict_of

UPWARDS: Vec3 = (0.0, 0.0, 1.0)


def ground(friction: float) -> Plane:
    return Plane(GROUND, (0.0, 0.0, 0.0), UPWARDS, friction)


def boxes(*parts: tuple[Vec3, Vec3]) -> FramedCompound:
    """A compound of boxes, each by its size and its centre."""
    return compound([(Box(size), Pose(centre)) for size, centre in parts])


def put(name: str, made: FramedCompound, origin: Vec3, turn: Quaternion = IDENTITY, mass: float = 1.0) -> Placed:
    """A compound with the origin in which it was written in a place."""
    return Placed(Brick(name, made.shape, mass), Pose(add(origin, rotate(turn, made.centre_of_mass)), turn))


def parts(placed: Placed) -> list[Placed]:
    """The parts of a brick as bricks of their own, with its density."""
    density = placed.brick.mass / placed.brick.shape.volume
    return [
        Placed(Brick(f"{placed.brick.id}/{n}", part.shape, density * part.shape.volume), part_pose(part, placed.pose))
        for n, part in enumerate(parts_of(placed.brick.shape))
    ]


def joined_verdict(bricks: Sequence[Placed], friction: float) -> Answer | None:
    """Known facts of compounds of upright boxes on level ground, from the contacts of their parts as boxes."""
    touches = flat_touches([part for placed in bricks for part in parts(placed)], friction)
    whole = {part.brick.id: placed.brick.id for placed in bricks for part in parts(placed)}
    renamed = [replace(t, lower=whole.get(t.lower, t.lower), upper=whole.get(t.upper, t.upper)) for t in touches]
    return verdict_of({p.brick.id: p for p in bricks}, [touch for touch in renamed if touch.lower != touch.upper])


@dataclass(frozen=True, slots=True)
class Assembled:
    """A random assembly."""

    bricks: tuple[Placed, ...]
    friction: float


def random_compound(rng: np.random.Generator) -> FramedCompound:
    """An L, T, U, O or table of random proportions."""
    a, b, c, s, t = (float(size) for size in rng.uniform((0.1, 0.05, 0.04, 0.01, 0.02), (0.3, 0.15, 0.2, 0.024, 0.04)))
    base = ((a, b, t), (0.0, 0.0, 0.5 * t))
    left, right = (((s, b, c), (x, 0.0, t + 0.5 * c)) for x in (0.5 * (s - a), 0.5 * (a - s)))
    middle = ((s, b, c), (0.0, 0.0, t + 0.5 * c))
    lid = ((a, b, t), (0.0, 0.0, 1.5 * t + c))
    legs = [
        ((s, s, c), (x, y, t + 0.5 * c)) for x in (0.5 * (s - a), 0.5 * (a - s)) for y in (0.5 * (s - b), 0.5 * (b - s))
    ]
    kinds = ([base, left], [base, middle], [base, left, right], [base, left, right, lid], [base, *legs])
    return boxes(*kinds[int(rng.integers(len(kinds)))])


def random_assembly(seed: int) -> Assembled:
    """Compounds and boxes, each upright or upside down, turned about the vertical, and set down on what is below."""
    rng = np.random.default_rng(seed)
    there: list[Placed] = []
    for number in range(int(rng.integers(2, 6))):
        made = (
            random_compound(rng) if rng.random() < 0.8 else boxes((tuple(rng.uniform(0.05, 0.2, 3)), (0.0, 0.0, 0.0)))
        )
        turn = about(UPWARDS, float(rng.choice([0.0, rng.uniform(0.0, 3.0)])))
        if rng.random() < 0.5:
            turn = multiply(turn, about((1.0, 0.0, 0.0), np.pi))
        x, y = (float(along) for along in rng.uniform(-0.04, 0.04, 2))
        own = put(f"b{number}", made, (x, y, 10.0), turn, float(rng.uniform(0.5, 2.0)))
        height = _fall(own, there)
        px, py, pz = own.pose.position_W
        there.append(replace(own, pose=replace(own.pose, position_W=(px, py, pz - height))))
    return Assembled(tuple(there), float(rng.uniform(0.1, 0.8)))


def _fall(own: Placed, there: Sequence[Placed]) -> float:
    """The height over what is below, by the outlines of boxes."""
    heights = [bottom(part) for part in parts(own)]
    for part in parts(own):
        for other in (each for placed in there for each in parts(placed)):
            if overlap(outline(part), outline(other)) and bottom(part) >= top(other):
                heights.append(bottom(part) - top(other))
    return min(heights)
