"""Contacts of compounds: those of their convex parts, without the seams between the parts.

Where two parts of a body touch, their common face is hidden. A contact of another body at its border must not push
along the normal of this hidden face, as an edge of a single part would. So the normals at such a place are limited to
those of the exposed faces around it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import cos, pi, sin
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import nnls

from stability.contacts.bodies import AnySolid, BoxSolid, CompoundSolid, Solid, as_hull
from stability.geometry.rows import Array
from stability.geometry.vectors import scale
from stability.model import BodyId, Vec3
from stability.problem import Contact

AROUND = 24  # directions in which the surroundings of a point on a face are looked at
WAY = 4.0  # distance to which they are looked at, as a multiple of the tolerance of contacts
CONVEX = 0.02  # sine of the largest angle between faces that count as one plane, as between faces in contact


class _Planes(NamedTuple):
    """Faces of a convex part in W."""

    normals: Array  # (f, 3) outwards
    offsets: Array  # (f,) of the planes from the origin [m]
    corners: Array  # (n, 3) [m]

    def heights(self, points: Array) -> Array:
        """Return the heights of points over the faces (n, f) [m]."""
        heights: Array = points @ self.normals.T - self.offsets
        return heights


def _planes(part: Solid) -> _Planes:
    centre = np.array(part.pose.position_W)
    if isinstance(part, BoxSolid):
        axes, half = np.array(part.axes), np.array(part.half)
        normals, reaches = np.concatenate([axes, -axes]), np.concatenate([half, half])
    else:
        hull = as_hull(part).hull
        normals, reaches = hull.normals, hull.mesh.reaches
    return _Planes(normals, reaches + normals @ centre, np.array(part.corners_W))


Found: TypeAlias = tuple[tuple[int, int], Contact]  # a contact, with the numbers of the parts of both bodies


def without_seams(contacts: Sequence[Found], bodies: tuple[AnySolid, AnySolid], reach: float) -> list[Contact]:
    """Return the contacts of the parts of two bodies, without normals of faces that other parts hide.

    `reach` is the tolerance of contacts [m].
    """
    kept = list(contacts)
    for side, body in enumerate(bodies):
        if isinstance(body, CompoundSolid):
            planes = [_planes(part) for part in body.parts]
            kept = [
                (numbers, each)
                for numbers, contact in kept
                for each in _exposed(contact, numbers[side], body.id, planes, reach)
            ]
    return [contact for _, contact in kept]


def _exposed(contact: Contact, number: int, body: BodyId, planes: Sequence[_Planes], reach: float) -> list[Contact]:
    """Return a contact with the normals that the exposed faces around each point, or the middle of a patch, admit."""
    sign = 1.0 if contact.lower == body else -1.0  # normals lead from `lower` to `upper`
    outwards = [scale(sign, normal) for normal in contact.normals_W]
    points = np.array(contact.points_W)
    if len(points) > 2:  # noqa: PLR2004 -- a patch
        return [contact] if _admitted(points.mean(axis=0), outwards, number, planes, reach) else []
    normals = [_admitted(point, outwards, number, planes, reach) for point in points]
    if all(len(own) == len(contact.normals_W) for own in normals):
        return [contact]
    gaps = contact.gaps or (0.0,) * len(contact.points_W)
    return [
        replace(
            contact,
            points_W=(point,),
            normals_W=tuple(scale(sign, normal) for normal in own),
            gaps=(gap,) if gap else (),
        )
        for point, own, gap in zip(contact.points_W, normals, gaps, strict=True)
        if own
    ]


def _admitted(
    point: Array, outwards: Sequence[Vec3], number: int, planes: Sequence[_Planes], reach: float
) -> list[Vec3]:
    """Return those outward normals of a part at a point that the body as a whole admits."""
    around = [n for n, part in enumerate(planes) if float(part.heights(point).max()) <= reach]
    if all(n == number for n in around):
        return list(outwards)
    faces = {n: list(_exposed_faces(point, n, around, planes, reach)) for n in {number, *around}}
    own, every = faces[number], [face for each in faces.values() for face in each]
    if _is_convex(point, every, around, planes, reach):
        own = every
    return [normal for normal in outwards if _is_between(np.array(normal), own)]


def _exposed_faces(
    point: Array, number: int, around: Sequence[int], planes: Sequence[_Planes], reach: float
) -> Iterator[Array]:
    """Yield the normals of the faces of a part at a point that are not hidden by other parts all around it."""
    part = planes[number]
    heights = part.heights(point)
    for face in np.flatnonzero(np.abs(heights) <= reach).tolist():
        normal = part.normals[face]
        on_face = point - heights[face] * normal
        first = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        turns = [2.0 * pi * (n + 0.5) / AROUND for n in range(AROUND)]
        beside = on_face + WAY * reach * np.array([cos(turn) * first + sin(turn) * second for turn in turns])
        inside = np.delete(part.heights(beside), face, axis=1).max(axis=1) <= 0.0
        above = beside[inside] + 2.0 * reach * normal
        hidden = np.zeros(len(above), dtype=bool)
        for other in around:
            if other != number:
                hidden |= planes[other].heights(above).max(axis=1) < 0.0
        if not hidden.all() or not len(above):
            yield normal


def _is_convex(
    point: Array, faces: Sequence[Array], around: Sequence[int], planes: Sequence[_Planes], reach: float
) -> bool:
    """Return whether the parts around a point lie behind all exposed faces at the point."""
    return all(
        float(((planes[n].corners - point) @ face).max())
        <= 2.0 * reach + CONVEX * float(np.linalg.norm(planes[n].corners - point, axis=1).max())
        for face in faces
        for n in around
    )


def _is_between(normal: Array, faces: Sequence[Array]) -> bool:
    """Return whether a normal is a sum of the normals of faces, up to noise."""
    return bool(faces) and float(nnls(np.array(faces).T, normal)[1]) <= CONVEX
