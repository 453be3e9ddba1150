"""Forces that loads alone bring forth: those under which contacts that give a little bring a structure to rest.

Every point of a contact is a spring that presses the more the further it is closed, and never pulls, beside one that
resists a slip until friction is used up. Loads that grow from nothing, on contacts that nothing has pressed yet, lead
to a rest or to none. A wedge pulls itself tight between steep walls; a plank between upright ones does not, though both
would hold if they were squeezed. So Kao et al. (2022), "Coupled Rigid-Block Analysis", couple forces with a small
motion, which they bound where this has a stiffness; any stiffness that leads to rest will do.

Friction as Coulomb has it makes the rest no minimum of anything. Newton's method, damped where a step leads away,
solves the equations, which are smooth by pieces. What it finds is checked, and nothing follows from its failure.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stability.statics.facts import Forces, Problem, Tolerances
from stability.statics.proof import check_forces
from stability.statics.solvers.wrench_matrix import Array, Sparse, WrenchMatrix, wrench_matrix

# Times one more than the bricks: how much further a brick may go than what closes most. A slimmer wedge goes so far
# that its angle is no longer what it was. In a column of n, of which each closes as it is loaded, the top goes n / 2
# times as far.
FURTHEST = 100.0
MOST_STEPS = 100
AT_REST = 1e-13  # share of the loads that nothing balances; the check allows more
BONDED = 1e-12  # damping of the first motion: it keeps what nothing holds from going anywhere
DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-14, 1e6  # of the second, and its range; as a share of the stiffness
LESS, MORE = 0.1, 10.0  # times the damping, after a whole step and where none gets nearer
SHORTEST = 1e-4  # share of a step that is tried
NEARER = 1e-4  # share of what is left over that a whole step has to take away


@dataclass(frozen=True, slots=True, eq=False)
class _Pressed:
    """How contacts answer a motion, in the units of the rows."""

    rows: Array  # (rows,) their forces, within their cones
    normal: Array  # (k,) those along the normals of cones with friction
    resisting: Array  # (k,) what would resist the slip, were there no limit to friction
    along: Array  # (k, 2) which way, a unit vector
    slips: NDArray[np.bool_]  # (k,) whether friction is used up


def elastic_rest(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Forces | None:
    """Forces that balance a problem and that its loads alone bring forth; None if none are found."""
    system = wrench_matrix(problem)
    motion = _motion(system)
    pressed = _pressed(system, motion)
    closed = pressed.rows[_normal_rows(system)].max(initial=0.0)
    if not np.abs(motion).max(initial=0.0) <= FURTHEST * (1 + len(problem.bricks)) * closed:
        return None
    forces = system.forces(pressed.rows)
    return forces if check_forces(problem, forces, tolerances).holds else None


def brought_forth(problem: Problem) -> Array:
    """(cones, 3) the forces that loads bring forth [N]; where nothing comes to rest, those of what was tried last."""
    system = wrench_matrix(problem)
    return system.forces_W(_pressed(system, _motion(system)).rows)


def _motion(system: WrenchMatrix) -> Array:
    """(columns,) how far loads move bricks before contacts hold them, or what Newton's method has come to."""
    size, damping = float(np.linalg.norm(system.loads)), DAMPING
    motion = _solved(system.matrix.T @ system.matrix, BONDED, system.loads)
    pressed, left = _left_over(system, motion)
    for _ in range(MOST_STEPS):
        if damping > MOST_DAMPING or np.linalg.norm(left) <= AT_REST * size:
            break
        stiffness = system.matrix.T @ _stiffness(system, motion, pressed) @ system.matrix
        step, share = _solved(stiffness, damping, left), 1.0
        while share >= SHORTEST:
            nearer = _left_over(system, motion + share * step)
            if np.linalg.norm(nearer[1]) <= (1.0 - NEARER * share) * np.linalg.norm(left):
                break
            share *= 0.5
        if share < SHORTEST:
            damping *= MORE
            continue
        motion, (pressed, left) = motion + share * step, nearer
        damping = max(LESS * damping, LEAST_DAMPING) if share == 1.0 else damping
    return motion


def _left_over(system: WrenchMatrix, motion: Array) -> tuple[_Pressed, Array]:
    """How contacts answer a motion, and what of the loads they do not balance."""
    pressed = _pressed(system, motion)
    return pressed, system.matrix.T @ pressed.rows + system.loads


def _pressed(system: WrenchMatrix, motion: Array) -> _Pressed:
    """Coulomb's law for springs of unit stiffness."""
    held = 3 * len(system.round)
    slips = system.matrix @ motion
    cones = slips[:held].reshape(-1, 3)
    normal, resisting = np.maximum(-cones[:, 0], 0.0), np.hypot(cones[:, 1], cones[:, 2])
    along = -cones[:, 1:] / np.where(resisting > 0.0, resisting, 1.0)[:, None]
    forces = np.column_stack([normal, along * np.minimum(resisting, normal)[:, None]])
    rows = np.append(forces.ravel(), np.maximum(-slips[held:], 0.0))
    return _Pressed(rows, normal, resisting, along, resisting > normal)


def _stiffness(system: WrenchMatrix, motion: Array, pressed: _Pressed) -> Sparse:
    """(rows, rows) by how much less a contact presses if it opens or slips by a unit."""
    from scipy.sparse import block_diag, bsr_matrix, diags  # noqa: PLC0415 -- slow to import, and few need to ask

    count, along = len(system.round), pressed.along
    blocks = np.zeros((count, 3, 3))
    blocks[:, 0, 0] = pressed.normal > 0.0
    blocks[:, 1:, 0] = along * (pressed.slips & (pressed.normal > 0.0))[:, None]  # friction goes with the pressure
    across = np.identity(2) - along[:, :, None] * along[:, None, :]
    turned = np.divide(pressed.normal, pressed.resisting, out=np.zeros(count), where=pressed.slips)
    blocks[:, 1:, 1:] = np.where(pressed.slips[:, None, None], turned[:, None, None] * across, np.identity(2))
    round_ = bsr_matrix((blocks, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    flat = diags((pressed.rows[3 * count :] > 0.0).astype(float))
    return block_diag([round_, flat], format="csc")


def _normal_rows(system: WrenchMatrix) -> NDArray[np.int64]:
    held = 3 * len(system.round)
    return np.append(np.arange(0, held, 3), np.arange(held, len(system.row_scale)))


def _solved(stiffness: Sparse, damping: float, loads: Array) -> Array:
    """The motion under loads that springs and damping resist; not a number where none does."""
    from scipy.sparse import identity  # noqa: PLC0415 -- slow to import, and few need to ask
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    try:
        motion: Array = splu((stiffness + damping * identity(len(loads))).tocsc()).solve(loads)
    except RuntimeError:  # singular, as far as it can tell
        return np.full(len(loads), np.nan)
    return motion
