"""The bricks that an engine moves: which of them have come to rest, and when it is worth while to judge them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from stability.engines.protocol import Engine
from stability.exact.candidates import solids
from stability.exact.hits.rigid_groups import RigidGroups
from stability.exact.rest_poses import RestPoses
from stability.model import BodyId, BodyState, Pose
from stability.statics.facts import Placed
from stability.watching.freezing import RestLimits
from stability.watching.refusals import Refusals
from stability.watching.stillness import Stillness


@dataclass
class AwakeBricks:
    """The bricks that one engine moves, from when they are set down or woken until they are frozen or gone."""

    engine: Engine
    rest: RestLimits
    rigid_groups: RigidGroups  # those of them that move as one
    rest_poses: RestPoses = field(default_factory=RestPoses, init=False)  # of those that were disturbed
    names: set[BodyId] = field(default_factory=set, init=False)
    announced: set[BodyId] = field(default_factory=set, init=False)  # set down since the last pass
    _stillness: Stillness = field(init=False)
    _refusals: Refusals = field(init=False)

    def __post_init__(self) -> None:
        self._stillness = Stillness(self.rest)
        self._refusals = Refusals(self.rest.hold_off)

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """These were set down at rest: they may be judged at once, before any step."""
        self.announced.update(bricks)
        self.names |= self.announced
        self._stillness.set_down(self.announced)

    def no_longer_new(self) -> set[BodyId]:
        """What was set down has been looked at; returns what that was."""
        announced, self.announced = self.announced, set()
        return announced

    def taken_out(self, brick: BodyId) -> None:
        """A brick is no longer in the engine: there is nothing to look at."""
        self.names.discard(brick)
        self.announced.discard(brick)

    def forget(self, brick: BodyId) -> None:
        """A brick is gone, or is another one by now."""
        self.rest_poses.settled([brick])
        self._stillness.forget(brick)
        self._refusals.forget(brick)

    def froze(self, brick: BodyId) -> None:
        """A brick was frozen."""
        self.names.discard(brick)
        self.rest_poses.settled([brick])
        self._stillness.froze(brick)
        self._refusals.forget(brick)

    def woke(self, brick: BodyId) -> None:
        """A brick was given back to the engine."""
        self.names.add(brick)
        self._stillness.woke(brick)

    def refuse(self, poses: Mapping[BodyId, Pose]) -> None:
        """These were not proven, where they are."""
        self._refusals.refuse(poses.items(), self.engine.time())

    def ask_again(self) -> None:
        """What is frozen is no longer what it was when bricks were refused."""
        self._refusals.changed()

    def wait(self) -> None:
        """What is at rest hangs on what moves: there is nothing to ask for a moment."""
        self._refusals.wait(self.engine.time())

    def follow(self) -> Mapping[BodyId, BodyState]:
        """See how they move: each one by one, those that ride through the first of their group."""
        states = self.engine.states(self.rigid_groups.followed(self.names))
        self._stillness.follow(self.engine.time(), states)
        return states

    def at_rest(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, Placed]:
        """The boxes among what is followed that are at rest; none if nothing is new since they were refused."""
        now = self.engine.time()
        if not self.announced and not self._refusals.may_ask(now):
            return {}
        resting = self._resting(now, states)
        news = any(
            brick in self.announced
            or self._refusals.is_news(brick, placed.pose, placed.brick.shape.least_thickness, now)
            for brick, placed in resting.items()
        )
        return resting if news else {}

    def _resting(self, now: float, states: Mapping[BodyId, BodyState]) -> dict[BodyId, Placed]:
        """The boxes that have been slow for long enough. What rides rests when all that was woken with it does."""
        slow = {brick for brick in states if self._stillness.may_be_judged(brick, now)}
        woken = [brick for brick in states if brick in self.rest_poses]
        if not slow.issuperset(woken):
            slow = {brick for brick in slow if brick not in self.rigid_groups}
        ridden = [
            member for brick in sorted(slow) if brick in self.rigid_groups for member in self.rigid_groups.part(brick)
        ]
        single = [brick for brick in slow if brick not in ridden]
        return dict(solids(self.engine, self.engine.states(sorted([*single, *ridden]))))
