"""Refuses claims about margins with too large programs: of too many bricks, or too many contact points."""

from collections.abc import Callable, Iterator
from typing import Final

from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import bounds_W
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import body_axes, dot
from stackdsl.compiler.bricks import WrittenBrick
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.work import HINT, most_bricks, most_points

ALONG: Final = 1e-6  # tolerance of the cosine of the angle between parallel or perpendicular sides
CUT: Final = 2  # additional corners of the intersection of two rectangles that are rotated against each other


def too_many_in_margins(bricks: int, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report margins of too many bricks; called before any brick is built."""
    yield from _beyond(most_bricks, bricks, "bricks", scenario, source)


def too_many_points(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report margins of bricks with too many possible contact points; a lattice has far more of these than a wall."""
    claims = (*scenario.expect, *scenario.truth)
    if any(most_points(margin) is not None for claim in claims for margin in claim.content.needed_margins):
        points, near = 0, Neighbours[int]()
        for number, brick in enumerate(built.bricks):
            low_W, high_W = bounds_W(brick.written.shape, brick.written.pose)
            beside = near.around(low_W, high_W, reach_between(brick.written.shape.least_thickness))
            points += sum(_points(brick.written, built.bricks[other].written) for other in beside)
            near.add(number, low_W, high_W)
        yield from _beyond(most_points, points, "contact points", scenario, source)


def _points(one: WrittenBrick, other: WrittenBrick) -> int:
    """Return the largest number of contact points of two bricks: the corners of the intersection of two faces."""
    most = max(len(face.corners) for brick in (one, other) for face in brick.shape.faces)
    turned = abs(dot(body_axes(one.pose.orientation)[0], body_axes(other.pose.orientation)[0]))
    return most if turned < ALONG or turned > 1.0 - ALONG else most + CUT


def _beyond(
    most_of: Callable[[str], int | None], count: int, noun: str, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for margin in sorted(claim.content.needed_margins):
                most = most_of(margin)
                if most is not None and count > most:
                    limit = f"the maximum is {most}"
                    message = (
                        f"the computation of the margin `{margin}` for up to {count} {noun} takes too long; {limit}"
                    )
                    hint = f"claim `verdict: stable` or `margin: {{friction: ...}}` instead, use fewer bricks, {HINT}"
                    yield Diagnostic("SD206", source.key_span_of((key, number, claim.kind)), message, hint)
