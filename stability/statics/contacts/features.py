"""Where edges and corners of two boxes touch: an edge or a corner on a face, edges that cross or meet, corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist

from stability.geometry.clipping import within_rectangle
from stability.geometry.vectors import add_scaled, cross, dot, scale, subtract
from stability.model import Vec3
from stability.statics.contacts.axes import Axis, gap_along
from stability.statics.contacts.faces import Face, Slack
from stability.statics.contacts.normal_cones import Feature, common_normals
from stability.statics.contacts.solids import BoxSolid

MERGING = 4.0  # a line of contact shorter than this many times the slack is a point


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where body a and body b touch along a line or in a point."""

    points_W: tuple[Vec3, ...]  # [m]
    heights: tuple[float, ...]  # of the one body above the other at each [m]
    normals_AB_W: tuple[Vec3, ...]  # the extreme ones, unit

    def gaps_beside(self, gap: float) -> tuple[float, ...]:
        """How far the bodies are apart at each point [m], if they are that far apart along some other direction."""
        return tuple(max(height, gap) for height in self.heights)


@dataclass(frozen=True, slots=True)
class _Locus:
    points: tuple[Vec3, ...]  # in W, from the centre of the first body [m]
    heights: tuple[float, ...]  # of the one body above the other at each [m]
    of_first: Feature
    of_second: Feature


def meeting(a: BoxSolid, b: BoxSolid, axis: Axis, slack: Slack) -> Meeting | None:
    """How the boxes touch along a separating axis; None if their features along it do not face each other."""
    p_AB, normal = subtract(b.pose.position_W, a.pose.position_W), axis.normal_AB_W
    rise, widest = slack.rise(axis.gap), slack.widest(normal)
    if axis.of_b is None and axis.of_a is not None:
        found = _on_face(Face.towards(normal, a, axis.of_a), b, p_AB, slack.sideways, rise, widest)
    elif axis.of_a is None and axis.of_b is not None:
        face = Face.towards(scale(-1.0, normal), b, axis.of_b)
        found = _swapped(_on_face(face, a, scale(-1.0, p_AB), slack.sideways, rise, widest), p_AB)
    else:
        found = _crossing(a, b, axis, slack.sideways)
    if found is None:
        return None
    normals = common_normals(a, found.of_first, b, found.of_second, len(found.points) > 1)
    # Features coincide up to the slack only. A normal along which the bodies are further apart is not theirs: it would
    # let a brick rest on an edge that it just misses.
    touching = tuple(each for each in normals if axis.gap - slack.off <= gap_along(each, a, b) <= slack.widest(each))
    points = tuple(add_scaled(a.pose.position_W, 1.0, point) for point in found.points)
    return Meeting(points, found.heights, touching or (normal,))


def _swapped(locus: _Locus | None, p_AB: Vec3) -> _Locus | None:
    if locus is None:
        return None
    points = tuple(add_scaled(point, 1.0, p_AB) for point in locus.points)
    return _Locus(points, locus.heights, locus.of_second, locus.of_first)


def _on_face(face: Face, other: BoxSolid, p_O: Vec3, slack: float, rise: float, widest: float) -> _Locus | None:  # noqa: PLR0913, PLR0917 -- a place, and what counts as on it
    """The lowest feature of `other`, whose centre is at `p_O` from that of the face's body, on the face.

    Of that feature, the corners of what is over the face that are no more than `widest` above it [m].
    """
    on, normal = face.body, face.normal_W
    first, second = (face.axis + 1) % 3, (face.axis + 2) % 3
    u, v = on.axes[first], on.axes[second]
    lowest = _lowest(other, normal, rise)
    vertices = [add_scaled(p_O, 1.0, vertex) for vertex in _vertices(other, lowest)]
    seen = [(dot(vertex, u), dot(vertex, v), dot(vertex, normal) - on.half[face.axis]) for vertex in vertices]
    place = _within(seen, on.half[first], on.half[second], slack, widest)
    if not place:
        return None
    points = tuple(add_scaled(add_scaled(scale(on.half[face.axis], normal), x, u), y, v) for x, y, _ in place)
    signs = [0.0, 0.0, 0.0]
    signs[face.axis] = face.sign
    of_on = _completed(on, (signs[0], signs[1], signs[2]), points, slack)
    from_other = [subtract(point, p_O) for point in points]
    return _Locus(points, tuple(height for _, _, height in place), of_on, _completed(other, lowest, from_other, slack))


def _lowest(body: BoxSolid, up: Vec3, rise: float) -> Feature:
    """The feature of a box that is lowest: axes along which it rises by less than `rise` lie in it."""
    signs = []
    for axis, half in zip(body.axes, body.half, strict=True):
        slope = dot(axis, up)
        signs.append(0.0 if 2.0 * half * abs(slope) <= rise else (-1.0 if slope > 0.0 else 1.0))
    return (signs[0], signs[1], signs[2])


def _vertices(body: BoxSolid, feature: Feature) -> list[Vec3]:
    """The corners of a feature in order, from the centre of the body, in W [m]."""
    points: list[Vec3] = [(0.0, 0.0, 0.0)]
    for sign, half, axis in zip(feature, body.half, body.axes, strict=True):
        if sign:
            points = [add_scaled(point, sign * half, axis) for point in points]
        else:
            one_side = [add_scaled(point, -half, axis) for point in points]
            points = one_side + [add_scaled(point, half, axis) for point in reversed(points)]
    return points


def _within(vertices: list[Vec3], half_x: float, half_y: float, slack: float, widest: float) -> Sequence[Vec3]:
    """The part of a feature on a face: one point, the two ends of a line, or nothing."""
    wider = no_higher(within_rectangle(vertices, half_x + slack, half_y + slack), widest)
    if not wider:
        return ()
    clamped: Sequence[Vec3] = [_clamped(point, half_x, half_y) for point in wider]
    if len(vertices) == 2 and not _along_border(wider, half_x, half_y, slack):  # noqa: PLR2004 -- an edge has two ends
        exact = no_higher(within_rectangle(vertices, half_x, half_y), widest)
        clamped = exact if len(exact) > 1 else clamped
    return line_or_point(clamped, slack)


def no_higher(corners: Sequence[Vec3], widest: float) -> Sequence[Vec3]:
    """Those of some corners over a face, as (x, y, height above it), whose gap counts as contact."""
    return [corner for corner in corners if corner[2] <= widest]


def line_or_point(corners: Sequence[Vec3], slack: float) -> Sequence[Vec3]:
    """The two corners over a face that are furthest apart; one in the middle of all if that is next to nothing."""
    ends = max(((one, other) for one in corners for other in corners), key=lambda pair: dist(pair[0][:2], pair[1][:2]))
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
    """The feature that holds these points: a smaller one than is known, where they all lie on its border."""
    signs = list(feature)
    for index, (axis, half) in enumerate(zip(body.axes, body.half, strict=True)):
        along = [dot(point, axis) for point in points]
        if not feature[index] and all(abs(half - abs(each)) <= slack for each in along) and min(along) * max(along) > 0:
            signs[index] = 1.0 if along[0] > 0.0 else -1.0
    return (signs[0], signs[1], signs[2])


def _crossing(a: BoxSolid, b: BoxSolid, axis: Axis, slack: float) -> _Locus | None:
    """The point where an edge of a and an edge of b cross; None if they pass each other."""
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
    """Where two lines along u and v come closest: distances along each from points that are `p_UV` apart [m]."""
    cosine, along_u, along_v = dot(u, v), dot(p_UV, u), dot(p_UV, v)
    across = cross(u, v)
    square = dot(across, across)  # 1 - cosine^2 would lose the small angles
    return (along_u - cosine * along_v) / square, (cosine * along_u - along_v) / square


def _edge(body: BoxSolid, index: int, normal: Vec3, sign: float) -> Feature:
    signs = [sign if dot(normal, axis) > 0.0 else -sign for axis in body.axes]
    signs[index] = 0.0
    return (signs[0], signs[1], signs[2])


def _middle(body: BoxSolid, feature: Feature) -> Vec3:
    """The middle of a feature, from the centre of the body, in W [m]."""
    point: Vec3 = (0.0, 0.0, 0.0)
    for sign, half, axis in zip(feature, body.half, body.axes, strict=True):
        point = add_scaled(point, sign * half, axis)
    return point
