"""Proves many samples of one design at once, by upright forces in flat stacks and by tipping of rigid parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from math import hypot, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.contact_law import GivenFriction, as_friction
from stability.contacts.bodies import solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.geometry.box_distance import reach_between
from stability.geometry.rows import Array
from stability.model import BodyId, Plane
from stability.problem import Contact, Placed, Problem, Tolerances, Wrench
from stability.statics.proof import check_motion
from stability.statics.tipping import Fall, tipping

# Proves that a part of a sample tips as one body, where no forces were found.


@dataclass(frozen=True, slots=True)
class SampleSite:
    """Ground, friction and gravity of sampled bricks."""

    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen


def falls_as_one(moving: Sequence[Placed], rest: Sequence[Placed], site: SampleSite) -> Fall | None:
    """The fall of some bricks as one body while all the rest stays where it is, checked by arithmetic."""
    bricks: Mapping[BodyId, Placed] = {placed.brick.id: placed for placed in moving}
    border = _between(moving, rest, site)
    for placed in moving:
        own, name = solid(placed), placed.brick.id
        found = [
            contact_with_plane(own, p, site.tolerances, as_friction(site.friction).on(name, p)) for p in site.planes
        ]
        border += [contact for contact in found if contact is not None]
    fall = tipping(bricks, border)
    if fall is None:
        return None
    loads = {name: Wrench((0.0, 0.0, -placed.brick.mass * site.gravity)) for name, placed in bricks.items()}
    # What moves as one body does not move in itself, so contacts between its bricks have nothing to say.
    return fall if check_motion(Problem(bricks, border, loads), fall.motion, site.tolerances).holds else None


def _between(moving: Sequence[Placed], rest: Sequence[Placed], site: SampleSite) -> list[Contact]:
    """Return the contacts between moving and resting bodies."""
    if not rest:
        return []
    reach = reach_between(max(p.brick.shape.least_thickness for p in (*moving, *rest)), share=site.tolerances.gap)
    places = [np.array([(*p.pose.position_W, p.brick.shape.bounding_radius) for p in part]) for part in (moving, rest)]
    away = places[0][:, None, :3] - places[1][None, :, :3]
    limit = places[0][:, None, 3] + places[1][None, :, 3] + reach
    found = []
    for one, other in zip(*np.nonzero((away**2).sum(axis=2) <= limit**2), strict=True):
        friction = as_friction(site.friction).of(moving[one].brick.id, rest[other].brick.id)
        contact = contact_between(solid(moving[one]), solid(rest[other]), friction, site.tolerances)
        if contact is not None:
            found.append(contact)
    return found


# Bricks that lie flat, in many samples of one design at once: where each lies, and whether two overlap in plan.
#
# A box lies flat if one of its axes is upright. In plan it is a rectangle, turned; everything here is plan geometry,
# and arrays have a row a brick and a column a sample, so that what is asked of one brick is asked of all samples
# together.


Mask: TypeAlias = NDArray[np.bool_]

SQUARE = sqrt(0.5)  # cosine of the angle from which the other side of a rectangle is the nearer one
THIN = 0.01  # of the least half length: a patch is not taken to be thinner


@dataclass(slots=True)
class FlatSamples:
    """Boxes in many samples; a row a brick, a column a sample."""

    half: Sequence[tuple[float, float]]  # by brick [m]
    x: Array  # of the centre, in plan [m]
    y: Array
    cos: Array  # of the turn from +x to the first level axis
    sin: Array

    def inside(self, bricks: Sequence[int], x: Array, y: Array) -> Mask:
        """Whether points in plan, a row a brick, lie within the outlines of these bricks, borders included."""
        rows = list(bricks)
        dx, dy, cos, sin = x - self.x[rows], y - self.y[rows], self.cos[rows], self.sin[rows]
        half = np.array([self.half[brick] for brick in rows]).reshape(-1, 2)
        return (np.abs(dx * cos + dy * sin) <= half[:, :1]) & (np.abs(dy * cos - dx * sin) <= half[:, 1:])

    def patch(self, upper: int, lower: int) -> tuple[Array, Array, Array]:
        """About where two outlines overlap: its middle along the axes of the upper one, seen from there [m].

        And the mean square of how far its points are from there along an axis [m2]. Exact where their sides are
        parallel. If `lower` is negative, it has no outline, and all of the upper one is meant.
        """
        one, two = self.half[upper]
        none = np.zeros_like(self.x[upper])
        if lower < 0:
            return none, none, none + (one * one + two * two) / 6.0
        cos, sin = self.cos[upper], self.sin[upper]
        dx, dy = self.x[lower] - self.x[upper], self.y[lower] - self.y[upper]
        along, across = dx * cos + dy * sin, dy * cos - dx * sin
        alike = np.abs(cos * self.cos[lower] + sin * self.sin[lower]) >= SQUARE
        first, second = self.half[lower]
        low, high = _common(one, along, np.where(alike, first, second))
        left, right = _common(two, across, np.where(alike, second, first))
        square = ((high - low) ** 2 + (right - left) ** 2) / 24.0
        return 0.5 * (low + high), 0.5 * (left + right), np.maximum(square, (THIN * min(one, two)) ** 2)


def _common(half: float, middle: Array, other: Array) -> tuple[Array, Array]:
    """Return both ends of the intersection of two intervals, one of them centred at 0."""
    return np.maximum(-half, middle - other), np.minimum(half, middle + other)


@dataclass(frozen=True, slots=True, eq=False)
class SampledRectangle:
    """A rectangle in plan, in every sample."""

    half: tuple[float, float]
    x: Array
    y: Array
    cos: Array
    sin: Array


def outlines_overlap(a: SampledRectangle, b: SampledRectangle) -> Array:
    """How far two rectangles reach into each other along the axis along which that is least [m]; negative apart."""
    dx, dy = b.x - a.x, b.y - a.y
    turn_cos = np.abs(a.cos * b.cos + a.sin * b.sin)
    turn_sin = np.abs(a.cos * b.sin - a.sin * b.cos)
    depths = [
        a.half[0] + b.half[0] * turn_cos + b.half[1] * turn_sin - np.abs(dx * a.cos + dy * a.sin),
        a.half[1] + b.half[0] * turn_sin + b.half[1] * turn_cos - np.abs(dy * a.cos - dx * a.sin),
        b.half[0] + a.half[0] * turn_cos + a.half[1] * turn_sin - np.abs(dx * b.cos + dy * b.sin),
        b.half[1] + a.half[0] * turn_sin + a.half[1] * turn_cos - np.abs(dy * b.cos - dx * b.sin),
    ]
    least: Array = np.minimum.reduce(depths)
    return least


# Upright forces passed down in many samples at once, and checked by arithmetic: a proof of each sample by itself.
#
# Where bricks lie flat, a force between two of them may go upright through any point that lies in both outlines. Each
# brick hands what it carries to those below it by the pressure that is linear over their patches: a linear map that
# depends on where these bricks lie, and not on what comes on top of them. So a brick that is added changes the forces
# below it by a sum, and those of the bricks before it stay. How the load is shared is no more than a proposal: of each
# sample, one linear solve a brick. A sample counts as proven if its own forces balance each of its own bricks, if each
# of them presses, and if each goes through its own contact. Of any other, nothing is known.


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
        """Add a brick with its weight; its supports are present."""
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
        """Return the share of a load on each support of a brick."""
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
