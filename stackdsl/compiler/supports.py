"""Movements of supports of a scenario, in W, and refusals of what is not computed with them."""

from collections.abc import Iterator
from typing import Final

from stability.contacts.detection import contacts_with_plane, solid
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import bounds_W
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import rotate
from stability.model import Brick, Vec3
from stability.problem import Placed, Tolerances
from stability.supports import SupportMotion
from stackdsl.compiler.bricks import ResolvedBrick
from stackdsl.compiler.joints import are_joined
from stackdsl.compiler.loads import direction_of
from stackdsl.compiler.schedule import ResolvedScenario, tilt_of
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.schema import Scenario
from stackdsl.language.supports import Support
from stackdsl.language.yaml.source import KeyPath, Source

SYSTEM: Final = "exact"  # the only system that judges moving supports
MOST_BRICKS: Final = 200  # a step of the movement then takes some seconds


def support_motions(built: ResolvedScenario, scenario: Scenario) -> tuple[SupportMotion, ...]:
    """Return the movements of all supports, in W."""
    return tuple(_motion(support, built, scenario) for support in scenario.supports)


def _motion(support: Support, built: ResolvedScenario, scenario: Scenario) -> SupportMotion:
    tilt, shift = tilt_of(scenario), support.by or (0.0, 0.0, 0.0)
    axis = (0.0, 0.0, 1.0) if support.about is None else direction_of(support.about)
    centre = support.around or _middle([brick for brick in built.bricks if brick.name in support.under])
    return SupportMotion(
        tuple(sorted(support.under)),
        rotate(tilt, shift),
        support.turn or 0.0,
        rotate(tilt, axis),
        rotate(tilt, centre),
    )


def _middle(bricks: list[ResolvedBrick]) -> Vec3:
    """Return the middle of bricks seen from above, on the ground."""
    lows, highs = zip(*(bounds_W(each.written.shape, each.written.pose) for each in bricks), strict=True)
    x, y = (0.5 * (min(low[axis] for low in lows) + max(high[axis] for high in highs)) for axis in (0, 1))
    return (x, y, 0.0)


def invalid_supports(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report supports below unknown bricks or none, and what is not computed with moving supports."""
    bricks = {brick.name: brick for brick in built.bricks}
    seen: dict[str, KeyPath] = {}
    for number, support in enumerate(scenario.supports):
        for place, name in enumerate(support.under):
            path: KeyPath = ("supports", number, "under", place)
            span = source.span_of(path)
            if name not in bricks:
                names = list(bricks)
                hint = did_you_mean(name, names) or f"the names of the bricks are {names[0]} to {names[-1]}"
                yield Diagnostic("SD204", span, f"there is no brick '{name}'", hint)
            elif name in seen:
                there = source.span_of(seen[name]).seen_from(span)
                yield Diagnostic("SD104", span, f"brick '{name}' already has a moving support, at {there}", "keep one")
            elif bricks[name].removed is not None or not _is_grounded(bricks[name], built):
                message = f"brick '{name}' does not stay on the ground, which is what moves"
                yield Diagnostic("SD204", span, message, "write the name of a brick on the ground")
            seen.setdefault(name, path)
    if scenario.supports:
        yield from _unjudged(built, scenario, source)


def _is_grounded(brick: ResolvedBrick, built: ResolvedScenario) -> bool:
    written = brick.written
    body = solid(Placed(Brick(brick.name, written.shape, written.mass), written.pose))
    return bool(contacts_with_plane(body, built.planes[0], Tolerances()))


def _unjudged(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks, systems and claims with which the movement of supports is not computed."""
    span = source.key_span_of(("supports",))
    for system in (system for system in scenario.systems if system != SYSTEM):
        message = f"moving supports are judged on `{SYSTEM}` only, not on the system '{system}'"
        yield Diagnostic("SD211", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")
    if scenario.samples is not None:
        message = "samples are not drawn for structures on moving supports"
        yield Diagnostic("SD211", source.key_span_of(("samples",)), message, "remove `samples`")
    if are_joined(built, scenario):
        yield Diagnostic("SD211", span, "moving supports are not computed for joined bricks", "remove the joints")
    if any(isinstance(brick.written.shape, Compound | RoundSolid) for brick in built.bricks):
        message = "moving supports are not computed for round bricks and bricks of several parts"
        yield Diagnostic("SD211", span, message, "write convex solids with flat faces, or remove `supports`")
    if len(built.bricks) > MOST_BRICKS:
        message = f"the movement of supports is computed for at most {MOST_BRICKS} bricks, not for {len(built.bricks)}"
        yield Diagnostic("SD206", span, message, "use fewer bricks")
    if not all(claim.content.needs_statics for claim in (*scenario.expect, *scenario.truth)):
        message = "structures on moving supports are judged at rest only, and not played"
        yield Diagnostic("SD211", span, message, "expect only `verdict` and `margin`")
