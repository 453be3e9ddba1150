"""What hits the structure: thrown and dropped bricks, and pushes, as actions; and whether they can be."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from stability.model import BodyId, Brick
from stability.shapes.box import Box
from stackdsl.compiling.impacts.drops import dropped
from stackdsl.compiling.impacts.flights import Coming, Crossing, crossings
from stackdsl.compiling.impacts.pushes import Comer, pushed
from stackdsl.compiling.impacts.scene import MissError, Scene
from stackdsl.compiling.impacts.throws import thrown
from stackdsl.compiling.scheduling import Moment
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts import Drop, Impact, Push, Throw
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source
from stackdsl.timeline import Action, Placement


def hitting_bricks(scenario: Scenario) -> dict[int, Brick]:
    """The bricks that are thrown or dropped, by the number of the impact; `thrown-1` if the first has no name."""
    found = {}
    for number, impact in enumerate(scenario.impacts):
        hit = impact.throw or impact.drop
        if hit is not None:
            kind, comes = hit.brick or scenario.brick, "thrown" if isinstance(hit, Throw) else "dropped"
            found[number] = Brick(hit.name or f"{comes}-{number + 1}", Box(kind.size), kind.mass_of(kind.size))
    return found


def shared_with_hits(
    scenario: Scenario, hitting: Mapping[int, Brick], names: Sequence[BodyId], source: Source
) -> Iterator[Diagnostic]:
    """Thrown and dropped bricks that are called like another one."""
    taken = set(names)
    for number, brick in hitting.items():
        if brick.id in taken:
            span = source.span_of(("impacts", number, _kind(scenario.impacts[number]), "name"))
            yield Diagnostic("SD203", span, f"two bricks are called '{brick.id}'", "give one of them another name")
        taken.add(brick.id)


def hits(
    scenario: Scenario, hitting: Mapping[int, Brick], impacts: Sequence[Moment], scene: Scene, source: Source
) -> tuple[list[tuple[Moment, Action]], list[Diagnostic]]:
    """The actions that hit the structure, and what keeps others from being as they are written."""
    flying = {brick.id: Comer(impacts[number], brick.mass) for number, brick in hitting.items()}
    known = {*flying, *(brick.name for brick in scene.bricks)}
    found: list[tuple[Moment, Action]] = []
    coming: list[Coming] = []
    mistakes = []
    for number, impact in enumerate(scenario.impacts):
        if _kind(impact) in ("remove", "insert") or _meant(impact) not in {*known, None}:
            continue  # a brick that nobody builds is told elsewhere
        try:
            action = _hit(impact, hitting.get(number), flying, replace(scene, moment=impacts[number]))
        except MissError as miss:
            span = source.span_of(("impacts", number, _kind(impact), miss.key))
            mistakes.append(Diagnostic(miss.code, span, miss.message, miss.hint))
        else:
            found.append((impacts[number], action))
            if isinstance(action, Placement):
                coming.append(Coming(number, impacts[number], action))
    mistakes += [
        _blocked(crossing, source) for crossing in crossings(coming, _disturbed(scenario, impacts), scene.gravity)
    ]
    return found, mistakes


def _disturbed(scenario: Scenario, impacts: Sequence[Moment]) -> Mapping[BodyId, Moment]:
    """When a brick is first pulled out or pushed."""
    found: dict[BodyId, Moment] = {}
    for moment, impact in sorted(zip(impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        names = impact.remove.names if impact.remove is not None else ()
        for name in (*names, *([impact.push.brick] if impact.push is not None else [])):
            found.setdefault(name, moment)
    return found


def _blocked(crossing: Crossing, source: Source) -> Diagnostic:
    later, earlier = crossing.later, crossing.earlier
    here, there = (
        source.key_span_of(("impacts", one.number, "drop" if one.placement.drop else "throw"))
        for one in (later, earlier)
    )
    message = (
        f"brick '{later.placement.brick.id}' begins {1000.0 * crossing.depth:.4g} mm inside "
        f"brick '{earlier.placement.brick.id}', which is still on its way from {there.line}:{there.column}"
    )
    hint = f"let it come later, such as `after: impact {earlier.number + 1} + 0.5 s`, or from elsewhere"
    return Diagnostic("SD201", here, message, hint)


def _kind(impact: Impact) -> str:
    return next(key for key in impact.one_of if getattr(impact, key) is not None)


def _meant(impact: Impact) -> BodyId | None:
    """The brick that a hit is aimed at, if it is one."""
    if impact.push is not None:
        return impact.push.brick
    aim = impact.throw.at if impact.throw is not None else impact.drop.onto if impact.drop is not None else None
    return aim.brick if aim is not None else None


def _hit(impact: Impact, brick: Brick | None, flying: Mapping[BodyId, Comer], scene: Scene) -> Action:
    """One hit, by the `brick` that comes if there is one. Raises MissError."""
    match impact.throw or impact.drop or impact.push, brick:
        case Throw() as throw, Brick():
            return thrown(brick, throw, scene)
        case Drop() as drop, Brick():
            return dropped(brick, drop, scene)
        case Push() as push, None:
            return pushed(push, flying, scene)
    raise TypeError(f"impact at {scene.moment.time:g} s is no hit")
