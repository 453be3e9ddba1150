"""Levels and names: by place, such as `L3.2`, unless the author gives his own; and whether names are right."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import inf
from types import MappingProxyType

from stability.model import GROUND, BodyId, Brick, Plane
from stackdsl.compiling.fitting import Fit, Sited, fits
from stackdsl.compiling.written_bricks import WrittenBrick
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source

FIXED_TOO = ("support", "about")  # keys that may also name the ground or a wall


def footings_of(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], removed_in: Mapping[int, int] = MappingProxyType({})
) -> list[Fit]:
    """What every brick stands on, for judging levels; nothing where layouts, which know theirs, are all there is.

    `removed_in` says of bricks, by number, in which step they are pulled out.
    """
    if all(brick.of_layout for brick in written):
        return [Fit() for _ in written]
    # What a brick stands on does not depend on the clock, only on what the author put before it or in the same step.
    sited = [
        Sited(float(brick.step), brick.shape, brick.pose, until=float(removed_in.get(index, inf)))
        for index, brick in enumerate(written)
    ]
    return fits(sited, planes)


def levels_of(written: Sequence[WrittenBrick], footings: Sequence[Fit]) -> list[int]:
    """The level of every brick: as written, or one above the highest that it stands on."""
    levels: dict[int, int] = {}
    for index in sorted(range(len(written)), key=lambda index: written[index].pose.position_W[2]):
        below = [levels[other] for other in footings[index].on_boxes if other in levels]
        levels[index] = written[index].level or max(below, default=0) + 1
    return [levels[index] for index in range(len(written))]


def lofty_levels(
    written: Sequence[WrittenBrick],
    footings: Sequence[Fit],
    levels: Sequence[int],
    names: Sequence[BodyId],
    source: Source,
) -> Iterator[Diagnostic]:
    """Levels that the author wrote and that are higher than one above what the brick stands on."""
    for brick, footing, name in zip(written, footings, names, strict=True):
        if brick.level is None or brick.of_layout or footing.in_the_air:
            continue  # in the air, a level is the author's word alone
        highest = max((levels[other] for other in footing.on_boxes), default=0) + 1
        if brick.level > highest:
            where = "the ground" if highest == 1 else f"level {highest - 1}"
            message = f"brick '{name}' stands on {where}, so it is no brick of level {brick.level}"
            hint = f"write at most {highest}, or leave it out"
            yield Diagnostic("SD104", source.span_of((*brick.path, "level")), message, hint)


def names_of(written: Sequence[WrittenBrick], levels: Sequence[int]) -> list[BodyId]:
    """The author's names, and `L3.2` for the second brick of level 3 in the author's order."""
    counts: Counter[tuple[str, int]] = Counter()
    names = []
    for brick, level in zip(written, levels, strict=True):
        place = f"{brick.within}." if brick.within else ""
        counts[place, level] += 1
        names.append(brick.name or f"{place}L{level}.{counts[place, level]}")
    return names


def shared_names(written: Sequence[WrittenBrick], names: Sequence[BodyId], source: Source) -> Iterator[Diagnostic]:
    """Bricks that are called like an earlier one."""
    first: dict[BodyId, int] = {}
    for index, name in enumerate(names):
        other = first.setdefault(name, index)
        if other != index:
            there = source.span_of(written[other].path)
            message = f"two bricks are called '{name}'; the other one is at {there.line}:{there.column}"
            yield Diagnostic("SD203", source.span_of(written[index].path), message, "give the step or the brick a name")


def unknown_bricks(
    scenario: Scenario, source: Source, names: Sequence[BodyId], hitting: Collection[BodyId] = ()
) -> Iterator[Diagnostic]:
    """Bricks that impacts and expectations speak of and that nobody builds, nor throws or drops."""
    known = {*names, *hitting}
    for key, claims in (("impacts", scenario.impacts), ("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for path, name in _named(claim.model_dump(by_alias=True, exclude_none=True), (key, number)):
                if name not in known and not (path[-1] in FIXED_TOO and name in _planes(scenario)):
                    fixed = _planes(scenario) if path[-1] in FIXED_TOO else ()
                    hint = (
                        did_you_mean(name, (*names, *hitting, *fixed))
                        or f"the bricks are called {names[0]} to {names[-1]}"
                    )
                    yield Diagnostic("SD204", source.span_of(path), f"there is no brick '{name}'", hint)


def missed_bricks(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of at the end, when they are pulled out."""
    gone = {name for impact in scenario.impacts if impact.remove is not None for name in impact.remove.names}
    for path, name in _claimed(scenario):
        if name in gone and "collapses" not in path:
            message = f"brick '{name}' is pulled out, so nothing can be expected of it"
            yield Diagnostic("SD204", source.span_of(path), message, "leave it out")


def bricks_that_hit(scenario: Scenario, hitting: Mapping[int, Brick], source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of as part of the structure, when an impact throws or drops them."""
    comes = {brick.id: "thrown" if scenario.impacts[number].throw else "dropped" for number, brick in hitting.items()}
    for path, name in _claimed(scenario):
        if name in comes and path[-1] not in FIXED_TOO:
            message = f"'{name}' is {comes[name]}, and no part of the structure; nothing can be expected of it"
            yield Diagnostic("SD204", source.span_of(path), message, "leave it out, or name a brick that is built")


def _planes(scenario: Scenario) -> tuple[BodyId, ...]:
    return (GROUND, *(f"wall{number}" for number in range(1, len(scenario.world.walls) + 1)))


def _claimed(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    """The names of bricks in what is expected and known, each with its place."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield from _named(claim.model_dump(by_alias=True, exclude_none=True), (key, number))


def _named(written: Mapping[str, object], path: Path) -> Iterator[tuple[Path, str]]:
    """The names of bricks in an expectation, each with its place."""
    for key, value in written.items():
        if isinstance(value, dict):
            yield from _named(value, (*path, key))
        elif key in ("bricks", "except") and isinstance(value, tuple):
            yield from (((*path, key, index), name) for index, name in enumerate(value) if isinstance(name, str))
        elif key in ("brick", "support", "of", "about") and isinstance(value, str):
            yield (*path, key), value
