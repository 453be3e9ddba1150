"""Poses of all bricks in many samples of one design, with placement errors that accumulate over the height.

The target of a unit follows its supports: it is shifted and turned with them, and on several supports it is the mean of
their targets. The unit's own error is added, so errors add up over the height, as for a person who aligns each brick
with the one below. The unit is lowered until it touches. If it would overlap a brick beside it, its error is drawn
again, as a person would feel the brick and try again.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from scipy.special import ndtri

from stability.analysis.sampled_columns import FlatSamples, Mask, SampledRectangle, disc_overlap, outlines_overlap
from stability.geometry.box_distance import LIMIT_ITSELF, reach_between
from stability.geometry.placed_shape import above_plane, bodies_apart, in_place, meeting
from stability.geometry.rows import Array
from stability.geometry.vectors import multiply, rotate
from stability.model import IDENTITY, Pose
from stability.problem import Placed
from stackdsl.sampling.samples import BuildPlan, DesignedBrick, Draws, Unit
from stackdsl.timeline import ErrorSpread

DIGITS: Final = 12  # of positions [m] and angles [rad]: rounding removes differences between processors
HALF_DIGITS: Final = 15  # of sine and cosine
ATTEMPTS: Final = 50  # to set down a unit beside others
FORGIVEN: Final = 1e-4  # [m] permitted overlap of bricks; less, if such an overlap is too deep for a contact


@dataclass
class PlacementSampler:
    """Poses of all bricks in a batch of samples: arrays (bricks, samples), in the frame of the scene."""

    design: BuildPlan
    draws: Draws
    x: Array = field(init=False)  # of the centre of mass [m]
    y: Array = field(init=False)
    turn: Array = field(init=False)  # yaw relative to the design [rad]
    lift: Array = field(init=False)  # height relative to the design [m]
    fits: Mask = field(init=False)  # (samples,), whether every unit has free space
    _reached: list[float] = field(default_factory=list)  # by brick: largest horizontal distance from the design [m]
    _spans: list[tuple[float, float]] = field(default_factory=list)  # by brick: lowest and highest point [m]

    def __post_init__(self) -> None:
        shape = (len(self.design.parts), self.count)
        self.x, self.y, self.turn, self.lift = (np.zeros(shape) for _ in range(4))
        self.fits = np.ones(self.count, dtype=bool)

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.draws.count

    def build(self) -> "PlacementSampler":
        """Set down all units, one after the other; return this sampler."""
        for moment in self.design.moments:
            for unit in moment.units:
                self._set_down(unit)
        return self

    # --- placement of a unit ------------------------------------------------------------------------------------------

    def _set_down(self, unit: Unit) -> None:
        target = self._target(unit)
        self._put(unit, target, attempt=0, where=np.ones(self.count, dtype=bool))
        crowded = self._crowded(unit)
        for attempt in range(1, ATTEMPTS):
            if unit.jitter is None or not crowded.any():
                break
            self._put(unit, target, attempt, crowded)
            crowded &= self._crowded(unit)
        self.fits &= ~crowded

    def _target(self, unit: Unit) -> Array:
        """Return the target of a unit: x and y of its centre [m], and yaw [rad]; shape (3, samples)."""
        x, y = unit.centre
        places = [np.broadcast_to(np.array([[x], [y], [0.0]]), (3, self.count))] if unit.grounded else []
        for number in unit.supports:
            px, py, _ = self.design.parts[number].placed.pose.position_W
            cos, sin = np.cos(self.turn[number]), np.sin(self.turn[number])
            dx, dy = x - px, y - py
            at = (self.x[number] + cos * dx - sin * dy, self.y[number] + sin * dx + cos * dy, self.turn[number])
            places.append(np.stack(at))
        middle: Array = np.add.reduce(places) / len(places)
        return middle

    def _put(self, unit: Unit, target: Array, attempt: int, where: Mask) -> None:
        """Put a unit at its target plus its error in the samples of a mask, and lower it unless joints hold it."""
        jitter, (x, y) = unit.jitter, unit.centre
        place = target
        if jitter is not None:
            drawn = self.draws.uniform(unit.parts[0].name, attempt)
            place = target + np.stack(
                [_error(jitter.position, drawn[0]), _error(jitter.position, drawn[1]), _error(jitter.yaw, drawn[2])]
            )
        turn = np.round(place[2], DIGITS)
        cos, sin = np.cos(turn), np.sin(turn)
        for part in unit.parts:
            px, py, _ = part.placed.pose.position_W
            rows = (place[0] + cos * (px - x) - sin * (py - y), place[1] + sin * (px - x) + cos * (py - y))
            self.x[part.number][where] = np.round(rows[0], DIGITS)[where]
            self.y[part.number][where] = np.round(rows[1], DIGITS)[where]
            self.turn[part.number][where] = turn[where]
            self.lift[part.number][where] = 0.0
            off = np.hypot(self.x[part.number] - px, self.y[part.number] - py).max()
            del self._reached[part.number :]
            self._reached.append(float(off))
        hangs = bool(self.design.joints.rules) and not any(part.rests_on for part in unit.parts)
        lift = np.zeros(self.count) if hangs else np.maximum.reduce([self._lift(part, unit) for part in unit.parts])
        for part in unit.parts:
            rows = self.lift[part.number]
            rows[where] = lift[where]
            del self._spans[part.number :]
            self._spans.append((part.low + float(rows.min()), part.high + float(rows.max())))

    # --- heights ------------------------------------------------------------------------------------------------------

    def _lift(self, part: DesignedBrick, unit: Unit) -> Array:
        """Return the height at which a brick touches a support, relative to the design [m]."""
        lift = np.full(self.count, -part.low)  # down to the ground
        below = [other for other in self._near(part, unit) if other.high <= part.low + part.reach(other)]
        for other in sorted(below, key=lambda each: (-self._spans[each.number][1], each.number)):
            if (lift + part.low > self._spans[other.number][1]).all():
                break
            lift = np.maximum(lift, self._lift_on(part, other))
        return lift

    def _lift_on(self, part: DesignedBrick, other: DesignedBrick) -> Array:
        depth = self._depth(part, other)
        if depth is not None:
            return np.where(depth > 0.0, other.high + self.lift[other.number] - part.low, -np.inf)
        lifts = np.full(self.count, -np.inf)
        for sample in range(self.count):
            under = in_place(other.placed.brick.shape, self.pose(other, sample))
            high = max(0.0, other.high + float(self.lift[other.number, sample]) - part.low) + part.high - part.low
            pose = self.pose(part, sample)
            x, y, z = pose.position_W
            above = in_place(part.placed.brick.shape, Pose((x, y, z + high), pose.orientation))
            met = meeting(above, under, (0.0, 0.0, -1.0), 0.0)
            if met is not None:
                lifts[sample] = high - met[0]
        return lifts

    def touching(self, part: DesignedBrick) -> Iterator[tuple[DesignedBrick, Mask]]:
        """Yield the supports of a brick that lies flat, with the samples in which they touch; without the ground."""
        bottom = part.low + self.lift[part.number]
        for other in self._near(part, None):
            reach = part.reach(other)
            least, most = self._spans[part.number][0], float(bottom.max())
            if other.flat is None or self._spans[other.number][1] < least - reach or other.low > most + reach:
                continue
            gap = bottom - other.high - self.lift[other.number]
            near = (gap >= -reach) & self.design.is_bridged(gap, reach)
            over: Mask = near & (outlines_overlap(self._outline(part), self._outline(other)) > 0.0)
            if over.any():
                yield other, over

    def on_ground(self, part: DesignedBrick) -> Mask:
        """Return the samples in which a brick lies on the ground, as a mask."""
        return self.design.is_bridged(part.low + self.lift[part.number], reach_between(part.thickness))

    # --- overlaps -----------------------------------------------------------------------------------------------------

    def _crowded(self, unit: Unit) -> Mask:
        """Return the samples in which a unit overlaps a brick or a wall, as a mask."""
        crowded = np.zeros(self.count, dtype=bool)
        for part in unit.parts:
            for other in self._near(part, unit):
                crowded |= self._overlaps(part, other)
            for plane in self.design.planes[1:]:
                away = part.placed.pose.position_W
                nearest = sum((a - p) * n for a, p, n in zip(away, plane.point_W, plane.normal_W, strict=True))
                if nearest - part.placed.brick.shape.bounding_radius > self._reached[part.number]:
                    continue
                for sample in range(self.count):
                    body = in_place(part.placed.brick.shape, self.pose(part, sample))
                    crowded[sample] |= above_plane(body, plane).gap < -FORGIVEN
        return crowded

    def _overlaps(self, part: DesignedBrick, other: DesignedBrick) -> Mask:
        forgiven = min(LIMIT_ITSELF * FORGIVEN, part.reach(other))
        (least, most), (other_least, other_most) = self._spans[part.number], self._spans[other.number]
        if min(most - other_least, other_most - least) <= forgiven:
            return np.zeros(self.count, dtype=bool)
        low, high = part.low + self.lift[part.number], part.high + self.lift[part.number]
        other_low, other_high = other.low + self.lift[other.number], other.high + self.lift[other.number]
        level: Mask = np.minimum(high - other_low, other_high - low) > forgiven
        if not level.any():
            return level
        depth = self._depth(part, other)
        around = outlines_overlap(self._around(part), self._around(other)) if depth is None else depth
        deep: Mask = level & (around > forgiven)
        if depth is None:
            for sample in np.nonzero(deep)[0]:
                bodies = (in_place(each.placed.brick.shape, self.pose(each, int(sample))) for each in (part, other))
                deep[sample] = bodies_apart(*bodies).gap < -forgiven
        return deep

    def _near(self, part: DesignedBrick, unit: Unit | None) -> Iterator[DesignedBrick]:
        """Yield earlier bricks that may be below or beside a brick in some sample."""
        first = unit.parts[0].number if unit is not None else part.number
        x, y, _ = part.placed.pose.position_W
        for other in self.design.parts[:first]:
            ox, oy, _ = other.placed.pose.position_W
            reach = part.radius + other.radius + self._reached[part.number] + self._reached[other.number]
            if (x - ox) ** 2 + (y - oy) ** 2 <= reach**2:
                yield other

    # --- poses --------------------------------------------------------------------------------------------------------

    def _depth(self, part: DesignedBrick, other: DesignedBrick) -> Array | None:
        """Return the depth of the overlap of two outlines in plan [m]; None unless both bricks have upright sides."""
        if part.flat is not None and other.flat is not None:
            return outlines_overlap(self._outline(part), self._outline(other))
        if part.disc is None or other.disc is None:
            round_brick, block = (other, part) if part.disc is None else (part, other)
            if round_brick.disc is None or block.flat is None:
                return None
            return disc_overlap(round_brick.disc, self._at(round_brick), self._outline(block))
        (x, y), (other_x, other_y) = self._at(part), self._at(other)
        depth: Array = part.disc + other.disc - np.hypot(x - other_x, y - other_y)
        return depth

    def _at(self, part: DesignedBrick) -> tuple[Array, Array]:
        return self.x[part.number], self.y[part.number]

    def _outline(self, part: DesignedBrick) -> SampledRectangle:
        assert part.flat is not None
        ux, uy, one, two = part.flat
        n = part.number
        cos, sin = np.cos(self.turn[n]), np.sin(self.turn[n])
        return SampledRectangle((one, two), self.x[n], self.y[n], ux * cos - uy * sin, uy * cos + ux * sin)

    def _around(self, part: DesignedBrick) -> SampledRectangle:
        """Return the outline of a brick in plan, or a bounding square."""
        if part.flat is not None:
            return self._outline(part)
        n, one = part.number, np.ones(self.count)
        return SampledRectangle((part.radius, part.radius), self.x[n], self.y[n], one, 0.0 * one)

    def pose(self, part: DesignedBrick, sample: int) -> Pose:
        """Return the pose of a brick in a sample, in the frame of the scene."""
        x, y, lift, turn = (float(rows[part.number, sample]) for rows in (self.x, self.y, self.lift, self.turn))
        half = 0.5 * turn
        yaw = (0.0, 0.0, round(float(np.sin(half)), HALF_DIGITS), round(float(np.cos(half)), HALF_DIGITS))
        designed = part.placed.pose
        return Pose((x, y, designed.position_W[2] + lift), multiply(yaw, designed.orientation))

    def placed(self, sample: int) -> list[Placed]:
        """Return all bricks of a sample, in W, in order of placement."""
        poses = [self.pose(part, sample) for part in self.design.parts]
        if self.design.tilt != IDENTITY:
            tilt = self.design.tilt
            poses = [Pose(rotate(tilt, p.position_W), multiply(tilt, p.orientation)) for p in poses]
        return [Placed(part.placed.brick, pose) for part, pose in zip(self.design.parts, poses, strict=True)]

    def flat(self) -> FlatSamples:
        """Return the outlines of all bricks in plan; only if all lie flat."""
        outlines = [self._outline(part) for part in self.design.parts]
        cos, sin = np.stack([o.cos for o in outlines]), np.stack([o.sin for o in outlines])
        return FlatSamples([o.half for o in outlines], self.x, self.y, cos, sin)


def _error(spread: ErrorSpread | None, drawn: Array) -> Array:
    if spread is None:
        return np.zeros_like(drawn)
    error: Array = spread.width * (ndtri(drawn) if spread.kind == "normal" else 2.0 * drawn - 1.0)
    return np.round(error, DIGITS)
