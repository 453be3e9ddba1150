"""Convex polyhedra at poses, and their separating directions.

Two convex polyhedra are separated along the normal of a face of one, or along the product of an edge of each. Only
pairs of edges count that form a face of the Minkowski difference, which follows from their adjacent faces
(Gregorius, 2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stability.geometry.box_distance import Axes, InBounds
from stability.geometry.rows import Array
from stability.model import ConvexShape, Vec3

Rows = NDArray[np.int_]
KEPT: Final = 512  # cache size
PARALLEL: Final = 1e-9  # sine of the angle below which edges count as parallel
# Rounding tolerance of the directions that an edge admits, as a sine. A direction on the border is also a face normal.
ADMITTED: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Arrays of a shape, in body axes."""

    corners: Array  # (n, 3) from the centre of mass [m]
    normals: Array  # (f, 3) of the faces, outwards
    reaches: Array  # (f,) of the faces from the centre of mass [m]
    loops: tuple[tuple[int, ...], ...]  # corners of each face
    edges: Rows  # (e, 2) corners
    beside: Rows  # (e, 2) faces on both sides of each edge
    directions: Array  # (e, 3) unit directions of the edges
    bounds: (
        Array  # (e, 2, 3) unit, in the edge's faces, away from it: a normal of the edge has no positive part along them
    )
    faces_at: tuple[tuple[int, ...], ...]  # faces at each corner
    around: tuple[tuple[int, ...], ...]  # corners connected to each corner by an edge


@lru_cache(maxsize=KEPT)
def mesh_of(shape: ConvexShape) -> Mesh:
    """Return the arrays of a shape, from a cache."""
    corners = np.array(shape.corners)
    normals = np.array([face.normal for face in shape.faces])
    loops = tuple(face.corners for face in shape.faces)
    reaches = np.array([float(corners[list(loop)].mean(axis=0) @ n) for loop, n in zip(loops, normals, strict=True)])
    edges = np.array(shape.edges)
    side: dict[tuple[int, int], int] = {}
    for number, loop in enumerate(loops):
        for start, end in zip(loop, (*loop[1:], loop[0]), strict=True):
            side[start, end] = number
    # Seen from outside, the face whose loop contains the edge in this direction is on its left.
    beside = np.array([(side[a, b], side[b, a]) for a, b in edges.tolist()])
    directions = corners[edges[:, 1]] - corners[edges[:, 0]]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    left, right = np.cross(normals[beside[:, 0]], directions), np.cross(directions, normals[beside[:, 1]])
    ends: list[list[int]] = [[] for _ in corners]
    for a, b in edges.tolist():
        ends[a].append(b)
        ends[b].append(a)
    faces_at = tuple(tuple(f for f, loop in enumerate(loops) if corner in loop) for corner in range(len(corners)))
    return Mesh(
        corners,
        normals,
        reaches,
        loops,
        edges,
        beside,
        directions,
        np.stack([left, right], axis=1),
        faces_at,
        tuple(map(tuple, ends)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Hull(InBounds):
    """Convex polyhedron at a pose. Vectors are in W, positions relative to the centre of mass."""

    mesh: Mesh
    p_WC: Vec3  # centre of mass [m]
    axes_W: Axes  # body axes
    corners: Array  # (n, 3) [m]
    normals: Array  # (f, 3)
    directions: Array  # (e, 3)
    bounds: Array  # (e, 2, 3)
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    thickness: float  # least thickness [m]
    length: float  # longest side of the box around the shape along its body axes [m]

    @property
    def edge_middles(self) -> Array:
        """The midpoints of the edges, from the centre of mass (e, 3) [m]."""
        midpoints: Array = self.corners[self.mesh.edges].mean(axis=1)
        return midpoints

    def heights(self, direction_W: Array) -> Array:
        """Return the components of the corners along a direction, from the centre of mass (n,) [m]."""
        components: Array = self.corners @ direction_W
        return components


def hull(shape: ConvexShape, p_WC: Vec3, axes_W: Axes) -> Hull:
    """Create the hull of a shape with this centre of mass [m] and these body axes."""
    mesh, turn = mesh_of(shape), np.array(axes_W)  # type: ignore[arg-type]  # shapes are values, and hashable
    corners = mesh.corners @ turn
    (x, y, z), low, high = p_WC, corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return Hull(
        mesh,
        p_WC,
        axes_W,
        corners,
        mesh.normals @ turn,
        mesh.directions @ turn,
        mesh.bounds @ turn,
        (x + low[0], y + low[1], z + low[2]),
        (x + high[0], y + high[1], z + high[2]),
        shape.least_thickness,
        shape.length,
    )


@dataclass(frozen=True, slots=True, eq=False)
class EdgePairs:
    """Pairs of edges of two hulls, a and b, whose products may separate them."""

    of_a: Rows  # (k,)
    of_b: Rows
    normals_AB: Array  # (k, 3) unit, from a towards b
    gaps: Array  # (k,) [m]


def between(a: Hull, b: Hull) -> Array:
    """Return the vector from the centre of a to that of b [m]."""
    (ax, ay, az), (bx, by, bz) = a.p_WC, b.p_WC
    return np.array((bx - ax, by - ay, bz - az))


def face_gaps(a: Hull, b: Hull, p_AB: Array) -> Array:
    """Return the gap of b outside each face of a (f,) [m]; negative if a corner of b is behind it."""
    gaps: Array = (b.corners @ a.normals.T).min(axis=0) + a.normals @ p_AB - a.mesh.reaches
    return gaps


def edge_pairs(a: Hull, b: Hull, p_AB: Array) -> EdgePairs:
    """Find all pairs of edges with a common normal that both admit."""
    products = _products(a.directions, b.directions)
    lengths = np.linalg.norm(products, axis=2)
    crossing = lengths > PARALLEL
    normals = products / np.where(crossing, lengths, 1.0)[:, :, None]
    pairs = []
    for sign in (1.0, -1.0):
        on_a = sign * np.einsum("ijk,imk->ijm", normals, a.bounds)
        on_b = sign * np.einsum("ijk,jmk->ijm", normals, b.bounds)
        fits = crossing & (on_a <= ADMITTED).all(axis=2) & (on_b >= -ADMITTED).all(axis=2)
        pairs += [(i, j, sign) for i, j in np.argwhere(fits).tolist()]
    if not pairs:
        empty = np.zeros(0, dtype=int)
        return EdgePairs(empty, empty, np.zeros((0, 3)), np.zeros(0))
    of_a, of_b = (np.array([pair[n] for pair in pairs], dtype=int) for n in (0, 1))
    towards = normals[of_a, of_b] * np.array([sign for _, _, sign in pairs])[:, None]
    apart = p_AB + b.edge_middles[of_b] - a.edge_middles[of_a]
    return EdgePairs(of_a, of_b, towards, np.einsum("ij,ij->i", towards, apart))


def _products(first: Array, second: Array) -> Array:
    """Return all pairwise vector products (e, g, 3), several times faster than numpy's for few vectors."""
    (ax, ay, az), (bx, by, bz) = first.T[:, :, None], second.T[:, None, :]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=2)


def separation(a: Hull, b: Hull) -> tuple[float, Vec3]:
    """Return the largest gap of two hulls [m], negative if they overlap, and its unit normal from b towards a."""
    p_AB = between(a, b)
    gaps_a, gaps_b = face_gaps(a, b, p_AB), face_gaps(b, a, -p_AB)
    # Faces come first and win ties: an edge product is never a better normal than that of a face.
    best, normal = float(gaps_a.max()), -a.normals[int(gaps_a.argmax())]
    if float(gaps_b.max()) > best + PARALLEL:
        best, normal = float(gaps_b.max()), b.normals[int(gaps_b.argmax())]
    pairs = edge_pairs(a, b, p_AB)
    if len(pairs.gaps) and float(pairs.gaps.max()) > best + PARALLEL:
        best_pair = int(pairs.gaps.argmax())
        best, normal = float(pairs.gaps[best_pair]), -pairs.normals_AB[best_pair]
    return best, vector(normal)


def passage(moving: Hull, fixed: Hull, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """Return the travel along a unit direction at which a hull enters and leaves another [m]; None if it misses it.

    The centre of the moving hull follows a line through the Minkowski difference of both bodies, whose face normals
    are those of both bodies and the products of their edges. An overlap across the direction of less than `graze` [m]
    counts as a miss.
    """
    direction, p_FM = np.array(direction_W), between(fixed, moving)
    normals = np.concatenate([fixed.normals, -moving.normals, _all_products(fixed, moving)])
    reach = (fixed.corners @ normals.T).max(axis=0) - (moving.corners @ normals.T).min(axis=0)
    heights, speeds = normals @ p_FM - reach, normals @ direction
    if np.any((np.abs(speeds) <= PARALLEL) & (heights > -graze)):
        return None
    into, out = speeds < -PARALLEL, speeds > PARALLEL
    enters = float((heights[into] / -speeds[into]).max(initial=-np.inf))
    leaves = float((-heights[out] / speeds[out]).min(initial=np.inf))
    return (enters, leaves) if enters < leaves else None


def _all_products(a: Hull, b: Hull) -> Array:
    products = _products(a.directions, b.directions).reshape(-1, 3)
    lengths = np.linalg.norm(products, axis=1)
    units = products[lengths > PARALLEL] / lengths[lengths > PARALLEL, None]
    return np.concatenate([units, -units])


def vector(parts: Array | Sequence[float]) -> Vec3:
    """Convert an array of three numbers to a vector."""
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
