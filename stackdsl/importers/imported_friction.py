"""Compares the friction and the base plate of an imported file with those of the scenario.

An import sets the friction of each brick. The rule that combines the frictions of two bricks in contact, and the
friction of the ground, belong to the scenario.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, Final

from stability.contact_law import Rule
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importers.load import BASE_PLATE, ImportedLoad, ImportedSurfaces, digits
from stackdsl.language.imports import Import
from stackdsl.language.yaml.source import Plain, Source

IGNORE_HINT: Final = "or ignore: ['friction']"


def conflict(load: ImportedLoad, options: Import, source: Source, span: Span) -> Diagnostic | None:
    """Return a diagnostic at `span` if the scenario leaves out or contradicts friction or ground of the file."""
    if BASE_PLATE not in options.ignore and (missing := base_plate_conflict(load, source, span)) is not None:
        return missing
    if load.surfaces is None:
        return None
    return _rule_conflict(load.surfaces.rule, source, span) or _ground_conflict(load.surfaces.ground, source, span)


def _rule_conflict(rule: Rule | None, source: Source, span: Span) -> Diagnostic | None:
    stated = _world_value(source, "friction", "rule")
    if rule is None:
        return None if stated else missing_rule(span, "world: {friction: {rule: lower}}", "ignore: ['contact']")
    if (own := stated or Rule.LOWER) == rule:
        return None
    message = f"this file combines friction coefficients by the rule `{rule}`, but the scenario by the rule `{own}`"
    return Diagnostic("SD115", span, message, f"write world: {{friction: {{rule: {rule}}}}}, {IGNORE_HINT}")


def _ground_conflict(ground: Fraction | None, source: Source, span: Span) -> Diagnostic | None:
    if ground is None or _world_value(source, "ground", "friction") is not None:
        return None
    message = f"this file sets a friction coefficient of {digits(ground)} for the ground, but the scenario sets none"
    hint = f"write world: {{ground: {{friction: {digits(ground)}}}}}, {IGNORE_HINT}"
    return Diagnostic("SD115", span, message, hint)


def base_plate_conflict(load: ImportedLoad, source: Source, span: Span) -> Diagnostic | None:
    """Return a diagnostic at `span` if the bricks of a file stand on a base plate that the scenario does not have."""
    world: Any = source.values.get("world")
    ground = world.get("ground") if isinstance(world, Mapping) else None
    if not load.on_base_plate or (isinstance(ground, Mapping) and "studs" in ground):
        return None
    message = "the bricks of the file stand on a base plate, but the ground of the scenario has no studs"
    return Diagnostic("SD115", span, message, "write world: {ground: {studs: lego}}, or ignore: ['base plate']")


def missing_rule(span: Span, rule: str, ignore: str) -> Diagnostic:
    """Return the diagnostic for a file that gives the friction of each body, but no rule for two in contact."""
    message = "the file sets the friction of each body, but no rule that combines the values of two bodies in contact"
    return Diagnostic("SD115", span, message, f"write {rule}, or another rule, or {ignore}")


def written_world(surfaces: ImportedSurfaces) -> dict[str, Plain]:
    """Return the `world` mapping that gives a scenario the friction rule and ground friction of a file."""
    ground: dict[str, Plain] = {} if surfaces.ground is None else {"ground": {"friction": float(surfaces.ground)}}
    rule: dict[str, Plain] = {} if surfaces.rule is None else {"friction": {"rule": surfaces.rule.value}}
    return {**ground, **rule}


def _world_value(source: Source, key: str, subkey: str) -> Any:  # noqa: ANN401 -- not validated yet
    world: Any = source.values.get("world")
    section = world.get(key) if isinstance(world, Mapping) else None
    return section.get(subkey) if isinstance(section, Mapping) else None
