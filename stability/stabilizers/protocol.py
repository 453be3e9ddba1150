"""The protocol of stabilizers, and the life cycle of a brick: awake, settling, frozen."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

from stability.dynamics.ground_motion import GroundMotion
from stability.model import BodyId, Vec3
from stability.problem import Verdict

# The protocol of a stabilizer.


@dataclass(frozen=True, slots=True)
class Update:
    """What one pass of an extension changed; bricks by name."""

    frozen: tuple[BodyId, ...] = ()
    woken: tuple[BodyId, ...] = ()  # left to the engine: they were frozen, or set down at rest, and cannot stand
    failed: tuple[BodyId, ...] = ()  # those of `woken` that give way; the rest stood on them
    reason: str = ""  # why bricks were woken
    proof: str = ""  # the stage that proved that the frozen bricks stand; empty where nothing proves
    riding: tuple[BodyId, ...] = ()  # those of `woken` that move as rigid bodies on others
    by: tuple[BodyId, ...] = ()  # the moving bricks that hit or press those of `woken`; empty if another cause woke any

    def then(self, other: "Update") -> "Update":
        """This update and a later one of the same pass as one; what is frozen, and its proof, are from the later."""
        told = all(update.by or not update.woken for update in (self, other))
        return Update(
            other.frozen,
            self.woken + tuple(brick for brick in other.woken if brick not in self.woken),
            self.failed + other.failed,
            "; ".join(filter(None, (self.reason, other.reason))),
            other.proof,
            self.riding + other.riding,
            self.by + other.by if told else (),
        )


class Extension(Protocol):
    """Freezes the bricks of one engine that stand, and wakes those that do so no longer."""

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""

    def riding(self) -> Collection[BodyId]:
        """Those of the awake bricks that move as rigid bodies on others, not one by one."""

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed."""

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Say that these bricks were set down at rest: they may be judged at once, before any step."""

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks were taken out of the engine: what cannot stand without them is woken at once."""

    def update(self) -> Update:
        """One pass over what the engine has just done. Call it after each step."""

    def struck(self, brick: BodyId, impulse_W: Vec3) -> Update:
        """Say that a brick is about to be given an impulse [N s]: what that disturbs is woken before."""

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks back to the engine, and all that cannot stand without them; returns those woken."""

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some.

        Where only some are asked for, it is enough to count what they carry of each other.
        """

    def least_margin(self) -> float | None:
        """The smallest tipping margin of what is frozen [m]; None where no model has one."""

    def verdict(self) -> Verdict | None:
        """What was proven of the structure when bricks were last set down or taken out; None where nothing proves."""

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why awake bricks are proven not to stand, though nothing may have been seen of that yet."""


@runtime_checkable
class JudgesLandings(Protocol):
    """An extension to which motions that are known without an engine may be told."""

    def landed(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks have come to rest: they are judged at once, though nothing was set down."""


@runtime_checkable
class Absorbs(Protocol):
    """An extension that can go on with what another one of its kind has watched, where its bricks come near."""

    def absorb(self, other: Self) -> None:
        """Go on with the bricks of another extension, which have come into this one's engine by now."""


@runtime_checkable
class FeelsHands(Protocol):
    """An extension that knows of hands, which move bricks or hold them, whatever these meet."""

    def taken(self, brick: BodyId) -> Update:
        """Say that a hand takes a brick: it is none of the bricks that are judged, and what stands by it is woken."""

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Say that bricks are held at rest from now on, as firmly as the ground; hands may have taken them before."""

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Say that hands let bricks go; `set_down` if they brought them, so that they are judged at once."""

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Say which bricks hands may move or press on by now: they are woken, and not judged while they are named."""


@runtime_checkable
class FeelsShaking(Protocol):
    """An extension that knows what the ground does to what it holds."""

    def shaken(self, motion: GroundMotion) -> None:
        """Say how the ground moves from now on."""

    def holds_until(self) -> float:
        """Until when all that is held is proven to go with the ground [s]; inf if that is for good."""


# The life cycle of a brick under a stability extension, and the one way in which its parts hear of it.
#
# A brick is set down or appears, is frozen when it is found to stand, woken when it is not any more, and gone at last.
# The extension changes the engine first, then tells its observers in a fixed order, and each of them draws its own
# conclusions. What observers are told is a fact; they answer nothing and change no brick.


class BrickObserver:
    """Hears what becomes of the bricks of one engine. A subclass overrides the events to which it reacts."""

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """These bricks were set down at rest: they may be judged at once, before any step."""

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """These bricks were found to stand, and are held fixed in the engine now."""

    def woken(self, bricks: Collection[BodyId]) -> None:
        """These bricks were frozen, and the engine moves them again, one by one or as rigid groups.

        There may be none: then bricks were judged together with what is frozen, and nothing was released.
        """

    def gone(self, bricks: Collection[BodyId]) -> None:
        """These bricks are no longer in the engine, or other ones are there under their names."""

    def absorb(self, other: Self) -> None:
        """The bricks of which another one of its kind hears come into this engine, with all that is known of them."""


class Observers(BrickObserver):
    """Several observers as one: each event is told to all of them, in the order in which they are given."""

    def __init__(self, observers: Iterable[BrickObserver]) -> None:
        """The order is fixed from here on."""
        self._observers = tuple(observers)

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were set down."""
        for observer in self._observers:
            observer.set_down(bricks)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were frozen."""
        for observer in self._observers:
            observer.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were woken."""
        for observer in self._observers:
            observer.woken(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks are gone."""
        for observer in self._observers:
            observer.gone(bricks)

    def absorb(self, other: Self) -> None:
        """Let each take over from the one in its place."""
        for own, others in zip(self._observers, other._observers, strict=True):
            own.absorb(others)
