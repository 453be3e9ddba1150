"""How bodies of a file rub, where that says it: what a scenario must say so that this is kept.

An import gives bricks a friction of their own. What two that touch make of theirs, and how rough the ground is, belongs
to the scenario, of which an import is a part.
"""

from collections.abc import Mapping
from typing import Any, Final

from stability.friction_law import Rule
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importing.load import ImportedLoad, Surfaces
from stackdsl.importing.written_load import digits
from stackdsl.reading.source import Plain, Source

PASSED_OVER: Final = "or ignore: ['friction']"


def disagreement(load: ImportedLoad, source: Source, span: Span) -> Diagnostic | None:
    """What a scenario leaves open, or says otherwise, of what the file says; told at `span`."""
    if load.surfaces is None:
        return None
    rule, ground = load.surfaces.rule, load.surfaces.ground
    if (taken := _at(source, "friction", "rule") or Rule.LOWER) != rule:
        message = f"of two frictions of this file that meet, the {rule} counts, and of the scenario's the {taken}"
        return Diagnostic("SD115", span, message, f"write world: {{friction: {{rule: {rule}}}}}, {PASSED_OVER}")
    if ground is not None and _at(source, "ground", "friction") is None:
        message = f"the ground of this file has a friction of {digits(ground)}, and the scenario does not say its own"
        hint = f"write world: {{ground: {{friction: {digits(ground)}}}}}, {PASSED_OVER}"
        return Diagnostic("SD115", span, message, hint)
    return None


def written_world(surfaces: Surfaces) -> dict[str, Plain]:
    """The `world` of a scenario that keeps what a file says."""
    ground: dict[str, Plain] = {} if surfaces.ground is None else {"ground": {"friction": float(surfaces.ground)}}
    return {**ground, "friction": {"rule": surfaces.rule.value}}


def _at(source: Source, key: str, within: str) -> Any:  # noqa: ANN401 -- not validated yet
    world: Any = source.values.get("world")
    found = world.get(key) if isinstance(world, Mapping) else None
    return found.get(within) if isinstance(found, Mapping) else None
