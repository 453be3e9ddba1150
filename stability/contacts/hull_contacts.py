"""Finds the contact of convex solids with each other and with planes: faces, edges, corners and their normals."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import dist, hypot
from operator import itemgetter
from typing import TypeAlias

import numpy as np

from stability.contact_law import Coulomb
from stability.contacts.bodies import HullSolid, Solid, as_hull, rounding
from stability.contacts.box_contacts import (
    LEVEL,
    NEARLY_PARALLEL,
    NOISE_RATIO,
    NOISY_TILT,
    ROUNDING,
    FeatureContact,
    PointsOnPlane,
    Slack,
    lies_on,
    line_or_point,
    no_higher,
)
from stability.contacts.gap_bridging import all_bridged, gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP
from stability.geometry.polygons import Point2, convex_hull, cut, hull
from stability.geometry.polyhedra import EdgePairs, Hull, between, edge_pairs, face_gaps, vector
from stability.geometry.rows import Array, cross_rows
from stability.geometry.vectors import add_scaled, cross, dot, norm, scale, unit
from stability.model import Plane, Vec3
from stability.problem import Contact

# Separating axes of two hulls, and how far their poses may be off by noise.


ALIKE = 0.5  # cosine above which two directions are worth a closer look

# Two faces that look at each other: number of that of a and of b, and sine of the angle between them.
FacePair: TypeAlias = tuple[int, int, float]


@dataclass(frozen=True, slots=True, eq=False)
class HullCloseness:
    """How two hulls stand to each other that touch or overlap."""

    a: Hull
    b: Hull
    p_AB: Array  # between their centres [m]
    gap: float  # the largest of all directions [m]
    gaps_a: Array  # by face of a [m]
    gaps_b: Array
    edges: EdgePairs
    facing: list[FacePair]  # nearly parallel

    def apart(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along each normal of a face, and of edges that cross [m], and that normal; as of boxes."""
        yield from self.faces()
        edges = self.edges
        sines = np.linalg.norm(cross_rows(self.a.ways[edges.of_a], self.b.ways[edges.of_b]), axis=1)
        cross = sines > NOISY_TILT
        yield from zip(edges.gaps[cross].tolist(), map(vector, edges.normals_AB[cross]), strict=True)

    def faces(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along the normal of each face of both [m], and that normal from a to b."""
        yield from zip(self.gaps_a.tolist(), map(vector, self.a.normals), strict=True)
        yield from zip(self.gaps_b.tolist(), map(vector, -self.b.normals), strict=True)

    def gap_along(self, normal_AB: Array) -> float:
        """The gap along a unit direction that leads from a to b [m]."""
        between_both = self.b.heights(normal_AB).min() - self.a.heights(normal_AB).max()
        return float(self.p_AB @ normal_AB + between_both)


def hull_closeness(a: Hull, b: Hull, reach: float) -> HullCloseness | None:
    """How two hulls stand to each other; None if they are further than `reach` apart, or deeper in each other."""
    p_AB = between(a, b)
    gaps_a, gaps_b = face_gaps(a, b, p_AB), face_gaps(b, a, -p_AB)
    largest = max(float(gaps_a.max()), float(gaps_b.max()))
    if largest > reach:
        return None
    edges = edge_pairs(a, b, p_AB)
    largest = max(largest, float(edges.gaps.max(initial=-np.inf)))
    if largest > reach or largest < -reach:
        return None
    return HullCloseness(a, b, p_AB, largest, gaps_a, gaps_b, edges, _facing(a, b))


def _facing(a: Hull, b: Hull) -> list[FacePair]:
    cosines = a.normals @ b.normals.T
    pairs = np.argwhere(cosines < -ALIKE)
    if not len(pairs):
        return []
    sines = np.linalg.norm(cross_rows(a.normals[pairs[:, 0]], b.normals[pairs[:, 1]]), axis=1)
    close = sines <= NEARLY_PARALLEL
    return [(int(i), int(j), float(sine)) for (i, j), sine in zip(pairs[close], sines[close], strict=True)]


def disturbance(close: HullCloseness, reach: float) -> float:
    """How far the two may be from the places that were meant [m], at most `reach`: read off the pair itself.

    As of boxes (`stability.contacts.box_contacts.disturbance`), by the normals of faces in place of body axes.
    """
    a, b = close.a, close.b
    alike = [(int(i), int(j)) for i, j in np.argwhere(np.abs(a.normals @ b.normals.T) > ALIKE)]
    one, other = [i for i, _ in alike], [j for _, j in alike]
    sines = np.linalg.norm(cross_rows(a.normals[one], b.normals[other]), axis=1) if alike else np.zeros(0)
    common = [i for i, sine in zip(one, sines.tolist(), strict=True) if sine <= NOISY_TILT]
    if common:
        ways = a.normals[common]
        same_way = np.linalg.norm(cross_rows(ways, np.broadcast_to(ways[0], ways.shape)), axis=1) <= NOISY_TILT
        if same_way.all() and max(close.gap_along(ways[0]), close.gap_along(-ways[0])) < -reach:
            return reach
    gaps: list[float] = [abs(gap) for gap in (*close.gaps_a.tolist(), *close.gaps_b.tolist()) if abs(gap) <= reach]
    tilts: list[float] = [sine for sine in sines.tolist() if sine <= NOISY_TILT]
    longest = max(a.length, b.length)
    noise = min([abs(close.gap), *gaps]) + min(tilts, default=0.0) * longest
    return min(reach, NOISE_RATIO * noise)


# Normals that two touching features of hulls admit.
#
# A face admits its normal, an edge what lies between those of its two faces, a corner what leads into none of its
# edges. Two features that touch admit what one admits and minus the other does; the extreme directions of that span it.


FACE, EDGE = 2, 1  # dimensions of a feature; a corner has none


@dataclass(frozen=True, slots=True)
class Feature:
    """A face, an edge or a corner of a hull, by its number."""

    body: Hull
    dimension: int
    number: int

    def normals(self, sign: float) -> list[Vec3]:
        """The extreme normals that it admits, times a sign; those of a corner in order around it."""
        mesh, normals = self.body.mesh, self.body.normals
        if self.dimension == FACE:
            return [vector(sign * normals[self.number])]
        if self.dimension == EDGE:
            return [vector(sign * normals[face]) for face in mesh.beside[self.number]]
        return [vector(sign * each) for each in _turned_around(normals[list(mesh.faces_at[self.number])])]

    def limits(self, sign: float) -> list[Vec3]:
        """Directions that a normal of a corner, times a sign, must not lead into."""
        corners, mesh = self.body.corners, self.body.mesh
        ways = corners[list(mesh.around[self.number])] - corners[self.number]
        return [vector(sign * way / np.linalg.norm(way)) for way in ways]


def _turned_around(normals: Array) -> Array:
    """The normals at a corner in order around their middle."""
    middle = normals.sum(axis=0)
    middle /= np.linalg.norm(middle)
    first = normals[0] - (normals[0] @ middle) * middle
    second = np.cross(middle, first)
    ordered: Array = normals[np.argsort(np.arctan2(normals @ second, normals @ first), kind="stable")]
    return ordered


def common_normals(a: Feature, b: Feature, along_line: bool) -> tuple[Vec3, ...]:
    """The extreme unit normals, from a towards b; none if the features do not face each other.

    Edges that touch along a line are taken as parallel, whatever noise has made of them.
    """
    if FACE in (a.dimension, b.dimension):
        return tuple(a.normals(1.0) if a.dimension == FACE else b.normals(-1.0))
    if a.dimension == b.dimension == EDGE:
        way_a, way_b = vector(a.body.ways[a.number]), vector(b.body.ways[b.number])
        across = cross(way_a, way_b)
        if along_line or norm(across) < ROUNDING:
            return _of_parallel_edges(a.normals(1.0), b.normals(-1.0), way_a)
        normal = unit(across)
        outward = sum(dot(normal, each) for each in a.normals(1.0))
        return (normal if outward > 0.0 else scale(-1.0, normal),)
    if a.dimension == EDGE:
        return _clipped(a.normals(1.0), b.limits(-1.0))
    return _clipped(b.normals(-1.0), a.limits(1.0))


def _of_parallel_edges(of_a: Sequence[Vec3], of_b: Sequence[Vec3], way: Vec3) -> tuple[Vec3, ...]:
    """What two arcs in the plane across the edges have in common: borders of one that lie within the other."""
    found = [each for each in of_a if _is_amid(each, of_b, way)]
    found += [each for each in of_b if _is_amid(each, of_a, way)]
    return _distinct(found)


def _is_amid(normal: Vec3, arc: Sequence[Vec3], way: Vec3) -> bool:
    start, end = arc if dot(cross(arc[0], arc[1]), way) > 0.0 else (arc[1], arc[0])
    if dot(normal, start) + dot(normal, end) <= 0.0:
        return False  # on the far side
    return dot(cross(start, normal), way) >= -ROUNDING and dot(cross(normal, end), way) >= -ROUNDING


def _clipped(cone: Sequence[Vec3], limits: Sequence[Vec3]) -> tuple[Vec3, ...]:
    normals = list(cone)
    for way in limits:
        normals = cut(normals, [-dot(normal, way) for normal in normals], ROUNDING, _amid) if normals else []
    return _distinct(normals)


def _amid(one: Vec3, other: Vec3, part: float) -> Vec3:
    return unit(add_scaled(scale(1.0 - part, one), part, other))


def _distinct(normals: Sequence[Vec3]) -> tuple[Vec3, ...]:
    found: list[Vec3] = []
    for normal in normals:
        if all(norm(add_scaled(normal, -1.0, other)) > ROUNDING for other in found):
            found.append(normal)
    return tuple(found)


# Face contacts of two hulls: nearly parallel faces whose gap counts as contact all over their overlap.


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


def hull_face_on_face(close: HullCloseness, slack: Slack, rounding: float) -> HullPatch | None:
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


# Edge and corner contacts of two hulls: on a face, crossing, meeting, or corner to corner.


CORNER = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Locus:
    points: tuple[Array, ...]  # from the centre of a, in W [m]
    heights: tuple[float, ...]  # of the one body above the other at each [m]
    of_a: Feature
    of_b: Feature


def meeting_on_face(close: HullCloseness, of_a: bool, number: int, slack: Slack) -> FeatureContact | None:
    """How the lowest feature of one hull touches a face of the other; None if it lies beside it."""
    a, b = close.a, close.b
    gap = float((close.gaps_a if of_a else close.gaps_b)[number])
    on, other, shift = (plate(a, number), b, close.p_AB) if of_a else (plate(b, number), a, -close.p_AB)
    normal = on.axes[2] if of_a else -on.axes[2]
    found = _on_face(on, other, shift, slack, gap)
    if found is None:
        return None
    points, heights, of_on, of_other = found
    if not of_a:
        points = tuple(point + close.p_AB for point in points)
    locus = _Locus(points, heights, of_on, of_other) if of_a else _Locus(points, heights, of_other, of_on)
    return _meeting(close, locus, normal, gap, slack)


def meeting_of_edges(close: HullCloseness, pair: int, slack: Slack) -> FeatureContact | None:
    """The point where an edge of a and an edge of b cross; None if they pass each other."""
    edges, a, b = close.edges, close.a, close.b
    i, j = int(edges.of_a[pair]), int(edges.of_b[pair])
    on_a, half_a = _segment(a, i)
    on_b, half_b = _segment(b, j)
    u, v, away = a.ways[i], b.ways[j], close.p_AB + on_b - on_a
    across = np.array(cross(vector(u), vector(v)))
    square = float(across @ across)
    along_a = float(np.array(cross(vector(away), vector(v))) @ across) / square
    along_b = float(np.array(cross(vector(away), vector(u))) @ across) / square
    if abs(along_a) > half_a + slack.sideways or abs(along_b) > half_b + slack.sideways:
        return None
    point_a, point_b = on_a + along_a * u, on_b + along_b * v
    locus = _Locus(
        (0.5 * (point_a + point_b + close.p_AB),),
        (float(edges.gaps[pair]),),
        _at_end(a, i, along_a, half_a, slack.sideways),
        _at_end(b, j, along_b, half_b, slack.sideways),
    )
    return _meeting(close, locus, edges.normals_AB[pair], float(edges.gaps[pair]), slack)


def _meeting(close: HullCloseness, locus: _Locus, normal: Array, gap: float, slack: Slack) -> FeatureContact:
    normals = common_normals(locus.of_a, locus.of_b, len(locus.points) > 1)
    # Features coincide up to the slack only. A normal along which the bodies are further apart is not theirs: it would
    # let a brick rest on an edge that it just misses.
    along = [(each, close.gap_along(np.array(each))) for each in normals]
    touching = tuple(each for each, apart in along if gap - slack.off <= apart <= slack.widest(each))
    centre = np.array(close.a.p_WC)
    points = tuple(vector(centre + point) for point in locus.points)
    return FeatureContact(points, locus.heights, touching or (vector(normal),))


def _segment(body: Hull, edge: int) -> tuple[Array, float]:
    """The middle of an edge, from the body's centre, and half its length [m]."""
    one, end = body.corners[body.mesh.edges[edge]]
    return 0.5 * (one + end), 0.5 * float(np.linalg.norm(end - one))


def _at_end(body: Hull, edge: int, along: float, half: float, slack: float) -> Feature:
    """The edge, or the corner at its end if the place is there."""
    if abs(along) < half - slack:
        return Feature(body, EDGE, edge)
    return Feature(body, CORNER, int(body.mesh.edges[edge][1 if along > 0.0 else 0]))


def _on_face(
    on: Plate, other: Hull, shift: Array, slacks: Slack, gap: float
) -> tuple[tuple[Array, ...], tuple[float, ...], Feature, Feature] | None:
    """The lowest feature of `other`, whose centre is `shift` from that of the face's body, on the face.

    The points on the face, the heights of the feature above them [m], and the features of the two bodies.
    """
    slack, rise, widest = slacks.sideways, slacks.rise(gap), slacks.widest(vector(on.axes[2]))
    seen = on.seen(other.corners + shift)
    lowest = min(height for _, _, height in seen)
    low = [number for number, (_, _, height) in enumerate(seen) if height - lowest <= rise]
    place = _within([seen[n] for n in low], on, slack, widest)
    if not place:
        return None
    loop = on.body.mesh.loops[on.number]
    of_on = _holding(on.body, place, dict(zip(loop, on.corners, strict=True)), Feature(on.body, FACE, on.number), slack)
    whole = _whole(other, low, -on.axes[2])
    of_other = _holding(other, place, {n: (seen[n][0], seen[n][1]) for n in low}, whole, slack)
    return tuple(on.placed(point) for point in place), tuple(height for _, _, height in place), of_on, of_other


def _whole(body: Hull, low: Sequence[int], towards: Array) -> Feature:
    """The feature that these corners make: of several faces, the one that looks most the way that is given."""
    if len(low) == 1:
        return Feature(body, CORNER, low[0])
    if len(low) == 2:  # noqa: PLR2004 -- an edge has two ends
        edge = _edge_of(body, low[0], low[1])
        if edge is not None:
            return Feature(body, EDGE, edge)
    return Feature(body, FACE, int((body.normals @ towards).argmax()))


def _edge_of(body: Hull, one: int, other: int) -> int | None:
    found = np.flatnonzero((body.mesh.edges == sorted((one, other))).all(axis=1))
    return int(found[0]) if len(found) else None


def _holding(body: Hull, place: Sequence[Vec3], corners: dict[int, Point2], whole: Feature, slack: float) -> Feature:
    """The least feature that holds a point or a line, of those between corners that are seen in plan."""
    if len(place) == 1:
        near = [(hypot(place[0][0] - x, place[0][1] - y), number) for number, (x, y) in corners.items()]
        if near and min(near)[0] <= slack:
            return Feature(body, CORNER, min(near)[1])
    for edge, (one, other) in enumerate(body.mesh.edges.tolist()):
        if one in corners and other in corners:
            ends = corners[one], corners[other]
            if all(_beside((x, y), *ends) <= slack for x, y, _ in place):
                return Feature(body, EDGE, edge)
    return whole


def _beside(point: Point2, one: Point2, other: Point2) -> float:
    """How far a point is from a line between two others [m]."""
    (x, y), (ax, ay), (bx, by) = point, one, other
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    part = ((x - ax) * dx + (y - ay) * dy) / square if square > 0.0 else 0.0
    part = min(1.0, max(0.0, part))
    return hypot(x - ax - part * dx, y - ay - part * dy)


def _within(vertices: Sequence[Vec3], on: Plate, slack: float, widest: float) -> Sequence[Vec3]:
    """The part of a feature on a face: one point, the two ends of a line, or nothing."""
    ordered = vertices if len(vertices) <= 2 else _in_order(vertices)  # noqa: PLR2004 -- a line has two ends
    wider = no_higher(on.cut_to(ordered, slack), widest)
    if not wider:
        return ()
    clamped: Sequence[Vec3] = [_clamped(point, on) for point in wider]
    if len(ordered) == 2 and not _along_border(wider, on, slack):  # noqa: PLR2004 -- an edge has two ends
        exact = no_higher(on.cut_to(ordered), widest)
        clamped = exact if len(exact) > 1 else clamped
    return line_or_point(clamped, slack)


def _in_order(vertices: Sequence[Vec3]) -> Sequence[Vec3]:
    """The corners over a face, as (x, y, height above it), that bound the rest in plan, in order around."""
    heights = {(x, y): height for x, y, height in sorted(vertices, reverse=True)}  # of two at a place, the lower one
    return [(x, y, heights[x, y]) for x, y in convex_hull(heights)]


def _sides(on: Plate) -> list[tuple[Point2, Point2]]:
    return list(zip(on.corners, (*on.corners[1:], on.corners[0]), strict=True))


def _clamped(point: Vec3, on: Plate) -> Vec3:
    """The point of a face that is nearest to another one beside it."""
    if all((bx - ax) * (point[1] - ay) - (by - ay) * (point[0] - ax) >= 0.0 for (ax, ay), (bx, by) in _sides(on)):
        return point
    nearest, best = point, float("inf")
    for (ax, ay), (bx, by) in _sides(on):
        dx, dy = bx - ax, by - ay
        part = min(1.0, max(0.0, ((point[0] - ax) * dx + (point[1] - ay) * dy) / (dx * dx + dy * dy)))
        foot = (ax + part * dx, ay + part * dy, point[2])
        away = hypot(point[0] - foot[0], point[1] - foot[1])
        if away < best:
            nearest, best = foot, away
    return nearest


def _along_border(segment: Sequence[Vec3], on: Plate, slack: float) -> bool:
    return any(all(_beside((x, y), one, other) <= slack for x, y, _ in segment) for one, other in _sides(on))


# The contact of two bodies of which one at least is no box, and of a hull and a plane.


# Share of the gap tolerance that noise may displace an edge sideways before it is another edge.
SIDEWAYS = 0.5
ASKEW = 0.9  # cosine below which two directions span a plane well


def hull_contact(a: Solid, b: Solid, friction: float, reach: float, within: float) -> Contact | None:
    """The contact of two bodies whose upright boxes touch; None if they do not. The same whichever comes first."""
    if a.id > b.id:
        a, b = b, a
    close = hull_closeness(as_hull(a), as_hull(b), reach)
    if close is None or run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.apart(), reach, within):
        return None
    off, exact = disturbance(close, reach), rounding(a, b)
    sideways = min(off, SIDEWAYS * reach) + exact
    slack = Slack(sideways, off + exact, reach, within)
    patch = hull_face_on_face(close, slack, exact)
    if patch is not None:
        lower, upper = (a, b) if patch.a_is_lower else (b, a)
        gaps = gaps_of(patch.heights, reach)
        return Contact(lower.id, upper.id, patch.points_W, (patch.normal_W,), Coulomb(friction), gaps)
    found = _best_hull_meeting(close, slack)
    # What a gap as wide as the tolerance has displaced further still touches.
    found = found or _best_hull_meeting(close, Slack(reach, reach, reach, within))
    return _of_meeting(a, b, found, friction, gaps_of(found.gaps_beside(close.gap), reach)) if found else None


def hulls_flush(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Whether two bodies that touch would carry nothing if they overlapped by `overlap` less [m]."""
    close = hull_closeness(as_hull(a), as_hull(b), reach)
    return close is not None and run_flush(close.faces(), overlap)


def _of_meeting(a: Solid, b: Solid, found: FeatureContact, friction: float, gaps: tuple[float, ...]) -> Contact:
    if sum(normal[2] for normal in found.normals_AB_W) >= -LEVEL:
        return Contact(a.id, b.id, found.points_W, found.normals_AB_W, Coulomb(friction), gaps)
    downwards = tuple(scale(-1.0, normal) for normal in found.normals_AB_W)
    return Contact(b.id, a.id, found.points_W, downwards, Coulomb(friction), gaps)


def _best_hull_meeting(close: HullCloseness, slack: Slack) -> FeatureContact | None:
    """The meeting along the direction of the largest gap along which features face each other; faces win near ties."""
    sideways = slack.sideways
    for rank, kind, number in sorted(_directions(close, sideways), key=itemgetter(0), reverse=True):
        gap = rank if kind == "edges" else rank - sideways
        if gap < close.gap - 2.0 * sideways or gap < -slack.reach:
            continue
        if kind == "edges":
            found = meeting_of_edges(close, number, slack)
        else:
            found = meeting_on_face(close, kind == "a", number, slack)
        if found:
            return found
    return None


def _directions(close: HullCloseness, sideways: float) -> Iterator[tuple[float, str, int]]:
    for kind, gaps in (("a", close.gaps_a), ("b", close.gaps_b)):
        yield from ((gap + sideways, kind, number) for number, gap in enumerate(gaps.tolist()))
    yield from ((gap, "edges", number) for number, gap in enumerate(close.edges.gaps.tolist()))


def hull_on_plane(body: HullSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """The points of the plane that a hull touches, as `points_on_plane` gives those of a box."""
    own, normal = body.hull, np.array(plane.normal_W)
    height = float((np.array(own.p_WC) - np.array(plane.point_W)) @ normal)
    rises = own.heights(normal)
    gap = height + float(rises.min())
    if gap > widest or gap < -reach:
        return (), ()
    low = own.corners[rises + height <= widest]
    above = (low @ normal) + height
    on_plane = np.array(own.p_WC) + low - above[:, None] * normal
    around = _around(low, normal)
    return tuple(vector(on_plane[n]) for n in around), tuple(float(above[n]) for n in around)


def _around(points: Array, normal: Array) -> list[int]:
    """Of corners that lie in a plane up to the tolerance, those that bound them, in order: an area, a line, a point."""
    if len(points) <= 2:  # noqa: PLR2004 -- a line has two ends
        return list(range(len(points)))
    up = vector(normal)
    first = unit(cross((0.0, 1.0, 0.0) if abs(up[1]) < ASKEW else (1.0, 0.0, 0.0), up))
    flat = [(x, y) for x, y in (points @ np.array((first, cross(up, first))).T).tolist()]
    around = hull(flat)
    if around:
        return [flat.index(corner) for corner in around]
    apart = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2)
    one, other = np.unravel_index(int(apart.argmax()), apart.shape)
    return [int(one), int(other)]
