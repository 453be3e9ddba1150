"""Keeps of many poses those that are needed to know all of them: what is at rest needs one where it begins to rest.

A pose is kept when a brick has moved by a hundredth of a millimetre, as far as its farthest corner goes, since the last
that was kept, counted along its way; so what creeps is not missed. The pose just before is kept as well: until then,
the brick was there.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

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
