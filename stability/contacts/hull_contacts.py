"""Convex solids other than boxes: their faces, edges and corners, and the gaps of a pair."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist

import numpy as np

from stability.contacts.convex_contacts import NEARLY_PARALLEL, Closeness, FacePair, SeparatingAxis
from stability.contacts.features import CORNER, EDGE, FACE, ConvexSolid, Edge, Face, Feature
from stability.geometry.box_distance import Axes
from stability.geometry.polygons import Point2, convex_hull, cut
from stability.geometry.polygons import hull as hull_in_plan
from stability.geometry.polyhedra import Hull, between, edge_pairs, face_gaps, hull, vector
from stability.geometry.rows import Array, cross_rows
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, scale, subtract, unit
from stability.model import BodyId, ConvexShape, Pose, Vec3

ASKEW = 0.9  # largest cosine of two directions that span a plane


@dataclass(frozen=True, slots=True)
class PolygonOutline:
    """Border of a face."""

    corners: Sequence[Point2]  # counter-clockwise seen from outside [m]

    def clipped(self, corners: Sequence[Vec3], slack: float = 0.0) -> Sequence[Vec3]:
        for (ax, ay), (bx, by) in self._sides():
            if not corners:
                return ()
            dx, dy = bx - ax, by - ay
            length = (dx * dx + dy * dy) ** 0.5
            depths = [(dx * (y - ay) - dy * (x - ax)) / length + slack for x, y, _ in corners]
            if min(depths) < 0.0:
                corners = cut(corners, depths)
        return corners

    def clamped(self, point: Vec3) -> Vec3:
        x, y, height = point
        if all((bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0 for (ax, ay), (bx, by) in self._sides()):
            return point
        feet = [_foot((x, y), start, end) for start, end in self._sides()]
        return (*min(feet, key=lambda foot: dist((x, y), foot)), height)

    def has_on_border(self, segment: Sequence[Vec3], slack: float) -> bool:
        points = [(x, y) for x, y, _ in segment]
        return any(all(_distance(point, side) <= slack for point in points) for side in self._sides())

    def _sides(self) -> list[tuple[Point2, Point2]]:
        return list(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))


def _foot(point: Point2, start: Point2, end: Point2) -> Point2:
    """Return the point of a line between two others that is nearest to a point."""
    (x, y), (ax, ay), (bx, by) = point, start, end
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    part = ((x - ax) * dx + (y - ay) * dy) / square if square > 0.0 else 0.0
    part = min(1.0, max(0.0, part))
    return (ax + part * dx, ay + part * dy)


def _distance(point: Point2, line: tuple[Point2, Point2]) -> float:
    return dist(point, _foot(point, *line))


@dataclass(frozen=True, slots=True, eq=False)
class HullFeature:
    """Face, edge or corner of a hull."""

    body: Hull
    dimension: int
    number: int
    corners: Sequence[int]  # numbers of its corners, and of others that touch the same face

    @property
    def direction(self) -> Vec3:
        return vector(self.body.directions[self.number])

    def normals(self, sign: float) -> Sequence[Vec3]:
        mesh, normals = self.body.mesh, self.body.normals
        if self.dimension == FACE:
            return [vector(sign * normals[self.number])]
        if self.dimension == EDGE:
            return [vector(sign * normals[face]) for face in mesh.beside[self.number]]
        return [vector(sign * normal) for normal in _turned_around(normals[list(mesh.faces_at[self.number])])]

    def limits(self, sign: float) -> Sequence[Vec3]:
        corners, mesh = self.body.corners, self.body.mesh
        directions = corners[list(mesh.around[self.number])] - corners[self.number]
        return [vector(sign * direction / np.linalg.norm(direction)) for direction in directions]

    def containing(self, points: Sequence[Vec3], up_W: Vec3, slack: float) -> "HullFeature":
        places = _flat(points, up_W)
        corners = dict(zip(self.corners, _flat(_vectors(self.body.corners[list(self.corners)]), up_W), strict=True))
        if len(places) == 1:
            nearest = min(corners, key=lambda number: dist(places[0], corners[number]))
            if dist(places[0], corners[nearest]) <= slack:
                return HullFeature(self.body, CORNER, nearest, (nearest,))
        for edge, (start, end) in enumerate(self.body.mesh.edges.tolist()):
            if start in corners and end in corners:
                line = corners[start], corners[end]
                if all(_distance(place, line) <= slack for place in places):
                    return HullFeature(self.body, EDGE, edge, (start, end))
        return self


def _turned_around(normals: Array) -> Array:
    """Sort the normals at a corner around their mean."""
    middle = normals.sum(axis=0)
    middle /= np.linalg.norm(middle)
    first = normals[0] - (normals[0] @ middle) * middle
    second = np.cross(middle, first)
    ordered: Array = normals[np.argsort(np.arctan2(normals @ second, normals @ first), kind="stable")]
    return ordered


def _flat(points: Sequence[Vec3], up_W: Vec3) -> list[Point2]:
    """Return the coordinates of points in a plane perpendicular to a direction, counter-clockwise seen from above."""
    first = unit(cross((0.0, 1.0, 0.0) if abs(up_W[1]) < ASKEW else (1.0, 0.0, 0.0), up_W))
    second = cross(up_W, first)
    return [(dot(point, first), dot(point, second)) for point in points]


def _vectors(rows: Array) -> list[Vec3]:
    return [(x, y, z) for x, y, z in rows.tolist()]


@dataclass(frozen=True, slots=True, eq=False)
class HullSolid(ConvexSolid):
    """Convex solid other than a box; its pose is not rotated, as the hull is in W."""

    hull: Hull

    @property
    def corners_W(self) -> tuple[Vec3, ...]:
        """The corners [m]."""
        return tuple(add(self.hull.p_WC, corner) for corner in _vectors(self.hull.corners))

    def extent(self, direction_W: Vec3) -> float:
        return float(self.hull.heights(np.array(direction_W)).max())

    def face(self, number: int, towards_W: Vec3) -> Face:
        """Return a face with its frame, x along its first side."""
        own, loop = self.hull, self.hull.mesh.loops[number]
        normal, points = vector(own.normals[number]), _vectors(own.corners[list(loop)])
        along = subtract(points[1], points[0])
        along = unit(add_scaled(along, -dot(along, normal), normal))
        across = cross(normal, along)
        outline = PolygonOutline([(dot(point, along), dot(point, across)) for point in points])
        reach = float(own.mesh.reaches[number])
        return Face(self, HullFeature(own, FACE, number, loop), (along, across, normal), True, reach, outline)

    def edge(self, number: int, towards_W: Vec3) -> Edge:
        own = self.hull
        first, second = own.mesh.edges[number].tolist()
        start, end = _vectors(own.corners[[first, second]])
        feature = HullFeature(own, EDGE, number, (first, second))
        return Edge(feature, scale(0.5, add(start, end)), feature.direction, 0.5 * dist(start, end))

    def lowest(self, on: Face, p_BO: Vec3, rise: float) -> tuple[Feature, Sequence[Vec3]]:
        own, up = self.hull, np.array(on.normal_W)
        heights = own.heights(up)
        low = np.flatnonzero(heights - heights.min() <= rise).tolist()
        corners = on.seen([add(p_BO, corner) for corner in _vectors(own.corners[low])])
        if len(low) == 1:
            return HullFeature(own, CORNER, low[0], low), corners
        if len(low) == 2:  # noqa: PLR2004 -- an edge has two ends
            edge = np.flatnonzero((own.mesh.edges == low).all(axis=1))
            if len(edge):
                return HullFeature(own, EDGE, int(edge[0]), low), corners
        # Of several faces the one that faces the other body most.
        face = HullFeature(own, FACE, int((own.normals @ up).argmin()), low)
        return face, _in_order(corners) if len(low) > 2 else corners  # noqa: PLR2004

    def lowest_corners(self, up_W: Vec3, rise: float) -> Sequence[Vec3]:
        low = _vectors(self.hull.corners[self.hull.heights(np.array(up_W)) <= rise])
        if len(low) <= 2:  # noqa: PLR2004 -- a line has two ends
            return low
        flat = _flat(low, up_W)
        around = hull_in_plan(flat)
        if around:
            return [low[flat.index(corner)] for corner in around]
        return max(((start, end) for start in low for end in low), key=lambda ends: dist(*ends))


def hull_solid(name: BodyId, shape: ConvexShape, p_WC: Vec3, axes_W: Axes) -> HullSolid:
    """Prepare a convex shape for contact detection, with this centre of mass [m] and these body axes."""
    own = hull(shape, p_WC, axes_W)
    return HullSolid(name, Pose(p_WC), own.low_W, own.high_W, own.thickness, own.length, own)


def _in_order(corners: Sequence[Vec3]) -> Sequence[Vec3]:
    """Return the corners over a face, as (x, y, height above it), of the convex hull in the face, in order."""
    heights = {(x, y): height for x, y, height in sorted(corners, reverse=True)}  # the lower of two at one (x, y)
    return [(x, y, heights[x, y]) for x, y in convex_hull(heights)]


# Gaps of two hulls.


ALIKE = 0.5  # cosine of a rough preselection of parallel directions


@dataclass(frozen=True, slots=True, eq=False)
class HullCloseness(Closeness):
    """Gaps of two hulls that touch or overlap."""

    a: HullSolid
    b: HullSolid
    gaps_a: Array  # by face of a [m]
    gaps_b: Array

    def parallel_faces(self) -> Sequence[FacePair]:
        normals_a, normals_b = self.a.hull.normals, self.b.hull.normals
        cosines = normals_a @ normals_b.T
        of_a, of_b = np.nonzero(np.abs(cosines) > ALIKE)
        sines = np.linalg.norm(cross_rows(normals_a[of_a], normals_b[of_b]), axis=1)
        return [
            FacePair(
                max(float(self.gaps_a[i]), float(self.gaps_b[j])), i, j, cosines[i, j] < 0.0, sine, vector(normals_a[i])
            )
            for i, j, sine in zip(of_a.tolist(), of_b.tolist(), sines.tolist(), strict=True)
            if sine <= NEARLY_PARALLEL
        ]


def hull_closeness(a: HullSolid, b: HullSolid, reach: float) -> HullCloseness | None:
    """Compute the gaps of two hulls; None if their gap or overlap exceeds `reach` [m]."""
    hull_a, hull_b = a.hull, b.hull
    p_AB = between(hull_a, hull_b)
    gaps_a, gaps_b = face_gaps(hull_a, hull_b, p_AB), face_gaps(hull_b, hull_a, -p_AB)
    largest = max(float(gaps_a.max()), float(gaps_b.max()))
    if largest > reach:
        return None
    pairs = edge_pairs(hull_a, hull_b, p_AB)
    largest = max(largest, float(pairs.gaps.max(initial=-np.inf)))
    if largest > reach or largest < -reach:
        return None
    least = largest - 2.0 * reach
    normals_a, normals_b = _vectors(hull_a.normals), _vectors(-hull_b.normals)
    faces = [SeparatingAxis(gap, normals_a[i], i, None) for i, gap in enumerate(gaps_a.tolist()) if gap >= least]
    faces += [SeparatingAxis(gap, normals_b[j], None, j) for j, gap in enumerate(gaps_b.tolist()) if gap >= least]
    edges = []
    for pair in np.flatnonzero(pairs.gaps >= least).tolist():
        i, j = int(pairs.of_a[pair]), int(pairs.of_b[pair])
        sine = norm(cross(vector(hull_a.directions[i]), vector(hull_b.directions[j])))
        edges.append(SeparatingAxis(float(pairs.gaps[pair]), vector(pairs.normals_AB[pair]), i, j, sine))
    return HullCloseness(a, b, vector(p_AB), largest, faces, edges, gaps_a, gaps_b)
