"""Mistakes between the values of a scenario that are right in themselves."""

from collections.abc import Iterator

from stackdsl.diagnostics import Diagnostic
from stackdsl.language.author_types import PROVING
from stackdsl.language.brick_forms import laid
from stackdsl.language.layouts.registry import place
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.sampled import sampled
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def disagreements(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """All of them, in no order."""
    for check in (
        _systems_not_played,
        _marks_of_other_systems,
        _unanswerable,
        _unproven_truths,
        _after_a_collapse,
        _impossible_layouts,
        sampled,
    ):
        yield from check(scenario, source)


def _systems_not_played(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, expectation in enumerate(scenario.expect):
        for system in expectation.system or ():
            if system not in scenario.systems:
                message = f"the scenario is not played on '{system}', so this would never be checked"
                hint = f"add it to systems, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of(("expect", index, "system")), message, hint)


def _marks_of_other_systems(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Marks for systems that the scenario is not played on, and of what cannot fail."""
    for key, mark in (("skip", scenario.skip), ("xfail", scenario.xfail)):
        for system in (mark.system if mark is not None else None) or ():
            if system not in scenario.systems:
                message = f"the scenario is not played on '{system}', so this says nothing"
                hint = f"leave it out, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of((key, "system")), message, hint)
    if scenario.xfail is not None and not scenario.expect:
        message = "nothing is expected that could fail"
        yield Diagnostic(
            "SD104", source.key_span_of(("xfail",)), message, "say under `expect` what ought to come of it"
        )


def _unanswerable(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Questions about proofs to systems that prove nothing."""
    for index, expectation in enumerate(scenario.expect):
        asked = [system for system in expectation.system or scenario.systems if system not in PROVING]
        if expectation.stated.needs_statics and asked:
            message = f"`{expectation.kind}` is known to statics alone, and not to '{asked[0]}'"
            span = source.key_span_of(("expect", index, expectation.kind))
            yield Diagnostic("SD104", span, message, f"say `system: {PROVING[0]}`, and name it in `systems`")


def _unproven_truths(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is known of proofs, where no system proves anything."""
    for index, truth in enumerate(scenario.truth):
        if truth.stated.needs_statics and not set(PROVING).intersection(scenario.systems):
            message = f"`{truth.kind}` is known to statics alone, so this would never be compared"
            span = source.key_span_of(("truth", index, truth.kind))
            yield Diagnostic("SD104", span, message, f"add {PROVING[0]} to systems")


def _after_a_collapse(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is to be built, or done, after a step that goes on until a collapse."""
    for index, step in enumerate(scenario.build[:-1]):
        if step.until is not None:
            message = "nothing is built after a collapse, and this step goes on until there is one"
            yield Diagnostic("SD104", source.span_of(("build", index, "until")), message, "let it be the last step")
    if scenario.impacts and scenario.build[-1].until is not None:
        message = "nothing can be done to a structure that has been built until it fell"
        hint = "say how much is built instead of `until: collapse`, or leave the impacts out"
        yield Diagnostic("SD205", source.key_span_of(("impacts",)), message, hint)


def _impossible_layouts(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, step in enumerate(scenario.build):
        if step.layout is None:
            continue
        name, params = step.layout
        try:
            form = (step.brick or scenario.brick).form
            for spec in place(name, params, form.size):
                laid(form, spec)
        except MistakeError as mistake:
            yield Diagnostic(mistake.code, source.span_of(("build", index, name)), mistake.message, mistake.hint)
