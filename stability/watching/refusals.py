"""When to ask again about bricks at rest that were not proven: as long as no pose changes, no verdict does."""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from math import dist
from typing import Self

from stability.model import BodyId, Pose
from stability.watching.life_cycle import BrickObserver
from stability.watching.rest import RestLimits

# Share of its smallest side that a brick must move by to be news: a quarter of the gap that still counts as contact,
# so that a contact which the engine is closing is not missed.
MOVED = 0.005
MOMENT = 0.1  # share of the hold-off for which nothing is asked while bricks at rest touch moving ones
RETRY = 10.0  # times the hold-off after which everything is news again


@dataclass(frozen=True, slots=True)
class _Refusal:
    pose: Pose
    time: float  # [s]
    changes: int  # how often what is frozen had changed by then


@dataclass
class Refusals(BrickObserver):
    """Where and when bricks were not proven."""

    limits_of: Callable[[BodyId], RestLimits]  # their hold-off is between one attempt that refused a brick and the next
    _changes: int = field(default=0, init=False)  # how often what is frozen has changed
    _not_before: float = field(default=0.0, init=False)  # [s] time of the next attempt
    _of: dict[BodyId, _Refusal] = field(default_factory=dict, init=False)

    def may_ask(self, now: float) -> bool:
        """Whether the last refusal is long enough ago for another attempt."""
        return now >= self._not_before

    def is_news(self, brick: BodyId, pose: Pose, smallest_side: float, now: float) -> bool:
        """Whether a brick was not refused yet, or something has changed since."""
        refused = self._of.get(brick)
        if (
            refused is None
            or refused.changes != self._changes
            or now >= refused.time + RETRY * self.limits_of(brick).hold_off
        ):
            return True
        return dist(refused.pose.position_W, pose.position_W) > MOVED * smallest_side

    def refuse(self, poses: Iterable[tuple[BodyId, Pose]], now: float) -> None:
        """Remember where bricks are that were not proven."""
        refused = {brick: _Refusal(pose, now, self._changes) for brick, pose in poses}
        self._of |= refused
        if refused:
            self._not_before = now + min(self.limits_of(brick).hold_off for brick in refused)

    def wait(self, now: float, bricks: Iterable[BodyId]) -> None:
        """Ask nothing for a moment, because some of these bricks rest, and touch others that still move."""
        moment = min((MOMENT * self.limits_of(brick).hold_off for brick in bricks), default=0.0)
        self._not_before = max(self._not_before, now + moment)

    def changed(self) -> None:
        """What is frozen, or what that rests on, is no longer what it was when bricks were refused."""
        self._changes += 1

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """There is more to stand on, and what was refused before is proven."""
        self._left(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """There is less to stand on."""
        if bricks:
            self.changed()

    def gone(self, bricks: Collection[BodyId]) -> None:
        """There may be less to stand on, and a new brick under an old name was never refused."""
        self._left(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._of |= other._of
        self._not_before = max(self._not_before, other._not_before)
        self.changed()

    def _left(self, bricks: Collection[BodyId]) -> None:
        """These are not among the bricks that wait for a proof any more."""
        if bricks:
            self.changed()
        for brick in bricks:
            self._of.pop(brick, None)
