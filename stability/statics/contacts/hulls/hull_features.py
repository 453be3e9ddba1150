"""Where edges and corners of two hulls touch: an edge or a corner on a face, edges that cross or meet, corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from stability.geometry.hulls import convex_hull
from stability.geometry.plan import Point2
from stability.geometry.polyhedra import Array, Hull, vector
from stability.geometry.vectors import cross
from stability.model import Vec3
from stability.statics.contacts.faces import Slack
from stability.statics.contacts.features import Meeting, line_or_point, no_higher
from stability.statics.contacts.hulls.hull_closeness import HullCloseness
from stability.statics.contacts.hulls.hull_cones import EDGE, FACE, Feature, common_normals
from stability.statics.contacts.hulls.hull_patches import Plate, plate

CORNER = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Locus:
    points: tuple[Array, ...]  # from the centre of a, in W [m]
    heights: tuple[float, ...]  # of the one body above the other at each [m]
    of_a: Feature
    of_b: Feature


def meeting_on_face(close: HullCloseness, of_a: bool, number: int, slack: Slack) -> Meeting | None:
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


def meeting_of_edges(close: HullCloseness, pair: int, slack: Slack) -> Meeting | None:
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


def _meeting(close: HullCloseness, locus: _Locus, normal: Array, gap: float, slack: Slack) -> Meeting:
    normals = common_normals(locus.of_a, locus.of_b, len(locus.points) > 1)
    # Features coincide up to the slack only. A normal along which the bodies are further apart is not theirs: it would
    # let a brick rest on an edge that it just misses.
    along = [(each, close.gap_along(np.array(each))) for each in normals]
    touching = tuple(each for each, apart in along if gap - slack.off <= apart <= slack.widest(each))
    centre = np.array(close.a.p_WC)
    points = tuple(vector(centre + point) for point in locus.points)
    return Meeting(points, locus.heights, touching or (vector(normal),))


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
