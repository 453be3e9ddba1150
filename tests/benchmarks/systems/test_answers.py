"""What is known of a case, and how many levels off a run is from it."""

from math import inf

import pytest

from benchmarks.systems.answers import Answer, Source, answer_of
from tests.benchmarks.systems.runs import case_of

ANSWERS = {
    "statics prove that it stands": ("- column: {levels: 3}", "", Answer(True, Source.STATICS, undisturbed=True)),
    # Planks stepped by 40 mm: the first too many is number floor(117.6 / 40) + 1 = 3.
    "statics name the level": (
        "- column: {levels: 4, step: 40 mm}\n  every: 1 s",
        "",
        Answer(False, Source.STATICS, 3.0, 3.0, undisturbed=True),
    ),
    "truth comes first": (
        "- column: {levels: 3}",
        "truth:\n  - collapses: {at: level 2 ± 1}\n    source: a test\n",
        Answer(False, Source.TRUTH, 1.0, 3.0, undisturbed=True),
    ),
    "nobody knows where what is dropped lands": (
        "- column: {levels: 1}\n- bricks: [{at: [0 mm, 0 mm, 40 mm], drop: true}]\n  after: built + 1 s",
        "",
        None,
    ),
}


@pytest.mark.parametrize(("build", "rest", "known"), ANSWERS.values(), ids=ANSWERS)
def test_an_answer_comes_from_truth_or_from_statics(build: str, rest: str, known: Answer | None) -> None:
    case = case_of(build, "expect:\n  - stands: all\n" + rest)
    assert answer_of(case.scenario, case.timeline) == known


@pytest.mark.parametrize(
    ("answer", "fell_at", "off"),
    [
        (Answer(True, Source.TRUTH), None, 0.0),
        (Answer(True, Source.TRUTH), 7.0, 19.0),  # 6 of 25 levels held
        (Answer(False, Source.TRUTH, 8.0, 10.0), 9.0, 0.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), 12.0, 2.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), 4.0, 4.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), None, 16.0),  # as if it fell at the 26th
        (Answer(False, Source.TRUTH), 4.0, 0.0),  # where it falls is not known
        (Answer(False, Source.TRUTH, 8.0, inf), 6.0, 2.0),
    ],
)
def test_an_error_in_levels_is_the_distance_from_what_is_true(answer: Answer, fell_at: float, off: float) -> None:
    assert answer.levels_off(fell_at, 25) == off
