"""The published method on a running engine: judges bricks after each step, freezes some and wakes others."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stability.contact_law import GivenFriction, as_friction
from stability.engines.protocol import Engine
from stability.graph import with_all_above
from stability.model import BodyId, BodyState, Plane, Vec3
from stability.problem import Verdict
from stability.stabilizers.held_bodies import HeldBodies, gravity_of
from stability.stabilizers.protocol import Observers, Update
from stability.stabilizers.published.impacts import (
    DirectHits,
    ImpactEnergy,
    energy_of_flight,
    energy_of_load,
    energy_of_push,
)
from stability.stabilizers.published.leaning import (
    LeaningBrick,
    LeaningFrictions,
    differ_in_height,
    failing_leaning,
    holds,
    leaning_brick,
    smallest_side,
    touching_areas,
)
from stability.stabilizers.published.support import (
    AS_READ,
    CarriedLoad,
    ContactArea,
    ContactLimits,
    Readings,
    StackedBrick,
    contact_area,
    failing,
    lies_above,
    loads_above,
    main_contact,
    resting_points,
    shares,
    tipping_margin,
)
from stability.stabilizers.rest import Refusals, RestLimits, Stillness

# The published method on a running engine: after each step it judges the bricks, freezes some and wakes others.
#
# Source: the stack-stability thesis, section 3.3.1: collect contacts, test the bricks that may be at rest one by one,
# add the stable ones, update what is above each brick, test the whole stack, wake what fails and all above it. Section
# 3.5: what the base model does not find stable is tested as a leaning brick, with contact areas of its own.


SUPPORT_REMOVED = "support removed"


@dataclass
class StackStability:
    """The published method on the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    rest: RestLimits = field(default_factory=RestLimits)
    contact: ContactLimits = field(default_factory=ContactLimits)
    # Whether every update also looks for frozen bricks and supports that somebody else has moved, and wakes what they
    # carry. It costs time.
    guard: bool = True
    # Coulomb coefficient of brick on brick, and on fixed bodies that are not among the planes; for leaning bricks only.
    friction: GivenFriction = 0.5
    planes: Sequence[Plane] = ()
    gravity: float | None = None  # as of ProvenStability [m/s2]; for impacts only
    readings: Readings = AS_READ  # of what the published text leaves open
    stack: dict[BodyId, StackedBrick] = field(default_factory=dict, init=False)
    leaning: dict[BodyId, LeaningBrick] = field(default_factory=dict, init=False)  # those of the stack that lean
    loads: dict[BodyId, CarriedLoad] = field(default_factory=dict, init=False)
    in_hands: set[BodyId] = field(default_factory=set, init=False)  # of somebody who moves them: no part of the stack
    _gravity: float = field(init=False)
    _stillness: Stillness = field(init=False)
    _held: HeldBodies = field(init=False)
    _surfaces: LeaningFrictions = field(init=False)
    _hits: DirectHits = field(init=False)
    _refusals: Refusals = field(init=False)  # of the leaning test, which costs too much to be done at every step
    _observers: Observers = field(init=False)  # all of these: who hears what becomes of bricks, in this order

    def __post_init__(self) -> None:
        self._gravity = gravity_of(self.engine, self.gravity)
        self._surfaces = LeaningFrictions(as_friction(self.friction), {plane.id: plane for plane in self.planes})
        self._stillness = Stillness(lambda _: self.rest)
        self._held = HeldBodies(self.engine, self._held_by)
        self._hits = DirectHits(self.engine, self.rest, self.readings.second_objects)
        self._refusals = Refusals(lambda _: self.rest)
        guarded = (self._held,) if self.guard else ()
        self._observers = Observers((*guarded, self._hits, self._stillness, self._refusals))

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""
        known = (self.stack, self.in_hands)
        return sorted(brick for brick in self.engine.masses() if not any(brick in each for each in known))

    def riding(self) -> Collection[BodyId]:
        """None: the method lets every brick that it wakes move by itself."""
        return ()

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is part of the stack."""
        return brick in self.stack

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Which part of its load goes to each support, for every brick of the stack, or those of some."""
        asked = self.stack if bricks is None else bricks
        return {brick: self._shares(brick) for brick in asked if brick in self.stack}

    def _shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        load = self.loads[brick]
        given = {share.on: share.mass / load.mass for share in shares(load, self.stack[brick].areas, self.readings)}
        return {on: given.get(on, 0.0) for on in sorted(self._held_by(brick))}

    def _held_by(self, brick: BodyId) -> tuple[BodyId, ...]:
        """What a brick of the stack rests or leans on."""
        leaning = self.leaning.get(brick)
        return leaning.leans_on if leaning else self.stack[brick].rests_on

    def verdict(self) -> Verdict | None:
        """None: the method tests bricks one by one, and proves nothing of the whole."""
        return None

    def giving_way(self) -> Mapping[BodyId, str]:
        """None, as it proves nothing."""
        return {}

    def least_margin(self) -> float | None:
        """The smallest tipping margin in the stack [m]; None if nothing rests. A leaning brick has no such margin."""
        resting = ((name, brick) for name, brick in self.stack.items() if name not in self.leaning)
        return min((tipping_margin(brick, self.loads[name]) for name, brick in resting), default=None)

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Say that these bricks were set down at rest: they may be tested at once, before any step."""
        self._observers.set_down(list(bricks))

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks were taken out of the engine: what rested on them is woken at once."""
        gone = set(bricks)
        self._observers.gone(sorted(gone - self.stack.keys()))
        lost = self._drop(sorted(gone & self.stack.keys()))
        failed, woken = self._wake_failing()
        return Update((), lost + woken, failed, SUPPORT_REMOVED if lost or woken else "")

    def update(self) -> Update:
        """One pass of the published method over what the engine has just done."""
        before = len(self.stack)
        hit, blows = self._wake_hit()
        lost = self._forget_removed() + self._wake_disturbed()
        awake = self.awake()
        states = self.engine.states(awake)
        self._stillness.follow(self.engine.time(), states)
        added = self._newly_stable(awake, states)
        if not added and len(self.stack) == before:
            return Update()
        self._freeze(added)
        failed, woken = self._wake_failing()
        reason = f"nothing holds what {', '.join(failed)} carries" if failed else SUPPORT_REMOVED
        reason = blows or (reason if lost or woken else "")
        return Update(tuple(brick.id for brick, _ in added), hit + lost + woken, failed, reason)

    def struck(self, brick: BodyId, impulse_W: Vec3) -> Update:
        """Say that a brick is about to be given an impulse [N s]: if that is enough, it is woken before."""
        if brick not in self.stack:
            return Update()
        impact = ImpactEnergy(energy_of_push(self.stack[brick].mass, impulse_W), self._energy_of_load(brick))
        return Update((), self.wake([brick]) if impact.disturbs else (), reason=f"{brick} pushed: {impact}")

    def _wake_hit(self) -> tuple[tuple[BodyId, ...], str]:
        """Wake bricks that are about to be hit hard enough, and what rests on them; returns these and the reason."""
        masses = self.engine.masses()
        blows = {}
        for hit in self._hits.coming(self.awake(), self.stack):
            kinetic = energy_of_flight(masses[hit.by], hit.velocity_W)
            impact = ImpactEnergy(kinetic, self._energy_of_load(hit.brick))
            if impact.disturbs:
                blows[hit.brick] = f"{hit.brick} hit by {hit.by}: {impact}"
        return self._wake(sorted(blows)), "; ".join(blows[brick] for brick in sorted(blows))

    def _energy_of_load(self, brick: BodyId) -> float:
        return energy_of_load(brick, self.stack, self.loads, self.leaning.get(brick), self._gravity, self.readings)

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks and all that rests on them back to the engine (section 3.3.7); returns those woken."""
        return self._wake([brick for brick in bricks if brick in self.stack]) + self._wake_failing()[1]

    def _wake_failing(self) -> tuple[tuple[BodyId, ...], tuple[BodyId, ...]]:
        """Repeat the stack test until all that is left passes; returns the bricks that failed, and those woken."""
        all_failed: tuple[BodyId, ...] = ()
        all_woken: tuple[BodyId, ...] = ()
        while True:
            self.loads = loads_above(self.stack, self.readings)
            leaning = failing_leaning(self.leaning, self.loads, self.readings)
            failed = failing(self.stack, self.loads) + leaning
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
            self._strike(brick)
        self._observers.gone(gone)
        fixed, bricks = self.engine.fixed(), self.engine.masses().keys() - gone
        # A brick may lean on one that is not in the stack, and never was.
        there = {name: bricks if name in self.leaning else self.stack.keys() for name in self.stack}
        return self._wake(
            [name for name in there if any(on not in fixed and on not in there[name] for on in self._held_by(name))]
        )

    def _wake_disturbed(self) -> tuple[BodyId, ...]:
        """Wake what somebody else has moved or pushed since it was frozen, and what rests on it."""
        if not self.guard:
            return ()
        dropped = self._drop(self._held.released(self.stack))
        disturbed = self._held.disturbed(self.stack).keys()
        return dropped + self._wake(
            [name for name in self.stack if name in disturbed or disturbed & set(self._held_by(name))]
        )

    def _newly_stable(
        self, awake: Collection[BodyId], states: Mapping[BodyId, BodyState]
    ) -> list[tuple[StackedBrick, LeaningBrick | None]]:
        """The slow bricks that rest stably on what was in the stack before this pass, or lean on it."""
        now = self.engine.time()
        potential = [brick for brick in awake if self._stillness.may_be_judged(brick, now)]
        masses = self.engine.masses()
        supports = self.stack.keys() | self.engine.fixed()
        found: list[tuple[StackedBrick, LeaningBrick | None]] = []
        for brick in potential:
            points = resting_points(self.engine, brick, states[brick], supports, self.contact)
            side = smallest_side(self.engine, brick)
            tested = stacked_brick(brick, masses[brick], states[brick].pose.position_W, points)
            if rests_stably(tested, side):
                found.append((tested, None))
            elif side is not None and self._refusals.is_news(brick, states[brick].pose, side, now):
                leaning = self._leaning(tested, side, states)
                if leaning:
                    found.append((replace(tested, areas=(), main=()), leaning))
                else:
                    self._refusals.refuse([(brick, states[brick].pose)], now)
        return found

    def _leaning(self, tested: StackedBrick, side: float, states: Mapping[BodyId, BodyState]) -> LeaningBrick | None:
        """What a brick leans on, if that holds it, neither body moves, and one of the two is no awake brick."""
        areas = touching_areas(self.engine, tested.id, self._surfaces)
        slow = [area for area in areas if area.on not in states or self.rest.slow(states[area.on])]
        if all(area.on in states for area in slow):
            return None
        leaning = leaning_brick(slow, side)
        own = CarriedLoad(tested.mass, tested.com_W[:2])
        return leaning if leaning and holds(leaning, own, self.readings) else None

    def _freeze(self, added: Collection[tuple[StackedBrick, LeaningBrick | None]]) -> None:
        for brick, leaning in added:
            self.engine.freeze(brick.id)
            self.stack[brick.id] = brick
            if leaning:
                self.leaning[brick.id] = leaning
        self._observers.frozen([brick.id for brick, _ in added])

    def _strike(self, brick: BodyId) -> None:
        """Take a brick out of the stack."""
        del self.stack[brick]
        self.leaning.pop(brick, None)

    def _wake(self, failed: Sequence[BodyId]) -> tuple[BodyId, ...]:
        woken = sorted(with_all_above({name: self._held_by(name) for name in self.stack}, failed))
        for brick in woken:
            self.engine.wake(brick)
            self._strike(brick)
        self._observers.woken(woken)
        return tuple(woken)


def rests_stably(brick: StackedBrick, smallest_side: float | None) -> bool:
    """The base test of one brick. Section 3.5: if its two contacts differ in height, it leans, and does not rest."""
    if not brick.areas or not lies_above(brick.com_W[:2], brick.main):
        return False
    if len(brick.areas) != 2 or smallest_side is None:  # noqa: PLR2004
        return True
    one, other = brick.areas
    return not differ_in_height(one.points_W, other.points_W, smallest_side)


def stacked_brick(brick: BodyId, mass: float, com_W: Vec3, points: Mapping[BodyId, Sequence[Vec3]]) -> StackedBrick:
    """A brick with its contact areas, supports by name; without any if it rests on nothing."""
    areas: tuple[ContactArea, ...] = tuple(contact_area(on, points[on]) for on in sorted(points))
    return StackedBrick(brick, mass, com_W, areas, main_contact(areas) if areas else ())


# The published method where hands take bricks, move them, hold them and let them go.
#
# In the publication a brick that a user moves is one that the engine moves: it is no part of the stack, and nothing
# that rests or leans on it is. What it touches is woken only if it hits hard enough (section 3.6), so that a brick
# which is moved slowly would pass through the stack; here all that a hand may move is woken, and what rests on that.


@dataclass
class HandledStack(StackStability):
    """The published method on the bricks of one engine some of which may be in hands; see `StackStability`."""

    def taken(self, brick: BodyId) -> Update:
        """Say that a hand takes a brick: what rests on it is woken with it (section 3.3.7)."""
        woken = self.wake([brick])
        self.engine.freeze(brick)
        self.in_hands.add(brick)
        return Update((), woken, reason=f"{brick} taken by a hand" if woken else "")

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Say that hands hold bricks: what is in a hand is no part of the stack, so what rests on it is not either."""
        found = Update()
        for brick in bricks:
            found = found.then(self.taken(brick))
        return found

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Say that hands let bricks go; what they brought may be tested at once."""
        self.in_hands.difference_update(bricks)
        if set_down:
            self.set_down(bricks)
        return Update()

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Say which bricks hands may move: they are woken, and not tested while they are named."""
        self._stillness.handled = bricks
        frozen = [brick for brick in bricks if brick in self.stack]
        woken = self.wake(frozen) if frozen else ()
        return Update((), woken, reason=reason if woken else "")
