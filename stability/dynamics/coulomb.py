"""One time step of rigid bodies with Coulomb friction, as a cone complementarity problem."""

from collections.abc import Collection
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stability.contact_law import Coulomb
from stability.geometry.placed_shape import principal_turn
from stability.geometry.rows import Array
from stability.geometry.vectors import body_axes, cross
from stability.problem import Placed
from stability.statics.cone_rows import ConeRows, row_units, with_and_without
from stability.statics.conic_program import clarabel_solve, solve

# Cone complementarity with non-associated friction.
#
# At each contact point the impulse p and the relative velocity u after the step satisfy
#
#     p in K, (u_n + mu |u_t|, u_t) in K*, and the two are orthogonal:
#
# the point is open without an impulse, or it sticks, or it slides with the largest friction against the slip (de
# Saxcé). Without the term mu |u_t| this is one conic program, Gauss' principle of least constraint, in which sliding
# points also lift off, by mu times the slip. So the program is solved with the slips of the last solution (de Saxcé's
# fixed point, after Acary and Cadoux), followed by Newton's method on the conditions (Alart and Curnier), which
# suffices alone with a good initial guess. A solution is accepted only if its residual in the conditions is small.


MOST_STEPS = 15  # Newton iterations; fewer than ten suffice if it converges
MOST_PROGRAMS = 20  # fixed-point iterations; one mostly suffices for Newton
# Residuals relative to the largest velocity or impulse: the accepted one, and the one that ends the iteration.
HELD, MET = 1e-6, 1e-10
ACCURACY = 1e-11  # of the conic solver
FIRM = 1e-4  # share of the largest mobility: regularisation that keeps redundant impulses near their last values


@dataclass(frozen=True, slots=True, eq=False)
class FrictionProblem:
    """Contact problem of c points, in units in which masses, velocities and impulses are near 1."""

    slips: Array  # (3 c, columns) from velocities to relative velocities: normal and two tangents of each point
    inverse_mass: Array  # (columns, columns)
    free: Array  # (columns,) velocities without contacts
    gaps: Array  # (c,) divided by the step: the least relative normal velocity is -gap
    law: Coulomb  # of all points


@dataclass(frozen=True, slots=True, eq=False)
class FrictionSolution:
    """Solution of a contact problem."""

    velocities: Array  # (columns,)
    impulses: Array  # (c, 3) normal and two tangents
    residual: float  # residual of the conditions, relative to the largest velocity or impulse


def solve_friction(problem: FrictionProblem, guess: Array | None = None) -> FrictionSolution | None:
    """Solve for velocities and impulses; None if no solution was found. `guess` are initial impulses (c, 3)."""
    if not len(problem.gaps):
        return FrictionSolution(problem.free, np.zeros((0, 3)), 0.0)
    mobility = problem.slips @ problem.inverse_mass @ problem.slips.T
    solution = _by_newton(problem, mobility, guess) if guess is not None else None
    if solution is None or solution.residual > HELD:
        solution = _by_programs(problem, mobility)
    return solution if solution is not None and solution.residual <= HELD else None


def residual(problem: FrictionProblem, velocities: Array, impulses: Array) -> float:
    """Return the residual of the conditions, relative to the largest velocity or impulse."""
    slips = (problem.slips @ velocities).reshape(-1, 3)
    normal, normal_impulses = slips[:, 0] + problem.gaps, impulses[:, 0]
    largest_friction = problem.law.greatest_friction(normal_impulses)
    slip, friction = np.hypot(slips[:, 1], slips[:, 2]), np.hypot(impulses[:, 1], impulses[:, 2])
    # A sliding point has the largest friction, against the slip.
    power_of_friction = np.einsum("ij,ij->i", slips[:, 1:], impulses[:, 1:]) + slip * largest_friction
    outside = problem.law.violation(normal_impulses, friction)
    violations = (-normal, np.minimum(normal, normal_impulses), outside, np.minimum(power_of_friction, slip))
    size = max(np.abs(slips).max(), np.abs(impulses).max(), np.abs(problem.free).max(), 1e-300)
    return float(max(part.max() for part in violations) / size)


def _checked(problem: FrictionProblem, impulses: Array) -> FrictionSolution:
    velocities = problem.free + problem.inverse_mass @ (problem.slips.T @ impulses.ravel())
    return FrictionSolution(velocities, impulses, residual(problem, velocities, impulses))


def _better(best: FrictionSolution | None, candidate: FrictionSolution) -> FrictionSolution:
    return candidate if best is None or candidate.residual < best.residual else best


def _by_newton(problem: FrictionProblem, mobility: Array, guess: Array) -> FrictionSolution:
    """Iterate by Alart and Curnier: impulse minus velocity decides whether a point opens, sticks or slides."""
    count = len(problem.gaps)
    free_slips = (problem.slips @ problem.free).reshape(-1, 3)
    free_slips[:, 0] += problem.gaps
    stiff = 1.0 / np.maximum(np.diag(mobility).reshape(-1, 3).max(axis=1), 1e-300)
    firm = FIRM * float(np.diag(mobility).max()) * np.identity(3 * count)
    impulses, best = guess, _checked(problem, guess)
    identity, identity_2 = np.identity(3), np.identity(2)
    for _ in range(MOST_STEPS):
        if best.residual <= MET:
            break
        slips = (mobility @ impulses.ravel()).reshape(-1, 3) + free_slips
        trial = impulses - stiff[:, None] * slips
        size = np.hypot(trial[:, 1], trial[:, 2])
        limits = problem.law.greatest_friction(np.maximum(trial[:, 0], 0.0))
        matrix, right_side = mobility + firm, firm @ impulses.ravel() - free_slips.ravel()
        opens, slides = trial[:, 0] <= 0.0, (trial[:, 0] > 0.0) & (size >= limits)
        for point in np.flatnonzero(opens):
            rows = slice(3 * point, 3 * point + 3)
            matrix[rows], right_side[rows] = 0.0, 0.0
            matrix[rows, rows] = identity
        for point in np.flatnonzero(slides):
            rows = slice(3 * point + 1, 3 * point + 3)
            along = trial[point, 1:] / max(size[point], 1e-300)
            turning = (identity_2 - along[:, None] * along) * (limits[point] / max(size[point], 1e-300))
            matrix[rows] = stiff[point] * turning @ mobility[rows]
            matrix[rows, rows] += identity_2 - turning
            matrix[rows, 3 * point] -= problem.law.friction[point] * along
            right_side[rows] = -stiff[point] * turning @ free_slips[point, 1:]
        try:
            impulses = np.asarray(np.linalg.solve(matrix, right_side), dtype=np.float64).reshape(-1, 3)
        except np.linalg.LinAlgError:
            break
        best = _better(best, _checked(problem, impulses))
    return best


def _by_programs(problem: FrictionProblem, mobility: Array) -> FrictionSolution | None:
    slip: Array = np.zeros(len(problem.gaps))
    best: FrictionSolution | None = None
    for _ in range(MOST_PROGRAMS):
        impulses = _program(problem, slip)
        if impulses is None:
            break
        best = _better(best, _by_newton(problem, mobility, impulses))
        if best.residual <= HELD:
            break
        tangential = (problem.slips @ _checked(problem, impulses).velocities).reshape(-1, 3)[:, 1:]
        slip = 0.5 * (slip + np.hypot(tangential[:, 0], tangential[:, 1]))  # the mean, as some iterations oscillate
    return best


def _program(problem: FrictionProblem, slip: Array) -> Array | None:
    """Return the impulses of the motion nearest to the free one, if sliding points may sink by mu times the slip."""
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, seldom needed

    mass = np.linalg.inv(problem.inverse_mass)
    rubbing, smooth = with_and_without(problem.law.friction)
    cones = ConeRows(len(rubbing), len(smooth))
    scales = row_units(problem.law.friction)
    scaled = (scales.ravel()[:, None] * problem.slips).reshape(len(slip), 3, -1)
    room = np.zeros((len(slip), 3))
    room[:, 0] = problem.gaps + problem.law.lift(slip)
    rows = np.concatenate([scaled[rubbing].reshape(-1, scaled.shape[2]), scaled[smooth, 0]])
    offset = cones.joined(room[rubbing], room[smooth, 0])
    curvature = csc_matrix(np.triu(mass))
    program = cones.program(-mass @ problem.free, csc_matrix(-rows), offset, curvature=curvature)
    point = solve(program, ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.dual).all():
        return None
    impulses: NDArray[np.float64] = np.zeros((len(slip), 3))
    impulses[rubbing] = cones.triples(point.dual) * scales[rubbing]
    impulses[smooth, 0] = cones.singles(point.dual)
    return impulses


# Mass, energy and free accelerations of several rigid bodies. Velocities are (6 n,), with spins.


def inverse_mass(bricks: Collection[Placed]) -> Array:
    """Return the inverse mass matrix, (6 n, 6 n)."""
    matrix = np.zeros((6 * len(bricks), 6 * len(bricks)))
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        matrix[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = np.identity(3) / placed.brick.mass
        matrix[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = axes.T @ (axes / moments[:, None])
    return matrix


def accelerations(bricks: Collection[Placed], velocities: Array, gravity: float) -> Array:
    """Return the accelerations of freely falling bodies with their spins, (6 n,)."""
    result = np.zeros((len(bricks), 6))
    result[:, 2] = -gravity
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        spin = axes @ velocities[6 * i + 3 : 6 * i + 6]
        result[i, 3:] = -(np.array(cross(spin.tolist(), (moments * spin).tolist())) / moments) @ axes
    return result.ravel()


def kinetic(bricks: Collection[Placed], velocities: Array) -> float:
    """Return the kinetic energy [J]."""
    energy = 0.0
    for i, placed in enumerate(bricks):
        axes, moments = _inertia(placed)
        velocity, spin = velocities[6 * i : 6 * i + 3], axes @ velocities[6 * i + 3 : 6 * i + 6]
        energy += 0.5 * float(placed.brick.mass * velocity @ velocity + spin @ (moments * spin))
    return energy


def potential(bricks: Collection[Placed], gravity: float) -> float:
    """Return the potential energy relative to z = 0 [J]."""
    return gravity * sum(placed.brick.mass * placed.pose.position_W[2] for placed in bricks)


def _inertia(placed: Placed) -> tuple[Array, Array]:
    """Return the principal axes in W, by rows, and the moments about them [kg m2]."""
    shape = placed.brick.shape
    axes = np.array(body_axes(principal_turn(shape, placed.pose.orientation)))
    return axes, np.array(shape.moments(placed.brick.mass))


# Units in which the quantities of a step are near 1, as the tolerances of the solvers require.


class ProblemScale(NamedTuple):
    """Units of a problem."""

    speed: float  # [m/s]
    mass: float  # [kg]
    columns: Array  # (6 n,) units of the velocities [m/s] and spins [rad/s]


def scale_of_problem(bricks: Collection[Placed], speed: float) -> ProblemScale:
    mass = median(placed.brick.mass for placed in bricks)
    length = median(placed.brick.shape.bounding_radius for placed in bricks)
    return ProblemScale(speed, mass, np.tile([speed] * 3 + [speed / length] * 3, len(bricks)))
