"""Whether every name is that of one brick, and of one that is there to speak of; and whether levels are right."""

from collections.abc import Iterator

from stability.model import GROUND, BodyId
from stackdsl.compiling.built import Built
from stackdsl.compiling.built_bricks import BuiltBrick
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.claims.claim import Claim
from stackdsl.language.named import Named, named_in
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def lofty_levels(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Levels that the author wrote and that are higher than one above what the brick stands on."""
    for brick in built.bricks:
        if brick.written.level is None or brick.written.of_layout or brick.footing.in_the_air:
            continue  # in the air, a level is the author's word alone
        highest = max((built.bricks[other].level for other in brick.footing.on_boxes), default=0) + 1
        if brick.written.level > highest:
            where = "the ground" if highest == 1 else f"level {highest - 1}"
            message = f"brick '{brick.name}' stands on {where}, so it is no brick of level {brick.written.level}"
            hint = f"write at most {highest}, or leave it out"
            yield Diagnostic("SD104", source.span_of((*brick.written.path, "level")), message, hint)


def shared_names(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are called like an earlier one."""
    first: dict[BodyId, BuiltBrick] = {}
    for brick in built.bricks:
        other = first.setdefault(brick.name, brick)
        if other is not brick:
            there, here = source.span_of(other.written.path), source.span_of(brick.written.path)
            message = f"two bricks are called '{brick.name}'; the other one is at {there.seen_from(here)}"
            yield Diagnostic("SD203", here, message, "give the step or the brick a name")


def shared_with_missiles(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are thrown or dropped and called like another one."""
    taken = {brick.name for brick in built.bricks}
    for number, brick in built.missiles.items():
        if brick.id in taken:
            span = source.span_of(("impacts", number, scenario.impacts[number].kind, "name"))
            yield Diagnostic("SD203", span, f"two bricks are called '{brick.id}'", "give one of them another name")
        taken.add(brick.id)


def unknown_bricks(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that impacts and expectations speak of and that nobody builds, nor throws or drops."""
    names, planes = [brick.name for brick in built.bricks], _planes(scenario)
    bodies = (*names, *(brick.id for brick in built.missiles.values()))
    bricks, all_bodies = set(bodies), {*bodies, *planes}
    impacts = (name for number, impact in enumerate(scenario.impacts) for name in named_in(impact, ("impacts", number)))
    for named in (*impacts, *(named for _, named in _claimed(scenario))):
        if named.name not in (all_bodies if named.or_plane else bricks):
            known = (*bodies, *planes) if named.or_plane else bodies
            hint = did_you_mean(named.name, known) or f"the bricks are called {names[0]} to {names[-1]}"
            yield Diagnostic("SD204", source.span_of(named.path), f"there is no brick '{named.name}'", hint)


def missed_bricks(_built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of at the end, when they are pulled out."""
    gone = {named.name for impact in scenario.impacts for named in impact.done.pulled_out}
    for claim, named in _claimed(scenario):
        if named.name in gone and not claim.stated.of_what_is_gone:
            message = f"brick '{named.name}' is pulled out, so nothing can be expected of it"
            yield Diagnostic("SD204", source.span_of(named.path), message, "leave it out")


def bricks_that_hit(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of as part of the structure, when an impact throws or drops them."""
    comes = {
        built.missiles[number].id: impact.done.missile.how
        for number, impact in enumerate(scenario.impacts)
        if impact.done.missile is not None
    }
    for _, named in _claimed(scenario):
        if named.name in comes and not named.or_plane:
            how = comes[named.name]
            message = f"'{named.name}' is {how}, and no part of the structure; nothing can be expected of it"
            yield Diagnostic(
                "SD204", source.span_of(named.path), message, "leave it out, or name a brick that is built"
            )


def _planes(scenario: Scenario) -> tuple[BodyId, ...]:
    return (GROUND, *(f"wall{number}" for number in range(1, len(scenario.world.walls) + 1)))


def _claimed(scenario: Scenario) -> Iterator[tuple[Claim, Named]]:
    """The names of bricks in what is expected and known."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield from ((claim, named) for named in named_in(claim, (key, number)))
