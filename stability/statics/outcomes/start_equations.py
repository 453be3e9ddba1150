"""The equations by which bricks at rest would start to move: M a = g + J' f, and what is known of a and f.

At rest no velocity adds anything: the relative acceleration of two bodies at a point is linear in those of the bricks.
Units are chosen so that all numbers are near one: the largest mass, the largest load, and the largest half diagonal.
A force anywhere on a patch counts at its corners, in the shares by which its point is a mean of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.mechanics.inertia import inertia_about_axes
from stability.model import BodyId, Vec3
from stability.statics.facts import Contact, Motion, Placed, Problem, Wrench

Array: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]

UPRIGHT = 0.9  # a normal with a vertical part up to this takes the vertical as the reference of its tangents
NO_LOAD = Wrench((0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class StartEquations:
    """All that decides how a group starts, per point of its contacts; D is six times the number of bricks."""

    names: tuple[BodyId, ...]
    mass: Array  # (D, D)
    loads: Array  # (D,)
    slips: Array  # (points, 3, D): the acceleration of the upper body there against the lower one, in W
    axes: Array  # (points, 3, 3): of the first normal, it and two tangents, by rows
    normals: tuple[Array, ...]  # of each point (k, 3), from the lower body towards the upper
    friction: Array  # (points,)
    contact: Indices  # (points,) which contact of the problem each belongs to
    units: tuple[float, float, float]  # force [N], mass [kg], length [m]

    def motion(self, acceleration: Array) -> Motion:
        """Accelerations (D,) as those of bricks [m/s2] and [rad/s2]."""
        force, mass, length = self.units
        rows = (acceleration.reshape(-1, 6) * (force / mass)).tolist()
        return Motion(
            {
                name: ((x, y, z), (a / length, b / length, c / length))
                for name, (x, y, z, a, b, c) in zip(self.names, rows, strict=True)
            }
        )


def start_equations(problem: Problem) -> StartEquations:
    """The equations of a problem with at least one brick."""
    names = tuple(sorted(problem.bricks))
    placed = [problem.bricks[name] for name in names]
    wrenches = [problem.loads.get(name, NO_LOAD) for name in names]
    units = _units(placed, wrenches)
    force, _, length = units
    points = [(number, contact, point) for number, contact in enumerate(problem.contacts) for point in contact.points_W]
    normals = tuple(np.array(contact.normals_W, dtype=float) for _, contact, _ in points)
    return StartEquations(
        names,
        _mass(placed, units),
        np.concatenate([[*np.array(w.force_W) / force, *np.array(w.torque_W) / (force * length)] for w in wrenches]),
        np.array([_slip(problem, names, contact, point, length) for _, contact, point in points]).reshape(
            -1, 3, 6 * len(names)
        ),
        np.array([frame(each[0]) for each in normals]).reshape(-1, 3, 3),
        normals,
        np.array([contact.friction for _, contact, _ in points], dtype=float),
        np.array([number for number, _, _ in points], dtype=np.int64),
        units,
    )


def frame(normal: Array) -> Array:
    """A unit normal and two tangents, by rows (3, 3)."""
    reference = np.array([0.0, 1.0, 0.0]) if abs(normal[2]) > UPRIGHT else np.array([0.0, 0.0, 1.0])
    first = np.cross(reference, normal)
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)])


def _units(placed: list[Placed], wrenches: list[Wrench]) -> tuple[float, float, float]:
    length = max(each.brick.shape.bounding_radius for each in placed)
    force = max(hypot(*wrench.force_W) + hypot(*wrench.torque_W) / length for wrench in wrenches)
    return force or 1.0, max(each.brick.mass for each in placed), length


def _mass(placed: list[Placed], units: tuple[float, float, float]) -> Array:
    """(D, D) masses and inertias about the centres, along the axes of W."""
    _, mass, length = units
    found = np.zeros((6 * len(placed), 6 * len(placed)))
    for number, each in enumerate(placed):
        first = 6 * number
        inertia = np.array(inertia_about_axes(each.brick, each.pose.orientation))
        found[first : first + 3, first : first + 3] = each.brick.mass / mass * np.identity(3)
        found[first + 3 : first + 6, first + 3 : first + 6] = inertia / (mass * length**2)
    return found


def _slip(problem: Problem, names: tuple[BodyId, ...], contact: Contact, point: Vec3, length: float) -> Array:
    """(3, D) what gives the relative acceleration at a point from those of all bricks."""
    found = np.zeros((3, 6 * len(names)))
    for name, sign in _bodies(contact):
        if name in problem.bricks:
            first = 6 * names.index(name)
            x, y, z = (np.array(point) - problem.bricks[name].pose.position_W) / length
            turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # of the spin: its cross product with the arm
            found[:, first : first + 3] += sign * np.identity(3)
            found[:, first + 3 : first + 6] += sign * turned
    return found


def _bodies(contact: Contact) -> Iterator[tuple[BodyId, float]]:
    yield contact.upper, 1.0
    yield contact.lower, -1.0
