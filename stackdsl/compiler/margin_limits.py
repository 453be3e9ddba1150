"""Refuses claims of margins that would need too large a program: of too many bricks, or too many touching pairs."""

from collections.abc import Callable, Iterator

from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import bounds_W
from stability.geometry.spatial_grid import Neighbours
from stackdsl.compiler.schedule import Built
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.work import HINT, most_bricks, most_pairs


def too_many_in_margins(bricks: int, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Claims about so many bricks; that is known before any is built."""
    yield from _beyond(most_bricks, bricks, "bricks", scenario, source)


def too_many_pairs(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Claims about bricks of which too many pairs may touch: a lattice has far more of these than a wall."""
    claims = (*scenario.expect, *scenario.truth)
    if any(most_pairs(margin) is not None for claim in claims for margin in claim.stated.needed_margins):
        pairs, near = 0, Neighbours[int]()
        for number, brick in enumerate(built.bricks):
            low_W, high_W = bounds_W(brick.written.shape, brick.written.pose)
            pairs += len(near.around(low_W, high_W, reach_between(brick.written.shape.least_thickness)))
            near.add(number, low_W, high_W)
        yield from _beyond(most_pairs, pairs, "pairs of bricks that may touch", scenario, source)


def _beyond(
    most_of: Callable[[str], int | None], count: int, what: str, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for margin in sorted(claim.stated.needed_margins):
                most = most_of(margin)
                if most is not None and count > most:
                    message = f"the margin `{margin}` of up to {count} {what} takes too much, and {most} is the most"
                    hint = f"claim `verdict: stable` or `margin: {{friction: ...}}`, build less, {HINT}"
                    yield Diagnostic("SD206", source.key_span_of((key, number, claim.kind)), message, hint)
