"""Scenario -> timeline: what is placed when and where, in SI, with every name and every time resolved.

The scene is laid out in its own frame, level ground at z = 0; a tilt then turns it as a whole into the world frame W.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import inf
from typing import Final, TypeAlias

from stability.friction_law import GivenFriction
from stability.model import BodyId, Brick, Plane, Quaternion
from stackdsl.compiling.asked import asked_of
from stackdsl.compiling.built import Built, built_of, missiles_of
from stackdsl.compiling.built_bricks import BuiltBrick, built_bricks
from stackdsl.compiling.by_hand import bringing, brought, hands_that_bring, placed_by_hand
from stackdsl.compiling.contradictions import beyond_what_is_built, contradictions
from stackdsl.compiling.frictions import friction_of, mispaired
from stackdsl.compiling.hands_apart import hands_apart, ways_through_planes
from stackdsl.compiling.impacts.doing import Done, done
from stackdsl.compiling.impacts.removals import missing_bricks
from stackdsl.compiling.margin_limits import too_many_in_margins, too_many_pairs
from stackdsl.compiling.misfits import crowded
from stackdsl.compiling.moment import Moment
from stackdsl.compiling.name_checks import (
    bricks_that_hit,
    lofty_levels,
    missed_bricks,
    shared_names,
    shared_with_missiles,
    unknown_bricks,
)
from stackdsl.compiling.naming import CrowdedBrickError
from stackdsl.compiling.neighbour_checks import nowhere, out_of_place
from stackdsl.compiling.shakes import shakes
from stackdsl.compiling.site import planes_of, tilt_of, turned_plane, turned_pose
from stackdsl.compiling.slivers import slivers
from stackdsl.diagnostics import Diagnostic, Span, first_of
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source
from stackdsl.timeline import Action, Arrival, Jitter, Placement, Timeline, World

MAX_BRICKS = 50_000  # in all steps together; some seconds of compiling
MAX_MEETINGS = 600_000  # bricks that each thrown or dropped one may meet, of all of these; some seconds

Check: TypeAlias = Callable[[Built, Scenario, Source], Iterable[Diagnostic]]

CHECKS: Final[Sequence[Check]] = (
    too_many_pairs,
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
    impacts = Done() if built.mistimed else done(built, scenario, source)
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


def _world(scenario: Scenario, friction: GivenFriction, planes: tuple[Plane, ...]) -> World:
    touching = scenario.world.touching
    return World(scenario.world.gravity, friction, planes, inf if touching is None else touching)


def _timeline(built: Built, impacts: Iterable[tuple[Moment, Action]], scenario: Scenario) -> Timeline:
    tilt, asked = tilt_of(scenario), asked_of(scenario)
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
        told_margins=asked.told_margins,
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
