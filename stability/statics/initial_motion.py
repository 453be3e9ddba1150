"""Finds and checks a motion that starts from rest: M a = g + J' f with lawful contact forces."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import hypot, inf, sqrt

import numpy as np

from stability.contact_law import ContactLaw, Coulomb, coulomb_coefficients
from stability.geometry.placed_shape import inertia_about_axes, inertia_times
from stability.geometry.rows import Array, Indices
from stability.geometry.vectors import add, cross, dot, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Contact, Forces, Motion, Placed, Problem, Tolerances, Wrench, rounded
from stability.statics.elastic_rest import load_induced_forces
from stability.statics.proof import check_forces

# The equations of a start from rest: M a = g + J' f, and the constraints on a and f.
#
# At rest all velocity terms vanish: the relative acceleration of two bodies at a point is linear in the accelerations
# of the bricks. Units are chosen so that all numbers are near one: the largest mass, the largest load, and the largest
# half diagonal. A force inside a patch counts as forces at its corners, with the barycentric weights of its point.


UPRIGHT = 0.9  # a normal with a vertical part up to this takes the vertical as the reference of its tangents
NO_LOAD = Wrench((0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class StartEquations:
    """Equations of a start from rest, per contact point; D is six times the number of bricks."""

    names: tuple[BodyId, ...]
    mass: Array  # (D, D)
    loads: Array  # (D,)
    slips: Array  # (points, 3, D): the acceleration of the upper body relative to the lower one, in W
    axes: Array  # (points, 3, 3): the first normal and two tangents, by rows
    normals: tuple[Array, ...]  # (k, 3) per point, from the lower body towards the upper
    law: Coulomb  # of all points
    contact: Indices  # (points,) index of the contact in the problem
    units: tuple[float, float, float]  # force [N], mass [kg], length [m]

    def law_at(self, point: int) -> Coulomb:
        """Return the law of one point."""
        return self.law.with_friction(float(self.law.friction[point]))

    def law_of_contact(self, contact: int) -> Coulomb:
        """Return the law of one contact."""
        return self.law_at(int(np.argmax(self.contact == contact)))

    def motion(self, acceleration: Array) -> Motion:
        """Return accelerations (D,) as those of bricks [m/s2] and [rad/s2]."""
        force, mass, length = self.units
        rows = (acceleration.reshape(-1, 6) * (force / mass)).tolist()
        return Motion(
            {
                name: ((x, y, z), (a / length, b / length, c / length))
                for name, (x, y, z, a, b, c) in zip(self.names, rows, strict=True)
            }
        )


def start_equations(problem: Problem) -> StartEquations:
    """Return the equations of a problem with at least one brick."""
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
        np.array([_slip_row(problem, names, contact, point, length) for _, contact, point in points]).reshape(
            -1, 3, 6 * len(names)
        ),
        np.array([frame(each[0]) for each in normals]).reshape(-1, 3, 3),
        normals,
        Coulomb(np.array(coulomb_coefficients(contact.law for _, contact, _ in points), dtype=float)),
        np.array([number for number, _, _ in points], dtype=np.int64),
        units,
    )


def frame(normal: Array) -> Array:
    """Return a unit normal and two tangents, by rows (3, 3)."""
    reference = np.array([0.0, 1.0, 0.0]) if abs(normal[2]) > UPRIGHT else np.array([0.0, 0.0, 1.0])
    first = np.cross(reference, normal)
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)])


def _units(placed: list[Placed], wrenches: list[Wrench]) -> tuple[float, float, float]:
    length = max(each.brick.shape.bounding_radius for each in placed)
    force = max(hypot(*wrench.force_W) + hypot(*wrench.torque_W) / length for wrench in wrenches)
    return force or 1.0, max(each.brick.mass for each in placed), length


def _mass(placed: list[Placed], units: tuple[float, float, float]) -> Array:
    """Return (D, D) masses and inertias about the centres, along the axes of W."""
    _, mass, length = units
    matrix = np.zeros((6 * len(placed), 6 * len(placed)))
    for number, each in enumerate(placed):
        first = 6 * number
        inertia = np.array(inertia_about_axes(each.brick, each.pose.orientation))
        matrix[first : first + 3, first : first + 3] = each.brick.mass / mass * np.identity(3)
        matrix[first + 3 : first + 6, first + 3 : first + 6] = inertia / (mass * length**2)
    return matrix


def _slip_row(problem: Problem, names: tuple[BodyId, ...], contact: Contact, point: Vec3, length: float) -> Array:
    """Return the matrix (3, D) from the accelerations of all bricks to the relative acceleration at a point."""
    matrix = np.zeros((3, 6 * len(names)))
    for name, sign in _bodies(contact):
        if name in problem.bricks:
            first = 6 * names.index(name)
            x, y, z = (np.array(point) - problem.bricks[name].pose.position_W) / length
            turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # of the spin: its cross product with the arm
            matrix[:, first : first + 3] += sign * np.identity(3)
            matrix[:, first + 3 : first + 6] += sign * turned
    return matrix


def _bodies(contact: Contact) -> Iterator[tuple[BodyId, float]]:
    yield contact.upper, 1.0
    yield contact.lower, -1.0


# Another start than rest: non-zero accelerations, with contact forces that obey all laws of contact.
#
# Coulomb's law at rest is a root (De Saxce and Feng 1998): with a the relative acceleration at a point and n its
# normal, every force f is the projection onto its friction cone of f - r (a + mu |a_t| n), for any r > 0. Newton's
# method searches such a root from a guess; it may also find rest, or no root. `check_start` checks the result.


MOST_STEPS = 60
CLOSE = 1e-13  # of the largest load: accepted residual of the root
# Resistance to a step, so that non-unique forces change as little as possible: shares of the square of the derivative.
# The first share is of the residual and vanishes with it, since a singular value of 1e-7 can still make a start unique:
# where one point slips slowly. The second is for rounding.
DAMPED, ROUNDED = 1e-12, 1e-20
SHORTEST = 1e-3  # shortest share of a step
SLOWEST = 1e-6  # of the largest load over the largest mass: a slower start counts as none


@dataclass(frozen=True, slots=True)
class InitialMotion:
    """Possible start of bricks at rest, with the contact forces."""

    acceleration: Motion  # accelerations instead of velocities [m/s2] and [rad/s2]
    forces: Forces


@dataclass(frozen=True, slots=True, eq=False)
class _Root:
    """Equation for forces (points, 3) along the axes of each point; accelerations are `response @ f + free`."""

    response: Array  # (3 points, 3 points)
    free: Array  # (3 points,)
    law: Coulomb
    rate: Array  # (points, 1) the r of each point

    def rest(self, forces: Array) -> tuple[Array, Array]:
        """Return the residual (3 points,) and its derivative by the forces."""
        slip = (self.response @ forces.ravel() + self.free).reshape(-1, 3)
        speed = np.hypot(slip[:, 1], slip[:, 2])
        along = slip[:, 1:] / np.where(speed > 0.0, speed, 1.0)[:, None]
        pushed = slip.copy()
        pushed[:, 0] += self.law.lift(speed)
        inside, turned = self.law.projection(forces - self.rate * pushed)
        raised = np.tile(np.identity(3), (len(forces), 1, 1))
        raised[:, 0, 1:] = self.law.friction[:, None] * along
        steps = (turned @ raised) * self.rate[:, :, None]
        derivative = np.einsum("pij,pjk->pik", steps, self.response.reshape(len(forces), 3, -1))
        derivative = derivative.reshape(len(forces) * 3, -1)
        for point in range(len(forces)):
            own = slice(3 * point, 3 * point + 3)
            derivative[own, own] += np.identity(3) - turned[point]
        return (forces - inside).ravel(), derivative


def nonrest_solution(problem: Problem, equations: StartEquations, forces: Array) -> InitialMotion | None:
    """Return an unproven start near forces (points, 3); None if only rest is near, or a point has several normals."""
    if not np.isfinite(forces).all() or any(len(normals) > 1 for normals in equations.normals):
        return None
    root, caused = _root(equations)
    solution = _solved(root, np.einsum("pij,pj->pi", equations.axes, forces))
    if solution is None:
        return None
    pressed = np.einsum("pi,pij->pj", solution, equations.axes)
    acceleration = caused @ (equations.loads + np.einsum("pij,pi->j", equations.slips, pressed))
    if np.abs(acceleration).max() < SLOWEST:
        return None
    return InitialMotion(equations.motion(acceleration), _forces(problem, pressed * equations.units[0]))


def _root(equations: StartEquations) -> tuple[_Root, Array]:
    caused = np.linalg.inv(equations.mass).astype(np.float64)
    slips = np.einsum("pij,pjk->pik", equations.axes, equations.slips).reshape(-1, len(equations.loads))
    response = slips @ caused @ slips.T
    blocks = response.reshape(len(equations.normals), 3, -1, 3)
    own = np.einsum("pipi->p", blocks)
    return _Root(response, slips @ caused @ equations.loads, equations.law, 1.0 / own[:, None]), caused


def _solved(root: _Root, forces: Array) -> Array | None:
    """Solve by Newton's method, with shorter steps if the whole one does not reduce the residual."""
    forces, _ = root.law.projection(forces)
    rest, derivative = root.rest(forces)
    for _ in range(MOST_STEPS):
        size = float(np.linalg.norm(rest))
        if size <= CLOSE * max(1.0, float(np.abs(forces).max())):
            nearest: Array = root.law.projection(forces)[0]
            return nearest
        step = _damped_step(rest, derivative, max(DAMPED * size, ROUNDED))
        part = 1.0
        while part > SHORTEST and not float(np.linalg.norm(root.rest(forces + part * step)[0])) < size:
            part *= 0.5
        forces = forces + part * step
        rest, derivative = root.rest(forces)
    return None


def _damped_step(rest: Array, derivative: Array, damping: float) -> Array:
    """Return the step (points, 3) with the least squares of what it leaves of the residual and, damped, of itself."""
    damped = np.diag(np.full(len(rest), sqrt(damping) * np.linalg.norm(derivative)))
    # not by normal equations: rounding would hide singular values below 1e-8
    turned, triangle = np.linalg.qr(np.vstack([derivative, damped]))
    step: Array = -np.linalg.solve(triangle, turned[: len(rest)].T @ rest).reshape(-1, 3)
    return step


def _forces(problem: Problem, pressed: Array) -> Forces:
    """Return forces (points, 3) by contact and point, each along the cone of its only normal."""
    each = iter(pressed.tolist())
    return Forces(tuple(tuple((tuple(next(each)),) for _ in contact.points_W) for contact in problem.contacts))


# Checks by plain arithmetic whether bricks at rest can start with a motion, trusting nothing but the problem.
#
# The forces must balance loads and inertia on every brick, within their cones. Each point with a force must stay
# closed, and where the bodies slip, friction must be at its limit, against the slip. No point may close.


# of the largest acceleration, and of it times the largest force: accepted rounding error of the contact laws
LAWFUL = 1e-8


@dataclass(frozen=True, slots=True)
class StartCheck:
    """Result of a check of a start: whether it is possible, and by how much it violates the laws of contact."""

    holds: bool
    violation: float  # relative to the largest acceleration of a point, and to the largest force


def check_start(problem: Problem, start: InitialMotion, tolerances: Tolerances) -> StartCheck:
    """Return whether a start obeys the laws of motion and of contact, and differs from rest."""
    moving = replace(problem, loads=dict(_with_inertia(problem, start.acceleration)))
    balanced = check_forces(moving, start.forces, rounded(problem, tolerances)).holds
    if not balanced or any(len(contact.normals_W) > 1 for contact in problem.contacts):
        return StartCheck(holds=False, violation=inf)
    points = list(_points(problem, start))
    fastest = max((hypot(*slip) for _, _, _, slip in points), default=0.0)
    strongest = max((hypot(*force) for _, _, force, _ in points), default=0.0)
    if not fastest > 0.0:
        return StartCheck(holds=False, violation=inf)
    violation = max(_violation(each, fastest, strongest) for each in points)
    return StartCheck(violation <= LAWFUL, violation)


def _with_inertia(problem: Problem, acceleration: Motion) -> Iterator[tuple[BodyId, Wrench]]:
    """Yield the loads minus mass times acceleration of the bricks."""
    for name, placed in problem.bricks.items():
        load = problem.loads.get(name, Wrench(ZERO))
        linear, angular = acceleration.velocity.get(name, (ZERO, ZERO))
        force = subtract(load.force_W, scale(placed.brick.mass, linear))
        turned = inertia_times(placed.brick, placed.pose.orientation, angular)
        yield name, Wrench(force, subtract(load.torque_W, turned))


def _points(problem: Problem, start: InitialMotion) -> Iterator[tuple[Vec3, ContactLaw, Vec3, Vec3]]:
    """Yield for each point its normal, law, force on the upper body, and slip of it relative to the lower body."""
    for contact, forces in zip(problem.contacts, start.forces.of_contacts, strict=True):
        for point, (force,) in zip(contact.points_W, forces, strict=True):
            yield contact.normals_W[0], contact.law, force, _slip(problem, start.acceleration, contact, point)


def _slip(problem: Problem, acceleration: Motion, contact: Contact, point: Vec3) -> Vec3:
    above, below = (_at(problem, acceleration, name, point) for name in (contact.upper, contact.lower))
    return subtract(above, below)


def _at(problem: Problem, acceleration: Motion, name: BodyId, point: Vec3) -> Vec3:
    if name not in acceleration.velocity:
        return ZERO
    linear, angular = acceleration.velocity[name]
    return add(linear, cross(angular, subtract(point, problem.bricks[name].pose.position_W)))


def _violation(point: tuple[Vec3, ContactLaw, Vec3, Vec3], fastest: float, strongest: float) -> float:
    """Return the largest violation at a point: penetration, a force at an open point, or friction below its limit."""
    normal, law, force, slip = point
    opening, pressed = dot(normal, slip), dot(normal, force)
    across = subtract(slip, scale(opening, normal))
    not_braked = law.greatest_friction(pressed) * hypot(*across) + dot(force, across)
    work = max(abs(opening * pressed), abs(not_braked)) / (fastest * strongest) if strongest > 0.0 else 0.0
    return max(-opening / fastest, work)


# Searches a lawful motion from rest for bricks that can also stay at rest.


MOST_EXACT_POINTS = 100  # of contacts: with more, making a start exact takes seconds


def find_start(problem: Problem, tolerances: Tolerances) -> InitialMotion | None:
    """Return a proven start of bricks that can rest, for any number of bricks; None if a short search finds none.

    None also for bricks with joints, whose motions are not searched.
    """
    if problem.has_joints:
        return None
    if sum(len(contact.points_W) for contact in problem.contacts) > MOST_EXACT_POINTS:
        return _without_forces(problem, tolerances)
    return _found(problem, start_equations(problem), tolerances)


def find_any_start(problem: Problem, equations: StartEquations, tolerances: Tolerances) -> InitialMotion | None:
    """Return a proven start of a small group; the search includes starts near zero forces."""
    start = _found(problem, equations, tolerances)
    if start is not None:
        return start
    return find_start_near(problem, equations, np.zeros((len(equations.normals), 3)), tolerances)


def find_start_near(
    problem: Problem, equations: StartEquations, forces: Array, tolerances: Tolerances
) -> InitialMotion | None:
    """Return a proven start near forces (points, 3), in the units of the equations."""
    start = nonrest_solution(problem, equations, forces)
    return start if start is not None and check_start(problem, start, tolerances).holds else None


def _found(problem: Problem, equations: StartEquations, tolerances: Tolerances) -> InitialMotion | None:
    """Return a proven start without forces, or else one near the load-induced forces."""
    if any(len(normals) > 1 for normals in equations.normals):
        return None
    start = _without_forces(problem, tolerances)
    if start is not None:
        return start
    return find_start_near(problem, equations, load_induced_forces(problem) / equations.units[0], tolerances)


def _without_forces(problem: Problem, tolerances: Tolerances) -> InitialMotion | None:
    """Return the start without contact forces; None if it is not lawful, or loads rotate a brick."""
    if any(hypot(*load.torque_W) > 0.0 for load in problem.loads.values()):
        return None
    falling = {
        name: (scale(1.0 / problem.bricks[name].brick.mass, load.force_W), ZERO) for name, load in problem.loads.items()
    }
    none = Forces(tuple(((ZERO,) * len(c.normals_W),) * len(c.points_W) for c in problem.contacts))
    start = InitialMotion(Motion(falling), none)
    return start if check_start(problem, start, tolerances).holds else None
