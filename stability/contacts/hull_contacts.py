"""Contact of convex solids with each other and with planes: faces, edges, corners and their normals."""

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
    is_face_contact,
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

# Separating axes of two hulls, and the displacement of their poses by noise.


ALIKE = 0.5  # cosine of a rough preselection of parallel directions

# Two faces that face each other: the number of that of a and of b, and the sine of the angle between them.
FacePair: TypeAlias = tuple[int, int, float]


@dataclass(frozen=True, slots=True, eq=False)
class HullCloseness:
    """Gaps of two hulls that touch or overlap."""

    a: Hull
    b: Hull
    p_AB: Array  # between their centres [m]
    gap: float  # largest of all directions [m]
    gaps_a: Array  # by face of a [m]
    gaps_b: Array
    edges: EdgePairs
    facing: list[FacePair]  # nearly parallel

    def separations(self) -> Iterator[tuple[float, Vec3]]:
        """Yield the gap [m] and the normal of each face and each pair of crossing edges, as for boxes."""
        yield from self.faces()
        edges = self.edges
        sines = np.linalg.norm(cross_rows(self.a.directions[edges.of_a], self.b.directions[edges.of_b]), axis=1)
        cross = sines > NOISY_TILT
        yield from zip(edges.gaps[cross].tolist(), map(vector, edges.normals_AB[cross]), strict=True)

    def faces(self) -> Iterator[tuple[float, Vec3]]:
        """Yield the gap [m] and the normal from a to b of each face of both."""
        yield from zip(self.gaps_a.tolist(), map(vector, self.a.normals), strict=True)
        yield from zip(self.gaps_b.tolist(), map(vector, -self.b.normals), strict=True)

    def gap_along(self, normal_AB: Array) -> float:
        """Return the gap along a unit direction from a to b [m]."""
        between_both = self.b.heights(normal_AB).min() - self.a.heights(normal_AB).max()
        return float(self.p_AB @ normal_AB + between_both)


def hull_closeness(a: Hull, b: Hull, reach: float) -> HullCloseness | None:
    """Compute the gaps of two hulls; None if their gap or overlap exceeds `reach` [m]."""
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
    """Estimate the displacement of two hulls from their ideal poses by noise [m], at most `reach`, from the pair alone.

    As `stability.contacts.box_contacts.disturbance`, with face normals in place of body axes.
    """
    a, b = close.a, close.b
    alike = [(int(i), int(j)) for i, j in np.argwhere(np.abs(a.normals @ b.normals.T) > ALIKE)]
    of_a, of_b = [i for i, _ in alike], [j for _, j in alike]
    sines = np.linalg.norm(cross_rows(a.normals[of_a], b.normals[of_b]), axis=1) if alike else np.zeros(0)
    common = [i for i, sine in zip(of_a, sines.tolist(), strict=True) if sine <= NOISY_TILT]
    if common:
        directions = a.normals[common]
        parallel = (
            np.linalg.norm(cross_rows(directions, np.broadcast_to(directions[0], directions.shape)), axis=1)
            <= NOISY_TILT
        )
        if parallel.all() and max(close.gap_along(directions[0]), close.gap_along(-directions[0])) < -reach:
            return reach
    gaps: list[float] = [abs(gap) for gap in (*close.gaps_a.tolist(), *close.gaps_b.tolist()) if abs(gap) <= reach]
    tilts: list[float] = [sine for sine in sines.tolist() if sine <= NOISY_TILT]
    longest = max(a.length, b.length)
    noise = min([abs(close.gap), *gaps]) + min(tilts, default=0.0) * longest
    return min(reach, NOISE_RATIO * noise)


# Normals of two touching features of hulls.
#
# A face has its normal, an edge the directions between those of its two faces, a corner the directions without a
# positive component along its edges. The normals of two touching features are the intersection of one set with the
# negative of the other, given by its extreme directions.


FACE, EDGE = 2, 1  # dimensions of a feature; that of a corner is 0


@dataclass(frozen=True, slots=True)
class Feature:
    """Face, edge or corner of a hull, by its number."""

    body: Hull
    dimension: int
    number: int

    def normals(self, sign: float) -> list[Vec3]:
        """Return the extreme normals, times a sign; those of a corner in order around it."""
        mesh, normals = self.body.mesh, self.body.normals
        if self.dimension == FACE:
            return [vector(sign * normals[self.number])]
        if self.dimension == EDGE:
            return [vector(sign * normals[face]) for face in mesh.beside[self.number]]
        return [vector(sign * normal) for normal in _turned_around(normals[list(mesh.faces_at[self.number])])]

    def limits(self, sign: float) -> list[Vec3]:
        """Return the directions along which a normal of a corner, times a sign, has no positive component."""
        corners, mesh = self.body.corners, self.body.mesh
        directions = corners[list(mesh.around[self.number])] - corners[self.number]
        return [vector(sign * direction / np.linalg.norm(direction)) for direction in directions]


def _turned_around(normals: Array) -> Array:
    """Sort the normals at a corner around their mean."""
    middle = normals.sum(axis=0)
    middle /= np.linalg.norm(middle)
    first = normals[0] - (normals[0] @ middle) * middle
    second = np.cross(middle, first)
    ordered: Array = normals[np.argsort(np.arctan2(normals @ second, normals @ first), kind="stable")]
    return ordered


def common_normals(a: Feature, b: Feature, along_line: bool) -> tuple[Vec3, ...]:
    """Return the extreme unit normals, from a towards b; none if the features do not face each other.

    Edges that touch along a line count as parallel.
    """
    if FACE in (a.dimension, b.dimension):
        return tuple(a.normals(1.0) if a.dimension == FACE else b.normals(-1.0))
    if a.dimension == b.dimension == EDGE:
        direction_a, direction_b = vector(a.body.directions[a.number]), vector(b.body.directions[b.number])
        across = cross(direction_a, direction_b)
        if along_line or norm(across) < ROUNDING:
            return _of_parallel_edges(a.normals(1.0), b.normals(-1.0), direction_a)
        normal = unit(across)
        outward = sum(dot(normal, normal_of_a) for normal_of_a in a.normals(1.0))
        return (normal if outward > 0.0 else scale(-1.0, normal),)
    if a.dimension == EDGE:
        return _clipped(a.normals(1.0), b.limits(-1.0))
    return _clipped(b.normals(-1.0), a.limits(1.0))


def _of_parallel_edges(of_a: Sequence[Vec3], of_b: Sequence[Vec3], direction: Vec3) -> tuple[Vec3, ...]:
    """Intersect two arcs in the plane perpendicular to the edges: the borders of each that lie within the other."""
    common = [normal for normal in of_a if _is_between(normal, of_b, direction)]
    common += [normal for normal in of_b if _is_between(normal, of_a, direction)]
    return _distinct(common)


def _is_between(normal: Vec3, arc: Sequence[Vec3], direction: Vec3) -> bool:
    start, end = arc if dot(cross(arc[0], arc[1]), direction) > 0.0 else (arc[1], arc[0])
    if dot(normal, start) + dot(normal, end) <= 0.0:
        return False  # on the far side
    return dot(cross(start, normal), direction) >= -ROUNDING and dot(cross(normal, end), direction) >= -ROUNDING


def _clipped(cone: Sequence[Vec3], limits: Sequence[Vec3]) -> tuple[Vec3, ...]:
    normals = list(cone)
    for limit in limits:
        normals = cut(normals, [-dot(normal, limit) for normal in normals], ROUNDING, _between) if normals else []
    return _distinct(normals)


def _between(start: Vec3, end: Vec3, part: float) -> Vec3:
    return unit(add_scaled(scale(1.0 - part, start), part, end))


def _distinct(normals: Sequence[Vec3]) -> tuple[Vec3, ...]:
    distinct: list[Vec3] = []
    for normal in normals:
        if all(norm(add_scaled(normal, -1.0, other)) > ROUNDING for other in distinct):
            distinct.append(normal)
    return tuple(distinct)


# Face contacts of two hulls: nearly parallel faces with a small gap all over their overlap.


@dataclass(frozen=True, slots=True, eq=False)
class Plate:
    """Face of a hull, with its frame: x and y in the face, z along its normal."""

    body: Hull
    number: int
    axes: Array  # (3, 3) rows x, y, z in W; right-handed
    corners: tuple[Point2, ...]  # counter-clockwise seen from outside, from the body's centre [m]
    reach: float  # of the face from the body's centre [m]

    def seen(self, points: Array) -> list[Vec3]:
        """Convert points (n, 3), from the body's centre in W, to (x, y, height above the face)."""
        return [(x, y, z - self.reach) for x, y, z in (points @ self.axes.T).tolist()]

    def placed(self, point: Sequence[float]) -> Array:
        """Convert a point (x, y) of the face to W, from the body's centre [m]."""
        point_W: Array = point[0] * self.axes[0] + point[1] * self.axes[1] + self.reach * self.axes[2]
        return point_W

    def cut_to(self, corners: Sequence[Vec3], slack: float = 0.0) -> Sequence[Vec3]:
        """Clip a convex polygon, a line or a point to the face, extended by `slack` [m]."""
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
    """Return a face of a hull with its frame, x along its first side."""
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
    """Contact area of two hulls."""

    a_is_lower: bool
    points_W: tuple[Vec3, ...]  # in order [m]
    heights: tuple[float, ...]  # of the upper body above the lower one at each point [m]
    normal_W: Vec3  # outward normal of the lower one


def hull_face_on_face(close: HullCloseness, slack: Slack, rounding: float) -> HullPatch | None:
    """Return the patch of two faces with a small gap all over; None if none is wider than `slack.sideways`."""
    pairs = [(max(float(close.gaps_a[i]), float(close.gaps_b[j])), i, j) for i, j, _ in close.facing]
    for _, i, j in sorted(pairs, reverse=True):
        lower_is_a, normal = _order(close, i, j)
        on = plate(close.a, i) if lower_is_a else plate(close.b, j)
        other, face = (close.b, j) if lower_is_a else (close.a, i)
        shift = close.p_AB if lower_is_a else -close.p_AB
        lying = on.seen(other.corners[list(other.mesh.loops[face])] + shift)
        corners = on.cut_to(lying[::-1])  # seen from outside the carrying face, the other runs clockwise
        if corners and is_face_contact(corners, vector(normal), slack):
            points, heights = _in_world(on, corners, rounding)
            return HullPatch(lower_is_a, points, heights, vector(normal))
    return None


def _order(close: HullCloseness, i: int, j: int) -> tuple[bool, Array]:
    """Check that the face of a is the lower one; return this, and the normal from the lower body to the upper one."""
    up_a, up_b = close.a.normals[i], close.b.normals[j]
    if up_a[2] >= -LEVEL:
        return True, up_a
    if up_b[2] > LEVEL:
        return False, up_b
    return True, -up_b  # both normals point down by noise: two vertical sides


def _in_world(on: Plate, corners: Sequence[Vec3], rounding: float) -> tuple[tuple[Vec3, ...], tuple[float, ...]]:
    """Return the distinct corners in W, and their heights above the face [m]."""
    distinct: list[Array] = []
    heights: list[float] = []
    for corner in corners:
        local = on.placed(corner)
        if not any(dist(local, other) <= rounding for other in distinct):
            distinct.append(local)
            heights.append(corner[2])
    centre = np.array(on.body.p_WC)
    return tuple(vector(centre + local) for local in distinct), tuple(heights)


# Edge and corner contacts of two hulls: on a face, edge on edge, or corner on corner.


CORNER = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Locus:
    points: tuple[Array, ...]  # from the centre of a, in W [m]
    heights: tuple[float, ...]  # of one body above the other at each point [m]
    of_a: Feature
    of_b: Feature


def contact_on_face(close: HullCloseness, of_a: bool, number: int, slack: Slack) -> FeatureContact | None:
    """Return the contact of the lowest feature of one hull with a face of the other; None if it is beside the face."""
    a, b = close.a, close.b
    gap = float((close.gaps_a if of_a else close.gaps_b)[number])
    on, other, shift = (plate(a, number), b, close.p_AB) if of_a else (plate(b, number), a, -close.p_AB)
    normal = on.axes[2] if of_a else -on.axes[2]
    locus_parts = _on_face(on, other, shift, slack, gap)
    if locus_parts is None:
        return None
    points, heights, of_on, of_other = locus_parts
    if not of_a:
        points = tuple(point + close.p_AB for point in points)
    locus = _Locus(points, heights, of_on, of_other) if of_a else _Locus(points, heights, of_other, of_on)
    return _feature_contact(close, locus, normal, gap, slack)


def contact_of_edges(close: HullCloseness, pair: int, slack: Slack) -> FeatureContact | None:
    """Return the contact where an edge of a crosses an edge of b; None if the lines cross beyond their ends."""
    edges, a, b = close.edges, close.a, close.b
    i, j = int(edges.of_a[pair]), int(edges.of_b[pair])
    on_a, half_a = _segment(a, i)
    on_b, half_b = _segment(b, j)
    u, v, offset = a.directions[i], b.directions[j], close.p_AB + on_b - on_a
    across = np.array(cross(vector(u), vector(v)))
    square = float(across @ across)
    along_a = float(np.array(cross(vector(offset), vector(v))) @ across) / square
    along_b = float(np.array(cross(vector(offset), vector(u))) @ across) / square
    if abs(along_a) > half_a + slack.sideways or abs(along_b) > half_b + slack.sideways:
        return None
    point_a, point_b = on_a + along_a * u, on_b + along_b * v
    locus = _Locus(
        (0.5 * (point_a + point_b + close.p_AB),),
        (float(edges.gaps[pair]),),
        _at_end(a, i, along_a, half_a, slack.sideways),
        _at_end(b, j, along_b, half_b, slack.sideways),
    )
    return _feature_contact(close, locus, edges.normals_AB[pair], float(edges.gaps[pair]), slack)


def _feature_contact(close: HullCloseness, locus: _Locus, normal: Array, gap: float, slack: Slack) -> FeatureContact:
    normals = common_normals(locus.of_a, locus.of_b, len(locus.points) > 1)
    # Features coincide only up to the slack. A normal with a larger gap is left out: it would let a brick rest on an
    # edge that it just misses.
    along = [(candidate, close.gap_along(np.array(candidate))) for candidate in normals]
    touching = tuple(
        candidate for candidate, apart in along if gap - slack.off <= apart <= slack.largest_gap(candidate)
    )
    centre = np.array(close.a.p_WC)
    points = tuple(vector(centre + point) for point in locus.points)
    return FeatureContact(points, locus.heights, touching or (vector(normal),))


def _segment(body: Hull, edge: int) -> tuple[Array, float]:
    """Return the midpoint of an edge, from the body's centre, and half its length [m]."""
    start, end = body.corners[body.mesh.edges[edge]]
    return 0.5 * (start + end), 0.5 * float(np.linalg.norm(end - start))


def _at_end(body: Hull, edge: int, along: float, half: float, slack: float) -> Feature:
    """Return the corner at the end of an edge if the point is there, else the edge."""
    if abs(along) < half - slack:
        return Feature(body, EDGE, edge)
    return Feature(body, CORNER, int(body.mesh.edges[edge][1 if along > 0.0 else 0]))


def _on_face(
    on: Plate, other: Hull, shift: Array, slacks: Slack, gap: float
) -> tuple[tuple[Array, ...], tuple[float, ...], Feature, Feature] | None:
    """Return the contact of a face with the lowest feature of `other`, whose centre is `shift` from the face's body.

    The result has the points on the face, the heights of the feature above them [m], and the features of the two
    bodies.
    """
    slack, rise, largest_gap = slacks.sideways, slacks.rise(gap), slacks.largest_gap(vector(on.axes[2]))
    local = on.seen(other.corners + shift)
    lowest = min(height for _, _, height in local)
    low = [number for number, (_, _, height) in enumerate(local) if height - lowest <= rise]
    in_face = _within([local[n] for n in low], on, slack, largest_gap)
    if not in_face:
        return None
    loop = on.body.mesh.loops[on.number]
    of_on = _smallest_feature(
        on.body, in_face, dict(zip(loop, on.corners, strict=True)), Feature(on.body, FACE, on.number), slack
    )
    lowest_feature = _feature_of(other, low, -on.axes[2])
    of_other = _smallest_feature(other, in_face, {n: (local[n][0], local[n][1]) for n in low}, lowest_feature, slack)
    return tuple(on.placed(point) for point in in_face), tuple(height for _, _, height in in_face), of_on, of_other


def _feature_of(body: Hull, low: Sequence[int], direction: Array) -> Feature:
    """Return the feature of these corners; of several faces the one that faces the given direction most."""
    if len(low) == 1:
        return Feature(body, CORNER, low[0])
    if len(low) == 2:  # noqa: PLR2004 -- an edge has two ends
        edge = _edge_of(body, low[0], low[1])
        if edge is not None:
            return Feature(body, EDGE, edge)
    return Feature(body, FACE, int((body.normals @ direction).argmax()))


def _edge_of(body: Hull, start: int, end: int) -> int | None:
    matches = np.flatnonzero((body.mesh.edges == sorted((start, end))).all(axis=1))
    return int(matches[0]) if len(matches) else None


def _smallest_feature(
    body: Hull, points: Sequence[Vec3], corners: dict[int, Point2], default: Feature, slack: float
) -> Feature:
    """Return the smallest feature that contains a point or a line, given the corners in the plane of the face."""
    if len(points) == 1:
        near = [(hypot(points[0][0] - x, points[0][1] - y), number) for number, (x, y) in corners.items()]
        if near and min(near)[0] <= slack:
            return Feature(body, CORNER, min(near)[1])
    for edge, (start, end) in enumerate(body.mesh.edges.tolist()):
        if start in corners and end in corners:
            ends = corners[start], corners[end]
            if all(_beside((x, y), *ends) <= slack for x, y, _ in points):
                return Feature(body, EDGE, edge)
    return default


def _beside(point: Point2, start: Point2, end: Point2) -> float:
    """Return the distance of a point from the line between two others [m]."""
    (x, y), (ax, ay), (bx, by) = point, start, end
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    part = ((x - ax) * dx + (y - ay) * dy) / square if square > 0.0 else 0.0
    part = min(1.0, max(0.0, part))
    return hypot(x - ax - part * dx, y - ay - part * dy)


def _within(vertices: Sequence[Vec3], on: Plate, slack: float, widest: float) -> Sequence[Vec3]:
    """Return the part of a feature on a face: a point, the two ends of a line, or nothing."""
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
    """Return the corners over a face, as (x, y, height above it), of the convex hull in the face, in order."""
    heights = {(x, y): height for x, y, height in sorted(vertices, reverse=True)}  # the lower of two at one (x, y)
    return [(x, y, heights[x, y]) for x, y in convex_hull(heights)]


def _sides(on: Plate) -> list[tuple[Point2, Point2]]:
    return list(zip(on.corners, (*on.corners[1:], on.corners[0]), strict=True))


def _clamped(point: Vec3, on: Plate) -> Vec3:
    """Return the point of a face that is nearest to a point beside it."""
    if all((bx - ax) * (point[1] - ay) - (by - ay) * (point[0] - ax) >= 0.0 for (ax, ay), (bx, by) in _sides(on)):
        return point
    nearest, best = point, float("inf")
    for (ax, ay), (bx, by) in _sides(on):
        dx, dy = bx - ax, by - ay
        part = min(1.0, max(0.0, ((point[0] - ax) * dx + (point[1] - ay) * dy) / (dx * dx + dy * dy)))
        foot = (ax + part * dx, ay + part * dy, point[2])
        distance = hypot(point[0] - foot[0], point[1] - foot[1])
        if distance < best:
            nearest, best = foot, distance
    return nearest


def _along_border(segment: Sequence[Vec3], on: Plate, slack: float) -> bool:
    return any(all(_beside((x, y), start, end) <= slack for x, y, _ in segment) for start, end in _sides(on))


# The contact of two bodies at least one of which is no box, and of a hull and a plane.


SIDEWAYS = 0.5  # largest sideways offset of coinciding edges by noise, as a share of the gap tolerance
ASKEW = 0.9  # largest cosine of two directions that span a plane


def hull_contact(a: Solid, b: Solid, friction: float, reach: float, within: float) -> Contact | None:
    """Return the contact of two bodies with touching bounding boxes, independent of their order; None without one."""
    if a.id > b.id:
        a, b = b, a
    close = hull_closeness(as_hull(a), as_hull(b), reach)
    if close is None or run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.separations(), reach, within):
        return None
    off, exact = disturbance(close, reach), rounding(a, b)
    sideways = min(off, SIDEWAYS * reach) + exact
    slack = Slack(sideways, off + exact, reach, within)
    patch = hull_face_on_face(close, slack, exact)
    if patch is not None:
        lower, upper = (a, b) if patch.a_is_lower else (b, a)
        gaps = gaps_of(patch.heights, reach)
        return Contact(lower.id, upper.id, patch.points_W, (patch.normal_W,), Coulomb(friction), gaps)
    features = _best_feature_contact(close, slack)
    # Try again with larger tolerances, as a gap of the largest size displaces edges further.
    features = features or _best_feature_contact(close, Slack(reach, reach, reach, within))
    return (
        _directed_contact(a, b, features, friction, gaps_of(features.gaps_beside(close.gap), reach))
        if features
        else None
    )


def hulls_flush(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Check that two touching bodies would transfer no force if they overlapped by `overlap` [m] less."""
    close = hull_closeness(as_hull(a), as_hull(b), reach)
    return close is not None and run_flush(close.faces(), overlap)


def _directed_contact(
    a: Solid, b: Solid, features: FeatureContact, friction: float, gaps: tuple[float, ...]
) -> Contact:
    if sum(normal[2] for normal in features.normals_AB_W) >= -LEVEL:
        return Contact(a.id, b.id, features.points_W, features.normals_AB_W, Coulomb(friction), gaps)
    downwards = tuple(scale(-1.0, normal) for normal in features.normals_AB_W)
    return Contact(b.id, a.id, features.points_W, downwards, Coulomb(friction), gaps)


def _best_feature_contact(close: HullCloseness, slack: Slack) -> FeatureContact | None:
    """Return the contact along the direction of the largest gap with features that face each other.

    Faces win near ties.
    """
    sideways = slack.sideways
    for rank, kind, number in sorted(_directions(close, sideways), key=itemgetter(0), reverse=True):
        gap = rank if kind == "edges" else rank - sideways
        if gap < close.gap - 2.0 * sideways or gap < -slack.reach:
            continue
        if kind == "edges":
            features = contact_of_edges(close, number, slack)
        else:
            features = contact_on_face(close, kind == "a", number, slack)
        if features:
            return features
    return None


def _directions(close: HullCloseness, sideways: float) -> Iterator[tuple[float, str, int]]:
    for kind, gaps in (("a", close.gaps_a), ("b", close.gaps_b)):
        yield from ((gap + sideways, kind, number) for number, gap in enumerate(gaps.tolist()))
    yield from ((gap, "edges", number) for number, gap in enumerate(close.edges.gaps.tolist()))


def hull_on_plane(body: HullSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """Return the points of a plane that a hull touches, as `points_on_plane` for a box."""
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
    """Return the hull of corners that lie in a plane up to the tolerance, in order: an area, a line or a point."""
    if len(points) <= 2:  # noqa: PLR2004 -- a line has two ends
        return list(range(len(points)))
    up = vector(normal)
    first = unit(cross((0.0, 1.0, 0.0) if abs(up[1]) < ASKEW else (1.0, 0.0, 0.0), up))
    flat = [(x, y) for x, y in (points @ np.array((first, cross(up, first))).T).tolist()]
    around = hull(flat)
    if around:
        return [flat.index(corner) for corner in around]
    apart = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2)
    start, end = np.unravel_index(int(apart.argmax()), apart.shape)
    return [int(start), int(end)]
