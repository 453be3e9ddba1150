"""Another start than rest: accelerations and contact forces that obey all laws of contact, and are not nothing.

Coulomb's law at rest is a root (De Saxce and Feng 1998): with a the relative acceleration at a point and n its normal,
every force f is the projection onto its friction cone of f - r (a + mu |a_t| n), for any r > 0. Newton's method looks
for such a root from a guess; it finds rest as well, or nothing. `start_proof` checks what it finds.
"""

from dataclasses import dataclass

import numpy as np

from stability.statics.facts import Forces, Motion, Problem
from stability.statics.outcomes.start_equations import Array, StartEquations

MOST_STEPS = 60
CLOSE = 1e-13  # of the largest load: the rest of the root
DAMPED = 1e-12  # of the largest entry: forces that are not unique are changed as little as can be
SHORTEST = 1e-3  # part of a step
SLOWEST = 1e-6  # of the largest load over the largest mass: starts slower than this are none


@dataclass(frozen=True, slots=True)
class Start:
    """How bricks at rest could start to move, with the forces of the contacts meanwhile."""

    acceleration: Motion  # accelerations in place of velocities [m/s2] and [rad/s2]
    forces: Forces


@dataclass(frozen=True, slots=True, eq=False)
class _Root:
    """Forces (points, 3) along the axes of each point; the accelerations they cause are `response @ f + free`."""

    response: Array  # (3 points, 3 points)
    free: Array  # (3 points,)
    friction: Array  # (points,)
    rate: Array  # (points, 1) the r of each point

    def rest(self, forces: Array) -> tuple[Array, Array]:
        """What is left of the root (3 points,), and its derivative by the forces."""
        slip = (self.response @ forces.ravel() + self.free).reshape(-1, 3)
        speed = np.hypot(slip[:, 1], slip[:, 2])
        along = slip[:, 1:] / np.where(speed > 0.0, speed, 1.0)[:, None]
        pushed = slip.copy()
        pushed[:, 0] += self.friction * speed
        inside, turned = _projected(forces - self.rate * pushed, self.friction)
        raised = np.tile(np.identity(3), (len(forces), 1, 1))
        raised[:, 0, 1:] = self.friction[:, None] * along
        steps = (turned @ raised) * self.rate[:, :, None]
        derivative = np.einsum("pij,pjk->pik", steps, self.response.reshape(len(forces), 3, -1))
        derivative = derivative.reshape(len(forces) * 3, -1)
        for point in range(len(forces)):
            own = slice(3 * point, 3 * point + 3)
            derivative[own, own] += np.identity(3) - turned[point]
        return (forces - inside).ravel(), derivative


def _projected(points: Array, friction: Array) -> tuple[Array, Array]:
    """The nearest vectors within friction cones (n, 3), and the derivatives (n, 3, 3)."""
    normal, across = points[:, 0], np.hypot(points[:, 1], points[:, 2])
    along = points[:, 1:] / np.where(across > 0.0, across, 1.0)[:, None]
    within, nothing = across <= friction * normal, friction * across <= -normal
    pressed = (normal + friction * across) / (1.0 + friction**2)
    nearest = np.column_stack([pressed, (friction * pressed)[:, None] * along])
    nearest = np.where(within[:, None], points, np.where(nothing[:, None], 0.0, nearest))
    edge = np.column_stack([np.ones(len(points)), friction[:, None] * along])
    turned = edge[:, :, None] * edge[:, None, :] / (1.0 + friction**2)[:, None, None]
    aside = np.column_stack([-along[:, 1], along[:, 0]])
    ratio = friction * pressed / np.where(across > 0.0, across, 1.0)
    turned[:, 1:, 1:] += ratio[:, None, None] * aside[:, :, None] * aside[:, None, :]
    turned[within] = np.identity(3)
    turned[nothing] = 0.0
    return nearest, turned


def other_start(problem: Problem, equations: StartEquations, forces: Array) -> Start | None:
    """A start near forces (points, 3), not proven; None if only rest is near it, or a point has several normals."""
    if not np.isfinite(forces).all() or any(len(normals) > 1 for normals in equations.normals):
        return None
    root, caused = _root(equations)
    found = _solved(root, np.einsum("pij,pj->pi", equations.axes, forces))
    if found is None:
        return None
    pressed = np.einsum("pi,pij->pj", found, equations.axes)
    acceleration = caused @ (equations.loads + np.einsum("pij,pi->j", equations.slips, pressed))
    if np.abs(acceleration).max() < SLOWEST:
        return None
    return Start(equations.motion(acceleration), _forces(problem, pressed * equations.units[0]))


def _root(equations: StartEquations) -> tuple[_Root, Array]:
    caused = np.linalg.inv(equations.mass).astype(np.float64)
    slips = np.einsum("pij,pjk->pik", equations.axes, equations.slips).reshape(-1, len(equations.loads))
    response = slips @ caused @ slips.T
    blocks = response.reshape(len(equations.normals), 3, -1, 3)
    own = np.einsum("pipi->p", blocks)
    return _Root(response, slips @ caused @ equations.loads, equations.friction, 1.0 / own[:, None]), caused


def _solved(root: _Root, forces: Array) -> Array | None:
    """Newton's method with shorter steps where the whole one is no gain."""
    forces, _ = _projected(forces, root.friction)
    rest, derivative = root.rest(forces)
    for _ in range(MOST_STEPS):
        size = float(np.linalg.norm(rest))
        if size <= CLOSE * max(1.0, float(np.abs(forces).max())):
            return _projected(forces, root.friction)[0]
        square = derivative.T @ derivative
        square[np.diag_indices_from(square)] += DAMPED * max(float(square.diagonal().max()), DAMPED)
        step = -np.linalg.solve(square, derivative.T @ rest).reshape(-1, 3)
        part = 1.0
        while part > SHORTEST and not float(np.linalg.norm(root.rest(forces + part * step)[0])) < size:
            part *= 0.5
        forces = forces + part * step
        rest, derivative = root.rest(forces)
    return None


def _forces(problem: Problem, pressed: Array) -> Forces:
    """Forces (points, 3) by contact and point, each along its one normal's cone."""
    each = iter(pressed.tolist())
    return Forces(tuple(tuple((tuple(next(each)),) for _ in contact.points_W) for contact in problem.contacts))
