"""Refusals of what moves bricks, for structures that are judged at rest only."""

from collections.abc import Iterator
from typing import Final

from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source

AT_REST: Final = frozenset({"remove", "insert"})  # impacts that are judged without motion


def what_moves(  # noqa: PLR0913, PLR0917 -- what is refused, and how it is told
    built: ResolvedScenario, scenario: Scenario, source: Source, code: str, not_modelled: str, key: str
) -> Iterator[Diagnostic]:
    """Report drops, impacts, hands, shaking and loads that change. `key` is what else may be removed."""
    if dropped := next((brick for brick in built.bricks if brick.written.drop), None):
        message = f"{not_modelled}, and brick '{dropped.name}' is dropped"
        yield Diagnostic(code, source.span_of(dropped.written.path), message, f"set it down, or remove `{key}`")
    paths: list[tuple[KeyPath, str]] = [
        (("impacts", number, impact.kind), impact.kind)
        for number, impact in enumerate(scenario.impacts)
        if impact.kind not in AT_REST
    ]
    paths += [(("build", number, "place"), "place") for number, step in enumerate(scenario.build) if step.place]
    if scenario.world.shake is not None:
        paths.append((("world", "shake"), "shake"))
    for path, moving in paths:
        message = f"{not_modelled}, and `{moving}` moves bricks"
        yield Diagnostic(code, source.key_span_of(path), message, f"remove `{moving}`, or `{key}`")
    for number, load in enumerate(scenario.loads):
        if any(amount != load.rows[0][1] for _, amount in load.rows):
            message = f"{not_modelled}, under loads that do not change"
            hint = "write a constant load, and vary it with `find`"
            yield Diagnostic(code, source.key_span_of(("loads", number, load.kind)), message, hint)
