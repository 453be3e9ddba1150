"""The extension whose verdicts are proven: freezes what exact statics shows to stand, wakes what it shows to move.

All frozen bricks are one assembly, and the verdict on it is STABLE. Bricks that come to rest are put to the proof
together. What the verdict says moves, or cannot decide on, is left to the engine, and the rest is asked again, so that
what still stands stays frozen with a proof of its own. Assumes gravity along -z and no other forces on bricks at rest.

Statics knows boxes, fixed or not, and half-spaces. What touches anything else stays with the engine.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stability.engine import Engine
from stability.freezing import RestLimits
from stability.held_bodies import HeldBodies
from stability.model import AT_REST, EARTH, BodyId, BodyState, Box, Brick, HalfSpace, Plane, Pose, Vec3
from stability.refusals import Refusals
from stability.separation import boxes_apart, in_world
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability, Tolerances, Verdict
from stability.stillness import Stillness
from stability.watching import Update

NO_MASS = 0.0  # of what is fixed; nobody weighs it
TOUCHING = Tolerances().gap  # share of the smallest side
ON_TOP = -0.5  # z of the normal from one body towards another that it lies on


@dataclass(frozen=True, slots=True)
class _Judgement:
    """A verdict, followed until what is left is proven."""

    first: Verdict
    last: Verdict  # STABLE, of what stays
    released: Mapping[BodyId, Pose]  # what does not, and where it is
    lowest: tuple[BodyId, ...]  # of the bricks that the first verdict names the one furthest down, if there are any


@dataclass
class ProvenStability:
    """Watches the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    # The fixed bodies; None for the half-spaces and boxes among those of the engine.
    planes: Sequence[Plane] | None = None
    # Coulomb coefficient of brick on brick, and on the engine's half-spaces. If bodies differ, give the least: what
    # stands with less friction stands with more.
    friction: float = 0.5
    gravity: float = EARTH  # [m/s2]
    rest: RestLimits = field(default_factory=RestLimits)
    # Look at every frozen brick each time, and judge again what somebody else has changed. Without it, cheaper.
    guard: bool = True
    assembly: Assembly = field(init=False)
    _awake: set[BodyId] = field(default_factory=set, init=False)
    _announced: set[BodyId] = field(default_factory=set, init=False)  # set down since the last pass
    _when_changed: Verdict | None = field(default=None, init=False)  # when bricks were last set down or taken out
    _stillness: Stillness = field(init=False)
    _refusals: Refusals = field(init=False)
    _held: HeldBodies = field(init=False)

    def __post_init__(self) -> None:
        self._stillness = Stillness(self.rest)
        self._refusals = Refusals(self.rest.hold_off)
        self._held = HeldBodies(self.engine)
        self.assembly = Assembly(self.planes or (), self.friction, self.gravity)

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""
        self._notice_new()
        return sorted(self._awake)

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed, with a proof."""
        return brick in self.assembly.bricks

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Say that these bricks were set down at rest: they may be judged at once, before any step."""
        self._announced.update(bricks)
        self._awake |= self._announced
        self._stillness.set_down(self._announced)

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks were taken out of the engine: what cannot stand without them is woken at once."""
        gone = sorted(bricks)
        frozen = [brick for brick in gone if self.is_frozen(brick)]
        for brick in gone:
            self._awake.discard(brick)
            self._announced.discard(brick)
            self._held.let_go(brick)
            self._stillness.forget(brick)
            self._refusals.forget(brick)
        self._refusals.changed()
        judgement = self._followed(self.assembly.remove(frozen))
        if frozen or not self._awake:  # else nothing was asked that was not proven before
            self._when_changed = judgement.first
        woken = self._give_back(judgement.released)
        return Update((), woken, judgement.lowest, judgement.first.reason if woken else "")

    def update(self) -> Update:
        """Judge what somebody else has changed, and what has come to rest."""
        lost = self._answer_changes() if self.guard else Update()
        self._notice_new()
        now = self.engine.time()
        states = self.engine.states(sorted(self._awake))
        self._stillness.follow(now, states)
        coming = self._at_rest(now, states)
        announced, self._announced = self._announced, set()
        if not coming:
            return lost
        judgement = self._followed(self.assembly.add_all(coming))
        if announced:
            self._when_changed = judgement.first
        found = self._carry_out(judgement, [placed.brick.id for placed in coming], announced)
        return _joined(lost, found)

    def struck(self, brick: BodyId, impulse_W: Vec3) -> Update:
        """Say that a brick is about to be given an impulse [N s]: what that disturbs is woken before."""
        return Update((), self.wake([brick]), reason="struck")

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks back to the engine, and all that cannot stand without them; returns those woken."""
        bricks = [bricks] if isinstance(bricks, str) else list(bricks)
        unknown = [brick for brick in bricks if brick not in self.engine.masses()]
        if unknown:
            raise LookupError(f"the engine has no brick '{unknown[0]}'")
        asked = {brick: self.assembly.bricks[brick].pose for brick in sorted(bricks) if self.is_frozen(brick)}
        if not asked:
            return ()
        self._refusals.changed()
        judgement = self._followed(self.assembly.remove(asked))
        return self._give_back({**asked, **judgement.released})

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""
        asked = None if bricks is None else [brick for brick in bricks if self.is_frozen(brick)]
        return self.assembly.all_shares(asked)

    def least_margin(self) -> float | None:
        """None: a margin of the whole is a programme of its own, solved where somebody asks for it."""
        return None

    def verdict(self) -> Verdict | None:
        """What was proven of the structure when bricks were last set down or taken out."""
        return self._when_changed

    # --- what is put to the proof -------------------------------------------------------------------------------------

    def _notice_new(self) -> None:
        bricks = self.engine.masses()
        # Whoever shares the world with nobody may count: all else has been announced.
        if self.guard or len(bricks) != len(self._awake) + len(self.assembly.bricks):
            self._awake = bricks.keys() - self.assembly.bricks.keys()

    def _at_rest(self, now: float, states: Mapping[BodyId, BodyState]) -> list[Placed]:
        """The bricks to be put to the proof, if it is worth while."""
        if not self._announced and not self._refusals.may_ask(now):
            return []
        resting = {brick: found for brick, found in self._boxes(states) if self._stillness.may_be_judged(brick, now)}
        if not any(
            brick in self._announced or self._refusals.is_news(brick, placed.pose, min(placed.brick.size), now)
            for brick, placed in resting.items()
        ):
            return []
        return self._clear_of_strangers(resting, states)

    def _boxes(self, states: Mapping[BodyId, BodyState]) -> Iterator[tuple[BodyId, Placed]]:
        masses = self.engine.masses()
        for brick, state in states.items():
            shape = self.engine.shape(brick)
            if isinstance(shape, Box):
                yield brick, Placed(Brick(brick, shape.size, masses[brick]), state.pose)

    def _clear_of_strangers(self, resting: Mapping[BodyId, Placed], states: Mapping[BodyId, BodyState]) -> list[Placed]:
        """Those that touch nothing which statics cannot speak of: what still moves, robots, and other shapes."""
        if self.planes is not None and len(resting) == len(self._awake):
            return list(resting.values())
        tables = (table.brick.id for table in self.assembly.tables)
        known = {*self.assembly.bricks, *tables, *(plane.id for plane in self.assembly.planes)}
        strange = {brick: [other for other in self.engine.near(brick) if other not in known] for brick in resting}
        kept = dict(resting)
        while True:
            out = [b for b in kept if any(o not in kept and self._hangs_on(kept[b], o, states) for o in strange[b])]
            if not out:
                return list(kept.values())
            for brick in out:
                del kept[brick]

    def _hangs_on(self, placed: Placed, other: BodyId, states: Mapping[BodyId, BodyState]) -> bool:
        size, gap = placed.brick.size, TOUCHING * min(placed.brick.size)
        shape = self.engine.shape(other) if other in states else None
        if isinstance(shape, Box):
            apart = boxes_apart(size, placed.pose, shape.size, states[other].pose)
            # What still moves on top of a brick is a load to come: it is judged when it has come to rest.
            return apart.gap <= gap and apart.normal_BA_W[2] > ON_TOP
        contacts = self.engine.contacts(placed.brick.id)
        return any(other in (point.a, point.b) and point.gap <= gap for point in contacts)

    # --- what follows from a verdict ----------------------------------------------------------------------------------

    def _followed(self, verdict: Verdict) -> _Judgement:
        """Take out what moves or is in doubt, until what is left is proven."""
        first = verdict
        released: dict[BodyId, Pose] = {}
        lowest: tuple[BodyId, ...] = ()
        while verdict.stability is not Stability.STABLE:
            moving = verdict.moving or tuple(self.assembly.bricks)
            poses = {brick: self.assembly.bricks[brick].pose for brick in moving}
            lowest = lowest or (min(moving, key=lambda brick: (poses[brick].position_W[2], brick)),)
            released |= poses
            verdict = self.assembly.remove(moving)
        return _Judgement(first, verdict, released, lowest)

    def _carry_out(self, judgement: _Judgement, coming: Sequence[BodyId], announced: set[BodyId]) -> Update:
        frozen = tuple(brick for brick in coming if brick not in judgement.released)
        for brick in frozen:
            self._freeze(brick)
        refused = {brick: judgement.released[brick] for brick in coming if brick in judgement.released}
        if frozen or len(judgement.released) > len(refused):
            self._refusals.changed()
        self._refusals.refuse(refused.items(), self.engine.time())
        fallen = {brick: pose for brick, pose in judgement.released.items() if brick not in refused}
        woken = self._give_back(fallen) + tuple(brick for brick in refused if brick in announced)
        proof = judgement.last.stage.value if frozen and judgement.last.stage is not None else ""
        return Update(
            frozen,
            tuple(sorted(woken)),
            judgement.lowest if woken else (),
            judgement.first.reason if woken else "",
            proof,
        )

    def _freeze(self, brick: BodyId) -> None:
        self.engine.freeze(brick)
        self._awake.discard(brick)
        self._stillness.froze(brick)
        self._refusals.forget(brick)
        if self.guard:
            self._held.hold(brick)

    def _give_back(self, bricks: Mapping[BodyId, Pose]) -> tuple[BodyId, ...]:
        """Wake frozen bricks that are no longer part of the assembly."""
        for brick in bricks:
            self.engine.wake(brick)
            self._awake.add(brick)
            self._held.let_go(brick)
            self._stillness.woke(brick)
        self._refusals.refuse(bricks.items(), self.engine.time())
        return tuple(sorted(bricks))

    # --- what somebody else has changed -------------------------------------------------------------------------------

    def _answer_changes(self) -> Update:
        """Judge the frozen bricks again where they or their surroundings are not what they were."""
        lost = self._lost()
        disturbed = self._held.disturbed(self.assembly.bricks.keys() - lost)
        pushed = {brick: state.pose for brick, state in disturbed.items() if _moves(state)}
        verdict = self.assembly.remove([*lost, *pushed]) if lost or pushed else None
        for brick, state in disturbed.items():
            if brick not in pushed:
                verdict = self.assembly.move(brick, state.pose)
        planes, tables = self._fixed()
        if (planes, tables) != (self.assembly.planes, self.assembly.tables):
            standing = tuple(self.assembly.bricks.values())
            self.assembly = Assembly(planes, self.friction, self.gravity, tables=tables)
            verdict = self.assembly.add_all(standing)
        if verdict is None:
            return Update()
        self._refusals.changed()
        judgement = self._followed(verdict)
        woken = self._give_back({**pushed, **judgement.released})
        return Update((), woken, judgement.lowest, judgement.first.reason or "moved by somebody else" if woken else "")

    def _lost(self) -> list[BodyId]:
        """The frozen bricks that the engine no longer has, or no longer holds."""
        frozen, gone = self.assembly.bricks, list[BodyId]()
        if self._held.came_or_went():
            bricks = self.engine.masses()
            gone = [brick for brick in frozen if brick not in bricks]
        lost = gone + self._held.released(brick for brick in frozen if brick not in gone)
        for brick in lost:
            self._held.let_go(brick)
            self._stillness.forget(brick)
            self._refusals.forget(brick)
        return lost

    def _fixed(self) -> tuple[tuple[Plane, ...], tuple[Placed, ...]]:
        """The fixed bodies, as statics knows them: half-spaces and boxes."""
        if self.planes is not None:
            return tuple(self.planes), ()
        shapes = {body: self.engine.shape(body) for body in sorted(self.engine.fixed())}
        poses = {body: state.pose for body, state in self.engine.states(shapes).items()}
        planes = [
            replace(in_world(shape, poses[body]), id=body, friction=self.friction)
            for body, shape in shapes.items()
            if isinstance(shape, HalfSpace)
        ]
        boxes = [(body, shape) for body, shape in shapes.items() if isinstance(shape, Box)]
        return tuple(planes), tuple(Placed(Brick(body, box.size, NO_MASS), poses[body]) for body, box in boxes)


def _moves(state: BodyState) -> bool:
    return state.velocity_W != AT_REST or state.angular_velocity_W != AT_REST


def _joined(one: Update, other: Update) -> Update:
    """Two updates of one pass as one."""
    return Update(
        other.frozen,
        one.woken + tuple(brick for brick in other.woken if brick not in one.woken),
        one.failed + other.failed,
        "; ".join(filter(None, (one.reason, other.reason))),
        other.proof,
    )
