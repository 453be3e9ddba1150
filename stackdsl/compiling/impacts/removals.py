"""Which bricks are pulled out when, and whether they are there by then."""

from collections.abc import Iterator

from stability.model import BodyId
from stackdsl.compiling.built import Built
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import Scene
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts.remove import Remove
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.timeline import Removal


@actions_of.register
def removed(remove: Remove, scene: Scene) -> tuple[Removal, ...]:
    """All of them at once, in the author's order."""
    return (Removal(scene.moment.time, tuple(named.name for named in remove.pulled_out)),)


def missing_bricks(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are pulled out before they come, or again; those that never come are told elsewhere."""
    when = {brick.name: brick.placed for brick in built.bricks} if scenario.impacts else {}
    when |= {brick.id: built.impacts[number] for number, brick in built.missiles.items()}
    gone: dict[BodyId, Path] = {}
    for number in sorted(range(len(built.impacts)), key=built.impacts.__getitem__):
        begins, impact = built.impacts[number], scenario.impacts[number]
        for named in impact.done.pulled_out:
            path, name = (("impacts", number, impact.kind, *named.path)), named.name
            if name in gone:
                there = source.span_of(gone[name])
                message = f"brick '{name}' is pulled out already, at {there.seen_from(source.span_of(path))}"
                yield Diagnostic("SD204", source.span_of(path), message, "leave out one of them")
            elif name in when and when[name] > begins:
                message = f"brick '{name}' is placed at {when[name].time:g} s, not before {begins.time:g} s"
                hint = f"pull it out later, such as `after: brick {name} + 1 s`"
                yield Diagnostic("SD204", source.span_of(path), message, hint)
            gone.setdefault(name, path)
