"""Convex polyhedra in their places, and along which directions two of them are apart.

Two convex polyhedra are apart along the normal of a face of one, or along the product of an edge of each: of such edges
only whose that meet as faces of the difference of both bodies, which their neighbouring faces say (Gregorius, 2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stability.geometry.box_distance import Axes
from stability.geometry.rows import Array
from stability.model import ConvexShape, Vec3

Rows = NDArray[np.int_]
KEPT: Final = 512  # shapes whose meshes are kept
PARALLEL: Final = 1e-9  # sine below which two edges give no direction of their own
# Sine by which a direction may lie outside of what an edge admits, and still count: rounding. What lies on the border
# is the normal of a face as well.
ADMITTED: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A shape in arrays, in body axes."""

    corners: Array  # (n, 3) from the centre of mass [m]
    normals: Array  # (f, 3) of the faces, outwards
    reaches: Array  # (f,) of the faces from the centre of mass [m]
    loops: tuple[tuple[int, ...], ...]  # the corners of each face
    edges: Rows  # (e, 2) corners
    beside: Rows  # (e, 2) the faces on both sides of each edge
    ways: Array  # (e, 3) unit, along the edges
    bounds: Array  # (e, 2, 3) unit, along the edge's faces, away from it: a normal of the edge leads into neither
    faces_at: tuple[tuple[int, ...], ...]  # the faces around each corner
    around: tuple[tuple[int, ...], ...]  # the corners at the far ends of the edges of each corner


@lru_cache(maxsize=KEPT)
def mesh_of(shape: ConvexShape) -> Mesh:
    """The arrays of a shape, worked out once."""
    corners = np.array(shape.corners)
    normals = np.array([face.normal for face in shape.faces])
    loops = tuple(face.corners for face in shape.faces)
    reaches = np.array([float(corners[list(loop)].mean(axis=0) @ n) for loop, n in zip(loops, normals, strict=True)])
    edges = np.array(shape.edges)
    side: dict[tuple[int, int], int] = {}
    for number, loop in enumerate(loops):
        for one, other in zip(loop, (*loop[1:], loop[0]), strict=True):
            side[one, other] = number
    # The face of which an edge runs counter-clockwise lies to its left, seen from outside.
    beside = np.array([(side[a, b], side[b, a]) for a, b in edges.tolist()])
    ways = corners[edges[:, 1]] - corners[edges[:, 0]]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    left, right = np.cross(normals[beside[:, 0]], ways), np.cross(ways, normals[beside[:, 1]])
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
        ways,
        np.stack([left, right], axis=1),
        faces_at,
        tuple(map(tuple, ends)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """A convex polyhedron in its place. Vectors are in W; places are seen from the body's own centre."""

    mesh: Mesh
    p_WC: Vec3  # its centre of mass [m]
    axes_W: Axes  # of the body
    corners: Array  # (n, 3) from there [m]
    normals: Array  # (f, 3)
    ways: Array  # (e, 3)
    bounds: Array  # (e, 2, 3)
    low_W: Vec3  # of the upright box around it [m]
    high_W: Vec3
    thickness: float  # the least [m]
    length: float  # the longest side of the box around it along its body axes [m]

    @property
    def middle_W(self) -> Vec3:
        """The middle of the upright box around it [m]."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        return (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))

    @property
    def reach(self) -> Vec3:
        """Half of the upright box around it [m]."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        return (0.5 * (bx - ax), 0.5 * (by - ay), 0.5 * (bz - az))

    @property
    def edge_middles(self) -> Array:
        """(e, 3) from its centre of mass [m]."""
        found: Array = self.corners[self.mesh.edges].mean(axis=1)
        return found

    def heights(self, direction_W: Array) -> Array:
        """(n,) of its corners along a direction, from its centre of mass [m]."""
        found: Array = self.corners @ direction_W
        return found


def hull(shape: ConvexShape, p_WC: Vec3, axes_W: Axes) -> Hull:
    """A shape with its centre of mass in a place [m], and its body axes along these."""
    mesh, turn = mesh_of(shape), np.array(axes_W)  # type: ignore[arg-type]  # shapes are values, and hashable
    corners = mesh.corners @ turn
    (x, y, z), low, high = p_WC, corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return Hull(
        mesh,
        p_WC,
        axes_W,
        corners,
        mesh.normals @ turn,
        mesh.ways @ turn,
        mesh.bounds @ turn,
        (x + low[0], y + low[1], z + low[2]),
        (x + high[0], y + high[1], z + high[2]),
        shape.least_thickness,
        shape.length,
    )


@dataclass(frozen=True, slots=True, eq=False)
class EdgePairs:
    """The pairs of edges of two hulls, a and b, along whose products these may be apart."""

    of_a: Rows  # (k,)
    of_b: Rows
    normals_AB: Array  # (k, 3) unit, from a towards b
    gaps: Array  # (k,) [m]


def between(a: Hull, b: Hull) -> Array:
    """The way from the centre of a to that of b [m]."""
    (ax, ay, az), (bx, by, bz) = a.p_WC, b.p_WC
    return np.array((bx - ax, by - ay, bz - az))


def face_gaps(a: Hull, b: Hull, p_AB: Array) -> Array:
    """(f,) how far b is beyond each face of a [m]; negative where a corner of b is behind it."""
    found: Array = (b.corners @ a.normals.T).min(axis=0) + a.normals @ p_AB - a.mesh.reaches
    return found


def edge_pairs(a: Hull, b: Hull, p_AB: Array) -> EdgePairs:
    """All pairs of edges that meet along a normal which both admit."""
    products = _products(a.ways, b.ways)
    lengths = np.linalg.norm(products, axis=2)
    crossing = lengths > PARALLEL
    normals = products / np.where(crossing, lengths, 1.0)[:, :, None]
    found = []
    for sign in (1.0, -1.0):
        on_a = sign * np.einsum("ijk,imk->ijm", normals, a.bounds)
        on_b = sign * np.einsum("ijk,jmk->ijm", normals, b.bounds)
        fits = crossing & (on_a <= ADMITTED).all(axis=2) & (on_b >= -ADMITTED).all(axis=2)
        found += [(i, j, sign) for i, j in np.argwhere(fits).tolist()]
    if not found:
        none = np.zeros(0, dtype=int)
        return EdgePairs(none, none, np.zeros((0, 3)), np.zeros(0))
    of_a, of_b = (np.array([pair[n] for pair in found], dtype=int) for n in (0, 1))
    towards = normals[of_a, of_b] * np.array([sign for _, _, sign in found])[:, None]
    apart = p_AB + b.edge_middles[of_b] - a.edge_middles[of_a]
    return EdgePairs(of_a, of_b, towards, np.einsum("ij,ij->i", towards, apart))


def _products(one: Array, other: Array) -> Array:
    """(e, g, 3) the vector product of each with each; numpy's own takes several times as long on a few."""
    (ax, ay, az), (bx, by, bz) = one.T[:, :, None], other.T[:, None, :]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=2)


def separation(a: Hull, b: Hull) -> tuple[float, Vec3]:
    """The largest gap of two hulls [m], negative where they overlap, and the unit normal of it from b towards a."""
    p_AB = between(a, b)
    gaps_a, gaps_b = face_gaps(a, b, p_AB), face_gaps(b, a, -p_AB)
    # Faces come first and win ties: an edge product is never a better normal where a face does.
    best, normal = float(gaps_a.max()), -a.normals[int(gaps_a.argmax())]
    if float(gaps_b.max()) > best + PARALLEL:
        best, normal = float(gaps_b.max()), b.normals[int(gaps_b.argmax())]
    pairs = edge_pairs(a, b, p_AB)
    if len(pairs.gaps) and float(pairs.gaps.max()) > best + PARALLEL:
        turn = int(pairs.gaps.argmax())
        best, normal = float(pairs.gaps[turn]), -pairs.normals_AB[turn]
    return best, vector(normal)


def passage(moving: Hull, fixed: Hull, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """How far along a unit direction a hull goes until it touches another, and until it leaves it; None if it passes.

    By translation: the centre of the moving one goes along a line through the difference of both bodies, whose faces
    have the normals of both and of the products of their edges. What would touch by less than `graze` [m] sideways
    passes by.
    """
    way, p_FM = np.array(direction_W), between(fixed, moving)
    normals = np.concatenate([fixed.normals, -moving.normals, _all_products(fixed, moving)])
    reach = (fixed.corners @ normals.T).max(axis=0) - (moving.corners @ normals.T).min(axis=0)
    heights, speeds = normals @ p_FM - reach, normals @ way
    if np.any((np.abs(speeds) <= PARALLEL) & (heights > -graze)):
        return None
    into, out = speeds < -PARALLEL, speeds > PARALLEL
    enters = float((heights[into] / -speeds[into]).max(initial=-np.inf))
    leaves = float((-heights[out] / speeds[out]).min(initial=np.inf))
    return (enters, leaves) if enters < leaves else None


def _all_products(a: Hull, b: Hull) -> Array:
    products = _products(a.ways, b.ways).reshape(-1, 3)
    lengths = np.linalg.norm(products, axis=1)
    units = products[lengths > PARALLEL] / lengths[lengths > PARALLEL, None]
    return np.concatenate([units, -units])


def vector(parts: Array | Sequence[float]) -> Vec3:
    """Three numbers of an array."""
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
