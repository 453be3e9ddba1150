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
from stability.contacts.detection import contacts_between, contacts_with_plane
from stability.geometry.box_distance import reach_between
from stability.geometry.rows import Array
from stability.model import BodyId, Plane
from stability.problem import Contact, Placed, Problem, Tolerances, Wrench
from stability.statics.proof import check_motion
from stability.statics.tipping import Fall, tipping

# Proves that a part of a sample tips as one body, if no forces were found.


@dataclass(frozen=True, slots=True)
class SampleSite:
    """Fixed bodies, friction and gravity of sampled bricks."""

    planes: Sequence[Plane]
    friction: GivenFriction  # between bricks
    gravity: float  # [m/s2]
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen


def falls_as_one(moving: Sequence[Placed], rest: Sequence[Placed], site: SampleSite) -> Fall | None:
    """Return the fall of some bricks as one body while all other bricks are fixed, checked by arithmetic."""
    bricks: Mapping[BodyId, Placed] = {placed.brick.id: placed for placed in moving}
    border = _between(moving, rest, site)
    for placed in moving:
        own, name = solid(placed), placed.brick.id
        for plane in site.planes:
            border += contacts_with_plane(own, plane, site.tolerances, as_friction(site.friction).on(name, plane))
    fall = tipping(bricks, border)
    if fall is None:
        return None
    loads = {name: Wrench((0.0, 0.0, -placed.brick.mass * site.gravity)) for name, placed in bricks.items()}
    # A rigid group has no relative motion inside, so contacts between its bricks do not matter.
    return fall if check_motion(Problem(bricks, border, loads), fall.motion, site.tolerances).holds else None


def _between(moving: Sequence[Placed], rest: Sequence[Placed], site: SampleSite) -> list[Contact]:
    """Return the contacts between moving and resting bodies."""
    if not rest:
        return []
    reach = reach_between(max(p.brick.shape.least_thickness for p in (*moving, *rest)), share=site.tolerances.gap)
    places = [np.array([(*p.pose.position_W, p.brick.shape.bounding_radius) for p in part]) for part in (moving, rest)]
    away = places[0][:, None, :3] - places[1][None, :, :3]
    limit = places[0][:, None, 3] + places[1][None, :, 3] + reach
    contacts: list[Contact] = []
    for one, other in zip(*np.nonzero((away**2).sum(axis=2) <= limit**2), strict=True):
        friction = as_friction(site.friction).of(moving[one].brick.id, rest[other].brick.id)
        contacts += contacts_between(solid(moving[one]), solid(rest[other]), friction, site.tolerances)
    return contacts


# Bricks that lie flat, in many samples of one design at once: their places and overlaps in plan.
#
# A box lies flat if one of its axes is vertical. In plan it is a rotated rectangle, and everything here is plan
# geometry. Arrays have one row per brick and one column per sample, so that a query for one brick covers all samples.


Mask: TypeAlias = NDArray[np.bool_]

SQUARE = sqrt(0.5)  # cosine of the angle from which the other side of a rectangle is nearer
THIN = 0.01  # share of the smallest half length: a patch has at least this thickness


@dataclass(slots=True)
class FlatSamples:
    """Boxes in many samples: one row per brick, one column per sample."""

    half: Sequence[tuple[float, float]]  # half lengths, by brick [m]
    x: Array  # of the centre, in plan [m]
    y: Array
    cos: Array  # of the rotation from +x to the first horizontal axis
    sin: Array

    def inside(self, bricks: Sequence[int], x: Array, y: Array) -> Mask:
        """Return whether points in plan lie within the outlines of bricks or on their borders, one row per brick."""
        rows = list(bricks)
        dx, dy, cos, sin = x - self.x[rows], y - self.y[rows], self.cos[rows], self.sin[rows]
        half = np.array([self.half[brick] for brick in rows]).reshape(-1, 2)
        return (np.abs(dx * cos + dy * sin) <= half[:, :1]) & (np.abs(dy * cos - dx * sin) <= half[:, 1:])

    def patch(self, upper: int, lower: int) -> tuple[Array, Array, Array]:
        """Return the centre of the overlap of two outlines and the mean square distance of its points per axis [m, m2].

        The centre is relative to the upper outline, along its axes. Results are exact if the sides are parallel. A
        negative `lower` has no outline: the overlap is the whole upper outline.
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
    """Rectangle in plan, in every sample."""

    half: tuple[float, float]
    x: Array
    y: Array
    cos: Array
    sin: Array


def outlines_overlap(a: SampledRectangle, b: SampledRectangle) -> Array:
    """Return the depth of the overlap of two rectangles along the axis where it is least [m]; negative if apart."""
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


def disc_overlap(radius: float, centre: tuple[Array, Array], b: SampledRectangle) -> Array:
    """Return the depth of the overlap of a disc and a rectangle [m]; negative if apart."""
    dx, dy = centre[0] - b.x, centre[1] - b.y
    along = np.abs(dx * b.cos + dy * b.sin) - b.half[0]
    across = np.abs(dy * b.cos - dx * b.sin) - b.half[1]
    outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
    depth: Array = radius - outside - np.minimum(np.maximum(along, across), 0.0)
    return depth


# Vertical forces passed down in many samples at once and checked by arithmetic: one proof per sample.
#
# Between flat bricks a vertical force may act at any point of both outlines. Each brick passes its load to the bricks
# below by a pressure that is linear over their patches: a linear map that depends on the places of these bricks, but
# not on the bricks above. So a new brick adds to the forces below it and does not change the maps. The shares of a load
# are only a proposal: one linear solve per brick and sample. A sample is proven if its forces balance each of its
# bricks, are all compressive, and act within their contacts. Other samples stay undecided.


# Accepted residual of a brick's balance, relative to its load and half diagonal: a tenth of the tolerance of proofs of
# statics.
BALANCED = 1e-12
GROUND = -1  # number of the ground below all bricks


@dataclass(frozen=True, slots=True)
class Support:
    """Possible support of a brick: another brick or the ground."""

    upper: int
    lower: int  # brick number, or GROUND
    touches: Mask  # by sample, whether the brick rests on it


@dataclass(slots=True)
class SampledForces:
    """Forces of many samples while bricks are added, each after its supports: bricks are numbered in this order.

    A force is its size [N] and its moments about the origin of the plan [N m], as rows; one column per sample.
    """

    samples: FlatSamples
    weights: Sequence[float]  # by brick [N]
    supports: Sequence[Sequence[Support]]  # by brick
    carried: Mask = field(init=False)  # by sample, whether every brick so far has a support
    _maps: dict[int, list[Array]] = field(default_factory=dict)
    _forces: dict[tuple[int, int], Array] = field(default_factory=dict)  # by upper brick and number of the support
    _off: dict[int, Array] = field(default_factory=dict)  # by brick: the residual, passed load minus own load [N]
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
        """Return by sample the highest brick whose forces are no proof; -1 if all forces are.

        Only forces that changed since the last call are checked.
        """
        keys = sorted(self._changed)
        self._changed.clear()
        highest = np.full(self.carried.shape, GROUND)
        if not keys:
            return highest
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
        for row, upper in enumerate(uppers):  # in ascending order, so that the highest number is stored last
            highest[~good[row]] = upper
        return highest

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
        """Return (samples, 3, 3) per support: the map from a load about the brick's centre to the support's share."""
        scale, cos, sin = hypot(*self.samples.half[brick]), self.samples.cos[brick], self.samples.sin[brick]
        moments = []
        for support in self.supports[brick]:
            along, across, square = self.samples.patch(brick, support.lower)
            x, y, spread = (along * cos - across * sin) / scale, (along * sin + across * cos) / scale, square / scale**2
            one = np.ones_like(x)
            rows = [[one, x, y], [x, x * x + spread, x * y], [y, x * y, y * y + spread]]
            moments.append(np.where(support.touches, np.array(rows), 0.0).transpose(2, 0, 1))
        total = np.add.reduce(moments)
        total[~self.carried] = np.eye(3)  # without a support there is nothing to share
        inverse = np.linalg.inv(total)
        return [moment @ inverse for moment in moments]
