"""Shaking ground: bricks stay frozen as long as the ground acceleration is within their proven range.

The accelerations that a structure withstands form a convex set around 0 (`analysis/acceleration_margin.py`), so a proof
in both directions covers all accelerations between. Outside of the proven range all connected bricks wake, because a
brick that slides on top changes the load of those below. They are judged again when all of them are at rest. Frozen
bricks move with the ground, and states are relative to it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, pi
from typing import NamedTuple

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import Engine
from stability.geometry.vectors import scale
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
    bounds: Bounds
    until: float  # time at which the acceleration leaves the range [s]; inf if it does not

    @property
    def reason(self) -> str:
        """Reason for waking the bricks at that time."""
        least, most = self.bounds
        return f"ground acceleration outside the proven range, {least:.3g} to {most:.3g} m/s2"


def proven_range(assembly: Assembly, bricks: frozenset[BodyId], motion: GroundMotion) -> Bounds:
    """Prove the range of ground accelerations that connected bricks, proven to stand, withstand along a motion."""
    from stability.analysis.acceleration_cut import heading, shaken, weights_of  # noqa: PLC0415 -- slow to import
    from stability.analysis.joined_acceleration import joined_along  # noqa: PLC0415 -- likewise

    problem = assembly.problem(bricks)
    along = atan2(motion.direction_W[1], motion.direction_W[0])
    if problem.has_joints:
        weights, tolerances = weights_of(problem, assembly.gravity), rounded(problem, Tolerances())
        ends = [joined_along(problem, weights, angle, tolerances)[0] for angle in (along, along + pi)]
        return Bounds(-assembly.gravity * ends[0], assembly.gravity * ends[1])
    case = shaken(problem, assembly.gravity, Tolerances())
    if case is None:
        return Bounds(0.0, 0.0)
    # The inertial acceleration is opposite to that of the ground.
    least, most = (assembly.gravity * heading(case, angle).reach for angle in (along, along + pi))
    return Bounds(-least, most)


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
        since = max(0.0, self.engine.time() - self._motion.begins)
        return scale(self._motion.course.acceleration(since), self._motion.direction_W)

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
    bounds = proven_range(assembly, bricks, motion)
    return HeldPart(bricks, bounds, motion.leaves(*bounds, since=now))
