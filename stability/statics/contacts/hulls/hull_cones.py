"""Which normals do two touching features of hulls admit?

A face admits its normal, an edge what lies between those of its two faces, a corner what leads into none of its edges.
Two features that touch admit what one admits and minus the other does; the extreme directions of that span it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stability.geometry.clipping import cut
from stability.geometry.polyhedra import Array, Hull, vector
from stability.geometry.vectors import add_scaled, cross, dot, norm, scale, unit
from stability.model import Vec3
from stability.statics.contacts.normal_cones import ROUNDING

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
        return [vector(sign * each) for each in _around(normals[list(mesh.faces_at[self.number])])]

    def limits(self, sign: float) -> list[Vec3]:
        """Directions that a normal of a corner, times a sign, must not lead into."""
        corners, mesh = self.body.corners, self.body.mesh
        ways = corners[list(mesh.around[self.number])] - corners[self.number]
        return [vector(sign * way / np.linalg.norm(way)) for way in ways]


def _around(normals: Array) -> Array:
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
