"""Exact division of a solid with flat faces into convex parts, along the planes of its faces.

The bounding box of the solid is divided by planes of faces until no face lies inside a cell. Each cell is then inside
the solid or outside it. The cells inside are joined in pairs as long as their union is convex.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, combinations, count, pairwise, product
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from stability.geometry.box import Box
from stability.geometry.compound import MOST_PARTS
from stability.geometry.compound_making import FramedCompound, compound
from stability.geometry.convex_solid import NotASolidError
from stability.geometry.polygons import Point2
from stability.geometry.rows import Array
from stability.geometry.solid_making import (
    FramedSolid,
    NotConvexError,
    admit_closed,
    integrals,
    prism,
    solid_of_corners,
    solid_of_mesh,
)
from stability.model import ConvexShape, Pose, Vec3

MOST_TRIANGLES: Final = 2000  # of a mesh to divide
MOST_CELLS: Final = 4 * MOST_PARTS  # inside the solid, before they are joined
MOST_WORK: Final = 60_000  # pieces of faces that are cut, in some seconds
TRIED: Final = 24  # planes of which the best is chosen for a cut
ON_PLANE: Final = 1e-5  # share of the extent: corners of files this near to a plane lie on it
EMPTY: Final = 1e-9  # share of the cubed extent: a smaller cell is rounding
SLIVER: Final = 1e-5  # share of the cubed extent: a part that may be left out if it cannot be made
BOX_CORNERS: Final = 8
SLOPPY: Final = (2e-5, 1e-4, 5e-4)  # shares of the extent within which corners of a part are merged
DENTED: Final = 1e-3  # share of the volume of its hull that a solid clearly lacks
WHOLE: Final = 1e-4  # share of the volume by which all parts together may differ from the solid


@dataclass(frozen=True, slots=True)
class _Piece:
    """A part of a face of the solid."""

    plane: int
    corners: Array  # (k, 3), in order


@dataclass(frozen=True, slots=True)
class _Cell:
    """A convex cell, with the pieces of faces inside it."""

    faces: list[Array]  # corners of each, in order
    pieces: list[_Piece]

    @property
    def corners(self) -> Array:
        corners: Array = np.concatenate(self.faces)
        return corners


def body_of_mesh(
    points: Sequence[Vec3], loops: Sequence[Sequence[int]], centre_of_mass: Vec3 | None = None
) -> FramedSolid | FramedCompound:
    """Create the body bounded by faces whose corners run counter-clockwise seen from outside.

    It is a convex solid, or a compound of convex parts. Raises NotASolidError for faces that bound no solid, and for
    too many of them.
    """
    try:
        return solid_of_mesh(points, loops, centre_of_mass)
    except NotASolidError as error:
        if not isinstance(error, NotConvexError):
            admit_closed(loops)
            if not _is_dented(points, loops):
                raise
        parts = convex_parts(points, loops)
        extent = max(max(along) - min(along) for along in zip(*chain(*parts), strict=True))
        made = [_part(corners, extent) for corners in parts]
        return compound([part for part in made if part is not None], centre_of_mass, SLOPPY[-1] * extent)


def bent_prism(
    outline: Sequence[tuple[float, float]], depth: float, centre_of_mass: Vec3 | None = None
) -> FramedSolid | FramedCompound:
    """Create a prism as `prism` does, in convex parts if its outline is not convex. Raises NotASolidError."""
    try:
        return prism(outline, depth, centre_of_mass)
    except NotConvexError:
        pass
    _admit_simple(outline)
    corners = np.array(outline, dtype=float)
    turned = np.roll(corners, -1, axis=0)
    if float((corners[:, 0] * turned[:, 1] - corners[:, 1] * turned[:, 0]).sum()) < 0.0:
        outline = outline[::-1]
    count = len(outline)
    points = [(x, y, z) for y in (-0.5 * depth, 0.5 * depth) for x, z in outline]
    sides = [(i, i + count, (i + 1) % count + count, (i + 1) % count) for i in range(count)]
    return body_of_mesh(points, [range(count), range(2 * count - 1, count - 1, -1), *sides], centre_of_mass)


def _admit_simple(outline: Sequence[tuple[float, float]]) -> None:
    """Raise NotASolidError for an outline that crosses or touches itself."""
    sides = [*zip(outline, (*outline[1:], outline[0]), strict=True)]
    for (one, (a, b)), (other, (c, d)) in combinations(enumerate(sides), 2):
        beside = other - one in {1, len(sides) - 1}
        if not beside and _meet(a, b, c, d):
            raise NotASolidError(
                f"the outline crosses itself between corners {one + 1} and {other + 1}",
                "write the corners in order around the outline",
                other,
            )


def _meet(a: Point2, b: Point2, c: Point2, d: Point2) -> bool:
    """Return whether two line segments have a point in common."""

    def side(start: Point2, end: Point2, point: Point2) -> float:
        return (end[0] - start[0]) * (point[1] - start[1]) - (end[1] - start[1]) * (point[0] - start[0])

    spans = [[sorted((one[k], other[k])) for k in (0, 1)] for one, other in ((a, b), (c, d))]
    near = all(first[0] <= second[1] and second[0] <= first[1] for first, second in zip(*spans, strict=True))
    return near and side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0


def _is_dented(points: Sequence[Vec3], loops: Sequence[Sequence[int]]) -> bool:
    """Return whether the volume of a closed mesh is clearly less than that of its hull."""
    try:
        hull = ConvexHull(np.array(points)[sorted({corner for loop in loops for corner in loop})])
    except QhullError:
        return False
    return 0.0 < integrals(points, loops).volume < (1.0 - DENTED) * float(hull.volume)


def _part(corners: Sequence[Vec3], extent: float) -> tuple[ConvexShape, Pose] | None:
    """Return the solid of these corners with the place of its centre of mass; a box if it is one along the axes.

    Corners that are nearly at one place, where faces are nearly in one plane, are merged; None if nothing remains of a
    sliver. Raises NotASolidError.
    """
    spans = [(min(along), max(along)) for along in zip(*corners, strict=True)]
    slack = ON_PLANE * max(high - low for low, high in spans)
    if len(corners) == BOX_CORNERS and all(
        min(along - low, high - along) <= slack
        for corner in corners
        for along, (low, high) in zip(corner, spans, strict=True)
    ):
        (ax, bx), (ay, by), (az, bz) = spans
        return Box((bx - ax, by - ay, bz - az)), Pose((0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz)))
    for slack in SLOPPY:
        kept = _different(np.array(corners), slack * extent)
        try:
            made = solid_of_corners([_vector(corner) for corner in kept[np.sort(ConvexHull(kept).vertices)]])
        except (NotASolidError, QhullError):
            continue
        return made.shape, Pose(made.centre_of_mass)
    if _volume(np.array(corners)) <= SLIVER * extent**3:
        return None
    raise _curved("faces of the solid that are nearly in one plane cannot be distinguished")


def convex_parts(points: Sequence[Vec3], loops: Sequence[Sequence[int]]) -> list[list[Vec3]]:
    """Return the corners of convex parts that together are the solid bounded by faces [m].

    The corners of each face run counter-clockwise seen from outside. Raises NotASolidError if the faces intersect each
    other, or the solid has too many faces or parts, as a curved one has.
    """
    array = np.array(points, dtype=float)
    low = array.min(axis=0)
    extent = float(np.ptp(array, axis=0).max())
    array = (array - low) / extent
    triangles = _triangles(array, loops)
    if len(triangles) > MOST_TRIANGLES:
        raise _curved(
            f"the mesh has {len(triangles)} triangles; the maximum for a solid that is not convex is {MOST_TRIANGLES}"
        )
    normals, offsets, pieces = _planes(triangles)
    cells = _joined(list(_inside(_cut(_box(pieces), normals, offsets), triangles)))
    if len(cells) > MOST_PARTS:
        raise _curved(f"the solid has more than {MOST_PARTS} convex parts")
    volume = float(np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum()) / 6.0
    if abs(sum(ConvexHull(cell).volume for cell in cells) - volume) > WHOLE * volume:
        raise NotASolidError("the faces of the solid intersect each other", "repair the mesh")
    return [[_vector(low + extent * corner) for corner in cell] for cell in cells]


def _curved(message: str) -> NotASolidError:
    return NotASolidError(message, "simplify the mesh, or write its hull as `points`")


def _vector(point: Array) -> Vec3:
    x, y, z = point.tolist()
    return (x, y, z)


def _triangles(points: Array, loops: Sequence[Sequence[int]]) -> Array:
    """Return the triangles of faces, as fans (n, 3, 3); those of a dented face cancel each other where they overlap."""
    fans = [
        (loop[0], start, end) for loop in map(partial(_from_best, points), loops) for start, end in pairwise(loop[1:])
    ]
    triangles = points[np.array(fans, dtype=int)]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    kept: Array = triangles[areas > 0.0]
    return kept


def _from_best(points: Array, loop: Sequence[int]) -> Sequence[int]:
    """Return a face, starting at a corner from which all of it is visible, if there is one.

    From other corners triangles of a warped face may overlap without cancelling each other.
    """
    corners = points[list(loop)] - points[loop[0]]
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    for start in range(len(loop)):
        arms = np.roll(corners, -start, axis=0)[1:] - corners[start]
        if (np.cross(arms[:-1], arms[1:]) @ normal >= 0.0).all():
            return [*loop[start:], *loop[:start]]
    return loop


def _planes(triangles: Array) -> tuple[Array, Array, list[_Piece]]:
    """Return the different planes of triangles, the largest first, and the triangles as pieces of them."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(across, axis=1)
    normals: list[Array] = []
    offsets: list[float] = []
    pieces = []
    for number in np.argsort(-areas, kind="stable").tolist():
        triangle = triangles[number]
        heights = (
            np.abs(triangle @ np.array(normals).reshape(-1, 3).T - np.array(offsets)) if normals else np.ones((3, 0))
        )
        near = np.flatnonzero(heights.max(axis=0) <= ON_PLANE)
        if not len(near):
            normals.append(across[number] / areas[number])
            offsets.append(float(normals[-1] @ triangle.mean(axis=0)))
            near = np.array([len(normals) - 1])
        pieces.append(_Piece(int(near[0]), triangle))
    return np.array(normals), np.array(offsets), pieces


def _box(pieces: list[_Piece]) -> _Cell:
    """Return the bounding box with a margin."""
    corners = np.concatenate([piece.corners for piece in pieces])
    low, high = corners.min(axis=0) - 0.1, corners.max(axis=0) + 0.1
    faces = []
    for axis, side in product(range(3), (low, high)):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        face = np.tile(side, (4, 1))
        for row, (one, other) in enumerate(((low, low), (high, low), (high, high), (low, high))):
            face[row, first], face[row, second] = one[first], other[second]
        faces.append(face)
    return _Cell(faces, pieces)


def _cut(whole: _Cell, normals: Array, offsets: Array) -> Iterator[_Cell]:
    """Yield the cells without faces inside them into which planes of faces divide a cell. Raises NotASolidError."""
    waiting, work = [whole], 0
    while waiting:
        cell = waiting.pop()
        if not cell.pieces:
            yield cell
            continue
        work += len(cell.pieces)
        if work > MOST_WORK:
            raise _curved("dividing the solid into convex parts takes too long")
        plane = _best(cell.pieces, normals, offsets)
        normal, offset = normals[plane], float(offsets[plane])
        for side in (1.0, -1.0):
            half = _half(cell, plane, side * normal, side * offset)
            if half is not None:
                waiting.append(half)


def _best(pieces: Sequence[_Piece], normals: Array, offsets: Array) -> int:
    """Return the plane that divides the fewest pieces; of several, the one with most of the faces."""
    counts = np.bincount([piece.plane for piece in pieces], minlength=len(normals))
    tried = np.argsort(-counts, kind="stable")[:TRIED]
    tried = tried[counts[tried] > 0]
    corners = np.concatenate([piece.corners for piece in pieces])
    starts = np.cumsum([0, *(len(piece.corners) for piece in pieces[:-1])])
    heights = corners @ normals[tried].T - offsets[tried]
    low, high = np.minimum.reduceat(heights, starts), np.maximum.reduceat(heights, starts)
    divided = ((low < -ON_PLANE) & (high > ON_PLANE)).sum(axis=0)
    return int(tried[int(np.argmin(divided))])


def _half(cell: _Cell, plane: int, normal: Array, offset: float) -> _Cell | None:
    """Return the part of a cell below a plane; None if it is empty."""
    faces, border = [], []
    for face in cell.faces:
        below, on = _below(face, normal, offset)
        if len(below) > 2:  # noqa: PLR2004 -- a polygon has three corners
            faces.append(below)
        border.extend(on)
    if len(border) > 2 and faces:  # noqa: PLR2004
        faces.append(_ordered(np.array(border), normal))
    heights = np.concatenate(faces) @ normal - offset if faces else np.zeros(1)
    if float(heights.min()) >= -ON_PLANE:
        return None
    pieces = []
    for piece in cell.pieces:
        if piece.plane != plane:
            below, _ = _below(piece.corners, normal, offset)
            if len(below) > 2 and float((below @ normal - offset).min()) < -ON_PLANE:  # noqa: PLR2004
                pieces.append(_Piece(piece.plane, below))
    return _Cell(faces, pieces)


def _below(polygon: Array, normal: Array, offset: float) -> tuple[Array, list[Array]]:
    """Return the part of a polygon below a plane, and its corners on the plane."""
    heights = polygon @ normal - offset
    if float(heights.max()) <= ON_PLANE:
        return polygon, [corner for corner, height in zip(polygon, heights, strict=True) if height >= -ON_PLANE]
    kept, on = [], []
    for number, (corner, height) in enumerate(zip(polygon, heights, strict=True)):
        before, was = polygon[number - 1], heights[number - 1]
        if (was < -ON_PLANE and height > ON_PLANE) or (was > ON_PLANE and height < -ON_PLANE):
            kept.append(before + was / (was - height) * (corner - before))
            on.append(kept[-1])
        if height <= ON_PLANE:
            kept.append(corner)
            if height >= -ON_PLANE:
                on.append(corner)
    return np.array(kept).reshape(-1, 3), on


def _ordered(points: Array, normal: Array) -> Array:
    """Return points of a plane in order around their mean."""
    arms = points - points.mean(axis=0)
    first = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    second = np.cross(normal, first)
    ordered: Array = points[np.argsort(np.arctan2(arms @ second, arms @ first), kind="stable")]
    return ordered


def _inside(cells: Iterator[_Cell], triangles: Array) -> Iterator[Array]:
    """Yield the corners of the cells inside the solid. Raises NotASolidError for too many."""
    found = 0
    for cell in cells:
        corners = _different(cell.corners)
        if len(corners) > 3 and _volume(corners) > EMPTY and _winding(corners.mean(axis=0), triangles) > 0.5:  # noqa: PLR2004
            found += 1
            if found > MOST_CELLS:
                raise _curved(f"the solid has more than {MOST_CELLS} convex parts")
            yield corners


def _winding(point: Array, triangles: Array) -> float:
    """Return the winding number of the surface about a point: the sum of solid angles (van Oosterom and Strackee)."""
    a, b, c = (triangles[:, n] - point for n in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc
    for one, other, length in ((a, b, lc), (b, c, la), (c, a, lb)):
        below += np.einsum("ij,ij->i", one, other) * length
    return float(np.arctan2(above, below).sum()) / (2.0 * np.pi)


def _different(points: Array, slack: float = 2.0 * ON_PLANE) -> Array:
    """Return points that are further apart than a distance."""
    kept: list[Array] = []
    for point in points:
        if not kept or float(np.abs(np.array(kept) - point).max(axis=1).min()) > slack:
            kept.append(point)
    return np.array(kept)


def _volume(corners: Array) -> float:
    try:
        return float(ConvexHull(corners).volume)
    except QhullError:
        return 0.0


def _joined(cells: list[Array]) -> list[Array]:
    """Join two cells as long as their union is convex."""
    if len(cells) > MOST_PARTS:
        return cells
    there = {number: (cell, _volume(cell)) for number, cell in enumerate(cells)}
    numbers = count(len(cells))
    waiting = [pair for pair in combinations(there, 2) if not _apart(there[pair[0]][0], there[pair[1]][0])]
    while waiting:
        one, other = waiting.pop(0)
        if one not in there or other not in there:
            continue
        both, total = np.concatenate((there[one][0], there[other][0])), there[one][1] + there[other][1]
        hull = ConvexHull(both)
        if hull.volume - total <= ON_PLANE * total:
            del there[one], there[other]
            number, corners = next(numbers), _different(both[hull.vertices])
            waiting += [(each, number) for each in there if not _apart(there[each][0], corners)]
            there[number] = corners, total
    return [cell for cell, _ in there.values()]


def _apart(one: Array, other: Array) -> bool:
    slack = 2.0 * ON_PLANE
    return bool(
        (one.min(axis=0) > other.max(axis=0) + slack).any() or (other.min(axis=0) > one.max(axis=0) + slack).any()
    )
