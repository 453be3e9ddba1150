"""Everything about one run that can be shown: claims, events, poses, proofs."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from math import inf

from stability.analysis.weakest import Weakest
from stability.dynamics.onset import as_it_begins
from stability.geometry.vectors import add
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Motion, Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from stackdsl.checking.cases import Case
from stackdsl.compiler.compile import places_of
from stackdsl.diagnostics import Span
from stackdsl.judging.proofs import MOST_FOR_PROGRAMS, proofs_of, weakest_of
from stackdsl.results import VariantResult
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recording
from stackdsl.simulation.systems import as_played
from stackdsl.timeline import Handled, Placement, PushAction, Removal, ShakeAction, Timeline, leaves_to_engine
from stackdsl.trace import ACTIONS, UNRELIABLE, EventKind, Trace
from stackdsl.wording import energy_fault

# What statics proves of a run, to be shown beside it: contacts, forces, and who rests on whom, while they hold.
#
# Worth a look are the last structure that was proven to stand before anything was woken, and what stands at the end;
# where few things are done, also every structure on the way. Where something is proven to fall, so is the motion with
# which it begins.


MOST_STEPS = 40  # actions of a run of which every structure on the way is shown: each repeats all contacts


@dataclass(frozen=True, slots=True)
class ShownContact:
    """Where two bodies press on each other, and with what."""

    lower: BodyId
    upper: BodyId
    points_W: tuple[Vec3, ...]  # [m]
    forces_W: tuple[Vec3, ...]  # of `lower` on `upper`, by point [N]


@dataclass(frozen=True, slots=True)
class ShownBrick:
    """What is proven of one brick."""

    stage: str
    rests_on: Mapping[BodyId, float]  # which part of its load goes where
    depth: (
        float | None
    )  # how far its centre lies inside what carries it to the ground [m]; None where that says nothing


@dataclass(frozen=True, slots=True)
class ShownProof:
    """A structure that is proven to stand, and for how long it is there."""

    begin: float  # [s]
    end: float  # [s]
    bricks: Mapping[BodyId, ShownBrick]
    contacts: tuple[ShownContact, ...]


@dataclass(frozen=True, slots=True)
class ShownFall:
    """The motion with which all that is proven to fall begins to, which no admissible forces can stop."""

    time: float  # [s]
    motion: Motion
    reason: str


@dataclass(frozen=True, slots=True)
class ShownProofs:
    """All that is proven of one run."""

    standing: tuple[ShownProof, ...]
    fall: ShownFall | None


def shown_proofs(timeline: Timeline, trace: Trace, names_smallest: bool = True) -> ShownProofs:
    """What statics proves of a run, whatever it was played on; of a fall, `names_smallest` as in `Assembly.add_all`."""
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
    """What is set down, as long as all of it is proven to stand."""

    def __init__(self, timeline: Timeline, every: bool, names_smallest: bool) -> None:
        """`every`: whether all that is built on the way is to be shown."""
        self.timeline, self.every, self.names_smallest = timeline.as_set_down(), every, names_smallest
        self.shown: list[ShownProof] = []
        self.assembly = timeline.world.assembly()
        self.begin, self.until = 0.0, inf  # while it is as it is [s]

    def judge(self, last: float) -> ShownFall | None:
        """Build what is done up to a time [s]; where that falls, go back to what stood, and say how it falls."""
        for moment in self.timeline.moments():
            time = moment[0].time if isinstance(moment, tuple) else moment.time
            if time > last:
                break
            if isinstance(moment, PushAction | ShakeAction | Handled) or (
                isinstance(moment, tuple) and any(map(leaves_to_engine, moment))
            ):
                self.until = time
                break
            if self.every and self.assembly.bricks and time > self.begin:
                self.shown.append(self.show())
            verdict, undo = self._taken_out(moment) if isinstance(moment, Removal) else self._set_down(moment)
            if verdict.stability is not Stability.STABLE:
                verdict = as_it_begins(self.assembly, verdict)
                undo()
                self.until = time
                self.shown = self.shown[:-1] if time > self.begin else self.shown  # it is the one that is there
                return ShownFall(time, verdict.motion, verdict.reason) if verdict.motion is not None else None
            self.begin = time
        return None

    def show(self) -> ShownProof:
        """What is there now, and proven."""
        return _shown(self.assembly, self.begin, inf)

    def _set_down(self, placements: Iterable[Placement]) -> tuple[Verdict, Callable[[], object]]:
        coming = [Placed(placement.brick, placement.pose) for placement in placements]
        verdict = self.assembly.add_all(coming, names_smallest=self.names_smallest)
        return verdict, lambda: self.assembly.remove([placed.brick.id for placed in coming])

    def _taken_out(self, removal: Removal) -> tuple[Verdict, Callable[[], object]]:
        going = [self.assembly.bricks[name] for name in removal.bricks]
        verdict = self.assembly.remove(removal.bricks, names_smallest=self.names_smallest)
        return verdict, lambda: self.assembly.add_all(going)


def _at_the_end(trace: Trace) -> ShownProof | None:
    """What is held at the end, if it is proven to stand."""
    standing = [Placed(track.brick, track.final) for track in trace.tracks.values() if track.frozen]
    if trace.world is None or not standing:
        return None
    assembly = trace.world.assembly()
    if assembly.add_all(standing).stability is not Stability.STABLE:
        return None
    names = {placed.brick.id for placed in standing}
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
    return ShownProof(begin, end, bricks, tuple(contacts))


def _depth(assembly: Assembly, placed: Placed) -> float | None:
    x, y, _ = placed.pose.position_W
    found = assembly.core_depth(placed.brick.id, (x, y))
    return found if found >= 0.0 else None


def _sum(forces: Iterable[Vec3]) -> Vec3:
    total = ZERO
    for force in forces:
        total = add(total, force)
    return total


# All that can be seen of one run: what was asked, what happened, where everything was, and what was proven of it.


@dataclass(frozen=True)
class RunView:
    """One run, as renderers see it; they compute nothing of what happened."""

    name: str  # what people call the case
    system: str
    description: str
    timeline: Timeline  # as it was played
    trace: Trace
    recording: Recording
    result: VariantResult
    proofs: ShownProofs
    places: Mapping[BodyId, Span]  # of what sets down each brick, in the file
    verdict: str  # in words
    # Of what a golden file tells: what differs from the run beside it, in words, by brick or what else it is of.
    marks: Mapping[str, tuple[str, ...]] | None = None

    @property
    def least_room(self) -> tuple[BodyId, float] | None:
        """The brick of the last structure that is proven to stand whose centre has least room, and how much [m].

        Room is how deep the centre of a brick lies inside what carries it down to the ground, in plan. Of a brick that
        stands by friction alone, or by the weight of others, that says nothing, and it is passed over.
        """
        standing = self.proofs.standing[-1:] if self.proofs.fall is None else ()
        told = [(brick.depth, name) for proof in standing for name, brick in proof.bricks.items()]
        depth, name = min(((depth, name) for depth, name in told if depth is not None), default=(0.0, ""))
        return (name, depth) if name else None

    def weakest(self) -> Weakest | None:
        """Which mechanism of what was built opens first; None where something falls, or is left to an engine.

        That takes seconds, and of more than a few bricks minutes: nothing is told of these.
        """
        bricks = sum(not placement.hits for placement in self.timeline.placements)
        if not self.proofs.standing or self.proofs.fall is not None or bricks > MOST_FOR_PROGRAMS:
            return None
        proofs = proofs_of(self.timeline)
        return weakest_of(proofs.assembly) if sum(len(each.bricks) for each in proofs.judged) == bricks else None


def view_of(
    case: Case, trace: Trace, recording: Recording, result: VariantResult, proofs: ShownProofs | None = None
) -> RunView:
    """What is to be seen of a case that was played; `proofs`, if they are known already."""
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
        _told(trace),
    )


def _told(trace: Trace) -> str:
    told, collapse = trace.reported_verdict, trace.collapse
    if told == UNRELIABLE:
        told = f"{UNRELIABLE}, {energy_fault(trace.energy_gained)}: {trace.verdict}"
    return told if collapse is None else f"{told} at level {collapse.level} after {collapse.time:.3f} s"
