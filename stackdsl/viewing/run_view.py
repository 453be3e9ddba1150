"""All data of one run for display: claims, events, poses, proofs."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

from stability.analysis.load_factor import borne_until, load_factor, used_of_joints
from stability.analysis.weakest import Weakest
from stability.dynamics.onset import as_it_begins
from stability.geometry.vectors import add, rotate
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Motion, Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from stability.statics.fall_description import really_moving
from stability.statics.used_strength import used_strength
from stackdsl.checking.cases import Case
from stackdsl.compiler.compile import places_of
from stackdsl.diagnostics import Span
from stackdsl.judging.numbers import ScenarioNumbers
from stackdsl.judging.proofs import MOST_FOR_PROGRAMS, frozen_assembly, gives_way_text, proofs_of, weakest_of
from stackdsl.results import VariantResult
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recording
from stackdsl.simulation.systems import as_played
from stackdsl.timeline import (
    HandAction,
    JointsAction,
    LoadsAction,
    Placement,
    PushAction,
    Removal,
    ShakeAction,
    Timeline,
    leaves_to_engine,
)
from stackdsl.trace import ACTIONS, UNRELIABLE, EventKind, Trace
from stackdsl.viewing.thrust import JointForces, Thrust, thrust_of
from stackdsl.wording import energy_fault

# Proofs to show beside a run: contacts, forces, and supports, with the time span in which they hold.
#
# Shown are the last structure that was proven to stand before a brick was woken, and the structure that stands at the
# end; in a run with few actions also every structure in between. A proven fall is shown by its initial motion.


MOST_STEPS = 40  # actions of a run up to which every structure is shown, as each repeats all contacts


@dataclass(frozen=True, slots=True)
class ShownContact:
    """A contact of two bodies, with its forces."""

    lower: BodyId
    upper: BodyId
    points_W: tuple[Vec3, ...]  # [m]
    forces_W: tuple[Vec3, ...]  # of `lower` on `upper`, by point [N]


@dataclass(frozen=True, slots=True)
class ShownLoad:
    """A load on a brick, as a force at a point, or a moment."""

    brick: BodyId
    point_W: Vec3  # [m]
    force_W: Vec3  # [N]
    moment_W: Vec3  # [N m]


@dataclass(frozen=True, slots=True)
class ShownBrick:
    """The proof of one brick."""

    stage: str
    rests_on: Mapping[BodyId, float]  # share of its load, by support
    depth: float | None  # distance of its centre inside the area that carries it [m]; None if it has no such area


@dataclass(frozen=True, slots=True)
class ShownProof:
    """A structure that is proven to stand, with its time span."""

    begin: float  # [s]
    end: float  # [s]
    bricks: Mapping[BodyId, ShownBrick]
    contacts: tuple[ShownContact, ...]
    loads: tuple[ShownLoad, ...] = ()

    @property
    def thrust(self) -> Thrust:
        """The line of thrust of the forces."""
        joints = (JointForces(each.lower, each.upper, each.points_W, each.forces_W) for each in self.contacts)
        return thrust_of(joints, self.bricks.keys())


@dataclass(frozen=True, slots=True)
class ShownFall:
    """The initial motion of a proven fall, which no admissible forces can prevent."""

    time: float  # [s]
    motion: Motion
    reason: str


@dataclass(frozen=True, slots=True)
class ShownProofs:
    """All proofs of one run."""

    standing: tuple[ShownProof, ...]
    fall: ShownFall | None


def shown_proofs(timeline: Timeline, trace: Trace, names_smallest: bool = True) -> ShownProofs:
    """Return the proofs of a run on any system; `names_smallest` is passed to `Assembly.add_all`."""
    moved = [event.time for event in trace.events if event.kind in (EventKind.WOKEN, EventKind.COLLAPSED)]
    last = max((event.time for event in trace.events if event.kind in ACTIONS), default=inf)
    structure = _Structure(timeline, every=len(timeline.actions) <= MOST_STEPS, names_smallest=names_smallest)
    fall = structure.judge(min([*moved, last]))
    until = min([*moved, structure.until])
    shown = [*structure.shown, structure.show()] if structure.assembly.bricks else []
    begins = [proof.begin for proof in shown]
    shown = [replace(proof, end=end) for proof, end in zip(shown, [*begins[1:], until], strict=bool(shown))]
    ending = _at_the_end(trace) if not shown or until < inf else None
    return ShownProofs(tuple(shown if ending is None else [*shown, ending]), fall)


class _Structure:
    """The structure during the build, as long as it is proven to stand."""

    def __init__(self, timeline: Timeline, every: bool, names_smallest: bool) -> None:
        """Start without bricks; `every` requests a view of each structure in between."""
        self.timeline, self.every, self.names_smallest = timeline.as_set_down(), every, names_smallest
        self.shown: list[ShownProof] = []
        self.assembly = timeline.world.assembly()
        self.begin, self.until = 0.0, inf  # time span of the current structure [s]

    def judge(self, last: float) -> ShownFall | None:
        """Build up to a time [s]; on a fall, return its motion, and go back to the structure before."""
        for moment in self.timeline.moments():
            time = moment[0].time if isinstance(moment, tuple) else moment.time
            if time > last:
                break
            if isinstance(moment, PushAction | ShakeAction | HandAction) or (
                isinstance(moment, tuple) and any(map(leaves_to_engine, moment))
            ):
                self.until = time
                break
            if self.every and self.assembly.bricks and time > self.begin:
                self.shown.append(self.show())
            match moment:
                case Removal():
                    verdict, undo = self._taken_out(moment)
                case JointsAction() | LoadsAction():
                    verdict, undo = self._changed(moment)
                case _:
                    verdict, undo = self._set_down(moment)
            if verdict.stability is not Stability.STABLE:
                verdict = as_it_begins(self.assembly, verdict)
                undo()
                if isinstance(moment, LoadsAction):
                    time = self._overloaded_at(moment)
                self.until = time
                self.shown = self.shown[:-1] if time > self.begin else self.shown  # the caller shows it again
                return ShownFall(time, verdict.motion, verdict.reason) if verdict.motion is not None else None
            self.begin = time
        return None

    def show(self) -> ShownProof:
        """Return the proof of the current structure."""
        return _shown(self.assembly, self.begin, inf)

    def _set_down(self, placements: Iterable[Placement]) -> tuple[Verdict, Callable[[], object]]:
        added = [Placed(placement.brick, placement.pose) for placement in placements]
        verdict = self.assembly.add_all(added, names_smallest=self.names_smallest)
        return verdict, lambda: self.assembly.remove([placed.brick.id for placed in added])

    def _taken_out(self, removal: Removal) -> tuple[Verdict, Callable[[], object]]:
        removed = [self.assembly.bricks[name] for name in removal.bricks]
        verdict = self.assembly.remove(removal.bricks, names_smallest=self.names_smallest)
        return verdict, lambda: self.assembly.add_all(removed)

    def _overloaded_at(self, change: LoadsAction) -> float:
        """Return the time at which loads that bring bricks down become too large [s]."""
        first = self.assembly.with_loads(change.course.first)
        if first.verdict().stability is not Stability.STABLE:
            return change.time
        return min(change.course.ends, borne_until(first, change.course, change.time))

    def _changed(self, change: JointsAction | LoadsAction) -> tuple[Verdict, Callable[[], object]]:
        before = self.assembly
        self.assembly = change.on(before)
        return self.assembly.verdict(), lambda: setattr(self, "assembly", before)


def _at_the_end(trace: Trace) -> ShownProof | None:
    """Return the proof of the frozen bricks at the end; None if they are not proven to stand."""
    assembly = frozen_assembly(trace)
    if assembly is None or assembly.verdict().stability is not Stability.STABLE:
        return None
    names = set(assembly.bricks)
    changes = [event.time for event in trace.events if names.intersection(event.bricks)]
    return _shown(assembly, max(changes, default=0.0), inf)


def _shown(assembly: Assembly, begin: float, end: float) -> ShownProof:
    forces, shares = assembly.forces(), assembly.all_shares()
    contacts = []
    if forces is not None:
        for contact, of_points in zip(assembly.problem().contacts, forces.of_contacts, strict=True):
            at_points = tuple(_sum(of_normals) for of_normals in of_points)
            contacts.append(ShownContact(contact.lower, contact.upper, contact.points_W, at_points))
    bricks = {
        name: ShownBrick(str(assembly.stage(name) or ""), shares.get(name, {}), _depth(assembly, placed))
        for name, placed in assembly.bricks.items()
    }
    return ShownProof(begin, end, bricks, tuple(contacts), tuple(_loads(assembly)))


def _loads(assembly: Assembly) -> Iterator[ShownLoad]:
    """Yield the loads on bricks where they act, without those of size zero."""
    for name, placed in assembly.bricks.items():
        for load in assembly.loads.on(name):
            point = add(placed.pose.position_W, rotate(placed.pose.orientation, load.point_B))
            force, moment = load.force, load.moment
            if load.turns:
                force, moment = (rotate(placed.pose.orientation, vector) for vector in (force, moment))
            if any(force) or any(moment):
                yield ShownLoad(name, point, force, moment)


def _depth(assembly: Assembly, placed: Placed) -> float | None:
    x, y, _ = placed.pose.position_W
    depth = assembly.core_depth(placed.brick.id, (x, y))
    return depth if depth >= 0.0 else None


def _sum(forces: Iterable[Vec3]) -> Vec3:
    total = ZERO
    for force in forces:
        total = add(total, force)
    return total


@dataclass(frozen=True, slots=True)
class ShownJoint:
    """A joint at the load factor."""

    lower: BodyId
    upper: BodyId
    used: float  # share of its strength
    yields: bool  # in the first mechanism
    points_W: tuple[Vec3, ...]  # of its contact [m]


@dataclass(frozen=True, slots=True)
class ShownLimit:
    """The first mechanism of a structure with joints under a multiple of its own weight."""

    factor: float
    gives_way: str
    moving: tuple[BodyId, ...]
    joints: tuple[ShownJoint, ...]


# The view of one run.


@dataclass(frozen=True)
class RunView:
    """The input of renderers: one run, without further computation."""

    name: str  # of the case
    system: str
    description: str
    timeline: Timeline  # as it was played
    trace: Trace
    recording: Recording
    result: VariantResult
    proofs: ShownProofs
    places: Mapping[BodyId, Span]  # position in the file of the step that places each brick
    verdict: str  # in words
    marks: Mapping[str, tuple[str, ...]] | None = None  # for a golden file: its differences in words, by subject
    numbers: ScenarioNumbers | None = None  # of the scenario, for remedies; None for a golden file

    @property
    def least_room(self) -> tuple[BodyId, float] | None:
        """The brick of the last proven structure whose centre has the least room, and that room [m].

        Room is the distance in plan of the centre of a brick inside the area that carries it. A brick that stands only
        by friction, or by the weight of others, has no such area and is left out.
        """
        standing = self.proofs.standing[-1:] if self.proofs.fall is None else ()
        depths = [(brick.depth, name) for proof in standing for name, brick in proof.bricks.items()]
        depth, name = min(((depth, name) for depth, name in depths if depth is not None), default=(0.0, ""))
        return (name, depth) if name else None

    @cached_property
    def limit(self) -> ShownLimit | None:
        """Return what limits the load factor; None without joints, or for more than `MOST_FOR_PROGRAMS` bricks.

        It takes seconds. The forces are one set that the joints bear at the load factor.
        """
        bricks = sum(not placement.hits for placement in self.timeline.placements)
        if not self.timeline.world.has_joints or bricks > MOST_FOR_PROGRAMS:
            return None
        problem = proofs_of(self.timeline).assembly.problem()
        found = load_factor(problem) if problem.has_joints else None
        if found is None or found.forces is None or found.motion is None:
            return None
        patches = {(contact.lower, contact.upper): contact.points_W for contact in reversed(problem.contacts)}
        yielding = {(joint.lower, joint.upper) for joint in found.joints}
        joints = tuple(
            ShownJoint(*pair, 1.0 if pair in yielding else min(share, 1.0), pair in yielding, patches[pair])
            for pair, share in used_of_joints(problem, found.forces).items()
        )
        moving = tuple(really_moving(problem, found.motion))
        return ShownLimit(found.factor, gives_way_text(problem, found), moving, joints)

    @cached_property
    def used_strength(self) -> Mapping[BodyId, float]:
        """Return by brick the share of its strength that it uses; empty for more than `MOST_FOR_PROGRAMS` bricks.

        The forces are one set of those that need the least share of all strengths.
        """
        strengths = self.timeline.world.strengths
        if not strengths or sum(not placement.hits for placement in self.timeline.placements) > MOST_FOR_PROGRAMS:
            return {}
        assembly = proofs_of(self.timeline).assembly
        present = {name: strength for name, strength in strengths.items() if name in assembly.bricks}
        used = used_strength(assembly.problem(), present)
        return {name: used.shares.get(name, 0.0) for name in present} if used.enough < inf else {}

    def weakest(self) -> Weakest | None:
        """Return the mechanism that opens first; None if a brick falls or needs an engine.

        This takes seconds, and minutes for many bricks: None for more than `MOST_FOR_PROGRAMS`.
        """
        bricks = sum(not placement.hits for placement in self.timeline.placements)
        if not self.proofs.standing or self.proofs.fall is not None or bricks > MOST_FOR_PROGRAMS:
            return None
        proofs = proofs_of(self.timeline)
        return weakest_of(proofs.assembly) if sum(len(each.bricks) for each in proofs.judged) == bricks else None


def view_of(
    case: Case, trace: Trace, recording: Recording, result: VariantResult, proofs: ShownProofs | None = None
) -> RunView:
    """Return the view of a played case; `proofs`, if they are computed already."""
    timeline = as_played(case.timeline, system_named(case.system).modification)
    return RunView(
        case.name,
        case.system,
        case.scenario.description or "",
        timeline,
        trace,
        recording,
        result,
        shown_proofs(timeline, trace) if proofs is None else proofs,
        places_of(case.scenario, case.source),
        _verdict_text(trace),
        numbers=ScenarioNumbers(case.scenario, case.variant),
    )


def _verdict_text(trace: Trace) -> str:
    text, collapse = trace.reported_verdict, trace.collapse
    if text == UNRELIABLE:
        text = f"{UNRELIABLE}, {energy_fault(trace.energy_gained)}: {trace.verdict}"
    if collapse is None:
        return text
    if collapse.fallen and text == trace.verdict:
        return collapse.text
    return f"{text} at level {collapse.level} after {collapse.time:.3f} s"
