"""Reports what round bricks do not support: cones on their side in other engines, some joints and margins."""

from collections.abc import Iterator
from math import cos, pi
from typing import Final

from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import rotate
from stability.model import ConvexShape, Pose
from stackdsl.compiler.bricks import ResolvedBrick
from stackdsl.compiler.joints import SYSTEM, are_joined
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.trace import is_load

# The margins of round bricks: of balance alone, which forces within polygons inside round contacts prove.
ROUND_MARGINS: Final = frozenset({"acceleration", "tilt", "friction", "load_factor"})
# The same, where no contact is on a curved side: a disc that is displaced still covers its polygon, drawn in as far.
DISC_MARGINS: Final = ROUND_MARGINS | {"placement"}

STANDING: Final = cos(pi / 4.0)  # least vertical component of the axis of a cone that stands


def unsupported_round_bricks(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, joints and margins that round bricks do not support."""
    yield from _lying_cones(built, scenario, source)
    first = next((brick for brick in built.bricks if isinstance(brick.written.shape, RoundSolid)), None)
    if first is None:
        return
    if are_joined(built, scenario):
        yield from _joints(first, scenario, source)
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            needed = {*claim.content.needed_margins} - DISC_MARGINS
            if margins := sorted(margin for margin in needed if not is_load(margin)):
                message = f"the margin `{margins[0]}` is not computed for round bricks"
                span = source.key_span_of((key, number, claim.kind))
                hint = "claim `verdict`, and vary a length, a load or the friction with `find`"
                yield Diagnostic("SD212", span, message, hint)


def _joints(first: ResolvedBrick, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report joints at corners, as round contacts have none, and claims about the motion of joined round bricks."""
    for number, item in enumerate(scenario.joints):
        if item.pull is not None:
            message = f"`pull` acts at corners, but the contacts of round bricks such as '{first.name}' have none"
            hint = "write a `bond`: a strength per area"
            yield Diagnostic("SD212", source.span_of(("joints", number)), message, hint)
    if not (scenario.expect and all(claim.content.needs_statics for claim in scenario.expect)):
        message = f"joined bricks are not played beside round bricks, such as '{first.name}', only judged at rest"
        hint = "expect only `verdict` and `margin`"
        yield Diagnostic("SD212", source.span_of(first.written.path), message, hint)


def _lying_cones(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report cones that start on their side: the engines of other systems move them as prisms, which do not roll."""
    systems = [system for system in scenario.systems if system != SYSTEM]
    lying = next((brick for brick in built.bricks if _is_lying_cone(brick.written.shape, brick.written.pose)), None)
    if lying is not None and systems:
        message = (
            f"cones on their side, such as '{lying.name}', roll on `{SYSTEM}` only, not on the system '{systems[0]}'"
        )
        yield Diagnostic("SD212", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")


def _is_lying_cone(shape: ConvexShape, pose: Pose) -> bool:
    is_cone = isinstance(shape, RoundSolid) and shape.tapers
    return is_cone and abs(rotate(pose.orientation, (0.0, 0.0, 1.0))[2]) < STANDING
