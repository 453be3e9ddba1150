"""Sees which bricks at rest are about to be hit, before the engine lets it happen.

A frozen brick has no mass for the engine, and takes all momentum out of what hits it. So what may give way has to be
woken before the hit, while the surfaces are still apart. Only the gap between solids and the speed of its closing are
looked at; bricks in contact press on each other, and do not hit.
"""

from collections.abc import Callable, Collection, Container, Mapping
from dataclasses import dataclass, field
from math import hypot, inf, sqrt
from typing import Self

from stability.engines.protocol import Engine
from stability.geometry.box_distance import TOUCHING, Separation
from stability.geometry.placed_shape import apart
from stability.geometry.vectors import add_scaled, multiply, scale
from stability.model import BodyId, BodyState, ConvexShape, Pose, Vec3, convex
from stability.stabilizers.protocol import BrickObserver

# Shares of the smallest side of the flying brick.
# Bricks that are closer press on each other: what touches at rest, and a little more.
IN_TOUCH = 1.5 * TOUCHING
# A millimetre for a plank. A hit is told when the gap is no more than this beyond what the speed closes in time.
CLOSE = 0.125
AHEAD = 1.0  # how far around a brick others are looked for
GLANCE = 0.05  # of the time ahead, over which the speed of closing is taken
PART_WAY = 0.5  # of the smallest side: further on, a brick has passed through the other, and goes away from it
LONGEST_STEP = 1.0 / 240.0  # [s]; assumed until two looks have shown how long a step of the engine is
STEPS = 2.0  # how many steps ahead hits are told, since speeds may grow
MOST_GAPS = 8  # gaps through which a flight is followed; two boxes seldom have more than three
ROUNDING = 1e-9  # [m]


@dataclass(frozen=True, slots=True)
class Hit:
    """A brick that is about to hit another one."""

    by: BodyId
    brick: BodyId  # the one that is hit
    speed: float  # at which the gap closes [m/s]
    normal_W: Vec3  # unit, from the hitting brick towards the hit one


@dataclass(frozen=True, slots=True)
class _Solid:
    id: BodyId
    shape: ConvexShape
    state: BodyState


@dataclass(frozen=True, slots=True)
class _Near:
    solid: _Solid
    apart: Separation  # from the flying brick


@dataclass(frozen=True, slots=True)
class Attention:
    """How closely a brick that moves is looked at."""

    horizon: float  # [s] in which gravity alone brings nothing close
    least: float = 0.02  # [m/s] slower, nothing is a hit
    ahead: float = 0.0  # [s] how long before it happens a hit is told, if that is more than two steps


@dataclass
class Approaches(BrickObserver):
    """Follows the moving bricks of one engine. A brick that has nothing near is not looked at until it could have."""

    engine: Engine
    attention_of: Callable[[BodyId], Attention]
    gravity: float = 0.0  # [m/s2]: what a step of free fall gives a brick that the engine keeps bouncing is no hit
    _now: float | None = field(default=None, init=False)  # [s] of the last look
    _known: set[BodyId] = field(default_factory=set, init=False)  # bricks that were looked at before
    _look_at: dict[BodyId, float] = field(default_factory=dict, init=False)  # [s] when to look next

    def hits(self, moving: Mapping[BodyId, BodyState], still: Container[BodyId]) -> list[Hit]:
        """Who is about to hit one of the bricks `still`, at the latest in the next step of the engine."""
        now = self.engine.time()
        since = now - self._now if self._now is not None else LONGEST_STEP
        step = since if 0.0 < since < LONGEST_STEP else LONGEST_STEP  # time may have been skipped
        self._now = now
        found = []
        for brick, state in moving.items():
            if now < self._look_at.get(brick, now):
                continue
            attention = self.attention_of(brick)
            least = max(attention.least, STEPS * self.gravity * step)
            ahead = max(attention.ahead, STEPS * step)
            # What is in touch presses, and does not hit; unless it has only just come, and came fast.
            closer = IN_TOUCH if brick in self._known else -inf
            self._known.add(brick)
            shape = convex(self.engine.shape(brick))
            if shape is not None and (fastest := _fastest(state, shape)) > least:
                flying, thin = _Solid(brick, shape, state), shape.least_thickness
                around = max(AHEAD * thin, _close(thin, fastest, ahead))
                near = [n for n in self._near(flying, still, around) if n.apart.gap > closer * thin]
                free = min((other.apart.gap for other in near), default=AHEAD * thin)
                # Half the way, for whatever makes it faster meanwhile.
                rest = 0.5 * max(0.0, free - _close(thin, fastest, ahead)) / fastest
                self._look_at[brick] = now + min(attention.horizon, rest)
                hits = (_hit(flying, other, ahead) for other in near)
                found += [hit for hit in hits if hit is not None and hit.speed > least]
        return found

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What does not move hits nothing."""
        for brick in bricks:
            self._look_at.pop(brick, None)
            self._known.discard(brick)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone hits nothing."""
        self.frozen(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._known |= other._known
        self._look_at |= other._look_at

    def _near(self, flying: _Solid, still: Container[BodyId], within: float) -> list["_Near"]:
        """The bricks `still` that are near."""
        if not still:
            return []
        others = [other for other in self.engine.neighbours(flying.id, within) if other in still]
        states, found = self.engine.states(others), []
        for other in others:
            shape = convex(self.engine.shape(other))
            if shape is not None:
                between = apart(flying.shape, flying.state.pose, shape, states[other].pose)
                found.append(_Near(_Solid(other, shape, states[other]), between))
        return found


def _close(thickness: float, speed: float, ahead: float) -> float:
    """How near a brick of this least thickness [m] and speed must be to be about to hit [m]."""
    return CLOSE * thickness + ahead * speed


def _hit(flying: _Solid, other: _Near, within: float) -> Hit | None:
    """Follow a flight from gap to gap: while one direction closes, another may keep the bricks apart, and for good."""
    between, ahead = other.apart, 0.0  # [s]
    glance = min(GLANCE * within, PART_WAY * flying.shape.least_thickness / _fastest(flying.state, flying.shape))
    for _ in range(MOST_GAPS):
        speed = (between.gap - _apart(flying, other.solid, ahead + glance).gap) / glance
        close = CLOSE * flying.shape.least_thickness
        if speed <= 0.0 or between.gap >= close + (within - ahead) * speed:
            return None
        if between.gap <= close + ROUNDING:
            return Hit(flying.id, other.solid.id, speed, scale(-1.0, between.normal_BA_W))
        ahead += (between.gap - close) / speed
        between = _apart(flying, other.solid, ahead)
    return Hit(flying.id, other.solid.id, speed, scale(-1.0, between.normal_BA_W))


def _apart(flying: _Solid, other: _Solid, ahead: float) -> Separation:
    """The separation of two bricks when the one has flown and turned on for a while [s]."""
    pose, half_turn = flying.state.pose, scale(0.5 * ahead, flying.state.angular_velocity_W)
    turn = multiply((*half_turn, 1.0), pose.orientation)
    size = sqrt(sum(part * part for part in turn))
    x, y, z, w = (part / size for part in turn)
    then = Pose(add_scaled(pose.position_W, ahead, flying.state.velocity_W), (x, y, z, w))
    return apart(flying.shape, then, other.shape, other.state.pose)


def _fastest(state: BodyState, shape: ConvexShape) -> float:
    """A bound on the speed of all points of a brick [m/s]."""
    return hypot(*state.velocity_W) + _turning_speed(state, shape)


def _turning_speed(state: BodyState, shape: ConvexShape) -> float:
    """A bound on how fast points of a brick move about its centre [m/s]."""
    return shape.bounding_radius * hypot(*state.angular_velocity_W)
