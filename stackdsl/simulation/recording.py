"""Records the poses of bricks over time, thinned to the keyframes that are needed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from struct import Struct
from typing import IO, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stability.geometry.rows import Array
from stability.model import BodyId, BodyState, Brick

# Keeps of many poses those that are needed to know all of them: what is at rest needs one where it begins to rest.
#
# A pose is kept when a brick has moved by a hundredth of a millimetre, as far as its farthest corner goes, since the
# last that was kept, counted along its way; so what creeps is not missed. The pose just before is kept as well: until
# then, the brick was there.


# The columns of what is recorded, each in SI units in frame W, orientations as x, y, z, w.
NUMBER, TIME = 0, 1
POSITION, ORIENTATION, POSE = slice(2, 5), slice(5, 9), slice(2, 9)
VELOCITY, SPIN = slice(9, 12), slice(12, 15)
COLUMNS = 15

NOTICED = 1e-5  # [m] of the way of a corner between kept poses; a screen shows a tenth of a millimetre at best
SHORTEST = 0.02  # [s] between kept poses of what moves, once there are too many

Rows = NDArray[np.float64]
Marks = NDArray[np.bool_]


@dataclass
class Thinning:
    """What is kept of the poses of one run, which come in order of time, any number of them at once."""

    most: int  # rows to keep
    _radii: list[float] = field(default_factory=list, init=False)  # of each brick [m]
    _kept: list[Rows] = field(default_factory=list, init=False)
    _last: Rows = field(default_factory=lambda: np.empty((0, COLUMNS)), init=False)  # seen of each brick
    _last_kept: Marks = field(default_factory=lambda: np.empty(0, bool), init=False)  # whether it is among those
    _way: NDArray[np.float64] = field(default_factory=lambda: np.empty(0), init=False)  # of each since one was [m]
    _apart: float = field(default=SHORTEST, init=False)  # how far kept poses of what moves are apart [s]

    def add(self, radius: float) -> None:
        """One more brick is to come; how far its farthest corner is from its centre [m]."""
        self._radii.append(radius)

    def take(self, rows: Rows) -> None:
        """Keep what is needed of these rows."""
        if not len(rows):
            return
        self._way = np.concatenate((self._way, np.zeros(len(self._radii) - len(self._way))))
        fresh = np.arange(len(self._last) + len(rows)) >= len(self._last)
        kept = np.concatenate((self._last_kept, np.zeros(len(rows), bool)))
        rows = np.concatenate((self._last, rows))
        order = np.argsort(rows[:, NUMBER], kind="stable")
        rows, fresh, kept = rows[order], fresh[order], kept[order]
        news = ~_same(rows, (NUMBER, TIME, *range(COLUMNS)[POSE]))
        self._keep(rows[news], fresh[news], kept[news])
        while sum(map(len, self._kept)) > self.most:
            self._apart *= 2.0
            self._kept = [_sparser(_sorted(np.concatenate(self._kept)), self._apart)]

    def keys(self) -> Rows:
        """All rows that are kept, and the last of each brick; by brick, then by time."""
        return _sorted(np.concatenate((*self._kept, self._last[~self._last_kept])))

    def _keep(self, rows: Rows, fresh: Marks, kept: Marks) -> None:
        """Keep what is needed of rows by brick; the first of a brick is its last of before, if that is not fresh."""
        first = ~_same(rows, (NUMBER,))
        last = np.concatenate((first[1:], [True]))
        numbers = rows[:, NUMBER].astype(int)
        way = np.where(first, self._way[numbers], _ways(rows, np.array(self._radii)[numbers]))
        total = np.cumsum(way)
        gone = total - (total - way)[first][np.cumsum(first) - 1]  # by each brick
        passed = np.floor(gone / NOTICED)
        due = np.where(first, fresh, np.concatenate(([False], passed[1:] > passed[:-1])))
        due |= np.concatenate((due[1:] & ~first[1:], [False]))
        self._kept.append(rows[due & ~kept])
        self._last, self._last_kept = rows[last], (due | kept)[last]
        self._way[numbers[last]] = np.fmod(gone[last], NOTICED)


def _sorted(rows: Rows) -> Rows:
    return rows[np.lexsort((rows[:, TIME], rows[:, NUMBER]))]


def _same(rows: Rows, columns: tuple[int, ...]) -> Marks:
    """Which rows are the same in these columns as the row before."""
    columns_of = rows[:, columns]
    return np.concatenate(([False], (columns_of[1:] == columns_of[:-1]).all(axis=1)))


def _ways(rows: Rows, radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far the farthest corner goes at most from the row before to each [m]."""
    shift = np.linalg.norm(np.diff(rows[:, POSITION], axis=0), axis=1)
    q, p = rows[1:, ORIENTATION], rows[:-1, ORIENTATION]
    turn = 2.0 * np.minimum(np.linalg.norm(q - p, axis=1), np.linalg.norm(q + p, axis=1))
    return np.concatenate(([0.0], shift + radii[1:] * turn))


def _sparser(rows: Rows, apart: float) -> Rows:
    """Of what moves one row in so many seconds [s]; what rests begins and ends where it did."""
    near = _same(rows, (NUMBER,)) & np.concatenate(([False], np.diff(rows[:, TIME]) < 2.0 * apart))
    inner = near & np.concatenate((near[1:], [False]))
    turn = np.floor(rows[:, TIME] / apart)
    return rows[~(inner & np.concatenate(([False], turn[1:] == turn[:-1])))]


# Where bricks were between two recorded poses.
#
# What flies or turns freely follows a cubic through both poses that begins and ends with the recorded velocities:
# exactly so in free fall, and to a micrometre where its acceleration changes slowly, as that of a known motion does.
# What was struck in between did not, and its velocities show it: it is taken to have gone straight.


# Share of the way, or [m] and [rad], by which the mean of both velocities may miss the way that was gone.
MISSED = 0.02
MISSED_AT_LEAST = 1e-5


def between(before: Rows, after: Rows, time: float) -> tuple[Array, Array]:
    """Positions (n, 3) [m] and orientations (n, 4) at a time [s] between those of rows, or at the nearer of them."""
    took = after[:, TIME] - before[:, TIME]
    took_something = np.where(took > 0.0, took, 1.0)[:, None]
    part = np.where(took > 0.0, np.clip((time - before[:, TIME]) / took_something[:, 0], 0.0, 1.0), 0.0)[:, None]
    way = after[:, POSITION] - before[:, POSITION]
    turn = _vectors(_multiplied(after[:, ORIENTATION], before[:, ORIENTATION] * [-1.0, -1.0, -1.0, 1.0]))
    shifted = _gone(way, before[:, VELOCITY] * took_something, after[:, VELOCITY] * took_something, part)
    turned = _gone(turn, before[:, SPIN] * took_something, after[:, SPIN] * took_something, part)
    return before[:, POSITION] + shifted, _multiplied(_quaternions(turned), before[:, ORIENTATION])


def _gone(way: Array, first: Array, last: Array, part: Array) -> Array:
    """How much of a way was gone after a part of the time, with velocities in ways a time at both ends."""
    off = np.linalg.norm(0.5 * (first + last) - way, axis=1)
    free = off <= np.maximum(MISSED * np.linalg.norm(way, axis=1), MISSED_AT_LEAST)
    squared, cubed = part**2, part**3
    cubic = (part - 2 * squared + cubed) * first + (3 * squared - 2 * cubed) * way + (cubed - squared) * last
    return np.where(free[:, None], cubic, part * way)


def _multiplied(q: Array, p: Array) -> Array:
    """The turns q after p, each (n, 4)."""
    v, w, u, s = q[:, :3], q[:, 3:], p[:, :3], p[:, 3:]
    return np.hstack((w * u + s * v + np.cross(v, u), w * s - (v * u).sum(axis=1, keepdims=True)))


def _vectors(q: Array) -> Array:
    """The shorter turns as axes times angles (n, 3) [rad]."""
    q = np.where(q[:, 3:] < 0.0, -q, q)
    length = np.linalg.norm(q[:, :3], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(length, q[:, 3:])
    return np.where(length > 0.0, angle / np.where(length > 0.0, length, 1.0), 2.0) * q[:, :3]


def _quaternions(vectors: Array) -> Array:
    """The turns of axes times angles (n, 3) [rad]."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.hstack((0.5 * np.sinc(angle / (2.0 * np.pi)) * vectors, np.cos(0.5 * angle)))


# What was recorded of a run, as arrays: where each brick was at any time of it.


class Track(NamedTuple):
    """The recorded poses of one brick, in order of time; between two of them it was on its way from one to the next."""

    times: Array  # (n,) [s]
    positions: Array  # (n, 3), of its centre of mass in W [m]
    orientations: Array  # (n, 4), from body axes to W, as x, y, z, w
    velocities: Array  # (n, 3), of its centre of mass in W [m/s]
    spins: Array  # (n, 3), angular velocity in W [rad/s]


class Poses(NamedTuple):
    """Where all bricks were at one time; a brick that had not come yet, or was gone, has nan."""

    positions: Array  # (bricks, 3) [m]
    orientations: Array  # (bricks, 4)


@dataclass(frozen=True)
class Recording:
    """Where bricks were in a run: poses of what moved at the looks of the runner, and of what rested where it did."""

    bricks: Sequence[Brick]  # in the order in which they came
    keys: Rows  # by brick, then by time; the columns are those of thinning.py
    gone: Array  # (bricks,), when each was pulled out [s]; inf for one that stayed
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
    def times(self) -> Array:
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


# Keeps where bricks are while a run is played, wherever the runner looks: nothing of what is at rest.
#
# Poses come in as the runner has them, so that no engine is asked anything more, and what is recorded is the same from
# each of them, and from motions that no engine takes part in. They are packed as they come, which is cheaper than to
# keep them, and are thinned some ten thousand at a time.


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
