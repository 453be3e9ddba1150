"""Remembers frozen bricks and their supports as they were left, to see what somebody else has done to them since."""

from collections.abc import Callable, Collection, Container, Iterable
from dataclasses import dataclass, field
from typing import Self

from stability.engines.protocol import Engine
from stability.model import BodyId, BodyState
from stability.watching.life_cycle import BrickObserver

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
