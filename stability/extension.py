"""The shell: after each step of the engine, read it, judge, and write back who is frozen and who is woken.

Source: the stack-stability thesis, section 3.3.1: collect contacts, test the bricks that may be at rest one by one,
add the stable ones, update what is above each brick, test the whole stack, wake what fails and all above it.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from stability.contact import ContactArea, contact_area, main_contact
from stability.contact_graph import with_all_above
from stability.engine import Engine
from stability.freezing import RestLimits
from stability.held_bodies import HeldBodies
from stability.model import BodyId, BodyState, Vec3
from stability.resting import ContactLimits, resting_points
from stability.statics.facts import Verdict
from stability.stillness import Stillness
from stability.support import Load, StackedBrick, failing, lies_above, loads_above, shares, tipping_margin
from stability.watching import Update

SUPPORT_REMOVED = "support removed"


@dataclass
class StackStability:
    """The published method on the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    rest: RestLimits = field(default_factory=RestLimits)
    contact: ContactLimits = field(default_factory=ContactLimits)
    # Look at every frozen brick and its supports each time, and wake what somebody else has moved. Without it, cheaper.
    guard: bool = True
    stack: dict[BodyId, StackedBrick] = field(default_factory=dict, init=False)
    loads: dict[BodyId, Load] = field(default_factory=dict, init=False)
    _stillness: Stillness = field(init=False)
    _held: HeldBodies = field(init=False)

    def __post_init__(self) -> None:
        self._stillness = Stillness(self.rest)
        self._held = HeldBodies(self.engine)

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""
        return sorted(brick for brick in self.engine.masses() if brick not in self.stack)

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is part of the stack."""
        return brick in self.stack

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Which part of its load goes to each support, for every brick of the stack, or those of some."""
        asked = self.stack if bricks is None else bricks
        return {brick: self._shares(brick) for brick in asked if brick in self.stack}

    def _shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        load = self.loads[brick]
        given = {share.on: share.mass / load.mass for share in shares(load, self.stack[brick].areas)}
        return {on: given.get(on, 0.0) for on in sorted(self.stack[brick].rests_on)}

    def verdict(self) -> Verdict | None:
        """None: the method tests bricks one by one, and proves nothing of the whole."""
        return None

    def least_margin(self) -> float | None:
        """The smallest tipping margin in the stack [m]; None if the stack is empty."""
        return min((tipping_margin(brick, self.loads[name]) for name, brick in self.stack.items()), default=None)

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Say that these bricks were set down at rest: they may be tested at once, before any step."""
        self._stillness.set_down(bricks)

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks were taken out of the engine: what rested on them is woken at once."""
        gone = set(bricks)
        for brick in gone - self.stack.keys():
            self._stillness.forget(brick)
        lost = self._drop(sorted(gone & self.stack.keys()))
        failed, woken = self._wake_failing()
        return Update((), lost + woken, failed, SUPPORT_REMOVED if lost or woken else "")

    def update(self) -> Update:
        """One pass of the published method over what the engine has just done."""
        before = len(self.stack)
        lost = self._forget_removed() + self._wake_disturbed()
        awake = self.awake()
        states = self.engine.states(awake)
        self._stillness.follow(self.engine.time(), states)
        added = self._newly_stable(awake, states)
        if not added and len(self.stack) == before:
            return Update()
        self._freeze(added)
        failed, woken = self._wake_failing()
        reason = f"no support under what {', '.join(failed)} carries" if failed else SUPPORT_REMOVED
        return Update(tuple(brick.id for brick in added), lost + woken, failed, reason if lost or woken else "")

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks and all that rests on them back to the engine (section 3.3.7); returns those woken."""
        return self._wake([brick for brick in bricks if brick in self.stack]) + self._wake_failing()[1]

    def _wake_failing(self) -> tuple[tuple[BodyId, ...], tuple[BodyId, ...]]:
        """The stack test, until all that is left passes: who failed, and who was woken for it."""
        all_failed: tuple[BodyId, ...] = ()
        all_woken: tuple[BodyId, ...] = ()
        while True:
            self.loads = loads_above(self.stack)
            failed = failing(self.stack, self.loads)
            if not failed:
                return all_failed, all_woken
            all_failed += failed
            all_woken += self._wake(failed)

    def _forget_removed(self) -> tuple[BodyId, ...]:
        """Drop bricks that the engine no longer has, and wake what rested on them or on a fixed body that is gone."""
        if not self._held.came_or_went():
            return ()
        bricks = self.engine.masses()
        return self._drop([brick for brick in self.stack if brick not in bricks])

    def _drop(self, gone: Collection[BodyId]) -> tuple[BodyId, ...]:
        """Strike bricks from the stack that the engine no longer holds; wake what has lost a support."""
        for brick in gone:
            del self.stack[brick]
            self._held.let_go(brick)
            self._stillness.forget(brick)
        fixed = self.engine.fixed()
        return self._wake(
            [
                name
                for name, brick in self.stack.items()
                if any(support not in self.stack and support not in fixed for support in brick.rests_on)
            ]
        )

    def _wake_disturbed(self) -> tuple[BodyId, ...]:
        """Wake what somebody else has moved or pushed since it was frozen, and what rests on it."""
        if not self.guard:
            return ()
        dropped = self._drop(self._held.released(self.stack))
        disturbed = self._held.disturbed(self.stack).keys()
        return dropped + self._wake(
            [name for name, brick in self.stack.items() if name in disturbed or disturbed & set(brick.rests_on)]
        )

    def _newly_stable(self, awake: Collection[BodyId], states: Mapping[BodyId, BodyState]) -> list[StackedBrick]:
        """The slow bricks that rest stably on what was in the stack before this pass."""
        now = self.engine.time()
        potential = [brick for brick in awake if self._stillness.may_be_judged(brick, now)]
        masses = self.engine.masses()
        supports = self.stack.keys() | self.engine.fixed()
        found = []
        for brick in potential:
            points = resting_points(self.engine, brick, states[brick], supports, self.contact)
            if points:
                tested = stacked_brick(brick, masses[brick], states[brick].pose.position_W, points)
                if lies_above((tested.com_W[0], tested.com_W[1]), tested.main):
                    found.append(tested)
        return found

    def _freeze(self, added: Sequence[StackedBrick]) -> None:
        for brick in added:
            self.engine.freeze(brick.id)
            self.stack[brick.id] = brick
            self._stillness.froze(brick.id)
            if self.guard:
                self._held.hold(brick.id, brick.rests_on)

    def _wake(self, failed: Sequence[BodyId]) -> tuple[BodyId, ...]:
        woken = sorted(with_all_above({name: brick.rests_on for name, brick in self.stack.items()}, failed))
        for brick in woken:
            self.engine.wake(brick)
            del self.stack[brick]
            self._held.let_go(brick)
            self._stillness.woke(brick)
        return tuple(woken)


def stacked_brick(brick: BodyId, mass: float, com_W: Vec3, points: Mapping[BodyId, Sequence[Vec3]]) -> StackedBrick:
    """A brick with its contact areas, supports by name."""
    areas: tuple[ContactArea, ...] = tuple(contact_area(on, points[on]) for on in sorted(points))
    return StackedBrick(brick, mass, com_W, areas, main_contact(areas))
