"""Runs to view in tests."""

from functools import cache
from textwrap import dedent

from stackdsl.checking.cases import cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.language.yaml.source import parse
from stackdsl.simulation.recording import Recorder
from stackdsl.viewing.run_view import RunView, view_of

SLANT_TOWER = """
    scenario: slant-tower
    build:
      - four_stack: {levels: 14, step: 11.5 mm, spacing: 43 mm}
        every: 1 s
    systems: [exact]
    expect:
      - collapses: {at: level 7}
"""


@cache  # many tests look at the same run
def views_of(text: str, file: str = "scene.yaml") -> tuple[RunView, ...]:
    """All cases of a text without mistakes, played."""
    cases, mistakes = cases_of(parse(dedent(text), file))
    assert mistakes == []
    views = []
    for case in cases:
        recorder = Recorder()
        trace = play_case(case.timeline, case.system, recorder=recorder)
        views.append(view_of(case, trace, recorder.recording(), judged(case, trace)))
    return tuple(views)
