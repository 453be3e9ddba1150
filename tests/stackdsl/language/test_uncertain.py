"""Distributions under `uncertain`: values and mistakes."""

from math import exp, inf, log
from typing import Any

import pytest
from scipy.special import ndtri
from scipy.stats import truncnorm

from stackdsl.language.distributions import distribution
from stackdsl.language.expressions import constant
from stackdsl.language.quantities import InputError
from stackdsl.language.yaml.source import Plain
from tests.scenes import compiled, mistakes_of


def si(written: Plain) -> float:
    """A value in SI."""
    return float(constant(written).magnitude)


@pytest.mark.parametrize(
    ("written", "low", "middle", "high"),
    [
        ("0.5 ± 0.1", 0.42, 0.5, 0.58),
        ("0.4 .. 0.6", 0.42, 0.5, 0.58),
        ({"uniform": "0.5 +- 0.1"}, 0.42, 0.5, 0.58),
        ("5 ± 1 mm", "4.2 mm", "5 mm", "5.8 mm"),
        ("10 deg .. 20 deg", "11 deg", "15 deg", "19 deg"),
        ({"normal": "0.5 ± 0.1"}, 0.5 + 0.1 * ndtri(0.1), 0.5, 0.5 + 0.1 * ndtri(0.9)),
        ({"lognormal": 0.5, "dispersion": 0.2}, 0.5 * exp(0.2 * ndtri(0.1)), 0.5, 0.5 * exp(0.2 * ndtri(0.9))),
        ({"table": ["3 mm", "1 mm", "2 mm"]}, "1 mm", "2 mm", "3 mm"),
    ],
)
def test_quantiles_of_distributions(written: Plain, low: Plain, middle: Plain, high: Plain) -> None:
    found = distribution(written)
    for share, expected in ((0.1, low), (0.5, middle), (0.9, high)):
        value = found.at(share, ndtri)
        assert si(value) == pytest.approx(si(expected), rel=1e-11)
    assert si(found.middle) == pytest.approx(si(middle), rel=1e-15)


@pytest.mark.parametrize(
    ("written", "truth"),
    [
        ({"normal": "0.5 ± 0.2", "least": 0.3}, truncnorm(-1.0, inf, 0.5, 0.2)),
        ("normal 0.5 ± 0.2 least 0.3 most 0.6", truncnorm(-1.0, 0.5, 0.5, 0.2)),
        ("normal 0 ± 1, least 5, most 6", truncnorm(5.0, 6.0)),
        ("normal 0 ± 1, most -5", truncnorm(-inf, -5.0)),
    ],
)
def test_truncated_normal_agrees_with_scipy(written: Plain, truth: Any) -> None:  # noqa: ANN401 -- scipy
    found = distribution(written)
    for share in (1e-6, 0.1, 0.5, 0.9, 0.999):
        assert si(found.at(share, ndtri)) == pytest.approx(float(truth.ppf(share)), rel=1e-8)
    assert si(found.middle) == pytest.approx(float(truth.ppf(0.5)), rel=1e-8)


def test_truncated_lognormal_agrees_with_scipy() -> None:
    found, logarithm = distribution("lognormal 0.5, dispersion 0.2, most 0.6"), truncnorm(-inf, log(1.2) / 0.2)
    for share in (0.01, 0.5, 0.99):
        assert si(found.at(share, ndtri)) == pytest.approx(0.5 * exp(0.2 * float(logarithm.ppf(share))), rel=1e-10)


@pytest.mark.parametrize(
    ("line", "whole"),
    [
        ("normal 12 ± 1 g", {"normal": "12 ± 1 g"}),
        ("uniform 1 mm .. 2 mm", "1 mm .. 2 mm"),
        ("lognormal 0.5, dispersion 0.2", {"lognormal": 0.5, "dispersion": 0.2}),
        ("table 1 mm; 3 mm; 2 mm", {"table": ["1 mm", "3 mm", "2 mm"]}),
        ("normal 0.5 ± 0.2, least 0", {"normal": "0.5 ± 0.2", "least": 0}),
    ],
)
def test_a_distribution_may_be_one_line(line: str, whole: Plain) -> None:
    assert distribution(line) == distribution(whole)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"normal": "0.5 ± 0.1", "least": 2}, "is almost zero"),
        ({"normal": "0.5 ± 0.1", "least": "2 mm"}, "differs from the unit"),
        ({"table": [1, 2], "most": 2}, "do not apply to a"),
        ("normal 0.5 ± 0.1 least ", "cannot be read at 'least'"),
        (0.5, "not a distribution"),
        ({"normal": 0.5}, "a normal distribution needs a standard deviation"),
        ({"gauss": "0.5 ± 0.1"}, "not a distribution"),
        ({"lognormal": 0.5}, "a lognormal distribution needs a dispersion"),
        ({"lognormal": -1, "dispersion": 0.2}, "greater than zero"),
        ({"lognormal": 1, "dispersion": "2 mm"}, "a dispersion has no unit"),
        ({"normal": "0.5 ± 0"}, "greater than zero"),
        ("0.5 ± 0", "is empty"),
        ("0.6 .. 0.4", "is empty"),
        ("1 mm ± 2 deg", "different units"),
        ({"table": ["1 mm", 2]}, "different units"),
        ({"table": []}, "expected a list"),
    ],
)
def test_invalid_distributions_are_rejected(written: Plain, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        distribution(written)
    assert caught.value.hint


COLUMN = "- column: {levels: 2, step: '${gap}'}"


@pytest.mark.parametrize(
    ("build", "rest", "words"),
    [
        (COLUMN, "uncertain: {gap: 5 mm ± 1 mm}\nexpect: [stands: all]", "`uncertain` has no effect"),
        ("- column: {levels: 2}", "samples: 5\nuncertain: {gap: 5 mm ± 1 mm}", "the variable 'gap' is unused"),
        (COLUMN, "samples: 5\nuncertain: {mm: 5 mm ± 1 mm}", "cannot be the name of a variable"),
        (COLUMN, "samples: 5\nuncertain: [5 mm]", "expected a mapping of variables to distributions"),
        (
            COLUMN,
            "samples: 5\nmatrix: {gap: [1 mm]}\nuncertain: {gap: 5 mm ± 1 mm}",
            "already a variable of the matrix",
        ),
        (COLUMN, "samples: 5\nlet: {gap: 1 mm}\nuncertain: {gap: 5 mm ± 1 mm}", "already a variable of the matrix"),
        (COLUMN, "samples: 5\nuncertain: {gap: 5 mm}", "not a distribution"),
    ],
)
def test_contradictory_uncertain_values_are_refused(build: str, rest: str, words: str) -> None:
    mistakes = mistakes_of(build, rest)
    assert any(words in mistake.message for mistake in mistakes), [mistake.message for mistake in mistakes]


def test_nominal_values_are_medians() -> None:
    rest = "samples: 5\nuncertain: {gap: 2 mm .. 8 mm}\nexpect: [stands: {share: 10 %}]"
    cases, mistakes = compiled(f"scenario: scene\nbuild:\n  {COLUMN}\n{rest}")
    assert mistakes == []
    assert cases[0].timeline.placements[1].pose.position_W[0] == pytest.approx(0.005, abs=1e-15)
