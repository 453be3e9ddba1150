"""All impacts of a scenario: as actions of the timeline, and what keeps some of them from being as they are written."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from stability.model import BodyId
from stackdsl.compiling.built import Built
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.flights import Coming, Crossing, crossings
from stackdsl.compiling.impacts.pushes import limit_push
from stackdsl.compiling.impacts.scene import MissError, Scene, scene_of
from stackdsl.compiling.moment import Moment
from stackdsl.compiling.site import tilt_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts.impact_kind import ImpactKind
from stackdsl.language.named import named_in
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source
from stackdsl.timeline import Action, Placement, Push
from stackdsl.wording import mm


@dataclass
class Done:
    """What all impacts come to."""

    actions: list[tuple[Moment, Action]] = field(default_factory=list)
    mistakes: list[Diagnostic] = field(default_factory=list)


def done(built: Built, scenario: Scenario, source: Source) -> Done:
    """The actions of all impacts, impact by impact."""
    found = Done()
    if not scenario.impacts:
        return found
    scene = scene_of(built, scenario.world.gravity, tilt_of(scenario))
    known = {*(brick.name for brick in scene.bricks), *scene.flying}
    coming: list[Coming] = []
    for number, (impact, moment) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
        if any(named.name not in known for named in named_in(impact)):
            continue  # a brick that nobody builds is told elsewhere
        try:
            actions = _actions(impact.done, replace(scene, moment=moment, missile=built.missiles.get(number)))
        except MissError as miss:
            span = source.span_of(("impacts", number, impact.kind, miss.key))
            found.mistakes.append(Diagnostic(miss.code, span, miss.message, miss.hint))
        else:
            found.actions += [(moment._replace(time=action.time), action) for action in actions]
            coming += [Coming(number, moment, action) for action in actions if isinstance(action, Placement)]
    blocked = crossings(coming, _struck(built, scenario), scene.gravity)
    found.mistakes += [_blocked(crossing, scenario, source) for crossing in blocked]
    return found


def _actions(done: ImpactKind, scene: Scene) -> tuple[Action, ...]:
    """What an impact comes to, within the limits that hold for every kind. Raises MissError."""
    actions = actions_of(done, scene)
    for action in actions:
        if isinstance(action, Push):
            limit_push(action, scene)
    return actions


def _struck(built: Built, scenario: Scenario) -> Mapping[BodyId, Moment]:
    """When a brick is first pulled out or pushed."""
    found: dict[BodyId, Moment] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        for name in impact.done.struck:
            found.setdefault(name, moment)
    return found


def _blocked(crossing: Crossing, scenario: Scenario, source: Source) -> Diagnostic:
    later, earlier = crossing.later, crossing.earlier
    here, there = (
        source.key_span_of(("impacts", one.number, scenario.impacts[one.number].kind)) for one in (later, earlier)
    )
    message = (
        f"brick '{later.placement.brick.id}' begins {mm(crossing.depth)} inside "
        f"brick '{earlier.placement.brick.id}', which is still on its way from {there.seen_from(here)}"
    )
    hint = f"let it come later, such as `after: impact {earlier.number + 1} + 0.5 s`, or from elsewhere"
    return Diagnostic("SD201", here, message, hint)
