"""Scenes for tests: a scenario's text in, timelines and cases out."""

from textwrap import dedent

from stackdsl.checking.cases import Case, cases_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.yaml.source import parse
from stackdsl.timeline import Timeline


def compiled(text: str) -> tuple[list[Case], list[Diagnostic]]:
    """Cases and mistakes of one or more scenarios."""
    return cases_of(parse(dedent(text), "scene.yaml"))


def scene(build: str, rest: str = "") -> str:
    """A scenario with these steps of building, and further keys after them."""
    return f"scenario: scene\nbuild:\n{_indented(dedent(build).strip())}\n{dedent(rest)}"


def _indented(block: str) -> str:
    return "\n".join(f"  {line}" for line in block.splitlines())


def timeline_of(build: str, rest: str = "") -> Timeline:
    """The timeline of a scene without mistakes."""
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return cases[0].timeline


def mistakes_of(build: str, rest: str = "") -> list[Diagnostic]:
    """The mistakes of a scene."""
    return compiled(scene(build, rest))[1]


def assert_told_in_its_place(impacts: str, code: str, words: str) -> None:
    """These impacts on a column of two planks have one mistake, where the `^` is."""
    (mistake,) = mistakes_of("- column: {levels: 2}\n  every: 4 s", f"\nimpacts: [{impacts.replace('^', '')}]")
    assert (mistake.code, mistake.span.line) == (code, 6)
    assert mistake.span.column == len("impacts: [") + impacts.index("^") + 1
    assert words in mistake.message
    assert mistake.hint
