"""Bricks that are placed inside others, or in the air."""

from collections.abc import Iterator, Sequence
from math import inf

from stackdsl.compiling.built import Built
from stackdsl.compiling.built_bricks import BuiltBrick
from stackdsl.compiling.fitting import MOST_INSIDE, CrowdedError, Fit, Sited, fits
from stackdsl.compiling.written_bricks import WrittenBrick
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.wording import mm

USUAL_DIGITS, ALL_DIGITS = 4, 17  # of a length in words, and those that tell any two lengths apart


def misfits(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks inside others or in the air; one of a kind for each place in the file, since a layout fails as a whole."""
    told: set[tuple[str, Path]] = set()
    bricks = built.in_order
    try:
        found = fits(_sited(bricks, built), built.planes)
    except CrowdedError as error:
        yield crowded(bricks[error.index].written, source)
        return
    unclear = sum(fit.overlaps for fit in found) > MOST_INSIDE  # what lies on the others
    for brick, fit in zip(bricks, found, strict=True):
        mistake = _misfit(fit, brick, bricks, built) if fit.overlaps or not unclear else None
        if mistake is not None and (mistake[0], brick.written.path) not in told:
            told.add((mistake[0], brick.written.path))
            yield Diagnostic(mistake[0], source.span_of(brick.written.path), *mistake[1:])


def crowded(brick: WrittenBrick, source: Source) -> Diagnostic:
    """That too many bricks lie around one of them to be held against each other."""
    message = "so many bricks lie so close together here that it takes too long to say which of them touch"
    hint = "build fewer, or let long ones lie along the axes: what is compared is what the boxes around them share"
    return Diagnostic("SD206", source.span_of(brick.path), message, hint)


def _sited(bricks: Sequence[BuiltBrick], built: Built) -> list[Sited]:
    """Bricks, each from the moment when it is placed until the one when it is gone."""
    moments = sorted({*(brick.placed for brick in bricks), *built.impacts})
    turns = {moment: float(turn) for turn, moment in enumerate(moments)}
    return [
        Sited(
            turns[brick.placed],
            brick.written.shape,
            brick.written.pose,
            inf if brick.gone is None else turns[brick.gone],
        )
        for brick in bricks
    ]


def _misfit(fit: Fit, brick: BuiltBrick, bricks: Sequence[BuiltBrick], built: Built) -> tuple[str, str, str] | None:
    of_layout = brick.written.of_layout
    if fit.overlaps:
        other = f"brick '{bricks[fit.overlaps_box].name}'" if fit.overlaps_box is not None else ""
        plane = built.planes[fit.overlaps_plane].id if fit.overlaps_plane is not None else ""
        message = f"brick '{brick.name}' is {mm(fit.depth)} inside {other or plane}"
        return "SD201", message, f"move it out by at least {mm(fit.depth)}{', such as by `origin`' * of_layout}"
    if fit.in_the_air and not brick.written.drop:
        above = "" if fit.clearance == inf else f"; the nearest body below is {_away(fit.clearance, fit.reach)}"
        hint = "place it on something, or say `drop: true` to let it fall"
        if of_layout:
            hint = "give the layout measures with which every brick lies on another, or an `origin` on top of something"
        return "SD202", f"nothing is under brick '{brick.name}'{above}", hint
    return None


def _away(clearance: float, reach: float) -> str:
    """A distance and the lesser one that it should be, in so many digits that they differ."""
    texts = ((mm(clearance, digits), mm(reach, digits)) for digits in range(USUAL_DIGITS, ALL_DIGITS + 1))
    away, most = next(pair for pair in texts if pair[0] != pair[1])
    return f"{away} away, and what is up to {most} away touches"
