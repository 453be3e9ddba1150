"""Moreau's impact law with Coulomb friction, as a cone complementarity problem, and its solver.

For every contact, with the normal velocity u_n after the step, its tangential one u_t, the impulses p_n and p_t:

    0 <= p_n  _|_  u_n + gap / dt + softness p_n >= 0,
    |p_t| <= mu p_n,  and  p_t = -mu p_n u_t / |u_t|  where u_t is not 0.

Hits are plastic and simultaneous, and friction acts during the hit as well. The problem is solved by projected
Gauss-Seidel, forwards and backwards over the contacts in turn, from the impulses of the last step, until no sweep
changes a velocity by more than a tolerance.
"""

import numpy as np
from numba import njit

from benchmarks.moreau.box_contacts import Array


@njit(cache=True)
def solve(
    pairs: Array, frames: Array, arms: Array, wanted: Array, softness: float, friction: float,
    inverse_mass: Array, inverse_inertia: Array, speeds: Array, impulses: Array, tolerance: float, most: int,
) -> int:  # fmt: skip
    """Change `impulses` (n, 3: normal, two tangents) and `speeds` (bodies, 6) to a solution; return the sweeps used.

    `pairs` (n, 2) holds the bodies, -1 for a fixed body; the first pushes the second along `frames[:, 0]`. `arms` (n,
    2, 3) lead from their centres to the point. `wanted` is the least normal velocity, -gap / dt.
    """
    contacts = len(pairs)
    rows = np.zeros((contacts, 3, 2, 6))  # of the Jacobian: an axis of the frame, and arm x axis, with a sign
    answers = np.zeros((contacts, 3, 2, 6))  # responses of both bodies to an impulse along it
    direct, across = np.zeros(contacts), np.zeros(contacts)
    for c in range(contacts):
        block = np.zeros((3, 3))
        for s in range(2):
            body = pairs[c, s]
            if body < 0:
                continue
            for k in range(3):
                lever = np.cross(arms[c, s], frames[c, k])
                rows[c, k, s, :3], rows[c, k, s, 3:] = (2 * s - 1) * frames[c, k], (2 * s - 1) * lever
                answers[c, k, s, :3] = inverse_mass[body] * rows[c, k, s, :3]
                answers[c, k, s, 3:] = inverse_inertia[body] @ rows[c, k, s, 3:]
            for k in range(3):
                for m in range(3):
                    block[k, m] += np.sum(rows[c, k, s] * answers[c, m, s])
        direct[c] = block[0, 0] + softness
        half, off = 0.5 * (block[1, 1] + block[2, 2]), block[1, 2]
        across[c] = half + np.sqrt((0.5 * (block[1, 1] - block[2, 2])) ** 2 + off * off)
        for k in range(3):
            _push(pairs, answers, c, k, speeds, impulses[c, k])
    for sweep in range(most):
        changed = 0.0
        for place in range(contacts):
            c = place if sweep % 2 == 0 else contacts - 1 - place
            before_n, before_1, before_2 = impulses[c, 0], impulses[c, 1], impulses[c, 2]
            missing = wanted[c] - softness * before_n - _speed(pairs, rows, c, 0, speeds)
            n = max(0.0, before_n + missing / direct[c])
            if n == 0.0 and before_n == 0.0:
                continue
            _push(pairs, answers, c, 0, speeds, n - before_n)
            t_1 = before_1 - _speed(pairs, rows, c, 1, speeds) / across[c]
            t_2 = before_2 - _speed(pairs, rows, c, 2, speeds) / across[c]
            size, limit = np.sqrt(t_1 * t_1 + t_2 * t_2), friction * n
            if size > limit:
                t_1, t_2 = t_1 * limit / size, t_2 * limit / size
            _push(pairs, answers, c, 1, speeds, t_1 - before_1)
            _push(pairs, answers, c, 2, speeds, t_2 - before_2)
            impulses[c, 0], impulses[c, 1], impulses[c, 2] = n, t_1, t_2
            changed = max(changed, abs(n - before_n) * direct[c])
            changed = max(changed, max(abs(t_1 - before_1), abs(t_2 - before_2)) * across[c])
        if changed < tolerance:
            return sweep + 1
    return most


@njit(cache=True)
def _speed(pairs: Array, rows: Array, c: int, axis: int, speeds: Array) -> float:
    """Return the velocity of the second body relative to the first at a contact, along an axis of its frame [m/s]."""
    total = 0.0
    for s in range(2):
        body = pairs[c, s]
        if body >= 0:
            for k in range(6):
                total += rows[c, axis, s, k] * speeds[body, k]
    return total


@njit(cache=True)
def _push(pairs: Array, answers: Array, c: int, axis: int, speeds: Array, impulse: float) -> None:
    """Apply an impulse along an axis to the second body, and its reaction to the first."""
    for s in range(2):
        body = pairs[c, s]
        if body >= 0:
            for k in range(6):
                speeds[body, k] += impulse * answers[c, axis, s, k]
