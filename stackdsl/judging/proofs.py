"""Timeline -> proofs: what statics says of every placement, with margins, without an engine."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, inf

from stability.analysis.acceleration_margin import acceleration, tilt
from stability.analysis.bearings import Survived, by_bearing
from stability.analysis.margins import least_friction
from stability.analysis.placement_margin import placement
from stability.analysis.repair import Piling
from stability.analysis.uniqueness import outcome
from stability.analysis.weakest import Weakest, weakest, weakest_at
from stability.dynamics.onset import as_it_begins
from stability.model import BodyId
from stability.problem import Motion, Placed, Problem, Stability, Stage, Tolerances, Verdict
from stability.statics.assembly import Assembly
from stability.statics.equilibrium import separating_motion
from stability.statics.fall_description import described
from stability.statics.initial_motion import lets_go
from stackdsl.timeline import Handled, PushAction, Removal, ShakeAction, Timeline, leaves_to_engine
from stackdsl.trace import Trace, VerdictMargins

# Timeline -> proofs: what statics says of each placement, without any engine.
#
# What falls, and where something dropped comes to lie, only an engine can tell. From there on nothing is judged.


DISPROVED = "statics prove that it stands"


@dataclass(frozen=True, slots=True)
class JudgedGroup:
    """Bricks set down together."""

    bricks: tuple[BodyId, ...]
    verdict: Verdict  # of all that stands, with them
    stages: Mapping[BodyId, Stage | None]  # what proved each of them then; later bricks may bring in another proof


@dataclass(frozen=True, slots=True)
class Proofs:
    """What was judged, in order of time."""

    judged: tuple[JudgedGroup, ...]
    assembly: Assembly  # all that was judged
    verdict: Verdict  # of all that was judged; of a fall, with what begins to move and how, if that was wanted
    done: int = 0  # of the actions of the timeline, those that were judged


def proofs_of(timeline: Timeline, names_smallest: bool = True) -> Proofs:
    """Judge every action as `exact` does, up to the first one that leaves anything to the engine.

    With `names_smallest` a fall is proven by as few bricks as are found to fall, which of a heap takes seconds, and the
    verdicts are told `as_it_begins`: that is what everybody is told of it, and what an engine is given.
    """
    assembly = timeline.world.assembly()
    judged: list[JudgedGroup] = []
    done = 0
    for moment in timeline.as_set_down().moments():
        if isinstance(moment, Removal):
            done += 1
            if assembly.remove(moment.bricks, names_smallest=names_smallest).stability is not Stability.STABLE:
                break
            continue
        if isinstance(moment, PushAction | ShakeAction | Handled):
            break
        set_down = [placement for placement in moment if placement.at_rest]
        if set_down:
            coming = [Placed(placement.brick, placement.pose) for placement in set_down]
            verdict = assembly.add_all(coming, names_smallest=names_smallest)
            if names_smallest:
                verdict = as_it_begins(assembly, verdict)
            done += len(moment)
            names = tuple(placement.brick.id for placement in set_down)
            judged.append(JudgedGroup(names, verdict, {name: assembly.stage(name) for name in names}))
        if len(set_down) < len(moment) or assembly.verdict().stability is not Stability.STABLE:
            break
    last = as_it_begins(assembly, assembly.verdict()) if names_smallest else assembly.verdict()
    return Proofs(tuple(judged), assembly, last, done)


def held_against_statics(trace: Trace, timeline: Timeline) -> Trace:
    """The trace; a collapse before which every structure was proven to stand is marked as numerical.

    One that had to come has the proof of it. Neither is said of one that could come as well as not.
    """
    proofs = proofs_until(timeline, trace.collapse.time) if trace.collapse is not None else None
    if proofs is None:
        return trace
    verdict = proofs.verdict
    if verdict.stability is Stability.UNSTABLE:
        return replace(trace, disproof=verdict)
    if verdict.stability is Stability.UNDECIDED or lets_go(proofs.assembly.problem(), Tolerances()) is not None:
        return trace
    return replace(trace, numerical=DISPROVED)


def stands_until(timeline: Timeline, time: float) -> bool:
    """Whether all that was built is proven to stand, after everything that was done up to a time [s]."""
    return verdict_until(timeline, time).stability is Stability.STABLE


def verdict_until(timeline: Timeline, time: float) -> Verdict:
    """The first verdict that is not STABLE, of all that was built up to a time [s], or STABLE.

    UNDECIDED from the first thing on that only an engine can follow: what is dropped, thrown or pushed.
    """
    proofs = proofs_until(timeline, time)
    if proofs is None:
        return Verdict(
            Stability.UNDECIDED, reason="something is dropped, thrown or pushed, which only an engine can follow"
        )
    return proofs.verdict


def proofs_until(timeline: Timeline, time: float) -> Proofs | None:
    """What is proven of all that was built up to a time [s]; None where only an engine can follow what was done."""
    timeline = timeline.as_set_down()
    done = tuple(action for action in timeline.actions if action.time <= time)
    if not done or any(leaves_to_engine(action) for action in done):
        return None
    return proofs_of(replace(timeline, actions=done))


# Timeline -> what is built in the end, as one design that statics can be asked about.


@dataclass(frozen=True, slots=True)
class FinishedStructure:
    """All that is set down and not pulled out again."""

    assembly: Assembly
    left_out: (
        int  # bricks that are dropped, thrown or let go in the air: where they come to lie only an engine can tell
    )

    @property
    def why_not(self) -> str:
        """Why nothing can be asked of what stands; empty if it does."""
        verdict = self.assembly.verdict()
        if not self.assembly.bricks:
            return "nothing is set down at rest, so there is nothing that statics could judge"
        if verdict.stability is not Stability.STABLE:
            return f"{verdict.stability.upper()}: {verdict.reason}; `stackdsl suggest` looks for what would mend it"
        return ""


def finished_structure_of(timeline: Timeline) -> FinishedStructure:
    """The finished structure of a timeline, all at once."""
    final = timeline.as_set_down()
    gone = {name for action in final.actions if isinstance(action, Removal) for name in action.bricks}
    staying = [placement for placement in final.placements if placement.brick.id not in gone]
    assembly = timeline.world.assembly()
    resting = [Placed(each.brick, each.pose) for each in staying if each.at_rest]
    if resting:
        assembly.add_all(resting)
    return FinishedStructure(assembly, len(staying) - len(resting))


def piling_of(timeline: Timeline) -> Piling:
    """What is set down and pulled out, in the order of the build."""
    stages: list[list[Placed]] = []
    pulled: dict[int, list[BodyId]] = {}
    there: set[BodyId] = set()
    for moment in timeline.as_set_down().moments():
        if isinstance(moment, Removal):
            # What was dropped or thrown is nowhere that statics know of.
            pulled.setdefault(len(stages), []).extend(name for name in moment.bricks if name in there)
        elif isinstance(moment, tuple):
            stage = [Placed(each.brick, each.pose) for each in moment if each.at_rest]
            stages += [stage] if stage else []
            there.update(placed.brick.id for placed in stage)
    stages += [[]] if len(stages) in pulled else []
    world = timeline.world
    gone = {turn: names for turn, names in pulled.items() if names}
    return Piling(world.planes, world.friction, world.gravity, stages, gone, world.tolerances)


# Margins of the proof that a structure stands, computed on request: each is a program of its own.


ALL = ("acceleration", "tilt", "friction", "placement")
MOST_FOR_PROGRAMS = 60  # bricks; beyond, margins and remedies take many seconds and come only when asked for


def margins_of(trace: Trace, wanted: Collection[str]) -> VerdictMargins:
    """Some margins of what stands frozen at the end of a run."""
    standing = [Placed(t.brick, t.final) for t in trace.tracks.values() if t.frozen]
    if trace.world is None or not standing:
        return VerdictMargins()
    assembly = trace.world.assembly()
    assembly.add_all(standing)
    return margins_of_assembly(assembly, wanted)


def margins_of_assembly(assembly: Assembly, wanted: Collection[str] = ALL) -> VerdictMargins:
    """Some margins of an assembly; none of one that is not proven to stand."""
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return VerdictMargins()
    problem = assembly.problem()
    found = _shaken(problem, assembly.gravity) if {"acceleration", "tilt"}.intersection(wanted) else VerdictMargins()
    if "friction" in wanted:
        roughest = max((contact.law.friction for contact in problem.contacts), default=0.0)
        found = replace(found, friction=least_friction(problem).coefficient, roughest=roughest)
    if "placement" in wanted:
        planes = [plane.id for plane in assembly.planes]
        placed = placement(problem, planes=planes)
        found = replace(found, placement=placed.value, joint=placed.limit)
    if "guaranteed" in wanted:
        can_happen = outcome(problem, assembly.forces())
        found = replace(found, guaranteed=can_happen.guaranteed, certainty=can_happen.reason)
    if "squeezed" in wanted:
        found = replace(found, squeezed=separating_motion(problem) is None)
    return found


def weakest_of(assembly: Assembly) -> Weakest | None:
    """Which mechanism opens first; None of what is not proven to stand, or is held on all sides."""
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return None
    return weakest(assembly.problem(), assembly.gravity)


def _shaken(problem: Problem, gravity: float) -> VerdictMargins:
    worst = acceleration(problem, gravity=gravity)
    if worst is None:
        return VerdictMargins()
    first = weakest_at(problem, worst)
    bearing = worst.bearing if first is None else first.bearing
    return VerdictMargins(worst.value, bearing, tilt(worst.value), weakest=first)


# The acceleration that a structure survives, by bearing, proven without an engine.


MOST_FOR_WEAKEST = 300  # bricks; beyond, the worst of all bearings takes many times as long as those that are asked for
ALIKE = 1e-6  # share by which a mechanism must give way sooner than the weakest one does to be named in its place
ALONG = 1e-12  # cosine below which a mechanism bounds nothing in a direction


@dataclass(frozen=True, slots=True)
class Along:
    """What is survived along one bearing."""

    bearing: float  # that bricks are pulled along, from +x towards +y [rad]
    survived: float  # proven [g]; inf if nothing gives way
    fails: float  # proven to bring something down [g]; inf if nothing is proven to
    tilt: float  # of the whole, downwards along the bearing, that is survived [rad]
    gives_way: str  # what comes down first, and how, in words; empty if nothing is proven to


@dataclass(frozen=True, slots=True)
class Survival:
    """All bearings around, from +x on, and what is weakest of all bearings, these or others."""

    along: Sequence[Along]
    weakest: Weakest | None  # None if nothing gives way, or of more bricks than `MOST_FOR_WEAKEST`

    @property
    def worst(self) -> Along:
        """Of these bearings, where least is survived; the first of several."""
        least = min(each.survived for each in self.along)
        return next(each for each in self.along if each.survived <= least * (1.0 + ALIKE))


def survival_of(
    assembly: Assembly, count: int, accuracy: float, known: Callable[[int], None] = lambda _: None
) -> Survival | None:
    """What an assembly survives along `count` bearings, each to a relative accuracy; None if it is not proven to stand.

    `known` is told of how many bearings enough is known, as it goes on.
    """
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return None
    problem = assembly.problem()
    found = by_bearing(problem, count, accuracy, assembly.gravity, known=known)
    if found is None:
        return None
    first = weakest(problem, assembly.gravity) if len(assembly.bricks) <= MOST_FOR_WEAKEST else None
    told: dict[int, str] = {}  # words are the same for all bearings at which the same motion gives way
    return Survival(tuple(_along(problem, each, first, told) for each in found), first)


def _along(problem: Problem, each: Survived, first: Weakest | None, told: dict[int, str]) -> Along:
    """One bearing. No less is survived along it than in the worst of all, whose mechanism bounds all others."""
    if first is None:
        return Along(each.bearing, each.value, each.upper, tilt(each.value), _words(problem, each.motion, told))
    survived, turn = max(each.value, first.acceleration), cos(each.bearing - first.bearing)
    bound = first.fails / turn if turn > ALONG else inf
    if bound > each.upper * (1.0 + ALIKE):
        return Along(each.bearing, survived, each.upper, tilt(survived), _words(problem, each.motion, told))
    return Along(each.bearing, survived, min(bound, each.upper), tilt(survived), first.gives_way)


def _words(problem: Problem, motion: Motion | None, told: dict[int, str]) -> str:
    if motion is None:
        return ""
    if id(motion) not in told:
        told[id(motion)] = described(problem, motion)
    return told[id(motion)]
