"""Several rigid bodies at once: mass, energy and what acts on each by itself. Velocities are (6 n,), with spins."""

from collections.abc import Collection

import numpy as np

from stability.geometry.rotations import body_axes
from stability.geometry.vectors import cross
from stability.shapes.in_pose import principal_turn
from stability.statics.facts import Placed
from stability.statics.solvers.conic_program import Array


def inverse_mass(bricks: Collection[Placed]) -> Array:
    """The inverse of the mass matrix, (6 n, 6 n)."""
    found = np.zeros((6 * len(bricks), 6 * len(bricks)))
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        found[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = np.identity(3) / placed.brick.mass
        found[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = axes.T @ (axes / moments[:, None])
    return found


def accelerations(bricks: Collection[Placed], velocities: Array, gravity: float) -> Array:
    """(6 n,) of bodies that fall freely, with the spins that they have."""
    found = np.zeros((len(bricks), 6))
    found[:, 2] = -gravity
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        spin = axes @ velocities[6 * i + 3 : 6 * i + 6]
        found[i, 3:] = -(np.array(cross(spin.tolist(), (moments * spin).tolist())) / moments) @ axes
    return found.ravel()


def kinetic(bricks: Collection[Placed], velocities: Array) -> float:
    """Energy of motion [J]."""
    energy = 0.0
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        velocity, spin = velocities[6 * i : 6 * i + 3], axes @ velocities[6 * i + 3 : 6 * i + 6]
        energy += 0.5 * float(placed.brick.mass * velocity @ velocity + spin @ (moments * spin))
    return energy


def potential(bricks: Collection[Placed], gravity: float) -> float:
    """Energy of height, above that of the origin [J]."""
    return gravity * sum(placed.brick.mass * placed.pose.position_W[2] for placed in bricks)


def _inertia(placed: Placed) -> tuple[Array, Array]:
    """The principal axes in W, by rows, and the moments about them [kg m2]."""
    shape = placed.brick.shape
    axes = np.array(body_axes(principal_turn(shape, placed.pose.orientation)))
    return axes, np.array(shape.moments(placed.brick.mass))
