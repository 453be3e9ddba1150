"""Compares fragility curves with closed forms: medians, coverage of the intervals, and cost.

python -m benchmarks.fragility            all curves
python -m benchmarks.fragility --write    the same, to docs/data
"""

import os
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from math import atan, inf, tan
from pathlib import Path
from typing import Final

import numpy as np
from rich.console import Console
from scipy.optimize import brentq
from scipy.special import ndtr

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.studies.fragility import FragilityPlan, draw
from stackdsl.studies.fragility_curve import Fragility, spaced
from stackdsl.studies.fragility_intensity import intensity_of

CONFIDENCE: Final = 0.999  # of each point: with a hundred points one curve in ten misses one by chance
POINTS: Final = 11
HALF_LENGTH, HALF_WIDTH = 0.0588, 0.0117  # [m] of a KAPLA plank
MANY: Final = 200_000  # samples of numpy, if only the condition has a closed form


@dataclass(frozen=True, slots=True)
class Curve:
    """Scenario with a known probability of collapse."""

    text: str
    over: str
    first: float
    last: float
    samples: int
    truth: Callable[[float], float]  # the probability of a fall, by intensity in SI
    bearing: float | None = 0.0  # of the acceleration or tilt


def _within(middle: float, spread: float, half: float) -> float:
    """Return the probability that a normal variable lies within a half width of zero."""
    return float(ndtr((half - middle) / spread) - ndtr((-half - middle) / spread))


def plank(offset: float, spread: float) -> float:
    """Return the share of falls of a plank placed on another with normal errors along both axes.

    It falls if its centre is beyond an edge.
    """
    return 1.0 - _within(offset, spread, HALF_LENGTH) * _within(0.0, spread, HALF_WIDTH)


def plate(spread: float) -> float:
    """Return the share of falls of a plate of 200 mm on a beam of 20 mm.

    It falls if its centre is beyond the beam, and lies on the ground if it misses the beam.
    """
    on_it = _within(0.0, spread, 0.01) * _within(0.0, spread, 0.1)
    beside = 1.0 - _within(0.0, spread, 0.11) * _within(0.0, spread, 0.2)
    return 1.0 - on_it - beside


def column(spread: float, step: float = 7e-3, levels: int = 10) -> float:
    """Return the share of falls of a column of planks, each offset by a step and normal errors; sampled with numpy.

    It stands if the common centre of all planks above each plank lies above that plank.
    """
    generator = np.random.default_rng(11)
    x = np.cumsum(step + spread * generator.standard_normal((levels, MANY)), axis=0)
    y = np.cumsum(spread * generator.standard_normal((levels, MANY)), axis=0)
    fell = np.zeros(MANY, dtype=bool)
    for top in range(1, levels):
        for low in range(top):
            fell |= np.abs(x[low + 1 : top + 1].mean(axis=0) - x[low]) > HALF_LENGTH
            fell |= np.abs(y[low + 1 : top + 1].mean(axis=0) - y[low]) > HALF_WIDTH
    return float(fell.mean())


def _tall(side: str) -> str:
    brick = f"brick: {{size: [{side}, 300 mm, 500 mm], mass: 1 kg}}"
    return f"build:\n  - bricks: [{{on: ground, {brick}}}]\nfriction: 2\n"


ON_EDGE: Final = (
    "let: {step: 40 mm}\nbuild:\n  - bricks: [{name: a, on: ground}]\n"
    '  - bricks: [{on: a, offset: ["${step}", 0 mm, 0 mm]}]\n    jitter: {position: 3 mm}\n'
)
PLATE: Final = (
    "build:\n  - bricks: [{name: a, on: ground, brick: {size: [200 mm, 20 mm, 20 mm], mass: 100 g}}]\n"
    "  - bricks: [{on: a, brick: {size: [200 mm, 200 mm, 10 mm], mass: 500 g}}]\n    jitter: {position: 3 mm}\n"
)
CURVES: Final = {
    "plank near an edge, over its offset": Curve(
        ON_EDGE, "step", 50e-3, 68e-3, 10_000, lambda offset: plank(offset, 3e-3)
    ),
    "plate on a beam, over placement errors": Curve(PLATE, "jitter", 9e-3, 24e-3, 20_000, plate),
    "column of ten planks, over placement errors": Curve(
        "build:\n  - column: {levels: 10, step: 7 mm}\n    every: 1 s\n    jitter: {position: 3 mm}\n",
        "jitter",
        2.5e-3,
        9e-3,
        10_000,
        column,
    ),
    "tall block, its side lognormal, over acceleration": Curve(
        _tall("lognormal 100 mm dispersion 0.1"),
        "acceleration",
        0.12,
        0.3,
        2000,
        lambda g: float(ndtr(np.log(g / 0.2) / 0.1)),
    ),
    "tall block, its side normal, over acceleration": Curve(
        _tall("normal 100 mm ± 5 mm"),
        "acceleration",
        0.16,
        0.24,
        2000,
        lambda g: float(ndtr((500.0 * g - 100.0) / 5.0)),
    ),
    "tall block, its side normal, over tilt": Curve(
        _tall("normal 100 mm ± 5 mm"),
        "tilt",
        atan(0.16),
        atan(0.24),
        500,
        lambda angle: float(ndtr((500.0 * tan(angle) - 100.0) / 5.0)),
        None,
    ),
    "brick on a slope that is normal, over friction": Curve(
        "world: {tilt: normal 20 deg ± 1 deg}\nbuild:\n  - bricks: [{on: ground}]\n",
        "friction",
        0.3,
        0.44,
        2000,
        lambda mu: float(1.0 - ndtr((np.degrees(atan(mu)) - 20.0) / 1.0)),
    ),
}


def drawn(curve: Curve, samples: int, workers: int, points: int = POINTS, seed: int = 1) -> Fragility:
    """Return the curve of a scenario, computed without the cache."""
    text = f"scenario: curve\nsamples: {samples}\n{curve.text}expect:\n  - stands: {{share: '>= 1 %'}}\n"
    cases, mistakes = cases_of(parse(text, "curve.yaml"))
    assert not mistakes, mistakes
    intensity = intensity_of(curve.over, cases[0].variant, cases[0].timeline)
    values = tuple(float(value) for value in spaced(curve.first, curve.last, points))
    plan = FragilityPlan(cases[0], intensity, values, points, samples, seed, CONFIDENCE, curve.bearing)
    fragility = draw(plan, workers, ResultCache(Path(), used=False), lambda _: None).fragility()
    assert fragility is not None
    return fragility


def true_median(curve: Curve) -> float:
    """Return the intensity with a probability of collapse of one half."""
    return float(brentq(lambda value: curve.truth(value) - 0.5, curve.first, curve.last, xtol=1e-9))


def row(curve: Curve, workers: int) -> Row:
    """Return the figures of a curve and of its closed form."""
    result, median = drawn(curve, curve.samples, workers), true_median(curve)
    shown = result.intensity.shown
    points = [(point.within, curve.truth(point.value)) for point in result.points]
    fitted, half = result.fit.median if result.fit is not None else inf, result.half or inf
    verdicts = curve.samples if result.intensity.kind in ("acceleration", "tilt") else curve.samples * len(points)
    return {
        "unit": result.intensity.shown_unit,
        "samples": curve.samples,
        "true_median": shown(median),
        "fitted_median": shown(fitted),
        "off_percent": 100.0 * (fitted / median - 1.0),
        "half": shown(half),
        "half_off_percent": 100.0 * (half / median - 1.0),
        "dispersion": float(result.fit.dispersion) if result.fit is not None else inf,
        "points": len(points),
        "points_that_hold_the_truth": sum(within.low <= truth <= within.high for within, truth in points),
        "p": result.test.p_text if result.test is not None else "",
        "open": result.left_out,
        "cpu_ms_a_verdict": 1000.0 * result.cpu_time / verdicts,
    }


def main(arguments: Namespace) -> None:
    """Measure and print the table; write it on request."""
    rows: dict[str, Row] = {}
    console = Console(width=200)
    for name, curve in CURVES.items():
        rows[name] = row(curve, arguments.workers)
        cells = (
            f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in rows[name].items()
        )
        console.print(f"{name}: {', '.join(cells)}")
    if arguments.write:
        record("fragility", "python -m benchmarks.fragility --write", {"curves": rows})


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    main(options.parse_args())
