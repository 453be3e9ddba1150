"""Records the poses of bricks over time, thinned to keyframes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from struct import Struct
from typing import IO, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stability.geometry.rows import Array
from stability.model import BodyId, BodyState, Brick

# Keyframe reduction: keeps the poses from which all others can be interpolated. A brick at rest needs only the first of
# them.
#
# A pose is kept when the farthest corner of a brick has moved by a hundredth of a millimetre along its path since the
# last kept pose, so creep is recorded too. The pose just before is kept as well, as the brick was there until then.


# Columns of a recorded row: SI units, frame W, orientations as x, y, z, w.
NUMBER, TIME = 0, 1
POSITION, ORIENTATION, POSE = slice(2, 5), slice(5, 9), slice(2, 9)
VELOCITY, SPIN = slice(9, 12), slice(12, 15)
COLUMNS = 15

NOTICED = 1e-5  # [m] path of a corner between kept poses; a screen shows a tenth of a millimetre at best
SHORTEST = 0.02  # [s] between kept poses of a moving brick, once there are too many

Rows = NDArray[np.float64]
Marks = NDArray[np.bool_]


@dataclass
class KeyframeReduction:
    """The keyframes of one run. Poses come in order of time, any number of them at once."""

    most: int  # number of rows to keep
    _radii: list[float] = field(default_factory=list, init=False)  # by brick [m]
    _kept: list[Rows] = field(default_factory=list, init=False)
    _last: Rows = field(default_factory=lambda: np.empty((0, COLUMNS)), init=False)  # latest row of each brick
    _last_kept: Marks = field(default_factory=lambda: np.empty(0, bool), init=False)  # whether that row is in `_kept`
    _way: NDArray[np.float64] = field(default_factory=lambda: np.empty(0), init=False)  # of each since a kept pose [m]
    _apart: float = field(default=SHORTEST, init=False)  # time between kept poses of a moving brick [s]

    def add(self, radius: float) -> None:
        """Add a brick; `radius` is the distance of its farthest corner from its centre [m]."""
        self._radii.append(radius)

    def take(self, rows: Rows) -> None:
        """Keep the keyframes of these rows."""
        if not len(rows):
            return
        self._way = np.concatenate((self._way, np.zeros(len(self._radii) - len(self._way))))
        fresh = np.arange(len(self._last) + len(rows)) >= len(self._last)
        kept = np.concatenate((self._last_kept, np.zeros(len(rows), bool)))
        rows = np.concatenate((self._last, rows))
        order = np.argsort(rows[:, NUMBER], kind="stable")
        rows, fresh, kept = rows[order], fresh[order], kept[order]
        changed = ~_same(rows, (NUMBER, TIME, *range(COLUMNS)[POSE]))
        self._keep(rows[changed], fresh[changed], kept[changed])
        while sum(map(len, self._kept)) > self.most:
            self._apart *= 2.0
            self._kept = [_sparser(_sorted(np.concatenate(self._kept)), self._apart)]

    def keys(self) -> Rows:
        """Return all kept rows and the latest row of each brick; by brick, then by time."""
        return _sorted(np.concatenate((*self._kept, self._last[~self._last_kept])))

    def _keep(self, rows: Rows, fresh: Marks, kept: Marks) -> None:
        """Keep the keyframes of rows in order of brick; a first row of a brick that is not `fresh` was seen before."""
        first = ~_same(rows, (NUMBER,))
        last = np.concatenate((first[1:], [True]))
        numbers = rows[:, NUMBER].astype(int)
        way = np.where(first, self._way[numbers], _ways(rows, np.array(self._radii)[numbers]))
        total = np.cumsum(way)
        travelled = total - (total - way)[first][np.cumsum(first) - 1]  # by each brick
        passed = np.floor(travelled / NOTICED)
        due = np.where(first, fresh, np.concatenate(([False], passed[1:] > passed[:-1])))
        due |= np.concatenate((due[1:] & ~first[1:], [False]))
        self._kept.append(rows[due & ~kept])
        self._last, self._last_kept = rows[last], (due | kept)[last]
        self._way[numbers[last]] = np.fmod(travelled[last], NOTICED)


def _sorted(rows: Rows) -> Rows:
    return rows[np.lexsort((rows[:, TIME], rows[:, NUMBER]))]


def _same(rows: Rows, columns: tuple[int, ...]) -> Marks:
    """Mark rows that equal the row before in these columns."""
    columns_of = rows[:, columns]
    return np.concatenate(([False], (columns_of[1:] == columns_of[:-1]).all(axis=1)))


def _ways(rows: Rows, radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an upper bound of the path of the farthest corner since the row before, for each row [m]."""
    shift = np.linalg.norm(np.diff(rows[:, POSITION], axis=0), axis=1)
    q, p = rows[1:, ORIENTATION], rows[:-1, ORIENTATION]
    turn = 2.0 * np.minimum(np.linalg.norm(q - p, axis=1), np.linalg.norm(q + p, axis=1))
    return np.concatenate(([0.0], shift + radii[1:] * turn))


def _sparser(rows: Rows, apart: float) -> Rows:
    """Keep one row in every `apart` seconds of a motion; the first and last row of a rest are kept."""
    near = _same(rows, (NUMBER,)) & np.concatenate(([False], np.diff(rows[:, TIME]) < 2.0 * apart))
    inner = near & np.concatenate((near[1:], [False]))
    turn = np.floor(rows[:, TIME] / apart)
    return rows[~(inner & np.concatenate(([False], turn[1:] == turn[:-1])))]


# Interpolation between two recorded poses.
#
# A freely flying or turning brick follows a cubic through both poses with the recorded velocities at its ends: exactly
# in free fall, and to a micrometre if its acceleration changes slowly, as in a motion of closed form. If a brick was
# struck in between, its velocities do not fit its displacement; then the interpolation is linear.


# Share of the displacement, or [m] and [rad], by which the mean of both velocities may differ from it.
MISSED = 0.02
MISSED_AT_LEAST = 1e-5


def between(before: Rows, after: Rows, time: float) -> tuple[Array, Array]:
    """Return positions (n, 3) [m] and orientations (n, 4) at a time [s], clipped to the times of the rows."""
    span = after[:, TIME] - before[:, TIME]
    divisor = np.where(span > 0.0, span, 1.0)[:, None]
    part = np.where(span > 0.0, np.clip((time - before[:, TIME]) / divisor[:, 0], 0.0, 1.0), 0.0)[:, None]
    way = after[:, POSITION] - before[:, POSITION]
    turn = _vectors(_multiplied(after[:, ORIENTATION], before[:, ORIENTATION] * [-1.0, -1.0, -1.0, 1.0]))
    shifted = _interpolated(way, before[:, VELOCITY] * divisor, after[:, VELOCITY] * divisor, part)
    turned = _interpolated(turn, before[:, SPIN] * divisor, after[:, SPIN] * divisor, part)
    return before[:, POSITION] + shifted, _multiplied(_quaternions(turned), before[:, ORIENTATION])


def _interpolated(way: Array, first: Array, last: Array, part: Array) -> Array:
    """Return the displacement after a part of the time; `first` and `last` are velocities per whole time span."""
    off = np.linalg.norm(0.5 * (first + last) - way, axis=1)
    free = off <= np.maximum(MISSED * np.linalg.norm(way, axis=1), MISSED_AT_LEAST)
    squared, cubed = part**2, part**3
    cubic = (part - 2 * squared + cubed) * first + (3 * squared - 2 * cubed) * way + (cubed - squared) * last
    return np.where(free[:, None], cubic, part * way)


def _multiplied(q: Array, p: Array) -> Array:
    """Return the rotations q after p, each (n, 4)."""
    v, w, u, s = q[:, :3], q[:, 3:], p[:, :3], p[:, 3:]
    return np.hstack((w * u + s * v + np.cross(v, u), w * s - (v * u).sum(axis=1, keepdims=True)))


def _vectors(q: Array) -> Array:
    """Return the shorter rotations as axis times angle (n, 3) [rad]."""
    q = np.where(q[:, 3:] < 0.0, -q, q)
    length = np.linalg.norm(q[:, :3], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(length, q[:, 3:])
    return np.where(length > 0.0, angle / np.where(length > 0.0, length, 1.0), 2.0) * q[:, :3]


def _quaternions(vectors: Array) -> Array:
    """Return the rotations (n, 4) of axis times angle (n, 3) [rad]."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.hstack((0.5 * np.sinc(angle / (2.0 * np.pi)) * vectors, np.cos(0.5 * angle)))


# A recorded run as arrays: the pose of each brick at any time.


class Track(NamedTuple):
    """The recorded poses of one brick, in order of time."""

    times: Array  # (n,) [s]
    positions: Array  # (n, 3), of its centre of mass in W [m]
    orientations: Array  # (n, 4), from body axes to W, as x, y, z, w
    velocities: Array  # (n, 3), of its centre of mass in W [m/s]
    spins: Array  # (n, 3), angular velocity in W [rad/s]


class Poses(NamedTuple):
    """The poses of all bricks at one time; nan for a brick that is not yet placed or already removed."""

    positions: Array  # (bricks, 3) [m]
    orientations: Array  # (bricks, 4)


@dataclass(frozen=True)
class Recording:
    """The poses of bricks during a run: of moving bricks at every look of the runner, of others where they rest."""

    bricks: Sequence[Brick]  # in order of placement
    keys: Rows  # by brick, then by time
    removed_at: Array  # (bricks,), time at which each was removed [s]; inf if it stayed
    _numbers: dict[BodyId, int] = field(init=False, compare=False)
    _begins: NDArray[np.intp] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_numbers", {brick.id: number for number, brick in enumerate(self.bricks)})
        begins = np.searchsorted(self.keys[:, NUMBER], np.arange(len(self.bricks) + 1))
        object.__setattr__(self, "_begins", begins)

    @property
    def names(self) -> tuple[BodyId, ...]:
        """The names of the bricks, in order of placement."""
        return tuple(self._numbers)

    @property
    def times(self) -> Array:
        """All times with a recorded pose [s], each once."""
        return np.unique(self.keys[:, TIME])

    def track(self, brick: BodyId) -> Track:
        """Return the recorded poses of a brick. Raises LookupError if it was never placed."""
        if brick not in self._numbers:
            raise LookupError(f"no brick '{brick}' was placed in this run")
        number = self._numbers[brick]
        rows = self.keys[self._begins[number] : self._begins[number + 1]]
        return Track(rows[:, TIME], rows[:, POSITION], rows[:, ORIENTATION], rows[:, VELOCITY], rows[:, SPIN])

    def at(self, time: float) -> Poses:
        """Return the poses of all bricks at a time [s], in order of placement."""
        keys = self.keys
        after = np.array(
            [
                begin + np.searchsorted(keys[begin:end, TIME], time, side="right")
                for begin, end in zip(self._begins[:-1], self._begins[1:], strict=True)
            ],
            dtype=np.intp,
        )
        present = (after > self._begins[:-1]) & (time < self.removed_at)
        after = np.maximum(after, self._begins[:-1] + 1)
        last = np.minimum(after, self._begins[1:] - 1)
        positions, orientations = between(keys[after - 1], keys[last], time)
        positions[~present], orientations[~present] = np.nan, np.nan
        return Poses(positions, orientations)

    def save(self, file: Path | IO[bytes]) -> None:
        """Write the recording to a file of numpy arrays (.npz); docs/python-api.md lists them."""
        rows = self.keys
        corners = [np.array(brick.shape.corners) for brick in self.bricks]
        np.savez_compressed(
            file,
            names=np.array(self.names),
            masses=np.array([brick.mass for brick in self.bricks]),
            corners=np.concatenate(corners) if corners else np.empty((0, 3)),
            corner_counts=np.array([len(each) for each in corners], dtype=int),
            removed_at=self.removed_at,
            brick=rows[:, NUMBER].astype(int),
            time=rows[:, TIME],
            position=rows[:, POSITION],
            orientation=rows[:, ORIENTATION],
            velocity=rows[:, VELOCITY],
            spin=rows[:, SPIN],
        )


# Recorder of a run.
#
# The runner passes on the poses that it reads anyway, so recording needs no further query of the engine, and works for
# motions without an engine. Poses are packed at once, which is cheaper than keeping objects, and thinned in batches.


AT_A_TIME = 20_000  # poses in a batch; some megabytes
MOST_KEYS = 1_000_000  # kept poses; 120 MB
ROW: Final = Struct(f"{COLUMNS}d")


@dataclass
class Recorder:
    """Records one run. Pass it to `play`, then call `recording`."""

    most_keys: int = MOST_KEYS  # above, every other keyframe of a motion is dropped, repeatedly if needed
    _waiting: bytearray = field(default_factory=bytearray, init=False)  # packed rows
    _numbers: dict[BodyId, int] = field(default_factory=dict, init=False)  # in order of placement
    _bricks: list[Brick] = field(default_factory=list, init=False)
    _removed_at: dict[BodyId, float] = field(default_factory=dict, init=False)  # time at which each was removed [s]
    _thinning: KeyframeReduction = field(init=False)

    def __post_init__(self) -> None:
        self._thinning = KeyframeReduction(self.most_keys)

    def add(self, time: float, brick: Brick, state: BodyState) -> None:
        """Add a brick that is placed at a time [s]."""
        self._numbers[brick.id] = len(self._bricks)
        self._bricks.append(brick)
        self._thinning.add(brick.shape.bounding_radius)
        self.see(time, {brick.id: state})

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Record the states of bricks at a time [s], not earlier than any before."""
        pack, numbers = ROW.pack, self._numbers
        for name, s in states.items():
            pose = s.pose
            self._waiting += pack(
                numbers[name], time, *pose.position_W, *pose.orientation, *s.velocity_W, *s.angular_velocity_W
            )
        if len(self._waiting) >= AT_A_TIME * ROW.size:
            self._put_away()

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        """Record the removal of bricks at a time [s]."""
        self._removed_at |= dict.fromkeys(bricks, time)

    def recording(self) -> Recording:
        """Return the recording so far; it has the first and the latest pose of each brick."""
        self._put_away()
        removed_at = np.array([self._removed_at.get(brick.id, np.inf) for brick in self._bricks])
        return Recording(tuple(self._bricks), self._thinning.keys(), removed_at)

    def _put_away(self) -> None:
        table: NDArray[np.float64] = np.frombuffer(self._waiting).reshape(-1, COLUMNS)
        self._waiting = bytearray()
        self._thinning.take(table)
