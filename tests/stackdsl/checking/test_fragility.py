"""Fragility curves beside closed forms: medians within 1 %, every count's interval around the truth."""

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fragility import CURVES, drawn, true_median
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.report.studies import fragility_lines
from stackdsl.sampling.sample_outcomes import SampleOutcome
from stackdsl.studies import fragility
from stackdsl.studies.fragility import FragilityPlan, draw
from stackdsl.studies.fragility_curve import (
    CurveSettings,
    Fragility,
    UndeterminedError,
    curve_of_capacities,
    curve_of_outcomes,
    fit_to_capacities,
    fit_to_outcomes,
)
from stackdsl.studies.fragility_intensity import Capacity, Intensity, IntensityKind, NoIntensityError, intensity_of
from tests.stackdsl.checking.in_process import run_here

SMALL = {
    "plank near an edge, over its offset": 2000,
    "tall block, its side normal, over acceleration": 60,
    "brick on a slope that is normal, over friction": 40,
}
QUICK = "brick on a slope that is normal, over friction"  # the others where there is time


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Judge samples here: that processes come to the same is asked of ensembles, and of the command."""
    monkeypatch.setattr(fragility, "run_supervised", run_here)


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] if n != QUICK else []) for n in SMALL])
def test_the_curve_is_that_of_its_closed_form(name: str) -> None:
    found, curve = drawn(CURVES[name], SMALL[name], workers=1, points=5), CURVES[name]
    for point in found.points:
        assert point.within.low <= curve.truth(point.value) <= point.within.high
    assert found.curve is not None
    assert found.curve.median_within.low <= true_median(curve) <= found.curve.median_within.high
    assert found.curve.median == pytest.approx(true_median(curve), rel=0.02 if SMALL[name] < 100 else 0.01)


VALUES = np.geomspace(0.5, 2.0, 9)


def capacities(count: int, seed: int) -> np.ndarray:
    return np.exp(0.3 * np.random.default_rng(seed).standard_normal(count))


def test_intervals_hold_the_truth_as_often_as_they_say_though_samples_are_the_same_at_each_point() -> None:
    held = 0
    for seed in range(200):
        fell = (capacities(100, seed)[:, None] <= VALUES[None, :]).astype(float)
        found = fit_to_outcomes(VALUES, fell, 0.9)
        held += found.median_within.low <= 1.0 <= found.median_within.high
    assert 0.83 <= held / 200 <= 0.96  # nine of ten, within three standard deviations


def test_capacities_give_their_median_and_dispersion() -> None:
    found = fit_to_capacities(capacities(20_000, 3), 0.99)
    assert found.median == pytest.approx(1.0, rel=0.01)
    assert found.dispersion == pytest.approx(0.3, rel=0.02)
    assert found.dispersion_within.low <= 0.3 <= found.dispersion_within.high


def test_what_falls_less_at_more_has_a_falling_curve() -> None:
    fell = (capacities(2000, 5)[:, None] > VALUES[None, :]).astype(float)
    found = fit_to_outcomes(VALUES, fell, 0.95)
    assert not found.rises
    assert found.median == pytest.approx(1.0, rel=0.03)
    assert found.share(0.5) > 0.9


@pytest.mark.parametrize(
    ("fell", "words"),
    [
        ([0, 0, 0, 0], "no sample falls"),
        ([1, 1, 1, 1], "all samples fall"),
        ([0, 0, 1, 1], "the share jumps between"),
        ([1, 1, 0, 0], "the share jumps between"),
    ],
)
def test_what_the_data_do_not_determine_is_told(fell: list[float], words: str) -> None:
    with pytest.raises(UndeterminedError, match=words):
        fit_to_outcomes(np.array([1.0, 2.0, 3.0, 4.0]), np.array([fell] * 10, dtype=float), 0.95)


def test_a_call_that_was_interrupted_goes_on_with_what_is_remembered(tmp_path: Path) -> None:
    text = f"scenario: s\nsamples: 50\n{CURVES['plank near an edge, over its offset'].text}"
    cases, _ = cases_of(parse(text + "expect: [stands: {share: '>= 1 %'}]\n", "s.yaml"))
    intensity = intensity_of("step", cases[0].variant, cases[0].timeline)
    plan, memory = FragilityPlan(cases[0], intensity, (0.05, 0.06), 2, 50, 1, 0.95), ResultCache(tmp_path)
    first = draw(plan, 1, memory, lambda _: None)
    asked: list[int] = []
    again = draw(plan, 1, memory, asked.append)
    assert (asked, again.fragility()) == ([], first.fragility())
    with pytest.raises(NoIntensityError, match="did you mean 'step'"):
        intensity_of("stp", cases[0].variant, cases[0].timeline)


@pytest.mark.usefixtures("in_process")
def test_points_that_nobody_chose_go_to_where_samples_fall_apart() -> None:
    """A block of 100 mm ± 0.5 mm by 500 mm tips at 0.2 g ± 0.5 %: even points would find all or none."""
    block = "{on: ground, brick: {size: [normal 100 mm ± 0.5 mm, 300 mm, 500 mm], mass: 6 kg}}"
    shares = "expect: [{stands: {share: '>= 1 %'}}]"
    text = f"scenario: block\nsamples: 20\nbuild:\n  - bricks: [{block}]\n{shares}\n"
    cases, mistakes = cases_of(parse(text, "a.yaml"))
    assert mistakes == []
    intensity = intensity_of("acceleration", cases[0].variant, cases[0].timeline)
    plan = FragilityPlan(cases[0], intensity, (), 11, 20, 1, 0.95, None)
    found = draw(plan, 1, ResultCache(Path(), used=False), lambda _: None).fragility()
    assert found is not None
    assert found.points[0].value == 0.0
    assert found.points[1].fell == 0
    assert found.points[-1].fell == 20
    assert sum(0 < point.fell < 20 for point in found.points) >= 6


def test_where_the_same_samples_fall_at_all_intensities_the_share_does_not_change() -> None:
    for count in (2, 3):
        fell = np.repeat([[1.0]] * 3 + [[0.0]] * 7, count, axis=1)
        with pytest.raises(UndeterminedError, match="does not change"):
            fit_to_outcomes(np.geomspace(0.3, 0.9, count), fell, 0.95)


def outcomes(capacity: np.ndarray, values: np.ndarray) -> Fragility:
    """The points of samples that fall at their capacity."""
    intensity = Intensity(IntensityKind.FRICTION, "friction", "", 0.5)
    fell = {float(value): [*map(int, capacity <= value)] for value in values}
    return curve_of_outcomes(CurveSettings(intensity, 1, 0.95), fell, {value: {} for value in fell})


def test_one_half_point_is_told_that_of_the_curve_only_where_the_curve_describes_the_points() -> None:
    (first, *_), good = (
        [*fragility_lines("s", outcomes(capacities(500, 3), VALUES))],
        outcomes(capacities(500, 3), VALUES),
    )
    assert good.curve is not None
    assert first.startswith(f"s: half of the samples fall at friction {good.curve.median:.4g} (")
    assert first.endswith("95 %, lognormal fit)")

    two_kinds = np.concatenate([capacities(400, 3) * 0.5, capacities(100, 4) * 5.0])  # half fall at 0.55
    poor = outcomes(two_kinds, np.geomspace(0.2, 20.0, 15))
    text = "\n".join(fragility_lines("s", poor))
    assert poor.curve is not None
    assert not poor.is_lognormal
    assert "median" not in text
    assert f"{poor.curve.median:.4g}" not in text
    low, high = (float(word) for word in re.findall(r"between friction ([\d.]+) and ([\d.]+) \(", text)[0])
    assert low < np.median(two_kinds) < high
    assert "no lognormal curve: the best fit misses the 95 % interval of" in text


def test_the_interval_of_the_median_capacity_holds_for_any_distribution() -> None:
    held = 0
    for seed in range(300):
        ends = np.random.default_rng(seed).exponential(1.0, 80)
        known = [Capacity(SampleOutcome.STANDS, end, end) for end in ends.tolist()]
        intensity = Intensity(IntensityKind.ACCELERATION, "acceleration", "")
        within = curve_of_capacities(CurveSettings(intensity, 1, 0.9), known, [], {}).half_within
        assert within is not None
        held += within.low <= np.log(2.0) <= within.high
    assert 0.87 <= held / 300 <= 0.97  # the coverage of discrete ranks is at least nine of ten
