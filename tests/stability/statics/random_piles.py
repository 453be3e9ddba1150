"""Random piles: planks set down flat, one after the other, anywhere near the others, on the highest thing below.

Overhangs, bridges, counterweights and merges come about by themselves. About half of the piles stand.
"""

from math import cos, pi, sin

import numpy as np

from stability.geometry.box import Box
from stability.geometry.polygons import Point2, Polygon, centroid, convex_hull, signed_distance
from stability.model import Brick, Pose, Vec3
from stability.problem import Placed
from tests.stability.statics.independent import TOUCHING, bottom, near, outline, overlap, top

FRICTION = 0.5
SEED = 0
KAPLA: Vec3 = (0.1176, 0.0234, 0.0078)
SIZES: tuple[Vec3, ...] = (KAPLA, (0.0588, 0.0234, 0.0078), (0.1176, 0.0468, 0.0156), (0.0234, 0.0234, 0.0468))
DENSITY = 557.0  # [kg/m3]
# [m] A gap that a contact tolerance, a share of the smallest side, might close. Piles have none.
DOUBTFUL = 0.04 * 0.0234


def random_piles(count: int, seed: int = SEED) -> list[tuple[Placed, ...]]:
    """Piles of 3 to 12 planks, and every tenth of up to 30, in the order in which the planks were set down."""
    return [random_pile(np.random.default_rng([seed, number]), number) for number in range(count)]


def random_pile(generator: np.random.Generator, number: int) -> tuple[Placed, ...]:
    """One pile. How its bricks are mixed and turned depends on its number, so that every kind occurs."""
    planks = int(generator.integers(13, 31) if number % 10 == 9 else generator.integers(3, 13))
    care = 1.0 - max(0.0, float(generator.uniform(-0.6, 1.4))) / planks
    return pile_of(generator, planks, care, mixed=number % 3 == 2, askew=(0.0, 0.5, 1.0)[number % 3])


def pile_of(
    generator: np.random.Generator, planks: int, care: float = 1.0, mixed: bool = False, askew: float = 0.5
) -> tuple[Placed, ...]:
    """So many planks, a share of them `askew`; `mixed` in size and density.

    `care` is the chance that a plank which would tip by itself is taken away again: most piles fall without. One that
    is left gets a counterweight next, which may or may not do.
    """
    reach = float(generator.uniform(0.03, 0.06 + 0.004 * planks))
    placed: list[Placed] = []
    aim: Point2 | None = None
    while len(placed) < planks:
        brick = _drawn_brick(generator, f"p{len(placed):02}", mixed)
        at = _drawn_place(generator, reach) if aim is None else aim
        candidate = _set_down(generator, brick, placed, at, askew)
        seat = _seat(candidate, placed)
        seated = signed_distance(candidate.pose.position_W[:2], seat) > 0.0
        aim = None
        if (seated or generator.random() >= care) and not _doubtful_among(candidate, placed):
            aim = None if seated else _behind(generator, candidate, seat)
            placed.append(candidate)
    return tuple(placed)


def _drawn_place(generator: np.random.Generator, reach: float) -> Point2:
    x, y = generator.uniform(-reach, reach, 2)
    return (float(x), float(y))


def _behind(generator: np.random.Generator, brick: Placed, seat: Polygon) -> Point2:
    """A place on the other side of the seat than the centre of a brick that tips."""
    (x, y), (u, v) = centroid(seat), brick.pose.position_W[:2]
    share = float(generator.uniform(0.3, 1.5))
    return (x + share * (x - u), y + share * (y - v))


def _drawn_brick(generator: np.random.Generator, name: str, mixed: bool) -> Brick:
    size = SIZES[int(generator.integers(len(SIZES)))] if mixed else KAPLA
    density = DENSITY * float(generator.choice([0.1, 1.0, 1.0, 10.0])) if mixed else DENSITY
    return Brick(name, Box(size), density * size[0] * size[1] * size[2])


def _set_down(generator: np.random.Generator, brick: Brick, below: list[Placed], at: Point2, askew: float) -> Placed:
    """The brick where it comes to lie: on the highest thing below."""
    turned = bool(generator.random() < askew)
    yaw = float(generator.uniform(0.0, pi)) if turned else 0.5 * pi * int(generator.integers(4))
    turn = (0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw))
    flat = Placed(brick, Pose((*at, 0.0), turn))
    floor = max((top(other) for other in below if _overlaps(flat, other)), default=0.0)
    return Placed(brick, Pose((*at, floor + top(flat)), turn))


def _seat(brick: Placed, below: list[Placed]) -> Polygon:
    """What a brick, as it comes to lie, lies on: the hull of all its contacts."""
    if bottom(brick) < TOUCHING:
        return convex_hull(outline(brick))
    under = [other for other in below if abs(bottom(brick) - top(other)) < TOUCHING and near(brick, other)]
    return convex_hull(corner for other in under for corner in overlap(outline(brick), outline(other)))


def _doubtful_among(brick: Placed, placed: list[Placed]) -> bool:
    """Whether a brick lies, or has passed, within a hair of something that it does not touch."""
    return any(_doubtful(brick, other) for other in placed)


def _doubtful(brick: Placed, other: Placed) -> bool:
    gap = bottom(brick) - top(other)
    if gap > DOUBTFUL or bottom(other) - top(brick) > DOUBTFUL:
        return False
    if _overlaps(brick, other):
        return gap > TOUCHING
    return near(brick, other, DOUBTFUL) and bool(overlap(outline(brick, DOUBTFUL), outline(other)))


def _overlaps(brick: Placed, other: Placed) -> bool:
    """Whether they do seen from above."""
    return near(brick, other) and bool(overlap(outline(brick), outline(other)))
