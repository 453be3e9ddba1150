"""Of all forces that hold an assembly at its reach, those in the middle.

Forces in indeterminate contacts are many, and where among them a solver ends is an accident. Those that maximise the
product of what all cones have to spare are one, and turn smoothly with the direction; so they can be interpolated.
Where bodies slip the force lies on the far side of its cone, against the slip; where they part there is none.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.statics.solvers.wrench_matrix import Array, Sparse, WrenchMatrix

MOST_STEPS = 16  # of Newton's; half of them are usual
CENTRED = 1e-14  # Newton's decrement squared below which a further step changes nothing that counts
BALANCED = 1e-11  # what may be left over, in units of what bricks carry
BOUND = 0.7  # share of the way to the border that a step may go
TINIEST = 1e-300  # close to the smallest normal float, 2e-308: no division by zero where nothing slips at all
FAINT = 1e-9  # keeps directions in which no force can act out of the way

Places: TypeAlias = tuple[NDArray[np.int32], NDArray[np.int32]]  # rows of entries, and where each column begins


@dataclass(frozen=True, slots=True, eq=False)
class _Face:
    """The forces that are left: three parts where bodies stick, one along a ray where they slip or have no friction."""

    basis: Sparse  # (rows, values)
    sticking: int  # cones, whose values come first
    start: Array  # (values,)


def centred(system: WrenchMatrix, rows: Array, slips: Array) -> Array:
    """The forces in the middle of those that balance the same loads as `rows`, against these slips."""
    from scipy.sparse import identity  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    face = _face(len(system.round), rows, slips)
    balance = (system.matrix.T @ face.basis).tocsc()
    transposed, faint = balance.T, FAINT * identity(balance.shape[0], format="csc")
    blocks = _blocks(face.sticking, len(face.start))
    wanted = system.matrix.T @ rows
    values = face.start
    for _ in range(MOST_STEPS):
        gradient, inverse = _barrier(values, face.sticking, blocks)
        pull = inverse @ gradient
        normal = (balance @ inverse @ transposed + faint).tocsc()
        missing = wanted - balance @ values
        step = inverse @ (transposed @ splu(normal).solve(missing + balance @ pull)) - pull
        share = _share(values, step, face.sticking)
        values = values + share * step
        if share == 1.0 and abs(step @ gradient) < CENTRED and np.abs(missing).max(initial=0.0) < BALANCED:
            break
    return np.asarray(face.basis @ values)


def _face(held: int, rows: Array, slips: Array) -> _Face:
    """Which cones stick, slip or are open: of force and slip one is on the border of its cone, the lesser one."""
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    slips = slips / max(float(np.abs(slips).max(initial=0.0)), TINIEST)
    forces, sliding = rows[: 3 * held].reshape(-1, 3), slips[: 3 * held].reshape(-1, 3)
    tangential, across = np.hypot(forces[:, 1], forces[:, 2]), np.hypot(sliding[:, 1], sliding[:, 2])
    opens = sliding[:, 0] - across > forces[:, 0] + tangential
    slides = ~opens & (sliding[:, 0] > forces[:, 0] - tangential)
    sticks, slipping = np.flatnonzero(~opens & ~slides), np.flatnonzero(slides)
    presses = np.flatnonzero(rows[3 * held :] >= slips[3 * held :])
    stuck = (3 * sticks[:, None] + np.arange(3)).ravel()
    # The force's own direction, not the slip's: the two agree to what the solver gives, but forces balance exactly.
    rays = forces[slipping] / np.where(forces[slipping, :1] > 0.0, forces[slipping, :1], 1.0)
    row = np.concatenate([stuck, (3 * slipping[:, None] + np.arange(3)).ravel(), 3 * held + presses])
    entry = np.concatenate([np.ones(len(stuck)), rays.ravel(), np.ones(len(presses))])
    singles = len(stuck) + np.concatenate(
        [np.repeat(np.arange(len(slipping)), 3), len(slipping) + np.arange(len(presses))]
    )
    column = np.concatenate([np.arange(len(stuck)), singles])
    count = len(stuck) + len(slipping) + len(presses)
    start = np.concatenate([rows[stuck], rows[3 * slipping], rows[3 * held + presses]])
    return _Face(
        csc_matrix((entry, (row, column)), shape=(len(rows), count)), len(sticks), _off_the_border(start, len(sticks))
    )


def _off_the_border(values: Array, sticking: int) -> Array:
    """Values strictly within their cones."""
    values = values.copy()
    cones = values[: 3 * sticking].reshape(-1, 3)
    cones[:, 0] = np.maximum(cones[:, 0], np.hypot(cones[:, 1], cones[:, 2]) * (1.0 + FAINT) + FAINT)
    values[3 * sticking :] = np.maximum(values[3 * sticking :], FAINT)
    return values


def _blocks(sticking: int, count: int) -> Places:
    """Where the entries of a matrix are that has a block of three for each part that sticks, then single values.

    By column, as sparse matrices keep them.
    """
    first = 3 * np.arange(sticking, dtype=np.int32)
    rows = np.repeat(first, 9) + np.tile(np.arange(3, dtype=np.int32), 3 * sticking)
    singles = np.arange(3 * sticking, count, dtype=np.int32)
    sizes = np.concatenate([np.full(3 * sticking, 3), np.ones(len(singles), dtype=int)])
    return np.concatenate([rows, singles]), np.append(0, np.cumsum(sizes)).astype(np.int32)


def _barrier(values: Array, sticking: int, at: Places) -> tuple[Array, Sparse]:
    """The gradient of minus the logarithm of what is to spare, and the inverse of its Hessian, z z' - (q/2) J.

    `at` are the places of the entries of the latter, which stay the same from step to step.
    """
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    cones, singles = values[: 3 * sticking].reshape(-1, 3), values[3 * sticking :]
    signs = np.array([1.0, -1.0, -1.0])
    spare = (cones * cones) @ signs
    gradient = np.append((-2.0 * signs * cones / spare[:, None]).ravel(), -1.0 / singles)
    blocks = cones[:, :, None] * cones[:, None, :] - 0.5 * spare[:, None, None] * np.diag(signs)
    entries = np.append(blocks.ravel(), singles * singles)  # the blocks are symmetric
    return gradient, csc_matrix((entries, *at), shape=(len(values), len(values)))


def _share(values: Array, step: Array, sticking: int) -> float:
    """The whole step, or as much of it as stays well within the cones."""
    share = 1.0
    while share > FAINT:
        cones = (values + share / BOUND * step)[: 3 * sticking].reshape(-1, 3)
        if (cones[:, 0] > np.hypot(cones[:, 1], cones[:, 2])).all() and (
            (values + share / BOUND * step)[3 * sticking :] > 0.0
        ).all():
            return share
        share *= BOUND
    return 0.0
