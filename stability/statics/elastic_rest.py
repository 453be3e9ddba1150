"""Load-induced forces: those under which slightly elastic contacts bring a structure to rest.

Every contact point is a normal spring, which pushes and never pulls, and a tangential spring, which resists a slip up
to the friction limit. Loads that grow from zero on unstressed contacts either lead to rest or do not. A wedge tightens
itself between steep walls; a plank between vertical walls does not, although both would hold if squeezed. Kao et al.
(2022), "Coupled Rigid-Block Analysis", likewise couple forces with a small motion, which they bound; here contacts have
a stiffness instead, and any stiffness that leads to rest is sufficient.

There may be states of rest that loads do not reach: a row of blocks between vertical walls would hold as an arch, but
falls as one body without normal forces. Therefore the motion is followed from the initial state, with a drag on each
brick proportional to its mass, so that freely falling bricks fall together. Every step is implicit: Newton's method
finds a root, and steps grow while it converges. The final forces are checked; a failure proves nothing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stability.geometry.placed_shape import inertia_about_axes
from stability.geometry.rows import Array
from stability.problem import Forces, Problem, Tolerances
from stability.statics.equilibrium import proven_forces
from stability.statics.wrench_matrix import Sparse, WrenchMatrix, wrench_matrix

# Ratio of slip to compression at a loaded contact: a slimmer wedge sinks so far that it may touch other faces there.
FURTHEST = 1000.0
SLIGHT = 1e-3  # share of the load capacity: a smaller normal force may act at any slip
ROUNDING = 1e-12  # share of the displacement of the bricks
MOST_STEPS, MOST_ROUNDS = 80, 10
# shares of the loads without balance: the target, and the limit at which rounding may end a step
AT_REST, ROUNDED = 1e-13, 1e-9
CLOSE = 1e-2  # share of the residual before a step: a smaller one ends the step
FIRST, LEAST, MOST = 1.0, 1e-14, 1e12  # drag of a step, as a share of the stiffness
LESS, MORE = 0.4, 5.0  # factors on the drag after a step, and after a step without a root
SHORTER, SHORTEST = 0.5, 0.02  # shares of the step of Newton's method
NEARER = 1e-4  # share of the residual that a whole step must remove


@dataclass(frozen=True, slots=True, eq=False)
class _Pressed:
    """Contact forces of a displacement, in the units of the rows."""

    rows: Array  # (rows,) forces within their cones
    normal: Array  # (k,) normal forces at the cones with friction
    resisting: Array  # (k,) tangential spring forces without a friction limit
    along: Array  # (k, 2) their directions, unit vectors
    slips: NDArray[np.bool_]  # (k,) whether the friction limit is reached


@dataclass(frozen=True, slots=True, eq=False)
class _Moved:
    """Displacements of bricks, and the resulting forces."""

    motion: Array  # (columns,)
    pressed: _Pressed
    left: Array  # (columns,) the loads that no contact balances

    @property
    def size(self) -> float:
        return float(np.linalg.norm(self.left))


def elastic_rest(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Forces | None:
    """Return the load-induced forces that balance a problem; None if none are found."""
    system = wrench_matrix(problem)
    moved = _given_way(problem, system)
    if _is_far(system, moved.pressed):
        return None
    return proven_forces(problem, system, moved.pressed.rows, tolerances)


def load_induced_forces(problem: Problem) -> Array:
    """Return the load-induced forces (cones, 3) [N]; without rest, those of the last attempt."""
    system = wrench_matrix(problem)
    return system.forces_W(_given_way(problem, system).pressed.rows)


def _given_way(problem: Problem, system: WrenchMatrix) -> _Moved:
    """Return the displacement at which contacts hold the loads, or the last one before the search ends."""
    moved, masses, drag = _moved(system, np.zeros(len(system.loads))), _masses(problem, system), FIRST
    loads = moved.size
    for _ in range(MOST_STEPS):
        after = _stepped(system, moved, drag * masses)
        if after is None:
            if moved.size <= ROUNDED * loads:
                return _polished(system, moved, LEAST * masses)
            drag *= MORE
            if drag > MOST:
                break
            continue
        moved, drag = after, max(LESS * drag, LEAST)
        if moved.size <= AT_REST * loads or _falls_freely(system, moved):
            break
    return moved


def _polished(system: WrenchMatrix, moved: _Moved, drag: Sparse) -> _Moved:
    """Return a point nearer to rest, within the accuracy of Newton's method."""
    for _ in range(MOST_ROUNDS):
        after = _moved(system, moved.motion + _solved(_stiffness(system, moved.pressed) + drag, moved.left))
        if not after.size < moved.size:
            break
        moved = after
    return moved


def _stepped(system: WrenchMatrix, before: _Moved, drag: Sparse) -> _Moved | None:
    """Return the balance of loads, contacts and drag at the end of a step; None if it is not found."""
    moved, rest = before, before.left
    for _ in range(MOST_ROUNDS):
        way, share, size = _solved(_stiffness(system, moved.pressed) + drag, rest), 1.0, float(np.linalg.norm(rest))
        while share >= SHORTEST:
            after = _moved(system, moved.motion + share * way)
            rest = after.left - drag @ (after.motion - before.motion)
            if np.linalg.norm(rest) <= (1.0 - NEARER * share) * size:
                break
            share *= SHORTER
        if share < SHORTEST:
            return None
        moved = after
        if np.linalg.norm(rest) <= CLOSE * before.size:
            return moved
    return None


def _moved(system: WrenchMatrix, motion: Array) -> _Moved:
    pressed = _pressed(system, motion)
    return _Moved(motion, pressed, system.matrix.T @ pressed.rows + system.loads)


def _falls_freely(system: WrenchMatrix, moved: _Moved) -> bool:
    """Return whether no contact is closed, at any displacement."""
    closed = moved.pressed.rows[system.rows.normals].max(initial=0.0)
    return bool(closed <= ROUNDING * np.abs(moved.motion).max(initial=0.0))


def _is_far(system: WrenchMatrix, pressed: _Pressed) -> bool:
    """Return whether the largest slip of a loaded contact is too large for its largest compression."""
    shapes = system.cones.shapes
    contact = np.repeat(np.arange(len(shapes)), [points * normals for points, normals in shapes])[system.round]
    closed, slipped = np.zeros(len(shapes)), np.zeros(len(shapes))
    np.maximum.at(closed, contact, pressed.normal)
    np.maximum.at(slipped, contact, pressed.resisting / system.cones.friction[system.round])
    return bool((slipped > FURTHEST * closed)[closed > SLIGHT].any())


def _pressed(system: WrenchMatrix, motion: Array) -> _Pressed:
    """Return the forces of springs of unit stiffness by Coulomb's law."""
    ways = system.matrix @ motion
    cones = system.rows.triples(ways)
    normal, resisting = np.maximum(-cones[:, 0], 0.0), np.hypot(cones[:, 1], cones[:, 2])
    along = -cones[:, 1:] / np.where(resisting > 0.0, resisting, 1.0)[:, None]
    forces = np.column_stack([normal, along * np.minimum(resisting, normal)[:, None]])
    rows = system.rows.joined(forces, np.maximum(-system.rows.singles(ways), 0.0))
    return _Pressed(rows, normal, resisting, along, resisting > normal)


def _stiffness(system: WrenchMatrix, pressed: _Pressed) -> Sparse:
    """Return (columns, columns) the change of contact forces per unit of displacement."""
    from scipy.sparse import block_diag, bsr_matrix, diags  # noqa: PLC0415 -- slow to import, and few need to ask

    count, along = system.rows.round, pressed.along
    blocks = np.zeros((count, 3, 3))
    blocks[:, 0, 0] = pressed.normal > 0.0
    # friction is proportional to the normal force
    blocks[:, 1:, 0] = along * (pressed.slips & (pressed.normal > 0.0))[:, None]
    across = np.identity(2) - along[:, :, None] * along[:, None, :]
    turned = np.divide(pressed.normal, pressed.resisting, out=np.zeros(count), where=pressed.slips)
    blocks[:, 1:, 1:] = np.where(pressed.slips[:, None, None], turned[:, None, None] * across, np.identity(2))
    round_ = bsr_matrix((blocks, np.arange(count), np.arange(count + 1)), shape=(system.rows.of_round,) * 2)
    flat = diags((system.rows.singles(pressed.rows) > 0.0).astype(float))
    return system.matrix.T @ block_diag([round_, flat], format="csc") @ system.matrix


def _masses(problem: Problem, system: WrenchMatrix) -> Sparse:
    """Return (columns, columns) masses and moments of inertia of the bricks, the largest entry 1."""
    from scipy.sparse import block_diag  # noqa: PLC0415 -- slow to import, and few need to ask

    blocks = []
    for number, name in enumerate(system.names):
        placed, scale = problem.bricks[name], system.column_scale[6 * number : 6 * number + 6]
        block = placed.brick.mass * np.identity(6)
        block[3:, 3:] = inertia_about_axes(placed.brick, placed.pose.orientation)
        blocks.append(block / np.outer(scale, scale))
    whole = block_diag(blocks, format="csr")[system.kept][:, system.kept]
    return whole / whole.diagonal().max(initial=np.finfo(float).tiny)


def _solved(stiffness: Sparse, loads: Array) -> Array:
    """Return the displacement under loads against springs and drag; NaN if nothing resists."""
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- slow to import, and few need to ask

    try:
        motion: Array = splu(stiffness.tocsc()).solve(loads)
    except RuntimeError:  # singular within rounding
        return np.full(len(loads), np.nan)
    return motion
