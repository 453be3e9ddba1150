"""Detects changes that others make to frozen bricks, and the gravity of the engine."""

from collections.abc import Callable, Collection, Container, Iterable
from dataclasses import dataclass, field
from math import hypot, isclose
from typing import Self

from stability.engines.protocol import Engine, TellsGravity
from stability.geometry.vectors import admit_number
from stability.model import EARTH, BodyId, BodyState
from stability.stabilizers.protocol import BrickObserver

# Remembers frozen bricks and their supports as they were left, to see what somebody else has done to them since.


# [m], and of a quaternion's parts: engines make orientations unit again at every step, and move their last digit so.
ROUNDING = 1e-9


def _nothing(_brick: BodyId) -> Collection[BodyId]:
    return ()


@dataclass
class HeldBodies(BrickObserver):
    """The bodies of one engine that nobody is expected to move, push or take away."""

    engine: Engine
    supports: Callable[[BodyId], Iterable[BodyId]] = _nothing  # what is looked after as well while a brick is frozen
    _held: dict[BodyId, BodyState] = field(default_factory=dict, init=False)
    _seen: tuple[object, object] = field(default=(None, None), init=False)  # the engine's bodies, last time

    def came_or_went(self) -> bool:
        """Whether bodies have been added or removed since the last time that this was asked."""
        bricks, fixed = self.engine.masses(), self.engine.fixed()
        unchanged = self._seen[0] is bricks and self._seen[1] is fixed
        self._seen = (bricks, fixed)
        return not unchanged

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Remember bricks as they were just frozen, and those of their supports that are new."""
        for brick in bricks:
            new = [on for on in self.supports(brick) if on not in self._held]
            self._held |= self.engine.states([brick, *new])

    def woken(self, bricks: Collection[BodyId]) -> None:
        """What the engine moves is looked after no longer."""
        for brick in bricks:
            self._held.pop(brick, None)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """There is nothing left to look after."""
        self.woken(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._held |= other._held

    def released(self, frozen: Iterable[BodyId]) -> list[BodyId]:
        """The frozen bricks that the engine no longer holds: another body under the name, or given a mass."""
        return [brick for brick in frozen if not self.engine.holds(brick)]

    def lost(self, frozen: Collection[BodyId]) -> list[BodyId]:
        """The frozen bricks that the engine no longer has, or no longer holds."""
        gone = list[BodyId]()
        if self.came_or_went():
            bricks = self.engine.masses()
            gone = [brick for brick in frozen if brick not in bricks]
        return gone + self.released(brick for brick in frozen if brick not in gone)

    def disturbed(self, frozen: Container[BodyId]) -> dict[BodyId, BodyState]:
        """The frozen bricks and supports that were moved or pushed since the last look, as they are now."""
        if not self._held:
            return {}
        fixed = self.engine.fixed()
        present = [body for body in self._held if body in frozen or body in fixed]
        states = self.engine.states(present)
        changed = {body: states[body] for body in present if _differs(states[body], self._held[body])}
        self._held |= changed
        return changed


def _differs(now: BodyState, before: BodyState) -> bool:
    """Whether a body has been moved or pushed."""
    if (now.velocity_W, now.angular_velocity_W) != (before.velocity_W, before.angular_velocity_W):
        return True
    parts = (*now.pose.position_W, *now.pose.orientation)
    others = (*before.pose.position_W, *before.pose.orientation)
    return any(abs(part - other) > ROUNDING for part, other in zip(parts, others, strict=True))


# The gravity that a stabilizer uses: that of its engine, where the engine gives one.


SAME = 1e-6  # of the size of gravity: what an engine may round, and how far it may lean


def gravity_of(engine: Engine, given: float | None) -> float:
    """The gravity along -z to reckon with [m/s2]: that of the engine, or the one that is given.

    Of an engine that tells of none, or has none as its owner applies it otherwise, it is the given one, or EARTH.

    Raises ValueError where the engine has other gravity than is given, where it has none and none is given, and where
    its gravity leans. Raises TypeError for what is no engine.
    """
    if not callable(getattr(engine, "masses", None)):
        raise TypeError(f"expected an engine, such as PyBulletBodies(client), not {engine!r}")
    if given is not None:
        admit_number("the gravity is", given, "write m/s2, as a number that is more than 0")
    if not isinstance(engine, TellsGravity):
        return EARTH if given is None else given
    x, y, z = engine.gravity_W()
    if x == y == z == 0.0:
        if given is None:
            raise ValueError("the engine has no gravity: set it before (in PyBullet: p.setGravity(0, 0, -9.81))")
        return given
    if z >= 0.0 or hypot(x, y) > SAME * -z:
        raise ValueError(f"the engine's gravity is ({x:g}, {y:g}, {z:g}) m/s2: proofs are for gravity along -z alone")
    if given is not None and not isclose(given, -z, rel_tol=SAME):
        raise ValueError(f"gravity={given:g} is not that of the engine, {-z:g} m/s2: leave it out, or mend one of both")
    return -z
