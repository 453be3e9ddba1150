"""Prediction of hits on bricks at rest, before the engine simulates them.

A frozen brick has no mass in the engine and absorbs all momentum of a brick that hits it. So bricks that may yield must
wake before the hit, while the surfaces are still apart. The prediction uses only the gap between solids and its closing
speed; bricks in contact press on each other and do not hit.
"""

from collections.abc import Callable, Collection, Container, Mapping, Sequence
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
# Closer bricks are in contact: the gap of touching bricks at rest, plus a margin.
IN_TOUCH = 1.5 * TOUCHING
# A millimetre for a plank. A hit is predicted if the gap exceeds the closing distance by no more than this.
CLOSE = 0.125
AHEAD = 1.0  # search distance around a brick
GLANCE = 0.05  # share of the look-ahead time over which the closing speed is measured
PART_WAY = 0.5  # limit of the distance in that time, as a share of the smallest side: a brick must not pass through
LONGEST_STEP = 1.0 / 240.0  # [s] assumed engine step before the second check
STEPS = 2.0  # look-ahead in engine steps, as speeds may grow
MOST_GAPS = 8  # iterations along a flight; two boxes rarely need more than three
ROUNDING = 1e-9  # [m]


@dataclass(frozen=True, slots=True)
class Hit:
    """Imminent hit of one brick on another."""

    by: BodyId
    brick: BodyId  # the brick that is hit
    speed: float  # closing speed of the gap [m/s]
    normal_W: Vec3  # unit, from the hitting brick towards the hit one


IMMINENT = "would hit"  # in the reason of an update: its bricks wake before the hit, which may still miss them

OVERLOADED = "than its proof allows"  # in the reason of an update: its bricks wake under a load, and may not move


def carries_too_much(bricks: Sequence[BodyId]) -> str:
    """Return the reason why bricks wake under a load for which no proof is known."""
    return "; ".join(f"{brick} carries more {OVERLOADED}" for brick in bricks)


def about_to_hit(by: BodyId, brick: BodyId) -> str:
    """Return the reason why a brick wakes before a hit."""
    return f"{by} {IMMINENT} {brick}"


def as_hit(reason: str) -> str:
    """Return the reason in words for a time after the hit."""
    return reason.replace(IMMINENT, "hits")


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
class PredictionLimits:
    """Limits of the prediction for a moving brick."""

    horizon: float  # [s] longest time between checks; gravity alone brings no brick close within it
    least: float = 0.02  # [m/s] least speed of a hit
    ahead: float = 0.0  # [s] look-ahead time, if that is more than two steps


@dataclass
class HitPredictor(BrickObserver):
    """Predicts hits of the moving bricks of one engine; skips a brick without neighbours until it may have one."""

    engine: Engine
    attention_of: Callable[[BodyId], PredictionLimits]
    gravity: float = 0.0  # [m/s2] the speed from a step of free fall, as of a brick that bounces in place, is no hit
    _now: float | None = field(default=None, init=False)  # [s] time of the last check
    _known: set[BodyId] = field(default_factory=set, init=False)  # bricks that were checked before
    _look_at: dict[BodyId, float] = field(default_factory=dict, init=False)  # [s] time of the next check

    def hits(self, moving: Mapping[BodyId, BodyState], still: Container[BodyId]) -> list[Hit]:
        """Return the imminent hits on bricks in `still`, at least those of the next engine step."""
        now = self.engine.time()
        since = now - self._now if self._now is not None else LONGEST_STEP
        step = since if 0.0 < since < LONGEST_STEP else LONGEST_STEP  # the clock may have skipped time
        self._now = now
        imminent: list[Hit] = []
        for brick, state in moving.items():
            if now < self._look_at.get(brick, now):
                continue
            attention = self.attention_of(brick)
            least = max(attention.least, STEPS * self.gravity * step)
            ahead = max(attention.ahead, STEPS * step)
            # A brick in contact does not hit, unless it is new and fast.
            closer = IN_TOUCH if brick in self._known else -inf
            self._known.add(brick)
            shape = convex(self.engine.shape(brick))
            if shape is not None and (fastest := _fastest(state, shape)) > least:
                flying, thin = _Solid(brick, shape, state), shape.least_thickness
                around = max(AHEAD * thin, _close(thin, fastest, ahead))
                near = [n for n in self._near(flying, still, around) if n.apart.gap > closer * thin]
                free = min((other.apart.gap for other in near), default=AHEAD * thin)
                # Half the distance, as the brick may accelerate.
                rest = 0.5 * max(0.0, free - _close(thin, fastest, ahead)) / fastest
                self._look_at[brick] = now + min(attention.horizon, rest)
                hits = (_hit(flying, other, ahead) for other in near)
                imminent += [hit for hit in hits if hit is not None and hit.speed > least]
        return imminent

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Stop the checks of frozen bricks."""
        for brick in bricks:
            self._look_at.pop(brick, None)
            self._known.discard(brick)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Stop the checks of removed bricks."""
        self.frozen(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._known |= other._known
        self._look_at |= other._look_at

    def _near(self, flying: _Solid, still: Container[BodyId], within: float) -> list["_Near"]:
        """Return the bricks in `still` within a distance [m]."""
        if not still:
            return []
        others = [other for other in self.engine.neighbours(flying.id, within) if other in still]
        states, near = self.engine.states(others), []
        for other in others:
            shape = convex(self.engine.shape(other))
            if shape is not None:
                between = apart(flying.shape, flying.state.pose, shape, states[other].pose)
                near.append(_Near(_Solid(other, shape, states[other]), between))
        return near


def _close(thickness: float, speed: float, ahead: float) -> float:
    """Return the gap below which a brick of a thickness [m] and speed [m/s] is about to hit [m]."""
    return CLOSE * thickness + ahead * speed


def _hit(flying: _Solid, other: _Near, within: float) -> Hit | None:
    """Follow a flight by conservative steps: the separating direction may change, and the bricks may miss."""
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
    """Return the separation of two bricks after one has moved and turned for a time [s]."""
    pose, half_turn = flying.state.pose, scale(0.5 * ahead, flying.state.angular_velocity_W)
    turn = multiply((*half_turn, 1.0), pose.orientation)
    size = sqrt(sum(part * part for part in turn))
    x, y, z, w = (part / size for part in turn)
    pose_then = Pose(add_scaled(pose.position_W, ahead, flying.state.velocity_W), (x, y, z, w))
    return apart(flying.shape, pose_then, other.shape, other.state.pose)


def _fastest(state: BodyState, shape: ConvexShape) -> float:
    """Return an upper bound of the speed of a brick's points [m/s]."""
    return hypot(*state.velocity_W) + _turning_speed(state, shape)


def _turning_speed(state: BodyState, shape: ConvexShape) -> float:
    """Return an upper bound of the speed of a brick's points relative to its centre [m/s]."""
    return shape.bounding_radius * hypot(*state.angular_velocity_W)
