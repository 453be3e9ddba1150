"""Finds the greatest horizontal acceleration that an assembly survives in every direction, with proof."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import atan, atan2, comb, cos, hypot, inf, pi, sin, tan
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.analysis.acceleration_cut import (
    AcceleratedProblem,
    Cut,
    Heading,
    corrected_forces,
    distance_of,
    groups_apart,
    heading,
    proven_distance,
    shaken,
    weights_of,
)
from stability.analysis.joined_acceleration import acceleration_of_joined
from stability.analysis.symmetry import Symmetry, symmetries
from stability.contact_law import OtherLawError
from stability.geometry.polygons import Point2, hull
from stability.geometry.rows import Array, Indices
from stability.model import BodyId
from stability.problem import ZERO, Contact, Motion, Problem, Tolerances, Wrench, rounded
from stability.process_settings import one_thread
from stability.statics.cone_rows import SQUARES, ConeRows
from stability.statics.conic_program import ConicProgram, clarabel_solve, solve
from stability.statics.proof import check_forces, check_motion
from stability.statics.wrench_matrix import Sparse, WrenchMatrix

# Proves that forces computed in some directions hold in all directions between them.
#
# With t = tan(angle / 2), (1 + t^2) (1, cos angle, sin angle) is a polynomial of degree 2 in t. Forces that balance the
# loads and an acceleration of a given size in three or more directions are multiplied by 1 + t^2 and interpolated by
# polynomials in t: these balance 1 + t^2 times the loads in all directions. Coefficients in the Bernstein basis show
# that they stay within the cones on an arc: a polynomial without a negative coefficient is not negative between 0 and
# 1.


# In units of the load capacities: a smaller violation of a cone is rounding, as in `proof`.
ROUNDING = 1e-12


def stay_inside(forces: Array, rows: ConeRows, angles: Sequence[float], half: float) -> bool:
    """Return whether forces (angles, rows) interpolated between those at `angles` stay within their cones.

    The arc goes from -`half` to `half` [rad].
    """
    edge = tan(0.5 * half)
    nodes = np.array([tan(0.5 * angle) for angle in angles])
    degree = len(angles) - 1
    basis = _bernstein(degree, 0.5 + 0.5 * nodes / edge)
    controls = np.linalg.solve(basis, forces * (1.0 + nodes * nodes)[:, None])
    if (rows.singles(controls) < -ROUNDING).any():
        return False
    cones = rows.triples(controls)
    if (cones[:, :, 0] < -ROUNDING).any():
        return False
    spare = np.einsum("mij,ikc,jkc->mk", _products(degree), cones * SQUARES, cones, optimize=True)
    return bool((spare >= -ROUNDING * np.maximum(cones[:, :, 0].max(axis=0), 1.0)).all())


def _bernstein(degree: int, at: Array) -> Array:
    """Return the Bernstein polynomials (points, degree + 1)."""
    return np.stack([comb(degree, i) * at**i * (1.0 - at) ** (degree - i) for i in range(degree + 1)], axis=1)


@cache
def _products(degree: int) -> Array:
    """Return the coefficients (2 degree + 1, degree + 1, degree + 1) of the product of two Bernstein polynomials."""
    table = np.zeros((2 * degree + 1, degree + 1, degree + 1))
    for i in range(degree + 1):
        for j in range(degree + 1):
            table[i + j, i, j] = comb(degree, i) * comb(degree, j) / comb(2 * degree, i + j)
    return table


# The analytic centre of the forces that hold an assembly at its limit.
#
# Forces in statically indeterminate contacts are not unique, and the solver's choice is arbitrary. The forces that
# maximise the product of the slacks of all cones are unique and change smoothly with the direction, so they can be
# interpolated. At a slipping contact the force lies on the border of its cone, against the slip; at an opening contact
# it is zero.


MOST_STEPS = 16  # of Newton's method; half of them are usual
CENTRED = 1e-14  # a further step is negligible below this squared Newton decrement
BALANCED = 1e-11  # accepted residual, in units of the load capacities
BOUND = 0.7  # share of the distance to the border that a step may cover
TINIEST = 1e-300  # close to the smallest normal float, 2e-308: no division by zero where nothing slips at all
FAINT = 1e-9  # keeps directions without a force out of the range of the solution

# row indices of the entries, and the start of each column
Places: TypeAlias = tuple[NDArray[np.int32], NDArray[np.int32]]


@dataclass(frozen=True, slots=True, eq=False)
class _Face:
    """The remaining forces: three components at sticking contacts, one along a ray at slipping or frictionless ones."""

    basis: Sparse  # (rows, values)
    values: ConeRows  # rows of the sticking contacts, then of the others
    start: Array  # (values,)


def centred(system: WrenchMatrix, rows: Array, slips: Array) -> Array:
    """Return the central forces among those that balance the same loads as `rows`, with these slips."""
    from scipy.sparse import identity  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    face = _face(system.rows, rows, slips)
    balance = (system.matrix.T @ face.basis).tocsc()
    transposed, faint = balance.T, FAINT * identity(balance.shape[0], format="csc")
    blocks = _blocks(face.values)
    wanted = system.matrix.T @ rows
    values = face.start
    for _ in range(MOST_STEPS):
        gradient, inverse = _barrier(values, face.values, blocks)
        pull = inverse @ gradient
        normal = (balance @ inverse @ transposed + faint).tocsc()
        missing = wanted - balance @ values
        step = inverse @ (transposed @ splu(normal).solve(missing + balance @ pull)) - pull
        share = _share(values, step, face.values)
        values = values + share * step
        if share == 1.0 and abs(step @ gradient) < CENTRED and np.abs(missing).max(initial=0.0) < BALANCED:
            break
    return np.asarray(face.basis @ values)


def _face(cones: ConeRows, rows: Array, slips: Array) -> _Face:
    """Return the remaining forces: all of a sticking contact, a ray of its cone of a slipping one, none of an open one.

    The state of a contact follows from its force and its slip, which are complementary.
    """
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    slips = slips / max(float(np.abs(slips).max(initial=0.0)), TINIEST)
    forces, sliding = cones.triples(rows), cones.triples(slips)
    tangential, across = np.hypot(forces[:, 1], forces[:, 2]), np.hypot(sliding[:, 1], sliding[:, 2])
    opens = sliding[:, 0] - across > forces[:, 0] + tangential
    slides = ~opens & (sliding[:, 0] > forces[:, 0] - tangential)
    sticks, slipping = np.flatnonzero(~opens & ~slides), np.flatnonzero(slides)
    presses = np.flatnonzero(cones.singles(rows) >= cones.singles(slips))
    stuck = (3 * sticks[:, None] + np.arange(3)).ravel()
    # The direction is that of the force, not of the slip: both agree within the solver's accuracy, but forces balance
    # exactly.
    rays = forces[slipping] / np.where(forces[slipping, :1] > 0.0, forces[slipping, :1], 1.0)
    row = np.concatenate([stuck, (3 * slipping[:, None] + np.arange(3)).ravel(), cones.of_round + presses])
    entry = np.concatenate([np.ones(len(stuck)), rays.ravel(), np.ones(len(presses))])
    singles = len(stuck) + np.concatenate(
        [np.repeat(np.arange(len(slipping)), 3), len(slipping) + np.arange(len(presses))]
    )
    column = np.concatenate([np.arange(len(stuck)), singles])
    start = np.concatenate([rows[stuck], rows[3 * slipping], rows[cones.of_round + presses]])
    basis = csc_matrix((entry, (row, column)), shape=(len(rows), len(start)))
    values = ConeRows(len(sticks), len(slipping) + len(presses))
    return _Face(basis, values, _off_the_border(start, values))


def _off_the_border(values: Array, rows: ConeRows) -> Array:
    """Return the values moved strictly inside their cones."""
    values = values.copy()
    cones, singles = rows.triples(values), rows.singles(values)
    cones[:, 0] = np.maximum(cones[:, 0], np.hypot(cones[:, 1], cones[:, 2]) * (1.0 + FAINT) + FAINT)
    singles[:] = np.maximum(singles, FAINT)
    return values


def _blocks(values: ConeRows) -> Places:
    """Return the entries' indices of a matrix with a 3 x 3 block for each sticking contact, then single values.

    The order is by column, as in compressed sparse columns.
    """
    first = 3 * np.arange(values.round, dtype=np.int32)
    rows = np.repeat(first, 9) + np.tile(np.arange(3, dtype=np.int32), values.of_round)
    singles = np.arange(values.of_round, len(values), dtype=np.int32)
    sizes = values.joined(np.full((values.round, 3), 3), np.ones(values.flat, dtype=int))
    return np.concatenate([rows, singles]), np.append(0, np.cumsum(sizes)).astype(np.int32)


def _barrier(values: Array, rows: ConeRows, at: Places) -> tuple[Array, Sparse]:
    """Return the gradient of the negative logarithm of the slacks, and the inverse of its Hessian.

    `at` holds the indices of the entries of the inverse, which are the same in all steps.
    """
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    gradient, entries = rows.barrier(values)  # of symmetric blocks
    return gradient, csc_matrix((entries, *at), shape=(len(values), len(values)))


def _share(values: Array, step: Array, rows: ConeRows) -> float:
    """Return the whole step, or the part of it that stays well inside the cones."""
    share = 1.0
    while share > FAINT:
        if (rows.spare(values + share / BOUND * step) > 0.0).all():
            return share
        share *= BOUND
    return 0.0


# Decides whether an assembly slides at the same acceleration in all directions, and survives less than it.
#
# Lift some bricks and all bricks that they carry along a slope of the greatest friction below them: no contact resists,
# in any direction. So no assembly survives more than this friction [g]; below it, forces parallel to the apparent
# gravity are tried.
#
# Seen from accelerating ground, gravity is inclined: a brick of weight w is pulled by w (a u, -1), with u a horizontal
# unit vector and a in g. Let each contact force be n (-a u, 1), parallel to it. It lies within its friction cone if the
# angle of friction is at least atan(a) plus the inclination of the normal, for any u; at the onset of sliding no other
# forces exist. With n = n_0 + n_1 . u for each force, the balance of each brick in all directions at once is linear. In
# these sums over its contacts, those above it count negative, and p and z are coordinates relative to its centre:
#
#     sum n_0 = w, sum n_1 = 0            forces
#     sum n_0 p = 0, sum z n_1 = 0        torques that do not turn with u, and those that turn twice as fast
#     sum (p n_1^T + a z n_0 I) = 0       torques that turn with u
#
# The torque about the vertical axis vanishes as well. A force that is compressive at both ends of an arc of directions
# and where the tangents of the arc meet is compressive on the whole arc, since n is affine and the arc lies within that
# triangle.
#
# A linear program finds such forces. They are then checked by plain arithmetic in five directions: the residual of the
# balance is a polynomial of degree 2 in u, and such a polynomial vanishes on a circle if it vanishes at five points.


ACCURACY = 1e-11  # requested accuracy of the solver
LEVEL = 1e-9  # a smaller horizontal part of a unit normal counts as zero
WEIGHT = 1e-12  # accepted relative difference between a load and the weight of its brick: rounding
GAINS = 100.0  # times the gain that a proof needs, as first guess
WIDEST_ARC = 0.75 * pi  # [rad] of an arc; the tangents of a wider one meet too far outside
# [rad] of an arc; its tangents meet 0.3 % outside the arc. A narrower arc would only be less exact.
NARROWEST = pi / 20.0
EQUATIONS = 11  # per brick
HOPELESS = 1e-6  # in units of the load capacities: a larger residual of the solver's point is not rounding
MENDINGS = 2  # the second removes the rounding error of the first
SINGULAR = 1e-12  # share of the largest equation that is added to all, since some may be linearly dependent
# Points of an arc (Chebyshev nodes, in units of half the arc, from its middle): a polynomial of degree 4 stays below
# about twice its largest value at these points.
PLACES = tuple(cos((2 * k + 1) * pi / 10.0) for k in range(5))


def slide(case: AcceleratedProblem, bearing: float) -> Cut | None:
    """Return the cut of bricks that slide alike in all directions, here along `bearing`; None if none do."""
    if not all(_is_weight(case, name) for name in case.system.names):
        return None
    problem = case.problem
    frictions = sorted({contact.law.friction for contact in problem.contacts})
    least = bisect_left(frictions, 1, key=lambda friction: min(1, len(_sliding(problem, friction))))
    if least == len(frictions):
        return None
    friction = frictions[least]
    x, y = cos(bearing), sin(bearing)
    motion = Motion(dict.fromkeys(_sliding(problem, friction), ((x, y, friction), ZERO)))
    further = GAINS * case.tolerances.gain * (1.0 + friction * friction)
    furthest = friction + further
    proven = check_motion(case.loaded(furthest * x, furthest * y), motion, case.tolerances).holds
    return Cut((x, y), friction, further, motion) if proven else None


def _is_weight(case: AcceleratedProblem, name: BodyId) -> bool:
    weight = case.weights.get(name, 0.0)
    load = case.problem.loads.get(name, Wrench(ZERO))
    x, y, z = load.force_W
    return x == y == 0.0 and load.torque_W == ZERO and abs(z + weight) <= WEIGHT * weight


def _sliding(problem: Problem, friction: float) -> list[BodyId]:
    """Return the bricks that rest on others only by level contacts of at most this friction."""
    held_by: dict[BodyId, list[BodyId]] = {}
    for contact in problem.contacts:
        held_by.setdefault(contact.upper, []).append(contact.lower)
        if contact.law.friction > friction or not _is_level(contact):
            held_by.setdefault(contact.lower, []).append(contact.upper)
    waiting = sorted(name for name in held_by if name not in problem.bricks)
    held = set(waiting)
    while waiting:
        for name in held_by.get(waiting.pop(), ()):
            if name not in held:
                held.add(name)
                waiting.append(name)
    return sorted(name for name in problem.bricks if name not in held)


def _is_level(contact: Contact) -> bool:
    return all(abs(x) <= LEVEL and abs(y) <= LEVEL and z > 0.0 for x, y, z in contact.normals_W)


def hold_along(case: AcceleratedProblem, acceleration: float, middle: float, width: float) -> bool:
    """Return whether parallel forces prove `acceleration` [g] on an arc of `width` about the bearing `middle`."""
    if width <= WIDEST_ARC and _hold_along(case, acceleration, middle, max(width, NARROWEST)):
        return True
    half = 0.5 * width
    return half >= NARROWEST and all(hold_along(case, acceleration, middle + side * half, half) for side in (-0.5, 0.5))


def _hold_along(case: AcceleratedProblem, acceleration: float, middle: float, width: float) -> bool:
    """Return whether forces with constant n_0 and n_1 prove `acceleration` [g] on an arc of `width` about `middle`."""
    cones = _admitting(case, acceleration)
    matrix, loads = _balance(case, acceleration, middle, cones, _parts(width))
    pushes = _pushes(matrix, loads)
    return pushes is not None and all(
        check_forces(case.loaded(*at), case.system.forces(rows), case.tolerances).holds
        for at, rows in _places(case, acceleration, middle, width, cones, pushes)
    )


def _admitting(case: AcceleratedProblem, acceleration: float) -> Indices:
    """Return the frictional cones that contain forces parallel to the apparent gravity in all directions."""
    cones, with_friction = case.system.cones, case.system.round
    x, y, z = cones.axes_W[with_friction, 0].T
    lean = np.arctan2(np.hypot(x, y), z)
    admitting: Indices = np.flatnonzero(atan(acceleration) + lean <= np.arctan(cones.friction[with_friction]))
    return admitting


def _parts(width: float) -> Array:
    """Return (3, 3): n_0 and n_1 from n at both ends of an arc about the first axis and where its tangents meet."""
    x, y = cos(0.5 * width), sin(0.5 * width)
    parts: Array = np.linalg.inv(np.array([[1.0, x, -y], [1.0, 1.0 / x, 0.0], [1.0, x, y]]))
    return parts


def _balance(
    case: AcceleratedProblem, acceleration: float, middle: float, cones: Indices, parts: Array
) -> tuple[Sparse, Array]:
    """Return the matrix and its required product with the forces at the three corners, scaled as in `WrenchMatrix`.

    `parts` gives n_0 and n_1 from the forces at the corners; the first axis points to the middle of the arc.
    """
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    system = case.system
    bricks = len(system.names)
    force, length = system.column_scale[0::6], system.column_scale[3::6] / system.column_scale[0::6]
    centres = np.array([case.problem.bricks[name].pose.position_W for name in system.names])
    c, s = cos(middle), sin(middle)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    which, size = system.round[cones], system.row_scale[3 * cones]
    shape = (EQUATIONS * bricks, 3 * len(cones))
    matrix = csc_matrix(shape)
    for body, sign in ((system.cones.upper[which], 1.0), (system.cones.lower[which], -1.0)):
        free = np.flatnonzero(body < bricks)
        brick = body[free]
        arms = (system.cones.points_W[which[free]] - centres[brick]) @ axes.T / length[brick, None]
        sums = (sign * size[free] / force[brick])[:, None, None] * (_sums(arms, acceleration) @ parts)
        rows = np.broadcast_to(EQUATIONS * brick[:, None, None] + np.arange(EQUATIONS)[:, None], sums.shape)
        columns = np.broadcast_to(3 * free[:, None, None] + np.arange(3), sums.shape)
        matrix += csc_matrix((sums.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
    loads = np.zeros(EQUATIONS * bricks)
    loads[::EQUATIONS] = np.array([case.weights.get(name, 0.0) for name in system.names]) / force
    return matrix, loads


def _sums(arms: Array, acceleration: float) -> Array:
    """Return the contributions (n, 11, 3) of n_0 and the two parts of n_1 of a force to each of the sums."""
    sums = np.zeros((len(arms), EQUATIONS, 3))
    x, y, z = arms.T
    for part in range(3):
        sums[:, part, part] = 1.0
    sums[:, 3, 0], sums[:, 4, 0] = x, y
    sums[:, 5, 1] = sums[:, 6, 2] = z
    sums[:, 7, 1] = sums[:, 8, 2] = x
    sums[:, 9, 1] = sums[:, 10, 2] = y
    sums[:, 7, 0] = sums[:, 10, 0] = acceleration * z
    return sums


def _pushes(matrix: Sparse, loads: Array) -> Array | None:
    """Return forces (cones, 3) at the corners, in units of the loads of upper bricks; None if some are tensile."""
    from scipy.sparse import diags, identity, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    count = matrix.shape[1]
    least = np.append(loads, np.zeros(count))
    stacked = vstack([matrix, -identity(count)], format="csc")
    point = solve(ConicProgram(np.zeros(count), stacked, least, len(loads), (), count), ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.x).all():
        return None
    pushes, residual = point.x, matrix @ point.x - loads
    if (pushes < -HOPELESS).any() or np.abs(residual).max(initial=0.0) > HOPELESS:
        return None
    weighted = diags(np.maximum(pushes, 0.0) + FAINT) @ matrix.T
    square = matrix @ weighted
    try:
        factorized = splu((square + SINGULAR * square.diagonal().max() * identity(len(loads))).tocsc()).solve
    except RuntimeError:  # singular within rounding
        return None
    for _ in range(MENDINGS):
        closer = pushes - weighted @ factorized(residual)
        left = matrix @ closer - loads
        if np.abs(left).max(initial=0.0) >= np.abs(residual).max(initial=0.0):
            break
        pushes, residual = closer, left
    return pushes.reshape(-1, 3) if (pushes >= -ROUNDING).all() else None


def _places(  # noqa: PLR0913, PLR0917 -- one arc, spelt out
    case: AcceleratedProblem, acceleration: float, middle: float, width: float, cones: Indices, pushes: Array
) -> Iterator[tuple[tuple[float, float], Array]]:
    """Yield accelerations along an arc and the forces for each, in the units of the rows of the system."""
    system = case.system
    axes = system.cones.axes_W[system.round[cones]]
    units = system.rows.triples(system.row_scale)[cones]
    parts = _parts(width)
    for place in PLACES:
        turn = 0.5 * width * place
        pushed = units[:, 0] * (pushes @ (np.array([1.0, cos(turn), sin(turn)]) @ parts))
        x, y = acceleration * cos(middle + turn), acceleration * sin(middle + turn)
        rows = np.zeros(len(system.row_scale))
        system.rows.triples(rows)[cones] = pushed[:, None] * (axes @ np.array([-x, -y, 1.0])) / units
        yield (x, y), rows


# The greatest horizontal acceleration that an assembly survives in every direction.
#
# Besides its weight each brick is pulled sideways by its mass times the acceleration. The accelerations that contact
# forces can balance form a convex set around zero. Solved directions are points of it, and motions cut it from outside
# (see `acceleration_cut`); the margin lies between the largest disc within the convex hull of the points and the
# nearest cut. The next direction is the foot of the perpendicular on the nearest cut, or else the corner between two
# cuts.
#
# Chords alone converge slowly where the set is round. Where bodies slide alike in all directions, other forces prove
# whole arcs (see `hold_along`). Elsewhere the forces of solved directions are interpolated: with t = tan(angle /
# 2), (1 + t^2) (1, cos, sin) are polynomials in t, so polynomials through (1 + t^2) times the solved forces balance
# every direction between. They stay within their cones, f_n >= 0 and f_n^2 - |f_t|^2 >= 0, if the coefficients of these
# polynomials in the Bernstein basis are not negative.


MOST_HEADINGS = 120  # beyond this number the gap between `value` and `upper` stays open
NOTHING = 1e-7  # [g] a smaller margin counts as zero
ALIKE = 1e-6  # relative difference that mechanisms or groups need, so that rounding does not choose which one is named
INEXACT = 1e-4  # relative error of the distance of a cut by the solver
ROUND = 0.9  # share of the friction at which everything slides: a smaller margin needs few chords
IMAGE = 1e-3  # [rad] from the next direction to the image of a solved one that is as good
SAME_BEARING = 6  # digits of a bearing [rad]
NODES = (4, 8)  # numbers of headings through which forces are interpolated
ROUNDED = 0.7  # [rad] a wider arc probably spans a corner, and interpolation costs as much as two directions
WIDEST = 3.0  # [rad] the widest arc that they interpolate
NEAR = 0.02  # share of an arc; a direction this near to one of its ends adds nothing


@dataclass(frozen=True, slots=True)
class AccelerationMargin:
    """Horizontal acceleration that is survived in every direction, in units of g."""

    value: float  # proven by forces in every direction; inf if the structure is held on all sides
    upper: float  # proven by `motion` as an upper bound
    bearing: float  # the worst direction, from x towards y [rad]
    motion: Motion | None  # of the structure in the worst direction
    headings: int  # number of solved directions


@dataclass(frozen=True, slots=True, eq=False)
class _Arc:
    """All directions between two solved ones, counter-clockwise."""

    start: Heading
    end: Heading
    smooth: float = 0.0  # [g] proven by interpolated forces

    @property
    def width(self) -> float:
        return (self.end.angle - self.start.angle) % (2.0 * pi) or 2.0 * pi

    @property
    def proven(self) -> float:
        """Return the acceleration that is survived in all these directions."""
        if self.width >= pi:
            return self.smooth
        (ax, ay), (bx, by) = self.start.point, self.end.point
        dx, dy = bx - ax, by - ay
        length = dx * dx + dy * dy
        part = min(1.0, max(0.0, -(ax * dx + ay * dy) / length)) if length > 0.0 else 0.0
        return max(self.smooth, hypot(ax + part * dx, ay + part * dy))


@one_thread()
def acceleration(
    problem: Problem,
    tolerance: float = 1e-6,
    gravity: float | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> AccelerationMargin | None:
    """Return the acceleration survived in the worst direction, to a relative `tolerance`; None if not proven to stand.

    It takes about ten directions where bodies tip, and four to eight where they slide alike in all directions.
    `gravity` [m/s2] is needed if loads are more than weights; without it the weight of a brick is the vertical part of
    its load. Groups without contact to each other are solved separately, and the weakest determines the result. Bricks
    with joints are solved to a thousandth at best, and to 0.5 % where they slide alike in all directions.
    """
    if problem.is_brittle:
        raise OtherLawError("the margin of acceleration is not computed for brittle joints")
    if problem.ties or not all(contact.law.is_shifted_cone for contact in problem.contacts):
        weights = weights_of(problem, gravity)
        joined = acceleration_of_joined(problem, weights, tolerance, rounded(problem, tolerances))
        if joined is None:
            return None
        return AccelerationMargin(joined.value, joined.upper, joined.bearing, joined.motion, joined.headings)
    weakest: AccelerationMargin | None = None
    for part in groups_apart(problem):
        margin = _of_one_group(part, tolerance, gravity, tolerances)
        if margin is None:
            return None
        weakest = margin if weakest is None else _weaker(weakest, margin)
    return weakest


def _weaker(one: AccelerationMargin, other: AccelerationMargin) -> AccelerationMargin:
    """Return the weaker of two margins."""
    first = other if other.upper < one.upper * (1.0 - ALIKE) else one
    return replace(first, value=min(one.value, other.value), headings=one.headings + other.headings)


def _of_one_group(
    problem: Problem, tolerance: float, gravity: float | None, tolerances: Tolerances
) -> AccelerationMargin | None:
    case = shaken(problem, gravity, tolerances)
    if case is None:
        return None
    first = _facing(problem)
    sliding = slide(case, 0.0)  # alike in all directions: any direction is the worst
    images = symmetries(case)
    solved: list[Heading] = []
    for quarter in range(4):
        angle = first + quarter * pi / 2.0
        solved.append(_image(case, images, solved, angle) or heading(case, angle))
    arcs = [_Arc(a, b) for a, b in pairwise([*solved, solved[0]])]
    middles: dict[float, Array] = {}
    widest = ROUNDED  # of an arc along which interpolation is tried; each failure halves it
    while True:
        nearest = _nearest(case, solved, sliding)
        upper = distance_of(nearest)
        enough = upper * (1.0 - tolerance)
        weakest = min(range(len(arcs)), key=lambda i: arcs[i].proven)
        arc = arcs[weakest]
        if arc.proven >= enough or upper <= NOTHING or upper == inf or len(solved) >= MOST_HEADINGS:
            return _margin(case, arc.proven, nearest, solved)
        is_round = sliding is not None and upper >= ROUND * sliding.distance
        middle = arc.start.angle + 0.5 * arc.width
        slides = is_round and hold_along(case, enough, middle, arc.width)
        tries = not slides and arc.width <= widest
        if slides or (tries and _is_smooth(arcs, weakest, case, enough, middles)):
            arcs[weakest] = replace(arc, smooth=enough)
        else:
            widest = 0.5 * arc.width if tries else widest
            angle = _next(arc, nearest)
            solved.append(_image(case, images, solved, angle) or heading(case, angle))
            arcs[weakest : weakest + 1] = [_Arc(arc.start, solved[-1]), _Arc(solved[-1], arc.end)]


def _image(
    case: AcceleratedProblem, images: Sequence[Symmetry], solved: Sequence[Heading], angle: float
) -> Heading | None:
    """Return the proven image of a solved direction at an angle; None if there is none."""
    for symmetry in images:
        for one in solved:
            if abs((symmetry.angle(one.angle) - angle + pi) % (2.0 * pi) - pi) <= IMAGE:
                return symmetry.image(case, one, symmetry.angle(one.angle))
    return None


def _nearest(case: AcceleratedProblem, solved: Sequence[Heading], sliding: Cut | None) -> Cut | None:
    """Return the nearest of all cuts; the solver's cuts are inexact, so near ones are proven."""
    cut = min((one.cut for one in solved), key=distance_of)
    if sliding is None or distance_of(cut) < sliding.distance * (1.0 - INEXACT):
        return cut
    return cut if cut is not None and proven_distance(case, cut) < sliding.distance else sliding


def _margin(
    case: AcceleratedProblem, proven: float, nearest: Cut | None, solved: Sequence[Heading]
) -> AccelerationMargin:
    if nearest is None:
        return AccelerationMargin(inf, inf, solved[0].angle, None, len(solved))
    upper = proven_distance(case, nearest)
    value = proven if upper > NOTHING else 0.0
    nearest = _first_alike(case, nearest, upper, solved)
    return AccelerationMargin(value, upper, atan2(nearest.normal[1], nearest.normal[0]), nearest.motion, len(solved))


def _first_alike(case: AcceleratedProblem, nearest: Cut, upper: float, solved: Sequence[Heading]) -> Cut:
    """Return the first counter-clockwise from +x of equally near cuts, such as those of a symmetric structure."""
    most = upper * (1.0 + ALIKE)
    near = [one.cut for one in solved if one.cut is not None and one.cut.distance <= most]
    alike = [nearest, *(cut for cut in near if proven_distance(case, cut) <= most)]
    return min(alike, key=_turn)


def _turn(cut: Cut) -> float:
    """Return the bearing of a cut from 0 to 2 pi [rad]; +x within rounding is 0."""
    return round(atan2(cut.normal[1], cut.normal[0]), SAME_BEARING) % (2.0 * pi)


def tilt(acceleration: float) -> float:
    """Return the ground tilt [rad] up to which an assembly stands that survives this acceleration [g].

    Seen from ground tilted by a, weights act with g cos(a) into it and with g sin(a) along it: the same as on level
    ground with an acceleration of tan(a), with all loads times cos(a). Contact forces scale with the loads, and cones
    are invariant under scaling.
    """
    return atan(acceleration)


def _facing(problem: Problem) -> float:
    """Return the direction in which the centre of mass is nearest to the border of its support.

    This first guess rotates with the structure.
    """
    fixed = [c for c in problem.contacts if c.lower not in problem.bricks or c.upper not in problem.bricks]
    support = hull((x, y) for contact in fixed for x, y, _ in contact.points_W)
    total = sum(-load.force_W[2] for load in problem.loads.values())
    if not support or not total > 0.0:
        return 0.0
    centre = [
        sum(-load.force_W[2] * problem.bricks[name].pose.position_W[axis] for name, load in problem.loads.items())
        / total
        for axis in (0, 1)
    ]
    return min((_beyond(a, b, centre) for a, b in pairwise([*support, support[0]])))[1]


def _beyond(a: Point2, b: Point2, centre: Sequence[float]) -> tuple[float, float]:
    """Return the distance of a border line from an inner point, and the outward bearing across the line."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return (dx * (centre[1] - a[1]) - dy * (centre[0] - a[0])) / hypot(dx, dy), atan2(-dx, dy)


def _next(arc: _Arc, nearest: Cut | None) -> float:
    """Return the most promising direction within an arc."""
    choices = []
    if nearest is not None:
        choices.append(atan2(nearest.normal[1], nearest.normal[0]))
    corner = _corner(arc)
    if corner is not None:
        choices.append(atan2(corner[1], corner[0]))
    for angle in choices:
        share = ((angle - arc.start.angle) % (2.0 * pi)) / arc.width
        if NEAR < share < 1.0 - NEAR:
            return arc.start.angle + share * arc.width
    return arc.start.angle + 0.5 * arc.width


def _corner(arc: _Arc) -> Point2 | None:
    """Return the intersection of the cuts at both ends."""
    if arc.start.cut is None or arc.end.cut is None:
        return None
    (ax, ay), (bx, by) = arc.start.cut.normal, arc.end.cut.normal
    turn = ax * by - ay * bx
    if turn <= NEAR * NEAR:
        return None
    a, b = arc.start.cut.distance, arc.end.cut.distance
    return ((a * by - b * ay) / turn, (b * ax - a * bx) / turn)


def _is_smooth(
    arcs: Sequence[_Arc], index: int, case: AcceleratedProblem, radius: float, middles: dict[float, Array]
) -> bool:
    """Return whether interpolated forces prove a radius along an arc.

    `middles` caches the computed forces by heading.
    """
    arc = arcs[index]
    middle = arc.start.angle + 0.5 * arc.width
    for count in NODES:
        if count > len(arcs):
            return False
        nodes = [arcs[(index + shift) % len(arcs)].start for shift in range(1 - count // 2, 1 + count // 2)]
        angles = [(node.angle - middle + pi) % (2.0 * pi) - pi for node in nodes]
        if angles != sorted(angles) or angles[-1] - angles[0] > WIDEST or min(node.reach for node in nodes) < radius:
            continue
        for node in nodes:
            if node.angle not in middles:
                middles[node.angle] = corrected_forces(
                    case.at(*node.point), centred(case.system, node.rows, node.slips)
                )
        forces = np.stack([case.rest + radius / node.reach * (middles[node.angle] - case.rest) for node in nodes])
        if stay_inside(forces, case.system.rows, angles, 0.5 * arc.width):
            return True
    return False
