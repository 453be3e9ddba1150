"""Protocol of stabilizers, and the life cycle of a brick: awake, settling, frozen."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, ClassVar, Protocol, Self

from stability.dynamics.ground_motion import GroundMotion
from stability.model import AT_REST, BodyId, Vec3
from stability.problem import Verdict

if TYPE_CHECKING:
    from stability.joints import Joints
    from stability.loads import LoadCourse
    from stability.statics.assembly import Assembly


@dataclass(frozen=True, slots=True)
class Update:
    """Changes made by one pass of a stabilizer; bricks by name."""

    frozen: tuple[BodyId, ...] = ()
    woken: tuple[
        BodyId, ...
    ] = ()  # frozen bricks, or bricks set down at rest, that cannot stand: the engine moves them
    failed: tuple[BodyId, ...] = ()  # the bricks in `woken` that failed; the others stood on them
    reason: str = ""  # reason for waking bricks
    proof: str = ""  # stage that proved the frozen bricks; empty without proofs
    riding: tuple[BodyId, ...] = ()  # the bricks in `woken` that move in rigid groups on others
    by: tuple[BodyId, ...] = ()  # moving bricks that hit or press those in `woken`; empty if any has another cause
    opened: frozenset[frozenset[BodyId]] = frozenset()  # pairs of bodies whose joint has opened

    def then(self, other: "Update") -> "Update":
        """Merge with a later update of the same pass, which provides the frozen bricks and their proof."""
        has_cause = all(update.by or not update.woken for update in (self, other))
        return Update(
            other.frozen,
            self.woken + tuple(brick for brick in other.woken if brick not in self.woken),
            self.failed + other.failed,
            "; ".join(filter(None, (self.reason, other.reason))),
            other.proof,
            self.riding + other.riding,
            self.by + other.by if has_cause else (),
            self.opened | other.opened,
        )


class Stabilizer(Protocol):
    """Stabilizer: freezes the bricks of one engine that stand, and wakes those that no longer do."""

    proves: ClassVar[bool] = False  # freezes by proofs, which also cover known motions and shaking ground

    def awake(self) -> list[BodyId]:
        """Return the bricks that the engine moves, sorted by name."""

    def riding(self) -> Collection[BodyId]:
        """Return the awake bricks that move in rigid groups on others."""

    def is_frozen(self, brick: BodyId) -> bool:
        """Check that a brick is frozen."""

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Handle bricks that were set down at rest: they may be judged immediately, before any step."""

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Handle bricks that were removed from the engine: bricks that cannot stand without them wake immediately."""

    def update(self) -> Update:
        """Judge the bricks after a step of the engine. Call this after each step."""

    def struck(self, brick: BodyId, impulse_W: Vec3, offset_W: Vec3 = AT_REST) -> Update:
        """Handle an impulse [N s] that a brick is about to receive, at an offset from its centre [m].

        Bricks that it disturbs wake before.
        """

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Wake these bricks and all that cannot stand without them; return the woken bricks."""

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Return each frozen brick's load shares by support, for all frozen bricks or some.

        For some bricks, the loads may include only these bricks.
        """

    def least_margin(self) -> float | None:
        """Return the smallest tipping margin of the frozen bricks [m]; None if the model has none."""

    def verdict(self) -> Verdict | None:
        """Return the verdict on the structure after bricks were last set down or removed; None without proofs."""

    def giving_way(self) -> Mapping[BodyId, str]:
        """Return the reasons why awake bricks are proven not to stand, possibly before they visibly move."""

    # --- hands, which move or hold bricks regardless of contacts ------------------------------------------------------

    def grasp(self, brick: BodyId) -> Update:
        """Handle a hand taking a brick: the brick is no longer judged, and bricks that it supported wake."""

    def hold(self, bricks: Collection[BodyId]) -> Update:
        """Handle bricks that hands hold at rest, as firmly as the ground; hands may have taken them before."""

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Handle hands releasing bricks; `set_down` if the hands placed them, so that they are judged immediately."""

    def set_handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Set the bricks that hands may move or press: they wake, and are not judged until a later call omits them."""

    # --- by proofs only: the defaults are those of a stabilizer without proofs ----------------------------------------

    def proven(self) -> "Assembly | None":
        """Return the assembly of the frozen bricks, with their proofs."""
        return None

    def landed(self, bricks: Iterable[BodyId]) -> Update:
        """Judge bricks that have come to rest after a motion without an engine, as if they were set down."""
        return Update()

    def rejoined(self, joints: "Joints") -> Update:
        """Handle other joints of all bricks: bricks that cannot stand with them wake immediately."""
        return Update()

    def loaded(self, course: "LoadCourse") -> Update:
        """Handle other loads on bricks: bricks that cannot stand under them wake immediately."""
        return Update()

    def moves_under_loads(self) -> bool:
        """Return whether loads act on bricks in motion."""
        return False

    def needs_engine(self) -> bool:
        """Return whether forces act on bricks in motion that motions without an engine do not cover."""
        return False

    def shaken(self, motion: GroundMotion) -> None:
        """Set the motion of the ground."""
        return

    def about_to_step(self) -> None:
        """Prepare the next step of the engine."""
        return

    def opened(self) -> Update | None:
        """Open the joints that did not bear the last step of the engine, and take it back; None if all did."""
        return None

    def moved_without_engine(self) -> None:
        """Handle a motion without the engine, in which all bricks move one by one."""
        return

    def holds_until(self) -> float:
        """Return the time until which all frozen bricks provably move with the ground [s]; inf for the whole motion."""
        return inf

    def absorb(self, other: Self) -> None:
        """Take over the bricks of another stabilizer, which are in this one's engine already."""
        raise TypeError(f"{type(self).__name__} cannot take over bricks")


# Life cycle of a brick, as events to observers.
#
# A brick is set down or appears, freezes when it is judged to stand, wakes when it no longer stands, and is removed.
# The stabilizer changes the engine first, then notifies its observers in a fixed order. Observers return nothing and
# change no brick.


class BrickObserver:
    """Observer of the life cycle of one engine's bricks. A subclass overrides the events that it needs."""

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Bricks were set down at rest: they may be judged immediately, before any step."""

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Bricks were judged to stand, and are frozen in the engine."""

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Frozen bricks were woken, one by one or as rigid groups.

        The collection is empty if bricks were judged together with the frozen ones and none of these was released.
        """

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Bricks were removed from the engine, or replaced by others of the same names."""

    def absorb(self, other: Self) -> None:
        """Take over the records of another observer, whose bricks were added to this engine."""


class Observers(BrickObserver):
    """Passes each event to several observers, in the given order."""

    def __init__(self, observers: Iterable[BrickObserver]) -> None:
        """Store the observers in this order."""
        self._observers = tuple(observers)

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Notify all observers that bricks were set down."""
        for observer in self._observers:
            observer.set_down(bricks)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Notify all observers that bricks were frozen."""
        for observer in self._observers:
            observer.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Notify all observers that bricks were woken."""
        for observer in self._observers:
            observer.woken(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Notify all observers that bricks were removed."""
        for observer in self._observers:
            observer.removed(bricks)

    def absorb(self, other: Self) -> None:
        """Let each observer take over the records of its counterpart."""
        for own, others in zip(self._observers, other._observers, strict=True):
            own.absorb(others)
