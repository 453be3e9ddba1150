"""Fragility curves beside closed forms: medians within 1 %, every count's interval around the truth."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fragility import CURVES, drawn, true_median
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case, cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.report.studies import as_values, capacities_table, fragility_lines, fragility_table
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
from stackdsl.studies.fragility_request import FragilityRequest, FragilityRequestError, plan_of
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
        found, _ = fit_to_outcomes(VALUES, fell, 0.9)
        held += found.median_within.low <= 1.0 <= found.median_within.high
    assert 0.83 <= held / 200 <= 0.96  # nine of ten, within three standard deviations


def test_capacities_give_their_median_and_dispersion() -> None:
    found, _ = fit_to_capacities(capacities(20_000, 3), 0.99)
    assert found.median == pytest.approx(1.0, rel=0.01)
    assert found.dispersion == pytest.approx(0.3, rel=0.02)
    assert found.dispersion_within.low <= 0.3 <= found.dispersion_within.high


def test_what_falls_less_at_more_has_a_falling_curve() -> None:
    fell = (capacities(2000, 5)[:, None] > VALUES[None, :]).astype(float)
    found, _ = fit_to_outcomes(VALUES, fell, 0.95)
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


def block() -> Case:
    """Return a block that tips at 0.2 g ± 0.5 %."""
    brick = "{on: ground, brick: {size: [normal 100 mm ± 0.5 mm, 300 mm, 500 mm], mass: 6 kg}}"
    shares = "expect: [{stands: {share: '>= 1 %'}}]"
    text = f"scenario: block\nsamples: 20\nbuild:\n  - bricks: [{brick}]\n{shares}\n"
    cases, mistakes = cases_of(parse(text, "a.yaml"))
    assert mistakes == []
    return cases[0]


@pytest.mark.usefixtures("in_process")
def test_points_that_nobody_chose_go_to_where_samples_fall_apart() -> None:
    """A block of 100 mm ± 0.5 mm by 500 mm tips at 0.2 g ± 0.5 %: even points would find all or none."""
    plan = plan_of(block(), FragilityRequest("acceleration", samples=20))
    found = draw(plan, 1, ResultCache(Path(), used=False), lambda _: None).fragility()
    assert found is not None
    counts = [point.fell for point in found.points]
    assert counts[0] == 1
    assert counts[-1] == 20
    assert counts == sorted(set(counts))  # more samples fall at each point than at the one before


def test_where_the_same_samples_fall_at_all_intensities_the_share_does_not_change() -> None:
    for count in (3, 4):
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
    assert poor.curve is None
    assert poor.refused is not None
    assert f"{poor.refused.median:.4g}" not in text
    low, high = (float(word) for word in re.findall(r"between friction ([\d.]+) and ([\d.]+) \(", text)[0])
    assert low < np.median(two_kinds) < high
    assert "no lognormal curve: refused with p < 0.0001 (chi-squared test of all points, level 5 %)" in text
    assert as_values(poor)["lognormal"] is None
    assert as_values(poor)["no_lognormal"]


@pytest.mark.parametrize("count", [25, 400])
def test_a_lognormal_curve_is_refused_as_often_as_the_level_says(count: int) -> None:
    by_points = by_capacities = independent = 0
    for seed in range(400):
        known = capacities(count, seed)
        by_capacities += fit_to_capacities(known, 0.95)[1].refuses
        by_points += fit_to_outcomes(VALUES, (known[:, None] <= VALUES).astype(float), 0.95)[1].refuses
        anew = np.exp(0.3 * np.random.default_rng(seed).standard_normal((count, len(VALUES))))
        independent += fit_to_outcomes(VALUES, (anew <= VALUES).astype(float), 0.95)[1].refuses
    # 5 % of 400 are 20, with a standard deviation of 4.4; few samples a point are refused less often.
    assert 10 <= by_capacities <= 31
    assert 4 <= by_points <= 31
    assert 4 <= independent <= 31


def test_capacities_that_are_not_lognormal_are_refused() -> None:
    known = np.random.default_rng(1).weibull(2.0, 400)
    test = fit_to_capacities(known, 0.95)[1]
    assert test.p < 1e-4
    share = float((known <= test.at).mean())
    fitted = fit_to_capacities(known, 0.95)[0].share(test.at)
    assert abs(share - fitted) == pytest.approx(test.largest, abs=1 / 400)
    assert fit_to_outcomes(VALUES, (known[:, None] <= VALUES).astype(float), 0.95)[1].p < 1e-3


@pytest.mark.parametrize(("written", "in_g"), [("0.1 g", 0.1), ("0.1", 0.1), ("0.980665 m/s2", 0.1), ("0", 0.0)])
def test_the_range_of_an_acceleration_accepts_its_units(written: str, in_g: float) -> None:
    case = block()
    plan = plan_of(case, FragilityRequest("acceleration", written, "0.5 g", points=2))
    assert plan.values == pytest.approx((in_g, 0.5))
    with pytest.raises(FragilityRequestError, match="'mm' is not a unit of an acceleration"):
        plan_of(case, FragilityRequest("acceleration", "1 mm", "0.5 g"))


@pytest.mark.usefixtures("in_process")
def test_the_settings_stand_in_text_csv_and_json() -> None:
    curve = {}
    for bearing in (None, 0.0):
        plan = plan_of(block(), FragilityRequest("acceleration", samples=20, seed=5, bearing=bearing))
        found = draw(plan, 1, ResultCache(Path(), used=False), lambda _: None).fragility()
        assert found is not None
        curve[bearing] = found
    worst, along = curve[None], curve[0.0]
    assert "  20 samples, seed 5; no jitter; worst direction of each sample" in [*fragility_lines("s", worst)]
    assert "  20 samples, seed 5; no jitter; direction 0 deg from +x towards +y" in [*fragility_lines("s", along)]
    assert (as_values(worst)["bearing_deg"], as_values(along)["bearing_deg"]) == ("worst", 0.0)
    header, first, *_ = csv.reader(fragility_table([("s", worst)]).csv().splitlines())
    assert dict(zip(header, first, strict=True))["bearing_deg"] == "worst"
    assert dict(zip(header, first, strict=True))["seed"] == "5"
    rows = capacities_table([("s", along)]).rows
    assert [row["sample"] for row in rows] == list(range(20))
    for row in rows:  # half the side over half the height
        assert row["survives"] <= row["falls"]
        assert row["survives"] == pytest.approx(0.2, rel=0.05)


def test_samples_that_fell_during_the_build_count_as_fallen_but_are_not_in_the_curve() -> None:
    stand = [Capacity(SampleOutcome.STANDS, end, end) for end in capacities(300, 3).tolist()]
    fallen = [Capacity(1, 0.0, 0.0)] * 100
    intensity = Intensity(IntensityKind.ACCELERATION, "acceleration", "")
    terms = CurveSettings(intensity, 1, 0.95)
    alone = curve_of_capacities(terms, stand, [0.5, 1.0], {})
    both = curve_of_capacities(terms, stand + fallen, [0.5, 1.0], {})
    assert both.curve == alone.curve
    assert [point.fell for point in both.points] == [point.fell + 100 for point in alone.points]
    assert both.half is not None
    assert sum(each.fails <= both.half for each in stand + fallen) == pytest.approx(200, abs=1)
    assert "100 samples fell during the build and count as fallen at each point" in "\n".join(
        fragility_lines("s", both)
    )


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
