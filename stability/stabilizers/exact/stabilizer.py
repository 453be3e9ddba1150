"""Exact stabilizer: freezes bricks that statics proves to stand, and wakes those that it proves to fall."""

from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import ClassVar, Self

from stability.contact_law import GivenFriction
from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import AcceptsForces, Engine, RecordsSteps, WeldingEngine
from stability.geometry.vectors import cross, norm, scale
from stability.joints import DRY, Joints
from stability.loads import UNLOADED, LoadCourse
from stability.model import AT_REST, BodyId, BodyState, Plane, Pose, Vec3
from stability.name_order import names_text
from stability.problem import Placed, Stability, Stage, Tolerances, Verdict
from stability.stabilizers.exact.awake_bricks import AwakeBricks
from stability.stabilizers.exact.candidates import (
    Judgement,
    fixed_bodies,
    judgeable_bricks,
    release_until_stable,
    solids,
)
from stability.stabilizers.exact.dozing import Dozing
from stability.stabilizers.exact.hits import Disturbance, Disturbances, UnionContainer, hit_by_bricks, is_level
from stability.stabilizers.exact.joined_bricks import JoinedBricks, Overload
from stability.stabilizers.exact.shaking import ROUNDING, HeldPart, Shaking
from stability.stabilizers.exact.woken_region import DeadLoads, RigidGroups, region, wake
from stability.stabilizers.held_bodies import HeldBodies, gravity_of
from stability.stabilizers.protocol import Observers, Stabilizer, Update
from stability.stabilizers.rest import LimitsBySize, RestLimits
from stability.statics.assembly import Assembly
from stability.statics.opened_joints import Pair, held_pairs
from stability.strength import Strength
from stability.ties import Tie

# Factors on an acceleration of the ground at the end of what joined bricks are proven to bear, until they yield.
BEYOND = (1.0, 1.0001, 1.001, 1.01)

NO_LOADS = LoadCourse(UNLOADED, UNLOADED)
# Shares of a course of loads by which they exceed what is borne, until a proof wakes bricks.
AHEAD = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)

# Judgement of the frozen bricks after the caller has moved, pushed or removed some, or changed the fixed bodies.


@dataclass(frozen=True, slots=True)
class FixedBodies:
    """The fixed bodies of a world."""

    planes: Sequence[Plane]
    tables: Sequence[Placed]


@dataclass(frozen=True, slots=True)
class ChangedAssembly:
    """Assembly after external changes."""

    assembly: Assembly  # a new one if the fixed bodies have changed
    verdict: Verdict | None  # None without changes
    pushed: Mapping[BodyId, Pose]  # moving bricks, which were removed from the assembly


def changed(
    assembly: Assembly, lost: Collection[BodyId], disturbed: Mapping[BodyId, BodyState], fixed: FixedBodies
) -> ChangedAssembly:
    """Remove lost and pushed bricks from an assembly, move displaced ones, and update its fixed bodies."""
    pushed = {brick: state.pose for brick, state in disturbed.items() if _moves(state)}
    verdict = assembly.remove([*lost, *pushed]) if lost or pushed else None
    for brick, state in disturbed.items():
        if brick not in pushed:
            verdict = assembly.move(brick, state.pose)
    if (tuple(fixed.planes), tuple(fixed.tables)) != (assembly.planes, assembly.tables):
        standing = tuple(assembly.bricks.values())
        assembly = Assembly(
            fixed.planes,
            assembly.friction,
            assembly.gravity,
            assembly.tolerances,
            fixed.tables,
            overlap=inf,
            joints=assembly.joints,
            loads=assembly.loads,
            strengths=assembly.strengths,
            ties=assembly.ties,
        )
        verdict = assembly.add_all(standing)
    return ChangedAssembly(assembly, verdict, pushed)


def _moves(state: BodyState) -> bool:
    return state.velocity_W != AT_REST or state.angular_velocity_W != AT_REST


# All frozen bricks form one assembly with the verdict STABLE. Bricks that come to rest are judged together with it.
# The engine moves the bricks that the verdict names as moving or undecided, and the others are judged again, so that
# the frozen bricks always have a proof of their own. Assumes gravity along -z and no other forces on bricks at rest.
# Statics supports convex solids, fixed or not, and half-spaces. A brick that touches another shape stays with the
# engine.


@dataclass
class ProvenStability(Stabilizer):
    """Exact stabilizer of the bricks of one engine. Call `update` after each of its steps."""

    proves: ClassVar[bool] = True

    engine: Engine
    # The fixed bodies; None: the half-spaces and convex solids that are fixed in the engine.
    planes: Sequence[Plane] | None = None
    # Coulomb coefficient of brick on brick, and on the engine's half-spaces; a `Friction` if bodies differ.
    friction: GivenFriction = 0.5
    gravity: float | None = None  # along -z [m/s2]; None: that of the engine, or of the Earth if it does not report it
    rest: RestLimits = field(default_factory=RestLimits)  # for planks of 8 mm, scaled to other bricks by size
    # Whether every update also detects frozen bricks that the caller has moved, and judges them again. It is slow.
    guard: bool = True
    # Welds riding bricks into one rigid body; None: all bricks move one by one.
    joiner: WeldingEngine | None = None
    # Applies the loads of frozen bricks to woken ones; None: bricks carried by woken ones wake too.
    presser: AcceptsForces | None = None
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen
    joints: Joints = DRY
    strengths: Mapping[BodyId, Strength] = field(default_factory=dict)  # against crushing, at rest only
    ties: Sequence[Tie] = ()  # at rest only
    # Repeats steps in which joints open; None: joints of bricks in motion hold until these come to rest.
    recorder: RecordsSteps | None = None
    assembly: Assembly = field(init=False)
    _course: LoadCourse = field(default=NO_LOADS, init=False)
    _parted: frozenset[Pair] = field(default=frozenset(), init=False)  # ductile joints that opened in the last step
    _bears_until: float = field(default=inf, init=False)  # the frozen bricks, under loads that change [s]
    _in_hands: dict[BodyId, Placed | None] = field(default_factory=dict, init=False)  # with its pose if held at rest
    _shaking: Shaking = field(init=False)
    _awake: AwakeBricks = field(init=False)
    _verdict: Verdict | None = field(default=None, init=False)  # when bricks were last set down or removed
    _held: HeldBodies = field(init=False)
    _rigid_groups: RigidGroups = field(init=False)
    _dead_loads: DeadLoads = field(init=False)
    _dozing: Dozing = field(init=False)
    _joined: JoinedBricks = field(init=False)
    _disturbances: Disturbances = field(init=False)
    _observers: Observers = field(init=False)  # all of these, in this order

    def __post_init__(self) -> None:
        gravity = gravity_of(self.engine, self.gravity)
        self._shaking = Shaking(self.engine)
        self._held = HeldBodies(self.engine)
        self._rigid_groups = RigidGroups(self.joiner)
        self._dead_loads = DeadLoads(self.engine, self.presser)
        limits_of = LimitsBySize(self.engine, self.rest)
        self._dozing = Dozing(self.engine, limits_of, self._dead_loads, self.friction, gravity, self.tolerances)
        self._awake = AwakeBricks(self.engine, limits_of, self._rigid_groups)
        self._joined = JoinedBricks(self.engine, self.joiner, self.joints, self.recorder)
        self._disturbances = Disturbances(self.engine, limits_of, gravity, self._dead_loads.reactions, self._joined)
        guarded = (self._held,) if self.guard else ()
        self._observers = Observers(
            (
                *guarded,
                self._dozing,
                limits_of,
                self._rigid_groups,
                self._joined,
                self._dead_loads,
                self._disturbances,
                self._awake,
            )
        )
        if self.recorder is not None:
            self.recorder.record_steps()
        self.assembly = Assembly(
            self.planes or (),
            self.friction,
            gravity,
            self.tolerances,
            overlap=inf,
            joints=self.joints,
            strengths=self.strengths,
            ties=self.ties,
        )

    def awake(self) -> list[BodyId]:
        """Return the bricks that the engine moves, sorted by name."""
        self._notice_bricks()
        return sorted(name for name in self._awake.names if name not in self._dozing)

    def riding(self) -> Collection[BodyId]:
        """Return the awake bricks that move in rigid groups on others, or in bodies with others."""
        return self._rigid_groups.bricks.union(*(body.names[1:] for body in self._joined.bodies))

    def is_frozen(self, brick: BodyId) -> bool:
        """Check that a brick is frozen, with a proof."""
        return brick in self.assembly.bricks

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Handle bricks that were set down at rest: they may be judged immediately, before any step."""
        self._observers.set_down(list(bricks))

    def landed(self, bricks: Iterable[BodyId]) -> Update:
        """Judge bricks that have come to rest, as if they were set down."""
        resting = self._judgeable(dict(solids(self.engine, self.engine.states(self._awake.in_order(bricks)))))
        if not resting:
            return Update()
        judgement = self._judge(resting, set(), names_smallest=False)
        return self._apply(judgement, [placed.brick.id for placed in resting], set())

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Handle bricks that were removed from the engine: bricks that cannot stand without them wake immediately."""
        removed = sorted(bricks)
        for brick in removed:
            self._joined.let_go(brick)
        frozen = [brick for brick in removed if self.is_frozen(brick)]
        self._observers.removed(removed)
        judgement = release_until_stable(self.assembly, self.assembly.remove(frozen))
        if frozen or not self._awake.names:  # otherwise no verdict has changed
            self._verdict = judgement.first
        woken = self._wake_released(judgement)
        reason = judgement.first.reason if woken else ""
        return self._without_ductile(Update((), woken, judgement.lowest, reason, opened=judgement.opened))

    def rejoined(self, joints: Joints) -> Update:
        """Handle other joints of all bricks: bricks that cannot stand with them wake immediately."""
        self._dozing.wake()
        self.joints, self.assembly = joints, self.assembly.with_joints(self._joined.with_rules(joints.rules))
        self._joined.rejoined(self.assembly)
        judgement = release_until_stable(self.assembly, self.assembly.verdict())
        self._verdict = judgement.first
        woken = self._wake_released(judgement)
        reason = judgement.first.reason if woken else ""
        return self._without_ductile(Update((), woken, judgement.lowest, reason, opened=judgement.opened))

    def loaded(self, course: LoadCourse) -> Update:
        """Handle other loads on bricks: bricks that cannot stand under them wake immediately, or when they cannot."""
        self._dozing.wake()
        self._course = course
        update = self._under_loads(self.engine.time())
        self._bears_until = self._borne_until()
        return update

    def _under_loads(self, time: float) -> Update:
        """Judge the frozen bricks under the loads at a time [s]."""
        loads = self._dead_loads.applied = self._course.at(time)
        self.assembly = self.assembly.with_loads(loads)
        judgement = release_until_stable(self.assembly, self.assembly.verdict())
        self._verdict = judgement.first
        woken = self._wake_released(judgement)
        self._dead_loads.woken(self._awake.names)
        self._dead_loads.exert()
        reason = f"under its loads, {judgement.first.reason}" if woken else ""
        return self._without_ductile(Update((), woken, judgement.lowest, reason, opened=judgement.opened))

    def moves_under_loads(self) -> bool:
        """Return whether loads act on bricks in motion."""
        return self._dead_loads.are_applied

    def needs_engine(self) -> bool:
        """Return whether loads, or joints that have yielded, act on bricks in motion."""
        return self._dead_loads.are_applied or bool(self._joined.links)

    def _borne_until(self) -> float:
        """Return the time until which all frozen bricks are proven to stand under loads that change [s]."""
        now = self.engine.time()
        if now >= self._course.ends:
            return inf
        from stability.analysis.load_factor import borne_until  # noqa: PLC0415 -- it brings numpy

        return borne_until(self.assembly, self._course, now)

    def _wake_loaded(self) -> Update:
        """Apply the loads of now, and wake the bricks that no longer bear them."""
        now = self.engine.time()
        if self._bears_until == inf and not self._dead_loads.are_applied:
            return Update()
        if now + ROUNDING < self._bears_until:
            self._dead_loads.applied = self._course.at(now)
            return Update()
        span, until = self._course.ends - self._course.begins, self._bears_until
        for ahead in AHEAD:
            update = self._under_loads(until + ahead * span)
            if update.woken:
                self._bears_until = self._borne_until()
                return update
        self._bears_until = max(self._borne_until(), now + AHEAD[-1] * span)
        return Update()

    def update(self) -> Update:
        """Judge external changes, disturbances, bricks that have come to rest, and the motion of the ground."""
        if self._shaking.has_just_ended():
            self._awake.allow_judgement()  # for bricks woken by the ground alone, or refused while others moved
        update = self._wake_shaken(self._wake_loaded().then(self._update_at_rest()))
        update, self._parted = replace(update, opened=update.opened | self._parted), frozenset()
        return self._without_ductile(update)

    def _update_at_rest(self) -> Update:
        """Judge as if the ground were at rest."""
        lost = self._judge_changes() if self.guard else Update()
        self._notice_bricks()
        states = self._awake.follow(without=self._dozing)
        self._dozing.wake(self._dozing.disturbed(states))
        lost = lost.then(self._wake_disturbed(states))
        if self._dozing and all(self._awake.is_slow(brick) for brick in states):
            self._dozing.wake()  # nothing moves, so that all are judged together
        resting = self._judgeable(self._awake.at_rest(states))
        announced = self._awake.clear_announced()
        if not resting:
            self._let_doze(states)
            self._dead_loads.exert()
            return lost
        # The smallest falling set is of no interest in a heap that has fallen.
        judgement = self._judge(resting, announced, names_smallest=bool(announced))
        if announced:
            self._verdict = judgement.first
        judged = self._apply(judgement, [placed.brick.id for placed in resting], announced)
        self._dead_loads.exert()
        return lost.then(judged)

    def _let_doze(self, states: Mapping[BodyId, BodyState]) -> None:
        """Let the engine hold bricks that have been at rest for a while on others that are at rest without a proof."""
        simple = self.presser is not None and not (
            self._in_hands or self._shaking.shakes or self.joints.rules or self._rigid_groups.bricks
        )
        if not simple or self.moves_under_loads() or not self._dozing.is_due(states.keys()):
            return
        self._dozing.wake(self._dozing.touched_anew(states))
        rested = {name: state for name, state in states.items() if self._awake.has_rested(name, state)}
        moving = {name for name in states if not self._awake.is_slow(name)}
        if rested and moving:
            fixed = self._fixed_bodies()
            resting = [placed for _, placed in solids(self.engine, rested)]
            self._dozing.fall_asleep(resting, moving, fixed.planes, fixed.tables)

    def _judge(self, resting: Sequence[Placed], announced: Container[BodyId], names_smallest: bool) -> Judgement:
        """Judge bricks with crept ones put back to their rest poses; if they do not stand, judge the actual poses."""
        self._joined.arrived([placed for placed in resting if placed.brick.id not in announced], self.assembly)
        self._joined.hold_again([placed.brick.id for placed in resting], self.assembly)
        restored = self._awake.rest_poses.put_back(resting)
        verdict = self.assembly.add_all(restored, names_smallest=names_smallest)
        moved_back = [placed for placed, actual in zip(restored, resting, strict=True) if placed is not actual]
        if moved_back and verdict.stability is not Stability.STABLE:
            self.assembly.remove([placed.brick.id for placed in resting], names_smallest=names_smallest)
            moved_back, verdict = [], self.assembly.add_all(resting, names_smallest=names_smallest)
        judgement = release_until_stable(self.assembly, verdict, names_smallest=names_smallest)
        while split := self._joined.split_by(judgement.released, self.assembly.bricks):
            # A body of joined bricks stands or moves as a whole.
            released = {**judgement.released, **{name: self.assembly.bricks[name].pose for name in split}}
            more = release_until_stable(self.assembly, self.assembly.remove(split), names_smallest=names_smallest)
            held = judgement.held | more.held
            judgement = replace(judgement, last=more.last, released={**released, **more.released}, held=held)
        self._joined.yield_again(judgement.released, self.assembly)
        for placed in moved_back:
            self.engine.freeze(placed.brick.id)
            self.engine.put_at(placed.brick.id, placed.pose)
        return judgement

    def struck(self, brick: BodyId, impulse_W: Vec3, offset_W: Vec3 = AT_REST) -> Update:
        """Handle an impulse [N s] that a brick is about to receive, at an offset from its centre [m].

        Bricks that it disturbs wake before.
        """
        self._dozing.wake([brick])
        if brick in self._joined or self._joined.is_in_structure(brick, self.assembly):
            return self._strike_joined(brick, impulse_W, offset_W)
        if brick in self._rigid_groups:
            self._rigid_groups.unweld(brick)  # even a gentle push moves one brick and not its group
        speed = norm(impulse_W) / self.engine.masses()[brick]
        if speed < self._disturbances.least_push(brick) or not self.is_frozen(brick):
            return Update()
        along_W = scale(1.0 / norm(impulse_W), impulse_W)
        return self._wake_struck(Disturbance({brick: along_W}, f"{brick} pushed to {speed:.3g} m/s"))

    # --- joined bricks ------------------------------------------------------------------------------------------------

    def about_to_step(self) -> None:
        """Weld the bricks that joints hold together for the next step of the engine."""
        self._joined.weld()

    def moved_without_engine(self) -> None:
        """Handle a motion without the engine, in which all bricks move one by one."""
        self._joined.unwelded()

    def opened(self) -> Update | None:
        """Open the joints that did not bear the loads of the last step, and take the step back; None if all did."""
        if not self.joints.rules or self.recorder is None:
            return None
        means = self.recorder.mean_loads()
        opening = self._joined.opening(means)
        overloads = self._joined.overloads(means, self.assembly, self._shaking.acceleration_W())
        if not opening and not overloads:
            self._parted |= self._joined.parted()
            return None
        by = {name for name in self._awake.names if name in means}
        self.recorder.undo_step()
        for body, pairs in opening:
            self._joined.open(body, pairs, self.assembly)
        update = self._wake_overloaded(overloads, tuple(sorted(by)))
        self._joined.weld()
        return self._without_ductile(replace(update, opened=update.opened.union(*(pairs for _, pairs in opening))))

    def _without_ductile(self, update: Update) -> Update:
        """Return an update without the joints that yield, and do not open yet."""
        return replace(update, opened=frozenset(p for p in update.opened if not self._joined.is_ductile(p)))

    def _wake_overloaded(
        self, overloads: Sequence[Overload], by: tuple[BodyId, ...] = (), *, returns: bool = True
    ) -> Update:
        """Wake the frozen bricks that loads move; if they hardly move, they may return to their places."""
        update = Update()
        for overload in overloads:
            moving, held = overload.moving, held_pairs(overload.problem, overload.motion)
            requested = {brick: self.assembly.bricks[brick].pose for brick in moving}
            judgement = release_until_stable(self.assembly, self.assembly.remove(moving))
            poses = {**requested, **judgement.released}
            if returns:
                self._awake.rest_poses.remember(poses, set(overload.loaded) & poses.keys())
            self._wake(sorted(poses))
            self._release_joined(poses, judgement.held | held, passes=True)
            reason = f"the load on {names_text(overload.loaded)} is more than the joints and contacts bear"
            opened = judgement.opened | (overload.joined_with(moving) - held)
            update = update.then(Update((), tuple(sorted(poses)), reason=reason, by=by, opened=opened))
        return update

    def _strike_joined(self, brick: BodyId, impulse_W: Vec3, offset_W: Vec3) -> Update:
        """Open the joints that do not bear an impulse on a brick during a time step."""
        duration = self.recorder.hit_duration() if self.recorder is not None else 1.0
        wrench = (*scale(1.0 / duration, impulse_W), *scale(1.0 / duration, cross(offset_W, impulse_W)))
        update = self._wake_overloaded(self._joined.overloads({brick: wrench}, self.assembly))
        while opening := self._joined.opening({brick: wrench}):
            for body, pairs in opening:
                self._joined.open(body, pairs, self.assembly)
                update = replace(update, opened=update.opened | pairs)
        self._joined.weld()
        return self._without_ductile(update)

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Wake these bricks and all that cannot stand without them; return the woken bricks."""
        bricks = [bricks] if isinstance(bricks, str) else list(bricks)
        unknown = [brick for brick in bricks if brick not in self.engine.masses()]
        if unknown:
            raise LookupError(f"the engine has no brick '{unknown[0]}'")
        requested = {brick: self.assembly.bricks[brick].pose for brick in sorted(bricks) if self.is_frozen(brick)}
        if not requested:
            return ()
        held = held_pairs(self.assembly.problem(requested), None) if self.joints.rules else set()
        judgement = release_until_stable(self.assembly, self.assembly.remove(requested))
        released = {**requested, **judgement.released}
        return self._wake_released(replace(judgement, released=released, held=judgement.held | held))

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Return each frozen brick's load shares by support, for all frozen bricks or some."""
        frozen = None if bricks is None else [brick for brick in bricks if self.is_frozen(brick)]
        return self.assembly.all_shares(frozen)

    def least_margin(self) -> float | None:
        """Return None: margins of an assembly are separate programs, solved on request."""
        return None

    def proven(self) -> Assembly:
        """Return the assembly of the frozen bricks, with their proofs."""
        return self.assembly

    def verdict(self) -> Verdict | None:
        """Return the verdict on the structure after bricks were last set down or removed."""
        return self._verdict

    def giving_way(self) -> Mapping[BodyId, str]:
        """Return the reasons why awake bricks cannot stand, after the last change or at their current poses."""
        verdict = self._verdict
        reasons: dict[BodyId, str] = {}
        if verdict is not None and verdict.motion is not None:
            reasons |= dict.fromkeys(verdict.motion.velocity, verdict.reason)
        before = self.assembly.state()
        try:
            awake = dict(solids(self.engine, self.engine.states(self._awake.in_order(self._awake.names))))
            verdict = self.assembly.add_all(awake.values(), names_smallest=False)
            while verdict.stability is Stability.UNSTABLE:
                reasons |= dict.fromkeys(verdict.moving, verdict.reason)
                verdict = self.assembly.remove(verdict.moving, names_smallest=False)
        finally:
            self.assembly.restore(before)
        return {name: reason for name, reason in reasons.items() if name in self._awake.names}

    # --- hands --------------------------------------------------------------------------------------------------------
    #
    # A brick in a hand is not judged. While it moves, no brick on it is proven. At rest it carries like the ground, as
    # the force of a hand is unlimited (docs/design/hands-and-shaking.md).

    def grasp(self, brick: BodyId) -> Update:
        """Handle a hand taking a brick: bricks that cannot stand without it wake."""
        woken: tuple[BodyId, ...] = ()
        if brick in self._rigid_groups:
            self._rigid_groups.unweld(brick)
        if len(joined := self._joined.joined_to(brick, self.assembly)) > 1:
            woken = self.wake(joined)  # they come along
            states = self.engine.states([name for name in woken if name != brick])
            self._awake.rest_poses.store_driven({name: state.pose for name, state in states.items()})
        elif self.is_frozen(brick):
            judgement = release_until_stable(self.assembly, self.assembly.remove([brick]))
            woken = self._wake_released(judgement)
            self._awake.rest_poses.store_driven(judgement.released)
        self._joined.take(brick)
        self._observers.removed([brick])
        self._in_hands[brick] = None
        return Update((), woken, reason=f"{brick} gripped by a hand" if woken else "")

    def hold(self, bricks: Collection[BodyId]) -> Update:
        """Handle bricks that hands hold at rest: they carry like the ground."""
        self.assembly.remove([brick for brick in bricks if self.is_frozen(brick)])
        new = [brick for brick in bricks if brick not in self._in_hands]
        for brick in new:
            self._joined.take(brick)
        self._observers.removed(new)
        along = [name for brick in bricks for name in self._joined.put_down(brick) if name not in bricks]
        self._in_hands |= dict(solids(self.engine, self.engine.states(sorted(bricks))))
        return self._judge_again([placed for _, placed in solids(self.engine, self.engine.states(along))])

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Handle hands releasing bricks: those held at rest are judged immediately, with the bricks on them."""
        for brick in bricks:
            self._joined.let_go(brick)
        resting = [placed for brick in sorted(bricks) if (placed := self._in_hands.pop(brick)) is not None]
        if set_down or resting:
            self.set_down(bricks)
        if not resting:
            return Update()
        self._awake.clear_announced()
        return self._judge_again(resting)

    def set_handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Set the bricks that hands may move: they wake, and are not judged until a later call omits them."""
        self._dozing.wake(bricks)
        self._awake.set_handled(bricks)
        for brick in bricks:
            if brick in self._rigid_groups:
                self._rigid_groups.unweld(brick)
        woken = self.wake([brick for brick in bricks if self.is_frozen(brick)])
        self._awake.rest_poses.store_driven({brick: s.pose for brick, s in self.engine.states(woken).items()})
        return Update((), woken, reason=reason if woken else "")

    def _judge_again(self, added: Sequence[Placed]) -> Update:
        """Judge all frozen bricks and `added` on the ground and the bricks that hands hold at rest."""
        tables = [placed for placed in self._in_hands.values() if placed is not None]
        planes = self.planes if self.planes is not None else fixed_bodies(self.engine, self.friction)[0]
        standing = tuple(self.assembly.bricks.values())
        site = planes, self.friction, self.assembly.gravity, self.tolerances, tables
        joints, loads, strengths = self._joined.joints, self.assembly.loads, self.strengths
        self.assembly = Assembly(*site, overlap=inf, joints=joints, loads=loads, strengths=strengths, ties=self.ties)
        judgement = release_until_stable(self.assembly, self.assembly.add_all([*standing, *added]))
        self._verdict = judgement.first
        names = [placed.brick.id for placed in added]
        return self._apply(judgement, names, set(names))

    # --- shaking ground -----------------------------------------------------------------------------------------------

    def shaken(self, motion: GroundMotion) -> None:
        """Set the motion of the ground."""
        self._dozing.wake()
        self._shaking.begin(motion)

    def holds_until(self) -> float:
        """Return the time until which all frozen bricks provably move with the ground [s]; inf if to the end."""
        return min([self._bears_until, *(held.until for held in self._shaking.held_parts(self.assembly))])

    def _wake_shaken(self, update: Update) -> Update:
        """Wake bricks whose proven range the ground acceleration leaves, and add them to an update."""
        now = self.engine.time()
        shaken = [held for held in self._shaking.held_parts(self.assembly) if held.until <= now + ROUNDING]
        if not shaken:
            return update
        for held in shaken:
            joined = (
                self._wake_joined_parts(held) if self._joined.is_in_structure(min(held.bricks), self.assembly) else None
            )
            own = joined or Update((), self.wake(held.bricks))
            reasons = dict.fromkeys(filter(None, (update.reason, held.reason)))
            woken, opened = (*update.woken, *own.woken), update.opened | own.opened
            update = replace(update, woken=woken, reason="; ".join(reasons), by=(), opened=opened)
        return update

    def _wake_joined_parts(self, held: HeldPart) -> Update | None:
        """Wake only those joined bricks that the acceleration of the ground moves; None if these are not known."""
        x, y, z = self._shaking.acceleration_W()
        nothing = dict.fromkeys(held.bricks, (0.0,) * 6)
        for factor in BEYOND:
            ground_W = (factor * x, factor * y, factor * z)
            if overloads := self._joined.overloads(nothing, self.assembly, ground_W):
                return self._wake_overloaded(overloads, returns=False)
        return None

    # --- merging islands ----------------------------------------------------------------------------------------------

    def absorb(self, other: Self) -> None:
        """Take over the bricks of another stabilizer, which are in this one's engine already.

        A proof stays valid beside other bricks that its bricks do not touch.
        """
        self._observers.absorb(other._observers)
        self.assembly.hold_by(self._joined.joints)
        standing = [other.assembly.bricks[name] for name in sorted(other.assembly.bricks)]
        if standing:
            self._wake_released(release_until_stable(self.assembly, self.assembly.add_all(standing)))

    # --- selection of bricks to judge ---------------------------------------------------------------------------------

    def _notice_bricks(self) -> None:
        bricks = self.engine.masses()
        apart = self._in_hands.keys()
        # Without a guard all additions are announced, so counting suffices.
        if self.guard or len(bricks) != len(self._awake.names) + len(self.assembly.bricks) + len(apart):
            self._awake.notice([name for name in bricks if name not in apart], self.assembly.bricks.keys())

    def _judgeable(self, resting: Mapping[BodyId, Placed]) -> list[Placed]:
        """Return the resting bricks that touch only bodies that statics supports.

        On shaking ground return all awake bricks once all are at rest: a moving brick shakes its support as well.
        Return none while loads change.
        """
        if resting and self.engine.time() < self._course.ends:
            return []
        judgeable = self._joined.whole(self._on_supported_bodies(resting))
        return judgeable if not self._shaking.shakes or len(judgeable) == len(self._awake.names) else []

    def _on_supported_bodies(self, resting: Mapping[BodyId, Placed]) -> list[Placed]:
        if not resting:
            return []
        if self.planes is not None and len(resting) == len(self._awake.names):
            return list(resting.values())
        tables = (table.brick.id for table in self.assembly.tables)
        supported = {*self.assembly.bricks, *tables, *(plane.id for plane in self.assembly.planes)}
        clear = judgeable_bricks(
            self.engine, resting, supported, self.engine.states(self._awake.in_order(self._awake.names))
        )
        if not clear:
            self._awake.wait()
        return clear

    # --- effects of a verdict -----------------------------------------------------------------------------------------

    def _apply(self, judgement: Judgement, resting: Sequence[BodyId], announced: set[BodyId]) -> Update:
        frozen = tuple(brick for brick in resting if brick not in judgement.released)
        for brick in frozen:
            self.engine.freeze(brick)
        self._observers.frozen(frozen)
        refused = {brick: judgement.released[brick] for brick in resting if brick in judgement.released}
        fallen = {brick: pose for brick, pose in judgement.released.items() if brick not in refused}
        new = [brick for brick in refused if brick in announced]
        woken = (*self._wake_released(replace(judgement, released=fallen), new), *new)
        self._awake.refuse(refused)
        # If the bricks were proven before others were released, the last verdict has no stage.
        stages = {judgement.last.stage} if judgement.last.stage else {self.assembly.stage(brick) for brick in frozen}
        proof = next((stage.value for stage in reversed(Stage) if frozen and stage in stages), "")
        update = Update(
            frozen,
            tuple(sorted(woken)),
            judgement.lowest if woken else (),
            judgement.first.reason if woken else "",
            proof,
            opened=frozenset(pair for pair in judgement.opened if not pair.isdisjoint(woken)),
        )
        return self._without_ductile(update)

    def _wake_disturbed(self, states: Mapping[BodyId, BodyState]) -> Update:
        """Wake bricks that are about to be hit or that yield to loads; unweld groups that are hit or moved too far."""
        if not states:
            return Update()
        for first in self._rigid_groups.moved_too_far(states):
            self._rigid_groups.unweld(first)
        update = Update()
        # Flights are followed even without bricks at rest, so that distant bricks do not affect the result.
        nothing_still = not self.assembly.bricks and not self._rigid_groups.bricks and not self._dozing
        frozen = UnionContainer(self.assembly.bricks, self._dozing)
        still = () if nothing_still else UnionContainer(frozen, self._rigid_groups)
        hits = self._disturbances.hits(self.assembly, states, still)
        dozing = {hit.brick for hit in hits if hit.brick in self._dozing}
        self._dozing.wake(dozing)
        hits = [hit for hit in hits if hit.brick not in dozing]
        if hits := [hit for hit in hits if not self._joined.is_in_structure(hit.brick, self.assembly)]:
            update = self._wake_struck(hit_by_bricks(hits))
        stepped = self._awake.names - self._awake.announced
        pressing = stepped.difference(self._rigid_groups.bricks, self._dozing)
        if pressed := self._disturbances.overloaded(self.assembly, pressing):
            dry = [name for name in pressed.struck if not self._joined.is_in_structure(name, self.assembly)]
            update = update.then(
                self._wake_struck(replace(pressed, struck={name: pressed.struck[name] for name in dry}))
            )
        return update

    def _wake_struck(self, disturbed: Disturbance) -> Update:
        """Wake the region of a disturbance; some of its bricks may move as rigid groups."""
        for brick in disturbed.struck:
            if brick in self._rigid_groups:
                self._rigid_groups.release(brick)
        struck = {brick: along_W for brick, along_W in disturbed.struck.items() if self.is_frozen(brick)}
        if not struck:
            return Update()
        woken_region = region(self.assembly, struck, ride=self.joiner is not None)
        woken = wake(self.assembly, woken_region, presses=self.presser is not None)
        poses = {brick: placed.pose for brick, placed in woken.placed.items()}
        self._awake.rest_poses.remember(poses, {brick for brick, along_W in struck.items() if is_level(along_W)})
        for group in woken.riding:
            side = min(woken.placed[brick].brick.shape.least_thickness for brick in group)
            self._rigid_groups.weld({brick: poses[brick] for brick in group}, woken.touched, side)
        self._wake(poses, self._rigid_groups)
        if woken.forces is not None:
            self._dead_loads.take_over(woken.forces, woken.placed.values(), self.assembly.bricks)
            self._dead_loads.exert()
        touched = tuple(sorted(woken.touched))
        return Update((), tuple(poses), reason=disturbed.reason, riding=touched, by=disturbed.by)

    def _wake_released(self, judgement: Judgement, new: Collection[BodyId] = ()) -> tuple[BodyId, ...]:
        """Wake frozen bricks that were released from the assembly, as they cannot stand; `new` bricks are awake."""
        woken = tuple(sorted(judgement.released))
        self._wake(woken)
        self._awake.refuse(judgement.released)
        self._release_joined({*woken, *new}, judgement.held)
        return woken

    def _release_joined(self, bricks: Collection[BodyId], held: Collection[Pair], *, passes: bool = False) -> None:
        if self.joints.rules:
            placed = [placed for _, placed in solids(self.engine, self.engine.states(sorted(bricks)))]
            self._joined.released(placed, held, self.assembly, passes=passes)

    def _wake(self, bricks: Collection[BodyId], riding: Container[BodyId] = ()) -> None:
        """Wake bricks in the engine, except riding ones, which rigid groups move already."""
        for brick in bricks:
            if brick not in riding:
                self.engine.wake(brick)
        self._observers.woken(bricks)

    # --- external changes ---------------------------------------------------------------------------------------------

    def _judge_changes(self) -> Update:
        """Judge the frozen bricks again if they or the fixed bodies have changed."""
        lost = self._held.lost(self.assembly.bricks)
        if lost:
            self._observers.removed(lost)
        disturbed = self._held.disturbed(self.assembly.bricks.keys() - lost)
        change = changed(self.assembly, lost, disturbed, self._fixed_bodies())
        self.assembly = change.assembly
        if change.verdict is None:
            return Update()
        self._awake.allow_judgement()
        judgement = release_until_stable(self.assembly, change.verdict)
        woken = self._wake_released(replace(judgement, released={**change.pushed, **judgement.released}))
        return Update((), woken, judgement.lowest, judgement.first.reason or "moved by the caller" if woken else "")

    def _fixed_bodies(self) -> FixedBodies:
        return (
            FixedBodies(self.planes, ())
            if self.planes is not None
            else FixedBodies(*fixed_bodies(self.engine, self.friction))
        )
