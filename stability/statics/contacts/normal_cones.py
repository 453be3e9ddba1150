"""Which normals do two touching features admit?

A feature of a box - face, edge or corner - is written as the signs of the body axes that lead out of it, 0 for those
along it. It admits the cone of these axes; two features that touch admit what is in the cone of one and in minus the
cone of the other, and the extreme directions of that span it.
"""

from collections.abc import Sequence
from math import atan2, dist, pi
from typing import TypeAlias

from stability.geometry.clipping import cut
from stability.geometry.vectors import add_scaled, cross, dot, norm, scale, unit
from stability.model import Vec3
from stability.statics.contacts.solids import BoxSolid

Feature: TypeAlias = tuple[float, float, float]  # by body axis: 1, -1 or 0

# Sine by which a direction may lie outside a cone and be taken to lie on its border, and between two that are one.
ROUNDING = 1e-9
FACE, EDGE = 1, 2  # how many axes lead out of it


def common_normals(a: BoxSolid, of_a: Feature, b: BoxSolid, of_b: Feature, along_line: bool) -> tuple[Vec3, ...]:
    """The extreme unit normals, from a towards b; none if the features do not face each other.

    Edges that touch along a line are taken as parallel, whatever noise has made of them.
    """
    cone_a, cone_b = _cone(a, of_a, 1.0), _cone(b, of_b, -1.0)
    if len(cone_a) == FACE or len(cone_b) == FACE:
        return cone_a if len(cone_a) == FACE else cone_b
    if len(cone_a) == len(cone_b) == EDGE:
        return _of_parallel_edges(cone_a, cone_b) if along_line else _of_crossing_edges(cone_a, cone_b)
    return _clipped(cone_a, cone_b) if len(cone_a) == EDGE else _clipped(cone_b, cone_a)


def _cone(body: BoxSolid, feature: Feature, sign: float) -> tuple[Vec3, ...]:
    return tuple(scale(sign * out, axis) for out, axis in zip(feature, body.axes, strict=True) if out)


def _of_parallel_edges(cone_a: Sequence[Vec3], cone_b: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Both cones are quarters of the plane across the edges, so one border of each bounds what they share."""
    start, end = cone_a
    one, other = cone_b
    middle = add_scaled(one, 1.0, other)
    # How far the quarter of b is turned from that of a, towards its end.
    turn = atan2(dot(middle, end), dot(middle, start)) - 0.25 * pi
    turn -= 2.0 * pi * round(turn / (2.0 * pi))
    if abs(turn) < ROUNDING:
        return (start, end)
    if abs(turn) > 0.5 * pi + ROUNDING:
        return ()
    around = cross(start, end)
    first, last = (one, other) if dot(cross(one, other), around) > 0.0 else (other, one)
    return _distinct((first, end) if turn > 0.0 else (start, last))


def _of_crossing_edges(cone_a: Sequence[Vec3], cone_b: Sequence[Vec3]) -> tuple[Vec3, ...]:
    edge_a, edge_b = cross(*cone_a), cross(*cone_b)
    across = cross(edge_a, edge_b)
    if norm(across) < ROUNDING:
        return _of_parallel_edges(cone_a, cone_b)
    normal = unit(across)
    outward = dot(normal, cone_a[0]) + dot(normal, cone_a[1])
    return (normal if outward > 0.0 else scale(-1.0, normal),)


def _clipped(cone: Sequence[Vec3], corner: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """The part of a cone inside the cone of a corner, which three half-spaces bound."""
    normals = cone
    for axis in corner:
        normals = cut(normals, [dot(normal, axis) for normal in normals], ROUNDING, _amid) if normals else ()
    return _distinct(normals)


def _amid(one: Vec3, other: Vec3, part: float) -> Vec3:
    """The direction between two."""
    return unit(add_scaled(scale(1.0 - part, one), part, other))


def _distinct(normals: Sequence[Vec3]) -> tuple[Vec3, ...]:
    found: list[Vec3] = []
    for normal in normals:
        if all(dist(normal, other) > ROUNDING for other in found):
            found.append(normal)
    return tuple(found)
