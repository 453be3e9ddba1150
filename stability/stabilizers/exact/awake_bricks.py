"""The bricks that an engine moves: which are at rest, and when to judge them."""

from collections.abc import Collection, Container, Iterable, Mapping
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
    """The bricks that one engine moves, from setting down or waking to freezing or removal."""

    engine: Engine
    limits_of: LimitsOf
    rigid_groups: RigidGroups  # welded groups among them
    rest_poses: RestPoses = field(default_factory=RestPoses, init=False)  # of the disturbed bricks
    names: set[BodyId] = field(default_factory=set, init=False)
    announced: set[BodyId] = field(default_factory=set, init=False)  # set down since the last pass
    _ranks: dict[BodyId, int] = field(default_factory=dict, init=False)  # order of addition
    _stillness: Stillness = field(init=False)
    _refusals: Refusals = field(init=False)
    _observers: Observers = field(init=False)

    def __post_init__(self) -> None:
        self._stillness = Stillness(self.limits_of)
        self._refusals = Refusals(self.limits_of)
        self._observers = Observers((self.rest_poses, self._stillness, self._refusals))

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Announce bricks that were set down: the next pass judges them."""
        self.announced.update(bricks)
        self.names |= self.announced
        self._rank(bricks)
        self._observers.set_down(self.announced)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Remove frozen bricks."""
        self.names.difference_update(bricks)
        self._observers.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Add woken bricks."""
        self.names.update(bricks)
        self._observers.woken(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Remove bricks that left the engine."""
        self.names.difference_update(bricks)
        self.announced.difference_update(bricks)
        self._observers.removed(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the bricks of another instance."""
        self.names |= other.names
        self.announced |= other.announced
        self._rank(other.in_order(other._ranks))
        self._observers.absorb(other._observers)

    def notice(self, bricks: Collection[BodyId], frozen: Collection[BodyId]) -> None:
        """Count all bricks of the engine except the frozen ones as awake."""
        self.names = set(bricks).difference(frozen)
        self._rank(bricks)

    def _rank(self, bricks: Iterable[BodyId]) -> None:
        for brick in bricks:
            self._ranks.setdefault(brick, len(self._ranks))

    def in_order(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Sort bricks by their addition, as an order by name would make an engine's rounding depend on names."""
        return sorted(bricks, key=self._ranks.__getitem__)

    def clear_announced(self) -> set[BodyId]:
        """Clear the announcements after a pass; return the announced bricks."""
        announced, self.announced = self.announced, set()
        return announced

    def set_handled(self, bricks: Collection[BodyId]) -> None:
        """Exclude bricks that hands may move from judgement, until the next call."""
        self._stillness.in_reach_of_hands = bricks

    def refuse(self, poses: Mapping[BodyId, Pose]) -> None:
        """Record bricks that were not proven, with their poses: they are not judged again before a change."""
        self._refusals.refuse(poses.items(), self.engine.time())

    def allow_judgement(self) -> None:
        """Allow another judgement of refused bricks after a change of the frozen bricks or their supports."""
        self._refusals.changed()

    def wait(self) -> None:
        """Pause judgements shortly, as the bricks at rest touch bricks that still move."""
        self._refusals.wait(self.engine.time(), self.names)

    def has_rested(self, brick: BodyId, state: BodyState) -> bool:
        """Check that a brick in this state has been slow for the hold-off, as slow as woken bricks have to be."""
        limits = self.limits_of(brick)
        return limits.slow(state, limits.still) and self._stillness.is_slow_for(
            brick, limits.hold_off, self.engine.time()
        )

    def is_slow(self, brick: BodyId) -> bool:
        """Check that a brick is slow now."""
        return self._stillness.is_slow_for(brick, 0.0, self.engine.time())

    def follow(self, without: Container[BodyId] = ()) -> Mapping[BodyId, BodyState]:
        """Read the states of the awake bricks except some; a rigid group is represented by its first brick."""
        names = self.in_order(name for name in self.names if name not in without)
        states = self.engine.states(self.rigid_groups.watched(names))
        self._stillness.follow(self.engine.time(), states)
        return states

    def at_rest(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, Placed]:
        """Return the convex bricks at rest; none if nothing has changed since their refusal."""
        now = self.engine.time()
        if not self.announced and not self._refusals.may_judge(now):
            return {}
        resting = self._resting(now, states)
        news = any(
            brick in self.announced
            or self._refusals.has_changed(brick, placed.pose, placed.brick.shape.least_thickness, now)
            for brick, placed in resting.items()
        )
        return resting if news else {}

    def _resting(self, now: float, states: Mapping[BodyId, BodyState]) -> dict[BodyId, Placed]:
        """Return the convex bricks that have been slow for long enough; groups only if all woken bricks have."""
        slow = {brick for brick in states if self._stillness.may_be_judged(brick, now)}
        woken = [brick for brick in states if brick in self.rest_poses]
        if not slow.issuperset(woken):
            slow = {brick for brick in slow if brick not in self.rigid_groups}
        unwelded = [
            member
            for brick in self.in_order(slow)
            if brick in self.rigid_groups
            for member in self.rigid_groups.unweld(brick)
        ]
        single = [brick for brick in slow if brick not in unwelded]
        return dict(solids(self.engine, self.engine.states(self.in_order([*single, *unwelded]))))
