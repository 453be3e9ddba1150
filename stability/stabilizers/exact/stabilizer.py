"""The exact stabilizer: freezes bricks that statics proves to stand and wakes those that it proves to fall."""

from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

from stability.contact_law import GivenFriction
from stability.engines.protocol import AcceptsForces, Engine, Joining
from stability.geometry.vectors import norm, scale
from stability.model import AT_REST, BodyId, BodyState, Plane, Pose, Vec3
from stability.problem import Placed, Stability, Stage, Tolerances, Verdict
from stability.stabilizers.exact.awake_bricks import AwakeBricks
from stability.stabilizers.exact.candidates import (
    Judgement,
    clear_of_strangers,
    fixed_bodies,
    release_until_stable,
    solids,
)
from stability.stabilizers.exact.hits import Disturbances, Disturbed, UnionContainer, hit_by_bricks, is_level
from stability.stabilizers.exact.woken_region import DeadLoads, RigidGroups, region, wake
from stability.stabilizers.held_bodies import HeldBodies, gravity_of
from stability.stabilizers.protocol import Observers, Update
from stability.stabilizers.rest import LimitsBySize, RestLimits
from stability.statics.assembly import Assembly

# Judges the frozen bricks again after somebody else has moved, pushed or taken some, or changed what is fixed.


@dataclass(frozen=True, slots=True)
class FixedBodies:
    """The fixed bodies of a world."""

    planes: Sequence[Plane]
    tables: Sequence[Placed]


@dataclass(frozen=True, slots=True)
class Changed:
    """An assembly after such changes."""

    assembly: Assembly  # a new one if the fixed bodies have changed
    verdict: Verdict | None  # None if nothing has changed
    pushed: Mapping[BodyId, Pose]  # bricks that move, and so are no longer part of the assembly


def changed(
    assembly: Assembly, lost: Collection[BodyId], disturbed: Mapping[BodyId, BodyState], site: FixedBodies
) -> Changed:
    """Remove the bricks that are lost or pushed, move those that were moved, and take in new fixed bodies."""
    pushed = {brick: state.pose for brick, state in disturbed.items() if _moves(state)}
    verdict = assembly.remove([*lost, *pushed]) if lost or pushed else None
    for brick, state in disturbed.items():
        if brick not in pushed:
            verdict = assembly.move(brick, state.pose)
    if (tuple(site.planes), tuple(site.tables)) != (assembly.planes, assembly.tables):
        standing = tuple(assembly.bricks.values())
        assembly = Assembly(
            site.planes, assembly.friction, assembly.gravity, assembly.tolerances, site.tables, overlap=inf
        )
        verdict = assembly.add_all(standing)
    return Changed(assembly, verdict, pushed)


def _moves(state: BodyState) -> bool:
    return state.velocity_W != AT_REST or state.angular_velocity_W != AT_REST


# The extension whose verdicts are proven: freezes what exact statics shows to stand, wakes what it shows to move.
#
# All frozen bricks are one assembly, and the verdict on it is STABLE. Bricks that come to rest are put to the proof
# together. What the verdict says moves, or cannot decide on, is left to the engine, and the rest is asked again, so
# that what still stands stays frozen with a proof of its own. Assumes gravity along -z and no other forces on bricks at
# rest. Statics knows boxes, fixed or not, and half-spaces. What touches anything else stays with the engine.


@dataclass
class ProvenStability:
    """Watches the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    # The fixed bodies; None to take the half-spaces and boxes that the engine holds fixed.
    planes: Sequence[Plane] | None = None
    # Coulomb coefficient of brick on brick, and on the engine's half-spaces; a `Friction` if bodies differ.
    friction: GivenFriction = 0.5
    gravity: float | None = None  # along -z [m/s2]; None to take what the engine says, or else that of the Earth
    rest: RestLimits = field(default_factory=RestLimits)  # for planks of 8 mm; other bricks have their own, by size
    # Whether every update also looks for frozen bricks that somebody else has moved, and judges them again. It is dear.
    guard: bool = True
    # What lets bricks ride along as one rigid body; None if the engine cannot, and all bricks move one by one.
    joiner: Joining | None = None
    # What lets frozen bricks press on woken ones; None if the engine cannot, and all that they carry is woken too.
    presser: AcceptsForces | None = None
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen
    assembly: Assembly = field(init=False)
    _awake: AwakeBricks = field(init=False)
    _when_changed: Verdict | None = field(default=None, init=False)  # as bricks were last set down or taken out
    _held: HeldBodies = field(init=False)
    _rigid_groups: RigidGroups = field(init=False)
    _dead_loads: DeadLoads = field(init=False)
    _disturbances: Disturbances = field(init=False)
    _observers: Observers = field(init=False)  # all of these: who hears what becomes of bricks, in this order

    def __post_init__(self) -> None:
        gravity = gravity_of(self.engine, self.gravity)
        self._held = HeldBodies(self.engine)
        self._rigid_groups = RigidGroups(self.joiner)
        self._dead_loads = DeadLoads(self.engine, self.presser)
        limits_of = LimitsBySize(self.engine, self.rest)
        self._awake = AwakeBricks(self.engine, limits_of, self._rigid_groups)
        self._disturbances = Disturbances(self.engine, limits_of, gravity, self._dead_loads.reactions)
        guarded = (self._held,) if self.guard else ()
        self._observers = Observers(
            (*guarded, limits_of, self._rigid_groups, self._dead_loads, self._disturbances, self._awake)
        )
        self.assembly = Assembly(self.planes or (), self.friction, gravity, self.tolerances, overlap=inf)

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""
        self._notice_new()
        return sorted(self._awake.names)

    def riding(self) -> Collection[BodyId]:
        """Those of the awake bricks that move as rigid bodies on others, not one by one."""
        return self._rigid_groups.bricks

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed, with a proof."""
        return brick in self.assembly.bricks

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Say that these bricks were set down at rest: they may be judged at once, before any step."""
        self._observers.set_down(list(bricks))

    def landed(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks have come to rest: they are judged at once, though nothing was set down."""
        coming = self._clear(dict(solids(self.engine, self.engine.states(self._awake.in_order(bricks)))))
        if not coming:
            return Update()
        return self._carry_out(self._judged(coming, names_smallest=False), [each.brick.id for each in coming], set())

    def taken_out(self, bricks: Iterable[BodyId]) -> Update:
        """Say that these bricks were taken out of the engine: what cannot stand without them is woken at once."""
        gone = sorted(bricks)
        frozen = [brick for brick in gone if self.is_frozen(brick)]
        self._observers.gone(gone)
        judgement = release_until_stable(self.assembly, self.assembly.remove(frozen))
        if frozen or not self._awake.names:  # otherwise no verdict has changed
            self._when_changed = judgement.first
        woken = self._give_back(judgement.released)
        return Update((), woken, judgement.lowest, judgement.first.reason if woken else "")

    def update(self) -> Update:
        """Judge what somebody else has changed, and what has come to rest."""
        lost = self._answer_changes() if self.guard else Update()
        self._notice_new()
        lost = lost.then(self._answer_disturbances(states := self._awake.follow()))
        coming = self._clear(self._awake.at_rest(states))
        announced = self._awake.no_longer_new()
        if not coming:
            self._dead_loads.exert()
            return lost
        # Of a heap that has fallen nobody wants to know which bricks would fall alone.
        judgement = self._judged(coming, names_smallest=bool(announced))
        if announced:
            self._when_changed = judgement.first
        found = self._carry_out(judgement, [placed.brick.id for placed in coming], announced)
        self._dead_loads.exert()
        return lost.then(found)

    def _judged(self, coming: Sequence[Placed], names_smallest: bool) -> Judgement:
        """Put bricks to the proof: first with those that hardly moved back at their rest poses, then as they are."""
        settled = self._awake.rest_poses.put_back(coming)
        verdict = self.assembly.add_all(settled, names_smallest=names_smallest)
        back = [placed for placed, was in zip(settled, coming, strict=True) if placed is not was]
        if back and verdict.stability is not Stability.STABLE:
            self.assembly.remove([placed.brick.id for placed in coming], names_smallest=names_smallest)
            back, verdict = [], self.assembly.add_all(coming, names_smallest=names_smallest)
        judgement = release_until_stable(self.assembly, verdict, names_smallest=names_smallest)
        for placed in back:
            self.engine.freeze(placed.brick.id)
            self.engine.put_at(placed.brick.id, placed.pose)
        return judgement

    def struck(self, brick: BodyId, impulse_W: Vec3) -> Update:
        """Say that a brick is about to be given an impulse [N s]: what that disturbs is woken before."""
        if brick in self._rigid_groups:
            self._rigid_groups.unweld(brick)  # a push moves one brick of a group, however gently
        speed = norm(impulse_W) / self.engine.masses()[brick]
        if speed < self._disturbances.least_push(brick) or not self.is_frozen(brick):
            return Update()
        along_W = scale(1.0 / norm(impulse_W), impulse_W)
        return self._wake_struck(Disturbed({brick: along_W}, f"{brick} pushed to {speed:.3g} m/s"))

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks back to the engine, and all that cannot stand without them; returns those woken."""
        bricks = [bricks] if isinstance(bricks, str) else list(bricks)
        unknown = [brick for brick in bricks if brick not in self.engine.masses()]
        if unknown:
            raise LookupError(f"the engine has no brick '{unknown[0]}'")
        asked = {brick: self.assembly.bricks[brick].pose for brick in sorted(bricks) if self.is_frozen(brick)}
        if not asked:
            return ()
        judgement = release_until_stable(self.assembly, self.assembly.remove(asked))
        return self._give_back({**asked, **judgement.released})

    def shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""
        asked = None if bricks is None else [brick for brick in bricks if self.is_frozen(brick)]
        return self.assembly.all_shares(asked)

    def least_margin(self) -> float | None:
        """None: a margin of the whole is a program of its own, solved where somebody asks for it."""
        return None

    def verdict(self) -> Verdict | None:
        """What was proven of the structure when bricks were last set down or taken out."""
        return self._when_changed

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why awake bricks cannot stand: as bricks were last set down or taken out, or where they are now."""
        verdict = self._when_changed
        found: dict[BodyId, str] = {}
        if verdict is not None and verdict.motion is not None:
            found |= dict.fromkeys(verdict.motion.velocity, verdict.reason)
        before = self.assembly.state()
        try:
            there = dict(solids(self.engine, self.engine.states(self._awake.in_order(self._awake.names))))
            verdict = self.assembly.add_all(there.values(), names_smallest=False)
            while verdict.stability is Stability.UNSTABLE:
                found |= dict.fromkeys(verdict.moving, verdict.reason)
                verdict = self.assembly.remove(verdict.moving, names_smallest=False)
        finally:
            self.assembly.restore(before)
        return {name: reason for name, reason in found.items() if name in self._awake.names}

    # --- what is put to the proof -------------------------------------------------------------------------------------

    def _notice_new(self) -> None:
        bricks = self.engine.masses()
        apart = set(self._apart())
        # Without a guard nobody else adds bricks, so that counting them is enough.
        if self.guard or len(bricks) != len(self._awake.names) + len(self.assembly.bricks) + len(apart):
            self._awake.notice([name for name in bricks if name not in apart], self.assembly.bricks.keys())

    def _apart(self) -> Collection[BodyId]:
        """The bricks that are neither moved by the engine alone nor judged."""
        return ()

    def _clear(self, resting: Mapping[BodyId, Placed]) -> list[Placed]:
        """The resting bricks that touch nothing that statics does not know."""
        if not resting:
            return []
        if self.planes is not None and len(resting) == len(self._awake.names):
            return list(resting.values())
        tables = (table.brick.id for table in self.assembly.tables)
        known = {*self.assembly.bricks, *tables, *(plane.id for plane in self.assembly.planes)}
        clear = clear_of_strangers(
            self.engine, resting, known, self.engine.states(self._awake.in_order(self._awake.names))
        )
        if not clear:
            self._awake.wait()
        return clear

    # --- what follows from a verdict ----------------------------------------------------------------------------------

    def _carry_out(self, judgement: Judgement, coming: Sequence[BodyId], announced: set[BodyId]) -> Update:
        frozen = tuple(brick for brick in coming if brick not in judgement.released)
        for brick in frozen:
            self.engine.freeze(brick)
        self._observers.frozen(frozen)
        refused = {brick: judgement.released[brick] for brick in coming if brick in judgement.released}
        fallen = {brick: pose for brick, pose in judgement.released.items() if brick not in refused}
        woken = self._give_back(fallen) + tuple(brick for brick in refused if brick in announced)
        self._awake.refuse(refused)
        # Of what was proven before something else was released, the last verdict names no stage.
        stages = {judgement.last.stage} if judgement.last.stage else {self.assembly.stage(brick) for brick in frozen}
        proof = next((stage.value for stage in reversed(Stage) if frozen and stage in stages), "")
        return Update(
            frozen,
            tuple(sorted(woken)),
            judgement.lowest if woken else (),
            judgement.first.reason if woken else "",
            proof,
        )

    def _answer_disturbances(self, states: Mapping[BodyId, BodyState]) -> Update:
        """Wake bricks that are about to be hit or pressed away; part rigid groups that are hit or moved too far."""
        if not states:
            return Update()
        for first in self._rigid_groups.moved_too_far(states):
            self._rigid_groups.unweld(first)
        found = Update()
        # Where nothing is still, flights are followed all the same: what is far away changes nothing.
        nothing_still = not self.assembly.bricks and not self._rigid_groups.bricks
        still = () if nothing_still else UnionContainer(self.assembly.bricks, self._rigid_groups)
        if hits := self._disturbances.hits(self.assembly, states, still):
            found = self._wake_struck(hit_by_bricks(hits))
        stepped = self._awake.names - self._awake.announced
        pressing = stepped - self._rigid_groups.bricks
        if pressed := self._disturbances.overloaded(self.assembly, pressing):
            found = found.then(self._wake_struck(pressed))
        return found

    def _wake_struck(self, disturbed: Disturbed) -> Update:
        """Wake the region that a disturbance reaches; some of its bricks may move on as rigid groups."""
        for brick in disturbed.struck:
            if brick in self._rigid_groups:
                self._rigid_groups.release(brick)
        struck = {brick: along_W for brick, along_W in disturbed.struck.items() if self.is_frozen(brick)}
        if not struck:
            return Update()
        reached = region(self.assembly, struck, ride=self.joiner is not None)
        woken = wake(self.assembly, reached, presses=self.presser is not None)
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

    def _give_back(self, bricks: Mapping[BodyId, Pose]) -> tuple[BodyId, ...]:
        """Wake frozen bricks that are no longer part of the assembly, for they cannot stand."""
        woken = tuple(sorted(bricks))
        self._wake(woken)
        self._awake.refuse(bricks)
        return woken

    def _wake(self, bricks: Collection[BodyId], riding: Container[BodyId] = ()) -> None:
        """Let the engine move bricks. Those that ride have their mass already, as a rigid group."""
        for brick in bricks:
            if brick not in riding:
                self.engine.wake(brick)
        self._observers.woken(bricks)

    # --- what somebody else has changed -------------------------------------------------------------------------------

    def _answer_changes(self) -> Update:
        """Judge the frozen bricks again where they or their surroundings are not what they were."""
        lost = self._held.lost(self.assembly.bricks)
        if lost:
            self._observers.gone(lost)
        disturbed = self._held.disturbed(self.assembly.bricks.keys() - lost)
        now = changed(self.assembly, lost, disturbed, self._site())
        self.assembly = now.assembly
        if now.verdict is None:
            return Update()
        self._awake.ask_again()
        judgement = release_until_stable(self.assembly, now.verdict)
        woken = self._give_back({**now.pushed, **judgement.released})
        return Update((), woken, judgement.lowest, judgement.first.reason or "moved by somebody else" if woken else "")

    def _site(self) -> FixedBodies:
        return (
            FixedBodies(self.planes, ())
            if self.planes is not None
            else FixedBodies(*fixed_bodies(self.engine, self.friction))
        )
