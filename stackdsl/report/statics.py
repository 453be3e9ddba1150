"""Results of statics for a scenario as text: proofs, margins, remedies, friction."""

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import degrees, hypot, inf, tan
from typing import Any

from stability.analysis.weakest import Weakest, first_tipping
from stability.contact_law import Friction, as_friction
from stability.geometry.box_distance import TOUCHING, reach_between
from stability.geometry.vectors import body_axes, scale
from stability.model import GROUND, BodyId, Brick, Vec3
from stability.name_order import in_order, names_text
from stability.problem import Contact, Placed, Stability
from stability.statics.assembly import Assembly
from stability.statics.fall_description import fall_side
from stability.statics.structure import Structure
from stability.ties import Tie, length_of
from stability.work_limit import TooMuchWorkError, limited
from stackdsl import work
from stackdsl.checking.cases import Case
from stackdsl.compiler.fit import Fit, TimedShape, fits
from stackdsl.compiler.joints import mortars_of
from stackdsl.judging.judge import expected_of
from stackdsl.judging.numbers import ScenarioNumbers
from stackdsl.judging.proofs import (
    ALL,
    MOST_FOR_PROGRAMS,
    MOST_ROUND_FOR_PROGRAMS,
    JudgedGroup,
    Proofs,
    fall_apart,
    margins_of_assembly,
    proofs_of,
)
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, OtherNumber, Remedies, StrongerJoints, remedies_of
from stackdsl.language.claims.margin import Margin
from stackdsl.language.impacts import Cut, Glue
from stackdsl.language.joints import JointOfBricks, MagnetOrTape, MortarOrGlue, StudGrid
from stackdsl.language.loads import Amount, Growing, Load
from stackdsl.language.schema import Scenario
from stackdsl.language.supports import Support
from stackdsl.report.blocks import Block, blocks_text, hanging, line, table
from stackdsl.report.warnings import modified_text
from stackdsl.shown_text import without_commands
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method, as_played
from stackdsl.simulation.worlds import settings_for
from stackdsl.timeline import (
    Arrival,
    HoldAction,
    JointChange,
    JointsAction,
    LoadsAction,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import NOT_MODELLED, USED_STRENGTH, VerdictMargins
from stackdsl.wording import (
    aided_text,
    apart_text,
    clock,
    how_many,
    in_short,
    joints_text,
    limit_text,
    mass_text,
    mm,
    moving_text,
    rounded_up,
    shaking_text,
    side_text,
    slides_together,
    survived_text,
    time_text,
    touching_text,
    weakest_text,
)

# Verdicts of statics on scenarios, without simulation.


ANSWERS = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls"}  # other verdicts are undecided
OPEN = "not proven"


@dataclass(frozen=True, slots=True)
class StaticsSummary:
    """The proofs of one variant of a scenario."""

    scenario: str
    variant: str  # without the system
    bricks: int  # bricks of the structure
    proven: int  # bricks proven to stand when set down, together with all before them
    answer: str  # `stands`, `falls` or `not proven`
    reason: str  # reason, if something falls or is undecided
    time: float | None  # time of the first placement that does not stand [s]
    within: float = 0.0  # [m] largest gap that the verdict counts as contact; 0 if none

    @property
    def name(self) -> str:
        """Return the scenario, with the variant if it has several."""
        return f"{self.scenario}[{self.variant}]" if self.variant else self.scenario


def statics_summary_of(case: Case) -> StaticsSummary:
    """Judge each placement of a case by statics, up to the first action that needs an engine."""
    timeline = case.timeline
    bricks = sum(not placement.hits for placement in timeline.placements)
    variant = ",".join(f"{name}={text}" for name, text in case.parameters)
    try:
        with limited(work.limit()):
            proofs = proofs_of(timeline)
    except TooMuchWorkError as error:
        return StaticsSummary(
            case.scenario_name, variant, bricks, 0, OPEN, f"the proof takes too much work: {error}", None
        )
    verdict = proofs.verdict
    fallen = [judged for judged in proofs.judged if judged.verdict.stability is not Stability.STABLE]
    proven = sum(len(judged.bricks) for judged in proofs.judged if judged not in fallen)
    answer = ANSWERS.get(verdict.stability, OPEN)
    reason = verdict.reason if verdict.stability is not Stability.STABLE else ""
    if answer == "stands" and proven < bricks:
        answer, reason = OPEN, f"{bricks - proven} of {bricks} bricks depend on the engine"
    first = {fallen[0].bricks[0]} if fallen else frozenset[str]()
    times = [act.time for act in timeline.actions if isinstance(act, Placement) and act.brick.id in first]
    return StaticsSummary(
        case.scenario_name,
        variant,
        bricks,
        proven,
        answer,
        reason,
        times[0] if times else None,
        verdict.touching_within,
    )


def statics_text(said: Sequence[StaticsSummary], width: int, colour: bool) -> str:
    """Return a table with one row for each variant, and below it the reasons of those that do not stand."""
    if not said:
        return ""
    rows = [
        {
            "scenario": each.scenario,
            "variant": each.variant or "-",
            "bricks": str(each.bricks),
            "proven": str(each.proven),
            "statics": each.answer,
            "at s": f"{each.time:.3f}" if each.time is not None else "-",
        }
        for each in said
    ]
    reasons = [line(f"  {each.name}: {each.answer}: {each.reason}") for each in said if each.reason]
    across = [line(f"  {each.name}: stands{touching_text(each.within)}") for each in said if each.within > 0.0]
    blocks: list[Block] = [[table(rows, ("scenario", "variant", "statics"))]]
    blocks += [[line("Not proven to stand", "bold"), *reasons]] if reasons else []
    blocks += [[line("Stable only if gaps count as contact", "bold"), *across]] if across else []
    counts = {answer: sum(each.answer == answer for each in said) for answer in (*ANSWERS.values(), OPEN)}
    sums = ", ".join(f"{count} {answer}" for answer, count in counts.items() if count)
    total = f"{len(said)} variant{'s' * (len(said) != 1)}: {sums}; no simulation"
    return blocks_text([*blocks, [line(total)]], width, colour)


# Remedies for a scenario that falls, one line each.


NO_COUNTERWEIGHT = "no counterweight on one brick was found"


def remedy_lines(remedies: Remedies) -> Iterator[str]:
    """Yield all remedies, and those proven not to help."""
    yield from map(_remedy_text, remedies.in_order())
    if remedies.friction is not None and remedies.friction.factor == inf:
        yield friction_text(remedies.friction)
    if remedies.joints is not None:
        if remedies.joints.factor == inf:
            yield stronger_text(remedies.joints)
        return
    if remedies.crushing is not None:
        yield f"strengths of {rounded_up(remedies.crushing.share)} times the written ones"
        return
    if not remedies.numbers:
        yield "no number of the file was found whose change alone prevents the fall"
    if remedies.counterweight is None:
        yield "no counterweight helps, since no brick rises" if remedies.nothing_rises else NO_COUNTERWEIGHT


def _remedy_text(remedy: OtherNumber | MoreFriction | StrongerJoints | HeavierBrick) -> str:
    if isinstance(remedy, StrongerJoints):
        return stronger_text(remedy)
    if isinstance(remedy, MoreFriction):
        return friction_text(remedy)
    if isinstance(remedy, HeavierBrick):
        return counterweight_text(remedy)
    number, limit = remedy.number, remedy.limit
    sign = ">=" if limit.least else "<="
    return f"{number.name} {sign} {number.text(limit.value)} instead of {number.text(number.number)} at {number.span}"


def stronger_text(remedy: StrongerJoints) -> str:
    if remedy.factor == inf:
        return "no strength of the joints is large enough"
    return f"joints of {remedy.factor:.4g} times their strength"


def friction_text(remedy: MoreFriction) -> str:
    if remedy.factor == inf:
        return "no friction coefficient is large enough"
    if remedy.alike:
        return f"friction >= {remedy.coefficient:.4g}"
    return f"all friction coefficients times {remedy.factor:.4g} (between bricks {remedy.coefficient:.4g})"


def counterweight_text(remedy: HeavierBrick) -> str:
    return f"{mass_text(remedy.mass)} on {remedy.brick}, at its centre{later_text(remedy.next_to_fall)}"


def later_text(next_to_fall: Collection[BodyId]) -> str:
    """Return what still falls with a remedy."""
    return f"; then {names_text(in_order(next_to_fall))} would fall later" if next_to_fall else ""


# Text on friction other than the usual coefficient.


def rubbing_lines(timeline: Timeline) -> Iterator[str]:
    """Yield bodies and pairs with friction of their own, and pairs of which no two bodies touch."""
    law = as_friction(timeline.world.friction)
    if not law.differs:
        return
    if law.own:
        own = ", ".join(f"{name} {each:g}" for name, each in sorted(law.own.items()))
        yield f"  own friction of bodies: {own}; friction of a contact: {law.rule}"
    touching = _touching(timeline, law)
    for pair, each in sorted(law.between.items()):
        never = "" if frozenset(pair) in touching else "; no two of these touch when they are set down"
        yield f"  friction {each:g} between {pair[0]} and {pair[1]}{never}"


def _contacts(timeline: Timeline) -> list[Contact]:
    """Return the contacts of all bodies where they are set down."""
    world = timeline.world
    structure = Structure(world.planes, (), 0.0, world.gravity, world.tolerances)
    for placement in timeline.placements:
        structure.put(Placed(placement.brick, placement.pose))
    return structure.contacts_of(list(structure.bricks))


def _touching(timeline: Timeline, law: Friction) -> set[frozenset[str]]:
    """Return the bodies and kinds that touch each other at some time while nothing moves."""
    return {
        frozenset(names)
        for contact in _contacts(timeline)
        for names in product(
            (contact.lower, law.kinds.get(contact.lower, contact.lower)),
            (contact.upper, law.kinds.get(contact.upper, contact.upper)),
        )
    }


# The weakest spot of a structure as text for all reports, and as JSON.


def weakest_json(weakest: Weakest) -> Mapping[str, Any]:
    """Return the weakest spot by key, with every brick that begins to move."""
    return {
        "brick": weakest.brick,
        "bricks": list(weakest.bricks),
        "survives_g": float(f"{weakest.acceleration:.6g}"),
        "fails_g": float(f"{weakest.fails:.6g}"),
        "bearing_deg": float(f"{degrees(weakest.bearing):.6g}"),
        "gives_way": weakest.gives_way,
    }


# Results of statics for a build as text: proofs of placements, their margins, and remedies for a fall.


MICROSECONDS = 1e6
DAY = 86_400.0  # [s]
LEAST_IN_MPA = 1e4  # [Pa] smaller strengths are told in kPa
TOLD = (*ALL, "guaranteed", "squeezed", USED_STRENGTH)  # the reported margins of standing structures


@dataclass(frozen=True, slots=True)
class Extent:
    """The extent of the computations and of the text."""

    margins: bool | None = None  # margins of proofs; None: only of few bricks
    remedies: bool | None = None  # remedies for a fall; None: only of few bricks
    times: bool = False  # time of each proof, which differs between runs
    on_stage: Callable[[str], None] = lambda _: None  # called with the name of each computation that may take long


def stages_told(proofs: Proofs, times: bool) -> Mapping[BodyId, str]:
    """Return the proof of each judged brick; with `times`, the time of a proof at the last brick of its group."""
    told = {}
    for judged in proofs.judged:
        for brick in judged.bricks:
            cost = _cost(judged) if times and brick == judged.bricks[-1] else ""
            told[brick] = f"  {_answer(judged, brick)}{cost}"
    return told


def _answer(judged: JudgedGroup, brick: BodyId) -> str:
    if brick in judged.verdict.moving:
        answer = "falls" if judged.verdict.stability is Stability.UNSTABLE else "in doubt"
        return f"{answer}: {judged.verdict.stage}" if judged.verdict.stage is not None else answer
    stage = judged.stages[brick]
    return f"{stage}" if stage is not None else "not proven"


def _cost(judged: JudgedGroup) -> str:
    together = f" for {len(judged.bricks)} bricks" if len(judged.bricks) > 1 else ""
    return f", {MICROSECONDS * judged.verdict.seconds:.0f} us{together}"


def proven_lines(  # noqa: PLR0913, PLR0917 -- all parts of the text
    proofs: Proofs,
    timeline: Timeline,
    count: int,
    extent: Extent,
    numbers: ScenarioNumbers,
    margins: VerdictMargins | None = None,
) -> Iterator[str]:
    """Yield the results for all judged bricks out of `count`; `margins` are the reported ones (`TOLD`), if known."""
    verdict, judged = proofs.verdict, sum(len(judged.bricks) for judged in proofs.judged)
    if verdict.stability is not Stability.STABLE:
        rest = "the engine simulates the rest" if verdict.crushing is None else NOT_MODELLED
        if timeline.world.ties:
            rest = "tied bricks are not played"
        elif timeline.world.strengths and verdict.stability is Stability.UNDECIDED:
            rest = "bricks that may crush are not played"
        yield f"  statics: {verdict.stability.upper()}: {verdict.reason}; {rest}"
        yield from _fall(proofs, timeline, extent, numbers)
    elif judged < count:
        yield f"  statics: {judged} of {count} bricks are proven to stand; the engine simulates the others"
    else:
        seconds = sum(judged.verdict.seconds for judged in proofs.judged)
        cost = f", in {1000.0 * seconds:.3g} ms" if extent.times else ""
        within = verdict.touching_within
        yield f"  statics: every placement is proven to stand{touching_text(within)}{cost}"
        if within > 0.0:
            yield "    with `touching: exactly`, it is not proven to stand"
        if fall := fall_apart(proofs.assembly):
            yield f"    {apart_text(fall)}"
        yield from _margins(proofs, extent, margins)


def _fall(proofs: Proofs, timeline: Timeline, extent: Extent, numbers: ScenarioNumbers) -> Iterator[str]:
    """Yield everything that moves, its direction, and remedies."""
    verdict, bricks = proofs.verdict, proofs.assembly.bricks
    in_doubt = verdict.stability is Stability.UNDECIDED
    if verdict.crushing is None:
        yield f"    {'in doubt' if in_doubt else 'moves'}: {', '.join(in_order(verdict.moving))}"
    if side := side_text(fall_side(verdict, bricks)):
        yield f"    direction: {side}"
    if in_doubt or extent.remedies is False:
        return
    if extent.remedies is None and len(bricks) > MOST_FOR_PROGRAMS:
        yield f"    remedies for more than {MOST_FOR_PROGRAMS} bricks take long to compute; add --remedies"
        return
    extent.on_stage("remedies")
    yield "    remedies, each verified:"
    yield from (f"      {line}" for line in remedy_lines(remedies_of(numbers, timeline, proofs)))


def _margins(proofs: Proofs, extent: Extent, margins: VerdictMargins | None) -> Iterator[str]:
    count = len(proofs.assembly.bricks)
    if extent.margins is False:
        return
    is_round = proofs.assembly.problem().is_round
    most = MOST_ROUND_FOR_PROGRAMS if is_round else MOST_FOR_PROGRAMS
    if extent.margins is None and count > most:
        kind = "round bricks" if is_round else "bricks"
        yield f"    margins of more than {most} {kind} take long to compute; add --margins"
        return
    margins = margins or margins_of_assembly(proofs.assembly, TOLD, extent.on_stage)
    if margins.used_strength is not None:
        yield f"    it needs {100.0 * margins.used_strength:.4g} % of the strength of its bricks"
    else:
        yield from _survived(margins)


def _survived(margins: VerdictMargins) -> Iterator[str]:
    yield "    it survives " + "; ".join(margin_texts(margins))
    if margins.squeezed:
        yield "    these margins rely on contacts whose pressure statics does not determine"
    if margins.weakest is not None:
        yield f"    {weakest_text(margins.weakest)}"
    if margins.apart is not None and margins.apart.acceleration is not None:
        yield f"    {apart_text(margins.apart)}"
    if margins.yields:
        yield f"    beyond: {margins.yields}"
    if margins.joints:
        yield f"    {joints_text(margins.joints)}"
    if margins.guaranteed is not None:
        yield f"    rest is {_certainty(margins)}"


def load_factor_text(factor: float, loaded: bool = False) -> str:
    """Return a load factor in words; `loaded` for that of applied loads, while the weight stays."""
    what = "its loads" if loaded else "its own weight"
    return f"any multiple of {what}" if factor == inf else f"{survived_text(factor)} times {what}"


def _certainty(margins: VerdictMargins) -> str:
    """Return whether rest is the only possibility, and why."""
    why = margins.certainty or "forces along normals alone balance every brick"
    return f"{'guaranteed' if margins.guaranteed else 'possible'}: {why}"


def margin_texts(margins: VerdictMargins) -> Iterator[str]:
    """Yield each known margin: what the structure survives."""
    if margins.load_factor is not None:
        yield load_factor_text(margins.load_factor, margins.loaded)
    if margins.acceleration == inf:  # held on all sides
        yield "any horizontal acceleration"
        if margins.tilt is not None:
            yield "any tilt below 90 deg"
    elif margins.acceleration is not None:
        worst = (
            f" (worst direction: {round(degrees(margins.bearing)) % 360} deg)" if margins.bearing is not None else ""
        )
        neighbours = f", {aided_text(margins.apart)}" if margins.apart is not None else ""
        yield f"a horizontal acceleration of {survived_text(margins.acceleration)} g{worst}{neighbours}"
    if margins.tilt is not None and margins.acceleration != inf:
        yield f"a tilt of {survived_text(degrees(margins.tilt))} deg"
    if margins.friction is not None:
        yield f"friction down to {rounded_up(margins.friction)}"
    if margins.placement == inf:  # all bricks lie on the ground, none on another brick
        yield "any placement error of every brick"
    elif margins.placement == 0.0 and margins.joints:
        yield "no placement error: it has no reserve"
    elif margins.placement is not None:
        yield f"a placement error of {survived_text(1000.0 * margins.placement)} mm of every brick"


# Compiled scenario as text: the world, each brick with time, place and supports, and the systems.
#
# With `exact` among the systems: the stage that proved each placement, its margins, or remedies for a fall.


WIDE = 160  # [characters]
AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def explanation_text(cases: Sequence[Case], extent: Extent = Extent(), width: int = WIDE) -> str:
    """Return the text for one variant of a scenario, wrapped to `width` [characters]; `cases` are its systems."""
    return without_commands("".join(f"{text}\n" for line in _lines(cases, extent) for text in hanging(line, width)))


def _lines(cases: Sequence[Case], extent: Extent) -> Iterator[str]:
    scenario, timeline = cases[0].scenario, cases[0].timeline
    chosen = ", ".join(f"{name} = {text}" for name, text in cases[0].variant.parameters)
    yield f"{scenario.scenario}{f' ({chosen})' if chosen else ''}, from {cases[0].source.span_of(('scenario',))}"
    if scenario.description:
        yield f"  {' '.join(scenario.description.split())}"
    yield from _world(timeline)
    idle = idle_items(scenario, timeline)
    for number, item in enumerate(scenario.joints):
        yield _joint_line(item) + ("; no two of these touch when they are set down" if number in idle else "")
    yield from _mortar_lines(scenario)
    yield from map(_load_line, scenario.loads)
    yield from map(_support_line, scenario.supports)
    yield from map(_tie_line, timeline.world.ties)
    yield from _strength_lines(timeline)
    kinds = [scenario.brick, *(step.brick for step in scenario.build)]
    kinds += [brick.brick for step in scenario.build for brick in step.bricks or ()]
    for studs in dict.fromkeys(kind.studs for kind in kinds if kind is not None and kind.studs is not None):
        yield f"  joint between bricks with studs: {_studs_text(studs)}"
    count, levels = sum(not placement.hits for placement in timeline.placements), timeline.levels
    what = f"{count} brick{'s' * (count > 1)} on {levels} level{'s' * (levels > 1)}"
    yield f"  {what}, finished at {time_text(timeline.built)}, watched until {time_text(timeline.end)}"
    yield ""
    extent.on_stage("proofs")
    proofs = proofs_of(timeline) if any(system_named(case.system).method is Method.PROVEN for case in cases) else None
    if proofs is not None:
        numbers = ScenarioNumbers(scenario, cases[0].variant)
        yield from proven_lines(proofs, timeline, count, extent, numbers)
        yield ""
    yield from _actions(timeline, stages_told(proofs, extent.times) if proofs is not None else {})
    yield ""
    for case in cases:
        yield from _system(case.system, timeline)


def _tie_line(tie: Tie) -> str:
    """Return where a tie is, with its tension and its length."""
    bricks = in_order(tie.around)
    where = f"between {' and '.join(bricks)}" if tie.course_W[0] != tie.course_W[-1] else f"around {names_text(bricks)}"
    up_to = f", up to {tie.strength:g} N if the balance needs more" if tie.is_ranged else ""
    return f"  tie '{tie.name}' {where}: {tie.tension:g} N{up_to}; {length_of(tie.course_W):.3g} m long"


def _strength_lines(timeline: Timeline) -> Iterator[str]:
    """Yield each strength against crushing, with the number of bricks that have it."""
    for strength, count in Counter(timeline.world.strengths.values()).items():
        limits = [f"a pressure of {1e-3 * strength.pressure:g} kPa"] if strength.pressure < inf else []
        limits += [f"a stack load of {strength.stack:g} N"] if strength.stack < inf else []
        yield f"  strength of {how_many(count, 'brick')}: {' and '.join(limits)}"


def _world(timeline: Timeline) -> Iterator[str]:
    world = timeline.world
    yield f"  gravity {world.gravity:g} m/s2, friction between bricks {as_friction(world.friction).usual:g}"
    yield from rubbing_lines(timeline)
    for plane in world.planes:
        normal = " ".join(f"{round(component, 4) + 0.0:g}" for component in plane.normal_W)
        yield f"  {plane.id}: normal ({normal}), friction {plane.friction:g}"


def _ductile_text(ductile: float) -> str:
    return f", ductile over {mm(ductile)}" if ductile else ""


def _studs_text(studs: StudGrid) -> str:
    narrow = "" if studs.narrow_pull is None else f" ({studs.narrow_pull:g} N under a brick of one stud)"
    every = f"studs every {1000.0 * studs.pitch:g} mm"
    return f"{every}, each of {studs.pull:g} N pull{narrow}, {studs.shear:g} N shear{_ductile_text(studs.ductile)}"


def idle_items(scenario: Scenario, timeline: Timeline) -> set[int]:
    """Return the numbers of the items of `joints` that hold from the start and join no two bodies that touch."""
    changes = sum(isinstance(impact.content, Glue | Cut) for impact in scenario.impacts)
    rules = timeline.world.joints.rules[changes : changes + len(scenario.joints)]
    held = [number for number, item in enumerate(scenario.joints) if item.bond is None or item.bond.from_ is None]
    contacts = _contacts(timeline) if held else []
    return {n for n in held if not any(rules[n].holds(contact.lower, contact.upper) for contact in contacts)}


def _joint_line(item: JointOfBricks) -> str:
    """Return one item of the joints in words."""
    match item:
        case JointOfBricks(bond=MortarOrGlue() as bond):
            what = _bond_text(bond)
        case JointOfBricks(pull=MagnetOrTape() as pull):
            what = f"pull of {pull.force:g} N at each corner" + _ductile_text(pull.ductile)
        case JointOfBricks(studs=StudGrid() as studs):
            what = _studs_text(studs)
        case _:
            what = "none"
    where = f"between {' and '.join(item.between)}" if item.between else f"of {', '.join(item.of or ['all bodies'])}"
    return f"  joint {where}: {what}"


def _mortar_lines(scenario: Scenario) -> Iterator[str]:
    for number, mortar in mortars_of(scenario):
        strength = "the joints above" if mortar.bond is None else _bond_text(mortar.bond)
        yield f"  mortar of step {number + 1}: joints of {mm(mortar.thickness)}, {strength}"


def _bond_text(bond: MortarOrGlue) -> str:
    strengths = {"tension": bond.tension, "cohesion": bond.cohesion}
    strengths |= {} if bond.shear is None else {"shear": bond.shear}
    text = "bond of " + ", ".join(f"{_strength_text(each)} {name}" for name, each in strengths.items())
    text += ", brittle" * bond.brittle + _ductile_text(bond.ductile)
    return text if bond.from_ is None else f"{text}, {_setting_text(bond.from_)} after placing"


def _load_line(load: Load) -> str:
    """Return a load in words, with its direction, its place and its bricks."""
    unit = MASSES.get(load.kind, "") if load.is_mass else UNITS_OF_LOADS[load.kind]
    parts = [f"{load.kind} of {_amount_text(load.amount, unit)}"]
    parts += [f"times a table up to {time_text(load.table[-1][0])}"] if load.table is not None else []
    parts += [f"towards {_direction_text(load.towards)}"] if load.towards is not None else []
    parts += [f"about {_direction_text(load.about)}"] if load.about is not None else []
    parts += [f"on face {_direction_text(load.face)}"] if load.face is not None else []
    parts += [f"up to a height of {load.surface:g} m"] if load.surface is not None else []
    parts += [f"at {_mm(load.point)} mm from the centre"] if load.point is not None else []
    parts += (
        [f"from {_mm(load.from_)} mm to {_mm(load.to)} mm"] if load.from_ is not None and load.to is not None else []
    )
    names = names_text([load.brick] if load.brick is not None else load.bricks or ())
    where = "all bricks" if load.all else f"level {load.level}" if load.level is not None else names
    parts += [f"on {where}"]
    return f"  load: {' '.join(parts)}"


def _support_line(support: Support) -> str:
    """Return the movement of a support in words."""
    parts = [f"by {_mm(support.by)} mm"] if support.by is not None else []
    if support.turn is not None and support.about is not None:
        parts.append(f"turned by {degrees(support.turn):g} deg about {_direction_text(support.about)}")
        parts += [f"around {_mm(support.around)} mm"] if support.around is not None else []
    return f"  support: under {names_text(support.under)} {', '.join(parts)}"


UNITS_OF_LOADS = {
    **{"force": "N", "weight": "N", "pressure": "Pa", "wind": "Pa", "fluid": "N/m3"},
    **{"acceleration": "m/s2", "moment": "N*m", "line": "N/m"},
}
MASSES = {"weight": "kg", "fluid": "kg/m3"}


def _amount_text(amount: Amount, unit: str) -> str:
    if isinstance(amount, Growing):
        return f"{amount.first:g} {unit} to {amount.last:g} {unit} over {time_text(amount.over)}"
    return f"{amount:g} {unit}"


def _direction_text(direction: str | float) -> str:
    """Return a direction with an arrow, as seen from the front or from above."""
    if isinstance(direction, str):
        return f"{direction} {ARROWS_BY_WORD[direction]}"
    turned = round(degrees(direction), 6) % 360.0
    return f"{turned:g} deg {ARROWS[round(turned / 45.0) % len(ARROWS)]}"


ARROWS = "→↗↑↖←↙↓↘"  # horizontal directions as seen from above, from +x towards +y
ARROWS_BY_WORD = {"up": "⇑", "down": "⇓", "top": "⇑", "bottom": "⇓"}


def _setting_text(time: float) -> str:
    days = time / DAY
    return f"{days:g} d" if days >= 1.0 else f"{24.0 * days:g} h"


def _strength_text(strength: float) -> str:
    return f"{1e-3 * strength:g} kPa" if 0.0 < strength < LEAST_IN_MPA else f"{1e-6 * strength:g} MPa"


def _actions(timeline: Timeline, told: Mapping[BodyId, str]) -> Iterator[str]:
    """Yield one line for each placed brick, with its text in `told`, and one for each other action."""
    placed = timeline.placements
    width = max(len(placement.brick.id) for placement in placed)
    bricks, planes = [placement.brick for placement in placed], [plane.id for plane in timeline.world.planes]
    found = iter(zip(placed, fits(_sited(timeline), timeline.world.planes), strict=True))
    for action in timeline.actions:
        match action:
            case Removal():
                yield f"  {clock(action.time)[1:]}  {', '.join(action.bricks):<{width}}  pulled out"
            case JointsAction() | LoadsAction() if action.bricks:
                change = JOINING[action.change] if isinstance(action, JointsAction) else "loaded"
                yield f"  {clock(action.time)[1:]}  {names_text(action.bricks):<{width}}  {change}"
            case PushAction():
                impulse = " ".join(f"{1000.0 * part:.4g}" for part in action.impulse_W)
                yield f"  {clock(action.time)[1:]}  {action.brick:<{width}}  pushed by ({impulse}) mN*s"
            case ShakeAction():
                yield f"  {clock(action.time)[1:]}  {GROUND:<{width}}  shaken {shaking_text(action.motion)}"
            case MoveAction(lowers=False):
                yield f"  {clock(action.time)[1:]}  {action.brick:<{width}}  {moving_text(action.course)} by hand"
            case HoldAction():
                yield f"  {clock(action.time)[1:]}  {', '.join(action.bricks):<{width}}  held"
            case ReleaseAction():
                yield f"  {clock(action.time)[1:]}  {', '.join(action.bricks):<{width}}  let go"
            case Placement():
                placement, fit = next(found)
                yield (
                    f"  {clock(placement.time)[1:]}  {placement.brick.id:<{width}}  "
                    f"at {_mm(placement.pose.position_W)} mm  along {_direction(placement)}  "
                    f"{_footing(placement, fit, bricks, planes)}{told.get(placement.brick.id, '')}"
                )


JOINING = {JointChange.JOINED: "joined", JointChange.SET: "joints have set", JointChange.CUT: "joints cut"}


def _footing(placement: Placement, fit: Fit, bricks: Sequence[Brick], planes: Sequence[BodyId]) -> str:
    """Return the supports of a placed brick and the walls that it touches, or how it arrives otherwise."""
    if placement.arrival in (Arrival.LET_GO, Arrival.DROPPED):
        return "dropped"
    if placement.arrival is Arrival.THROWN:
        return f"thrown at {hypot(*placement.velocity_W):.4g} m/s"
    boxes = [bricks[index] for index in fit.on_boxes]
    below = [*(brick.id for brick in boxes), *(planes[index] for index in fit.on_planes)]
    walls = [planes[index] for index in fit.beside_planes]
    if not below:
        beside = [*(bricks[index].id for index in fit.beside_boxes), *walls]
        return f"{'between' if len(beside) > 1 else 'held by'} {', '.join(beside)}"
    through = _touched_through(placement.brick, boxes) if len(below) > 1 else ""
    by_hand = ", brought by hand" if placement.arrival is Arrival.BY_HAND else ""
    return f"on {', '.join(below)}{through}" + (f", against {', '.join(walls)}" if walls else "") + by_hand


def _touched_through(brick: Brick, boxes: Sequence[Brick]) -> str:
    """Return the bodies below that are thinner than the reach of contact, so that the brick touches through them."""
    reach = reach_between(brick.shape.least_thickness)
    sheets = [box.id for box in boxes if box.shape.least_thickness <= reach]
    share = f"{100.0 * TOUCHING:g} % of {brick.id}"
    return f" (touched through {', '.join(sheets)}, thinner than {share})" if sheets else ""


def _sited(timeline: Timeline) -> list[TimedShape]:
    """Return all bricks, each from its placement to its removal."""
    moments = list(timeline.moments())
    until = {
        name: float(turn)
        for turn, moment in enumerate(moments)
        if isinstance(moment, Removal)
        for name in moment.bricks
    }
    return [
        TimedShape(float(turn), placement.brick.shape, placement.pose, until.get(placement.brick.id, inf))
        for turn, moment in enumerate(moments)
        if isinstance(moment, tuple)
        for placement in moment
    ]


def _mm(position: Vec3) -> str:
    return "(" + " ".join(f"{1000.0 * part:8.2f}" for part in position) + ")"


def _direction(placement: Placement) -> str:
    """Return the direction of the longest side of a brick."""
    reach = placement.brick.shape.reach
    longest = max(range(3), key=lambda axis: reach(AXES[axis]) + reach(scale(-1.0, AXES[axis])))
    direction = body_axes(placement.pose.orientation)[longest]
    return "(" + " ".join(f"{round(part, 3) + 0.0:6.3f}" for part in direction) + ")"


def _system(name: str, timeline: Timeline) -> Iterator[str]:
    system = system_named(name)
    yield f"  {name}: {system.summary}"
    yield f"    {settings_for(as_played(timeline, system.modification), system).summary()}"
    if modified := system.modification.summary:
        yield f"    {modified_text(modified)}"
    if system.method is Method.PROVEN:
        yield "    bricks that are proven to stand are frozen; the engine starts when a brick moves"
        if timeline.world.has_joints:
            yield "    joined bricks move as one body, until a joint opens that does not bear their loads"
    elif system.method is Method.PUBLISHED:
        yield "    the extension freezes bricks that its model finds stable, and skips time while all are frozen"
    else:
        yield "    the engine simulates every brick in every step"


# Margins that a standing structure misses, and what would help.


def missed_lines(case: Case, assembly: Assembly) -> Iterator[str]:
    """Yield for each claim `margin` that a structure misses what it measures, and what gives way."""
    claims = [claim.content for _, claim in expected_of(case.scenario, case.system)]
    for claim in claims:
        if not isinstance(claim, Margin):
            continue
        supports = case.timeline.world.supports
        margins = margins_of_assembly(assembly, claim.needed_margins, supports=supports)
        found = claim.compared(margins)
        if found.passed:
            continue
        yield f"  measured {found.measured}"
        if margins.yields:
            yield f"  {margins.yields}"
        wanted = max(
            claim.acceleration.low if claim.acceleration is not None else 0.0,
            tan(claim.tilt.low) if claim.tilt is not None else 0.0,
        )
        if margins.weakest is None or margins.acceleration is None or margins.acceleration >= wanted:
            continue
        yield f"  {weakest_text(margins.weakest)}"
        if slides_together(margins.weakest):
            yield f"  to slide only above {wanted:.4g} g, it needs a coefficient of friction of more than {wanted:.4g}"
        tips = first_tipping(assembly.problem(), assembly.gravity)
        if tips is not None and tips.acceleration < wanted:
            least = limit_text(tips.acceleration)
            yield f"  tipping begins above {least} g, however good the friction is: {in_short(tips.gives_way)}"
            yield "    a part tips above b/h times g: h is the height of its centre, b its distance from the edge"
            lower = f"{100.0 * (1.0 - tips.acceleration / wanted):.2g} %"
            yield f"    to tip only above {wanted:.4g} g, the centre of what tips must be {lower} lower:"
            yield "    take off its top layer, or put heavy bricks lower"
        apart = margins.apart
        if apart is not None and apart.acceleration is not None and (tips is None or tips.gives_way != apart.gives_way):
            yield f"  {apart_text(apart)}"
