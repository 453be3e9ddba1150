"""Exact stabilizer with hands, with merging islands, and on shaking ground."""

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

# Hands: a brick in a hand is not judged. While it moves, no brick on it is proven; held at rest it carries like the
# ground, as the force of a hand is unlimited (docs/design/hands-and-shaking.md).


@dataclass
class HandledStability(ProvenStability):
    """Exact stabilizer of bricks that hands may take, move, hold and release; see `ProvenStability`."""

    _in_hands: dict[BodyId, Placed | None] = field(default_factory=dict, init=False)  # with its pose if held at rest

    def taken(self, brick: BodyId) -> Update:
        """Handle a hand taking a brick: bricks that cannot stand without it wake."""
        woken: tuple[BodyId, ...] = ()
        if brick in self._rigid_groups:
            self._rigid_groups.unweld(brick)
        if self.is_frozen(brick):
            judgement = release_until_stable(self.assembly, self.assembly.remove([brick]))
            woken = self._wake_released(judgement.released)
            self._awake.rest_poses.store_driven(judgement.released)
        self._observers.gone([brick])
        self._in_hands[brick] = None
        return Update((), woken, reason=f"{brick} taken by a hand" if woken else "")

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Handle bricks that hands hold at rest: they carry like the ground."""
        self.assembly.remove([brick for brick in bricks if self.is_frozen(brick)])
        self._observers.gone([brick for brick in bricks if brick not in self._in_hands])
        self._in_hands |= dict(solids(self.engine, self.engine.states(sorted(bricks))))
        return self._judge_again(())

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Handle hands releasing bricks: those held at rest are judged immediately, with the bricks on them."""
        resting = [placed for brick in sorted(bricks) if (placed := self._in_hands.pop(brick)) is not None]
        if set_down or resting:
            self.set_down(bricks)
        if not resting:
            return Update()
        self._awake.clear_announced()
        return self._judge_again(resting)

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Set the bricks that hands may move: they wake, and are not judged until a later call omits them."""
        self._awake.handled(bricks)
        for brick in bricks:
            if brick in self._rigid_groups:
                self._rigid_groups.unweld(brick)
        woken = self.wake([brick for brick in bricks if self.is_frozen(brick)])
        self._awake.rest_poses.store_driven({brick: s.pose for brick, s in self.engine.states(woken).items()})
        return Update((), woken, reason=reason if woken else "")

    def _judge_again(self, added: Sequence[Placed]) -> Update:
        """Judge all frozen bricks and `added` on the ground and the bricks that hands hold at rest."""
        tables = [placed for placed in self._in_hands.values() if placed is not None]
        planes = self.planes if self.planes is not None else fixed_bodies(self.engine, self.friction)[0]
        standing = tuple(self.assembly.bricks.values())
        self.assembly = Assembly(planes, self.friction, self.assembly.gravity, self.tolerances, tables, overlap=inf)
        judgement = release_until_stable(self.assembly, self.assembly.add_all([*standing, *added]))
        self._verdict = judgement.first
        names = [placed.brick.id for placed in added]
        return self._apply(judgement, names, set(names))

    def _excluded(self) -> Collection[BodyId]:
        return self._in_hands


# Merging islands: a stabilizer takes over the proofs and records of another.


@dataclass
class MergedStability(HandledStability):
    """Exact stabilizer that can take over the bricks of another one; see `HandledStability`."""

    def absorb(self, other: Self) -> None:
        """Take over the bricks of another stabilizer, which are in this one's engine already.

        A proof stays valid beside other bricks that its bricks do not touch.
        """
        self._observers.absorb(other._observers)
        standing = [other.assembly.bricks[name] for name in sorted(other.assembly.bricks)]
        if standing:
            self._wake_released(release_until_stable(self.assembly, self.assembly.add_all(standing)).released)


# Shaking ground: bricks stay frozen as long as the ground acceleration is within their proven range.
#
# The accelerations that a structure withstands form a convex set around 0 (`analysis/acceleration_margin.py`), so a
# proof in both directions covers all accelerations between. Beyond it all connected bricks wake, as a brick that slides
# on top loads those below less, and they are judged again when all are at rest.
#
# Frozen bricks move with the ground, and states are relative to it.


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


def proven_range(assembly: Assembly, bricks: frozenset[BodyId], motion: GroundMotion) -> Bounds:
    """Prove the range of ground accelerations that connected bricks, proven to stand, withstand along a motion."""
    from stability.analysis.acceleration_cut import heading, shaken  # noqa: PLC0415 -- slow to import

    case = shaken(assembly.problem(bricks), assembly.gravity, Tolerances())
    if case is None:
        return Bounds(0.0, 0.0)
    along = atan2(motion.direction_W[1], motion.direction_W[0])
    # The inertial acceleration is opposite to that of the ground.
    least, most = (assembly.gravity * heading(case, angle).reach for angle in (along, along + pi))
    return Bounds(-least, most)


@dataclass
class ShakenStability(MergedStability):
    """Exact stabilizer of bricks on ground that may shake; see `MergedStability`."""

    _motion: GroundMotion | None = field(default=None, init=False)
    _judged_bricks: Mapping[BodyId, Placed] = field(default_factory=dict, init=False)  # the bricks of `_parts`
    _parts: list[HeldPart] = field(default_factory=list, init=False)
    _shook: bool = field(default=False, init=False)  # whether the ground shook at the last update

    def shaken(self, motion: GroundMotion) -> None:
        """Set the motion of the ground."""
        self._motion, self._judged_bricks, self._parts = motion, {}, []

    def holds_until(self) -> float:
        """Return the time until which all frozen bricks provably move with the ground [s]; inf if to the end."""
        return min((held.until for held in self._held_parts()), default=inf)

    def update(self) -> Update:
        """Judge bricks at rest, and wake bricks whose proven range the ground acceleration leaves."""
        if self._shook and not self._shakes:
            self._awake.allow_judgement()  # for bricks woken by the ground alone, or refused while others moved
        self._shook = self._shakes
        update = super().update()
        now = self.engine.time()
        shaken = [held for held in self._held_parts() if held.until <= now + ROUNDING]
        if not shaken or self._motion is None:
            return update
        woken = tuple(brick for held in shaken for brick in self.wake(held.bricks))
        reasons = dict.fromkeys(filter(None, (update.reason, *map(_reason, shaken))))
        return replace(update, woken=(*update.woken, *woken), reason="; ".join(reasons), by=())

    def _judgeable(self, resting: Mapping[BodyId, Placed]) -> list[Placed]:
        """Return all awake bricks once all are at rest: a moving brick shakes its support as the ground does."""
        judgeable = super()._judgeable(resting)
        return judgeable if not self._shakes or len(judgeable) == len(self._awake.names) else []

    @property
    def _shakes(self) -> bool:
        return self._motion is not None and self.engine.time() < self._motion.ends

    def _held_parts(self) -> list[HeldPart]:
        """Return the connected parts of the frozen bricks with their proven ranges."""
        motion, now = self._motion, self.engine.time()
        if motion is None or not self._shakes:
            return []
        if self._judged_bricks != self.assembly.bricks:
            unchanged = {held.bricks: held for held in self._parts if self._is_unchanged(held)}
            parts = map(frozenset, components(self.assembly.bricks, self._touching))
            self._parts = [unchanged.get(part) or self._held_from(now, part, motion) for part in parts]
            self._judged_bricks = dict(self.assembly.bricks)
        return self._parts

    def _is_unchanged(self, held: HeldPart) -> bool:
        bricks = self.assembly.bricks
        return all(brick in bricks and bricks[brick] is self._judged_bricks[brick] for brick in held.bricks)

    def _touching(self, brick: BodyId) -> set[BodyId]:
        return {body for contact in self.assembly.contacts(brick) for body in (contact.lower, contact.upper)}

    def _held_from(self, now: float, bricks: frozenset[BodyId], motion: GroundMotion) -> HeldPart:
        bounds = proven_range(self.assembly, bricks, motion)
        return HeldPart(bricks, bounds, motion.leaves(*bounds, since=now))


def _reason(held: HeldPart) -> str:
    least, most = held.bounds
    return f"ground acceleration outside the proven range, {least:.3g} to {most:.3g} m/s2"
