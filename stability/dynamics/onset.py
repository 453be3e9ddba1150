"""Initial motion of an unstable structure, by Gauss's principle of least constraint."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from stability.contact_law import Coulomb
from stability.geometry.placed_shape import principal_turn
from stability.geometry.rows import Array
from stability.geometry.vectors import rotate, scale
from stability.model import BodyId, Vec3
from stability.problem import Motion, Placed, Problem, Stability, Tolerances, Verdict
from stability.statics.assembly import Assembly
from stability.statics.conic_program import ConicProgram, Solver, clarabel_solve, solve
from stability.statics.equilibrium import balance, proven_motion
from stability.statics.fall_description import described_from
from stability.statics.opened_joints import Pair, opened_pairs
from stability.statics.wrench_matrix import Sparse, WrenchMatrix, wrench_matrix

# From rest, bricks start with the motion nearest to free fall among all motions that no contact resists, with distances
# weighted by mass and moments of inertia (Gauss: least constraint). Up to its scale that is the motion of least energy
# among those of equal power of the loads, one conic program. Sliding contacts also open in it, by the coefficient of
# friction times the slip, as in every motion that proves a fall; without sliding the motion is exact.
#
# The smallest falling set of bricks is a different question: bricks that tip over another and drag it along would fall
# even if that brick were held, but it starts to move too.


QUIET = (1e-3, 1e-6, 1e-9)  # shares of the largest speed, tried in turn, below which a brick counts as at rest
ACCURACIES = (1e-9, 1e-12)  # of the solver, tried in turn until the motion is proven
AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def onset(
    problem: Problem,
    motion: Motion,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
) -> Motion | None:
    """Return the proven initial motion of a problem; None if not found. `motion` is any that proves its fall."""
    system = wrench_matrix(problem, whole=True)
    root = _root_of_inertia([problem.bricks[name] for name in system.names], system)
    columns = system.columns_of(motion)
    gain = float(system.loads @ columns) / float(np.linalg.norm(root @ columns))
    program = _least_energy(system, root, gain)
    for accuracy in ACCURACIES:
        point = solve(program, accuracy, solver)
        if isinstance(point, str):
            continue
        proven = proven_motion(problem, system, point.x[: len(columns)], tolerances, QUIET)
        if proven is not None:
            return proven
    return None


def _root_of_inertia(bricks: Sequence[Placed], system: WrenchMatrix) -> Sparse:
    """Return a root of the inertia: it maps velocities to vectors of squared length proportional to kinetic energy."""
    from scipy.sparse import block_diag, diags  # noqa: PLC0415 -- slow to import, seldom needed

    blocks = []
    for placed in bricks:
        brick, pose = placed.brick, placed.pose
        spins = zip(brick.shape.moments(brick.mass), AXES, strict=True)
        turn = principal_turn(brick.shape, pose.orientation)
        turns = [[sqrt(moment) * part for part in rotate(turn, axis)] for moment, axis in spins]
        blocks += [sqrt(brick.mass) * np.identity(3), np.array(turns)]
    root = block_diag(blocks, format="csc") @ diags(1.0 / system.column_scale)
    return root / abs(root).max()


def _least_energy(system: WrenchMatrix, root: Sparse, gain: float) -> ConicProgram:
    """Return the program for the motion of least kinetic energy with a power `gain` of the loads."""
    from scipy.sparse import bmat, csc_matrix  # noqa: PLC0415 -- slow to import, seldom needed

    size, columns = root.shape
    held = system.rows.of_round
    bound = csc_matrix(([1.0], ([0], [0])), shape=(1, 1))
    power = csc_matrix(system.loads[None, :] / gain)
    matrix = bmat(
        [[power, None], [-system.matrix[:held], None], [None, -bound], [-root, None], [-system.matrix[held:], None]]
    )
    offset: Array = np.zeros(matrix.shape[0])
    offset[0] = 1.0
    cost = np.append(np.zeros(columns), 1.0)
    return system.rows.program(cost, matrix.tocsc(), offset, equal=1, norms=[size + 1])


# Completion of a verdict of UNSTABLE by the initial motion of all bricks connected with the falling ones.
#
# The cascade proves a fall by the smallest part that it finds. But the engine must move every brick that starts to
# move, and a report describes their motion.


MOST = 300  # most bricks in one program, which takes a tenth of a second; of larger structures the nearest ones


def as_it_begins(assembly: Assembly, verdict: Verdict) -> Verdict:
    """Return the verdict with all moving bricks and their initial motion.

    Unchanged if none is proven to fall. Joints that yield in the first mechanism open; all others hold as if rigid.
    """
    if verdict.stability is not Stability.UNSTABLE or verdict.motion is None:
        return verdict

    problem = assembly.problem(_around(assembly, verdict.moving))
    if problem.ties:
        return verdict  # the motion of tied bricks is not computed
    motion = _first_mechanism(problem, verdict.motion) if problem.has_joints else onset(problem, verdict.motion)
    if motion is None:
        return verdict
    moving = tuple(sorted(motion.velocity))
    same = moving == tuple(sorted(verdict.moving))
    reason = verdict.reason if same else described_from(problem, motion, verdict)
    return replace(verdict, motion=motion, moving=moving, reason=reason)


def _first_mechanism(problem: Problem, motion: Motion) -> Motion:
    """Return how bricks with joints begin to move; `motion` is any that proves their fall."""
    first = balance(problem).motion or motion
    return onset(with_rigid_joints(problem, opened_pairs(problem, first)), first) or first


def with_rigid_joints(problem: Problem, opened: Collection[Pair]) -> Problem:
    """Return the problem without the opened joints, and with all others rigid: they bear any force."""
    contacts = []
    for contact in problem.contacts:
        if contact.law.is_cone:
            contacts.append(contact)
        elif frozenset((contact.lower, contact.upper)) not in opened:
            both = (contact.normals_W[0], scale(-1.0, contact.normals_W[0]))
            contacts.append(replace(contact, normals_W=both, law=Coulomb(1.0)))
    return replace(problem, contacts=contacts)


def _around(assembly: Assembly, bricks: tuple[BodyId, ...]) -> set[BodyId]:
    """Return these bricks and all that are connected with them, or the nearest if there are too many."""
    group = set(bricks)
    while len(group) < MOST:
        larger = group | {other for brick in group for other in _neighbours(assembly, brick)}
        if len(larger) == len(group):
            break
        group = larger
    return group


def _neighbours(assembly: Assembly, brick: BodyId) -> set[BodyId]:
    bodies = {body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper)}
    return {body for body in bodies if body in assembly.bricks}
