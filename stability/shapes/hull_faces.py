"""The faces of a convex hull, each with all its corners: Qhull finds triangles, and those in one plane are one face."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from stability.geometry.hulls import convex_hull
from stability.model import Vec3
from stability.shapes.not_a_solid import NotASolidError

Array = NDArray[np.float64]
FLUSH: Final = 1e-9  # share of the extent: what is thinner has no thickness
# Share of the least thickness: nearer to a plane or a line is in it. Files write six decimals of a metre, or single
# precision, and what touches may be two hundred times as far apart.
WRITTEN: Final = 1e-4
LEAST_POINTS: Final = 4
LEAST_FACES_AT_A_CORNER: Final = 3
MOST_POINTS: Final = 100_000
MOST_CORNERS: Final = 1000  # that Qhull sees, some of them amid faces; what is too much for the rest is told there


def hull_faces(points: Sequence[Vec3]) -> tuple[list[Vec3], list[tuple[int, ...]], list[int]]:
    """The corners of the hull of points, its faces counter-clockwise seen from outside, and which points are inside.

    Corners stand in the order of the points; what lies on a face or an edge is neither a corner nor inside. Raises
    NotASolidError if the points lie in a plane, or so close to one that no digits are left.
    """
    if not LEAST_POINTS <= len(points) <= MOST_POINTS:
        raise NotASolidError(
            f"{len(points)} points enclose nothing" if len(points) < LEAST_POINTS else f"{len(points)} points are many",
            f"write {LEAST_POINTS} to {MOST_POINTS} corners",
        )
    given = np.array(points, dtype=float)
    centred = given - given.mean(axis=0)
    extent = float(np.ptp(centred, axis=0).max())
    flat = NotASolidError("all points lie in one plane", "a solid has a thickness")
    if extent == 0.0:
        raise flat
    scaled = centred / extent
    try:
        hull = ConvexHull(scaled)
    except QhullError as error:
        raise flat from error
    if len(hull.vertices) > MOST_CORNERS:
        message = f"the hull of the points has {len(hull.vertices)} corners, and {MOST_CORNERS} is the most"
        raise NotASolidError(message, "write a simpler solid, close to it")
    thickness = float(np.ptp(scaled @ hull.equations[:, :3].T, axis=0).min())
    if thickness <= FLUSH:
        raise flat
    written = WRITTEN * thickness
    planes = [_plane(scaled, group, hull) for group in _groups(scaled, hull, written)]
    loops = [_loop(scaled, on, normal, written) for normal, on in planes]
    return _in_order(points, loops, scaled, planes, written)


def written_share(points: Sequence[Vec3], faces: Sequence[Sequence[int]]) -> float:
    """How far a corner of these faces may be off as files write, as a share of the extent."""
    given = np.array(points, dtype=float)
    normals = np.array([np.cross(given[b] - given[a], given[c] - given[a]) for a, b, c, *_ in faces])
    lengths = np.linalg.norm(normals, axis=1)
    heights = np.ptp(given @ (normals[lengths > 0.0] / lengths[lengths > 0.0, None]).T, axis=0)
    return WRITTEN * float(heights.min()) / float(np.ptp(given, axis=0).max())


def _groups(points: Array, hull: ConvexHull, written: float) -> Iterator[list[int]]:
    """The triangles of each face: neighbours that lie in one plane, as far as files write."""
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    areas = np.linalg.norm(_across(points, hull.simplices), axis=1)
    left = set(range(len(hull.simplices)))
    for first in sorted(left, key=lambda number: -areas[number]):  # the largest says best where the plane is
        if first not in left:
            continue
        heights = np.abs(points[hull.simplices] @ normals[first] + offsets[first]).max(axis=1)
        facing = hull.equations[:, :3] @ normals[first] > 0.0
        # A sliver has no normal of its own to tell by: that its corners lie in the plane is enough.
        with_it = {n for n in left if heights[n] <= written and (facing[n] or areas[n] <= written)}
        group, front = {first}, [first]
        while front:
            front = [n for number in front for n in hull.neighbors[number].tolist() if n in with_it and n not in group]
            group.update(front)
        left -= group
        yield sorted(group)


def _across(points: Array, triangles: NDArray[np.int_]) -> Array:
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.cross(b - a, c - a)


def _plane(points: Array, group: Sequence[int], hull: ConvexHull) -> tuple[Array, list[int]]:
    """The outward normal of a face, and the points on it."""
    largest = max(group, key=lambda n: float(np.linalg.norm(_across(points, hull.simplices[[n]]))))
    normal = hull.equations[largest, :3]
    on = sorted({int(corner) for number in group for corner in hull.simplices[number]})
    return normal, on


def _loop(points: Array, on: Sequence[int], normal: Array, written: float) -> list[int]:
    """The corners of a face in order, without those amid it or amid an edge."""
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
            "its corners are so close together, or its faces so nearly flush, that they cannot be told apart",
            "leave out what differs by rounding only",
        )
    new = {corner: number for number, corner in enumerate(corners)}
    depths = np.array([normal @ scaled[on[0]] for normal, on in planes]) - scaled @ np.array([n for n, _ in planes]).T
    inside = [number for number in range(len(points)) if float(depths[number].min()) > written]
    return [_vector(points[c]) for c in corners], [tuple(new[c] for c in loop) for loop in loops], inside


def _is_a_sphere(corners: int, loops: Sequence[Sequence[int]]) -> bool:
    """Whether faces close up to one surface without holes (Euler's formula)."""
    sides = {pair for loop in loops for pair in pairwise((*loop, loop[0]))}
    closed = all((other, one) in sides for one, other in sides)
    return closed and corners + len(loops) - len(sides) // 2 == 2  # noqa: PLR2004 -- of a sphere


def _vector(point: Sequence[float]) -> Vec3:
    x, y, z = (float(part) for part in point)
    return (x, y, z)
