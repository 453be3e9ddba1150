"""External changes to frozen bricks, and the gravity of the engine."""

from collections.abc import Callable, Collection, Container, Iterable
from dataclasses import dataclass, field
from math import hypot, isclose
from typing import Self

from stability.engines.protocol import Engine
from stability.geometry.vectors import admit_number
from stability.model import EARTH, BodyId, BodyState
from stability.stabilizers.protocol import BrickObserver

# States of frozen bricks and their supports, to detect changes by the caller.


# [m], and of a quaternion's components: engines normalise orientations at every step, which changes the last digit.
ROUNDING = 1e-9


def _nothing(_brick: BodyId) -> Collection[BodyId]:
    return ()


@dataclass
class HeldBodies(BrickObserver):
    """Frozen bricks of one engine and their supports, with their expected states."""

    engine: Engine
    supports: Callable[[BodyId], Iterable[BodyId]] = _nothing  # bodies to watch with a frozen brick
    _held: dict[BodyId, BodyState] = field(default_factory=dict, init=False)
    _seen: tuple[object, object] = field(default=(None, None), init=False)  # the engine's bodies at the last call

    def bodies_changed(self) -> bool:
        """Check that bodies were added or removed since the last call."""
        bricks, fixed = self.engine.masses(), self.engine.fixed()
        unchanged = self._seen[0] is bricks and self._seen[1] is fixed
        self._seen = (bricks, fixed)
        return not unchanged

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Store the states of newly frozen bricks, and of their new supports."""
        for brick in bricks:
            new = [on for on in self.supports(brick) if on not in self._held]
            self._held |= self.engine.states([brick, *new])

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Drop the states of woken bricks."""
        for brick in bricks:
            self._held.pop(brick, None)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the states of removed bricks."""
        self.woken(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the states of another instance."""
        self._held |= other._held

    def released(self, frozen: Iterable[BodyId]) -> list[BodyId]:
        """Return the frozen bricks that the engine no longer holds: replaced by another body, or given a mass."""
        return [brick for brick in frozen if not self.engine.holds(brick)]

    def lost(self, frozen: Collection[BodyId]) -> list[BodyId]:
        """Return the frozen bricks that the engine no longer has or no longer holds."""
        removed = list[BodyId]()
        if self.bodies_changed():
            bricks = self.engine.masses()
            removed = [brick for brick in frozen if brick not in bricks]
        return removed + self.released(brick for brick in frozen if brick not in removed)

    def disturbed(self, frozen: Container[BodyId]) -> dict[BodyId, BodyState]:
        """Return the current states of the frozen bricks and supports that were moved or pushed since the last call."""
        if not self._held:
            return {}
        fixed = self.engine.fixed()
        present = [body for body in self._held if body in frozen or body in fixed]
        states = self.engine.states(present)
        changed = {body: states[body] for body in present if _differs(states[body], self._held[body])}
        self._held |= changed
        return changed


def _differs(now: BodyState, before: BodyState) -> bool:
    """Check that a body was moved or pushed."""
    if (now.velocity_W, now.angular_velocity_W) != (before.velocity_W, before.angular_velocity_W):
        return True
    parts = (*now.pose.position_W, *now.pose.orientation)
    others = (*before.pose.position_W, *before.pose.orientation)
    return any(abs(part - other) > ROUNDING for part, other in zip(parts, others, strict=True))


SAME = 1e-6  # relative tolerance of gravity: rounding of an engine, and its horizontal part


def gravity_of(engine: Engine, given: float | None) -> float:
    """Return the gravity of a stabilizer along -z [m/s2]: that of the engine, or the given one.

    If the engine does not report its gravity, or reports 0 as the caller applies it otherwise, it is the given one; an
    engine that does not report it defaults to EARTH.

    Raises ValueError if the engine's gravity differs from the given one, is 0 with none given, or is not vertical.
    Raises TypeError for an object that is no engine.
    """
    if not callable(getattr(engine, "masses", None)):
        raise TypeError(f"expected an engine, such as PyBulletBodies(client), not {engine!r}")
    if given is not None:
        admit_number("the gravity is", given, "write a number greater than 0, in m/s2")
    if (reported_W := engine.gravity_W()) is None:
        return EARTH if given is None else given
    x, y, z = reported_W
    if x == y == z == 0.0:
        if given is None:
            raise ValueError("the engine has no gravity; set it first, in PyBullet with p.setGravity(0, 0, -9.81)")
        return given
    if z >= 0.0 or hypot(x, y) > SAME * -z:
        raise ValueError(
            f"the gravity of the engine is ({x:g}, {y:g}, {z:g}) m/s2, but proofs require gravity along -z"
        )
    if given is not None and not isclose(given, -z, rel_tol=SAME):
        raise ValueError(
            f"gravity={given:g} differs from the gravity of the engine, {-z:g} m/s2; omit it, or correct one of them"
        )
    return -z
