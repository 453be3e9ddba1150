"""Poses over time in few bytes: rounded to what can be seen, told by how they change, and deflated.

All that a brick does is told column by column (times, x, y, z, and the four parts of its orientation), as differences
of differences of whole numbers: of what goes on as it did, these are zeros. `unpack.ts` reads it.
"""

import base64
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stackdsl.recording.recording import Recording
from stackdsl.recording.thinning import NUMBER, ORIENTATION, POSITION, TIME

FINEST = 400.0  # the smallest side of all bricks in units of position: 0.02 mm of a plank of 7.8 mm
TURNS = 16_384.0  # a unit quaternion in units of orientation: 7 micrometres at the end of a plank of 120 mm
TICKS = 10_000.0  # a second in units of time


@dataclass(frozen=True, slots=True)
class Packed:
    """The poses of a recording."""

    counts: tuple[int, ...]  # of each brick
    origin: tuple[float, float, float]  # of the whole numbers [m]
    unit: float  # of a position [m]
    data: str  # base64 of deflated bytes


def packed(recording: Recording) -> Packed:
    """All poses of a recording."""
    rows = recording.keys
    numbers = rows[:, NUMBER].astype(int)
    smallest = min((brick.shape.least_thickness for brick in recording.bricks), default=1.0)
    origin = np.round(rows[:, POSITION].mean(axis=0), 6) if len(rows) else np.zeros(3)
    away = float(np.abs(rows[:, POSITION] - origin).max(initial=0.0))
    unit = max(smallest / FINEST, away / 2.0**30)
    whole = np.hstack(
        (
            np.round(rows[:, TIME : TIME + 1] * TICKS),
            np.round((rows[:, POSITION] - origin) / unit),
            np.round(_continuous(rows[:, ORIENTATION], numbers) * TURNS),
        )
    ).astype(np.int64)
    first = np.concatenate(([True], numbers[1:] != numbers[:-1])) if len(rows) else np.empty(0, bool)
    changes = _changes(_changes(whole, first), first).astype(np.int32)
    counts = np.bincount(numbers, minlength=len(recording.bricks)) if len(rows) else np.empty(0, int)
    return Packed(tuple(counts.tolist()), tuple(origin.tolist()), unit, deflated(_planes(changes.T)))


def packed_floats(values: NDArray[np.float64]) -> str:
    """Numbers with the seven digits of a 32-bit float, as base64 of deflated bytes."""
    return deflated(_planes(values.astype("<f4").view("<i4")))


def deflated(data: bytes) -> str:
    """Bytes as base64 of what zlib makes of them."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _changes(whole: NDArray[np.int64], first: NDArray[np.bool_]) -> NDArray[np.int64]:
    """What is added to each row from the one before; the first of each brick as it is."""
    before = np.vstack((np.zeros_like(whole[:1]), whole[:-1]))
    return whole - np.where(first[:, None], 0, before)


def _planes(whole: NDArray[np.int32]) -> bytes:
    """The lowest bytes of all numbers, then the next ones, and so on: small numbers leave the latter empty."""
    return np.ascontiguousarray(whole.astype("<i4").reshape(-1, 1).view(np.uint8).reshape(-1, 4).T).tobytes()


def _continuous(orientations: NDArray[np.float64], numbers: NDArray[np.intp]) -> NDArray[np.float64]:
    """The same turns, each brick's quaternions with the signs that make them change least."""
    if not len(orientations):
        return orientations
    flips = np.where((orientations[1:] * orientations[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    flips[numbers[1:] != numbers[:-1]] = 1.0
    signs = np.concatenate(([1.0], np.cumprod(flips)))
    starts = signs[np.searchsorted(numbers, numbers)]
    steady: NDArray[np.float64] = orientations * (signs * starts)[:, None]
    return steady
