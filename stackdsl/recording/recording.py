"""What was recorded of a run, as arrays: where each brick was at any time of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stability.model import BodyId, Brick
from stackdsl.recording.between import between
from stackdsl.recording.thinning import NUMBER, ORIENTATION, POSITION, SPIN, TIME, VELOCITY, Rows

Floats = NDArray[np.float64]


class Track(NamedTuple):
    """The recorded poses of one brick, in order of time; between two of them it was on its way from one to the next."""

    times: Floats  # (n,) [s]
    positions: Floats  # (n, 3), of its centre of mass in W [m]
    orientations: Floats  # (n, 4), from body axes to W, as x, y, z, w
    velocities: Floats  # (n, 3), of its centre of mass in W [m/s]
    spins: Floats  # (n, 3), angular velocity in W [rad/s]


class Poses(NamedTuple):
    """Where all bricks were at one time; a brick that had not come yet, or was gone, has nan."""

    positions: Floats  # (bricks, 3) [m]
    orientations: Floats  # (bricks, 4)


@dataclass(frozen=True)
class Recording:
    """Where bricks were in a run: poses of what moved at the looks of the runner, and of what rested where it did."""

    bricks: Sequence[Brick]  # in the order in which they came
    keys: Rows  # by brick, then by time; the columns are those of thinning.py
    gone: Floats  # (bricks,), when each was pulled out [s]; inf for one that stayed
    _numbers: dict[BodyId, int] = field(init=False, compare=False)
    _begins: NDArray[np.intp] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_numbers", {brick.id: number for number, brick in enumerate(self.bricks)})
        begins = np.searchsorted(self.keys[:, NUMBER], np.arange(len(self.bricks) + 1))
        object.__setattr__(self, "_begins", begins)

    @property
    def names(self) -> tuple[BodyId, ...]:
        """The names of the bricks, in the order in which they came."""
        return tuple(self._numbers)

    @property
    def times(self) -> Floats:
        """All times at which something was seen to move, or to come [s]; each once."""
        return np.unique(self.keys[:, TIME])

    def track(self, brick: BodyId) -> Track:
        """The recorded poses of a brick. Raises LookupError for one that never came."""
        if brick not in self._numbers:
            raise LookupError(f"no brick '{brick}' came in this run")
        number = self._numbers[brick]
        rows = self.keys[self._begins[number] : self._begins[number + 1]]
        return Track(rows[:, TIME], rows[:, POSITION], rows[:, ORIENTATION], rows[:, VELOCITY], rows[:, SPIN])

    def at(self, time: float) -> Poses:
        """Where all bricks were at a time [s], by their order."""
        keys = self.keys
        after = np.array(
            [
                begin + np.searchsorted(keys[begin:end, TIME], time, side="right")
                for begin, end in zip(self._begins[:-1], self._begins[1:], strict=True)
            ],
            dtype=np.intp,
        )
        there = (after > self._begins[:-1]) & (time < self.gone)
        after = np.maximum(after, self._begins[:-1] + 1)
        last = np.minimum(after, self._begins[1:] - 1)
        positions, orientations = between(keys[after - 1], keys[last], time)
        positions[~there], orientations[~there] = np.nan, np.nan
        return Poses(positions, orientations)

    def save(self, file: Path | IO[bytes]) -> None:
        """Write it to a file of numpy arrays (.npz), which docs/python-api.md lists."""
        rows = self.keys
        corners = [np.array(brick.shape.corners) for brick in self.bricks]
        np.savez_compressed(
            file,
            names=np.array(self.names),
            masses=np.array([brick.mass for brick in self.bricks]),
            corners=np.concatenate(corners) if corners else np.empty((0, 3)),
            corner_counts=np.array([len(each) for each in corners], dtype=int),
            gone=self.gone,
            brick=rows[:, NUMBER].astype(int),
            time=rows[:, TIME],
            position=rows[:, POSITION],
            orientation=rows[:, ORIENTATION],
            velocity=rows[:, VELOCITY],
            spin=rows[:, SPIN],
        )
