"""The exact stabilizer with hands, with parts that merge, and on shaking ground."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, inf, pi
from typing import NamedTuple, Self

from stability.dynamics.ground_motion import GroundMotion
from stability.graph import components
from stability.model import BodyId
from stability.problem import Placed, Tolerances
from stability.stabilizers.exact.candidates import fixed_bodies, release_until_stable, solids
from stability.stabilizers.exact.stabilizer import ProvenStability
from stability.stabilizers.protocol import Update
from stability.statics.assembly import Assembly

# The extension where hands take bricks, move them, hold them and let them go.
#
# A brick in a hand is none of those that are judged: as long as it moves it carries nothing that could be proven, and
# once it is held at rest it carries like the ground, for a hand is as strong as it has to be (docs/design/hands-and-shaking.md).


@dataclass
class HandledStability(ProvenStability):
    """Watches the bricks of one engine some of which may be in hands; see `ProvenStability`."""

    _in_hands: dict[BodyId, Placed | None] = field(default_factory=dict, init=False)  # where each is held, if at rest

    def taken(self, brick: BodyId) -> Update:
        """Say that a hand takes a brick: what cannot stand without it is woken."""
        woken: tuple[BodyId, ...] = ()
        if brick in self._rigid_groups:
            self._rigid_groups.unweld(brick)
        if self.is_frozen(brick):
            judgement = release_until_stable(self.assembly, self.assembly.remove([brick]))
            woken = self._give_back(judgement.released)
            self._awake.rest_poses.remember_driven(judgement.released)
        self._observers.gone([brick])
        self._in_hands[brick] = None
        return Update((), woken, reason=f"{brick} taken by a hand" if woken else "")

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Say that bricks are held at rest from now on: they carry as the ground does."""
        self.assembly.remove([brick for brick in bricks if self.is_frozen(brick)])
        self._observers.gone([brick for brick in bricks if brick not in self._in_hands])
        self._in_hands |= dict(solids(self.engine, self.engine.states(sorted(bricks))))
        return self._judged_anew(())

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Say that hands let bricks go: those that were at rest are judged at once, with all that they carried."""
        resting = [placed for brick in sorted(bricks) if (placed := self._in_hands.pop(brick)) is not None]
        if set_down or resting:
            self.set_down(bricks)
        if not resting:
            return Update()
        self._awake.no_longer_new()
        return self._judged_anew(resting)

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Say which bricks hands may move: they are woken, and not judged while they are named."""
        self._awake.handled(bricks)
        for brick in bricks:
            if brick in self._rigid_groups:
                self._rigid_groups.unweld(brick)
        woken = self.wake([brick for brick in bricks if self.is_frozen(brick)])
        self._awake.rest_poses.remember_driven({brick: s.pose for brick, s in self.engine.states(woken).items()})
        return Update((), woken, reason=reason if woken else "")

    def _judged_anew(self, coming: Sequence[Placed]) -> Update:
        """Judge all that stands on what is fixed by now, the ground and what hands hold at rest; `coming` as well."""
        tables = [placed for placed in self._in_hands.values() if placed is not None]
        planes = self.planes if self.planes is not None else fixed_bodies(self.engine, self.friction)[0]
        standing = tuple(self.assembly.bricks.values())
        self.assembly = Assembly(planes, self.friction, self.assembly.gravity, self.tolerances, tables, overlap=inf)
        judgement = release_until_stable(self.assembly, self.assembly.add_all([*standing, *coming]))
        self._when_changed = judgement.first
        names = [placed.brick.id for placed in coming]
        return self._carry_out(judgement, names, set(names))

    def _apart(self) -> Collection[BodyId]:
        return self._in_hands


# The extension where what was far apart comes near: what one has proven and seen, another goes on with.


@dataclass
class MergedStability(HandledStability):
    """Watches the bricks of one engine into which those of others may come; see `HandledStability`."""

    def absorb(self, other: Self) -> None:
        """Go on with the bricks of another extension, which have come into this one's engine by now.

        What stood by itself stands beside others that it does not touch.
        """
        self._observers.absorb(other._observers)
        standing = [other.assembly.bricks[name] for name in sorted(other.assembly.bricks)]
        if standing:
            self._give_back(release_until_stable(self.assembly, self.assembly.add_all(standing)).released)


# The extension on ground that shakes: what stands is held for as long as the ground accelerates less than it bears.
#
# The accelerations that a structure bears are a convex set around none (`statics/margins/acceleration.py`): what is
# proven to bear so much to one side, and so much to the other, bears all between. So there is nothing to step until the
# ground accelerates more than that. Then all that is connected moves, since what slides at the top of it passes on less
# to what is below, and it is judged anew when all is at rest.
#
# Bricks that are held go with the ground, and all is told as seen from there.


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
    from stability.analysis.acceleration_cut import heading, shaken  # noqa: PLC0415 -- slow to import

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
