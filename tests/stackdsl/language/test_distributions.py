"""Distributions in place of values: nominal values, allowed places, mistakes."""

import pytest

from stackdsl.language.variants import resampled
from stackdsl.sampling.samples import Draws, picks, timelines
from tests.scenes import compiled, mistakes_of, timeline_of

SHARE = 'samples: 5\nexpect: [stands: {share: ">= 1 %"}]'


def test_nominal_value_of_an_inline_distribution_is_its_median() -> None:
    build = "- bricks: [{at: [10 mm ± 4 mm, normal 5 mm ± 1 mm, 3.9 mm]}]"
    timeline = timeline_of(build, f"friction: uniform 0.3 .. 0.5\n{SHARE}")
    assert timeline.world.friction == pytest.approx(0.4, abs=1e-15)
    assert timeline.placements[0].pose.position_W == pytest.approx((0.010, 0.005, 0.0039), abs=1e-15)


def test_each_repetition_has_its_own_random_variable() -> None:
    text = f"""
    scenario: row
    build:
      - bricks:
          - repeat: {{i: 1 .. 3}}
            at: ["${{i * 200 mm}} ± 1 mm", 0 mm, 3.9 mm]
    {SHARE.replace(chr(10), chr(10) + "    ")}
    """
    cases, mistakes = compiled(text)
    assert mistakes == []
    found = [
        placement.pose.position_W[0] - 0.2 * number
        for timeline in timelines(cases[0].variant, Draws(1, "row", 0, 4))
        for number, placement in enumerate(timeline.placements, start=1)
    ]
    assert len({round(each, 9) for each in found}) == 12
    assert max(map(abs, found)) <= 1e-3 + 1e-12


def test_inline_random_values_are_independent_of_other_variables() -> None:
    def drawn(more: str) -> dict[str, object]:
        text = f"scenario: s\nfriction: 0.4 ± 0.1\n{more}\nbuild: [column: {{levels: 2}}]\n{SHARE}"
        (pick,) = picks(Draws(1, "s", 7, 1))
        resampled(compiled(text)[0][0].variant, pick)
        return dict(pick.values)

    alone, beside = drawn(""), drawn("brick: {size: [100 mm, 20 mm ± 1 mm, 10 mm], mass: 12 g}")
    assert set(beside) == {"friction", "brick.size[1]"}
    assert alone == {"friction": beside["friction"]}


def test_name_with_a_distribution_is_rejected_as_a_name() -> None:
    (found,) = mistakes_of("- bricks: [{name: uniform 1, at: [0 mm, 0 mm, 5 mm]}]", "")
    assert found.message == "'uniform 1' is not a valid name of a brick"


@pytest.mark.parametrize("kind", ["table", "normal", "uniform"])
def test_brick_type_may_have_the_name_of_a_distribution(kind: str) -> None:
    types = f"brick_types: {{{kind}: {{size: [100 mm, 20 mm, 10 mm], mass: 12 g}}}}"
    assert mistakes_of(f"- bricks: [{{name: one, brick: {kind}, at: [0 mm, 0 mm, 5 mm]}}]", types) == []


@pytest.mark.parametrize(
    ("build", "rest", "words", "remedy"),
    [
        ("- column: {levels: 2}", "friction: 0.4 ± 0.1\nexpect: [stands: all]", "has no samples", "add `samples"),
        ("- column: {levels: 2, step: normal 5 mm ± -1 mm}", SHARE, "greater than zero", "write"),
        ("- column: {levels: 2}", f"friction: {{normal: 0.4 ± 0.1, least: 0}}\n{SHARE}", "one line", "least 0"),
        (
            "- column: {levels: 2, step: '${gap}'}",
            f"let: {{gap: 5 mm ± 1 mm}}\n{SHARE}",
            "`let` cannot define",
            "uncertain",
        ),
        ("- column: {levels: 2}\n  every: 1 s ± 0.1 s", SHARE, "expected a duration", "1.5 s"),
        ("- column: {levels: 2}\n  jitter: {position: 0 mm ± 1 mm}", SHARE, "expected a length", "13.5 mm"),
        ("- column: {levels: 2}", f"friction: normal 0.4 ± 0.1 leats 0\n{SHARE}", "leats", "least 10 g"),
        (
            "- column: {levels: 2}",
            f"friction: uniform 0.4 ± 0.1 least 0\n{SHARE}",
            "do not apply to a",
            "normal or lognormal",
        ),
    ],
)
def test_invalid_inline_distribution_has_a_remedy(build: str, rest: str, words: str, remedy: str) -> None:
    found = [mistake for mistake in mistakes_of(build, rest) if words in mistake.message]
    assert found, [mistake.message for mistake in mistakes_of(build, rest)]
    assert remedy in found[0].hint
