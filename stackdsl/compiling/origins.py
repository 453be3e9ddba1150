"""Which line of a scenario an action of its timeline comes from."""

from collections.abc import Sequence
from dataclasses import dataclass

from stability.model import BodyId
from stackdsl.compiling.built import built_of
from stackdsl.diagnostics import Span
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.timeline import Action, Hold, LetGo, Placement, Push, Removal, Shake

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
    if isinstance(action, Shake):
        return None
    built = built_of(scenario, source)
    if not isinstance(action, Placement):
        named = set(action.bricks if isinstance(action, Removal | Hold | LetGo) else (action.brick,))
        for number, (impact, begins) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
            struck = {*impact.done.struck, *(each.name for each in impact.done.pulled_out)}
            ends = begins.time + impact.done.lasts
            if begins.time - ROUNDING <= action.time <= ends + ROUNDING and named & struck:
                return _impact(number, scenario, source)
        if isinstance(action, Removal | Push):
            return None
        brick = next(iter(named))  # a hand brought it
    else:
        brick = action.brick.id
    for number, missile in built.missiles.items():
        if missile.id == brick:
            return _impact(number, scenario, source)
    return _of_brick(brick, [(each.name, each.written.path) for each in built.bricks], scenario, source)


def _of_brick(
    brick: BodyId, written: Sequence[tuple[BodyId, Path]], scenario: Scenario, source: Source
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
