"""Where bricks were between two recorded poses.

What flies or turns freely follows a cubic through both poses that begins and ends with the recorded velocities: exactly
so in free fall, and to a micrometre where its acceleration changes slowly, as that of a known motion does. What was
struck in between did not, and its velocities show it: it is taken to have gone straight.
"""

import numpy as np
from numpy.typing import NDArray

from stackdsl.recording.thinning import ORIENTATION, POSITION, SPIN, TIME, VELOCITY, Rows

Floats = NDArray[np.float64]

# Share of the way, or [m] and [rad], by which the mean of both velocities may miss the way that was gone.
MISSED = 0.02
MISSED_AT_LEAST = 1e-5


def between(before: Rows, after: Rows, time: float) -> tuple[Floats, Floats]:
    """Positions (n, 3) [m] and orientations (n, 4) at a time [s] between those of rows, or at the nearer of them."""
    took = after[:, TIME] - before[:, TIME]
    took_something = np.where(took > 0.0, took, 1.0)[:, None]
    part = np.where(took > 0.0, np.clip((time - before[:, TIME]) / took_something[:, 0], 0.0, 1.0), 0.0)[:, None]
    way = after[:, POSITION] - before[:, POSITION]
    turn = _vectors(_multiplied(after[:, ORIENTATION], before[:, ORIENTATION] * [-1.0, -1.0, -1.0, 1.0]))
    shifted = _gone(way, before[:, VELOCITY] * took_something, after[:, VELOCITY] * took_something, part)
    turned = _gone(turn, before[:, SPIN] * took_something, after[:, SPIN] * took_something, part)
    return before[:, POSITION] + shifted, _multiplied(_quaternions(turned), before[:, ORIENTATION])


def _gone(way: Floats, first: Floats, last: Floats, part: Floats) -> Floats:
    """How much of a way was gone after a part of the time, with velocities in ways a time at both ends."""
    off = np.linalg.norm(0.5 * (first + last) - way, axis=1)
    free = off <= np.maximum(MISSED * np.linalg.norm(way, axis=1), MISSED_AT_LEAST)
    squared, cubed = part**2, part**3
    cubic = (part - 2 * squared + cubed) * first + (3 * squared - 2 * cubed) * way + (cubed - squared) * last
    return np.where(free[:, None], cubic, part * way)


def _multiplied(q: Floats, p: Floats) -> Floats:
    """The turns q after p, each (n, 4)."""
    v, w, u, s = q[:, :3], q[:, 3:], p[:, :3], p[:, 3:]
    return np.hstack((w * u + s * v + np.cross(v, u), w * s - (v * u).sum(axis=1, keepdims=True)))


def _vectors(q: Floats) -> Floats:
    """The shorter turns as axes times angles (n, 3) [rad]."""
    q = np.where(q[:, 3:] < 0.0, -q, q)
    length = np.linalg.norm(q[:, :3], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(length, q[:, 3:])
    return np.where(length > 0.0, angle / np.where(length > 0.0, length, 1.0), 2.0) * q[:, :3]


def _quaternions(vectors: Floats) -> Floats:
    """The turns of axes times angles (n, 3) [rad]."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.hstack((0.5 * np.sinc(angle / (2.0 * np.pi)) * vectors, np.cos(0.5 * angle)))
