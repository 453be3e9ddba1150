"""Solves one time step of rigid bodies in contact with Coulomb friction, as a cone complementarity problem."""

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

# Velocities after a step of rigid bodies with Coulomb friction: cone complementarity, not associated.
#
# At each contact point the impulse p is in the cone of friction, and with the relative velocity u after it
#
#     p in K, (u_n + mu |u_t|, u_t) in K*, and the two are orthogonal:
#
# open and nothing presses, or it presses and stays, or it slides and friction is all it can be against the slip (de
# Saxcé). Without the term mu |u_t| this is one conic program, Gauss' principle of least constraint; in that what slides
# also lifts off, by mu times the slip. So the program is solved with the slips found last (de Saxcé's fixed point,
# after Acary and Cadoux), and Newton's method on the conditions themselves (Alart and Curnier) does the rest, or all of
# it where a good guess is at hand. Whatever found it, a point counts only if arithmetic has checked the conditions.


MOST_STEPS = 15  # of Newton: where it converges, fewer than ten are enough
MOST_PROGRAMS = 20  # of the fixed point: Newton needs one in most cases
# Of the largest of a velocity or an impulse: what conditions may be missed by, and at what no more is asked for.
HELD, MET = 1e-6, 1e-10
ACCURACY = 1e-11  # asked of the conic solver
FIRM = 1e-4  # share of the largest mobility by which an impulse yields to a change: redundant ones stay as they were


@dataclass(frozen=True, slots=True, eq=False)
class FrictionProblem:
    """Points of contact, all in units in which masses, velocities and impulses are near one."""

    slips: Array  # (3 c, columns) from velocities to relative ones: normal and two tangents of each point
    inverse_mass: Array  # (columns, columns)
    free: Array  # (columns,) velocities if nothing pressed
    gaps: Array  # (c,) by the time in which they may close: the relative normal velocity may be as low as -gap
    law: Coulomb  # of all points


@dataclass(frozen=True, slots=True, eq=False)
class FrictionSolution:
    """What was found."""

    velocities: Array  # (columns,)
    impulses: Array  # (c, 3) normal and two tangents
    miss: float  # by how much the conditions are missed, as a share of the largest velocity or impulse


def pressed(meeting: FrictionProblem, guess: Array | None = None) -> FrictionSolution | None:
    """Velocities and impulses that obey the conditions; None if none were found. `guess` is of impulses (c, 3)."""
    if not len(meeting.gaps):
        return FrictionSolution(meeting.free, np.zeros((0, 3)), 0.0)
    mobility = meeting.slips @ meeting.inverse_mass @ meeting.slips.T
    found = _by_newton(meeting, mobility, guess) if guess is not None else None
    if found is None or found.miss > HELD:
        found = _by_programs(meeting, mobility)
    return found if found is not None and found.miss <= HELD else None


def miss(meeting: FrictionProblem, velocities: Array, impulses: Array) -> float:
    """By how much the conditions are missed, as a share of the largest velocity or impulse."""
    slips = (meeting.slips @ velocities).reshape(-1, 3)
    normal, pressing = slips[:, 0] + meeting.gaps, impulses[:, 0]
    most = meeting.law.greatest_friction(pressing)
    slip, rubbing = np.hypot(slips[:, 1], slips[:, 2]), np.hypot(impulses[:, 1], impulses[:, 2])
    # A slip is against friction as strong as it can be, or there is none.
    against = np.einsum("ij,ij->i", slips[:, 1:], impulses[:, 1:]) + slip * most
    outside = meeting.law.violation(pressing, rubbing)
    wrong = (-normal, np.minimum(normal, pressing), outside, np.minimum(against, slip))
    size = max(np.abs(slips).max(), np.abs(impulses).max(), np.abs(meeting.free).max(), 1e-300)
    return float(max(part.max() for part in wrong) / size)


def _checked(meeting: FrictionProblem, impulses: Array) -> FrictionSolution:
    velocities = meeting.free + meeting.inverse_mass @ (meeting.slips.T @ impulses.ravel())
    return FrictionSolution(velocities, impulses, miss(meeting, velocities, impulses))


def _better(one: FrictionSolution | None, other: FrictionSolution) -> FrictionSolution:
    return other if one is None or other.miss < one.miss else one


def _by_newton(meeting: FrictionProblem, mobility: Array, guess: Array) -> FrictionSolution:
    """Alart and Curnier: each point opens, stays or slides, as its impulse less its velocity says."""
    count = len(meeting.gaps)
    still = (meeting.slips @ meeting.free).reshape(-1, 3)
    still[:, 0] += meeting.gaps
    stiff = 1.0 / np.maximum(np.diag(mobility).reshape(-1, 3).max(axis=1), 1e-300)
    firm = FIRM * float(np.diag(mobility).max()) * np.identity(3 * count)
    impulses, best = guess, _checked(meeting, guess)
    alone, level = np.identity(3), np.identity(2)
    for _ in range(MOST_STEPS):
        if best.miss <= MET:
            break
        slips = (mobility @ impulses.ravel()).reshape(-1, 3) + still
        trial = impulses - stiff[:, None] * slips
        size = np.hypot(trial[:, 1], trial[:, 2])
        most = meeting.law.greatest_friction(np.maximum(trial[:, 0], 0.0))
        matrix, wanted = mobility + firm, firm @ impulses.ravel() - still.ravel()
        opens, slides = trial[:, 0] <= 0.0, (trial[:, 0] > 0.0) & (size >= most)
        for point in np.flatnonzero(opens):
            rows = slice(3 * point, 3 * point + 3)
            matrix[rows], wanted[rows] = 0.0, 0.0
            matrix[rows, rows] = alone
        for point in np.flatnonzero(slides):
            rows = slice(3 * point + 1, 3 * point + 3)
            along = trial[point, 1:] / max(size[point], 1e-300)
            turning = (level - along[:, None] * along) * (most[point] / max(size[point], 1e-300))
            matrix[rows] = stiff[point] * turning @ mobility[rows]
            matrix[rows, rows] += level - turning
            matrix[rows, 3 * point] -= meeting.law.friction[point] * along
            wanted[rows] = -stiff[point] * turning @ still[point, 1:]
        try:
            impulses = np.asarray(np.linalg.solve(matrix, wanted), dtype=np.float64).reshape(-1, 3)
        except np.linalg.LinAlgError:
            break
        best = _better(best, _checked(meeting, impulses))
    return best


def _by_programs(meeting: FrictionProblem, mobility: Array) -> FrictionSolution | None:
    slip: Array = np.zeros(len(meeting.gaps))
    best: FrictionSolution | None = None
    for _ in range(MOST_PROGRAMS):
        impulses = _program(meeting, slip)
        if impulses is None:
            break
        best = _better(best, _by_newton(meeting, mobility, impulses))
        if best.miss <= HELD:
            break
        tangential = (meeting.slips @ _checked(meeting, impulses).velocities).reshape(-1, 3)[:, 1:]
        slip = 0.5 * (slip + np.hypot(tangential[:, 0], tangential[:, 1]))  # the middle, for some go to and fro
    return best


def _program(meeting: FrictionProblem, slip: Array) -> Array | None:
    """Impulses of the motion nearest to the free one, if what slides may sink by the friction times its slip."""
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, seldom needed

    mass = np.linalg.inv(meeting.inverse_mass)
    rubbing, smooth = with_and_without(meeting.law.friction)
    cones = ConeRows(len(rubbing), len(smooth))
    scales = row_units(meeting.law.friction)
    scaled = (scales.ravel()[:, None] * meeting.slips).reshape(len(slip), 3, -1)
    room = np.zeros((len(slip), 3))
    room[:, 0] = meeting.gaps + meeting.law.lift(slip)
    rows = np.concatenate([scaled[rubbing].reshape(-1, scaled.shape[2]), scaled[smooth, 0]])
    offset = cones.joined(room[rubbing], room[smooth, 0])
    curvature = csc_matrix(np.triu(mass))
    program = cones.program(-mass @ meeting.free, csc_matrix(-rows), offset, curvature=curvature)
    point = solve(program, ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.dual).all():
        return None
    impulses: NDArray[np.float64] = np.zeros((len(slip), 3))
    impulses[rubbing] = cones.triples(point.dual) * scales[rubbing]
    impulses[smooth, 0] = cones.singles(point.dual)
    return impulses


# Several rigid bodies at once: mass, energy and what acts on each by itself. Velocities are (6 n,), with spins.


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


# Units in which what bricks do in a step is near one, so that a solver's tolerances mean something.


class ProblemScale(NamedTuple):
    """What makes numbers near one."""

    speed: float  # [m/s]
    mass: float  # [kg]
    columns: Array  # (6 n,) [m/s], and [rad/s]


def scale_of_problem(bricks: Collection[Placed], speed: float) -> ProblemScale:
    mass = median(placed.brick.mass for placed in bricks)
    length = median(placed.brick.shape.bounding_radius for placed in bricks)
    return ProblemScale(speed, mass, np.tile([speed] * 3 + [speed / length] * 3, len(bricks)))
