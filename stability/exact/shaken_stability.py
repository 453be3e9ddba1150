"""The extension on ground that shakes: what stands is held for as long as the ground accelerates less than it bears.

The accelerations that a structure bears are a convex set around none (`statics/margins/acceleration.py`): what is
proven to bear so much to one side, and so much to the other, bears all between. So there is nothing to step until the
ground accelerates more than that. Then all that is connected moves, since what slides at the top of it passes on less
to what is below, and it is judged anew when all is at rest.

Bricks that are held go with the ground, and all is told as seen from there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import atan2, inf, pi
from typing import NamedTuple

from stability.exact.merged_stability import MergedStability
from stability.graph import components
from stability.mechanics.ground_motion import GroundMotion
from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Tolerances
from stability.watching.extension import Update

ROUNDING = 1e-9  # [s] of clocks, which are sums of steps


class Bounds(NamedTuple):
    """Accelerations of the ground along a line that are borne, and all between [m/s2]."""

    least: float
    most: float


class Held(NamedTuple):
    """Bricks that are held as long as this is borne."""

    bricks: frozenset[BodyId]
    bounds: Bounds
    until: float  # when it no longer is [s]; inf if it is to the end


def borne(assembly: Assembly, bricks: frozenset[BodyId], motion: GroundMotion) -> Bounds:
    """What bricks that touch no others, and are proven to stand, are proven to bear of a motion of the ground."""
    from stability.statics.margins.acceleration_cut import heading, shaken  # noqa: PLC0415 -- slow to import

    case = shaken(assembly.problem(bricks), assembly.gravity, Tolerances())
    if case is None:
        return Bounds(0.0, 0.0)
    along = atan2(motion.direction_W[1], motion.direction_W[0])
    # What the ground does one way bricks feel the other way.
    least, most = (assembly.gravity * heading(case, angle).reach for angle in (along, along + pi))
    return Bounds(-least, most)


@dataclass
class ShakenStability(MergedStability):
    """Watches the bricks of one engine whose ground may shake; see `MergedStability`."""

    _motion: GroundMotion | None = field(default=None, init=False)
    _known: Mapping[BodyId, Placed] = field(default_factory=dict, init=False)  # what `_parts` are of
    _parts: list[Held] = field(default_factory=list, init=False)
    _shook: bool = field(default=False, init=False)  # as it was last updated

    def shaken(self, motion: GroundMotion) -> None:
        """Say how the ground moves from now on."""
        self._motion, self._known, self._parts = motion, {}, []

    def holds_until(self) -> float:
        """Until when all that is held is proven to go with the ground [s]; inf if that is for good."""
        return min((held.until for held in self._look()), default=inf)

    def update(self) -> Update:
        """Judge what has come to rest, and wake what the ground shakes too much."""
        if self._shook and not self._shakes:
            self._awake.ask_again()  # what was woken by the ground alone, or refused as others still moved
        self._shook = self._shakes
        found = super().update()
        now = self.engine.time()
        shaken = [held for held in self._look() if held.until <= now + ROUNDING]
        if not shaken or self._motion is None:
            return found
        woken = tuple(brick for held in shaken for brick in self.wake(held.bricks))
        reasons = dict.fromkeys(filter(None, (found.reason, *map(_in_words, shaken))))
        return replace(found, woken=(*found.woken, *woken), reason="; ".join(reasons), by=())

    def _clear(self, resting: Mapping[BodyId, Placed]) -> list[Placed]:
        """All that is awake, once all of it rests: what still moves on a brick shakes it as much as the ground does."""
        clear = super()._clear(resting)
        return clear if not self._shakes or len(clear) == len(self._awake.names) else []

    @property
    def _shakes(self) -> bool:
        return self._motion is not None and self.engine.time() < self._motion.ends

    def _look(self) -> list[Held]:
        """What is held, each part for itself."""
        motion, now = self._motion, self.engine.time()
        if motion is None or not self._shakes:
            return []
        if self._known != self.assembly.bricks:
            known = {held.bricks: held for held in self._parts if self._is_as_it_was(held)}
            parts = map(frozenset, components(self.assembly.bricks, self._touching))
            self._parts = [known.get(part) or self._held_from(now, part, motion) for part in parts]
            self._known = dict(self.assembly.bricks)
        return self._parts

    def _is_as_it_was(self, held: Held) -> bool:
        bricks = self.assembly.bricks
        return all(brick in bricks and bricks[brick] is self._known[brick] for brick in held.bricks)

    def _touching(self, brick: BodyId) -> set[BodyId]:
        return {body for contact in self.assembly.contacts(brick) for body in (contact.lower, contact.upper)}

    def _held_from(self, now: float, bricks: frozenset[BodyId], motion: GroundMotion) -> Held:
        bounds = borne(self.assembly, bricks, motion)
        return Held(bricks, bounds, motion.leaves(*bounds, since=now))


def _in_words(held: Held) -> str:
    least, most = held.bounds
    return f"the ground accelerates by more than is borne, {least:.3g} to {most:.3g} m/s2"
