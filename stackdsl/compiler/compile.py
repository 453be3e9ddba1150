"""Scenario -> timeline: what is placed when and where, in SI, with every name and time resolved."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations
from math import cos, inf, sin
from typing import Final, TypeAlias

from stability.contact_law import Friction, GivenFriction, Rule
from stability.dynamics.ground_motion import GroundMotion
from stability.model import BodyId, Brick, Plane, Quaternion
from stackdsl.compiler.bricks import ActionOrder, BuiltBrick, CrowdedBrickError, built_bricks
from stackdsl.compiler.checks import (
    beyond_what_is_built,
    bricks_that_hit,
    contradictions,
    crowded,
    lofty_levels,
    missed_bricks,
    nowhere,
    out_of_place,
    requirements_of,
    shared_names,
    shared_with_missiles,
    slivers,
    unknown_bricks,
)
from stackdsl.compiler.hands import (
    bringing,
    brought,
    hands_apart,
    hands_that_bring,
    placed_by_hand,
    ways_through_planes,
)
from stackdsl.compiler.impacts import ImpactActions, done, missing_bricks
from stackdsl.compiler.margin_limits import too_many_in_margins, too_many_points
from stackdsl.compiler.schedule import Built, built_of, missiles_of, planes_of, tilt_of, turned_plane, turned_pose
from stackdsl.diagnostics import Diagnostic, Span, did_you_mean, first_of
from stackdsl.language.bricks import CATALOGUE, BrickKind
from stackdsl.language.schema import PairOfBodies, Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import (
    Action,
    Arrival,
    FixedWorld,
    HoldAction,
    Jitter,
    LetGo,
    Placement,
    PushAction,
    Removal,
    ShakeAction,
    Timeline,
)

# Which line of a scenario an action of its timeline comes from.


ROUNDING = 1e-9  # [s] of times that are worked out from others


@dataclass(frozen=True, slots=True)
class Origin:
    """A step of the build or an impact, as its author counts it."""

    part: str  # `build step` or `impact`
    number: int  # from 1
    kind: str  # such as `column`, `bricks`, `remove`
    span: Span


def origin_of(action: Action, scenario: Scenario, source: Source) -> Origin | None:
    """Where an action is written; None where nothing says so."""
    if isinstance(action, ShakeAction):
        return None
    built = built_of(scenario, source)
    if not isinstance(action, Placement):
        named = set(action.bricks if isinstance(action, Removal | HoldAction | LetGo) else (action.brick,))
        for number, (impact, begins) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
            struck = {*impact.done.struck, *(each.name for each in impact.done.pulled_out)}
            ends = begins.time + impact.done.lasts
            if begins.time - ROUNDING <= action.time <= ends + ROUNDING and named & struck:
                return _impact(number, scenario, source)
        if isinstance(action, Removal | PushAction):
            return None
        brick = next(iter(named))  # a hand brought it
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


# Who rubs how on whom: what a scenario says of kinds, bricks and pairs -> the law that everybody asks.


def friction_of(built: Built, scenario: Scenario) -> GivenFriction:
    """One coefficient where nothing else is said, and else the whole law."""
    kinds = _kinds(built, scenario)
    # Of its kind, unless a brick is called as that.
    own = {
        name if kind.called in kinds or not kind.called else kind.called: kind.friction
        for name, kind in kinds.items()
        if kind.friction is not None
    }
    own |= {brick.name: brick.written.friction for brick in built.bricks if brick.written.friction is not None}
    between = {pair.pair: pair.friction for pair in scenario.world.friction.between}
    if not own and not between:
        return scenario.friction
    named = {*own, *(name for pair in between for name in pair)}
    called = {name: kind.called for name, kind in kinds.items() if kind.called in named}
    return Friction(scenario.friction, own, between, called, Rule(scenario.world.friction.rule))


def _kinds(built: Built, scenario: Scenario) -> Mapping[BodyId, BrickKind]:
    """What each brick is, also those that impacts throw or drop."""
    flying = {
        brick.id: (missile.brick if (missile := scenario.impacts[number].done.missile) else None) or scenario.brick
        for number, brick in built.missiles.items()
    }
    return {brick.name: brick.written.kind for brick in built.bricks} | flying


def mispaired(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Pairs of what is not there, of what never meets, and pairs of which two things are said."""
    pairs = scenario.world.friction.between
    bricks = {brick.name for brick in built.bricks} | {brick.id for brick in built.missiles.values()}
    planes, kinds = {plane.id for plane in built.planes}, {*scenario.brick_types, *CATALOGUE}
    for number, each in enumerate(pairs):
        span = source.span_of(("world", "friction", "between", number, "pair"))
        for place, name in enumerate(each.pair):
            there = source.span_of(("world", "friction", "between", number, "pair", place))
            if name not in bricks | planes | kinds:
                hint = did_you_mean(name, (*kinds, *sorted(planes), *sorted(bricks)))
                hint = hint or "name a kind of brick, a brick, the ground or a wall"
                yield Diagnostic("SD204", there, f"there is no brick '{name}', nor a kind of that name", hint)
            elif name in kinds and name in bricks | planes:
                message = f"'{name}' is a body and a kind of brick"
                yield Diagnostic("SD203", there, message, "call one of them otherwise")
        one, other = each.pair
        if one == other and one in bricks:
            yield Diagnostic(
                "SD104", span, f"'{one}' is one brick, and rubs on no other of its name", "name two bodies"
            )
        elif {one, other} <= planes:
            yield Diagnostic("SD104", span, "what never moves does not rub on its like", "name a brick, or a kind")
    yield from _said_twice(pairs, source)
    yield from _crossing(built, scenario, source, bricks)


def _said_twice(pairs: Sequence[PairOfBodies], source: Source) -> Iterator[Diagnostic]:
    first: dict[frozenset[str], int] = {}
    for number, each in enumerate(pairs):
        earlier = first.setdefault(frozenset(each.pair), number)
        if pairs[earlier].friction != each.friction:
            here, there = _lines(source, number, earlier)
            message = f"of this pair {pairs[earlier].friction:g} is said already, at {there}"
            yield Diagnostic("SD104", here, message, "keep one of them")


def _lines(source: Source, number: int, earlier: int) -> tuple[Span, str]:
    """Where one pair is said, and where another is, as seen from there."""
    here = source.span_of(("world", "friction", "between", number))
    return here, source.span_of(("world", "friction", "between", earlier)).seen_from(here)


def _crossing(built: Built, scenario: Scenario, source: Source, bricks: set[BodyId]) -> Iterator[Diagnostic]:
    """Two pairs, each of one brick and the kind of the other's, which say two things of the same two bricks."""
    pairs = scenario.world.friction.between
    called = {name: kind.called for name, kind in _kinds(built, scenario).items()}
    mixed = [
        (number, brick, kind)
        for number, each in enumerate(pairs)
        for brick, kind in (each.pair, each.pair[::-1])
        if brick in bricks and kind not in bricks
    ]
    told = {frozenset(each.pair) for each in pairs}
    for (first, a, kind_of_b), (second, b, kind_of_a) in combinations(mixed, 2):
        if a == b or called.get(a) != kind_of_a or called.get(b) != kind_of_b or frozenset((a, b)) in told:
            continue
        if pairs[first].friction != pairs[second].friction:
            here, there = _lines(source, second, first)
            message = f"{a} and {b} are a pair of this line and of that at {there}, which say different things"
            yield Diagnostic("SD104", here, message, f"say what [{a}, {b}] have")


# How and when the ground shakes, as an action of the timeline.


def shakes(built: Built, scenario: Scenario) -> Iterator[tuple[ActionOrder, ShakeAction]]:
    """What the ground does, if it moves at all: level, also where the scene is tilted."""
    shake, moment = scenario.world.shake, built.shaken
    if shake is not None and moment is not None:
        # Rounded to where processors agree on them.
        direction_W = (round(cos(shake.bearing), 15), round(sin(shake.bearing), 15), 0.0)
        yield moment, ShakeAction(moment.time, GroundMotion(shake.course, direction_W, moment.time))


# Scenario -> timeline: what is placed when and where, in SI, with every name and every time resolved.
#
# The scene is laid out in its own frame, level ground at z = 0; a tilt then turns it as a whole into the world frame W.


MAX_BRICKS = 50_000  # in all steps together; some seconds of compiling
MAX_MEETINGS = 600_000  # bricks that each thrown or dropped one may meet, of all of these; some seconds

Check: TypeAlias = Callable[[Built, Scenario, Source], Iterable[Diagnostic]]

CHECKS: Final[Sequence[Check]] = (
    too_many_points,
    shared_names,
    shared_with_missiles,
    lofty_levels,
    slivers,
    lambda built, _scenario, _source: built.mistimed,
    unknown_bricks,
    missed_bricks,
    bricks_that_hit,
    beyond_what_is_built,
    contradictions,
    mispaired,
)
CHECKS_IN_TIME: Final[Sequence[Check]] = (
    missing_bricks,
    out_of_place,
    hands_that_bring,
    hands_apart,
    ways_through_planes,
)  # without the right times, nothing fits


def compile_timeline(scenario: Scenario, source: Source) -> tuple[Timeline | None, tuple[Diagnostic, ...]]:
    """The timeline of a scenario, or all that keeps it from being built."""
    too_many = tuple(_too_many(scenario, source))
    if too_many:
        return None, too_many
    try:
        built = built_of(scenario, source)
    except CrowdedBrickError as error:
        return None, (crowded(error.brick, source),)
    if lost := first_of(nowhere(built, scenario, source)):
        return None, tuple(lost)
    checks = CHECKS if built.mistimed else (*CHECKS, *CHECKS_IN_TIME)
    impacts = ImpactActions() if built.mistimed else done(built, scenario, source)
    found = (mistake for check in checks for mistake in check(built, scenario, source))
    mistakes = first_of(chain(found, impacts.mistakes))
    return (None if mistakes else _timeline(built, impacts.actions, scenario)), tuple(mistakes)


def bricks_at_most(scenario: Scenario) -> int:
    """How many bricks there are in a scenario at most; nothing has to be built to know."""
    built = sum(step.layout[1].bricks_at_most if step.layout else len(step.bricks or ()) for step in scenario.build)
    return built + len(scenario.impacts)


def where_placed(brick: BodyId, scenario: Scenario, source: Source) -> Span:
    """The place in the file of what sets down, throws or drops a brick."""
    return places_of(scenario, source)[brick]


def places_of(scenario: Scenario, source: Source) -> Mapping[BodyId, Span]:
    """The place in the file of what sets down, throws or drops each brick."""
    bricks = built_bricks(scenario, tuple(planes_of(scenario)))
    hitting = {
        missile.id: source.key_span_of(("impacts", number, scenario.impacts[number].kind))
        for number, missile in missiles_of(scenario).items()
    }
    return {built.name: source.span_of(built.written.path) for built in bricks} | hitting


def _too_many(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    bricks = bricks_at_most(scenario)
    if bricks > MAX_BRICKS:
        message = f"the scenario has {bricks} bricks, and {MAX_BRICKS} is the most"
        yield Diagnostic("SD206", source.key_span_of(("build",)), message, "make it smaller")
    flying = sum(impact.done.missile is not None for impact in scenario.impacts)
    if flying * bricks > MAX_MEETINGS:
        message = f"{flying} bricks are thrown or dropped where {bricks} may be in the way of each"
        hint = f"let one times the other be at most {MAX_MEETINGS}"
        yield Diagnostic("SD206", source.key_span_of(("impacts",)), message, hint)
    yield from too_many_in_margins(bricks, scenario, source)


def _world(scenario: Scenario, friction: GivenFriction, planes: tuple[Plane, ...]) -> FixedWorld:
    touching = scenario.world.touching
    return FixedWorld(scenario.world.gravity, friction, planes, inf if touching is None else touching)


def _timeline(built: Built, impacts: Iterable[tuple[ActionOrder, Action]], scenario: Scenario) -> Timeline:
    tilt, asked = tilt_of(scenario), requirements_of(scenario)
    planes = tuple(turned_plane(plane, tilt) for plane in built.planes)
    steps = _steps_by_level(built)
    placed = {brick.name: _placement(brick, tilt, step_text(brick, scenario, steps)) for brick in built.in_order}
    in_hands = brought(built, scenario)
    placed |= {one.brick.name: placed_by_hand(placed[one.brick.name], one, tilt) for one in in_hands}
    alone = placed.keys() - {one.brick.name for one in in_hands}
    placements = [(brick.placed, placed[brick.name]) for brick in built.in_order if brick.name in alone]
    return Timeline(
        _world(scenario, friction_of(built, scenario), planes),
        tuple(
            action
            for _, action in sorted(
                (*placements, *bringing(in_hands, placed, tilt), *impacts, *shakes(built, scenario)),
                key=lambda timed: timed[0],
            )
        ),
        hold=asked.hold,
        watched=asked.watched,
        margins=asked.margins,
        reported_margins=asked.reported_margins,
        measures=asked.measures,
        closely=asked.closely,
        followed=asked.followed,
        jitter=_jitter(built, scenario),
    )


def _jitter(built: Built, scenario: Scenario) -> Mapping[BodyId, Jitter]:
    """The errors with which bricks are set down, by brick, of those that have some."""
    errors = {number: step.jitter.jitter for number, step in enumerate(scenario.build) if step.jitter is not None}
    return {brick.name: errors[brick.written.step] for brick in built.bricks if brick.written.step in errors}


def _steps_by_level(built: Built) -> Mapping[int, set[int]]:
    """Which steps build each level: those of a layout count from 1, wherever it stands."""
    found: defaultdict[int, set[int]] = defaultdict(set)
    for brick in built.bricks:
        found[brick.level].add(brick.written.step)
    return found


def step_text(brick: BuiltBrick, scenario: Scenario, steps: Mapping[int, set[int]]) -> str:
    """The step that builds a brick, where its level alone does not tell; empty otherwise."""
    step = brick.written.step
    if brick.written.inserted or len(steps[brick.level]) == 1:
        return ""
    name = scenario.build[step].name
    return f"step {step + 1}" + (f" '{name}'" if name else "")


def _placement(brick: BuiltBrick, tilt: Quaternion, step: str) -> Placement:
    made = brick.written
    arrival = Arrival.LET_GO if made.drop else Arrival.SLID_IN if made.inserted else Arrival.SET_DOWN
    pose = turned_pose(made.pose, tilt)
    return Placement(
        brick.placed.time,
        Brick(brick.name, made.shape, made.mass),
        brick.level,
        pose,
        arrival,
        step=step,
        together=made.together,
    )
