"""Does an assembly slide alike in all directions, and does it hold up to that?

Lift some bricks and all they carry along a slope of the greatest friction below them: no contact resists, in whatever
direction. So none survives more than that friction [g]; below it, forces parallel to the apparent gravity are tried.

Seen from a ground that accelerates, gravity leans: a brick of weight w is pulled by w (a u, -1), u a level unit vector,
a in g. Let every contact force be n (-a u, 1), parallel to that. It is within its friction cone wherever the angle of
friction is at least atan(a) and the lean of the normal, whatever u is; where bodies are about to slide, there are no
others. With n = n_0 + n_1 . u for each force, balance of every brick in all directions at once is linear. Sums over its
contacts, those above it counted negative, of what acts at (p, z) from its centre:

    sum n_0 = w, sum n_1 = 0            forces
    sum n_0 p = 0, sum z n_1 = 0        torques that do not turn with u, and those that turn twice as fast
    sum (p n_1^T + a z n_0 I) = 0       torques that turn with u

Then there is no torque about the vertical either. A force that pushes at both ends of an arc of directions and where
its tangents meet pushes all along it, since n is affine and the arc lies within that triangle.

A linear program finds such forces. In five directions they are then checked by plain arithmetic: what they leave of
balance is a polynomial of degree 2 in u, on a circle nothing everywhere if nothing in five places.
"""

from bisect import bisect_left
from collections.abc import Iterator
from math import atan, cos, pi, sin

import numpy as np

from stability.model import BodyId
from stability.statics.facts import ZERO, Contact, Motion, Problem, Wrench
from stability.statics.margins.acceleration_cut import Cut, Shaken
from stability.statics.proof import check_forces, check_motion
from stability.statics.solvers.conic_program import Array, ConicProgram, clarabel_solve, solve
from stability.statics.solvers.wrench_matrix import Indices, Sparse

ACCURACY = 1e-11  # asked of the solver
LEVEL = 1e-9  # level part of a unit normal that counts as none
WEIGHT = 1e-12  # share by which a load may differ from what its brick weighs: rounding
GAINS = 100.0  # times what a proof must gain, to begin with
WIDEST = 0.75 * pi  # [rad] of an arc; its tangents meet too far out beyond
# [rad] of an arc; its tangents meet 0.3 % further out than the arc, and a narrower one would only be less exact.
NARROWEST = pi / 20.0
EQUATIONS = 11  # of each brick
HOPELESS = 1e-6  # of what a brick may carry: what the solver's point is off by more is no rounding
MENDINGS = 2  # the second mends what the first left of rounding
FAINT = 1e-9  # of usual forces: by so much even those that do not press share in mending
SINGULAR = 1e-12  # share of the largest equation that is added to all, since some may follow from others
ROUNDING = 1e-12  # of what the upper brick may carry: a pull up to that is rounding, as it is for `proof`
# Of half an arc, from its middle: a polynomial of degree 4 is nowhere much more than twice its largest value there.
PLACES = tuple(cos((2 * k + 1) * pi / 10.0) for k in range(5))


def slide(case: Shaken, bearing: float) -> Cut | None:
    """The cut of bricks that slide alike in all directions, here along `bearing`; None if none do."""
    if not all(_is_weight(case, name) for name in case.system.names):
        return None
    problem = case.problem
    frictions = sorted({contact.friction for contact in problem.contacts})
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


def _is_weight(case: Shaken, name: BodyId) -> bool:
    weight = case.weights.get(name, 0.0)
    load = case.problem.loads.get(name, Wrench(ZERO))
    x, y, z = load.force_W
    return x == y == 0.0 and load.torque_W == ZERO and abs(z + weight) <= WEIGHT * weight


def _sliding(problem: Problem, friction: float) -> list[BodyId]:
    """The bricks that rest on others than themselves by level contacts of no more friction than this."""
    held_by: dict[BodyId, list[BodyId]] = {}
    for contact in problem.contacts:
        held_by.setdefault(contact.upper, []).append(contact.lower)
        if contact.friction > friction or not _is_level(contact):
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


def hold_along(case: Shaken, acceleration: float, middle: float, width: float) -> bool:
    """Whether parallel forces are proven to hold `acceleration` [g] on an arc of `width` about the bearing `middle`."""
    if width <= WIDEST and _hold_along(case, acceleration, middle, max(width, NARROWEST)):
        return True
    half = 0.5 * width
    return half >= NARROWEST and all(hold_along(case, acceleration, middle + side * half, half) for side in (-0.5, 0.5))


def _hold_along(case: Shaken, acceleration: float, middle: float, width: float) -> bool:
    """The same, by forces that are given by the same n_0 and n_1 on all of the arc."""
    cones = _admitting(case, acceleration)
    matrix, loads = _balance(case, acceleration, middle, cones, _parts(width))
    pushes = _pushes(matrix, loads)
    return pushes is not None and all(
        check_forces(case.loaded(*at), case.system.forces(rows), case.tolerances).holds
        for at, rows in _places(case, acceleration, middle, width, cones, pushes)
    )


def _admitting(case: Shaken, acceleration: float) -> Indices:
    """Which of the cones with friction admit forces parallel to the apparent gravity, in all directions."""
    cones, with_friction = case.system.cones, case.system.round
    x, y, z = cones.axes_W[with_friction, 0].T
    lean = np.arctan2(np.hypot(x, y), z)
    admitting: Indices = np.flatnonzero(atan(acceleration) + lean <= np.arctan(cones.friction[with_friction]))
    return admitting


def _parts(width: float) -> Array:
    """(3, 3) n_0 and n_1 from n at the ends of an arc about the first axis, and where its tangents meet."""
    x, y = cos(0.5 * width), sin(0.5 * width)
    parts: Array = np.linalg.inv(np.array([[1.0, x, -y], [1.0, 1.0 / x, 0.0], [1.0, x, y]]))
    return parts


def _balance(case: Shaken, acceleration: float, middle: float, cones: Indices, parts: Array) -> tuple[Sparse, Array]:
    """The matrix, and what its product with forces at the three corners must be; scaled as a `WrenchMatrix` is.

    `parts`: n_0 and n_1 from the forces at the corners, in axes of which the first points to the middle of the arc.
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
    """(n, 11, 3) what n_0 and the two parts of n_1 of a force add to each of the sums."""
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
    """(cones, 3) forces at the corners, in units of what upper bricks may carry; None if some pull."""
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
    except RuntimeError:  # singular, as far as it can tell
        return None
    for _ in range(MENDINGS):
        closer = pushes - weighted @ factorized(residual)
        left = matrix @ closer - loads
        if np.abs(left).max(initial=0.0) >= np.abs(residual).max(initial=0.0):
            break
        pushes, residual = closer, left
    return pushes.reshape(-1, 3) if (pushes >= -ROUNDING).all() else None


def _places(  # noqa: PLR0913, PLR0917 -- one arc, spelt out
    case: Shaken, acceleration: float, middle: float, width: float, cones: Indices, pushes: Array
) -> Iterator[tuple[tuple[float, float], Array]]:
    """Accelerations along an arc, and the forces for each, in units of the rows of the system."""
    system = case.system
    axes = system.cones.axes_W[system.round[cones]]
    units = system.row_scale[: 3 * len(system.round)].reshape(-1, 3)[cones]
    parts = _parts(width)
    for place in PLACES:
        turn = 0.5 * width * place
        pushed = units[:, 0] * (pushes @ (np.array([1.0, cos(turn), sin(turn)]) @ parts))
        x, y = acceleration * cos(middle + turn), acceleration * sin(middle + turn)
        rows = np.zeros(len(system.row_scale))
        rows[: 3 * len(system.round)].reshape(-1, 3)[cones] = pushed[:, None] * (axes @ np.array([-x, -y, 1.0])) / units
        yield (x, y), rows
