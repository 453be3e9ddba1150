"""The published method as a stabilizer: judges the bricks of an engine after each step, freezes and wakes them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stability.contact_law import GivenFriction, as_friction
from stability.engines.protocol import Engine
from stability.graph import with_all_above
from stability.model import AT_REST, BodyId, BodyState, Plane, Vec3
from stability.problem import Verdict
from stability.stabilizers.approach import about_to_hit
from stability.stabilizers.held_bodies import HeldBodies, gravity_of
from stability.stabilizers.protocol import Observers, Stabilizer, Update
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
    neighbours,
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

# Source: the stack-stability thesis, section 3.3.1: collect contacts, test the bricks that may be at rest one by one,
# add the stable ones, update the load above each brick, test the whole stack, wake failing bricks and all above them.
# Section 3.5: a brick that the base model finds unstable is tested as a leaning brick, with contact areas of its own.


SUPPORT_REMOVED = "support removed"


@dataclass
class StackStability(Stabilizer):
    """Published method on the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    rest: RestLimits = field(default_factory=RestLimits)
    contact: ContactLimits = field(default_factory=ContactLimits)
    # Whether every update also detects frozen bricks and supports that the caller has moved, and wakes the bricks on
    # them. It is slow.
    guard: bool = True
    # Coulomb coefficient of brick on brick, and on fixed bodies that are not among the planes; for leaning bricks only.
    friction: GivenFriction = 0.5
    planes: Sequence[Plane] = ()
    gravity: float | None = None  # as of ProvenStability [m/s2]; only for impacts
    readings: Readings = AS_READ  # of ambiguous published text
    stack: dict[BodyId, StackedBrick] = field(default_factory=dict, init=False)
    leaning: dict[BodyId, LeaningBrick] = field(default_factory=dict, init=False)  # leaning bricks of the stack
    loads: dict[BodyId, CarriedLoad] = field(default_factory=dict, init=False)
    in_hands: set[BodyId] = field(default_factory=set, init=False)  # bricks in hands, which are no part of the stack
    _gravity: float = field(init=False)
    _stillness: Stillness = field(init=False)
    _held: HeldBodies = field(init=False)
    _frictions: LeaningFrictions = field(init=False)
    _hits: DirectHits = field(init=False)
    _refusals: Refusals = field(init=False)  # of the leaning test, which is too slow for every step
    _observers: Observers = field(init=False)  # all of these, in this order

    def __post_init__(self) -> None:
        self._gravity = gravity_of(self.engine, self.gravity)
        self._frictions = LeaningFrictions(as_friction(self.friction), {plane.id: plane for plane in self.planes})
        self._stillness = Stillness(lambda _: self.rest)
        self._held = HeldBodies(self.engine, self._supports)
        self._hits = DirectHits(self.engine, self.rest, self.readings.second_objects)
        self._refusals = Refusals(lambda _: self.rest)
        guarded = (self._held,) if self.guard else ()
        self._observers = Observers((*guarded, self._hits, self._stillness, self._refusals))

    def awake(self) -> list[BodyId]:
        """Return the bricks that the engine moves, sorted by name."""
        not_awake = (self.stack, self.in_hands)
        return sorted(brick for brick in self.engine.masses() if not any(brick in bricks for bricks in not_awake))

    def riding(self) -> Collection[BodyId]:
        """Return no bricks: the method has no rigid groups."""
        return ()

    def is_frozen(self, brick: BodyId) -> bool:
        """Check that a brick is part of the stack."""
        return brick in self.stack

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Return each brick's load shares by support, for all bricks of the stack or some."""
        requested = self.stack if bricks is None else bricks
        return {brick: self._shares(brick) for brick in requested if brick in self.stack}

    def _shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        load = self.loads[brick]
        fractions = {share.on: share.mass / load.mass for share in shares(load, self.stack[brick].areas, self.readings)}
        return {on: fractions.get(on, 0.0) for on in sorted(self._supports(brick))}

    def _supports(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Return the bodies that a brick of the stack rests or leans on."""
        leaning = self.leaning.get(brick)
        return leaning.leans_on if leaning else self.stack[brick].rests_on

    def verdict(self) -> Verdict | None:
        """Return None: the method tests bricks one by one, without a proof of the structure."""
        return None

    def giving_way(self) -> Mapping[BodyId, str]:
        """Return no bricks, as the method has no proofs."""
        return {}

    def least_margin(self) -> float | None:
        """Return the smallest tipping margin of the resting bricks [m]; None without any. Leaning bricks have none."""
        resting = ((name, brick) for name, brick in self.stack.items() if name not in self.leaning)
        return min((tipping_margin(brick, self.loads[name]) for name, brick in resting), default=None)

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Handle bricks that were set down at rest: they may be tested immediately, before any step."""
        self._observers.set_down(list(bricks))

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Handle bricks that were removed from the engine: bricks that rested on them wake immediately."""
        removed = set(bricks)
        self._observers.removed(sorted(removed - self.stack.keys()))
        unsupported = self._drop(sorted(removed & self.stack.keys()))
        failed, woken = self._wake_failing()
        return Update((), unsupported + woken, failed, SUPPORT_REMOVED if unsupported or woken else "")

    def update(self) -> Update:
        """Run one pass of the published method after a step of the engine."""
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
        reason = f"no support for the load of {', '.join(failed)}" if failed else SUPPORT_REMOVED
        reason = blows or (reason if lost or woken else "")
        return Update(tuple(brick.id for brick, _ in added), hit + lost + woken, failed, reason)

    def struck(self, brick: BodyId, impulse_W: Vec3, offset_W: Vec3 = AT_REST) -> Update:
        """Handle an impulse [N s] that a brick is about to receive: the brick wakes before if the energy suffices."""
        if brick not in self.stack:
            return Update()
        impact = ImpactEnergy(energy_of_push(self.stack[brick].mass, impulse_W), self._energy_of_load(brick))
        return Update((), self.wake([brick]) if impact.disturbs else (), reason=f"{brick} pushed: {impact}")

    def _wake_hit(self) -> tuple[tuple[BodyId, ...], str]:
        """Wake bricks that imminent hits disturb, with all bricks on them; return the woken bricks and the reason."""
        masses = self.engine.masses()
        blows = {}
        for hit in self._hits.coming(self.awake(), self.stack):
            kinetic = energy_of_flight(masses[hit.by], hit.velocity_W)
            impact = ImpactEnergy(kinetic, self._energy_of_load(hit.brick))
            if impact.disturbs:
                blows[hit.brick] = f"{about_to_hit(hit.by, hit.brick)}: {impact}"
        return self._wake(sorted(blows)), "; ".join(blows[brick] for brick in sorted(blows))

    def _energy_of_load(self, brick: BodyId) -> float:
        return energy_of_load(brick, self.stack, self.loads, self.leaning.get(brick), self._gravity, self.readings)

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Wake these bricks and all that rest on them (section 3.3.7); return the woken bricks."""
        return self._wake([brick for brick in bricks if brick in self.stack]) + self._wake_failing()[1]

    # --- hands --------------------------------------------------------------------------------------------------------
    #
    # In the publication the engine moves a brick that a user moves: neither this brick nor the bricks on it are part of
    # the stack. Bricks that it touches wake only if it hits hard enough (section 3.6), so that a slow brick would pass
    # through the stack; here all bricks that a hand may move wake, with those on them.

    def grasp(self, brick: BodyId) -> Update:
        """Handle a hand taking a brick: it wakes with all bricks on it (section 3.3.7)."""
        woken = self.wake([brick])
        self.engine.freeze(brick)
        self.in_hands.add(brick)
        return Update((), woken, reason=f"{brick} gripped by a hand" if woken else "")

    def hold(self, bricks: Collection[BodyId]) -> Update:
        """Handle hands holding bricks: neither these nor the bricks on them are part of the stack."""
        update = Update()
        for brick in bricks:
            update = update.then(self.grasp(brick))
        return update

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Handle hands releasing bricks; `set_down` if the hands placed them: they may be tested immediately."""
        self.in_hands.difference_update(bricks)
        if set_down:
            self.set_down(bricks)
        return Update()

    def set_handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Set the bricks that hands may move: they wake, and are not tested until a later call omits them."""
        self._stillness.in_reach_of_hands = bricks
        frozen = [brick for brick in bricks if brick in self.stack]
        woken = self.wake(frozen) if frozen else ()
        return Update((), woken, reason=reason if woken else "")

    # --- judgement ----------------------------------------------------------------------------------------------------

    def _wake_failing(self) -> tuple[tuple[BodyId, ...], tuple[BodyId, ...]]:
        """Repeat the stack test until all remaining bricks pass; return the failed and the woken bricks."""
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
        """Drop bricks that the engine no longer has, and wake bricks that rested on them or on a removed fixed body."""
        if not self._held.bodies_changed():
            return ()
        bricks = self.engine.masses()
        return self._drop([brick for brick in self.stack if brick not in bricks])

    def _drop(self, removed: Collection[BodyId]) -> tuple[BodyId, ...]:
        """Remove bricks from the stack that the engine no longer holds; wake bricks that have lost a support."""
        for brick in removed:
            self._remove(brick)
        self._observers.removed(removed)
        fixed, bricks = self.engine.fixed(), self.engine.masses().keys() - removed
        # A brick may lean on a brick that was never in the stack.
        supports = {name: bricks if name in self.leaning else self.stack.keys() for name in self.stack}
        return self._wake(
            [
                name
                for name in supports
                if any(on not in fixed and on not in supports[name] for on in self._supports(name))
            ]
        )

    def _wake_disturbed(self) -> tuple[BodyId, ...]:
        """Wake frozen bricks that the caller has moved or pushed, with all bricks on them."""
        if not self.guard:
            return ()
        dropped = self._drop(self._held.released(self.stack))
        disturbed = self._held.disturbed(self.stack).keys()
        return dropped + self._wake(
            [name for name in self.stack if name in disturbed or disturbed & set(self._supports(name))]
        )

    def _newly_stable(
        self, awake: Collection[BodyId], states: Mapping[BodyId, BodyState]
    ) -> list[tuple[StackedBrick, LeaningBrick | None]]:
        """Return the slow bricks that rest stably, or lean, on the stack as it was before this pass."""
        now = self.engine.time()
        potential = [brick for brick in awake if self._stillness.may_be_judged(brick, now)]
        masses = self.engine.masses()
        supports = self.stack.keys() | self.engine.fixed()
        stable: list[tuple[StackedBrick, LeaningBrick | None]] = []
        for brick in potential:
            points = resting_points(self.engine, brick, states[brick], supports, self.contact)
            side = smallest_side(self.engine, brick)
            tested = stacked_brick(brick, masses[brick], states[brick].pose.position_W, points)
            if rests_stably(tested, side):
                stable.append((tested, None))
            elif side is not None and self._refusals.has_changed(brick, states[brick].pose, side, now):
                leaning = self._leaning(tested, side, states)
                if leaning:
                    stable.append((replace(tested, areas=(), main=()), leaning))
                else:
                    self._refusals.refuse([(brick, states[brick].pose)], now)
        return stable

    def _leaning(self, tested: StackedBrick, side: float, states: Mapping[BodyId, BodyState]) -> LeaningBrick | None:
        """Return the leaning contacts of a brick if they hold it, both bodies are slow, and one is not awake."""
        # A brick whose neighbours are all awake needs no contacts: in a large wall, nearly all bricks.
        if states.keys() >= set(neighbours(self.engine, tested.id)):
            return None
        areas = touching_areas(self.engine, tested.id, self._frictions)
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

    def _remove(self, brick: BodyId) -> None:
        """Remove a brick from the stack."""
        del self.stack[brick]
        self.leaning.pop(brick, None)

    def _wake(self, failed: Sequence[BodyId]) -> tuple[BodyId, ...]:
        woken = sorted(with_all_above({name: self._supports(name) for name in self.stack}, failed))
        for brick in woken:
            self.engine.wake(brick)
            self._remove(brick)
        self._observers.woken(woken)
        return tuple(woken)


def rests_stably(brick: StackedBrick, smallest_side: float | None) -> bool:
    """Test one brick by the base model. With two contacts of different heights it leans instead (section 3.5)."""
    if not brick.areas or not lies_above(brick.com_W[:2], brick.main):
        return False
    if len(brick.areas) != 2 or smallest_side is None:  # noqa: PLR2004
        return True
    first, second = brick.areas
    return not differ_in_height(first.points_W, second.points_W, smallest_side)


def stacked_brick(brick: BodyId, mass: float, com_W: Vec3, points: Mapping[BodyId, Sequence[Vec3]]) -> StackedBrick:
    """Return a brick with its contact areas, sorted by support; without areas if it rests on no body."""
    areas: tuple[ContactArea, ...] = tuple(contact_area(on, points[on]) for on in sorted(points))
    return StackedBrick(brick, mass, com_W, areas, main_contact(areas) if areas else ())
