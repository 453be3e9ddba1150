"""Contact of two boxes, or of a box and a plane: faces, edges, corners and their normals."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, dist, hypot, inf, pi
from typing import Self, TypeAlias

from stability.contacts.bodies import BoxSolid, PlanRectangle, rounding
from stability.geometry.box_distance import (
    Matrix,
    along_product,
    coordinates,
    cosines,
    edge_products,
    face_gaps,
    gap_bridged,
    half_extent,
    transposed,
)
from stability.geometry.polygons import Polygon, cut, doubled_area, within_rectangle
from stability.geometry.vectors import add_scaled, cross, dot, norm, scale, subtract, unit
from stability.model import Plane, Vec3
from stability.problem import UP

# Separating axes of two boxes: touching bodies have their contact along the axis of the largest gap.


# Sine of the largest angle between two faces in contact: ten times the tilts that engines leave, and the largest at
# which the gap tolerance, a fiftieth of the shortest side, can bridge a face.
NEARLY_PARALLEL = 0.02
# Sine of the largest angle between two axes that is noise: the tilts that engines leave in two bodies. A larger angle
# is part of the scene.
NOISY_TILT = 3e-3
# Ratio of the assumed displacement of a pair to the least of its gaps and tilts. Large, as the least may be small by
# chance; a pair aligned up to rounding is not affected.
NOISE_RATIO = 30.0


@dataclass(frozen=True, slots=True)
class SeparatingAxis:
    """Direction that may separate two boxes, a and b."""

    gap: float  # [m], negative where they overlap
    normal_AB_W: Vec3  # unit, from a towards b
    of_a: int | None  # axis of a for a face normal of a, or edge of a in a product of edges
    of_b: int | None

    @property
    def is_face(self) -> bool:
        return self.of_a is None or self.of_b is None


@dataclass(frozen=True, slots=True)
class BoxCloseness:
    """Gaps of two boxes that touch or overlap."""

    gap: float  # largest of all axes [m]
    faces_a: Sequence[SeparatingAxis]  # by axis of a
    faces_b: Sequence[SeparatingAxis]
    edges: Sequence[SeparatingAxis]  # products of edges with nearly the largest gap
    sines: Matrix  # of the angles between the axes of a (rows) and b

    def separations(self) -> Iterator[tuple[float, Vec3]]:
        """Yield the gap [m] and the normal of each face and each pair of crossing edges.

        Edges that are parallel up to noise are left out, as noise determines their product.
        """
        for axis in (*self.faces_a, *self.faces_b, *self.edges):
            if axis.of_a is None or axis.of_b is None or self.sines[axis.of_a][axis.of_b] > NOISY_TILT:
                yield axis.gap, axis.normal_AB_W

    def faces(self) -> Iterator[tuple[float, Vec3]]:
        """Yield the gap [m] and the normal from a to b of each face that faces the other box."""
        for axis in (*self.faces_a, *self.faces_b):
            yield axis.gap, axis.normal_AB_W


def closeness(a: BoxSolid, b: BoxSolid, reach: float) -> BoxCloseness | None:
    """Compute the gaps of two boxes; None if their gap or overlap exceeds `reach` [m]."""
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    turn = cosines(a.axes, b.axes)
    along_a, along_b = coordinates(p_AB, a.axes), coordinates(p_AB, b.axes)
    gaps_a = face_gaps(along_a, a.half, b.half, turn)
    gaps_b = face_gaps(along_b, b.half, a.half, transposed(turn))
    largest = max(gaps_a + gaps_b)
    if largest > reach:
        return None
    products = []
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        products.append(((abs(along) - extent) / length, (1.0 if along >= 0.0 else -1.0) / length, i, j))
    largest = max([largest, *(gap for gap, _, _, _ in products)])
    if largest > reach or largest < -reach:
        return None
    edges = [
        SeparatingAxis(gap, scale(share, cross(a.axes[i], b.axes[j])), i, j)
        for gap, share, i, j in products
        if gap >= largest - 2.0 * reach
    ]
    faces_a = [SeparatingAxis(gaps_a[i], _towards(along_a[i], a.axes[i]), i, None) for i in range(3)]
    faces_b = [SeparatingAxis(gaps_b[j], _towards(along_b[j], b.axes[j]), None, j) for j in range(3)]
    return BoxCloseness(largest, faces_a, faces_b, edges, _sines(turn))


def _sines(turn: Matrix) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = turn
    return (
        (hypot(d, g), hypot(e, h), hypot(f, i)),
        (hypot(a, g), hypot(b, h), hypot(c, i)),
        (hypot(a, d), hypot(b, e), hypot(c, f)),
    )


def _towards(along: float, axis: Vec3) -> Vec3:
    return axis if along >= 0.0 else scale(-1.0, axis)


def gap_along(direction: Vec3, a: BoxSolid, b: BoxSolid) -> float:
    """Return the gap along a unit direction from a to b [m]."""
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    return dot(p_AB, direction) - half_extent(a.axes, a.half, direction) - half_extent(b.axes, b.half, direction)


def disturbance(close: BoxCloseness, longest: float, reach: float) -> float:
    """Estimate the displacement of two boxes from their ideal poses by noise [m], at most `reach`, from the pair alone.

    In written scenes bodies touch and align up to rounding. A settled pair has gaps and tilts in all directions, so
    the least of them is the estimate, as a single one may be part of the scene. `longest` is the longest side of both
    [m]. Two boxes with only one common direction that are apart along it, such as planks that lean on each other, have
    no common faces with an intended small offset: there the estimate is `reach`, so that edges meet edges.
    """
    common = [i for i, row in enumerate(close.sines) if min(row) <= NOISY_TILT]
    if len(common) == 1 and close.faces_a[common[0]].gap < -reach:
        return reach
    gaps = [abs(axis.gap) for axis in (*close.faces_a, *close.faces_b) if abs(axis.gap) <= reach]
    tilts = [sine for row in close.sines for sine in row if sine <= NOISY_TILT]
    return min(reach, NOISE_RATIO * (min([abs(close.gap), *gaps]) + min(tilts, default=0.0) * longest))


# Face contacts of two boxes: nearly parallel faces with a small gap at every corner of their overlap.
#
# Faces with a larger gap at a corner have only edge and corner contacts (`FeatureContact`): the strip of two faces at
# an angle of a degree within which the gap is small would support a brick that tips over an edge.


LEVEL = 1e-12  # vertical component of a unit normal below which it is horizontal: rounding


@dataclass(frozen=True, slots=True)
class BoxFace:
    """Face of a box."""

    body: BoxSolid
    axis: int
    sign: float  # of the body axis that is the outward normal

    @classmethod
    def towards(cls, direction: Vec3, body: BoxSolid, axis: int) -> Self:
        """Return the face perpendicular to an axis that faces a direction."""
        return cls(body, axis, 1.0 if dot(direction, body.axes[axis]) > 0.0 else -1.0)

    @property
    def normal_W(self) -> Vec3:
        return scale(self.sign, self.body.axes[self.axis])


@dataclass(frozen=True, slots=True)
class Patch:
    """Contact area of two bodies."""

    lower: BoxSolid
    upper: BoxSolid
    points_W: tuple[Vec3, ...]  # in order [m]
    heights: tuple[float, ...]  # of the upper body above the lower one at each point [m]
    normal_W: Vec3


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


def face_on_face(a: BoxSolid, b: BoxSolid, close: BoxCloseness, slack: Slack) -> Patch | None:
    """Return the patch of two faces with a small gap all over; None if none is wider than `slack.sideways`."""
    for of_a, of_b in _facing(a, b, close):
        lower, upper, normal = _in_order(of_a, of_b)
        corners = _overlap(lower, upper)
        if is_face_contact(corners, normal, slack):
            points, heights = _in_world(lower, corners, rounding(a, b))
            return Patch(lower.body, upper.body, points, heights, normal)
    return None


def is_face_contact(corners: Sequence[Vec3], normal_W: Vec3, slack: Slack) -> bool:
    """Check that an overlap with a face, as (x, y, height above it), is in contact all over, and no line."""
    largest_gap = slack.largest_gap(normal_W)
    return all(-slack.reach <= height <= largest_gap for _, _, height in corners) and width(corners) > slack.sideways


def _facing(a: BoxSolid, b: BoxSolid, close: BoxCloseness) -> Iterator[tuple[BoxFace, BoxFace]]:
    """Yield the pairs of nearly parallel faces that face each other, the largest gap first."""
    pairs = [
        (max(close.faces_a[i].gap, close.faces_b[j].gap), i, j)
        for i, row in enumerate(close.sines)
        for j, sine in enumerate(row)
        if sine <= NEARLY_PARALLEL
    ]
    for _, i, j in sorted(pairs, reverse=True):
        normal = close.faces_a[i].normal_AB_W
        yield BoxFace.towards(normal, a, i), BoxFace.towards(scale(-1.0, normal), b, j)


def _in_order(of_a: BoxFace, of_b: BoxFace) -> tuple[BoxFace, BoxFace, Vec3]:
    """Return the lower face, the upper one, and the normal of the lower one; a is first by name."""
    up_a, up_b = of_a.normal_W, of_b.normal_W
    if up_a[2] >= -LEVEL:
        return of_a, of_b, up_a
    if up_b[2] > LEVEL:
        return of_b, of_a, up_b
    # Both normals point down by noise: two vertical sides.
    return of_a, of_b, scale(-1.0, up_b)


def _overlap(on: BoxFace, lying: BoxFace) -> Sequence[Vec3]:
    """Return the part of the other face above the face `on`, as (x, y, height above it) in the frame of `on`."""
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
    """Return the least width of a convex polygon in its first two coordinates [m]."""
    flat = [(x, y) for x, y, _ in corners]
    narrowest = inf
    for (ax, ay), (bx, by) in pairwise([*flat, *flat[:1]]):
        length = dist((ax, ay), (bx, by))
        if length > 0.0:
            reach = max(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) for x, y in flat) / length
            narrowest = min(narrowest, reach)
    return narrowest if narrowest < inf else 0.0


def _in_world(on: BoxFace, corners: Sequence[Vec3], slack: float) -> tuple[tuple[Vec3, ...], tuple[float, ...]]:
    """Return the distinct corners in W, on the face, counter-clockwise seen from outside, and their heights [m]."""
    body = on.body
    first, second = body.axes[(on.axis + 1) % 3], body.axes[(on.axis + 2) % 3]
    area, _ = doubled_area([(x, y) for x, y, _ in corners])
    points: list[Vec3] = []
    heights: list[float] = []
    # The frame of the face is right-handed if its normal is a body axis, and left-handed for the opposite.
    for x, y, height in corners if area * on.sign > 0.0 else corners[::-1]:
        local = add_scaled(add_scaled(scale(body.half[on.axis], on.normal_W), x, first), y, second)
        if not any(dist(local, other) <= slack for other in points):
            points.append(local)
            heights.append(height)
    return tuple(add_scaled(body.pose.position_W, 1.0, local) for local in points), tuple(heights)


# Normals of two touching features.
#
# A feature of a box - face, edge or corner - is given by the signs of the body axes that point out of it, 0 for axes
# along it. Its normals form the cone of these axes. The normals of two touching features are the intersection of one
# cone with the negative of the other, given by its extreme directions.


Feature: TypeAlias = tuple[float, float, float]  # by body axis: 1, -1 or 0

# Sine of the tolerance at the border of a cone, and of the angle between equal directions.
ROUNDING = 1e-9
FACE, EDGE = 1, 2  # number of axes out of a feature


def common_normals(a: BoxSolid, of_a: Feature, b: BoxSolid, of_b: Feature, along_line: bool) -> tuple[Vec3, ...]:
    """Return the extreme unit normals, from a towards b; none if the features do not face each other.

    Edges that touch along a line count as parallel.
    """
    cone_a, cone_b = _cone(a, of_a, 1.0), _cone(b, of_b, -1.0)
    if len(cone_a) == FACE or len(cone_b) == FACE:
        return cone_a if len(cone_a) == FACE else cone_b
    if len(cone_a) == len(cone_b) == EDGE:
        return _of_parallel_edges(cone_a, cone_b) if along_line else _of_crossing_edges(cone_a, cone_b)
    return _clipped(cone_a, cone_b) if len(cone_a) == EDGE else _clipped(cone_b, cone_a)


def _cone(body: BoxSolid, feature: Feature, sign: float) -> tuple[Vec3, ...]:
    return tuple(scale(sign * out, axis) for out, axis in zip(feature, body.axes, strict=True) if out)


def _of_parallel_edges(cone_a: Sequence[Vec3], cone_b: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Intersect the cones of parallel edges, which are quarters of the plane perpendicular to the edges."""
    start, end = cone_a
    first_b, second_b = cone_b
    middle = add_scaled(first_b, 1.0, second_b)
    # Rotation of the quarter of b relative to that of a, towards its end.
    turn = atan2(dot(middle, end), dot(middle, start)) - 0.25 * pi
    turn -= 2.0 * pi * round(turn / (2.0 * pi))
    if abs(turn) < ROUNDING:
        return (start, end)
    if abs(turn) > 0.5 * pi + ROUNDING:
        return ()
    around = cross(start, end)
    first, last = (first_b, second_b) if dot(cross(first_b, second_b), around) > 0.0 else (second_b, first_b)
    return _distinct((first, end) if turn > 0.0 else (start, last))


def _of_crossing_edges(cone_a: Sequence[Vec3], cone_b: Sequence[Vec3]) -> tuple[Vec3, ...]:
    edge_a, edge_b = cross(*cone_a), cross(*cone_b)
    across = cross(edge_a, edge_b)
    if norm(across) < ROUNDING:
        return _of_parallel_edges(cone_a, cone_b)
    normal = unit(across)
    outward = dot(normal, cone_a[0]) + dot(normal, cone_a[1])
    return (normal if outward > 0.0 else scale(-1.0, normal),)


def _clipped(cone: Sequence[Vec3], corner: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Clip a cone to the cone of a corner, which three half-spaces bound."""
    normals = cone
    for axis in corner:
        normals = cut(normals, [dot(normal, axis) for normal in normals], ROUNDING, _between) if normals else ()
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


# Edge and corner contacts of two boxes: on a face, edge on edge, or corner on corner.


MERGING = 4.0  # times the slack: a shorter contact line is a point


@dataclass(frozen=True, slots=True)
class FeatureContact:
    """Contact of body a and body b along a line or at a point."""

    points_W: tuple[Vec3, ...]  # [m]
    heights: tuple[float, ...]  # of one body above the other at each point [m]
    normals_AB_W: tuple[Vec3, ...]  # extreme normals, unit

    def gaps_beside(self, gap: float) -> tuple[float, ...]:
        """Return the gaps at the points [m], at least the gap along another direction."""
        return tuple(max(height, gap) for height in self.heights)


@dataclass(frozen=True, slots=True)
class _Locus:
    points: tuple[Vec3, ...]  # in W, from the centre of the first body [m]
    heights: tuple[float, ...]  # of one body above the other at each point [m]
    of_first: Feature
    of_second: Feature


def feature_contact(a: BoxSolid, b: BoxSolid, axis: SeparatingAxis, slack: Slack) -> FeatureContact | None:
    """Return the contact of two boxes along a separating axis; None if their features do not face each other."""
    p_AB, normal = subtract(b.pose.position_W, a.pose.position_W), axis.normal_AB_W
    rise, largest_gap = slack.rise(axis.gap), slack.largest_gap(normal)
    if axis.of_b is None and axis.of_a is not None:
        locus = _on_face(BoxFace.towards(normal, a, axis.of_a), b, p_AB, slack.sideways, rise, largest_gap)
    elif axis.of_a is None and axis.of_b is not None:
        face = BoxFace.towards(scale(-1.0, normal), b, axis.of_b)
        locus = _swapped(_on_face(face, a, scale(-1.0, p_AB), slack.sideways, rise, largest_gap), p_AB)
    else:
        locus = _crossing(a, b, axis, slack.sideways)
    if locus is None:
        return None
    normals = common_normals(a, locus.of_first, b, locus.of_second, len(locus.points) > 1)
    # Features coincide only up to the slack. A normal with a larger gap is left out: it would let a brick rest on an
    # edge that it just misses.
    touching = tuple(
        candidate
        for candidate in normals
        if axis.gap - slack.off <= gap_along(candidate, a, b) <= slack.largest_gap(candidate)
    )
    points = tuple(add_scaled(a.pose.position_W, 1.0, point) for point in locus.points)
    return FeatureContact(points, locus.heights, touching or (normal,))


def _swapped(locus: _Locus | None, p_AB: Vec3) -> _Locus | None:
    if locus is None:
        return None
    points = tuple(add_scaled(point, 1.0, p_AB) for point in locus.points)
    return _Locus(points, locus.heights, locus.of_second, locus.of_first)


def _on_face(face: BoxFace, other: BoxSolid, p_O: Vec3, slack: float, rise: float, widest: float) -> _Locus | None:  # noqa: PLR0913, PLR0917 -- a position, and tolerances
    """Return the contact of a face with the lowest feature of `other`, whose centre is at `p_O` from the face's body.

    Its points are the corners of the feature's part over the face, at most `widest` [m] above it.
    """
    on, normal = face.body, face.normal_W
    first, second = (face.axis + 1) % 3, (face.axis + 2) % 3
    u, v = on.axes[first], on.axes[second]
    lowest = _lowest(other, normal, rise)
    vertices = [add_scaled(p_O, 1.0, vertex) for vertex in _vertices(other, lowest)]
    local = [(dot(vertex, u), dot(vertex, v), dot(vertex, normal) - on.half[face.axis]) for vertex in vertices]
    in_face = _within(local, on.half[first], on.half[second], slack, widest)
    if not in_face:
        return None
    points = tuple(add_scaled(add_scaled(scale(on.half[face.axis], normal), x, u), y, v) for x, y, _ in in_face)
    signs = [0.0, 0.0, 0.0]
    signs[face.axis] = face.sign
    of_on = _completed(on, (signs[0], signs[1], signs[2]), points, slack)
    from_other = [subtract(point, p_O) for point in points]
    return _Locus(
        points, tuple(height for _, _, height in in_face), of_on, _completed(other, lowest, from_other, slack)
    )


def _lowest(body: BoxSolid, up: Vec3, rise: float) -> Feature:
    """Return the lowest feature of a box, with the axes along which the box rises by less than `rise` [m]."""
    signs = []
    for axis, half in zip(body.axes, body.half, strict=True):
        slope = dot(axis, up)
        signs.append(0.0 if 2.0 * half * abs(slope) <= rise else (-1.0 if slope > 0.0 else 1.0))
    return (signs[0], signs[1], signs[2])


def _vertices(body: BoxSolid, feature: Feature) -> list[Vec3]:
    """Return the ordered corners of a feature, from the centre of the body, in W [m]."""
    points: list[Vec3] = [(0.0, 0.0, 0.0)]
    for sign, half, axis in zip(feature, body.half, body.axes, strict=True):
        if sign:
            points = [add_scaled(point, sign * half, axis) for point in points]
        else:
            one_side = [add_scaled(point, -half, axis) for point in points]
            points = one_side + [add_scaled(point, half, axis) for point in reversed(points)]
    return points


def _within(vertices: list[Vec3], half_x: float, half_y: float, slack: float, widest: float) -> Sequence[Vec3]:
    """Return the part of a feature on a face: a point, the two ends of a line, or nothing."""
    wider = no_higher(within_rectangle(vertices, half_x + slack, half_y + slack), widest)
    if not wider:
        return ()
    clamped: Sequence[Vec3] = [_clamped(point, half_x, half_y) for point in wider]
    if len(vertices) == 2 and not _along_border(wider, half_x, half_y, slack):  # noqa: PLR2004 -- an edge has two ends
        exact = no_higher(within_rectangle(vertices, half_x, half_y), widest)
        clamped = exact if len(exact) > 1 else clamped
    return line_or_point(clamped, slack)


def no_higher(corners: Sequence[Vec3], widest: float) -> Sequence[Vec3]:
    """Return the corners over a face, as (x, y, height above it), with a gap of at most `widest` [m]."""
    return [corner for corner in corners if corner[2] <= widest]


def line_or_point(corners: Sequence[Vec3], slack: float) -> Sequence[Vec3]:
    """Return the two corners over a face that are farthest apart; their mean if all are close together."""
    ends = max(((start, end) for start in corners for end in corners), key=lambda pair: dist(pair[0][:2], pair[1][:2]))
    if dist(ends[0][:2], ends[1][:2]) > MERGING * slack:
        return ends
    x, y = (sum(point[i] for point in corners) / len(corners) for i in range(2))
    return ((x, y, max(point[2] for point in corners)),)


def _clamped(point: Vec3, half_x: float, half_y: float) -> Vec3:
    return (min(half_x, max(-half_x, point[0])), min(half_y, max(-half_y, point[1])), point[2])


def _along_border(segment: Sequence[Vec3], half_x: float, half_y: float, slack: float) -> bool:
    return any(
        all(abs(abs(point[axis]) - half) <= slack for point in segment) for axis, half in ((0, half_x), (1, half_y))
    )


def _completed(body: BoxSolid, feature: Feature, points: Sequence[Vec3], slack: float) -> Feature:
    """Return the smallest feature that contains these points, such as an edge of a face with all points on it."""
    signs = list(feature)
    for index, (axis, half) in enumerate(zip(body.axes, body.half, strict=True)):
        along = [dot(point, axis) for point in points]
        if (
            not feature[index]
            and all(abs(half - abs(value)) <= slack for value in along)
            and min(along) * max(along) > 0
        ):
            signs[index] = 1.0 if along[0] > 0.0 else -1.0
    return (signs[0], signs[1], signs[2])


def _crossing(a: BoxSolid, b: BoxSolid, axis: SeparatingAxis, slack: float) -> _Locus | None:
    """Return the contact where an edge of a crosses an edge of b; None if the lines cross beyond their ends."""
    if axis.of_a is None or axis.of_b is None:
        return None
    of_a, of_b = _edge(a, axis.of_a, axis.normal_AB_W, 1.0), _edge(b, axis.of_b, axis.normal_AB_W, -1.0)
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    u, v, p_A, p_B = a.axes[axis.of_a], b.axes[axis.of_b], _middle(a, of_a), add_scaled(_middle(b, of_b), 1.0, p_AB)
    along_a, along_b = _closest(u, v, subtract(p_B, p_A))
    if abs(along_a) > a.half[axis.of_a] + slack or abs(along_b) > b.half[axis.of_b] + slack:
        return None
    on_a, on_b = add_scaled(p_A, along_a, u), add_scaled(p_B, along_b, v)
    point = scale(0.5, add_scaled(on_a, 1.0, on_b))
    of_a, of_b = _completed(a, of_a, [on_a], slack), _completed(b, of_b, [subtract(on_b, p_AB)], slack)
    return _Locus((point,), (axis.gap,), of_a, of_b)


def _closest(u: Vec3, v: Vec3, p_UV: Vec3) -> tuple[float, float]:
    """Return the nearest points of two lines along u and v, as distances from points that are `p_UV` apart [m]."""
    cosine, along_u, along_v = dot(u, v), dot(p_UV, u), dot(p_UV, v)
    across = cross(u, v)
    square = dot(across, across)  # accurate for small angles, unlike 1 - cosine^2
    return (along_u - cosine * along_v) / square, (cosine * along_u - along_v) / square


def _edge(body: BoxSolid, index: int, normal: Vec3, sign: float) -> Feature:
    signs = [sign if dot(normal, axis) > 0.0 else -sign for axis in body.axes]
    signs[index] = 0.0
    return (signs[0], signs[1], signs[2])


def _middle(body: BoxSolid, feature: Feature) -> Vec3:
    """Return the centre of a feature, from the centre of the body, in W [m]."""
    point: Vec3 = (0.0, 0.0, 0.0)
    for sign, half, axis in zip(feature, body.half, body.axes, strict=True):
        point = add_scaled(point, sign * half, axis)
    return point


# Contact of two level boxes. Most pairs are of this kind, so this code is fast.
#
# Both are rectangles in plan, in the frame of the lower one, so that precision does not depend on the position in W.


PARALLEL = 1e-12  # sine of the angle below which sides are parallel: rounding

APART: tuple[Vec3, ...] = ()

# Pose of the upper rectangle in the frame of the lower one: centre [m], cosine and sine of its rotation.
Place: TypeAlias = tuple[float, float, float, float]


def level_patch(lower: BoxSolid, upper: BoxSolid, reach: float, within: float) -> tuple[tuple[Vec3, ...], float] | None:
    """Return the corners of the patch on the top of `lower`, counter-clockwise from above, and its gap [m].

    The corners are APART if the gap is too large for a contact with this reach and `within` [m].

    None if this does not decide the contact: if the boxes touch only within `reach` of an edge, or side by side.
    """
    if lower.plan is None or upper.plan is None:
        return None
    ux, uy, _, _ = lower.plan
    (px, py, pz), (qx, qy, qz) = lower.pose.position_W, upper.pose.position_W
    dx, dy = qx - px, qy - py
    x, y = dx * ux + dy * uy, dy * ux - dx * uy
    cosine, sine = ux * upper.plan[0] + uy * upper.plan[1], ux * upper.plan[1] - uy * upper.plan[0]
    place = (x, y, cosine, sine)
    overlap = _level_overlap(place, lower.plan, upper.plan)
    if overlap < -reach:
        return APART, 0.0
    if overlap <= reach:
        return None
    gap = qz - pz - lower.rise - upper.rise
    if gap > reach or gap < -reach or (gap > within and gap > gap_bridged(reach, 1.0, within)):
        return APART, gap
    top = pz + lower.rise
    corners = _common(place, lower.plan, upper.plan)
    return tuple([(px + u * ux - v * uy, py + u * uy + v * ux, top) for u, v in corners]), gap


def side_patch(a: BoxSolid, b: BoxSolid, reach: float, within: float) -> tuple[tuple[Vec3, ...], Vec3, float] | None:
    """Return the corners of the patch on the side of `a` that faces `b`, the normal of that side, and the gap [m].

    The corners are APART if the gap is too large for a contact. None unless both boxes are level, their sides are
    parallel, and they face each other beyond the reach of their edges.
    """
    if a.plan is None or b.plan is None:
        return None
    (ux, uy, half_u, half_v), (px, py, pz), (qx, qy, qz) = a.plan, a.pose.position_W, b.pose.position_W
    vx, vy = b.plan[0], b.plan[1]
    cosine, sine = ux * vx + uy * vy, ux * vy - uy * vx
    if not (-PARALLEL <= sine <= PARALLEL or -PARALLEL <= cosine <= PARALLEL):
        return None
    other_u, other_v = (b.plan[2], b.plan[3]) if -PARALLEL <= sine <= PARALLEL else (b.plan[3], b.plan[2])
    dx, dy, dz = qx - px, qy - py, qz - pz
    x, y = dx * ux + dy * uy, dy * ux - dx * uy
    if half_u + other_u - abs(x) > half_v + other_v - abs(y):  # contact on the second side: rotate the frame
        ux, uy, x, y = -uy, ux, y, -x
        half_u, half_v, other_u, other_v = half_v, half_u, other_v, other_u
    gap = abs(x) - half_u - other_u
    if gap < -reach or half_v + other_v - abs(y) <= reach:
        return None
    if a.rise + b.rise - abs(dz) <= reach:
        return None
    sign = 1.0 if x > 0.0 else -1.0
    if gap > gap_bridged(reach, 0.0, within):
        return APART, (sign * ux, sign * uy, 0.0), gap
    left, right = max(-half_v, sign * y - other_v), min(half_v, sign * y + other_v)
    low, high = max(-a.rise, dz - b.rise), min(a.rise, dz + b.rise)
    ux, uy = sign * ux, sign * uy
    around = ((left, low), (right, low), (right, high), (left, high))
    points = tuple([(px + half_u * ux - v * uy, py + half_u * uy + v * ux, pz + w) for v, w in around])
    return points, (ux, uy, 0.0), gap


def _level_overlap(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> float:
    """Return the penetration depth of two rectangles [m]; negative if they are apart."""
    x, y, cosine, sine = place
    (_, _, a, b), (_, _, c, d) = lower, upper
    along, across = abs(cosine), abs(sine)
    least = min(a + c * along + d * across - abs(x), b + c * across + d * along - abs(y))
    if across <= PARALLEL or along <= PARALLEL:
        return least
    s, t = x * cosine + y * sine, y * cosine - x * sine
    return min(least, c + a * along + b * across - abs(s), d + a * across + b * along - abs(t))


def _common(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> Polygon:
    """Return the intersection of two rectangles, in the frame of the lower one."""
    x, y, cosine, sine = place
    (_, _, a, b), (_, _, c, d) = lower, upper
    if -PARALLEL <= sine <= PARALLEL or -PARALLEL <= cosine <= PARALLEL:
        if -PARALLEL <= cosine <= PARALLEL:
            c, d = d, c
        left, right = max(-a, x - c), min(a, x + c)
        near, far = max(-b, y - d), min(b, y + d)
        return ((left, near), (right, near), (right, far), (left, far))
    p, q, r, s = c * cosine, c * sine, d * sine, d * cosine
    turned = ((x - p + r, y - q - s), (x + p + r, y + q - s), (x + p - r, y + q + s), (x - p - r, y - q + s))
    return tuple(within_rectangle(turned, a, b))


# Contact of a box with a plane: the corners of its lowest face with a small gap.


# Points on a plane in contact with a body, and the height of the body above each [m].
PointsOnPlane: TypeAlias = tuple[tuple[Vec3, ...], tuple[float, ...]]


def points_on_plane(body: BoxSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """Return the points of a plane that a box touches, counter-clockwise seen from above; none without contact.

    The largest overlap of a contact is `reach` [m], the largest gap `widest` [m].
    """
    p_PB = subtract(body.pose.position_W, plane.point_W)
    height = dot(p_PB, plane.normal_W)
    gap = height - half_extent(body.axes, body.half, plane.normal_W)
    if gap > widest or gap < -reach:
        return (), ()
    if body.plan is not None and plane.normal_W == UP:
        points = _of_plan(body, body.pose.position_W[2] - height)
        return points, (gap,) * len(points)
    corners = [(corner, dot(corner, plane.normal_W) + height) for corner in _lowest_face(body, plane.normal_W)]
    low = [(corner, above) for corner, above in corners if above <= widest]
    at = body.pose.position_W
    points = tuple(add_scaled(add_scaled(at, 1.0, corner), -above, plane.normal_W) for corner, above in low)
    return points, tuple(above for _, above in low)


def _of_plan(body: BoxSolid, ground: float) -> tuple[Vec3, ...]:
    if body.plan is None:
        return ()
    ux, uy, a, b = body.plan
    x, y, _ = body.pose.position_W
    px, py, qx, qy = a * ux, a * uy, -b * uy, b * ux
    return (
        (x - px - qx, y - py - qy, ground),
        (x + px - qx, y + py - qy, ground),
        (x + px + qx, y + py + qy, ground),
        (x - px + qx, y - py + qy, ground),
    )


def _lowest_face(body: BoxSolid, up: Vec3) -> list[Vec3]:
    """Return the corners of the face that leans least, from the centre, in W [m]; it contains the lowest edge."""
    rises = [half * abs(dot(axis, up)) for half, axis in zip(body.half, body.axes, strict=True)]
    steepest = max(range(3), key=lambda index: rises[index])
    first, second = (steepest + 1) % 3, (steepest + 2) % 3
    down = -1.0 if dot(body.axes[steepest], up) > 0.0 else 1.0
    centre = scale(down * body.half[steepest], body.axes[steepest])
    u, v = scale(body.half[first], body.axes[first]), scale(body.half[second], body.axes[second])
    # Seen from above the plane, the second side is to the left of the first if the third axis points up.
    around = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
    corners = [add_scaled(add_scaled(centre, s, u), t, v) for s, t in around]
    return corners if down < 0.0 else corners[::-1]
