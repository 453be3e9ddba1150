"""Contacts of round solids: with planes, boxes, other solids, and each other.

The contact lies along the direction of the largest gap. Each body has a feature there: a point, a line, or a flat face.
Where two features meet, the contact is a point, a line, or a patch with straight and round borders.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist, hypot
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from stability.contact_law import Coulomb
from stability.contacts.gap_bridging import gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged
from stability.geometry.polygons import Point2, clip_line, convex_hull
from stability.geometry.polyhedra import vector
from stability.geometry.round_distance import (
    Convex,
    PlacedRound,
    face_normals,
    gaps,
    placed_round,
    side_normals,
    widest_gap,
)
from stability.geometry.round_patch import Disc, RoundPatch, smallest_discs
from stability.geometry.round_solid import RoundSolid
from stability.geometry.rows import Array
from stability.geometry.vectors import body_axes
from stability.model import BodyId, Plane, Pose, Vec3
from stability.problem import Contact, RollingWay

if TYPE_CHECKING:
    from stability.contacts.hull_contacts import HullSolid

LEVEL = 1e-12  # vertical component of a unit normal below which it is horizontal: rounding
SLACK = 1e-6  # share of a length: offsets of features that meet, and widths of patches that are lines
EXACT = 1e-9  # the same, for the ends of lines
A_LINE = 2  # points
ASKEW = 0.9  # largest cosine of two directions that span a plane
SAME_WAY = 0.999  # cosine above which two directions of rolling count as one
BENT = 0.5  # cosine to a direction of curvature above which a surface counts as curved


@dataclass(frozen=True, slots=True, eq=False)
class RoundBody:
    """Round solid at a pose, prepared for contact detection."""

    id: BodyId
    pose: Pose
    placed: PlacedRound

    @property
    def low_W(self) -> Vec3:
        """The lowest corner of the bounding box [m]."""
        return self.placed.low_W

    @property
    def high_W(self) -> Vec3:
        """The highest corner of the bounding box [m]."""
        return self.placed.high_W

    @property
    def shortest(self) -> float:
        """The least thickness [m]."""
        return self.placed.thickness

    @property
    def longest(self) -> float:
        """The longest side of the box around the solid along its body axes [m]."""
        return self.placed.length

    @property
    def corners_W(self) -> tuple[Vec3, ...]:
        """The corners of the drawn polyhedron [m]."""
        turned = np.array(self.placed.solid.corners) @ np.array(self.placed.axes_W)
        return tuple(vector(row) for row in turned + np.array(self.pose.position_W))

    def extent(self, direction_W: Vec3) -> float:
        """Return the extent along a unit direction, from the centre of mass [m]."""
        return float(self.placed.extents(np.array([direction_W]))[0])


Meeting: TypeAlias = "RoundBody | HullSolid"


def round_body(name: BodyId, solid: RoundSolid, pose: Pose) -> RoundBody:
    """Prepare a round solid at a pose for contact detection."""
    return RoundBody(name, pose, placed_round(solid, pose.position_W, body_axes(pose.orientation)))


# Features: the parts of two bodies that are nearest to each other, in a plane perpendicular to their common normal.


@dataclass(frozen=True, slots=True, eq=False)
class _Plane:
    """Frame of a contact: two axes perpendicular to its normal, from the centre of mass of the lower body."""

    origin_W: Array  # (3,) [m]
    axes_W: Array  # (3, 3): x, y and the normal, from the lower body towards the upper one

    def flat(self, points: Array) -> list[Point2]:
        """Return the coordinates in the plane of points, from the origin in W."""
        return [(x, y) for x, y in (points @ self.axes_W[:2].T).tolist()]


@dataclass(frozen=True, slots=True, eq=False)
class _Feature:
    """Part of a surface that is farthest along a normal; without corners and disc, it is a whole plane."""

    height: tuple[float, float, float]  # of its plane above the origin along the normal, and its rise along x and y
    corners: Sequence[Point2] = ()  # of a point, a line, or a polygon in order
    disc: Disc | None = None
    centre: Array | None = None  # of curvature, from the origin in W [m]
    curved: tuple[Array, ...] = ()  # unit directions of curvature

    @property
    def is_flat(self) -> bool:
        """True if it has an area."""
        return self.disc is not None or not 0 < len(self.corners) <= A_LINE

    def height_at(self, point: Point2) -> float:
        """Return its height above the origin over a point of the plane [m]."""
        at, along_x, along_y = self.height
        return at + along_x * point[0] + along_y * point[1]


def round_contact(a: Meeting, b: Meeting, friction: float, reach: float, within: float) -> Contact | None:
    """Return the contact of two bodies, of which a is first by name and one is round; None if they do not touch."""
    of_a, of_b = _convex(a), _convex(b)
    p_AB = np.array(b.pose.position_W) - np.array(a.pose.position_W)
    gap, normal = widest_gap(of_a, of_b, p_AB)
    widest = gap_bridged(reach, float(normal[2]), within)
    if not -reach <= gap <= widest or flush(a, b, NO_GAP * reach):
        return None
    lower, upper = a, b
    if normal[2] < -LEVEL:
        lower, upper, of_a, of_b, p_AB, normal = b, a, of_b, of_a, -p_AB, -normal
    plane = _plane(lower.pose.position_W, normal)
    for rise in (reach, EXACT * min(of_a.length, of_b.length)):
        features = _feature(of_a, np.zeros(3), plane, 1.0, rise), _feature(of_b, p_AB, plane, -1.0, rise)
        contact = _contact(lower.id, upper.id, features, plane, friction, reach, widest, min(a.longest, b.longest))
        if contact is not None:
            return contact
    return None


def round_on_plane(body: RoundBody, plane: Plane, friction: float, reach: float, widest: float) -> Contact | None:
    """Return the contact of a round body with a fixed half-space, which counts as the lower body."""
    up = np.array(plane.normal_W)
    height = float((np.array(body.pose.position_W) - np.array(plane.point_W)) @ up)
    gap = height - float(body.placed.extents(-up[None, :])[0])
    if not -reach <= gap <= widest:
        return None
    frame = _plane(body.pose.position_W, up)
    for rise in (widest - gap, EXACT * body.longest):
        features = _Feature((-height, 0.0, 0.0)), _feature(body.placed, np.zeros(3), frame, -1.0, rise)
        contact = _contact(plane.id, body.id, features, frame, friction, reach, widest, body.longest)
        if contact is not None:
            return contact
    return None


def flush(a: Meeting, b: Meeting, overlap: float) -> bool:
    """Check that two touching bodies, one of them round, transfer no force, as each can move past the other."""
    of_a, of_b = _convex(a), _convex(b)
    p_AB = np.array(b.pose.position_W) - np.array(a.pose.position_W)
    normals = np.concatenate([*face_normals(of_a, of_b), side_normals(of_a, of_b, p_AB)])
    values = gaps(of_a, of_b, p_AB, normals)
    near = values >= -overlap
    return run_flush(zip(values[near].tolist(), map(vector, normals[near]), strict=True), overlap)


def _convex(body: Meeting) -> Convex:
    return body.placed if isinstance(body, RoundBody) else body.hull


def _plane(origin_W: Vec3, normal: Array) -> _Plane:
    first = np.identity(3)[0 if abs(normal[0]) < ASKEW else 1]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return _Plane(np.array(origin_W), np.stack([first, np.cross(normal, first), normal]))


def _feature(body: Convex, p_OB: Array, plane: _Plane, sign: float, rise: float) -> _Feature:
    """Return the feature of a body at `p_OB` from the origin, with all points up to `rise` [m] from the farthest one.

    `sign` is 1 for the lower body, whose highest feature counts, and -1 for the upper one.
    """
    normal = sign * plane.axes_W[2]
    if isinstance(body, PlacedRound):
        return _round_feature(body, p_OB, plane, normal, rise)
    heights = body.corners @ normal
    near = body.corners[heights >= heights.max() - rise] + p_OB
    corners: Sequence[Point2] = plane.flat(near)
    if len(near) > A_LINE:
        corners = convex_hull(corners)
        fit = np.column_stack([np.ones(len(near)), np.array(plane.flat(near))])
        (at, along_x, along_y), *_ = np.linalg.lstsq(fit, near @ plane.axes_W[2], rcond=None)
        return _Feature((float(at), float(along_x), float(along_y)), corners)
    return _Feature(_line_height(near, plane), corners)


def _line_height(ends: Array, plane: _Plane) -> tuple[float, float, float]:
    """Return the height of a point or a line and its rise along x and y."""
    heights = ends @ plane.axes_W[2]
    if len(ends) < A_LINE:
        return (float(heights[0]), 0.0, 0.0)
    (ax, ay), (bx, by) = plane.flat(ends)
    dx, dy = bx - ax, by - ay
    slope = float(heights[1] - heights[0]) / (dx * dx + dy * dy)
    return (float(heights[0]) - slope * (ax * dx + ay * dy), slope * dx, slope * dy)


def _round_feature(body: PlacedRound, p_OB: Array, plane: _Plane, normal: Array, rise: float) -> _Feature:
    solid = body.solid
    along = float(normal @ body.axis)
    radial = normal - along * body.axis
    across = float(np.linalg.norm(radial))
    upper = along > 0.0
    if solid.radii[upper] and 2.0 * solid.radii[upper] * across <= rise and not solid.rounding:
        centre = body.end(upper) + p_OB
        ((x, y),) = plane.flat(centre[None, :])
        own = plane.axes_W @ body.axis
        slope_x, slope_y = float(-own[0] / own[2]), float(-own[1] / own[2])
        height = float(centre @ plane.axes_W[2]) - slope_x * x - slope_y * y
        return _Feature((height, slope_x, slope_y), disc=Disc(x, y, solid.radii[upper]))
    radial = radial / across if across > 0.0 else radial
    ends = np.array([body.end(end) + solid.radii[end] * radial for end in (False, True)]) + p_OB
    ends = ends + solid.rounding * normal
    heights = ends @ normal
    near = heights >= heights.max() - rise
    if not solid.height:
        near = np.array([True, False])
    corners = ends[near]
    # The centre of curvature lies on the axis, along the normal.
    radius = float(np.array(solid.radii)[near].mean())
    bent = solid.rounding + (radius / across if radius else 0.0)
    directions: tuple[Array, ...] = ()
    if bent > 0.0:
        round_about = np.cross(body.axis, radial)
        is_ball_end = not radius and not near.all()
        directions = (plane.axes_W[0], plane.axes_W[1]) if is_ball_end else (round_about,)
    centre = corners.mean(axis=0) - bent * normal
    return _Feature(_line_height(corners, plane), plane.flat(corners), None, centre, directions)


# Meeting of two features.


def _contact(  # noqa: PLR0913, PLR0917 -- two bodies, their features, and the limits of contacts
    lower: BodyId,
    upper: BodyId,
    features: tuple[_Feature, _Feature],
    plane: _Plane,
    friction: float,
    reach: float,
    widest: float,
    size: float,
) -> Contact | None:
    """Return the contact of two features; None if they do not meet, or if a gap is wider than `widest` [m]."""
    below, above = features
    law, normal = Coulomb(friction), vector(plane.axes_W[2])

    def gap_at(point: Point2) -> float:
        return above.height_at(point) - below.height_at(point)

    if below.is_flat and above.is_flat:
        patch = _patch(below, above, plane)
        points: Sequence[Point2] = patch.inner
        if len(points) > A_LINE and _width(points) > SLACK * size:
            gap = gaps_of([gap_at(point) for point in points], reach)
            if max(gap, default=0.0) > widest:
                return None
            placed = patch.placed(patch.inner)
            return Contact(lower, upper, placed, (normal,), law, gap, patch=patch if any(patch.arcs) else None)
    else:
        points = _met(below, above, SLACK * size)
    if not points:
        return None
    points = _ends(points, SLACK * size)
    gap = gaps_of([gap_at(point) for point in points], reach)
    if max(gap, default=0.0) > widest:
        return None
    rows = np.array([(x, y, below.height_at((x, y))) for x, y in points]) @ plane.axes_W
    rolling = _rolling(below, above, rows.mean(axis=0), plane)
    return Contact(lower, upper, tuple(map(vector, rows + plane.origin_W)), (normal,), law, gap, rolling=rolling)


def _patch(below: _Feature, above: _Feature, plane: _Plane) -> RoundPatch:
    """Return the common part of two flat features, one of which is a disc."""
    discs = [feature.disc for feature in (below, above) if feature.disc is not None]
    polygon = next((tuple(feature.corners) for feature in (below, above) if feature.corners), ())
    middle = discs[0]
    (at, x, y), (low, low_x, low_y) = above.height, below.height
    height = below.height_at((middle.x, middle.y))
    origin = plane.origin_W + height * plane.axes_W[2]
    kept = smallest_discs(discs, EXACT * middle.radius)
    axes = vector(plane.axes_W[0]), vector(plane.axes_W[1])
    return RoundPatch(vector(origin), axes, kept, polygon, (), (at - low, x - low_x, y - low_y))


def _met(below: _Feature, above: _Feature, slack: float) -> Sequence[Point2]:
    """Return the common points of two features of which one is a point or a line, up to `slack` [m]."""
    thin, other = (below, above) if not below.is_flat else (above, below)
    if len(thin.corners) > len(other.corners) > 0:
        thin, other = other, thin
    points: Sequence[Point2] = thin.corners
    if other.disc is not None:
        return _in_disc(points, other.disc, slack)
    if not other.corners:
        return points
    if len(other.corners) > A_LINE:
        return clip_line(points, tuple(other.corners), slack)
    if len(points) == len(other.corners) == A_LINE:
        return _of_lines(points, other.corners, slack)
    return points


def _in_disc(points: Sequence[Point2], disc: Disc, slack: float) -> Sequence[Point2]:
    """Return the part of a point or a line in a disc."""
    (ax, ay), (bx, by) = points[0], points[-1]
    length = dist(points[0], points[-1])
    dx, dy = ((bx - ax) / length, (by - ay) / length) if length > 0.0 else (1.0, 0.0)
    foot = (disc.x - ax) * dx + (disc.y - ay) * dy
    off = abs((disc.x - ax) * dy - (disc.y - ay) * dx)
    if off > disc.radius + slack:
        return ()
    half = max(0.0, disc.radius**2 - off**2) ** 0.5
    start, end = max(0.0, foot - half), min(length, foot + half)
    if start > end + slack:
        return ()
    return [(ax + start * dx, ay + start * dy), (ax + end * dx, ay + end * dy)]


def _of_lines(one: Sequence[Point2], other: Sequence[Point2], slack: float) -> Sequence[Point2]:
    """Return the common part of two lines: a line if they are parallel up to `slack` [m], else their crossing."""
    (ax, ay), (bx, by) = one
    length = dist(*one)
    dx, dy = (bx - ax) / length, (by - ay) / length
    along = [(x - ax) * dx + (y - ay) * dy for x, y in other]
    across = [dx * (y - ay) - dy * (x - ax) for x, y in other]
    if abs(across[1] - across[0]) <= slack:
        start, end = max(0.0, min(along)), min(length, max(along))
        if start > end + slack or abs(across[0]) > slack:
            return ()
        return [(ax + start * dx, ay + start * dy), (ax + end * dx, ay + end * dy)]
    part = across[0] / (across[0] - across[1])
    at = along[0] + part * (along[1] - along[0])
    return [(ax + at * dx, ay + at * dy)]


def _ends(points: Sequence[Point2], slack: float) -> Sequence[Point2]:
    """Return the two farthest of some points, or their middle if all are close together."""
    start, end = max(((a, b) for a in points for b in points), key=lambda pair: dist(*pair))
    if dist(start, end) > slack:
        return [start, end]
    return [(sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points))]


def _width(points: Sequence[Point2]) -> float:
    """Return the least width of a convex polygon [m]."""
    return min(
        max(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) for x, y in points) / hypot(bx - ax, by - ay)
        for (ax, ay), (bx, by) in zip(points, (*points[1:], points[0]), strict=True)
    )


def _rolling(below: _Feature, above: _Feature, at: Array, plane: _Plane) -> tuple[RollingWay, ...]:
    """Return the ways in which the upper body can roll on the lower one at a contact, `at` from the origin [m]."""
    found = sorted((each for each in (below, above) if each.curved), key=lambda each: len(each.curved))
    ways: list[Array] = []
    for feature in found:
        for direction in _crossed(ways, feature.curved, plane):
            if all(abs(float(direction @ way)) < SAME_WAY for way in ways):
                ways.append(direction)
    return tuple(
        RollingWay(
            vector(way),
            vector(_centre(below, way, at) + plane.origin_W),
            vector(_centre(above, way, at) + plane.origin_W),
        )
        for way in ways
    )


def _crossed(ways: Sequence[Array], curved: tuple[Array, ...], plane: _Plane) -> tuple[Array, ...]:
    """Return the directions of a surface that is curved in all directions, along and across a known one."""
    if len(ways) == 1 and len(curved) > 1:
        return (np.cross(plane.axes_W[2], ways[0]),)
    return curved


def _centre(feature: _Feature, way: Array, at: Array) -> Array:
    """Return the point of a body that a contact follows: its centre of curvature along a direction, or the contact."""
    if feature.centre is None or not any(abs(float(way @ each)) > BENT for each in feature.curved):
        return at
    # Of a line the centre beside the middle of the contact.
    return feature.centre
