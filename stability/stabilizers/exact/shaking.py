"""Shaking ground: bricks stay frozen as long as the ground acceleration is within their proven range.

The accelerations that a structure withstands form a convex set around 0 (`analysis/acceleration_margin.py`), so a proof
in both directions covers all accelerations between. Outside of the proven range all connected bricks wake, because a
brick that slides on top changes the load of those below. They are judged again when all of them are at rest. Frozen
bricks move with the ground, and states are relative to it.

A ground that accelerates by a in the horizontal and by b upwards acts on dry bricks without loads as one that
accelerates by a g / (g + b) under g: their weights and inertial forces are in the same proportions, and contacts have
no strength of their own.
"""

from bisect import insort
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import atan2, hypot, pi, sin
from typing import NamedTuple

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import Engine
from stability.graph import components
from stability.model import AT_REST, BodyId, Vec3
from stability.problem import Placed, Tolerances, rounded
from stability.statics.assembly import Assembly

ROUNDING = 1e-9  # [s] of clocks, which are sums of steps


class Bounds(NamedTuple):
    """Proven range of ground accelerations along a line [m/s2]."""

    least: float
    most: float


class HeldPart(NamedTuple):
    """Connected frozen bricks with their proven range."""

    bricks: frozenset[BodyId]
    bounds: Bounds | None  # None if the ground moves along several lines
    until: float  # time at which the acceleration leaves the range [s]; inf if it does not

    @property
    def reason(self) -> str:
        """Reason for waking the bricks at that time."""
        if self.bounds is None:
            return "ground acceleration outside the proven range"
        least, most = self.bounds
        return f"ground acceleration outside the proven range, {least:.3g} to {most:.3g} m/s2"


def proven_range(assembly: Assembly, bricks: frozenset[BodyId], motion: GroundMotion) -> Bounds:
    """Prove the range of ground accelerations that connected bricks, proven to stand, withstand along a motion."""
    along = atan2(motion.direction_W[1], motion.direction_W[0])
    reach = _proven_reach(assembly, bricks)
    # The inertial acceleration is opposite to that of the ground.
    least, most = reach(along), reach(along + pi)
    return Bounds(-least, most)


def _proven_reach(assembly: Assembly, bricks: frozenset[BodyId]) -> Callable[[float], float]:
    """Return a function of the bearing of a horizontal pull [rad], the inertial acceleration that bricks withstand.

    The acceleration is proven [m/s2].
    """
    from stability.analysis.acceleration_cut import heading, shaken, weights_of  # noqa: PLC0415 -- slow to import
    from stability.analysis.joined_acceleration import joined_along  # noqa: PLC0415 -- likewise

    problem, gravity = assembly.problem(bricks), assembly.gravity
    if problem.has_joints:
        weights, tolerances = weights_of(problem, gravity), rounded(problem, Tolerances())
        return lambda bearing: gravity * joined_along(problem, weights, bearing, tolerances)[0]
    case = shaken(problem, gravity, Tolerances())
    return (lambda _: 0.0) if case is None else (lambda bearing: gravity * heading(case, bearing).reach)


FIRST_BEARINGS = 8
ROUNDING_OF_CHORDS = 1e-12


@dataclass
class ProvenPolygon:
    """Ground accelerations in all directions that connected bricks provably withstand, proven further where asked."""

    reach: Callable[[float], float]  # of the bearing of an inertial pull [rad]: the proven acceleration [m/s2]
    gravity: float  # [m/s2]
    only_weights: bool  # whether the bricks are dry and have no loads besides their weights
    _points: list[tuple[float, float]] = field(init=False)  # bearing in [0, 2 pi) and acceleration, by bearing

    def __post_init__(self) -> None:
        bearings = (2.0 * pi * number / FIRST_BEARINGS for number in range(FIRST_BEARINGS))
        self._points = [(bearing, self.reach(bearing)) for bearing in bearings]

    def holds(self, ground_W: Vec3) -> bool:
        """Return whether the bricks provably move with ground of an acceleration [m/s2]."""
        x, y, up = ground_W
        if up != 0.0:
            if not self.only_weights or self.gravity + up <= 0.0:
                return False
            x, y = (part * self.gravity / (self.gravity + up) for part in (x, y))
        bearing, size = atan2(-y, -x) % (2.0 * pi), hypot(x, y)
        if size <= self._chord(bearing):
            return True
        if any(known == bearing for known, _ in self._points):
            return False
        insort(self._points, (bearing, self.reach(bearing)))
        return size <= self._chord(bearing)

    def _chord(self, bearing: float) -> float:
        """Return the distance of the edge of the polygon along a bearing [m/s2]."""
        after = next((number for number, (other, _) in enumerate(self._points) if other > bearing), 0)
        (first, a), (second, b) = self._points[after - 1], self._points[after]
        if first == bearing:
            return a
        # The triangle of both points and the origin has the area a b sin(w) / 2, as do its two parts together.
        into, beyond = (bearing - first) % (2.0 * pi), (second - bearing) % (2.0 * pi)
        height = a * sin(into) + b * sin(beyond)
        return a * b * sin(into + beyond) / height if height > ROUNDING_OF_CHORDS else 0.0


@dataclass
class Shaking:
    """Motion of the ground, and the frozen bricks that provably move with it."""

    engine: Engine
    _motion: GroundMotion | None = field(default=None, init=False)
    _judged_bricks: Mapping[BodyId, Placed] = field(default_factory=dict, init=False)  # the bricks of `_parts`
    _parts: list[HeldPart] = field(default_factory=list, init=False)
    _shook: bool = field(default=False, init=False)  # whether the ground shook at the last call of `has_just_ended`

    def begin(self, motion: GroundMotion) -> None:
        """Set the motion of the ground."""
        self._motion, self._judged_bricks, self._parts = motion, {}, []

    @property
    def shakes(self) -> bool:
        """True while the ground shakes."""
        return self._motion is not None and self.engine.time() < self._motion.ends

    def acceleration_W(self) -> Vec3:
        """Return the acceleration of the ground now [m/s2]."""
        if self._motion is None or not self.shakes:
            return AT_REST
        return self._motion.at(self.engine.time())

    def has_just_ended(self) -> bool:
        """Return whether the ground has come to rest since the last call."""
        shook, self._shook = self._shook, self.shakes
        return shook and not self._shook

    def held_parts(self, assembly: Assembly) -> list[HeldPart]:
        """Return the connected parts of the frozen bricks with their proven ranges; none on ground at rest."""
        motion, now = self._motion, self.engine.time()
        if motion is None or not self.shakes:
            return []
        if self._judged_bricks != assembly.bricks:
            unchanged = {held.bricks: held for held in self._parts if self._is_unchanged(held, assembly)}

            def touching(brick: BodyId) -> set[BodyId]:
                return {body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper)}

            parts = map(frozenset, components(assembly.bricks, touching))
            self._parts = [unchanged.get(part) or _held_from(now, assembly, part, motion) for part in parts]
            self._judged_bricks = dict(assembly.bricks)
        return self._parts

    def _is_unchanged(self, held: HeldPart, assembly: Assembly) -> bool:
        bricks = assembly.bricks
        return all(brick in bricks and bricks[brick] is self._judged_bricks[brick] for brick in held.bricks)


def _held_from(now: float, assembly: Assembly, bricks: frozenset[BodyId], motion: GroundMotion) -> HeldPart:
    if not motion.beside:
        bounds = proven_range(assembly, bricks, motion)
        return HeldPart(bricks, bounds, motion.leaves(*bounds, since=now))
    only_weights = not assembly.problem(bricks).has_joints and not any(map(assembly.loads.on, bricks))
    polygon = ProvenPolygon(_proven_reach(assembly, bricks), assembly.gravity, only_weights)
    return HeldPart(bricks, None, motion.leaves_set(polygon.holds, since=now))
