"""Where two boxes lie face on face: nearly parallel faces whose gap counts as contact at every corner of the overlap.

Of faces that gape wider at some corner, only edges and corners that meet count (`features`): a strip of two faces that
are tilted against each other by a degree, as wide as the gap counts, would hold up what tips over an edge.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist, inf
from typing import Self

from stability.geometry.clipping import within_rectangle
from stability.geometry.polygons import doubled_area
from stability.geometry.touching import gap_bridged
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import Vec3
from stability.statics.contacts.axes import NEARLY_PARALLEL, Closeness
from stability.statics.contacts.solids import BoxSolid, rounding

LEVEL = 1e-12  # height of a unit normal below which it is horizontal: rounding


@dataclass(frozen=True, slots=True)
class Face:
    """One side of a box."""

    body: BoxSolid
    axis: int
    sign: float  # of the body axis that leads out of it

    @classmethod
    def towards(cls, direction: Vec3, body: BoxSolid, axis: int) -> Self:
        """The one of the two faces across an axis that looks in this direction."""
        return cls(body, axis, 1.0 if dot(direction, body.axes[axis]) > 0.0 else -1.0)

    @property
    def normal_W(self) -> Vec3:
        return scale(self.sign, self.body.axes[self.axis])


@dataclass(frozen=True, slots=True)
class Patch:
    """Where two bodies touch over an area."""

    lower: BoxSolid
    upper: BoxSolid
    points_W: tuple[Vec3, ...]  # in order [m]
    heights: tuple[float, ...]  # of the upper body above the lower one at each [m]
    normal_W: Vec3


@dataclass(frozen=True, slots=True)
class Slack:
    """What counts as touching where two bodies are a little off their places [m]."""

    sideways: float  # features whose places differ by less coincide
    off: float  # how far the two may be off: vertices less above the lowest one touch too, and gaps differ by that
    reach: float  # what is deeper in a face does not touch it, nor what is further from it
    within: float  # what is further from a face than that does not touch it either, whatever the reach

    def rise(self, gap: float) -> float:
        """How much higher than the lowest vertex, which is `gap` above a face, another may be that belongs to it."""
        return min(self.off, max(self.sideways, self.reach - gap))

    def widest(self, normal_W: Vec3) -> float:
        """The widest gap along a normal that counts as contact."""
        return gap_bridged(self.reach, normal_W[2], self.within)


def face_on_face(a: BoxSolid, b: BoxSolid, close: Closeness, slack: Slack) -> Patch | None:
    """The patch of two faces whose gap counts as contact all over; None if none is wider than `slack.sideways`."""
    for of_a, of_b in _facing(a, b, close):
        lower, upper, normal = _in_order(of_a, of_b)
        corners = _overlap(lower, upper)
        if lies_on(corners, normal, slack):
            points, heights = _placed(lower, corners, rounding(a, b))
            return Patch(lower.body, upper.body, points, heights, normal)
    return None


def lies_on(corners: Sequence[Vec3], normal_W: Vec3, slack: Slack) -> bool:
    """Whether what overlaps a face, as (x, y, height above it), lies on it all over, and is no mere line."""
    widest = slack.widest(normal_W)
    return all(-slack.reach <= height <= widest for _, _, height in corners) and width(corners) > slack.sideways


def _facing(a: BoxSolid, b: BoxSolid, close: Closeness) -> Iterator[tuple[Face, Face]]:
    """Pairs of nearly parallel faces that look at each other, the ones least deep in each other first."""
    pairs = [
        (max(close.faces_a[i].gap, close.faces_b[j].gap), i, j)
        for i, row in enumerate(close.sines)
        for j, sine in enumerate(row)
        if sine <= NEARLY_PARALLEL
    ]
    for _, i, j in sorted(pairs, reverse=True):
        normal = close.faces_a[i].normal_AB_W
        yield Face.towards(normal, a, i), Face.towards(scale(-1.0, normal), b, j)


def _in_order(of_a: Face, of_b: Face) -> tuple[Face, Face, Vec3]:
    """The lower face, the upper one, and the normal of the lower one; a comes first by name."""
    up_a, up_b = of_a.normal_W, of_b.normal_W
    if up_a[2] >= -LEVEL:
        return of_a, of_b, up_a
    if up_b[2] > LEVEL:
        return of_b, of_a, up_b
    # Both lean down, by noise: two upright sides that gape.
    return of_a, of_b, scale(-1.0, up_b)


def _overlap(on: Face, lying: Face) -> Sequence[Vec3]:
    """What lies above face `on` of the other face, as (x, y, height above it) in the frame of the face `on`."""
    body, other = on.body, lying.body
    first, second = (on.axis + 1) % 3, (on.axis + 2) % 3
    frame = (body.axes[first], body.axes[second], on.normal_W)
    u, v = (lying.axis + 1) % 3, (lying.axis + 2) % 3
    p_AF = subtract(other.pose.position_W, body.pose.position_W)
    p_AF = add_scaled(p_AF, other.half[lying.axis], lying.normal_W)
    corners = []
    for su, sv in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)):
        corner = add_scaled(add_scaled(p_AF, su * other.half[u], other.axes[u]), sv * other.half[v], other.axes[v])
        x, y, z = (dot(corner, axis) for axis in frame)
        corners.append((x, y, z - body.half[on.axis]))
    return within_rectangle(corners, body.half[first], body.half[second])


def width(corners: Sequence[Vec3]) -> float:
    """How far apart the closest two parallel lines are that take a convex polygon between them [m]; heights aside."""
    flat = [(x, y) for x, y, _ in corners]
    narrowest = inf
    for (ax, ay), (bx, by) in pairwise([*flat, *flat[:1]]):
        length = dist((ax, ay), (bx, by))
        if length > 0.0:
            reach = max(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) for x, y in flat) / length
            narrowest = min(narrowest, reach)
    return narrowest if narrowest < inf else 0.0


def _placed(on: Face, corners: Sequence[Vec3], slack: float) -> tuple[tuple[Vec3, ...], tuple[float, ...]]:
    """The corners in W, in the plane of the face, counter-clockwise seen from outside; doubled ones once.

    And the heights above the face [m].
    """
    body = on.body
    first, second = body.axes[(on.axis + 1) % 3], body.axes[(on.axis + 2) % 3]
    area, _ = doubled_area([(x, y) for x, y, _ in corners])
    points: list[Vec3] = []
    heights: list[float] = []
    # The frame of the face is right-handed where its normal is a body axis, and left-handed where it is minus that.
    for x, y, height in corners if area * on.sign > 0.0 else corners[::-1]:
        local = add_scaled(add_scaled(scale(body.half[on.axis], on.normal_W), x, first), y, second)
        if not any(dist(local, other) <= slack for other in points):
            points.append(local)
            heights.append(height)
    return tuple(add_scaled(body.pose.position_W, 1.0, local) for local in points), tuple(heights)
