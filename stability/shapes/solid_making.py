"""Makes convex solids: from their corners, from an outline and a depth, or from the faces of a mesh."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from numbers import Integral
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from stability.geometry.given_numbers import LONGEST, SHORTEST, admit_in_range, admit_numbers, listed, told
from stability.geometry.principal_axes import principal_axes
from stability.geometry.vectors import norm, subtract, unit
from stability.model import IDENTITY, Face, Quaternion, Vec3
from stability.shapes.convex_solid import ConvexSolid
from stability.shapes.hull_faces import FLUSH, hull_faces, written_share
from stability.shapes.mesh_integrals import MeshIntegrals, integrals
from stability.shapes.not_a_solid import NotASolidError

Array = NDArray[np.float64]
MOST_FACES: Final = 200  # edges of two solids are compared each with each; and engines take hulls of some 250 corners
ALIGNED: Final = 1e-12  # share of the moments: products of inertia that rounding leaves of body axes that are principal


@dataclass(frozen=True, slots=True)
class Made:
    """A solid, with where the frame is in which it was written."""

    shape: ConvexSolid
    centre_of_mass: Vec3  # in that frame, whose axes are the body axes [m]


def solid_of_corners(points: Sequence[Vec3], centre_of_mass: Vec3 | None = None) -> Made:
    """The convex hull of points, which are to be corners of it or lie on its surface.

    `centre_of_mass` is in the frame of the points; by default, that of an even filling. Raises NotASolidError: for
    fewer than four points, for points in a plane, inside of the others, or too many, and for a centre of mass outside.
    """
    points = _admitted(points, 3, "corners", "x, y and z in metres")
    _admit_centre(centre_of_mass)
    corners, loops, inside = hull_faces(points)
    if inside:
        raise NotASolidError(
            f"point {inside[0] + 1} is no corner: it lies inside of the others", "leave it out", inside[0]
        )
    return _made(corners, loops, centre_of_mass)


def prism(outline: Sequence[tuple[float, float]], depth: float, centre_of_mass: Vec3 | None = None) -> Made:
    """A solid with an outline in its x-z plane, as seen from -y, that reaches half of `depth` to both sides of it.

    The outline runs either way round. Raises NotASolidError if it is not convex, and as `solid_of_corners`.
    """
    outline = _admitted(outline, 2, "corners of an outline", "x and z in metres")
    remedy = f"write metres, more than 0: a number from {SHORTEST:g} to {LONGEST:g}"
    admit_in_range("a prism has the depth", depth, SHORTEST, LONGEST, remedy)
    _admit_centre(centre_of_mass)
    _admit_outline(outline)
    half = 0.5 * depth
    corners, loops, _ = hull_faces([(x, y, z) for y in (-half, half) for x, z in outline])
    return _made(corners, loops, centre_of_mass)


def _admitted(points: Sequence[tuple[float, ...]], count: int, what: str, parts: str) -> list[tuple[Any, ...]]:
    """Points with this number of coordinates. Raises TypeError for what is not a point, ValueError if out of range."""
    points = listed(points, f"{what}, each {parts}")
    for number, point in enumerate(points, start=1):
        _admit_place(f"point {number} is", point, count, f"write {parts}")
    made = [tuple(map(float, point)) for point in points]
    if made and max(max(along) - min(along) for along in zip(*made, strict=True)) < SHORTEST:
        message = f"all points lie within {SHORTEST:g} m"
        raise NotASolidError(message, "write metres: a solid is larger than that")
    return made


def _admit_place(what: str, point: Sequence[float], count: int, remedy: str) -> None:
    admit_numbers(what, point, count, remedy)
    if not all(-LONGEST <= part <= LONGEST for part in point):
        raise ValueError(f"{what} {told(tuple(point))}; {remedy}, within {LONGEST:g} m of the origin")


def _admit_centre(centre_of_mass: Vec3 | None) -> None:
    if centre_of_mass is not None:
        _admit_place("the centre of mass is", centre_of_mass, 3, "write x, y and z in metres")


def _admitted_loops(given: Sequence[Sequence[int]], count: int) -> list[list[int]]:
    """Faces that list corners by number. Raises TypeError or ValueError for others."""
    loops = listed(given, "faces, each the numbers of its corners")
    for number, loop in enumerate(loops, start=1):
        sequence = isinstance(loop, Sequence) or (isinstance(loop, np.ndarray) and loop.ndim == 1)
        if not sequence or not all(isinstance(corner, Integral) and not isinstance(corner, bool) for corner in loop):
            raise TypeError(f"face {number} is {told(loop)}; list the numbers of its corners, from 0")
        if len(loop) < 3 or not all(0 <= corner < count for corner in loop):  # noqa: PLR2004 -- as a triangle has
            corners = f"there are the corners 0 to {count - 1}"
            raise ValueError(f"face {number} is {told(tuple(loop))}; list three of its corners or more; {corners}")
    return [[int(corner) for corner in loop] for loop in loops]


def _admit_outline(outline: Sequence[tuple[float, float]]) -> None:
    points = np.array(outline, dtype=float).reshape(-1, 2)
    ways = np.roll(points, -1, axis=0) - points
    before = np.roll(ways, 1, axis=0)
    turns = before[:, 0] * ways[:, 1] - before[:, 1] * ways[:, 0]
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if extent == 0.0 or np.abs(turns.sum()) <= FLUSH * extent**2:
        raise NotASolidError(
            "the outline has no area, or crosses itself", "write three corners or more, in order around it"
        )
    sense = 1.0 if turns.sum() > 0.0 else -1.0
    slack = FLUSH * extent * extent
    dents = np.flatnonzero(sense * turns < -slack)
    if len(dents):
        corner = int(dents[0])
        raise NotASolidError(
            f"the outline is not convex: it turns inwards at corner {corner + 1}",
            "write its corners in order around it, or cut it into convex parts that touch",
            corner,
        )
    lengths = np.hypot(*ways.T)
    known = lengths > 0.0
    angles = np.arctan2(turns, np.einsum("ij,ij->i", before, ways))
    if not known.all() or abs(abs(float(angles.sum())) - 2.0 * np.pi) > 1.0:
        message = "the outline crosses itself" if known.all() else "two corners of the outline are one"
        raise NotASolidError(message, "write each of its corners once, in order around it")


def solid_of_mesh(points: Sequence[Vec3], loops: Sequence[Sequence[int]], centre_of_mass: Vec3 | None = None) -> Made:
    """The solid that these faces bound, each its corners counter-clockwise seen from outside.

    Raises NotASolidError for faces that leave a hole, look inwards, or bound nothing convex, and as `solid_of_corners`.
    """
    points = _admitted(points, 3, "corners", "x, y and z in metres")
    loops = _admitted_loops(loops, len(points))
    _admit_centre(centre_of_mass)
    _admit_closed(loops)
    used = sorted({corner for loop in loops for corner in loop})
    extent = float(np.ptp(np.array([points[n] for n in used]), axis=0).max())
    volume = integrals(points, loops).volume
    if abs(volume) <= FLUSH * extent**3:
        raise NotASolidError("the faces enclose no volume", "a solid has a thickness")
    if volume < 0.0:
        raise NotASolidError(
            "the faces look inwards", "list the corners of each face counter-clockwise, as seen from outside"
        )
    corners, hull_loops, inside = hull_faces([points[n] for n in used])
    hull_volume = integrals(corners, hull_loops).volume
    if inside or hull_volume - volume > written_share(corners, hull_loops) * extent**3:
        share = 100.0 * (1.0 - volume / hull_volume)
        where = f": corner {used[inside[0]] + 1} is inside of its hull" if inside else ""
        raise NotASolidError(
            f"the solid is not convex{where}; it fills {share:.3g} % less than its hull",
            "cut it into convex parts that touch, or write `points` for its hull",
            used[inside[0]] if inside else None,
        )
    return _made(corners, hull_loops, centre_of_mass)


def _admit_closed(loops: Sequence[Sequence[int]]) -> None:
    if len(loops) < 4:  # noqa: PLR2004 -- a tetrahedron has four
        raise NotASolidError(f"{len(loops)} faces enclose nothing", "a solid has four faces or more")
    seen: dict[tuple[int, int], int] = {}
    for number, loop in enumerate(loops):
        for edge in pairwise((*loop, loop[0])):
            if edge in seen:
                both = f"faces {seen[edge] + 1} and {number + 1}"
                raise NotASolidError(
                    f"{both} pass their common edge the same way, so one looks inwards",
                    "list the corners of each face counter-clockwise, as seen from outside",
                    number,
                )
            seen[edge] = number
    for (one, other), number in seen.items():
        if (other, one) not in seen:
            edge_told = f"the edge of face {number + 1} from corner {one + 1} to {other + 1}"
            raise NotASolidError(
                f"the mesh has a hole: nothing is beyond {edge_told}",
                "close it",
                number,
            )


def _made(corners: Sequence[Vec3], loops: Sequence[Sequence[int]], centre_of_mass: Vec3 | None) -> Made:
    if len(loops) > MOST_FACES:
        raise NotASolidError(
            f"the solid has {len(loops)} faces, and {MOST_FACES} is the most", "write a simpler solid, close to it"
        )
    filled = integrals(corners, loops)
    centre = filled.centre if centre_of_mass is None else _three(centre_of_mass)
    about = [subtract(corner, centre) for corner in corners]
    faces = tuple(_face(about, loop) for loop in loops)
    for face in faces:
        if sum(a * b for a, b in zip(face.normal, about[face.corners[0]], strict=True)) <= 0.0:
            raise NotASolidError("the centre of mass lies outside of the solid", "write one inside of it")
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
    return Made(shape, centre)


def _three(parts: Iterable[float]) -> Vec3:
    x, y, z = map(float, parts)
    return (x, y, z)


def _face(corners: Sequence[Vec3], loop: Sequence[int]) -> Face:
    """With the normal of the whole loop (Newell), which no short edge makes unclear."""
    points = np.array([corners[n] for n in loop])
    points = points - points[0]
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    return Face(unit((float(normal[0]), float(normal[1]), float(normal[2]))), tuple(loop))


def _principal(filled: MeshIntegrals) -> tuple[Vec3, Quaternion]:
    """Principal moments at a mass of 1, and the turn from their axes to the body axes."""
    tensor = filled.inertia / filled.volume
    across = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if across <= ALIGNED * np.trace(tensor):
        a, b, c = (float(part) for part in np.diag(tensor))
        return (a, b, c), IDENTITY
    return principal_axes(tensor.tolist())


def _least_thickness(points: Array, faces: Sequence[Face], edges: Iterable[tuple[int, int]]) -> float:
    """The least width is across a face, or across two edges that do not run alike."""
    return min(float(np.ptp(points @ ways.T, axis=0).min()) for ways in _width_ways(points, faces, edges) if len(ways))


def _width_ways(points: Array, faces: Sequence[Face], edges: Iterable[tuple[int, int]]) -> Iterator[Array]:
    yield np.array([face.normal for face in faces])
    ends = np.array(list(edges))
    ways = points[ends[:, 1]] - points[ends[:, 0]]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    for number, way in enumerate(ways):  # row by row, or a stone of 200 faces takes much memory
        products = np.cross(way, ways[number + 1 :])
        lengths = np.linalg.norm(products, axis=1)
        yield products[lengths > FLUSH] / lengths[lengths > FLUSH, None]
