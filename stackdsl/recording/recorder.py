"""Keeps where bricks are while a run is played, wherever the runner looks: nothing of what is at rest.

Poses come in as the runner has them, so that no engine is asked anything more, and what is recorded is the same from
each of them, and from motions that no engine takes part in. They are packed as they come, which is cheaper than to keep
them, and are thinned some ten thousand at a time.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from struct import Struct
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stability.model import BodyId, BodyState, Brick
from stackdsl.recording.recording import Recording
from stackdsl.recording.thinning import COLUMNS, Thinning

AT_A_TIME = 20_000  # poses that wait to be thinned; some megabytes
MOST_KEYS = 1_000_000  # that are kept; 120 MB
ROW: Final = Struct(f"{COLUMNS}d")


@dataclass
class Recorder:
    """Records one run. Give it to `play`, then ask for the `recording`."""

    most_keys: int = MOST_KEYS  # beyond, every other key of what moves is given up, and so on
    _waiting: bytearray = field(default_factory=bytearray, init=False)  # rows, as they are in memory
    _numbers: dict[BodyId, int] = field(default_factory=dict, init=False)  # of bricks, in the order in which they came
    _bricks: list[Brick] = field(default_factory=list, init=False)
    _gone: dict[BodyId, float] = field(default_factory=dict, init=False)  # when each was pulled out [s]
    _thinning: Thinning = field(init=False)

    def __post_init__(self) -> None:
        self._thinning = Thinning(self.most_keys)

    def add(self, time: float, brick: Brick, state: BodyState) -> None:
        """A brick has come at a time [s]."""
        self._numbers[brick.id] = len(self._bricks)
        self._bricks.append(brick)
        self._thinning.add(brick.shape.bounding_radius)
        self.see(time, {brick.id: state})

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in where bricks are at a time [s], which is no earlier than any before."""
        pack, numbers = ROW.pack, self._numbers
        for name, s in states.items():
            pose = s.pose
            self._waiting += pack(
                numbers[name], time, *pose.position_W, *pose.orientation, *s.velocity_W, *s.angular_velocity_W
            )
        if len(self._waiting) >= AT_A_TIME * ROW.size:
            self._put_away()

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        """These were pulled out at a time [s]."""
        self._gone |= dict.fromkeys(bricks, time)

    def recording(self) -> Recording:
        """What was recorded so far; each brick with its first pose and its last."""
        self._put_away()
        gone = np.array([self._gone.get(brick.id, np.inf) for brick in self._bricks])
        return Recording(tuple(self._bricks), self._thinning.keys(), gone)

    def _put_away(self) -> None:
        table: NDArray[np.float64] = np.frombuffer(self._waiting).reshape(-1, COLUMNS)
        self._waiting = bytearray()
        self._thinning.take(table)
