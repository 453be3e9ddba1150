"""Compiles a scenario to a timeline: the actions in SI units, with all names and times resolved."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import cos, inf, sin
from typing import Final, TypeAlias

from stability.contact_law import Friction, GivenFriction, Rule
from stability.dynamics.ground_motion import Component, GroundMotion
from stability.model import BodyId, Brick, Plane, Quaternion
from stackdsl.compiler.bricks import ActionOrder, CrowdedBrickError, ResolvedBrick, resolved_bricks
from stackdsl.compiler.checks import (
    bricks_of_several_parts,
    claims_about_missiles,
    claims_about_removed_bricks,
    contradictions,
    crowded,
    duplicate_missile_names,
    duplicate_names,
    excessive_counts,
    excessive_levels,
    misplaced_bricks,
    missing_neighbours,
    requirements_of,
    slivers,
    too_many_in_margins,
    too_many_points,
    unknown_bricks,
)
from stackdsl.compiler.hands import (
    actions_on_held_bricks,
    blocked_carrying,
    carried_bricks,
    carried_placement,
    carrying_actions,
    moves_through_planes,
)
from stackdsl.compiler.impacts import ImpactActions, early_removals, impact_actions
from stackdsl.compiler.joints import invalid_joints, joints_in_time
from stackdsl.compiler.loads import invalid_loads, loads_in_time
from stackdsl.compiler.round_bricks import unsupported_round_bricks
from stackdsl.compiler.schedule import (
    ResolvedScenario,
    missiles_of,
    planes_of,
    resolved_scenario,
    tilt_of,
    turned_plane,
    turned_pose,
)
from stackdsl.compiler.strengths import strengths_of, unsupported_strengths
from stackdsl.compiler.supports import invalid_supports, support_motions
from stackdsl.compiler.ties import invalid_ties, ties_of
from stackdsl.diagnostics import Diagnostic, Span, capped, did_you_mean
from stackdsl.language.bricks import CATALOGUE, BrickKind
from stackdsl.language.schema import PairOfBodies, Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import (
    Action,
    Arrival,
    FixedWorld,
    HoldAction,
    Jitter,
    JointChange,
    JointsAction,
    LoadsAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
)

# The origin of an action in the scenario file.


ROUNDING = 1e-9  # [s] rounding error of computed times


@dataclass(frozen=True, slots=True)
class Origin:
    """A build step or an impact."""

    part: str  # `build step`, `impact` or `load`
    number: int  # from 1
    kind: str  # such as `column`, `bricks`, `remove`
    span: Span


def origin_of(action: Action, scenario: Scenario, source: Source) -> Origin | None:
    """Return the origin of an action; None if it has none in the file."""
    if isinstance(action, ShakeAction):
        return None
    built = resolved_scenario(scenario, source)
    if isinstance(action, JointsAction):
        acted = [number for number, begins in enumerate(built.impacts) if begins.time == action.time]
        return _impact(acted[0], scenario, source) if acted and action.change is not JointChange.SET else None
    if isinstance(action, LoadsAction):
        number = next(number for number, begins in enumerate(built.loaded) if begins.time == action.time)
        kind = scenario.loads[number].kind
        return Origin("load", number + 1, kind, source.key_span_of(("loads", number, kind)))
    if not isinstance(action, Placement):
        named = set(action.bricks if isinstance(action, Removal | HoldAction | ReleaseAction) else (action.brick,))
        for number, (impact, begins) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
            struck = {*impact.content.struck, *(each.name for each in impact.content.pulled_out)}
            ends = begins.time + impact.content.lasts
            if begins.time - ROUNDING <= action.time <= ends + ROUNDING and named & struck:
                return _impact(number, scenario, source)
        if isinstance(action, Removal | PushAction):
            return None
        brick = next(iter(named))  # an action of a hand
    else:
        brick = action.brick.id
    for number, missile in built.missiles.items():
        if missile.id == brick:
            return _impact(number, scenario, source)
    return _of_brick(brick, [(each.name, each.written.path) for each in built.bricks], scenario, source)


def _of_brick(
    brick: BodyId, written: Sequence[tuple[BodyId, KeyPath]], scenario: Scenario, source: Source
) -> Origin | None:
    path = next((path for name, path in written if name == brick), None)
    if path is None:
        return None
    part, number, *_ = path
    assert isinstance(number, int)
    if part == "impacts":
        return _impact(number, scenario, source)
    return Origin("build step", number + 1, str(path[2]), source.key_span_of(path))


def _impact(number: int, scenario: Scenario, source: Source) -> Origin:
    kind = scenario.impacts[number].kind
    return Origin("impact", number + 1, kind, source.key_span_of(("impacts", number, kind)))


# The friction law, from the frictions of kinds, bricks and pairs in the scenario.


def friction_of(built: ResolvedScenario, scenario: Scenario) -> GivenFriction:
    """Return the single coefficient of a scenario, or its friction law if frictions differ."""
    kinds = _kinds(built, scenario)
    # By the name of the kind, or of the brick for an unnamed kind or if a brick has that name.
    own = {
        name if kind.kind_name in kinds or not kind.kind_name else kind.kind_name: kind.friction
        for name, kind in kinds.items()
        if kind.friction is not None
    }
    own |= {brick.name: brick.written.friction for brick in built.bricks if brick.written.friction is not None}
    between = {pair.pair: pair.friction for pair in scenario.world.friction.between}
    if not own and not between:
        return scenario.friction
    named = {*own, *(name for pair in between for name in pair)}
    kind_names = {name: kind.kind_name for name, kind in kinds.items() if kind.kind_name in named}
    return Friction(scenario.friction, own, between, kind_names, Rule(scenario.world.friction.rule))


def _kinds(built: ResolvedScenario, scenario: Scenario) -> Mapping[BodyId, BrickKind]:
    """Return the kind of each brick, including those that impacts throw or drop."""
    flying = {
        brick.id: (missile.brick if (missile := scenario.impacts[number].content.missile) else None) or scenario.brick
        for number, brick in built.missiles.items()
    }
    return {brick.name: brick.written.kind for brick in built.bricks} | flying


def invalid_friction_pairs(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report friction pairs with unknown names, pairs that never touch, and contradictory pairs."""
    pairs = scenario.world.friction.between
    bricks = {brick.name for brick in built.bricks} | {brick.id for brick in built.missiles.values()}
    planes, kinds = {plane.id for plane in built.planes}, {*scenario.brick_types, *CATALOGUE}
    for number, each in enumerate(pairs):
        span = source.span_of(("world", "friction", "between", number, "pair"))
        for place, name in enumerate(each.pair):
            there = source.span_of(("world", "friction", "between", number, "pair", place))
            if name not in bricks | planes | kinds:
                hint = did_you_mean(name, (*kinds, *sorted(planes), *sorted(bricks)))
                hint = hint or "write the name of a kind of brick, a brick, the ground or a wall"
                yield Diagnostic("SD204", there, f"there is no brick or kind of brick '{name}'", hint)
            elif name in kinds and name in bricks | planes:
                message = f"'{name}' is the name of both a body and a kind of brick"
                yield Diagnostic("SD203", there, message, "rename one of them")
        one, other = each.pair
        if one == other and one in bricks:
            yield Diagnostic(
                "SD104", span, f"'{one}' is a single brick, which cannot touch itself", "write two different bodies"
            )
        elif {one, other} <= planes:
            yield Diagnostic(
                "SD104",
                span,
                "both bodies are fixed, so no friction acts between them",
                "write at least one brick or kind of brick",
            )
    yield from _contradictory_repeats(pairs, source)
    yield from _ambiguous_pairs(built, scenario, source, bricks)


def _contradictory_repeats(pairs: Sequence[PairOfBodies], source: Source) -> Iterator[Diagnostic]:
    first: dict[frozenset[str], int] = {}
    for number, each in enumerate(pairs):
        earlier = first.setdefault(frozenset(each.pair), number)
        if pairs[earlier].friction != each.friction:
            here, there = _lines(source, number, earlier)
            message = f"this pair already has a friction coefficient of {pairs[earlier].friction:g}, at {there}"
            yield Diagnostic("SD104", here, message, "keep one of them")


def _lines(source: Source, number: int, earlier: int) -> tuple[Span, str]:
    """Return the position of one pair, and the text of the position of another."""
    here = source.span_of(("world", "friction", "between", number))
    return here, source.span_of(("world", "friction", "between", earlier)).seen_from(here)


def _ambiguous_pairs(
    built: ResolvedScenario, scenario: Scenario, source: Source, bricks: set[BodyId]
) -> Iterator[Diagnostic]:
    """Report two bricks with two different frictions: each brick is in a pair with the kind of the other one."""
    pairs = scenario.world.friction.between
    kind_names = {name: kind.kind_name for name, kind in _kinds(built, scenario).items()}
    mixed = [
        (number, brick, kind)
        for number, each in enumerate(pairs)
        for brick, kind in (each.pair, each.pair[::-1])
        if brick in bricks and kind not in bricks
    ]
    explicit = {frozenset(each.pair) for each in pairs}
    for (first, a, kind_of_b), (second, b, kind_of_a) in combinations(mixed, 2):
        if a == b or kind_names.get(a) != kind_of_a or kind_names.get(b) != kind_of_b or frozenset((a, b)) in explicit:
            continue
        if pairs[first].friction != pairs[second].friction:
            here, there = _lines(source, second, first)
            message = f"this line and the line at {there} specify different friction coefficients for {a} and {b}"
            yield Diagnostic("SD104", here, message, f"add the pair [{a}, {b}]")


# The ground motion.


def shakes(built: ResolvedScenario, scenario: Scenario) -> Iterator[tuple[ActionOrder, ShakeAction]]:
    """Yield the action of a shaking ground; its directions are horizontal or vertical in W, also in a tilted scene."""
    shake, moment = scenario.world.shake, built.shaken
    if shake is not None and moment is not None:
        # Rounded to digits on which all processors agree.
        x, y = round(cos(shake.bearing), 15), round(sin(shake.bearing), 15)
        directions_W = {"across": (0.0 - y, x, 0.0), "up": (0.0, 0.0, 1.0)}
        beside = tuple(Component(course, directions_W[name]) for name, course in sorted(shake.beside.items()))
        yield moment, ShakeAction(moment.time, GroundMotion(shake.course, (x, y, 0.0), moment.time, beside))


# The timeline.
#
# The scene is compiled in its own frame, with level ground at z = 0. A tilt rotates it as a whole into W.


MAX_BRICKS = 30_000  # in all steps together; a run of so many takes 20 s and 400 MB
MAX_MEETINGS = 600_000  # pairs of a thrown or dropped brick and a brick that it may meet; takes some seconds

Check: TypeAlias = Callable[[ResolvedScenario, Scenario, Source], Iterable[Diagnostic]]

CHECKS: Final[Sequence[Check]] = (
    too_many_points,
    duplicate_names,
    duplicate_missile_names,
    excessive_levels,
    slivers,
    lambda built, _scenario, _source: built.timing_mistakes,
    unknown_bricks,
    claims_about_removed_bricks,
    claims_about_missiles,
    excessive_counts,
    contradictions,
    invalid_friction_pairs,
    invalid_joints,
    invalid_loads,
    bricks_of_several_parts,
    unsupported_round_bricks,
    invalid_supports,
    unsupported_strengths,
    invalid_ties,
)
CHECKS_IN_TIME: Final[Sequence[Check]] = (
    early_removals,
    misplaced_bricks,
    blocked_carrying,
    actions_on_held_bricks,
    moves_through_planes,
)  # these need valid times


def compile_timeline(scenario: Scenario, source: Source) -> tuple[Timeline | None, tuple[Diagnostic, ...]]:
    """Return the timeline of a scenario, or None and its mistakes."""
    too_many = tuple(_too_many(scenario, source))
    if too_many:
        return None, too_many
    try:
        built = resolved_scenario(scenario, source)
    except CrowdedBrickError as error:
        return None, (crowded(error.brick, source),)
    if unresolved := capped(missing_neighbours(built, scenario, source)):
        return None, tuple(unresolved)
    checks = CHECKS if built.timing_mistakes else (*CHECKS, *CHECKS_IN_TIME)
    impacts = ImpactActions() if built.timing_mistakes else impact_actions(built, scenario, source)
    reported = (mistake for check in checks for mistake in check(built, scenario, source))
    mistakes = capped(chain(reported, impacts.mistakes))
    return (None if mistakes else _timeline(built, impacts.actions, scenario)), tuple(mistakes)


def bricks_at_most(scenario: Scenario) -> int:
    """Return an upper bound of the number of bricks of a scenario, without building it."""
    built = sum(step.layout[1].bricks_at_most if step.layout else len(step.bricks or ()) for step in scenario.build)
    return built + len(scenario.impacts)


def where_placed(brick: BodyId, scenario: Scenario, source: Source) -> Span:
    """Return the position in the file of the step or impact that places a brick."""
    return places_of(scenario, source)[brick]


def places_of(scenario: Scenario, source: Source) -> Mapping[BodyId, Span]:
    """Return the position in the file of the step or impact that places each brick."""
    bricks = resolved_bricks(scenario, tuple(planes_of(scenario)))
    hitting = {
        missile.id: source.key_span_of(("impacts", number, scenario.impacts[number].kind))
        for number, missile in missiles_of(scenario).items()
    }
    return {built.name: source.span_of(built.written.path) for built in bricks} | hitting


def _too_many(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    bricks = bricks_at_most(scenario)
    if bricks > MAX_BRICKS:
        message = f"the scenario has {bricks} bricks; the maximum is {MAX_BRICKS}"
        yield Diagnostic("SD206", source.key_span_of(("build",)), message, "use fewer bricks")
    flying = sum(impact.content.missile is not None for impact in scenario.impacts)
    if flying * bricks > MAX_MEETINGS:
        message = f"the checks of {flying} thrown or dropped bricks against {bricks} bricks take too long"
        hint = f"reduce the product of both numbers to at most {MAX_MEETINGS}"
        yield Diagnostic("SD206", source.key_span_of(("impacts",)), message, hint)
    yield from too_many_in_margins(bricks, scenario, source)


def _world(built: ResolvedScenario, scenario: Scenario, planes: tuple[Plane, ...]) -> FixedWorld:
    touching, friction = scenario.world.touching, friction_of(built, scenario)
    within = inf if touching is None else touching
    motions = support_motions(built, scenario)
    strengths, ties = strengths_of(built, scenario), ties_of(built, scenario)
    gravity = scenario.world.gravity
    return FixedWorld(gravity, friction, planes, within, strengths=strengths, supports=motions, ties=ties)


def _timeline(built: ResolvedScenario, impacts: Iterable[tuple[ActionOrder, Action]], scenario: Scenario) -> Timeline:
    tilt, requirements = tilt_of(scenario), requirements_of(scenario)
    planes = tuple(turned_plane(plane, tilt) for plane in built.planes)
    steps = _steps_by_level(built)
    placed = {brick.name: _placement(brick, tilt, step_text(brick, scenario, steps)) for brick in built.in_order}
    by_hand = carried_bricks(built, scenario)
    placed |= {carried.brick.name: carried_placement(placed[carried.brick.name], carried, tilt) for carried in by_hand}
    others = placed.keys() - {carried.brick.name for carried in by_hand}
    placements = [(brick.placed, placed[brick.name]) for brick in built.in_order if brick.name in others]
    joints, joining = joints_in_time(built, scenario)
    others_in_time: list[tuple[ActionOrder, Action]] = [
        *joining,
        *shakes(built, scenario),
        *loads_in_time(built, scenario),
    ]
    return Timeline(
        replace(_world(built, scenario, planes), joints=joints),
        tuple(
            action
            for _, action in sorted(
                (*placements, *carrying_actions(by_hand, placed, tilt), *impacts, *others_in_time),
                key=lambda timed: timed[0],
            )
        ),
        hold=requirements.hold,
        watched=requirements.watched,
        margins=requirements.margins,
        reported_margins=requirements.reported_margins,
        measures=requirements.measures,
        tests=requirements.tests,
        closely=requirements.closely,
        followed=requirements.followed,
        jitter=_jitter(built, scenario),
    )


def _jitter(built: ResolvedScenario, scenario: Scenario) -> Mapping[BodyId, Jitter]:
    """Return the placement errors of the bricks that have some."""
    errors = {number: step.jitter.jitter for number, step in enumerate(scenario.build) if step.jitter is not None}
    return {brick.name: errors[brick.written.step] for brick in built.bricks if brick.written.step in errors}


def _steps_by_level(built: ResolvedScenario) -> Mapping[int, set[int]]:
    """Return the steps that build each level; several do, since every layout counts its levels from 1."""
    steps: defaultdict[int, set[int]] = defaultdict(set)
    for brick in built.bricks:
        steps[brick.level].add(brick.written.step)
    return steps


def step_text(brick: ResolvedBrick, scenario: Scenario, steps: Mapping[int, set[int]]) -> str:
    """Return the text about the step of a brick; "" if its level alone identifies the step."""
    step = brick.written.step
    if brick.written.inserted or len(steps[brick.level]) == 1:
        return ""
    name = scenario.build[step].name
    return f"step {step + 1}" + (f" '{name}'" if name else "")


def _placement(brick: ResolvedBrick, tilt: Quaternion, step: str) -> Placement:
    written = brick.written
    arrival = Arrival.LET_GO if written.drop else Arrival.SLID_IN if written.inserted else Arrival.SET_DOWN
    pose = turned_pose(written.pose, tilt)
    return Placement(
        brick.placed.time,
        Brick(brick.name, written.shape, written.mass),
        brick.level,
        pose,
        arrival,
        step=step,
        together=written.together,
    )
