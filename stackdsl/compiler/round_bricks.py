"""Reports what round bricks do not support: other systems than `exact`, joints, samples and some margins."""

from collections.abc import Iterator
from typing import Final

from stability.geometry.round_solid import RoundSolid
from stackdsl.compiler.joints import SYSTEM, are_joined
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source

# The margins of round bricks: of balance alone, which forces within polygons inside round contacts prove.
ROUND_MARGINS: Final = frozenset({"acceleration", "tilt", "friction", "load_factor"})
# The same, where no contact is on a curved side: a disc that is displaced still covers its polygon, drawn in as far.
DISC_MARGINS: Final = ROUND_MARGINS | {"placement"}


def unsupported_round_bricks(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, joints, samples and margins that round bricks do not support."""
    first = next((brick for brick in built.bricks if isinstance(brick.written.shape, RoundSolid)), None)
    if first is None:
        return
    for system in (system for system in scenario.systems if system != SYSTEM):
        message = f"round bricks such as '{first.name}' are judged on `{SYSTEM}` only, not on the system '{system}'"
        yield Diagnostic("SD212", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")
    if scenario.samples is not None:
        hint = "remove `samples` and all `uncertain` values"
        yield Diagnostic("SD212", source.key_span_of(("samples",)), "samples are not drawn for round bricks", hint)
    if are_joined(built, scenario):
        message = f"joints are not judged in a scenario with round bricks, such as '{first.name}'"
        yield Diagnostic("SD212", source.span_of(first.written.path), message, "remove the joints, or use prisms")
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            if margins := sorted({*claim.content.needed_margins} - DISC_MARGINS):
                message = f"the margin `{margins[0]}` is not computed for round bricks"
                span = source.key_span_of((key, number, claim.kind))
                hint = "claim `verdict`, and vary a length, a load or the friction with `find`"
                yield Diagnostic("SD212", span, message, hint)
