"""The bricks that an engine moves: which of them have come to rest, and when it is worth judging them."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Self

from stability.engines.protocol import Engine
from stability.model import BodyId, BodyState, Pose
from stability.problem import Placed
from stability.stabilizers.exact.candidates import RestPoses, solids
from stability.stabilizers.exact.woken_region import RigidGroups
from stability.stabilizers.protocol import BrickObserver, Observers
from stability.stabilizers.rest import LimitsOf, Refusals, Stillness


@dataclass
class AwakeBricks(BrickObserver):
    """The bricks that one engine moves, from when they are set down or woken until they are frozen or gone."""

    engine: Engine
    limits_of: LimitsOf
    rigid_groups: RigidGroups  # those of them that move as one
    rest_poses: RestPoses = field(default_factory=RestPoses, init=False)  # of those that were disturbed
    names: set[BodyId] = field(default_factory=set, init=False)
    announced: set[BodyId] = field(default_factory=set, init=False)  # set down since the last pass
    _ranks: dict[BodyId, int] = field(default_factory=dict, init=False)  # who came before whom
    _stillness: Stillness = field(init=False)
    _refusals: Refusals = field(init=False)
    _observers: Observers = field(init=False)

    def __post_init__(self) -> None:
        self._stillness = Stillness(self.limits_of)
        self._refusals = Refusals(self.limits_of)
        self._observers = Observers((self.rest_poses, self._stillness, self._refusals))

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """What is set down is announced: it is judged in the next pass."""
        self.announced.update(bricks)
        self.names |= self.announced
        self._rank(bricks)
        self._observers.set_down(self.announced)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """The engine moves these no longer."""
        self.names.difference_update(bricks)
        self._observers.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """The engine moves these again."""
        self.names.update(bricks)
        self._observers.woken(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """There is nothing to look at any more."""
        self.names.difference_update(bricks)
        self.announced.difference_update(bricks)
        self._observers.gone(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self.names |= other.names
        self.announced |= other.announced
        self._rank(other.in_order(other._ranks))
        self._observers.absorb(other._observers)

    def notice(self, bricks: Collection[BodyId], frozen: Collection[BodyId]) -> None:
        """All bricks of the engine but the frozen ones are awake, whoever has put them there."""
        self.names = set(bricks).difference(frozen)
        self._rank(bricks)

    def _rank(self, bricks: Iterable[BodyId]) -> None:
        for brick in bricks:
            self._ranks.setdefault(brick, len(self._ranks))

    def in_order(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """These bricks in the order in which they came: an engine told of them by name would round by their names."""
        return sorted(bricks, key=self._ranks.__getitem__)

    def no_longer_new(self) -> set[BodyId]:
        """Say that a pass has looked at the announced bricks; returns their names."""
        announced, self.announced = self.announced, set()
        return announced

    def handled(self, bricks: Collection[BodyId]) -> None:
        """Bricks that hands may move are not judged, as long as they are named here."""
        self._stillness.handled = bricks

    def refuse(self, poses: Mapping[BodyId, Pose]) -> None:
        """Bricks were not proven, each where it is: they are not asked about again until something is new."""
        self._refusals.refuse(poses.items(), self.engine.time())

    def ask_again(self) -> None:
        """Bricks that were refused may be asked about again: what is frozen was moved, or what it rests on."""
        self._refusals.changed()

    def wait(self) -> None:
        """Ask nothing for a moment, because the bricks at rest touch bricks that still move."""
        self._refusals.wait(self.engine.time(), self.names)

    def follow(self) -> Mapping[BodyId, BodyState]:
        """Read the states of the awake bricks; a rigid group is represented by its first brick."""
        states = self.engine.states(self.rigid_groups.watched(self.in_order(self.names)))
        self._stillness.follow(self.engine.time(), states)
        return states

    def at_rest(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, Placed]:
        """The boxes that are at rest; none if nothing has changed since they were refused."""
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
        """The boxes that have been slow for long enough. A rigid group rests only when all that a hit woke does."""
        slow = {brick for brick in states if self._stillness.may_be_judged(brick, now)}
        woken = [brick for brick in states if brick in self.rest_poses]
        if not slow.issuperset(woken):
            slow = {brick for brick in slow if brick not in self.rigid_groups}
        ridden = [
            member
            for brick in self.in_order(slow)
            if brick in self.rigid_groups
            for member in self.rigid_groups.unweld(brick)
        ]
        single = [brick for brick in slow if brick not in ridden]
        return dict(solids(self.engine, self.engine.states(self.in_order([*single, *ridden]))))
