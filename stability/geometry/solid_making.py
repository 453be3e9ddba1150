"""Construction of convex solids from corners, prisms or meshes, with volume, centroid and inertia."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from numbers import Integral
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from stability.geometry.box import Box, box_of
from stability.geometry.convex_solid import ConvexSolid, NotASolidError
from stability.geometry.polygons import convex_hull
from stability.geometry.rows import Array
from stability.geometry.vectors import (
    LONGEST,
    SHORTEST,
    admit_in_range,
    admit_numbers,
    listed,
    norm,
    principal_axes,
    scale,
    short_repr,
    subtract,
    unit,
)
from stability.model import IDENTITY, ConvexShape, Face, Quaternion, Vec3

# Faces of a convex hull, each with all its corners: the triangles of Qhull in one plane are merged to one face.


FLUSH: Final = 1e-9  # share of the extent: least thickness of a solid
# Share of the least thickness: a point within this distance of a plane or line lies on it. Files have six decimals of a
# metre or single precision, and the largest gap of a contact is two hundred times as large.
WRITTEN: Final = 1e-4
# Warped faces can be nearly flat: if faces merged within `WRITTEN` do not close, they are merged within a part of it.
FINER: Final = (1.0, 10.0, 100.0, 1e3, 1e4)
LEAST_POINTS: Final = 4
LEAST_FACES_AT_A_CORNER: Final = 3
MOST_POINTS: Final = 100_000
MOST_CORNERS: Final = 1000  # of Qhull's hull, including corners within faces; `MOST_FACES` limits the solid further


def hull_faces(points: Sequence[Vec3]) -> tuple[list[Vec3], list[tuple[int, ...]], list[int]]:
    """Return the corners of the hull of points, its faces counter-clockwise seen from outside, and the inner points.

    Corners keep the order of the points; a point on a face or an edge is neither a corner nor inside. Raises
    NotASolidError if all points lie in a plane, or so close to one that precision is lost.
    """
    if not LEAST_POINTS <= len(points) <= MOST_POINTS:
        raise NotASolidError(
            f"{len(points)} points enclose no volume"
            if len(points) < LEAST_POINTS
            else f"{len(points)} points are too many",
            f"write {LEAST_POINTS} to {MOST_POINTS} corners",
        )
    array = np.array(points, dtype=float)
    centred = array - array.mean(axis=0)
    extent = float(np.ptp(centred, axis=0).max())
    flat = NotASolidError("all points lie in one plane", "write points that enclose a volume")
    if extent == 0.0:
        raise flat
    scaled = centred / extent
    try:
        hull = ConvexHull(scaled)
    except QhullError as error:
        raise flat from error
    if len(hull.vertices) > MOST_CORNERS:
        message = f"the hull of the points has {len(hull.vertices)} corners; the maximum is {MOST_CORNERS}"
        raise NotASolidError(message, "simplify the solid")
    thickness = float(np.ptp(scaled @ hull.equations[:, :3].T, axis=0).min())
    if thickness <= FLUSH:
        raise flat
    for finer in FINER[:-1]:
        with suppress(NotASolidError):
            return _faces_within(WRITTEN * thickness / finer, points, scaled, hull)
    return _faces_within(WRITTEN * thickness / FINER[-1], points, scaled, hull)


def _faces_within(
    written: float, points: Sequence[Vec3], scaled: Array, hull: ConvexHull
) -> tuple[list[Vec3], list[tuple[int, ...]], list[int]]:
    """Return what `hull_faces` returns, with faces merged whose corners lie within a share of the extent of a plane."""
    planes = [_plane(scaled, group, hull) for group in _groups(scaled, hull, written)]
    loops = [_loop(scaled, on, normal, written) for normal, on in planes]
    return _in_order(points, loops, scaled, planes, written)


class NotConvexError(NotASolidError):
    """A mesh bounds a solid that is not convex."""


def file_tolerance(points: Sequence[Vec3], faces: Sequence[Sequence[int]]) -> float:
    """Return the tolerance of the corners of these faces as written in files, as a share of the extent."""
    array = np.array(points, dtype=float)
    normals = np.array([np.cross(array[b] - array[a], array[c] - array[a]) for a, b, c, *_ in faces])
    lengths = np.linalg.norm(normals, axis=1)
    heights = np.ptp(array @ (normals[lengths > 0.0] / lengths[lengths > 0.0, None]).T, axis=0)
    return WRITTEN * float(heights.min()) / float(np.ptp(array, axis=0).max())


def _groups(points: Array, hull: ConvexHull, written: float) -> Iterator[list[int]]:
    """Yield the triangles of each face: adjacent triangles in one plane, up to the precision of files."""
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    areas = np.linalg.norm(_across(points, hull.simplices), axis=1)
    remaining = set(range(len(hull.simplices)))
    for first in sorted(remaining, key=lambda number: -areas[number]):  # the largest triangle defines the plane best
        if first not in remaining:
            continue
        heights = np.abs(points[hull.simplices] @ normals[first] + offsets[first]).max(axis=1)
        facing = hull.equations[:, :3] @ normals[first] > 0.0
        # The normal of a sliver is undefined, so it only needs its corners in the plane.
        coplanar = {n for n in remaining if heights[n] <= written and (facing[n] or areas[n] <= written)}
        group, front = {first}, [first]
        while front:
            front = [n for number in front for n in hull.neighbors[number].tolist() if n in coplanar and n not in group]
            group.update(front)
        remaining -= group
        yield sorted(group)


def _across(points: Array, triangles: NDArray[np.int_]) -> Array:
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.cross(b - a, c - a)


def _plane(points: Array, group: Sequence[int], hull: ConvexHull) -> tuple[Array, list[int]]:
    """Return the outward normal of a face, and the points on it."""
    largest = max(group, key=lambda n: float(np.linalg.norm(_across(points, hull.simplices[[n]]))))
    normal = hull.equations[largest, :3]
    on = sorted({int(corner) for number in group for corner in hull.simplices[number]})
    return normal, on


def _loop(points: Array, on: Sequence[int], normal: Array, written: float) -> list[int]:
    """Return the corners of a face in order, without points within it or within an edge."""
    middle = points[on].mean(axis=0)
    first = points[on[0]] - middle
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    arms = points[on] - middle
    flat = dict(zip(zip((arms @ first).tolist(), (arms @ second).tolist(), strict=True), on, strict=True))
    around = convex_hull(flat)
    start = min(range(len(around)), key=lambda number: atan2(around[number][1], around[number][0]))
    loop = [flat[point] for point in (*around[start:], *around[:start])]
    index = 0
    while len(loop) > 3 and index < len(loop):  # noqa: PLR2004 -- a triangle is the least
        before, here, after = points[loop[index - 1]], points[loop[index]], points[loop[(index + 1) % len(loop)]]
        side = after - before
        length = float(np.linalg.norm(side))
        sticks_out = float(np.linalg.norm(np.cross(here - before, side))) / length if length > 0.0 else 0.0
        if sticks_out <= written:
            del loop[index]
            index = max(index - 2, 0)
        else:
            index += 1
    return loop


def _in_order(
    points: Sequence[Vec3],
    loops: Sequence[Sequence[int]],
    scaled: Array,
    planes: Sequence[tuple[Array, list[int]]],
    written: float,
) -> tuple[list[Vec3], list[tuple[int, ...]], list[int]]:
    faces_at: dict[int, int] = defaultdict(int)
    for loop in loops:
        for corner in loop:
            faces_at[corner] += 1
    corners = sorted(faces_at)
    if min(faces_at.values()) < LEAST_FACES_AT_A_CORNER or not _is_a_sphere(len(corners), loops):
        raise NotASolidError(
            "the corners are too close together, or the faces too nearly coplanar, to be distinguished",
            "remove corners that differ only by rounding",
        )
    new = {corner: number for number, corner in enumerate(corners)}
    depths = np.array([normal @ scaled[on[0]] for normal, on in planes]) - scaled @ np.array([n for n, _ in planes]).T
    inside = [number for number in range(len(points)) if float(depths[number].min()) > written]
    return [_vector(points[c]) for c in corners], [tuple(new[c] for c in loop) for loop in loops], inside


def _is_a_sphere(corners: int, loops: Sequence[Sequence[int]]) -> bool:
    """Check that faces form one closed surface without holes (Euler's formula)."""
    sides = {pair for loop in loops for pair in pairwise((*loop, loop[0]))}
    closed = all((end, start) in sides for start, end in sides)
    return closed and corners + len(loops) - len(sides) // 2 == 2  # noqa: PLR2004 -- of a sphere


def _vector(point: Sequence[float]) -> Vec3:
    x, y, z = (float(part) for part in point)
    return (x, y, z)


# Volume, centroid and second moments of a solid from its surface: closed forms of tetrahedra on its triangles.
#
# The divergence theorem turns an integral over a solid into one over its surface. With flat faces it is a sum over the
# tetrahedra of triangles and an arbitrary apex, with signs for an apex outside.


@dataclass(frozen=True, slots=True, eq=False)
class MeshIntegrals:
    """Integrals over a solid of uniform density."""

    volume: float  # [m3]; negative if its faces look inwards
    centre: Vec3  # centroid [m]
    second: Array  # of x x^T about the centre, (3, 3) [m5]

    @property
    def inertia(self) -> Array:
        """The inertia tensor about the centroid at a density of 1, (3, 3) [m5]."""
        tensor: Array = np.trace(self.second) * np.eye(3) - self.second
        return tensor


def integrals(corners: Sequence[Vec3], loops: Iterable[Sequence[int]]) -> MeshIntegrals:
    """Integrate over the solid bounded by flat faces, whose corners run counter-clockwise seen from outside."""
    points = np.array(corners)
    apex = points.mean(axis=0)  # near the solid, as the products lose digits far from it
    fans = [(loop[0], start, end) for loop in loops for start, end in pairwise(loop[1:])]
    a, b, c = (points[[fan[n] for fan in fans]] - apex for n in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = a + b + c
    volume = float(parts.sum())
    first = np.einsum("i,ij->j", parts, total) / 4.0
    second = sum(np.einsum("i,ij,ik->jk", parts, v, v) for v in (a, b, c, total)) / 20.0
    centre = first / volume if volume else np.zeros(3)
    x, y, z = (float(part) for part in apex + centre)
    return MeshIntegrals(volume, (x, y, z), second - volume * np.outer(centre, centre))


# Convex solids from their corners, from an outline and a depth, or from the faces of a mesh.


MOST_FACES: Final = 200  # contact detection compares all pairs of edges; engines accept hulls of some 250 corners
ALIGNED: Final = 1e-12  # share of the moments: smaller products of inertia are rounding


@dataclass(frozen=True, slots=True)
class FramedSolid:
    """Solid with the position of its centre of mass in the frame of its input."""

    shape: ConvexSolid
    centre_of_mass: Vec3  # in the frame of the input, whose axes are the body axes [m]


def solid_of_corners(points: Sequence[Vec3], centre_of_mass: Vec3 | None = None) -> FramedSolid:
    """Create the convex hull of points, all of which must be corners or lie on its surface.

    `centre_of_mass` is in the frame of the points; the default is that of uniform density. Raises NotASolidError for
    fewer than four points, too many points, points in a plane or inside the hull, and a centre of mass outside.
    """
    points = _admitted(points, 3, "corners", "x, y and z in metres")
    _admit_centre(centre_of_mass)
    corners, loops, inside = hull_faces(points)
    if inside:
        raise NotASolidError(
            f"point {inside[0] + 1} is not a corner, since it lies inside the hull of the other points",
            "remove this point",
            inside[0],
        )
    return _made(corners, loops, centre_of_mass)


def prism(outline: Sequence[tuple[float, float]], depth: float, centre_of_mass: Vec3 | None = None) -> FramedSolid:
    """Create a prism with an outline in the x-z plane, seen from -y, and half of `depth` [m] on both sides of it.

    The outline may run in either direction. Raises NotASolidError if it is not convex, and as `solid_of_corners`.
    """
    outline = _admitted(outline, 2, "corners of an outline", "x and z in metres")
    remedy = f"write a number from {SHORTEST:g} to {LONGEST:g}, in metres"
    admit_in_range("the depth of the prism is", depth, SHORTEST, LONGEST, remedy)
    _admit_centre(centre_of_mass)
    _admit_outline(outline)
    half = 0.5 * depth
    corners, loops, _ = hull_faces([(x, y, z) for y in (-half, half) for x, z in outline])
    return _made(corners, loops, centre_of_mass)


def _admitted(points: Sequence[tuple[float, ...]], count: int, noun: str, coordinates: str) -> list[tuple[Any, ...]]:
    """Return points of `count` coordinates each. Raises TypeError for other values, ValueError if out of range."""
    points = listed(points, f"{noun}, each {coordinates}")
    for number, point in enumerate(points, start=1):
        _admit_place(f"point {number} is", point, count, f"write {coordinates}")
    converted = [tuple(map(float, point)) for point in points]
    if converted and max(max(along) - min(along) for along in zip(*converted, strict=True)) < SHORTEST:
        message = f"the extent of the points is less than {SHORTEST:g} m"
        raise NotASolidError(message, "check the unit, which is metres")
    return converted


def _admit_place(subject: str, point: Sequence[float], count: int, remedy: str) -> None:
    admit_numbers(subject, point, count, remedy)
    if not all(-LONGEST <= part <= LONGEST for part in point):
        raise ValueError(f"{subject} {short_repr(tuple(point))}; {remedy}, within {LONGEST:g} m of the origin")


def _admit_centre(centre_of_mass: Vec3 | None) -> None:
    if centre_of_mass is not None:
        _admit_place("the centre of mass is", centre_of_mass, 3, "write x, y and z in metres")


def _admitted_loops(faces: Sequence[Sequence[int]], count: int) -> list[list[int]]:
    """Check faces that list corners by number. Raises TypeError or ValueError for other values."""
    loops = listed(faces, "faces, each a list of corner numbers")
    for number, loop in enumerate(loops, start=1):
        sequence = isinstance(loop, Sequence) or (isinstance(loop, np.ndarray) and loop.ndim == 1)
        if not sequence or not all(isinstance(corner, Integral) and not isinstance(corner, bool) for corner in loop):
            raise TypeError(f"face {number} is {short_repr(loop)}; list the numbers of its corners, from 0")
        if len(loop) < 3 or not all(0 <= corner < count for corner in loop):  # noqa: PLR2004 -- as a triangle has
            corners = f"corner numbers run from 0 to {count - 1}"
            raise ValueError(f"face {number} is {short_repr(tuple(loop))}; list at least three corners; {corners}")
    return [[int(corner) for corner in loop] for loop in loops]


def _admit_outline(outline: Sequence[tuple[float, float]]) -> None:
    points = np.array(outline, dtype=float).reshape(-1, 2)
    sides = np.roll(points, -1, axis=0) - points
    before = np.roll(sides, 1, axis=0)
    turns = before[:, 0] * sides[:, 1] - before[:, 1] * sides[:, 0]
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if extent == 0.0 or np.abs(turns.sum()) <= FLUSH * extent**2:
        raise NotASolidError(
            "the outline has no area, or crosses itself", "write at least three corners, in order around the outline"
        )
    sense = 1.0 if turns.sum() > 0.0 else -1.0
    slack = FLUSH * extent * extent
    dents = np.flatnonzero(sense * turns < -slack)
    if len(dents):
        corner = int(dents[0])
        raise NotConvexError(
            f"the outline is not convex: it turns inwards at corner {corner + 1}",
            "write the corners in order around the outline, or divide it into convex parts that touch",
            corner,
        )
    lengths = np.hypot(*sides.T)
    nonzero = lengths > 0.0
    angles = np.arctan2(turns, np.einsum("ij,ij->i", before, sides))
    if not nonzero.all() or abs(abs(float(angles.sum())) - 2.0 * np.pi) > 1.0:
        message = "the outline crosses itself" if nonzero.all() else "two corners of the outline coincide"
        raise NotASolidError(message, "write each corner once, in order around the outline")


def solid_of_mesh(
    points: Sequence[Vec3], loops: Sequence[Sequence[int]], centre_of_mass: Vec3 | None = None
) -> FramedSolid:
    """Create the solid bounded by faces whose corners run counter-clockwise seen from outside.

    Raises NotASolidError for faces that leave a hole, look inwards, or bound no convex solid, and as
    `solid_of_corners`.
    """
    points = _admitted(points, 3, "corners", "x, y and z in metres")
    loops = _admitted_loops(loops, len(points))
    _admit_centre(centre_of_mass)
    admit_closed(loops)
    used = sorted({corner for loop in loops for corner in loop})
    extent = float(np.ptp(np.array([points[n] for n in used]), axis=0).max())
    volume = integrals(points, loops).volume
    if abs(volume) <= FLUSH * extent**3:
        raise NotASolidError("the faces enclose no volume", "write faces that enclose a volume")
    if volume < 0.0:
        raise NotASolidError(
            "the faces are oriented inwards",
            "list the corners of each face counter-clockwise, as seen from outside the solid",
        )
    corners, hull_loops, inside = hull_faces([points[n] for n in used])
    hull_volume = integrals(corners, hull_loops).volume
    if inside or hull_volume - volume > file_tolerance(corners, hull_loops) * extent**3:
        share = 100.0 * (1.0 - volume / hull_volume)
        where = f": corner {used[inside[0]] + 1} is inside its hull" if inside else ""
        raise NotConvexError(
            f"the solid is not convex{where}; its volume is {share:.3g} % less than that of its hull",
            "divide it into convex parts that touch, or write `points` for its hull",
            used[inside[0]] if inside else None,
        )
    return _made(corners, hull_loops, centre_of_mass)


def admit_closed(loops: Sequence[Sequence[int]]) -> None:
    """Raise NotASolidError unless each edge belongs to two faces that traverse it in opposite directions."""
    if len(loops) < 4:  # noqa: PLR2004 -- a tetrahedron has four
        raise NotASolidError(f"{len(loops)} faces enclose no volume", "write at least four faces")
    face_of_edge: dict[tuple[int, int], int] = {}
    for number, loop in enumerate(loops):
        for edge in pairwise((*loop, loop[0])):
            if edge in face_of_edge:
                both = f"faces {face_of_edge[edge] + 1} and {number + 1}"
                raise NotASolidError(
                    f"{both} traverse their common edge in the same direction, so one of them faces inwards",
                    "list the corners of each face counter-clockwise, as seen from outside the solid",
                    number,
                )
            face_of_edge[edge] = number
    for (start, end), number in face_of_edge.items():
        if (end, start) not in face_of_edge:
            edge_description = f"the edge of face {number + 1} from corner {start + 1} to {end + 1}"
            raise NotASolidError(
                f"the mesh has a hole: no other face has {edge_description}",
                "add the missing face",
                number,
            )


def _made(corners: Sequence[Vec3], loops: Sequence[Sequence[int]], centre_of_mass: Vec3 | None) -> FramedSolid:
    if len(loops) > MOST_FACES:
        raise NotASolidError(f"the solid has {len(loops)} faces; the maximum is {MOST_FACES}", "simplify the solid")
    filled = integrals(corners, loops)
    centre = filled.centre if centre_of_mass is None else _three(centre_of_mass)
    about = [subtract(corner, centre) for corner in corners]
    faces = tuple(_face(about, loop) for loop in loops)
    for face in faces:
        if sum(a * b for a, b in zip(face.normal, about[face.corners[0]], strict=True)) <= 0.0:
            raise NotASolidError("the centre of mass lies outside the solid", "write a point inside it")
    moments, axes = _principal(filled)
    edges = sorted({(min(pair), max(pair)) for loop in loops for pair in pairwise((*loop, loop[0]))})
    points = np.array(about)
    shape = ConvexSolid(
        tuple(about),
        faces,
        moments,
        axes,
        tuple(edges),
        filled.volume,
        _least_thickness(points, faces, edges),
        float(np.ptp(points, axis=0).max()),
        max(map(norm, about)),
    )
    return FramedSolid(shape, centre)


def _three(parts: Iterable[float]) -> Vec3:
    x, y, z = map(float, parts)
    return (x, y, z)


def _face(corners: Sequence[Vec3], loop: Sequence[int]) -> Face:
    """Create a face with the normal of its whole loop (Newell), which is accurate in spite of short edges."""
    points = np.array([corners[n] for n in loop])
    points = points - points[0]
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    return Face(unit((float(normal[0]), float(normal[1]), float(normal[2]))), tuple(loop))


def _principal(filled: MeshIntegrals) -> tuple[Vec3, Quaternion]:
    """Return the principal moments at a mass of 1, and the rotation from their axes to the body axes."""
    tensor = filled.inertia / filled.volume
    across = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if across <= ALIGNED * np.trace(tensor):
        a, b, c = (float(part) for part in np.diag(tensor))
        return (a, b, c), IDENTITY
    return principal_axes(tensor.tolist())


def _least_thickness(points: Array, faces: Sequence[Face], edges: Iterable[tuple[int, int]]) -> float:
    """Return the least width, which is perpendicular to a face or to two edges that are not parallel."""
    return min(
        float(np.ptp(points @ directions.T, axis=0).min())
        for directions in _width_directions(points, faces, edges)
        if len(directions)
    )


def _width_directions(points: Array, faces: Sequence[Face], edges: Iterable[tuple[int, int]]) -> Iterator[Array]:
    yield np.array([face.normal for face in faces])
    ends = np.array(list(edges))
    directions = points[ends[:, 1]] - points[ends[:, 0]]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for number, direction in enumerate(directions):  # row by row, to save memory for stones of 200 faces
        products = np.cross(direction, directions[number + 1 :])
        lengths = np.linalg.norm(products, axis=1)
        yield products[lengths > FLUSH] / lengths[lengths > FLUSH, None]


# Shapes whose faces are moved inwards, for engines that round them outwards by the same distance.


def inset_corners(shape: ConvexShape, distance: float) -> Sequence[Vec3]:
    """Return the corners of a shape with its faces moved inwards by a distance [m], relative to its centre of mass.

    `distance` is less than a quarter of the least thickness, which is the least depth of a convex solid's centroid.
    """
    boxed = box_of(shape)
    if boxed is not None:
        (a, b, c), (x, y, z) = boxed[0].size, boxed[1]
        inner = Box((a - 2.0 * distance, b - 2.0 * distance, c - 2.0 * distance))
        return inner.corners if boxed[0] is shape else [(x + p, y + q, z + r) for p, q, r in inner.corners]
    import numpy as np  # noqa: PLC0415 -- boxes do without
    from scipy.spatial import ConvexHull, HalfspaceIntersection  # noqa: PLC0415

    unit = 1.0 / shape.length  # Qhull's tolerances are for numbers near 1
    faces = [(*face.normal, unit * (distance - shape.reach(face.normal))) for face in shape.faces]
    middle = integrals(shape.corners, [face.corners for face in shape.faces]).centre
    points = HalfspaceIntersection(np.array(faces), np.array(scale(unit, middle))).intersections
    corners = points[np.sort(ConvexHull(points).vertices)]
    return [(float(x) / unit, float(y) / unit, float(z) / unit) for x, y, z in corners]
