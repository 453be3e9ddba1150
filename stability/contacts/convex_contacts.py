"""Contact of two convex solids, or of one and a plane: the same routine for boxes and for all other shapes.

A solid supplies its faces, edges and corners (`ConvexSolid`), and a module for each kind of solid the gaps of a pair
(`Closeness`).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist, inf, sqrt
from operator import itemgetter
from typing import NamedTuple, TypeAlias

from stability.contact_law import Coulomb
from stability.contacts.features import ConvexSolid, Face, Feature, common_normals
from stability.contacts.gap_bridging import all_bridged, gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged
from stability.geometry.polygons import doubled_area
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, scale, subtract
from stability.model import Plane, Vec3
from stability.problem import Contact

# Separating directions of two solids: touching solids have their contact along the direction of the largest gap.


# Sine of the largest angle between two faces in contact: ten times the tilts that engines leave, and the largest at
# which the gap tolerance, a fiftieth of the shortest side, can bridge a face.
NEARLY_PARALLEL = 0.02
# Sine of the largest angle between two directions that is noise: the tilts that engines leave in two bodies. A larger
# angle is part of the scene.
NOISY_TILT = 3e-3
# Ratio of the assumed displacement of a pair to the least of its gaps and tilts. Large, as the least may be small by
# chance; a pair aligned up to rounding is not affected.
NOISE_RATIO = 30.0
# Largest sideways offset of coinciding edges by noise, as a share of the gap tolerance: 0.08 mm for a plank of 7.8 mm.
# Engines leave offsets of 0.01 mm, and rotations of up to a thousandth, which move the end of a short edge by 0.05 mm.
SIDEWAYS = 0.5
LEVEL = 1e-12  # vertical component of a unit normal below which it is horizontal: rounding
MERGING = 4.0  # times the slack: a shorter contact line is a point


class SeparatingAxis(NamedTuple):
    """Direction that may separate two solids, a and b: the normal of a face, or the product of an edge of each."""

    gap: float  # [m], negative where they overlap
    normal_AB_W: Vec3  # unit, from a towards b
    of_a: int | None  # number of the face or edge of a; None for a face of b
    of_b: int | None
    sine: float = 1.0  # of the angle between the two edges


class FacePair(NamedTuple):
    """Nearly parallel faces of two solids, a and b; pairs are sorted by gap."""

    gap: float  # the larger one of both faces [m]
    of_a: int  # number of the face
    of_b: int
    is_facing: bool  # whether the faces face each other
    sine: float  # of the angle between them
    normal_AB_W: Vec3  # unit normal of the face of a


@dataclass(frozen=True, slots=True, eq=False)
class Closeness(ABC):
    """Gaps of two solids that touch or overlap.

    Directions with gaps far below the largest one may be left out, as they matter to no contact.
    """

    a: ConvexSolid
    b: ConvexSolid
    p_AB: Vec3  # between their centres [m]
    gap: float  # largest of all directions [m]
    face_axes: Sequence[SeparatingAxis]  # of a, then of b
    edge_axes: Sequence[SeparatingAxis]

    @abstractmethod
    def parallel_faces(self) -> Sequence[FacePair]:
        """Return the pairs of nearly parallel faces."""

    def separations(self) -> Iterator[tuple[float, Vec3]]:
        """Yield the gap [m] and the normal of each face and each pair of crossing edges.

        Edges that are parallel up to noise are left out, as noise determines their product.
        """
        yield from self.faces()
        yield from [(axis.gap, axis.normal_AB_W) for axis in self.edge_axes if axis.sine > NOISY_TILT]

    def faces(self) -> Sequence[tuple[float, Vec3]]:
        """Return the gap [m] and the normal from a to b of each face."""
        return [(axis.gap, axis.normal_AB_W) for axis in self.face_axes]

    def gap_along(self, normal_AB_W: Vec3) -> float:
        """Return the gap along a unit direction from a to b [m]."""
        return dot(self.p_AB, normal_AB_W) - self.a.extent(normal_AB_W) - self.b.extent(scale(-1.0, normal_AB_W))


@dataclass(frozen=True, slots=True)
class Slack:
    """Tolerances of a contact [m]."""

    sideways: float  # features with a smaller offset coincide
    off: float  # displacement of the two bodies: tolerance of vertices above the lowest one, and of gaps
    reach: float  # largest gap or overlap of a contact
    within: float  # largest gap of a contact, independent of the reach

    def rise(self, gap: float) -> float:
        """Return the tolerance of the lowest feature's vertices above the lowest one, which is `gap` above a face."""
        return min(self.off, max(self.sideways, self.reach - gap))

    def largest_gap(self, normal_W: Vec3) -> float:
        """Return the largest gap of a contact along a normal."""
        return gap_bridged(self.reach, normal_W[2], self.within)


def convex_contact(close: Closeness, friction: float, reach: float, within: float) -> Contact | None:
    """Return the contact of two solids, of which a is first by name; None if they do not touch."""
    if run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.separations(), reach, within):
        return None
    pairs, exact = close.parallel_faces(), rounding(close.a, close.b)
    off = _disturbance(close, pairs, reach)
    slack = Slack(min(off, SIDEWAYS * reach) + exact, off + exact, reach, within)
    law = Coulomb(friction)
    return (
        _face_on_face(close, pairs, slack, law, exact)
        or _best_feature_contact(close, slack, law)
        # Try again with larger tolerances, as a gap of the largest size displaces edges further.
        or _best_feature_contact(close, Slack(reach, reach, reach, within), law)
    )


def rounding(a: ConvexSolid, b: ConvexSolid) -> float:
    """Return the rounding error of the distance of two bodies [m], from their sizes and positions."""
    (ax, ay, az), (bx, by, bz) = a.pose.position_W, b.pose.position_W
    far = sqrt(ax * ax + ay * ay + az * az) + sqrt(bx * bx + by * by + bz * bz)
    return 1e-12 * min(a.longest, b.longest) + 1e-15 * (far + max(a.longest, b.longest))


def _disturbance(close: Closeness, pairs: Sequence[FacePair], reach: float) -> float:
    """Estimate how far noise displaced two solids from their ideal poses [m], from the pair alone, at most `reach`.

    In written scenes bodies touch and align up to rounding. A settled pair has gaps and tilts in all directions, so
    the least of them is the estimate, as a single one may be part of the scene. Two bodies with only one common
    direction that are not apart along it, such as planks that lean on each other, have no common faces with an
    intended small offset: there the estimate is `reach`, so that edges meet edges.
    """
    aligned = [pair for pair in pairs if pair.sine <= NOISY_TILT]
    common = aligned[0].normal_AB_W if aligned else None
    if (
        common
        and all(norm(cross(common, pair.normal_AB_W)) <= NOISY_TILT for pair in aligned[1:])
        and close.gap_along(common) < -reach
        and close.gap_along(scale(-1.0, common)) < -reach
    ):
        return reach
    gaps = [abs(axis.gap) for axis in close.face_axes if abs(axis.gap) <= reach]
    tilt = min([pair.sine for pair in aligned], default=0.0)
    longest = max(close.a.longest, close.b.longest)
    return min(reach, NOISE_RATIO * (min([abs(close.gap), *gaps]) + tilt * longest))


# Face contacts: nearly parallel faces with a small gap at every corner of their overlap.
#
# Faces with a larger gap at a corner have only edge and corner contacts: the strip of two faces at an angle of a degree
# within which the gap is small would support a brick that tips over an edge.


def _face_on_face(
    close: Closeness, pairs: Sequence[FacePair], slack: Slack, law: Coulomb, exact: float
) -> Contact | None:
    """Return the contact of two faces with a small gap all over; None if none is wider than `slack.sideways`."""
    for pair in sorted(pairs, reverse=True):
        if pair.is_facing:
            of_a = close.a.face(pair.of_a, pair.normal_AB_W)
            of_b = close.b.face(pair.of_b, scale(-1.0, pair.normal_AB_W))
            lower, upper, normal = _in_order(of_a, of_b)
            p_LU = subtract(upper.body.pose.position_W, lower.body.pose.position_W)
            corners = lower.outline.clipped(lower.seen(upper.placed(upper.outline.corners, p_LU)))
            if corners and _is_face_contact(corners, normal, slack):
                points, heights = _in_world(lower, corners, exact)
                return Contact(lower.body.id, upper.body.id, points, (normal,), law, gaps_of(heights, slack.reach))
    return None


def _is_face_contact(corners: Sequence[Vec3], normal_W: Vec3, slack: Slack) -> bool:
    """Check that an overlap with a face, as (x, y, height above it), is in contact all over, and no line."""
    largest_gap = slack.largest_gap(normal_W)
    return all(-slack.reach <= height <= largest_gap for _, _, height in corners) and _width(corners) > slack.sideways


def _in_order(of_a: Face, of_b: Face) -> tuple[Face, Face, Vec3]:
    """Return the lower face, the upper one, and the normal of the lower one; a is first by name."""
    up_a, up_b = of_a.normal_W, of_b.normal_W
    if up_a[2] >= -LEVEL:
        return of_a, of_b, up_a
    if up_b[2] > LEVEL:
        return of_b, of_a, up_b
    # Both normals point down by noise: two vertical sides.
    return of_a, of_b, scale(-1.0, up_b)


def _width(corners: Sequence[Vec3]) -> float:
    """Return the least width of a convex polygon in its first two coordinates [m]."""
    flat = [(x, y) for x, y, _ in corners]
    narrowest = inf
    for (ax, ay), (bx, by) in pairwise([*flat, *flat[:1]]):
        length = dist((ax, ay), (bx, by))
        if length > 0.0:
            reach = max(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) for x, y in flat) / length
            narrowest = min(narrowest, reach)
    return narrowest if narrowest < inf else 0.0


def _in_world(on: Face, corners: Sequence[Vec3], slack: float) -> tuple[tuple[Vec3, ...], tuple[float, ...]]:
    """Return the distinct corners in W, on the face, counter-clockwise seen from outside, and their heights [m]."""
    area, _ = doubled_area([(x, y) for x, y, _ in corners])
    points: list[Vec3] = []
    heights: list[float] = []
    corners = corners if (area > 0.0) == on.is_right_handed else corners[::-1]
    for local, (_, _, height) in zip(on.placed(corners), corners, strict=True):
        if not any(dist(local, other) <= slack for other in points):
            points.append(local)
            heights.append(height)
    return tuple(add(on.body.pose.position_W, local) for local in points), tuple(heights)


# Edge and corner contacts: on a face, edge on edge, or corner on corner.


@dataclass(frozen=True, slots=True)
class _Locus:
    """Place where two features touch."""

    points: Sequence[Vec3]  # in W, from the centre of the first body [m]
    heights: Sequence[float]  # of one body above the other at each point [m]
    of_first: Feature
    of_second: Feature


def _best_feature_contact(close: Closeness, slack: Slack, law: Coulomb) -> Contact | None:
    """Return the contact along the axis of the largest gap with features that face each other; faces win near ties."""
    sideways = slack.sideways
    axes = [(axis.gap + sideways, axis) for axis in close.face_axes]
    axes += [(axis.gap, axis) for axis in close.edge_axes]
    for _, axis in sorted(axes, key=itemgetter(0), reverse=True):
        if axis.gap >= close.gap - 2.0 * sideways and axis.gap >= -slack.reach:
            contact = _feature_contact(close, axis, slack, law)
            if contact:
                return contact
    return None


def _feature_contact(close: Closeness, axis: SeparatingAxis, slack: Slack, law: Coulomb) -> Contact | None:
    """Return the contact of two solids along a separating axis; None if their features do not face each other."""
    a, b, p_AB, towards = close.a, close.b, close.p_AB, axis.normal_AB_W
    locus: _Locus | None
    if axis.of_b is None and axis.of_a is not None:
        locus = _on_face(a.face(axis.of_a, towards), b, p_AB, slack, axis.gap)
    elif axis.of_a is None and axis.of_b is not None:
        face = b.face(axis.of_b, scale(-1.0, towards))
        locus = _swapped(_on_face(face, a, scale(-1.0, p_AB), slack, axis.gap), p_AB)
    else:
        locus = _crossing(close, axis, slack.sideways)
    if locus is None:
        return None
    normals = common_normals(locus.of_first, locus.of_second, len(locus.points) > 1)
    # Features coincide only up to the slack. A normal with a larger gap is left out: it would let a brick rest on an
    # edge that it just misses.
    normals = tuple(
        normal for normal in normals if axis.gap - slack.off <= close.gap_along(normal) <= slack.largest_gap(normal)
    ) or (towards,)
    points = tuple(add(a.pose.position_W, point) for point in locus.points)
    gaps = gaps_of([max(height, close.gap) for height in locus.heights], slack.reach)
    if sum(normal[2] for normal in normals) >= -LEVEL:
        return Contact(a.id, b.id, points, normals, law, gaps)
    return Contact(b.id, a.id, points, tuple(scale(-1.0, normal) for normal in normals), law, gaps)


def _swapped(locus: _Locus | None, p_AB: Vec3) -> _Locus | None:
    if locus is None:
        return None
    points = [add(point, p_AB) for point in locus.points]
    return _Locus(points, locus.heights, locus.of_second, locus.of_first)


def _on_face(on: Face, other: ConvexSolid, p_O: Vec3, slack: Slack, gap: float) -> _Locus | None:
    """Return the contact of a face with the lowest feature of `other`, whose centre is at `p_O` from the face's body.

    Its points are the corners of the feature's part over the face.
    """
    lowest, corners = other.lowest(on, p_O, slack.rise(gap))
    in_face = _within(corners, on, slack.sideways, slack.largest_gap(on.normal_W))
    if not in_face:
        return None
    points = on.placed(in_face)
    of_on = on.feature.containing(points, on.normal_W, slack.sideways)
    of_other = lowest.containing([subtract(point, p_O) for point in points], on.normal_W, slack.sideways)
    return _Locus(points, [height for _, _, height in in_face], of_on, of_other)


def _within(corners: Sequence[Vec3], on: Face, slack: float, widest: float) -> Sequence[Vec3]:
    """Return the part of a feature on a face: a point, the two ends of a line, or nothing.

    `corners` are those of the feature as (x, y, height above the face), `widest` is the largest gap [m].
    """
    wider = _no_higher(on.outline.clipped(corners, slack), widest)
    if not wider:
        return ()
    clamped: Sequence[Vec3] = [on.outline.clamped(point) for point in wider]
    if len(corners) == 2 and not on.outline.has_on_border(wider, slack):  # noqa: PLR2004 -- an edge has two ends
        exact = _no_higher(on.outline.clipped(corners), widest)
        clamped = exact if len(exact) > 1 else clamped
    return _line_or_point(clamped, slack)


def _no_higher(corners: Sequence[Vec3], widest: float) -> Sequence[Vec3]:
    return [corner for corner in corners if corner[2] <= widest]


def _line_or_point(corners: Sequence[Vec3], slack: float) -> Sequence[Vec3]:
    """Return the two corners over a face that are farthest apart; their mean if all are close together."""
    ends = max(((start, end) for start in corners for end in corners), key=lambda pair: dist(pair[0][:2], pair[1][:2]))
    if dist(ends[0][:2], ends[1][:2]) > MERGING * slack:
        return ends
    x, y = (sum(point[i] for point in corners) / len(corners) for i in range(2))
    return ((x, y, max(point[2] for point in corners)),)


def _crossing(close: Closeness, axis: SeparatingAxis, slack: float) -> _Locus | None:
    """Return the contact where an edge of a crosses an edge of b; None if the lines cross beyond their ends."""
    if axis.of_a is None or axis.of_b is None:
        return None
    normal, p_AB = axis.normal_AB_W, close.p_AB
    of_a, of_b = close.a.edge(axis.of_a, normal), close.b.edge(axis.of_b, scale(-1.0, normal))
    p_A, p_B = of_a.middle, add(of_b.middle, p_AB)
    along_a, along_b = _closest(of_a.direction_W, of_b.direction_W, subtract(p_B, p_A))
    if abs(along_a) > of_a.half + slack or abs(along_b) > of_b.half + slack:
        return None
    on_a, on_b = add_scaled(p_A, along_a, of_a.direction_W), add_scaled(p_B, along_b, of_b.direction_W)
    at_a = of_a.feature.containing([on_a], normal, slack)
    at_b = of_b.feature.containing([subtract(on_b, p_AB)], normal, slack)
    return _Locus([scale(0.5, add(on_a, on_b))], [axis.gap], at_a, at_b)


def _closest(u: Vec3, v: Vec3, p_UV: Vec3) -> tuple[float, float]:
    """Return the nearest points of two lines along u and v, as distances from points that are `p_UV` apart [m]."""
    cosine, along_u, along_v = dot(u, v), dot(p_UV, u), dot(p_UV, v)
    across = cross(u, v)
    square = dot(across, across)  # accurate for small angles, unlike 1 - cosine^2
    return (along_u - cosine * along_v) / square, (cosine * along_u - along_v) / square


# Contact of a solid with a plane: its lowest corners.


# Points on a plane in contact with a body, and the height of the body above each [m].
PointsOnPlane: TypeAlias = tuple[tuple[Vec3, ...], tuple[float, ...]]


def points_on_plane(body: ConvexSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """Return the points of a plane that a solid touches, counter-clockwise seen from above; none without contact.

    The largest overlap of a contact is `reach` [m], the largest gap `widest` [m].
    """
    up, at = plane.normal_W, body.pose.position_W
    height = dot(subtract(at, plane.point_W), up)
    gap = height - body.extent(scale(-1.0, up))
    if gap > widest or gap < -reach:
        return (), ()
    corners = [(corner, dot(corner, up) + height) for corner in body.lowest_corners(up, widest - height)]
    low = [(corner, above) for corner, above in corners if above <= widest]
    return tuple(add_scaled(add(at, corner), -above, up) for corner, above in low), tuple(above for _, above in low)
