"""Pieces of bricks, as at the ends of a wall, that are so small that statics cannot tell them from nothing."""

from collections.abc import Iterator

from stability.geometry.given_numbers import SHORTEST
from stability.statics.admission import LIGHTEST
from stackdsl.compiling.built import Built
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source


def slivers(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """One of each layout that has any; of a brick that is laid whole, its own keys tell it."""
    told: set[Path] = set()
    for brick in built.bricks:
        made = brick.written
        if (made.shape.least_thickness < SHORTEST or made.mass < LIGHTEST) and made.path not in told:
            told.add(made.path)
            message = (
                f"brick '{brick.name}' is cut to {made.mass:.3g} kg and a side of {made.shape.least_thickness:.3g} m"
            )
            hint = f"give the layout measures that leave of every brick at least {LIGHTEST:g} kg and {SHORTEST:g} m"
            yield Diagnostic("SD104", source.span_of(made.path), message, hint)
