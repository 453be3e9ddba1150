"""Samples with uncertain variables, against the closed form for each value."""

import re
from collections.abc import Iterator
from math import atan

import pytest

from stackdsl.checking.cases import Case
from stackdsl.checking.ensembles import Chunk, sampled_result, varied_chunk
from stackdsl.language.expressions import constant
from stackdsl.language.variants import Variant, resampled
from stackdsl.language.yaml.source import Plain
from stackdsl.results import RunStatus
from stackdsl.sampling.sample_outcomes import SampleOutcome
from stackdsl.sampling.samples import Draws, InvalidSampleError, picks, timelines
from tests.scenes import compiled

SLOPE = """
scenario: slope
samples: 100
uncertain:
  mu: 0.5 ± 0.2
  tilt: {normal: 20 deg ± 5 deg}
let: {under: "${0.8 * mu}"}
friction: ${mu}
world: {tilt: "${tilt}", ground: {friction: "${under}"}}
build:
  - bricks: [{on: ground}]
expect:
  - stands: {share: ">= 10 %"}
"""


def case_of(text: str) -> Case:
    cases, mistakes = compiled(text)
    assert mistakes == []
    return cases[0]


def drawn_values(variant: Variant, draws: Draws) -> Iterator[dict[str, Plain]]:
    for pick in picks(draws):
        resampled(variant, pick)
        yield pick.values


def radians(written: Plain) -> float:
    return float(constant(written).magnitude)


def test_a_brick_slides_in_the_samples_whose_slope_is_steeper_than_its_friction() -> None:
    case, draws = case_of(SLOPE), Draws(3, "slope", 0, 60)
    expected = [
        atan(0.8 * float(str(values["mu"]))) > radians(values["tilt"]) for values in drawn_values(case.variant, draws)
    ]
    assert 5 < sum(expected) < 55
    chunk = varied_chunk(case.variant, "exact", draws)
    assert isinstance(chunk, Chunk)
    assert [outcome == SampleOutcome.STANDS for outcome in chunk.outcomes] == expected


def test_a_value_depends_on_its_sample_alone() -> None:
    case = case_of(SLOPE)
    together = list(drawn_values(case.variant, Draws(3, "slope", 0, 20)))
    assert list(drawn_values(case.variant, Draws(3, "slope", 12, 4))) == together[12:16]


def test_values_computed_by_let_vary_with_their_variable() -> None:
    case, draws = case_of(SLOPE), Draws(3, "slope", 0, 5)
    for values, timeline in zip(drawn_values(case.variant, draws), timelines(case.variant, draws), strict=True):
        assert timeline.world.friction == pytest.approx(float(str(values["mu"])), rel=1e-12)
        assert timeline.world.planes[0].friction == pytest.approx(0.8 * float(str(values["mu"])), rel=1e-12)


def test_a_sample_with_a_value_that_may_not_be_written_is_told_with_it() -> None:
    case = case_of(SLOPE.replace("0.5 ± 0.2", "{normal: 0.01 ± 1}"))
    with pytest.raises(InvalidSampleError, match=r"sample \d+ has mu = -.* is below the minimum of 0") as caught:
        list(timelines(case.variant, Draws(1, "slope", 0, 50)))
    mistake = caught.value.mistake
    assert (mistake.code, mistake.span.line) == ("SD104", 8)
    assert "least: 0.1" in mistake.hint


def test_hands_err_in_such_samples_as_well() -> None:
    text = SLOPE.replace("[{on: ground}]", "[{on: ground}]\n    jitter: {yaw: 30 deg}")
    case = case_of(text)
    found = varied_chunk(case.variant, "exact", Draws(3, "slope", 0, 10))
    assert isinstance(found, Chunk)
    assert len(found.outcomes) == 10
    assert sum(found.ways.values()) == 10


def test_a_brick_slides_where_a_slope_without_a_name_is_steeper_than_its_friction() -> None:
    text = SLOPE.replace("${mu}", "normal 0.4 ± 0.2, least 0").replace('"${tilt}"', "20 deg ± 8 deg")
    text = text.replace('ground: {friction: "${under}"}', "ground: {}")
    case, draws = case_of(re.sub(r"uncertain:.*?(?=friction)", "", text, flags=re.DOTALL)), Draws(3, "slope", 0, 60)
    expected = [
        atan(float(str(values["friction"]))) > radians(values["world.tilt"])
        for values in drawn_values(case.variant, draws)
    ]
    assert 5 < sum(expected) < 55
    chunk = varied_chunk(case.variant, "exact", draws)
    assert isinstance(chunk, Chunk)
    assert [outcome == SampleOutcome.STANDS for outcome in chunk.outcomes] == expected


def test_a_sample_with_a_value_that_may_not_be_written_is_a_mistake_of_the_scenario() -> None:
    case = case_of(SLOPE.replace("0.5 ± 0.2", "{normal: 0.01 ± 1}"))
    result = sampled_result(case, 1)
    assert result.status is RunStatus.BLOCKED
    assert result.mistake is not None
    assert "mu = -" in result.mistake.message
