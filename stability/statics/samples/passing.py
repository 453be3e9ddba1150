"""Upright forces passed down in many samples at once, and checked by arithmetic: a proof of each sample by itself.

Where bricks lie flat, a force between two of them may go upright through any point that lies in both outlines. Each
brick hands what it carries to those below it by the pressure that is linear over their patches: a linear map that
depends on where these bricks lie, and not on what comes on top of them. So a brick that is added changes the forces
below it by a sum, and those of the bricks before it stay. How the load is shared is no more than a proposal: of each
sample, one linear solve a brick. A sample counts as proven if its own forces balance each
of its own bricks, if each of them presses, and if each goes through its own contact. Of any other, nothing is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from math import hypot

import numpy as np

from stability.statics.samples.flat_bricks import Array, FlatSamples, Mask

# What a brick hands down, less what it carries, relative to that and to half its diagonal: a tenth of what a proof of
# statics may be off.
BALANCED = 1e-12
GROUND = -1  # the number of what is below all bricks


@dataclass(frozen=True, slots=True)
class Support:
    """A brick may rest on another one, or on the ground."""

    upper: int
    lower: int  # or GROUND
    touches: Mask  # in which samples it truly rests there


@dataclass(slots=True)
class PassedDown:
    """The forces of many samples while bricks come, each after those that it rests on: bricks are numbered so.

    A force is its size [N] and its moments about the origin of the plan [N m], in rows; a column a sample.
    """

    samples: FlatSamples
    weights: Sequence[float]  # by brick [N]
    supports: Sequence[Sequence[Support]]  # by brick
    carried: Mask = field(init=False)  # in which samples every brick so far rests on something
    _maps: dict[int, list[Array]] = field(default_factory=dict)
    _forces: dict[tuple[int, int], Array] = field(default_factory=dict)  # by upper brick and number of the support
    _off: dict[int, Array] = field(default_factory=dict)  # by brick: what it handed down less what it carries [N]
    _changed: set[tuple[int, int]] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.carried = np.ones(self.samples.x.shape[1], dtype=bool)

    def add(self, brick: int) -> None:
        """Let a brick come, with its weight; what it rests on is there."""
        supports, samples = self.supports[brick], self.samples
        self.carried &= np.logical_or.reduce([s.touches for s in supports] or [np.zeros_like(self.carried)])
        if len(supports) > 1:
            self._maps[brick] = self._shares(brick)
        weight = np.full_like(samples.x[brick], self.weights[brick])
        loads = {brick: np.stack([weight, weight * samples.x[brick], weight * samples.y[brick]])}
        waiting = [-brick]
        while waiting:
            upper = -heappop(waiting)
            load = loads.pop(upper)
            for number, (support, part) in enumerate(zip(self.supports[upper], self._handed(upper, load), strict=True)):
                key = (upper, number)
                self._forces[key] = self._forces[key] + part if key in self._forces else part
                self._changed.add(key)
                if support.lower in loads:
                    loads[support.lower] = loads[support.lower] + part
                elif support.lower != GROUND:
                    loads[support.lower] = part
                    heappush(waiting, -support.lower)

    def astray(self) -> Array:
        """By sample, the highest brick whose forces are no proof; -1 if those of all are.

        Only forces that have changed since this was last asked are looked at.
        """
        keys = sorted(self._changed)
        self._changed.clear()
        found = np.full(self.carried.shape, GROUND)
        if not keys:
            return found
        forces = np.stack([self._forces[key] for key in keys])
        uppers, lowers = [key[0] for key in keys], [self.supports[upper][number].lower for upper, number in keys]
        size = forces[:, 0]
        presses = size > 0.0
        safe = np.where(presses, size, 1.0)
        x, y = forces[:, 1] / safe, forces[:, 2] / safe
        good = self.samples.inside(uppers, x, y)
        on_bricks = [row for row, lower in enumerate(lowers) if lower != GROUND]
        good[on_bricks] &= self.samples.inside([lowers[row] for row in on_bricks], x[on_bricks], y[on_bricks])
        good = np.where(presses, good, (forces == 0.0).all(axis=1))
        carried = np.zeros_like(self.samples.x)
        np.add.at(carried, uppers, size)
        for upper in sorted(self._off.keys() & set(uppers)):
            good[uppers.index(upper)] &= self._off[upper] <= BALANCED * carried[upper]
        for row, upper in enumerate(uppers):  # from the lowest number on, so that the highest stays
            found[~good[row]] = upper
        return found

    def _handed(self, upper: int, load: Array) -> list[Array]:
        """What a load on a brick comes to on each of its supports."""
        if len(self.supports[upper]) <= 1:
            return [load] * len(self.supports[upper])
        x, y, scale = self.samples.x[upper], self.samples.y[upper], hypot(*self.samples.half[upper])
        own = np.stack([load[0], (load[1] - load[0] * x) / scale, (load[2] - load[0] * y) / scale])
        parts = [np.einsum("sij,js->is", shares, own) for shares in self._maps[upper]]
        self._off[upper] = self._off.get(upper, 0.0) + np.abs(np.add.reduce(parts) - own).max(axis=0)
        return [np.stack([part[0], part[1] * scale + part[0] * x, part[2] * scale + part[0] * y]) for part in parts]

    def _shares(self, brick: int) -> list[Array]:
        """(samples, 3, 3) for each support: a load about the brick's own centre, to the part of it that goes there."""
        scale, cos, sin = hypot(*self.samples.half[brick]), self.samples.cos[brick], self.samples.sin[brick]
        moments = []
        for support in self.supports[brick]:
            along, across, square = self.samples.patch(brick, support.lower)
            x, y, spread = (along * cos - across * sin) / scale, (along * sin + across * cos) / scale, square / scale**2
            one = np.ones_like(x)
            rows = [[one, x, y], [x, x * x + spread, x * y], [y, x * y, y * y + spread]]
            moments.append(np.where(support.touches, np.array(rows), 0.0).transpose(2, 0, 1))
        total = np.add.reduce(moments)
        total[~self.carried] = np.eye(3)  # where nothing carries it, there is nothing to share
        inverse = np.linalg.inv(total)
        return [moment @ inverse for moment in moments]
