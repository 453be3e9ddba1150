"""Strengths of the bricks of a scenario, and refusals of what is not judged with them."""

from collections.abc import Iterator, Mapping
from typing import Final

from stability.geometry.round_solid import RoundSolid
from stability.model import BodyId
from stability.strength import Strength
from stackdsl.compiler.at_rest import what_moves
from stackdsl.compiler.joints import are_joined
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.trace import USED_STRENGTH, is_load

SYSTEM: Final = "exact"  # the only system that judges strengths
NOT_MODELLED: Final = "crushing is judged at rest only"


def strengths_of(built: ResolvedScenario, scenario: Scenario) -> Mapping[BodyId, Strength]:
    """Return the strengths of the bricks that have one."""
    gravity = scenario.world.gravity
    return {
        brick.name: kind.strength.under(gravity)
        for brick in built.bricks
        if (kind := brick.written.kind).strength is not None
    }


def unsupported_strengths(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, actions, loads and margins that are not judged with strengths of bricks."""
    first = next((brick for brick in built.bricks if brick.written.kind.strength is not None), None)
    if first is None:
        yield from _without_strength(scenario, source)
        return
    for system in (system for system in scenario.systems if system != SYSTEM):
        message = f"the strength of '{first.name}' is judged on `{SYSTEM}` only, not on the system '{system}'"
        yield Diagnostic("SD213", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")
    span = source.span_of(first.written.path)
    if are_joined(built, scenario):
        message = f"the strength of '{first.name}' is not judged together with joints"
        yield Diagnostic("SD213", span, message, "remove the joints, or `strength`")
    if round_brick := next((each for each in built.bricks if isinstance(each.written.shape, RoundSolid)), None):
        message = f"the strength of '{first.name}' is not judged beside round bricks, such as '{round_brick.name}'"
        yield Diagnostic("SD213", span, message, "use prisms, or remove `strength`")
    if scenario.supports:
        message = f"the strength of '{first.name}' is not judged on supports that move"
        yield Diagnostic("SD213", source.key_span_of(("supports",)), message, "remove `supports`, or `strength`")
    if scenario.samples is not None:
        message = f"samples are not drawn for bricks with a strength, such as '{first.name}'"
        hint = "remove `samples` and all `uncertain` values"
        yield Diagnostic("SD213", source.key_span_of(("samples",)), message, hint)
    yield from what_moves(built, scenario, source, "SD213", NOT_MODELLED, "strength")
    yield from _claimed(scenario, source)


def _without_strength(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            if claim.kind == "margin" and USED_STRENGTH in claim.content.needed_margins:
                span = source.key_span_of((key, number, claim.kind, USED_STRENGTH))
                hint = "add it to their kind, such as `strength: {stack: 120 kg}`"
                yield Diagnostic("SD213", span, "no brick has a `strength`", hint)


def _claimed(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            needed = {margin for margin in claim.content.needed_margins if not is_load(margin)} - {USED_STRENGTH}
            span = source.key_span_of((key, number, claim.kind))
            hint = (
                "claim `verdict` or the margin `used_strength`, and vary a length, a load or the friction with `find`"
            )
            if needed:
                message = f"`{min(needed)}` does not include the strengths of bricks"
                yield Diagnostic("SD213", span, message, hint)
            elif claim.content.needed_tests:
                message = f"`{claim.kind}` does not include the strengths of bricks"
                yield Diagnostic("SD213", span, message, hint)
