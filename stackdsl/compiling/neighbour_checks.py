"""Whether what a brick is placed by is there, and still where the author put it, when the brick comes."""

from collections.abc import Iterator, Mapping

from stability.model import BodyId
from stackdsl.compiling.beside import later_names
from stackdsl.compiling.built import Built
from stackdsl.compiling.built_bricks import BuiltBrick
from stackdsl.compiling.misfits import misfits
from stackdsl.compiling.moment import Moment
from stackdsl.compiling.standing import MAX_NAMED
from stackdsl.diagnostics import Diagnostic, Span, did_you_mean, first_of
from stackdsl.language.named import named_in
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def nowhere(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are placed by one that does not stand before them."""
    lost = [brick for brick in built.bricks if brick.written.lost is not None]
    if not lost:
        return
    later = later_names([brick.written for brick in built.bricks])
    names = [brick.name for brick in built.bricks if brick.written.lost is None]
    for brick in lost:
        error, span = brick.written.lost, _span(brick, source)
        assert error is not None  # as it was looked for
        if error.too_dear:
            message = f"to find '{error.name}' by its place, more than {MAX_NAMED} names have to be worked out anew"
            yield Diagnostic("SD206", span, message, "give the bricks names that others are placed by")
            return
        elif error.name in later:
            there = source.span_of(later[error.name].path)
            message = f"brick '{error.name}' comes only later, at {there.seen_from(span)}"
            yield Diagnostic("SD204", span, message, "name one that is placed before, or place that one first")
        else:
            hint = did_you_mean(error.name, names) or "name one that is placed before"
            yield Diagnostic("SD204", span, f"there is no brick '{error.name}' before this one", hint)


def out_of_place(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that do not fit where they are placed, unless some are placed by what is not there, which says why."""
    moved = first_of(_moved_neighbours(built, scenario, source))
    yield from moved or misfits(built, scenario, source)


def _moved_neighbours(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are placed by one that is not there by then, or that may be elsewhere."""
    if not any(brick.written.placed_by for brick in built.bricks):
        return
    hit = _hit(built, scenario)
    for brick in built.bricks:
        for number in brick.written.placed_by:
            other = built.bricks[number]
            if (why := _away(other, brick.placed, hit)) is not None:
                message = f"brick '{brick.name}' is placed by '{other.name}' at {brick.placed.time:g} s, {why}"
                hint = "place it by another one, or `at` a place, or at another time"
                yield Diagnostic("SD204", _span(brick, source), message, hint)
                break


def _away(other: BuiltBrick, moment: Moment, hit: Mapping[BodyId, Moment]) -> str | None:
    """Why nobody knows where a brick is at a moment; None if it is where its author put it."""
    if other.written.drop:
        return "and where that one lies is known only to a run, as it is let go"
    if other.placed > moment:
        return f"and that one comes only at {other.placed.time:g} s"
    if other.gone is not None and other.gone <= moment:
        return f"and that one is pulled out at {other.gone.time:g} s"
    if other.name in hit and hit[other.name] <= moment:
        return f"and that one is hit at {hit[other.name].time:g} s, so that only a run knows where it is"
    return None


def _hit(built: Built, scenario: Scenario) -> Mapping[BodyId, Moment]:
    """When each brick is first named by something that may move it."""
    found: dict[BodyId, Moment] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        if impact.done.slid_in is None:
            for named in named_in(impact.done):
                found.setdefault(named.name, moment)
    return found


def _span(brick: BuiltBrick, source: Source) -> Span:
    key = "beside" if (*brick.written.path, "beside") in source.value_spans else "on"
    return source.span_of((*brick.written.path, key))
