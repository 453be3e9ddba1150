"""Timeline -> proofs: a verdict of statics after every placement, and margins, without an engine."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, inf

from stability.analysis.acceleration_margin import acceleration, tilt
from stability.analysis.bearings import Survived, by_bearing
from stability.analysis.load_bounds import loads_between, loads_on
from stability.analysis.load_factor import LoadFactor, load_factor
from stability.analysis.margins import least_friction
from stability.analysis.piling import Piling
from stability.analysis.placement_margin import placement
from stability.analysis.uniqueness import outcome
from stability.analysis.weakest import (
    Apart,
    Weakest,
    fall_without_neighbours,
    first_tipping,
    weakest,
    weakest_at,
    without_neighbours,
    without_side_friction,
)
from stability.dynamics.onset import as_it_begins
from stability.model import BodyId
from stability.notebook import Printed
from stability.problem import Crushing, Motion, Placed, Problem, Stability, Stage, Tolerances, Verdict
from stability.statics.assembly import Assembly
from stability.statics.equilibrium import separating_motion
from stability.statics.fall_description import described
from stability.statics.initial_motion import find_start
from stability.statics.round_borders import inscribed
from stability.statics.tied_rest import ties_that_yield
from stability.statics.used_strength import used_strength
from stability.strength import Strength
from stability.supports import SupportMotion
from stackdsl.compiler.round_bricks import ROUND_MARGINS
from stackdsl.timeline import (
    HandAction,
    JointsAction,
    LoadsAction,
    PushAction,
    Removal,
    ShakeAction,
    Timeline,
    leaves_to_engine,
)
from stackdsl.trace import ALL_LOADS, USED_STRENGTH, CarriedRange, Trace, VerdictMargins, is_load, load_on
from stackdsl.wording import how_many

# Timeline -> proofs: a verdict after each placement, without an engine.
#
# Only an engine can follow a fall or find where a dropped brick comes to rest. Nothing after that is judged.


DISPROVED = "statics prove that it stands"


@dataclass(frozen=True, slots=True)
class JudgedGroup:
    """Bricks set down together."""

    bricks: tuple[BodyId, ...]
    verdict: Verdict  # of the whole assembly, these bricks included
    stages: Mapping[BodyId, Stage | None]  # stage that proved each of them then; later bricks may change the proof


@dataclass(frozen=True, slots=True)
class Proofs:
    """Verdicts of a build, in order of time."""

    judged: tuple[JudgedGroup, ...]
    assembly: Assembly  # after the last judged action
    verdict: Verdict  # of `assembly`; of a fall, with the bricks that begin to move and how, if `names_smallest`
    done: int = 0  # number of judged actions, from the first of the timeline on


def proofs_of(timeline: Timeline, names_smallest: bool = True) -> Proofs:
    """Judge every action as `exact` does, up to the first one that needs an engine.

    With `names_smallest` a fall is proven by the smallest set of bricks found, which takes seconds for a heap, and the
    verdicts describe the motion `as_it_begins`, as reports show it and as an engine receives it.
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
        if isinstance(moment, JointsAction | LoadsAction):
            done += 1
            assembly = moment.on(assembly)
            if assembly.verdict().stability is not Stability.STABLE:
                break
            continue
        if isinstance(moment, PushAction | ShakeAction | HandAction):
            break
        set_down = [placement for placement in moment if placement.at_rest]
        if set_down:
            added = [Placed(placement.brick, placement.pose) for placement in set_down]
            verdict = assembly.add_all(added, names_smallest=names_smallest)
            if names_smallest:
                verdict = as_it_begins(assembly, verdict)
            done += len(moment)
            names = tuple(placement.brick.id for placement in set_down)
            judged.append(JudgedGroup(names, verdict, {name: assembly.stage(name) for name in names}))
        if len(set_down) < len(moment) or assembly.verdict().stability is not Stability.STABLE:
            break
    last = as_it_begins(assembly, assembly.verdict()) if names_smallest else assembly.verdict()
    return Proofs(tuple(judged), assembly, last, done)


def compare_with_statics(trace: Trace, timeline: Timeline) -> Trace:
    """Return the trace, with its collapse marked as numerical if every structure before it was proven to stand.

    If statics prove the collapse, the trace gets that proof. A collapse that statics leave open is not marked.
    """
    proofs = proofs_until(timeline, trace.collapse.time) if trace.collapse is not None else None
    if proofs is None:
        return trace
    verdict = proofs.verdict
    if verdict.stability is Stability.UNSTABLE:
        return replace(trace, disproof=verdict)
    if verdict.stability is Stability.UNDECIDED or find_start(proofs.assembly.problem(), Tolerances()) is not None:
        return trace
    return replace(trace, numerical=DISPROVED)


def stands_until(timeline: Timeline, time: float) -> bool:
    """Return whether the structure is proven to stand after every action up to a time [s]."""
    return verdict_until(timeline, time).stability is Stability.STABLE


def verdict_until(timeline: Timeline, time: float) -> Verdict:
    """Return the first verdict up to a time [s] that is not STABLE, or else STABLE.

    UNDECIDED if an action before that needs an engine: a drop, a throw or a push.
    """
    proofs = proofs_until(timeline, time)
    if proofs is None:
        return Verdict(
            Stability.UNDECIDED, reason="a brick is dropped, thrown or pushed, which only an engine can follow"
        )
    return proofs.verdict


def proofs_until(timeline: Timeline, time: float) -> Proofs | None:
    """Return the proofs of the build up to a time [s]; None if an action before that needs an engine."""
    timeline = timeline.as_set_down()
    done = tuple(action for action in timeline.actions if action.time <= time)
    if not done or any(leaves_to_engine(action) for action in done):
        return None
    return proofs_of(replace(timeline, actions=done))


# Timeline -> the finished structure, as one assembly.


REPAIRS = "`stackdsl suggest` searches for repairs"
RIGID = "bricks with a `strength` are not judged by this command, only by `check`, `explain` and `find`"
TIED = "tied bricks are not judged by this command, only by `check`, `explain`, `survive` and `find`"
NO_MARGIN = f"only a stable structure has margins; {REPAIRS}"


@dataclass(frozen=True, slots=True)
class FinishedStructure:
    """All bricks that are set down and not pulled out again."""

    assembly: Assembly
    left_out: int  # bricks dropped, thrown or let go in the air: only an engine can find where they come to rest

    @property
    def why_not(self) -> str:
        """Reason why the structure cannot be analysed, as it does not stand; empty if it stands."""
        verdict = self.assembly.verdict()
        if not self.assembly.bricks:
            return "no brick is set down at rest, so statics has nothing to judge"
        if verdict.stability is not Stability.STABLE:
            return f"{verdict.stability.upper()}: {verdict.reason}; {REPAIRS}"
        if self.assembly.strengths:
            return RIGID
        return ""


def finished_structure_of(timeline: Timeline) -> FinishedStructure:
    """Return the finished structure of a timeline, judged as a whole."""
    final = timeline.as_set_down()
    removed = {name for action in final.actions if isinstance(action, Removal) for name in action.bricks}
    staying = [placement for placement in final.placements if placement.brick.id not in removed]
    assembly = timeline.final_world.assembly()
    resting = [Placed(each.brick, each.pose) for each in staying if each.at_rest]
    if resting:
        assembly.add_all(resting)
    return FinishedStructure(assembly, len(staying) - len(resting))


def piling_of(timeline: Timeline) -> Piling:
    """Return the bricks that are set down and pulled out, in the order of the build."""
    stages: list[list[Placed]] = []
    pulled: dict[int, list[BodyId]] = {}
    present: set[BodyId] = set()
    for moment in timeline.as_set_down().moments():
        if isinstance(moment, Removal):
            # Statics do not know where a dropped or thrown brick is.
            pulled.setdefault(len(stages), []).extend(name for name in moment.bricks if name in present)
        elif isinstance(moment, tuple):
            stage = [Placed(each.brick, each.pose) for each in moment if each.at_rest]
            stages += [stage] if stage else []
            present.update(placed.brick.id for placed in stage)
    stages += [[]] if len(stages) in pulled else []
    world = timeline.final_world
    removed = {turn: names for turn, names in pulled.items() if names}
    return Piling(world.planes, world.friction, world.gravity, stages, removed, world.tolerances, world.joints)


# Margins of the proof that a structure stands, computed on request: each solves a separate program.


ALL = ("acceleration", "tilt", "friction", "placement")
MOST_ROUND_FOR_PROGRAMS = 12  # bricks, if some are round: polygons of many sides stand for their discs
MOST_FOR_PROGRAMS = 60  # bricks; above, margins and remedies take many seconds and are computed only on request


def margins_of(trace: Trace, requested: Collection[str]) -> VerdictMargins:
    """Return the requested margins of the bricks that are frozen at the end of a run."""
    assembly = frozen_assembly(trace)
    if assembly is None or trace.world is None:
        return VerdictMargins()
    return margins_of_assembly(assembly, requested, supports=trace.world.supports)


def frozen_assembly(trace: Trace) -> Assembly | None:
    """Return the assembly of the bricks that are frozen at the end of a run; None if there are none."""
    standing = [Placed(track.brick, track.final) for track in trace.tracks.values() if track.frozen]
    if trace.world is None or not standing:
        return None
    # Another order of the same bricks would change last digits, and a brick in a hand carries like the ground.
    played = trace.assembly
    if played is not None and not played.tables and list(played.bricks.values()) == standing:
        return played
    assembly = trace.world.assembly()
    assembly.add_all(standing)
    return assembly


def margins_of_assembly(
    assembly: Assembly,
    requested: Collection[str] = ALL,
    on_stage: Callable[[str], None] = lambda _: None,
    supports: Sequence[SupportMotion] = (),
) -> VerdictMargins:
    """Return the requested margins of an assembly; none if it is not proven to stand.

    Bricks with joints have the margins of acceleration and tilt, and the load factor, which is returned in any case.
    Bricks under loads have no margins of tilt and placement, and their load factor is that of the loads.
    `on_stage` is called with the name of each computation.
    """
    if not _has_margins(assembly):
        return VerdictMargins()
    if assembly.strengths:  # the other margins are those of bricks that never crush
        return _crushed(assembly.problem(), assembly, requested, on_stage)
    return _of_rigid(assembly, requested, on_stage, supports)


def _of_rigid(
    assembly: Assembly,
    requested: Collection[str],
    on_stage: Callable[[str], None],
    supports: Sequence[SupportMotion],
) -> VerdictMargins:
    problem, margins = inscribed(assembly.problem()), VerdictMargins()
    if problem.is_round:
        requested = {margin for margin in requested if margin in ROUND_MARGINS or is_load(margin)}
    if "load_factor" in requested or ((problem.has_joints or problem.applied) and requested):
        on_stage("load factor")
        margins = _loaded(problem)
    margins = replace(margins, carried=_carried(assembly.problem(), requested, on_stage))
    if {"acceleration", "tilt"}.intersection(requested) and not problem.is_brittle:
        on_stage("margin of acceleration and tilt")
        margins = _shaken(problem, assembly.gravity, margins)
    if problem.applied or problem.is_tied:
        margins = replace(margins, tilt=None)  # it reduces the weight that holds against the loads
    margins = replace(margins, settlement=_settlement(assembly, supports if "settlement" in requested else ()))
    if problem.has_joints:
        return margins  # the other margins are those of dry structures
    if "friction" in requested:
        on_stage("margin of friction")
        roughest = max((contact.law.friction for contact in problem.contacts), default=0.0)
        margins = replace(margins, friction=least_friction(problem).coefficient, roughest=roughest)
    if "placement" in requested and not (problem.applied or problem.is_tied):
        on_stage("margin of placement")
        planes = [plane.id for plane in assembly.planes]
        placed = placement(problem, planes=planes)
        margins = replace(margins, placement=placed.value, joints=placed.limits)
    if "guaranteed" in requested:
        on_stage("guarantee of rest")
        rest = outcome(problem, assembly.forces())
        margins = replace(margins, guaranteed=rest.guaranteed, certainty=rest.reason)
    if "squeezed" in requested:
        margins = replace(margins, squeezed=separating_motion(problem) is None)
    return margins


def _crushed(
    problem: Problem, assembly: Assembly, requested: Collection[str], on_stage: Callable[[str], None]
) -> VerdictMargins:
    """Return the margins of an assembly of bricks with a strength."""
    margins = VerdictMargins(carried=_carried(problem, requested, on_stage))
    if USED_STRENGTH not in requested:
        return margins
    on_stage("used strength")
    strengths = {name: each for name, each in assembly.strengths.items() if name in assembly.bricks}
    found = used_strength(problem, strengths, assembly.tolerances)
    return replace(margins, used_strength=found.enough, apart=_crushing_apart(problem, strengths, assembly.tolerances))


def _crushing_apart(problem: Problem, strengths: Mapping[BodyId, Strength], tolerances: Tolerances) -> Apart | None:
    """Return what crushes without friction between the side faces of bricks; None if nothing does."""
    apart = without_side_friction(problem)
    found = None if apart is None else used_strength(apart, strengths, tolerances, decide=True)
    return Apart(None, Crushing(found.brick, found.least).text) if found is not None and found.crushes else None


def _has_margins(assembly: Assembly) -> bool:
    """Return whether margins are computed."""
    return bool(assembly.bricks) and assembly.verdict().stability is Stability.STABLE


def _carried(problem: Problem, requested: Collection[str], on_stage: Callable[[str], None]) -> tuple[CarriedRange, ...]:
    """Return the requested loads on bodies, by name."""
    bodies = {contact.lower for contact in problem.contacts} | problem.bricks.keys()
    everywhere = problem.bricks.keys() if ALL_LOADS in requested else ()
    wanted = sorted(name for name in bodies if name in everywhere or load_on(name) in requested)
    pairs = sorted({(contact.lower, contact.upper) for contact in problem.contacts})
    between = [pair for pair in pairs if load_on(*pair) in requested]
    if wanted or between:
        on_stage("loads on bricks")
    found = (loads_on(problem, wanted) if wanted else None) or {}
    parts = (loads_between(problem, between) if between else None) or {}
    ranges = [*(((name, ""), each) for name, each in found.items()), *parts.items()]
    return tuple(
        CarriedRange(lower, upper, each.least.force, each.greatest.force, each.area) for (lower, upper), each in ranges
    )


def weakest_of(assembly: Assembly) -> Weakest | None:
    """Return the mechanism that opens first under an acceleration.

    None if the assembly is not proven to stand, is held on all sides, or has joints.
    """
    if not _has_margins(assembly) or assembly.problem().has_joints:
        return None
    return weakest(inscribed(assembly.problem()), assembly.gravity)


def _loaded(problem: Problem) -> VerdictMargins:
    # Of applied loads, these grow; otherwise the weights do, while ties keep the tension with which they were put on.
    growing = problem.applied or (problem.weights if problem.pulled else None)
    found = load_factor(problem) if growing is None else load_factor(problem.without(growing), growing)
    if found is None:
        return VerdictMargins()
    yields = gives_way_text(problem, found)
    return VerdictMargins(load_factor=found.factor, loaded=bool(problem.applied), yields=yields)


def gives_way_text(problem: Problem, found: LoadFactor) -> str:
    """Return the first mechanism in words, with the joint that gives way; empty without one."""
    if found.motion is None:
        return ""
    yields = described(problem, found.motion)
    if found.joints:
        first, more = found.joints[0], len(found.joints) - 1
        others = f", with {how_many(more, 'other joint')}" if more else ""
        yields = f"{yields}; the joint between {first.lower} and {first.upper} gives way{others}"
    return "; ".join([yields, *ties_that_yield(problem, found.motion)])


def _shaken(problem: Problem, gravity: float, margins: VerdictMargins) -> VerdictMargins:
    worst = acceleration(problem, gravity=gravity)
    if worst is None:
        return margins
    first = weakest_at(problem, worst)
    bearing = worst.bearing if first is None else first.bearing
    alone = apart(problem, gravity, worst.value)
    return replace(
        margins, acceleration=worst.value, apart=alone, bearing=bearing, tilt=tilt(worst.value), weakest=first
    )


def _settlement(assembly: Assembly, supports: Sequence[SupportMotion]) -> float | None:
    """Return the multiple of the movement of supports that an assembly survives; None if none move, or unknown."""
    if not supports:
        return None
    from stability.analysis.large_motion import support_path  # noqa: PLC0415 -- seldom needed

    moved = support_path(assembly.problem(), supports, assembly.loads)
    if moved.falls < inf:
        return moved.holds
    return None if moved.ends else inf


LESS = 1e-3  # share of a margin by which it must be less without friction between side faces to be told


def apart(problem: Problem, gravity: float, value: float) -> Apart | None:
    """Return what is survived without friction between side faces, if that is less than `value` [g]."""
    alone = None if problem.has_joints or problem.is_tied else without_neighbours(problem, gravity)
    return None if alone is None or (alone.acceleration or 0.0) >= value * (1.0 - LESS) else alone


def fall_apart(assembly: Assembly) -> Apart | None:
    """Return the fall of a structure that stands only by friction between side faces; None if there is none."""
    if len(assembly.bricks) > MOST_FOR_WEAKEST or all(
        assembly.stage(name) is not Stage.CONES for name in assembly.bricks
    ):
        return None  # vertical forces hold it without such friction, or the program takes long
    problem = assembly.problem()
    judged = not (problem.has_joints or problem.is_round or problem.is_tied)  # ties press neighbours together
    return fall_without_neighbours(problem) if judged else None


# The acceleration that a structure survives, by bearing, proven without an engine.


MOST_FOR_WEAKEST = 300  # bricks; above, the worst of all bearings takes many times as long as the requested bearings
ALIKE = 1e-6  # share by which a mechanism must give way sooner than the weakest one to be named in its place
ALONG = 1e-12  # cosine below which a mechanism gives no bound along a bearing


@dataclass(frozen=True, slots=True)
class BearingSurvival:
    """The horizontal acceleration that an assembly survives along one bearing."""

    bearing: float  # of the pull on the bricks, from +x towards +y [rad]
    survived: float  # acceleration that is proven to be survived [g]; inf if nothing gives way
    fails: float  # acceleration that is proven to bring bricks down [g]; inf if none is
    # Survived tilt of the whole scene, downwards along the bearing [rad]; None under loads.
    tilt: float | None
    gives_way: str  # first mechanism, in words; empty if none is proven


@dataclass(frozen=True, slots=True)
class Survival(Printed):
    """Bearings all around, from +x on, and the weakest mechanism over all bearings, also those in between."""

    along: Sequence[BearingSurvival]
    weakest: Weakest | None  # None if nothing gives way, or with more bricks than `MOST_FOR_WEAKEST`
    tips: Weakest | None = None  # if all bricks slide together first: the mechanism that opens if none can slide
    apart: Apart | None = None  # what it survives without friction between side faces, if less
    name: str = ""  # of the case
    notes: tuple[str, ...] = ()  # parts of the case that are not judged
    # Multiple of its own weight that a structure with joints bears, or of its loads, and what gives way above it.
    load_factor: float | None = None
    loaded: bool = False  # whether `load_factor` is that of the loads, beside the weight
    yields: str = ""

    @property
    def worst(self) -> BearingSurvival:
        """The bearing of `along` with the least survived acceleration; the first of several."""
        least = min(each.survived for each in self.along)
        return next(each for each in self.along if each.survived <= least * (1.0 + ALIKE))


def survival_of(
    assembly: Assembly, count: int, accuracy: float, on_progress: Callable[[int], None] = lambda _: None
) -> Survival | None:
    """Return the survived acceleration along `count` bearings; None if the assembly is not proven to stand.

    Of a structure with joints, the load factor is computed, too. `accuracy` is relative, for dry structures.
    `on_progress` is called with the number of bearings that are finished.
    """
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return None
    problem = inscribed(assembly.problem())  # the margins of round bricks, too, are those of polygons
    loaded = _loaded(problem) if problem.has_joints or problem.applied else VerdictMargins()
    if problem.is_brittle:
        return Survival((), None, load_factor=loaded.load_factor, yields=loaded.yields)
    bearings = by_bearing(problem, count, accuracy, assembly.gravity, on_progress=on_progress)
    if bearings is None:
        return None
    first = weakest(problem, assembly.gravity) if len(assembly.bricks) <= MOST_FOR_WEAKEST else None
    texts: dict[int, str] = {}  # by motion, as several bearings share one
    slides = first is not None and first.slides_on and not problem.has_joints
    tips = first_tipping(problem, assembly.gravity) if slides else None
    alone = apart(problem, assembly.gravity, first.acceleration) if first is not None else None
    along = tuple(_along(problem, each, first, texts) for each in bearings)
    if problem.applied or problem.is_tied:
        along = tuple(replace(each, tilt=None) for each in along)
    beyond = loaded.load_factor, loaded.yields
    return Survival(along, first, tips, alone, load_factor=beyond[0], loaded=loaded.loaded, yields=beyond[1])


def _along(problem: Problem, each: Survived, first: Weakest | None, texts: dict[int, str]) -> BearingSurvival:
    """Return the result of one bearing, bounded on both sides by the weakest mechanism of all bearings.

    No bearing survives less than the worst one, and the weakest mechanism also limits every bearing near its own.
    """
    if first is None:
        return BearingSurvival(
            each.bearing, each.value, each.upper, tilt(each.value), _description(problem, each.motion, texts)
        )
    survived, turn = max(each.value, first.acceleration), cos(each.bearing - first.bearing)
    bound = first.fails / turn if turn > ALONG else inf
    if bound > each.upper * (1.0 + ALIKE):
        return BearingSurvival(
            each.bearing, survived, each.upper, tilt(survived), _description(problem, each.motion, texts)
        )
    return BearingSurvival(each.bearing, survived, min(bound, each.upper), tilt(survived), first.gives_way)


def _description(problem: Problem, motion: Motion | None, texts: dict[int, str]) -> str:
    if motion is None:
        return ""
    if id(motion) not in texts:
        texts[id(motion)] = described(problem, motion)
    return texts[id(motion)]
