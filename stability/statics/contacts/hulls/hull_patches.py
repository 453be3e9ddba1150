"""Where two hulls lie face on face: nearly parallel faces whose gap counts as contact all over their overlap."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist

import numpy as np

from stability.geometry.clipping import cut
from stability.geometry.plan import Point2
from stability.geometry.polyhedra import Array, Hull, vector
from stability.geometry.vectors import cross
from stability.model import Vec3
from stability.statics.contacts.faces import LEVEL, Slack, lies_on
from stability.statics.contacts.hulls.hull_closeness import HullCloseness


@dataclass(frozen=True, slots=True, eq=False)
class Plate:
    """One face of a hull, as the frame in which what lies on it is seen: x and y along it, z out of it."""

    body: Hull
    number: int
    axes: Array  # (3, 3) rows x, y, z in W; right-handed
    corners: tuple[Point2, ...]  # counter-clockwise seen from outside, from the body's centre [m]
    reach: float  # of the face from the body's centre [m]

    def seen(self, points: Array) -> list[Vec3]:
        """Points (n, 3), from the body's centre in W, as (x, y, height above the face)."""
        return [(x, y, z - self.reach) for x, y, z in (points @ self.axes.T).tolist()]

    def placed(self, point: Sequence[float]) -> Array:
        """A point (x, y) of the face, from the body's centre in W [m]."""
        found: Array = point[0] * self.axes[0] + point[1] * self.axes[1] + self.reach * self.axes[2]
        return found

    def cut_to(self, corners: Sequence[Vec3], slack: float = 0.0) -> Sequence[Vec3]:
        """The part of a convex polygon, a line or a point that lies over the face, or beside it by at most `slack`."""
        for (ax, ay), (bx, by) in zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True):
            if not corners:
                return ()
            dx, dy = bx - ax, by - ay
            length = (dx * dx + dy * dy) ** 0.5
            depths = [(dx * (y - ay) - dy * (x - ax)) / length + slack for x, y, _ in corners]
            if min(depths) < 0.0:
                corners = cut(corners, depths)
        return corners


def plate(body: Hull, number: int) -> Plate:
    """A face of a hull as a frame, x along its first side."""
    loop, normal = list(body.mesh.loops[number]), body.normals[number]
    points = body.corners[loop]
    along = points[1] - points[0]
    along = along - (along @ normal) * normal
    along /= np.linalg.norm(along)
    axes = np.array((along, cross(vector(normal), vector(along)), normal))
    corners = tuple((x, y) for x, y, _ in (points @ axes.T).tolist())
    return Plate(body, number, axes, corners, float(body.mesh.reaches[number]))


@dataclass(frozen=True, slots=True)
class HullPatch:
    """Where two hulls touch over an area."""

    a_is_lower: bool
    points_W: tuple[Vec3, ...]  # in order [m]
    heights: tuple[float, ...]  # of the upper body above the lower one at each [m]
    normal_W: Vec3  # out of the lower one


def face_on_face(close: HullCloseness, slack: Slack, rounding: float) -> HullPatch | None:
    """The patch of two faces whose gap counts as contact all over; None if none is wider than `slack.sideways`."""
    pairs = [(max(float(close.gaps_a[i]), float(close.gaps_b[j])), i, j) for i, j, _ in close.facing]
    for _, i, j in sorted(pairs, reverse=True):
        lower_is_a, normal = _order(close, i, j)
        on = plate(close.a, i) if lower_is_a else plate(close.b, j)
        other, face = (close.b, j) if lower_is_a else (close.a, i)
        shift = close.p_AB if lower_is_a else -close.p_AB
        lying = on.seen(other.corners[list(other.mesh.loops[face])] + shift)
        corners = on.cut_to(lying[::-1])  # seen from outside of the face that carries, the other runs backwards
        if corners and lies_on(corners, vector(normal), slack):
            points, heights = _placed(on, corners, rounding)
            return HullPatch(lower_is_a, points, heights, vector(normal))
    return None


def _order(close: HullCloseness, i: int, j: int) -> tuple[bool, Array]:
    """Whether the face of a is the lower one, and the normal from the lower body to the upper one; a comes first."""
    up_a, up_b = close.a.normals[i], close.b.normals[j]
    if up_a[2] >= -LEVEL:
        return True, up_a
    if up_b[2] > LEVEL:
        return False, up_b
    return True, -up_b  # both lean down, by noise: two upright sides that gape


def _placed(on: Plate, corners: Sequence[Vec3], rounding: float) -> tuple[tuple[Vec3, ...], tuple[float, ...]]:
    """The corners in W, doubled ones once, and their heights above the face [m]."""
    kept: list[Array] = []
    heights: list[float] = []
    for corner in corners:
        local = on.placed(corner)
        if not any(dist(local, other) <= rounding for other in kept):
            kept.append(local)
            heights.append(corner[2])
    centre = np.array(on.body.p_WC)
    return tuple(vector(centre + local) for local in kept), tuple(heights)
