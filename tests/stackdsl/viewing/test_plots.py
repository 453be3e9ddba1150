"""Plots of studies: what they mark is where the numbers say, and no curve is drawn that does not hold."""

import re
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from stackdsl.judging.proofs import BearingSurvival, Survival
from stackdsl.judging.statistics import Interval
from stackdsl.studies.fragility_curve import CurvePoint, FitTest, Fragility, Lognormal
from stackdsl.studies.fragility_intensity import Intensity, IntensityKind
from stackdsl.viewing.plots import MIDDLE, RADIUS, Axis, drawn_fragility, drawn_survival
from stackdsl.viewing.svg import GREEN, RED, width_of


def survival(*survived: float) -> Survival:
    bearings = [2.0 * pi * number / len(survived) for number in range(len(survived))]
    along = [BearingSurvival(b, value, value, value, "") for b, value in zip(bearings, survived, strict=True)]
    return Survival(tuple(along), None)


def test_the_weakest_direction_is_marked_at_its_bearing_and_distance() -> None:
    svg = drawn_survival("tower", survival(1.0, 1.0, 1.0, 0.5), ".svg").decode()  # weakest towards -y
    assert "survives 0.5 g in every direction, weakest towards -y" in svg
    x, y = (float(value) for value in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="5"', svg)[0])
    assert (x, y) == pytest.approx((MIDDLE[0], MIDDLE[1] + 0.5 * RADIUS), abs=0.1)


def test_the_expected_limit_is_a_ring_whose_colour_and_label_say_whether_it_is_met() -> None:
    met = drawn_survival("tower", survival(1.0, 1.0, 1.0, 0.5), ".svg", expected=0.4).decode()
    (radius,) = re.findall(rf'r="([\d.]+)" fill="none" stroke="{GREEN}"', met)
    assert float(radius) == pytest.approx(0.4 * RADIUS, abs=0.1)
    assert ">expected: 0.4 g<" in met
    missed = drawn_survival("tower", survival(1.0, 1.0, 1.0, 0.5), ".svg", expected=0.6).decode()
    (radius,) = re.findall(rf'r="([\d.]+)" fill="none" stroke="{RED}"', missed)
    assert float(radius) == pytest.approx(0.6 * RADIUS, abs=0.1)
    assert ">expected: 0.6 g, not met<" in missed


@pytest.mark.parametrize("weakest", [0.02, 0.3, 0.98])
@pytest.mark.parametrize("place", range(8))
def test_no_label_lies_on_the_curve(weakest: float, place: int) -> None:
    values = [1.0 if number != place else weakest for number in range(8)]
    svg = drawn_survival("tower", survival(*values), ".svg", expected=0.5).decode()
    (corners,) = re.findall(r'<polygon points="([^"]+)" fill="#1a56b0"', svg)
    curve = [(float(x), float(y)) for x, y in (corner.split(",") for corner in corners.split())]
    labels = re.findall(r'<text x="([\d.]+)" y="([\d.]+)" text-anchor="middle"[^>]*>([^<]*)', svg)
    assert sum(" g" in text for _, _, text in labels) >= 3  # weakest, expected, and a ring
    for x, y, text in labels:
        half = width_of(text) / 2.0
        for begin, end in zip(curve, [*curve[1:], curve[0]], strict=True):
            along = np.linspace(begin, end, 50) - (float(x), float(y) - 4.0)
            assert not ((np.abs(along[:, 0]) < half) & (np.abs(along[:, 1]) < 6.0)).any(), text


def test_a_logarithmic_axis_places_the_geometric_mean_in_the_middle() -> None:
    axis = Axis(0.1, 10.0, 0.0, 100.0, logarithmic=True)
    assert axis.place(1.0) == pytest.approx(50.0)
    assert list(axis.ticks()) == pytest.approx([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])


def curve(*fell: int, refused: bool = False) -> Fragility:
    """A curve with its median at 1 mm, and points of a hundred samples each at 0.5, 1 and 2 mm."""
    points = [
        CurvePoint(value, count, 0, 100, Interval(count / 100 - 0.05, count / 100 + 0.05))
        for value, count in zip((0.0005, 0.001, 0.002), fell, strict=True)
    ]
    known = Interval(0.0, 1.0)
    lognormal = Lognormal(0.001, 0.5, known, known, rises=True)
    intensity = Intensity(IntensityKind.JITTER, "jitter", "m", 0.001)
    test = FitTest("test", 0.001 if refused else 0.5, 0.2, 0.001)
    found = Fragility(intensity, tuple(points), lognormal, "", 0.001, Interval(0.0005, 0.002), 1, 0.95, test=test)
    return replace(found, curve=None, refused=lognormal, no_curve="refused with p = 0.001") if refused else found


def test_a_refused_lognormal_curve_is_dashed() -> None:
    # ln 2 / 0.5 = 1.386 standard deviations from the median: 8.3 % and 91.7 %.
    good = drawn_fragility("tower", curve(8, 50, 92), ".svg").decode()
    assert good.count("<polyline") == 1
    assert not re.findall("<polyline[^>]*dasharray", good)
    assert "line: lognormal curve, not refused, p = 0.5" in good
    poor = drawn_fragility("tower", curve(40, 50, 60, refused=True), ".svg").decode()
    assert len(re.findall("<polyline[^>]*dasharray", poor)) == 1
    assert "dashed: no lognormal curve, the best fit is refused with p = 0.001" in poor
    assert poor.count("<circle") == 3


def test_no_point_lies_on_the_edge_of_the_plot() -> None:
    svg = drawn_fragility("tower", curve(8, 50, 92), ".svg").decode()
    (left, right), *_ = re.findall(r"M([\d.]+) [\d.]+H([\d.]+)", svg)  # a line of the grid
    points = [float(x) for x in re.findall(r'<circle cx="([\d.]+)"', svg)]
    assert float(left) + 10.0 < min(points)
    assert max(points) < float(right) - 10.0


def test_the_plot_marks_the_half_point_that_its_text_states() -> None:
    good = drawn_fragility("tower", curve(8, 50, 92), ".svg").decode()
    assert "half of the samples fall at jitter 1 mm" in good
    points = [float(x) for x in re.findall(r'<circle cx="([\d.]+)"', good)]
    (foot,) = re.findall(r'H([\d.]+)V[\d.]+" stroke="[^"]+" stroke-dasharray', good)
    assert float(foot) == pytest.approx(points[1])
    poor = drawn_fragility("tower", curve(40, 50, 60, refused=True), ".svg").decode()
    assert "half of the samples fall between jitter 0.5 mm and 2 mm" in poor
    ((x, width),) = re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="([\d.]+)" [^>]+ fill-opacity', poor)
    points = [float(x) for x in re.findall(r'<circle cx="([\d.]+)"', poor)]
    assert (float(x), float(x) + float(width)) == pytest.approx(
        (points[0], points[2]), abs=0.15
    )  # sums of rounded numbers
