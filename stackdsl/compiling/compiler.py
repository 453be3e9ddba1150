"""Scenario -> timeline: what is placed when and where, in SI, with every name and every time resolved.

The scene is laid out in its own frame, level ground at z = 0; a tilt then turns it as a whole into the world frame W.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import inf

from stability.model import BodyId, Brick, Plane, Quaternion
from stackdsl.compiling.contradictions import beyond_what_is_built, contradictions
from stackdsl.compiling.fitting import Fit, Sited, fits
from stackdsl.compiling.impacts.hits import hits, hitting_bricks, shared_with_hits
from stackdsl.compiling.impacts.removals import missing_bricks, removed_in
from stackdsl.compiling.impacts.scene import Scene, standing_bricks
from stackdsl.compiling.naming import (
    bricks_that_hit,
    footings_of,
    levels_of,
    lofty_levels,
    missed_bricks,
    names_of,
    shared_names,
    unknown_bricks,
)
from stackdsl.compiling.scheduling import Moment, Schedule, scheduled
from stackdsl.compiling.site import planes_of, tilt_of, turned_plane, turned_pose
from stackdsl.compiling.written_bricks import WrittenBrick, bricks_of
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.timeline import Action, Placement, Removal, Timeline, World

MAX_BRICKS = 50_000  # in all steps together; some seconds of compiling
HOLD = 2.0  # [s] watched after the last action unless an expectation says for how long


def compile_timeline(scenario: Scenario, source: Source) -> tuple[Timeline | None, tuple[Diagnostic, ...]]:
    """The timeline of a scenario, or all that keeps it from being built."""
    bricks = sum(step.layout[1].bricks_at_most if step.layout else len(step.bricks or ()) for step in scenario.build)
    bricks += len(scenario.impacts)
    if bricks > MAX_BRICKS:
        message = f"the scenario has {bricks} bricks, and {MAX_BRICKS} is the most"
        return None, (Diagnostic("SD206", source.key_span_of(("build",)), message, "make it smaller"),)
    written, planes = bricks_of(scenario), tuple(planes_of(scenario))
    footings, levels, names, removed = _identified(written, planes, scenario)
    schedule = scheduled(written, levels, names, scenario, source)
    order = sorted(range(len(written)), key=schedule.bricks.__getitem__)
    tilt, hitting = tilt_of(scenario), hitting_bricks(scenario)
    hit: list[tuple[Moment, Action]] = []
    mistakes = [
        *shared_names(written, names, source),
        *shared_with_hits(scenario, hitting, names, source),
        *lofty_levels(written, footings, levels, names, source),
        *schedule.mistakes,
        *unknown_bricks(scenario, source, names, [brick.id for brick in hitting.values()]),
        *missed_bricks(scenario, source),
        *bricks_that_hit(scenario, hitting, source),
        *beyond_what_is_built(scenario, max(levels, default=0), len(names), source),
        *contradictions(scenario, dict(zip(names, levels, strict=True)), _hold(scenario), source),
    ]
    if not schedule.mistakes:  # without the right times, nothing fits
        come = dict(zip(names, schedule.bricks, strict=True))
        come |= {brick.id: schedule.impacts[number] for number, brick in hitting.items()}
        mistakes += missing_bricks(scenario, come, schedule.impacts, source)
        gone = {i: schedule.impacts[step - len(scenario.build)] for i, step in removed.items()}
        found = fits(_sited(written, schedule, gone, order), planes)
        mistakes += _misfits([written[i] for i in order], [names[i] for i in order], found, planes, source)
        standing = tuple(standing_bricks(written, levels, names, schedule.bricks, gone)) if scenario.impacts else ()
        scene = Scene(Moment(0.0), standing, planes, scenario.world.gravity, tilt)
        hit, missed = hits(scenario, hitting, schedule.impacts, scene, source)
        mistakes += missed
    if mistakes:
        return None, tuple(mistakes)
    world = World(scenario.world.gravity, scenario.friction, tuple(turned_plane(plane, tilt) for plane in planes))
    placements = [
        (schedule.bricks[i], _placement(schedule.bricks[i].time, written[i], levels[i], names[i], tilt)) for i in order
    ]
    actions = _in_order(placements, hit, _removals(scenario, schedule))
    claims = (*scenario.expect, *scenario.truth)
    watched = not scenario.expect or not all(claim.needs_statics for claim in claims)
    margins = {key for claim in claims if claim.margin is not None for key in claim.margin.asked}
    closely = any(claim.needs_close_looks for claim in claims)
    return Timeline(world, actions, _hold(scenario), watched, tuple(sorted(margins)), closely), ()


def where_placed(brick: BodyId, scenario: Scenario, source: Source) -> Span:
    """The place in the file of what sets down, throws or drops a brick."""
    for number, hitting in hitting_bricks(scenario).items():
        if hitting.id == brick:
            return source.key_span_of(("impacts", number, "throw" if scenario.impacts[number].throw else "drop"))
    written = bricks_of(scenario)
    _, _, names, _ = _identified(written, tuple(planes_of(scenario)), scenario)
    return source.span_of(written[names.index(brick)].path)


def _placement(time: float, written: WrittenBrick, level: int, name: BodyId, tilt: Quaternion) -> Placement:
    brick = Brick(name, written.shape, written.mass)
    return Placement(time, brick, level, turned_pose(written.pose, tilt), written.drop, written.inserted)


def _removals(scenario: Scenario, schedule: Schedule) -> Iterator[tuple[Moment, Action]]:
    for moment, impact in zip(schedule.impacts, scenario.impacts, strict=True):
        if impact.remove is not None:
            yield moment, Removal(moment.time, impact.remove.names)


def _in_order(*actions: Iterable[tuple[Moment, Action]]) -> tuple[Action, ...]:
    return tuple(action for _, action in sorted(chain(*actions), key=lambda timed: timed[0]))


def _sited(
    written: Sequence[WrittenBrick], schedule: Schedule, gone: Mapping[int, Moment], order: Sequence[int]
) -> list[Sited]:
    """The bricks in an order, each from the moment when it is placed until the one when it is `gone`, by number."""
    turns = {moment: float(turn) for turn, moment in enumerate(sorted({*schedule.bricks, *schedule.impacts}))}
    until = {i: turns[moment] for i, moment in gone.items()}
    return [Sited(turns[schedule.bricks[i]], written[i].shape, written[i].pose, until.get(i, inf)) for i in order]


def _identified(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], scenario: Scenario
) -> tuple[list[Fit], list[int], list[BodyId], Mapping[int, int]]:
    """Footing, level and name of every brick, and, by number, the step that pulls a brick out."""
    removed: Mapping[int, int] = {}
    # Names say what is pulled out, which makes room for what is slid in, whose level then gives it its name.
    for _ in range(2 if scenario.impacts else 1):
        footings = footings_of(written, planes, removed)
        levels = levels_of(written, footings)
        names = names_of(written, levels)
        removed = removed_in(scenario, names)
    return footings, levels, names, removed


def _hold(scenario: Scenario) -> float:
    claims = (*scenario.expect, *scenario.truth)
    spans = [claim.stands.for_ for claim in claims if claim.stands is not None and claim.stands.for_ is not None]
    return max(spans, default=HOLD)


def _misfits(
    bricks: Sequence[WrittenBrick], names: Sequence[str], found: Sequence[Fit], planes: Sequence[Plane], source: Source
) -> Iterator[Diagnostic]:
    """Bricks inside others or in the air; one of a kind for each place in the file, since a layout fails as a whole."""
    told: set[tuple[str, Path]] = set()
    for brick, name, fit in zip(bricks, names, found, strict=True):
        mistake = _misfit(fit, brick, name, names, planes)
        if mistake is not None and (mistake[0], brick.path) not in told:
            told.add((mistake[0], brick.path))
            yield Diagnostic(mistake[0], source.span_of(brick.path), *mistake[1:])


def _misfit(
    fit: Fit, brick: WrittenBrick, name: str, names: Sequence[str], planes: Sequence[Plane]
) -> tuple[str, str, str] | None:
    if fit.overlaps:
        other = f"brick '{names[fit.overlaps_box]}'" if fit.overlaps_box is not None else ""
        plane = planes[fit.overlaps_plane].id if fit.overlaps_plane is not None else ""
        message = f"brick '{name}' is {_mm(fit.depth)} inside {other or plane}"
        return "SD201", message, f"move it out by at least {_mm(fit.depth)}{', such as by `origin`' * brick.of_layout}"
    if fit.in_the_air and not brick.drop:
        above = "" if fit.clearance == inf else f"; the nearest body below is {_mm(fit.clearance)} away"
        hint = "place it on something, or say `drop: true` to let it fall"
        if brick.of_layout:
            hint = "give the layout measures with which every brick lies on another, or an `origin` on top of something"
        return "SD202", f"nothing is under brick '{name}'{above}", hint
    return None


def _mm(length: float) -> str:
    return f"{1000.0 * length:.4g} mm"
