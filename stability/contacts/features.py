"""Faces, edges and corners of convex solids, and the normals that two of them have in common."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import atan2, dist
from typing import NamedTuple, Protocol

from stability.geometry.box_distance import coordinates
from stability.geometry.polygons import cut
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, scale, unit
from stability.model import BodyId, Pose, Vec3

FACE, EDGE, CORNER = 2, 1, 0  # dimensions of a feature

# Sine of the tolerance at the border of a cone of normals, and of the angle between equal directions.
ROUNDING = 1e-9

ORIGIN: Vec3 = (0.0, 0.0, 0.0)


class Feature(Protocol):
    """Face, edge or corner of a convex solid.

    The normals of a face are one direction, those of an edge all directions between the normals of its two faces, and
    those of a corner all directions without a positive component along its edges.
    """

    @property
    def dimension(self) -> int:
        """FACE, EDGE or CORNER."""

    @property
    def direction(self) -> Vec3:
        """The direction of an edge."""

    def normals(self, sign: float) -> Sequence[Vec3]:
        """Return the extreme unit normals, times a sign; those of a corner in order around it."""

    def limits(self, sign: float) -> Sequence[Vec3]:
        """Return the directions along which a normal of a corner, times a sign, has no positive component."""

    def containing(self, points: Sequence[Vec3], up_W: Vec3, slack: float) -> "Feature":
        """Return the smallest part of the feature within `slack` [m] of a point or a line, such as an edge of a face.

        `points` are its ends, from the centre of the solid. Distances are measured perpendicular to `up_W`.
        """


class Outline(Protocol):
    """Border of a face, in coordinates (x, y) of the face."""

    @property
    def corners(self) -> Sequence[tuple[float, float]]:
        """The corners in order [m]."""

    def clipped(self, corners: Sequence[Vec3], slack: float = 0.0) -> Sequence[Vec3]:
        """Clip a convex polygon, a line or a point to the face, extended by `slack` [m]."""

    def clamped(self, point: Vec3) -> Vec3:
        """Move a point beside the face to its border."""

    def has_on_border(self, segment: Sequence[Vec3], slack: float) -> bool:
        """Check that all points are within `slack` [m] of the same side."""


@dataclass(frozen=True, slots=True, eq=False)
class ConvexSolid(ABC):
    """Convex solid at a pose, with its faces, edges and corners by number."""

    id: BodyId
    pose: Pose  # of the centre
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    shortest: float  # least thickness [m]
    longest: float  # longest side of the box around the shape along its body axes [m]

    @abstractmethod
    def extent(self, direction_W: Vec3) -> float:
        """Return the largest component of a point of the solid along a unit direction, from the centre [m]."""

    @abstractmethod
    def face(self, number: int, towards_W: Vec3) -> "Face":
        """Return a face by its number; of two faces with the same number, the one that faces a direction."""

    @abstractmethod
    def edge(self, number: int, towards_W: Vec3) -> "Edge":
        """Return an edge by its number; of several edges with the same number, the outermost along a direction."""

    @abstractmethod
    def lowest(self, on: "Face", p_BO: Vec3, rise: float) -> tuple[Feature, Sequence[Vec3]]:
        """Return the feature nearest to a face of body B, and its corners in order as (x, y, height above the face).

        `p_BO` leads from the centre of B to that of this solid. Corners up to `rise` [m] above the lowest one belong to
        the feature.
        """

    @abstractmethod
    def lowest_corners(self, up_W: Vec3, rise: float) -> Sequence[Vec3]:
        """Return the lowest corners, counter-clockwise seen from above, from the centre, in W [m].

        They include all corners whose component along the unit vector `up_W` is at most `rise` [m].
        """


class Face(NamedTuple):
    """Face of a convex solid, with a frame: x and y in the face, z along its outward normal."""

    body: ConvexSolid
    feature: Feature
    axes: tuple[Vec3, Vec3, Vec3]  # x, y and z in W
    is_right_handed: bool  # whether these axes are
    reach: float  # distance of the face from the centre of the body [m]
    outline: Outline

    @property
    def normal_W(self) -> Vec3:
        """The outward normal."""
        return self.axes[2]

    def seen(self, points: Sequence[Vec3]) -> list[Vec3]:
        """Convert points, from the centre of the body in W, to (x, y, height above the face)."""
        return [(x, y, z - self.reach) for x, y, z in [coordinates(point, self.axes) for point in points]]

    def placed(self, points: Iterable[Sequence[float]], p_OB: Vec3 = ORIGIN) -> list[Vec3]:
        """Convert points (x, y) of the face to W, from an origin O; `p_OB` leads from O to the centre of the body."""
        u, v, normal = self.axes
        middle = add_scaled(p_OB, self.reach, normal)
        return [add_scaled(add_scaled(middle, point[0], u), point[1], v) for point in points]


class Edge(NamedTuple):
    """Edge of a convex solid, as a line."""

    feature: Feature
    middle: Vec3  # from the centre of the body, in W [m]
    direction_W: Vec3  # unit
    half: float  # half length [m]


def common_normals(a: Feature, b: Feature, along_line: bool) -> tuple[Vec3, ...]:
    """Return the extreme unit normals, from a towards b; none if the features do not face each other.

    They bound the intersection of the normals of one feature with the negative normals of the other. Edges that touch
    along a line count as parallel.
    """
    if a.dimension == FACE:
        return tuple(a.normals(1.0))
    if b.dimension == FACE:
        return tuple(b.normals(-1.0))
    if a.dimension == b.dimension == EDGE:
        across = cross(a.direction, b.direction)
        if along_line or norm(across) < ROUNDING:
            return _of_parallel_edges(a.normals(1.0), b.normals(-1.0))
        normal = unit(across)
        outward = sum(dot(normal, normal_of_a) for normal_of_a in a.normals(1.0))
        return (normal if outward > 0.0 else scale(-1.0, normal),)
    if a.dimension == EDGE:
        return _clipped(a.normals(1.0), b.limits(-1.0))
    return _clipped(b.normals(-1.0), a.limits(1.0))


def _of_parallel_edges(arc_a: Sequence[Vec3], arc_b: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Intersect two arcs of normals in the plane perpendicular to the edges."""
    (start, end), around = arc_a, cross(*arc_a)
    first, last = arc_b if dot(cross(*arc_b), around) > 0.0 else arc_b[::-1]
    middle_a, middle_b = add(start, end), add(first, last)
    half_a, half_b = atan2(dist(start, end), norm(middle_a)), atan2(dist(first, last), norm(middle_b))
    # Rotation of the arc of b relative to that of a, towards its end.
    turn = atan2(dot(cross(middle_a, middle_b), unit(around)), dot(middle_a, middle_b))
    if abs(turn) > half_a + half_b + ROUNDING:
        return ()
    starts_later = turn - half_b > -half_a + ROUNDING
    ends_earlier = turn + half_b < half_a - ROUNDING
    return _distinct((first if starts_later else start, last if ends_earlier else end))


def _clipped(cone: Sequence[Vec3], limits: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Clip a cone of normals to the half-spaces without a positive component along the limits."""
    normals = list(cone)
    for limit in limits:
        normals = cut(normals, [-dot(normal, limit) for normal in normals], ROUNDING, _between) if normals else []
    return _distinct(normals)


def _between(start: Vec3, end: Vec3, part: float) -> Vec3:
    """Interpolate between two directions."""
    return unit(add_scaled(scale(1.0 - part, start), part, end))


def _distinct(normals: Sequence[Vec3]) -> tuple[Vec3, ...]:
    distinct: list[Vec3] = []
    for normal in normals:
        if all(dist(normal, other) > ROUNDING for other in distinct):
            distinct.append(normal)
    return tuple(distinct)
