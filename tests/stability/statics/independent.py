"""An independent check of verdicts: friction pyramids and a plain linear program, nothing of `stability.statics`.

A pyramid inside the friction cone can only carry less than the cone, so what it carries is stable. A pyramid around
the cone can only carry more, so what it cannot carry is unstable. Between the two there is no statement. Contacts are
worked out here for boxes that lie flat, turned by any yaw, on each other and on level ground; others are given by hand.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import atan2, cos, hypot, pi, sin
from typing import Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import csc_array, hstack, identity

from stability.geometry.box import as_box
from stability.model import GROUND, BodyId, Brick, Pose, Vec3

Answer: TypeAlias = Literal["stable", "unstable"]
Array: TypeAlias = NDArray[np.float64]
Point: TypeAlias = tuple[float, float]

SIDES = 16  # of a pyramid; the two pyramids differ by 2 %
TOUCHING = 1e-9  # [m] heights this close are equal
BALANCED = 1e-9  # residuals below this share of a brick's own weight count as none
FALLING = 1e-6  # what cannot be balanced to this share is proven to fall


class InPlace(Protocol):
    """A brick and where it is."""

    @property
    def brick(self) -> Brick: ...
    @property
    def pose(self) -> Pose: ...


@dataclass(frozen=True, slots=True)
class Touch:
    """A flat contact: `upper` is pressed along `normal`, away from `lower`, at any of the points."""

    lower: BodyId
    upper: BodyId
    points: tuple[Vec3, ...]  # [m]
    normal: Vec3  # unit
    along: Vec3  # unit, in the plane of contact: where the first side of the pyramid points
    friction: float


def independent_verdict(bricks: Iterable[InPlace], friction: float) -> Answer | None:
    """What is certain of boxes that lie flat on each other and on level ground at height 0."""
    placed = {each.brick.id: each for each in bricks}
    return verdict_of(placed, flat_touches(placed.values(), friction))


def flat_touches(bricks: Collection[InPlace], friction: float) -> list[Touch]:
    """The contacts of boxes that lie flat on each other and on level ground at height 0."""
    return [*_on_ground(bricks, friction), *_on_bricks(bricks, friction)]


def verdict_of(placed: Mapping[BodyId, InPlace], touches: Sequence[Touch]) -> Answer | None:
    """What is certain of bricks with these contacts. Vertical forces alone are tried first, since they are quick."""
    if all(touch.normal == (0.0, 0.0, 1.0) for touch in touches) and _imbalance(placed, touches, 0.0) < BALANCED:
        return "stable"
    if _imbalance(placed, touches, 1.0 / cos(pi / SIDES)) > FALLING:
        return "unstable"
    return "stable" if _imbalance(placed, touches, 1.0) < BALANCED else None


def _imbalance(placed: Mapping[BodyId, InPlace], touches: Sequence[Touch], widening: float) -> float:
    """The least sum of what is left unbalanced, each row as a share of its brick's weight.

    Elastic, so that there always is an optimum, and no status of the solver is ever read as an answer.
    """
    columns = [column for touch in touches for column in _columns(placed, touch, widening)]
    index = {name: 6 * number for number, name in enumerate(sorted(placed))}
    entries = [(index[name] + row, number, value) for number, rows in enumerate(columns) for name, row, value in rows]
    rows, numbers, values = zip(*entries, strict=True) if entries else ((), (), ())
    size = 6 * len(placed)
    forces = csc_array((np.array(values), (np.array(rows, int), np.array(numbers, int))), shape=(size, len(columns)))
    load = np.zeros(size)
    load[[place + 2 for place in index.values()]] = 1.0
    slack = identity(size, format="csc")
    cost = np.concatenate([np.zeros(len(columns)), np.ones(2 * size)])
    found = linprog(
        cost,
        A_eq=hstack([forces, slack, -slack], format="csc"),
        b_eq=load,
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    return _bound(forces, load, found.x[: len(columns)], np.clip(found.eqlin.marginals, -1.0, 1.0))


def _bound(forces: csc_array, load: Array, x: Array, multipliers: Array) -> float:
    """What x leaves unbalanced, if that is nothing; else what the multipliers prove to be left by any forces."""
    left = float(np.abs(forces @ np.maximum(x, 0.0) - load).sum())
    if left < BALANCED:
        return left
    # Multipliers y prove y.load only if no column gains from them: weak duality, up to what is noise in both.
    gain = float(np.max(multipliers @ forces, initial=0.0))
    return float(multipliers @ load) if gain < 1e-8 else BALANCED


def _columns(
    placed: Mapping[BodyId, InPlace], touch: Touch, widening: float
) -> Iterator[list[tuple[BodyId, int, float]]]:
    """What one unit of each extreme force of a contact adds to the rows of the two bricks."""
    for point in touch.points:
        for force in _extremes(touch, widening):
            entries: list[tuple[BodyId, int, float]] = []
            for name, sign in ((touch.upper, 1.0), (touch.lower, -1.0)):
                if name in placed:
                    entries += [(name, row, sign * value) for row, value in _wrench(placed[name], point, force)]
            yield entries


def _wrench(at: InPlace, point: Vec3, force: Vec3) -> list[tuple[int, float]]:
    """Force and torque about the centre of mass, as shares of the weight and of weight times half diagonal.

    A unit of force is the weight of a kilogram, so gravity drops out.
    """
    rx, ry, rz = (a - b for a, b in zip(point, at.pose.position_W, strict=True))
    fx, fy, fz = force
    reach = at.brick.shape.bounding_radius
    torque = (ry * fz - rz * fy, rz * fx - rx * fz, rx * fy - ry * fx)
    rows = [*(value / at.brick.mass for value in force), *(value / at.brick.mass / reach for value in torque)]
    return [(row, value) for row, value in enumerate(rows) if value != 0.0]


def _extremes(touch: Touch, widening: float) -> list[Vec3]:
    """The edges of the pyramid, `widening` times as wide as those of the cone; the normal alone where there is none."""
    slope = touch.friction * widening
    if slope == 0.0:
        return [touch.normal]
    across = _cross(touch.normal, touch.along)
    # Edges along the patch within the cone, faces across it around the cone: so both are exact for forces along it.
    start = 0.5 if widening > 1.0 else 0.0
    angles = [2.0 * pi * (side + start) / SIDES for side in range(SIDES)]
    return [
        tuple_of(n + slope * (c * a + s * b) for n, a, b in zip(touch.normal, touch.along, across, strict=True))
        for c, s in ((cos(angle), sin(angle)) for angle in angles)
    ]


def tuple_of(values: Iterable[float]) -> Vec3:
    """Three numbers as a vector."""
    x, y, z = values
    return (x, y, z)


def _cross(a: Vec3, b: Vec3) -> Vec3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _on_ground(placed: Iterable[InPlace], friction: float) -> Iterator[Touch]:
    for each in placed:
        if abs(bottom(each)) < TOUCHING:
            points = tuple((x, y, 0.0) for x, y in outline(each))
            yield Touch(GROUND, each.brick.id, points, (0.0, 0.0, 1.0), _heading(each), friction)


def _on_bricks(placed: Iterable[InPlace], friction: float) -> Iterator[Touch]:
    for one, other in combinations(placed, 2):
        lower, upper = (one, other) if top(one) < top(other) else (other, one)
        if abs(bottom(upper) - top(lower)) < TOUCHING and near(one, other):
            points = tuple((x, y, top(lower)) for x, y in overlap(outline(lower), outline(upper)))
            if points:
                yield Touch(lower.brick.id, upper.brick.id, points, (0.0, 0.0, 1.0), _heading(lower), friction)


def size_of(each: InPlace) -> Vec3:
    """Length, width and thickness [m]."""
    return as_box(each.brick.shape, "the independent verdict").size


def bottom(each: InPlace) -> float:
    """Height of the under side [m]."""
    return each.pose.position_W[2] - 0.5 * size_of(each)[2]


def top(each: InPlace) -> float:
    """Height of the upper side [m]."""
    return each.pose.position_W[2] + 0.5 * size_of(each)[2]


def near(one: InPlace, other: InPlace, apart: float = 0.0) -> bool:
    """Whether the circles around two outlines come within `apart` [m] of each other."""
    (ax, ay, _), (bx, by, _) = one.pose.position_W, other.pose.position_W
    reach = 0.5 * (hypot(*size_of(one)[:2]) + hypot(*size_of(other)[:2]))
    return hypot(ax - bx, ay - by) < reach + 2.0 * apart


def yaw(each: InPlace) -> float:
    """The turn of a box that lies flat [rad]."""
    _, _, z, w = each.pose.orientation
    return 2.0 * atan2(z, w)


def _heading(each: InPlace) -> Vec3:
    return (cos(yaw(each)), sin(yaw(each)), 0.0)


def outline(each: InPlace, grown: float = 0.0) -> list[Point]:
    """The corners seen from above, counter-clockwise, `grown` outwards by so much on every side [m]."""
    c, s = cos(yaw(each)), sin(yaw(each))
    x, y, _ = each.pose.position_W
    a, b = 0.5 * size_of(each)[0] + grown, 0.5 * size_of(each)[1] + grown
    return [(x + u * c - v * s, y + u * s + v * c) for u, v in ((-a, -b), (a, -b), (a, b), (-a, b))]


def overlap(one: Sequence[Point], other: Sequence[Point]) -> list[Point]:
    """The corners of the common part of two convex outlines: corners within, and where the edges cross."""
    corners = [p for p in one if _within(p, other)] + [p for p in other if _within(p, one)]
    for a, b in _edges(one):
        for c, d in _edges(other):
            across = (b[0] - a[0]) * (d[1] - c[1]) - (b[1] - a[1]) * (d[0] - c[0])
            if across == 0.0:
                continue
            u = ((c[0] - a[0]) * (d[1] - c[1]) - (c[1] - a[1]) * (d[0] - c[0])) / across
            v = ((c[0] - a[0]) * (b[1] - a[1]) - (c[1] - a[1]) * (b[0] - a[0])) / across
            if 0.0 <= u <= 1.0 and 0.0 <= v <= 1.0:
                corners.append((a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1])))
    return corners if len(corners) > 2 else []


def _within(point: Point, outline: Sequence[Point]) -> bool:
    return all((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) >= 0.0 for a, b in _edges(outline))


def _edges(outline: Sequence[Point]) -> list[tuple[Point, Point]]:
    return list(zip(outline, [*outline[1:], outline[0]], strict=True))
