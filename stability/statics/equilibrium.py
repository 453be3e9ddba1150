"""Decides by a conic program whether contact forces within Coulomb cones balance the loads on every brick."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf

import numpy as np

from stability.geometry.rows import Array
from stability.geometry.vectors import add_scaled, scale
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Forces, Motion, Problem, Tolerances
from stability.statics.conic_program import SOLVED, ConicProgram, Solver, clarabel_solve, quick_solve, solve
from stability.statics.load_factor import central_forces, yielding
from stability.statics.proof import check_forces, check_motion, least_separating_speed
from stability.statics.propagation import is_held_upright
from stability.statics.single_joints import SingleJoints, single_joints
from stability.statics.stud_program import (
    REFINED,
    SPARING,
    UPRIGHT,
    WHOLE,
    HalvedJoints,
    StudPoint,
    StudPrograms,
    whole_point,
)
from stability.statics.wrench_matrix import Sparse, WrenchMatrix, wrench_matrix

# Separating motions: they open contacts strictly.
#
# If some motion opens all contacts, no contact forces except zero balance each other.


# Share of the speed: a contact that opens more slowly may be closed because of errors of the geometry.
SEPARATES = 1e-6
SPREAD = 0.5  # share of the free friction of a rise that its horizontal spread may use
# Times the number of bricks: the largest ratio of the speed of a brick to the slowest opening speed. In a row of
# leaning planks each moves faster than the one before, so height is no measure.
ROOM = 10.0
LAYER = 0.01  # share of the smallest side: centres with a smaller height difference belong to one layer
ACCURACY = 1e-9  # requested accuracy of the solver; its results are checked
INWARDS = (1e-8, 1e-6, 1e-5, 1e-4)  # shares of central forces, tried in turn, with which forces can be corrected


@dataclass(frozen=True, slots=True)
class ContactSeparation:
    """Motion, and the separation of each contact of a problem: from 0 for none to 1, and likewise of each tie."""

    motion: Motion
    of_contacts: tuple[float, ...]
    of_ties: tuple[float, ...] = ()  # by which it gets shorter


def separating_motion(problem: Problem, solver: Solver = clarabel_solve) -> Motion | None:
    """Return a motion that is proven to open every contact and to shorten every tie strictly; None if none is found.

    Bounded pulls of joints do not count: these may balance each other, but only up to their bounds.
    """
    problem = replace(without_bounded_forces(problem), ties=problem.ties)
    rising = next(_opening(problem), None)
    if rising is not None:
        return rising
    widest = widest_separation(problem, solver)
    if widest is None or least_separating_speed(problem, widest.motion) < SEPARATES:
        return None
    return widest.motion


def separating_velocities(problem: Problem, moving: Collection[BodyId]) -> Mapping[BodyId, Vec3] | None:
    """Return velocities, at most 1, that strictly open all contacts of moving bricks with the rest fixed; or None."""
    part = without_bounded_forces(problem.part(moving))
    for motion in _opening(part):
        fastest = max(hypot(*velocity) for velocity, _ in motion.velocity.values())
        return {name: scale(1.0 / fastest, velocity) for name, (velocity, _) in motion.velocity.items()}
    return None


def without_bounded_forces(problem: Problem) -> Problem:
    """Return the problem with the cone of each law only: the forces that a contact bears of any size."""
    if not problem.has_joints:
        return problem
    return replace(
        problem, ties=(), contacts=[replace(contact, law=contact.law.unbounded) for contact in problem.contacts]
    )


def _opening(problem: Problem) -> Iterator[Motion]:
    """Yield the motions that open every contact, among those tried without a solver."""
    for ranks in (stack_ranks(problem), layers(problem)):
        for spread in (0.0, SPREAD):
            motion = _rising(problem, ranks, spread)
            if least_separating_speed(problem, motion) >= SEPARATES:
                yield motion


def _rising(problem: Problem, ranks: Mapping[BodyId, int], spread: float) -> Motion:
    """Return an upward motion of all bricks, faster with higher rank, that spreads horizontally from the middle."""
    centres = [placed.pose.position_W for placed in problem.bricks.values()]
    middle = (
        tuple(0.5 * (min(c[i] for c in centres) + max(c[i] for c in centres)) for i in (0, 1)) if centres else (0, 0)
    )
    reach = max((hypot(c[0] - middle[0], c[1] - middle[1]) for c in centres), default=0.0)
    most = max((contact.law.friction for contact in problem.contacts), default=0.0)
    rate = spread / (max(most, 1.0) * reach) if reach > 0.0 else 0.0

    def velocity(name: BodyId) -> Vec3:
        x, y, _ = problem.bricks[name].pose.position_W
        return (rate * (x - middle[0]), rate * (y - middle[1]), float(ranks[name]))

    return Motion({name: (velocity(name), ZERO) for name in problem.bricks})


def stack_ranks(problem: Problem) -> Mapping[BodyId, int]:
    """Return ranks: one above the highest rank of the supports; by height of centres in a ring of leaning bricks."""
    heights = {name: placed.pose.position_W[2] for name, placed in problem.bricks.items()}
    below: dict[BodyId, list[BodyId]] = {name: [] for name in heights}
    for contact in problem.contacts:
        if contact.upper in below and contact.lower in below:
            below[contact.upper].append(contact.lower)
    ranks: dict[BodyId, int] = {}
    for name in sorted(heights, key=lambda brick: (heights[brick], brick)):
        level = heights[name]
        ranks[name] = 1 + max(
            (ranks[lower] for lower in below[name] if heights[lower] < level and lower in ranks), default=0
        )
    return ranks


def layers(problem: Problem) -> Mapping[BodyId, int]:
    """Return the layer of each brick by the height of its centre, from the lowest on.

    Bricks of one layer rise alike, even if their supports are not part of the problem.
    """
    ranks: dict[BodyId, int] = {}
    rank, top = 0, -inf
    for name in sorted(problem.bricks, key=lambda brick: (problem.bricks[brick].pose.position_W[2], brick)):
        placed = problem.bricks[name]
        height = placed.pose.position_W[2]
        if height > top + LAYER * placed.brick.shape.least_thickness:
            rank, top = rank + 1, height
        ranks[name] = rank
    return ranks


def widest_separation(problem: Problem, solver: Solver = clarabel_solve) -> ContactSeparation | None:
    """Return the motion with the largest sum of limited separations: contacts that it keeps shut, no motion opens.

    Bounded pulls of joints do not count.
    """
    problem = replace(without_bounded_forces(problem), ties=problem.ties)
    system = wrench_matrix(problem, whole=True, carried=dict.fromkeys(problem.bricks, 1.0), any_law=True)
    room = ROOM * (1 + len(problem.bricks))
    point = solve(_program(system, len(problem.contacts), room), ACCURACY, solver)
    if isinstance(point, str) or not np.isfinite(point.x).all():
        return None
    columns = len(system.loads)
    separations, count = tuple(np.clip(point.x[columns:], 0.0, 1.0).tolist()), len(problem.contacts)
    return ContactSeparation(system.motion(point.x[:columns]), separations[:count], separations[count:])


def _program(system: WrenchMatrix, contacts: int, room: float) -> ConicProgram:
    """Return the program of the largest sum of separations, from 0 to 1, at speeds up to `room`.

    There is one for each contact, then one for each tie.
    """
    from scipy.sparse import bmat, csc_matrix, identity  # noqa: PLC0415 -- slow to import, and few need to ask

    rows, columns = system.matrix.shape
    of_contact = np.repeat(np.arange(contacts), [points * normals for points, normals in system.cones.shapes])
    normals = system.rows.normals
    ties = contacts + np.arange(len(system.most_tension))
    which, contacts = np.append(of_contact[np.append(system.round, system.flat)], ties), contacts + len(ties)
    separation = csc_matrix((np.ones(len(normals)), (normals, which)), shape=(rows, contacts))
    speed, each = identity(columns), identity(contacts)
    matrix = bmat(
        [[-system.matrix, separation], [speed, None], [-speed, None], [None, each], [None, -each]], format="csc"
    )
    offset: Array = np.concatenate([np.zeros(rows), np.full(2 * columns, room), np.ones(contacts), np.zeros(contacts)])
    cost = np.append(np.zeros(columns), np.full(contacts, -1.0))
    return system.rows.program(cost, matrix, offset, positive=2 * columns + 2 * contacts)


# Balances the loads on every brick by contact forces within exact Coulomb cones: the last stage of the cascade.
#
# One conic program over velocities u maximises the power of the loads with each slip within the dual of its friction
# cone, so that no contact resists. Slips may violate this by a fixed share; the duals of the program are then forces
# that balance the loads with the least sum. If no such forces exist, the power is unbounded along a motion.
#
# Only the solver's points matter, not its status: forces or a motion are returned after `proof` has checked them by
# plain arithmetic. If neither passes, the solver runs again with another accuracy, and then for the motion of largest
# power at bounded speed, whose duals leave the least residual.


MOST_CORRECTIONS = 3  # of forces; an error that remains after them is not rounding
HOPELESS = 1e-6  # share of the load capacity: a larger residual is not rounding
FAINT = 1e-8  # share of a usual force by which even a contact without pressure may be corrected
# speeds of a separating motion, relative to the fastest brick, that are mixed into a motion
MIXED = (1e-11, 1e-9, 1e-7, 1e-5)
DENSE = 90  # columns up to which dense matrices are faster than the import of sparse ones
QUICK = 1e-9  # accuracy of the search for a fall alone
QUIET = (1e-4, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken as static


@dataclass(frozen=True, slots=True)
class Balance:
    """Forces that balance a problem, or a motion that no contact resists; neither if none was proven."""

    forces: Forces | None
    motion: Motion | None
    note: str  # why there is neither; otherwise empty
    frictionless: bool = False  # the forces at dry contacts are along normals, and so free of self-stress


def balance(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
) -> Balance:
    """Return proven forces that balance a problem, or a proven motion; neither, with a note, if there is no proof."""
    if problem.has_joints:
        return _yielding_balance(problem, tolerances, solver)
    system = wrench_matrix(problem)
    notes = []
    for build, accuracy in ATTEMPTS:
        point = solve(build(system), accuracy, solver)
        if isinstance(point, str):
            notes.append(point)
            continue
        forces = proven_forces(problem, system, point.dual[: len(system.row_scale)], tolerances)
        motion = None if forces else proven_motion(problem, system, point.x, tolerances)
        if forces or motion:
            return Balance(forces, motion, "")
        notes.append(
            f"{build.__name__.strip('_')} to {accuracy:g}: {point.status}, but the returned point is not a proof"
        )
    return Balance(None, None, "; ".join(notes))


# Requested accuracies of the programs for bounded forces, tried in turn, from the second time on in the units of the
# forces that were computed first.
ACCURACIES = (1e-12, 1e-12, 1e-10, 1e-8)
MOST_STRAIGHTENED = 600  # columns, of a dense matrix
# Contacts that open or close more slowly than a share of the fastest slip are taken as shut. Where bricks move very
# slowly in the mechanism itself, only slower ones still are, and they open by a share of that speed, which exceeds
# rounding.
STRAIGHTENED = ((1e-6, 0.0), (1e-8, 0.1))
SLIGHT = 1e-7  # share of the fastest brick: so slow
RANK = 1e-10  # smaller singular values count as zero
STILL = (1e-4, 1e-3, 1e-5, 1e-6, 1e-7, 1e-9, 0.0)  # as `QUIET`, for the programs of bounded forces


def _yielding_balance(problem: Problem, tolerances: Tolerances, solver: Solver) -> Balance:
    """Return the balance of a problem with bounded contact forces: central forces, or the motion of its load factor."""
    studded = None if problem.ties else _studded_balance(problem, tolerances)
    if studded is not None:
        return studded
    carried: Mapping[BodyId, float] | None = None
    notes = []
    for accuracy in ACCURACIES:
        system = wrench_matrix(problem, any_law=True, carried=carried)
        rows = central_forces(system, system.loads, accuracy, solver)
        forces = None if isinstance(rows, str) else proven_forces(problem, system, rows, tolerances)
        if forces is not None:
            return Balance(forces, None, "")
        point = yielding(system, system.loads, None, accuracy, solver)
        if isinstance(point, str):
            notes.append(point)
            continue
        forces = proven_forces(problem, system, point.rows, tolerances) if point.share <= 1.0 else None
        motion = None if forces else proven_motion(problem, system, point.columns, tolerances, STILL)
        if forces or motion:
            return Balance(forces, motion, "")
        notes.append(f"load factor to {accuracy:g}: {point.status}, but the returned point is not a proof")
        carried = carried or system.greatest_forces(point.rows)
    return Balance(None, None, "; ".join(notes))


SLOW = 1e-3  # share of the largest speed below which a brick is taken as static
MOST_MOVING = 0.5  # share of all bricks: a program of more takes as long as that of all, whose mechanism is exact
ALIKE = 1e-6  # two load factors that differ by less are of one mechanism


def _studded_balance(problem: Problem, tolerances: Tolerances) -> Balance | None:
    """Return the balance by the small programs of studded bricks; None if they prove nothing."""
    single = single_joints(problem)
    if isinstance(single, Motion):
        falls = check_motion(problem.part(single.velocity), single, tolerances).holds
        return Balance(None, single, "") if falls else _halved_balance(problem, tolerances)
    if not single.rest.bricks:
        return _balanced(single, Forces(()), tolerances) or _halved_balance(problem, tolerances)
    return _balanced_by_programs(single, tolerances) or _halved_balance(problem, tolerances)


def _balanced_by_programs(single: SingleJoints, tolerances: Tolerances) -> Balance | None:
    """Return the balance by forces without friction; None if they prove nothing."""
    programs, waiting = StudPrograms(single.rest), [UPRIGHT, WHOLE, SPARING, REFINED]
    while waiting:
        point = programs.point(waiting.pop(0))
        if point is None:
            continue
        if point.share <= 1.0:  # forces of the whole program are larger than the loads require
            balanced = None if point.is_whole else _balanced(single, point.forces(), tolerances)
            if balanced is not None:
                return balanced
            continue
        exact = list(exact_points(single.rest, point))
        for motion in (single.whole_motion(each.motion()) for each in exact if each.share > 1.0):
            if check_motion(single.problem.part(motion.velocity), motion, tolerances).holds:
                return Balance(None, motion, "")
        if any(each.share > 1.0 + ALIKE for each in exact):
            return None
        if exact and WHOLE in waiting:
            waiting = [SPARING, WHOLE, REFINED]  # forces along the contacts hold what vertical ones do not
    return None


def _balanced(single: SingleJoints, rest: Forces, tolerances: Tolerances) -> Balance | None:
    """Return the balance of a whole structure by forces of its rest; None if they do not balance it."""
    forces = single.whole_forces(rest)
    holds = check_forces(single.problem, forces, tolerances).holds
    return Balance(forces, None, "", frictionless=True) if holds else None


def _halved_balance(problem: Problem, tolerances: Tolerances) -> Balance | None:
    """Return the balance with friction and two points for each joint of studs; None if it proves nothing."""
    halved = HalvedJoints.of(problem)
    if halved is None:
        return None
    system = wrench_matrix(halved.problem, any_law=True)
    point = yielding(system, system.loads, None, ACCURACIES[0], quick_solve)
    if isinstance(point, str) or not (np.isfinite(point.rows).all() and np.isfinite(point.columns).all()):
        return None
    if point.share > 1.0:
        motion = proven_motion(problem, system, point.columns, tolerances, STILL)
        return None if motion is None else Balance(None, motion, "")
    near = proven_forces(halved.problem, system, point.rows, tolerances)
    forces = None if near is None else halved.spread(near)
    proven = forces is not None and check_forces(problem, forces, tolerances).holds
    return Balance(forces, None, "") if proven else None


def exact_points(problem: Problem, point: StudPoint) -> Iterator[StudPoint]:
    """Yield the points of the exact program: the given one, and that of those bricks alone that move in its mechanism.

    The second one is more accurate. Its share of the strength is at most that of all bricks.
    """
    if point.is_whole:
        yield point
    moving = point.moving(SLOW)
    if point.is_whole or len(moving) <= MOST_MOVING * len(problem.bricks):
        alone = whole_point(problem.part(moving))
        if alone is not None:
            yield alone


def falling_motion(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = quick_solve,
) -> Motion | None:
    """Return a proven motion that lowers a problem; None if the solver finds none, which is not a proof of rest.

    If weight propagation succeeds there is none, and the solver is not needed.
    """
    if is_held_upright(problem):
        return None
    if problem.has_joints:
        studded = None if problem.ties else _studded_balance(problem, tolerances)
        if studded is not None:
            return studded.motion
        system = wrench_matrix(problem, any_law=True)
        yields = yielding(system, system.loads, None, QUICK, solver)
        stands = isinstance(yields, str) or (yields.status == SOLVED and yields.share <= 1.0)
        return (
            None
            if isinstance(yields, str) or stands
            else proven_motion(problem, system, yields.columns, tolerances, STILL)
        )
    system = wrench_matrix(problem)
    point = solve(_held(system), QUICK, solver)
    if isinstance(point, str) or point.status == SOLVED:
        return None
    return proven_motion(problem, system, point.x, tolerances)


def leading_motion(problem: Problem, solver: Solver = clarabel_solve) -> Motion | None:
    """Return the motion of largest power at bounded speed, without a proof; None for bricks with joints."""
    if problem.has_joints:
        return None
    system = wrench_matrix(problem)
    point = solve(_bounded(system), QUICK, solver)
    if isinstance(point, str) or not np.isfinite(point.x).all():
        return None
    return system.motion(point.x)


def _held(system: WrenchMatrix) -> ConicProgram:
    """Return the program of the largest power with violations of the slip cones of at most 1."""
    return system.rows.program(-system.loads, -system.matrix, _normal_rows(system))


def _bounded(system: WrenchMatrix) -> ConicProgram:
    """Return the program of the largest power with speeds of at most 1; its duals leave the least residual."""
    from scipy.sparse import identity, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    columns = len(system.loads)
    matrix = vstack([-system.matrix, identity(columns), -identity(columns)], format="csc")
    offset = np.append(np.zeros(len(system.row_scale)), np.ones(2 * columns))
    return system.rows.program(-system.loads, matrix, offset, positive=2 * columns)


# The tight accuracy is tried first: it costs one or two steps, and its residuals need no correction.
ATTEMPTS: tuple[tuple[Callable[[WrenchMatrix], ConicProgram], float], ...] = (
    (_held, 1e-12),
    (_bounded, 1e-13),
    (_held, 1e-9),
    (_bounded, 1e-9),
    (_held, 1e-7),
)


def _normal_rows(system: WrenchMatrix) -> Array:
    """Return 1 in the rows of normal components, 0 in those of tangential ones."""
    rows = np.zeros(len(system.row_scale))
    rows[system.rows.normals] = 1.0
    return rows


def proven_forces(problem: Problem, system: WrenchMatrix, rows: Array, tolerances: Tolerances) -> Forces | None:
    """Return forces near the given ones, in units of the rows, that are proven to balance the problem."""
    for _ in range(1 + MOST_CORRECTIONS):
        if not np.isfinite(rows).all():
            return None
        rows = system.project(rows)
        residual = system.matrix.T @ rows + system.loads
        if np.abs(residual).max(initial=0.0) > HOPELESS:
            return None
        forces = system.forces(rows)
        if check_forces(problem, forces, tolerances).holds:
            return forces
        rows = rows + _correction(system, rows, residual)
    return None


def proven_inside(
    problem: Problem, system: WrenchMatrix, rows: Array, central: Callable[[], Array | None], tolerances: Tolerances
) -> Forces | None:
    """Return proven forces near the given ones, as `proven_forces` does, else nearer to `central` ones by small shares.

    Forces on the borders of their cones leave no room for corrections.
    """
    forces = proven_forces(problem, system, rows, tolerances)
    middle = central() if forces is None else None
    if middle is None:
        return forces
    inside = (rows + share * (middle - rows) for share in INWARDS)
    found = (proven_forces(problem, system, each, tolerances) for each in inside)
    return next((each for each in found if each is not None), None)


def _correction(system: WrenchMatrix, rows: Array, residual: Array) -> Array:
    """Return the smallest change that removes the residual, weighted by force so that no force changes sign."""
    room = system.room(rows)
    weight = room * room + FAINT
    change: Array = -weight * (system.matrix @ _solved(system.matrix, weight, residual))
    return change


def _solved(matrix: Sparse, weight: Array, residual: Array) -> Array:
    """Return x with `matrix.T @ diag(weight) @ matrix @ x = residual`, approximately; zero if that fails."""
    if len(residual) <= DENSE:
        rows = matrix.toarray()
        square = rows.T @ (weight[:, None] * rows)
        try:
            near: Array = np.linalg.solve(square + FAINT * FAINT * np.identity(len(residual)), residual)
        except np.linalg.LinAlgError:  # singular within rounding
            return np.zeros(len(residual))
        return near
    from scipy.sparse import diags, identity  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    square = matrix.T @ diags(weight) @ matrix + FAINT * FAINT * identity(len(residual))
    try:
        solved: Array = splu(square.tocsc()).solve(residual)
    except RuntimeError:  # singular within rounding
        return np.zeros(len(residual))
    return solved


def proven_motion(
    problem: Problem, system: WrenchMatrix, columns: Array, tolerances: Tolerances, quiet: Sequence[float] = QUIET
) -> Motion | None:
    """Return a motion near the given velocities, in units of the columns, that is proven to lower the problem.

    `quiet` holds shares of the largest speed, tried in turn, below which a brick is taken as static.
    """
    if not (np.isfinite(columns).all() and columns @ system.loads > 0.0):
        return None
    for share in quiet:
        for motion in nudged_motions(problem, system.motion(columns, share)):
            if check_motion(problem, motion, tolerances).holds:
                return motion
        if system.bounded is not None:
            for shut, lift in STRAIGHTENED if share <= SLIGHT else STRAIGHTENED[:1]:
                motion = system.motion(_straightened(system, columns, share, shut, lift), share)
                if check_motion(problem, motion, tolerances).holds:
                    return motion
    return None


def _straightened(system: WrenchMatrix, columns: Array, quiet: float, shut: float, lift: float) -> Array:
    """Return velocities near the given ones for which contacts that hardly open or close do not close.

    `shut` is the share of the largest speed below which a contact hardly opens, and `lift` the share of that speed by
    which it then opens. A separating motion, which would open them all, exists only where bricks are free to rise.
    """
    moving = system.columns_of(system.motion(columns, quiet)) != 0.0
    columns = np.where(moving, columns, 0.0)
    if not 0 < moving.sum() <= MOST_STRAIGHTENED:
        return columns
    for _ in range(MOST_CORRECTIONS):
        slack, slopes = system.opening(columns)
        speed = shut * np.abs(slack).max(initial=0.0)
        near = np.abs(slack) < speed
        change = np.linalg.lstsq(slopes[near][:, moving].toarray(), lift * speed - slack[near], rcond=RANK)[0]
        columns[moving] += change
    return columns


def nudged_motions(problem: Problem, motion: Motion) -> Iterator[Motion]:
    """Yield the motion, then mixtures with more of a separating motion, which opens contacts closed by rounding."""
    yield motion
    separating = separating_velocities(problem, motion.velocity) if motion.velocity else None
    if separating is not None:
        fastest = max(hypot(*velocity) for velocity, _ in motion.velocity.values())
        for share in MIXED:
            rate = share * fastest
            yield Motion({name: (add_scaled(v, rate, separating[name]), w) for name, (v, w) in motion.velocity.items()})
