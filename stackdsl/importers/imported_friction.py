"""How bodies of a file rub, where that says it: what a scenario must say so that this is kept.

An import gives bricks a friction of their own. What two that touch make of theirs, and how rough the ground is, belongs
to the scenario, of which an import is a part.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, Final

from stability.contact_law import Rule
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importers.load import ImportedLoad, ImportedSurfaces, digits
from stackdsl.language.yaml.source import Plain, Source

PASSED_OVER: Final = "or ignore: ['friction']"


def disagreement(load: ImportedLoad, source: Source, span: Span) -> Diagnostic | None:
    """What a scenario leaves open, or says otherwise, of what the file says; told at `span`."""
    if load.surfaces is None:
        return None
    return _of_the_rule(load.surfaces.rule, source, span) or _of_the_ground(load.surfaces.ground, source, span)


def _of_the_rule(rule: Rule | None, source: Source, span: Span) -> Diagnostic | None:
    said = _at(source, "friction", "rule")
    if rule is None:
        return None if said else left_open(span, "world: {friction: {rule: lower}}", "ignore: ['contact']")
    if (taken := said or Rule.LOWER) == rule:
        return None
    message = f"of two frictions of this file that meet, the {rule} counts, and of the scenario's the {taken}"
    return Diagnostic("SD115", span, message, f"write world: {{friction: {{rule: {rule}}}}}, {PASSED_OVER}")


def _of_the_ground(ground: Fraction | None, source: Source, span: Span) -> Diagnostic | None:
    if ground is None or _at(source, "ground", "friction") is not None:
        return None
    message = f"the ground of this file has a friction of {digits(ground)}, and the scenario does not say its own"
    hint = f"write world: {{ground: {{friction: {digits(ground)}}}}}, {PASSED_OVER}"
    return Diagnostic("SD115", span, message, hint)


def left_open(span: Span, ruled: str, passed_over: str) -> Diagnostic:
    """That a file says how rough its bodies are, and not what two that touch have."""
    message = "the file says how rough each body is, and not what two have that touch: simulators differ in that"
    return Diagnostic("SD115", span, message, f"write {ruled}, or another rule, or {passed_over}")


def written_world(surfaces: ImportedSurfaces) -> dict[str, Plain]:
    """The `world` of a scenario that keeps what a file says."""
    ground: dict[str, Plain] = {} if surfaces.ground is None else {"ground": {"friction": float(surfaces.ground)}}
    rule: dict[str, Plain] = {} if surfaces.rule is None else {"friction": {"rule": surfaces.rule.value}}
    return {**ground, **rule}


def _at(source: Source, key: str, within: str) -> Any:  # noqa: ANN401 -- not validated yet
    world: Any = source.values.get("world")
    found = world.get(key) if isinstance(world, Mapping) else None
    return found.get(within) if isinstance(found, Mapping) else None
