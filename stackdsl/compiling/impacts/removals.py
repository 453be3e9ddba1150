"""Which bricks are pulled out when, and whether they are there by then."""

from collections.abc import Iterator, Mapping, Sequence

from stability.model import BodyId
from stackdsl.compiling.scheduling import Moment
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source


def removed_in(scenario: Scenario, names: Sequence[BodyId]) -> Mapping[int, int]:
    """The step that pulls out a brick, by the number of the brick; impacts are steps after those of the build."""
    numbers = {name: index for index, name in enumerate(names)}
    return {
        numbers[name]: len(scenario.build) + number
        for number in range(len(scenario.impacts))
        for _, name in _removed(scenario, number)
        if name in numbers
    }


def missing_bricks(
    scenario: Scenario, when: Mapping[BodyId, Moment], impacts: Sequence[Moment], source: Source
) -> Iterator[Diagnostic]:
    """Bricks that are pulled out before they come, or again; those that never come are told elsewhere.

    `when` says when each brick is placed, or comes flying.
    """
    gone: dict[BodyId, Path] = {}
    for number in sorted(range(len(impacts)), key=impacts.__getitem__):
        for path, name in _removed(scenario, number):
            if name in gone:
                there = source.span_of(gone[name])
                message = f"brick '{name}' is pulled out already, at {there.line}:{there.column}"
                yield Diagnostic("SD204", source.span_of(path), message, "leave out one of them")
            elif name in when and when[name] > impacts[number]:
                message = f"brick '{name}' is placed at {when[name].time:g} s, not before {impacts[number].time:g} s"
                hint = f"pull it out later, such as `after: brick {name} + 1 s`"
                yield Diagnostic("SD204", source.span_of(path), message, hint)
            gone.setdefault(name, path)


def _removed(scenario: Scenario, number: int) -> Iterator[tuple[Path, BodyId]]:
    """The bricks that an impact pulls out, each with its place in the file."""
    remove = scenario.impacts[number].remove
    if remove is None:
        return
    where: Path = ("impacts", number, "remove")
    if remove.brick is not None:
        yield (*where, "brick"), remove.brick
    for index, name in enumerate(remove.bricks or ()):
        yield (*where, "bricks", index), name
