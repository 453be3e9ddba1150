"""Bounds for brittle joints: which multiple of its loads a structure bears before the first brittle joint breaks.

A joint that breaks sheds its force, so forces within the strength of all joints do not prove that a structure stands.
Two things do. Either no joint reaches its strength in the first place: here forces are those of an elastic calculation,
in which bricks are rigid and the stiffness of a contact is proportional to its area (the rigid-body-spring model of
Kawai, 1978). Or the structure stands without its brittle joints, whichever of them break.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf
from typing import Final

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import MatrixRankWarning, splu

from stability.geometry.rows import Array, Indices
from stability.model import BodyId
from stability.problem import Contact, Problem

# Of a contact, relative to that against opening: G / E of a material with a Poisson's ratio of 1/4.
SHEAR_STIFFNESS: Final = 0.4
CORNERS_OF_A_FACE: Final = 3
BALANCED: Final = 1e-9  # largest residual of the loads, relative to the largest load
ROUNDING: Final = 1e-9  # of the largest stress: a dry contact that pulls less is not open


@dataclass(frozen=True, slots=True)
class _Face:
    """Contact of two bodies over an area, with the strength of its brittle joint."""

    contact: Contact
    strength: tuple[float, float, float] | None  # tension, cohesion, shear [Pa]; None for other contacts

    def quadrature(self) -> Iterator[tuple[Array, float]]:
        """Yield points and areas that integrate stresses, which are linear, and their moments exactly [m, m2]."""
        corners = np.array(self.contact.points_W)
        for one, other in pairwise(corners[1:]):
            area = 0.5 * float(np.linalg.norm(np.cross(one - corners[0], other - corners[0])))
            for a, b in ((corners[0], one), (one, other), (other, corners[0])):
                yield 0.5 * (a + b), area / 3.0  # the middles of the sides of a triangle

    def stiffness(self) -> Array:
        """Return the stiffness per area (3, 3)."""
        normal = np.array(self.contact.normals_W[0])
        stiffness: Array = SHEAR_STIFFNESS * np.identity(3) + (1.0 - SHEAR_STIFFNESS) * np.outer(normal, normal)
        return stiffness

    def factor(self, stresses: Array, largest: float) -> float:
        """Return the factor by which stresses at the corners (n, 3) may grow; 0 if a dry contact does not bear them."""
        normal = stresses @ np.array(self.contact.normals_W[0])
        tangential = np.linalg.norm(stresses - normal[:, None] * np.array(self.contact.normals_W[0]), axis=1)
        slides = tangential - self.contact.law.friction * normal
        if self.strength is None:
            return 0.0 if max(-normal.min(), slides.max()) > ROUNDING * largest else inf
        tension, cohesion, shear = self.strength
        parts = ((-normal, tension), (slides, cohesion), (tangential, shear))
        return min(float(bound / stress.max()) if stress.max() > ROUNDING * largest else inf for stress, bound in parts)


def elastic_factor(problem: Problem) -> float:
    """Return the multiple of its loads up to which no brittle joint breaks; 0 if it is not known.

    Without initial stresses, stresses grow in proportion to the loads, and are linear over each contact, so that its
    corners decide. Joints that are not brittle count as dry, which is on the safe side. Lines and points that touch
    bear nothing.
    """
    faces = _faces(problem)
    number = {name: index for index, name in enumerate(problem.bricks)}
    maps = {name: _Motion(np.array(placed.pose.position_W), number[name]) for name, placed in problem.bricks.items()}
    rows: list[Indices] = []
    columns: list[Indices] = []
    values: list[Array] = []
    for face in faces:
        bodies = [(maps[name], sign) for name, sign in _sides(face.contact) if name in maps]
        stiffness = face.stiffness()
        for point, area in face.quadrature():
            at = np.hstack([sign * body.at(point) for body, sign in bodies])
            places = np.concatenate([body.columns for body, _ in bodies])
            rows.append(np.repeat(places, len(places)))
            columns.append(np.tile(places, len(places)))
            values.append((area * at.T @ stiffness @ at).ravel())
    loads = np.array([[*load.force_W, *load.torque_W] for load in (problem.loads[name] for name in number)]).ravel()
    moved = _solved(rows, columns, values, loads)
    if moved is None:
        return 0.0
    stresses = [_stresses(face, maps, moved) for face in faces]
    largest = max((float(np.abs(each).max()) for each in stresses), default=0.0)
    return min((face.factor(each, largest) for face, each in zip(faces, stresses, strict=True)), default=0.0)


def without_brittle(problem: Problem) -> Problem:
    """Return the problem without its brittle joints, whose contacts remain."""
    return replace(problem, contacts=tuple(contact for contact in problem.contacts if contact.brittle is None))


def _faces(problem: Problem) -> list[_Face]:
    strengths = {(each.lower, each.upper): each.brittle for each in problem.contacts if each.brittle is not None}
    return [
        _Face(contact, strengths.get((contact.lower, contact.upper)))
        for contact in problem.contacts
        if contact.law.is_cone and len(contact.normals_W) == 1 and len(contact.points_W) >= CORNERS_OF_A_FACE
    ]


@dataclass(frozen=True, slots=True)
class _Motion:
    """Displacement of the points of a brick, as a function of that of its centre and of its rotation."""

    centre: Array
    index: int

    @property
    def columns(self) -> Indices:
        """Return the columns of the brick."""
        places: Indices = np.arange(6 * self.index, 6 * self.index + 6)
        return places

    def at(self, point: Array) -> Array:
        """Return the displacement of a point (3, 6)."""
        x, y, z = point - self.centre
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        return np.hstack([np.identity(3), turned])


def _sides(contact: Contact) -> tuple[tuple[BodyId, float], tuple[BodyId, float]]:
    return (contact.upper, 1.0), (contact.lower, -1.0)


def _solved(rows: list[Indices], columns: list[Indices], values: list[Array], loads: Array) -> Array | None:
    """Return the displacements under the loads; None if some bricks are held by no face."""
    if not rows:
        return None
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    matrix = csc_matrix(entries, shape=(len(loads), len(loads)))
    try:
        moved: Array = splu(matrix).solve(loads)
        moved = moved + splu(matrix).solve(loads - matrix @ moved)
    except (RuntimeError, MatrixRankWarning):  # singular
        return None
    if not np.isfinite(moved).all() or np.abs(matrix @ moved - loads).max() > BALANCED * np.abs(loads).max():
        return None
    return moved


def _stresses(face: _Face, maps: dict[BodyId, _Motion], moved: Array) -> Array:
    """Return the stresses of the lower body on the upper one at the corners of a face (n, 3)."""
    found = []
    for corner in np.array(face.contact.points_W):
        opened = np.zeros(3)
        for name, sign in _sides(face.contact):
            if name in maps:
                opened = opened + sign * (maps[name].at(corner) @ moved[maps[name].columns])
        found.append(-face.stiffness() @ opened)
    return np.array(found)
