"""Measures how often towers of the publication fall at their nominal level if planks are placed with errors.

Every plank has a normal error along each of two horizontal axes and about the vertical; errors add up from plank to
plank. Verdicts are those of statics, level by level. Intervals are those of Clopper and Pearson, at 95 %. The first
samples of flat planks are placed and judged again by `benchmarks.hands_apart`, which shares only the design and the
random numbers with the package.

python -m benchmarks.human_error            1,000 samples of each scene for each pair of errors, 100 of them verified
python -m benchmarks.human_error --write    the same, to docs/data
"""

import os
from argparse import Namespace
from collections import Counter
from math import radians
from typing import Final

from rich.console import Console
from rich.progress import track
from scipy.stats import binomtest

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.hands_apart import Plank, falls_at, set_down, turn_of
from stability.geometry.box import Box
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.ensembles import draw_samples
from stackdsl.language.yaml.source import parse
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, sample_outcomes_of
from stackdsl.sampling.samples import Draws, build_plan_of

SAMPLES, APART, LIMIT = 1_000, 100, 3600.0
FRICTION = 0.5
SURE: Final = 0.95
# The scenes, and the level at which each falls without errors; None if it stands.
SCENES: Final[dict[str, tuple[str, int | None]]] = {
    "slant tower": ("four_stack: {levels: 14, step: 12.8 mm, spacing: 90 mm}", 9),
    "four-stack": ("four_stack: {levels: 25}", None),
    "card house": ("card_house: {levels: 3, angle: 70 deg}", None),
}
FLAT: Final = ("slant tower", "four-stack")
HANDS: Final = ((0.5, 0.5), (1.0, 1.0), (2.0, 2.0), (4.0, 4.0))  # standard deviations [mm], [deg]


def case_of(layout: str, position: float, yaw: float, samples: int) -> Case:
    """Return a scene with placement errors; without expectations, so that all samples are drawn."""
    jitter = f"{{position: {position} mm, yaw: {yaw} deg}}"
    build = f"build:\n  - {layout}\n    every: 1 s\n    jitter: {jitter}\n"
    cases, mistakes = cases_of(
        parse(f"scenario: built-by-hand\nsamples: {samples}\nfriction: {FRICTION}\n{build}", "hands.yaml")
    )
    assert not mistakes, mistakes
    return cases[0]


def measured(scene: str, position: float, yaw: float, arguments: Namespace) -> Row:
    """Return how often a scene has the same outcome as without errors."""
    layout, level = SCENES[scene]
    drawing = draw_samples(case_of(layout, position, yaw, arguments.samples), arguments.workers, LIMIT)
    assert drawing is not None
    outcomes = Counter(int(outcome) for first in sorted(drawing.chunks) for outcome in drawing.chunks[first].outcomes)
    alike = sum(outcomes[each] for each in (SampleOutcome.STANDS,)) if level is None else outcomes[level]
    near = alike if level is None else sum(outcomes[each] for each in (level - 1, level, level + 1))
    between = binomtest(near, arguments.samples).proportion_ci(SURE, method="exact")
    levels = sorted(outcome for outcome in outcomes if outcome > 0)
    return {
        "scene": scene,
        "hands": f"{position:g} mm, {yaw:g} deg",
        "without": "stands" if level is None else f"falls at level {level}",
        "same_percent": 100.0 * alike / arguments.samples,
        "claim": "stands" if level is None else f"level {level} ± 1",
        "percent": 100.0 * near / arguments.samples,
        "least_percent": 100.0 * between.low,
        "most_percent": 100.0 * between.high,
        "fell_at": f"{levels[0]} .. {levels[-1]}" if levels else "-",
        "not_proven": outcomes[SampleOutcome.UNDECIDED],
        "unfit": outcomes[SampleOutcome.UNFIT],
        "cpu_ms_a_sample": 1000.0 * drawing.ensemble().cpu_time / arguments.samples,
    }


def held_apart(scene: str, position: float, yaw: float, count: int) -> Row:
    """Place and judge the first samples of a scene by the package and independently of it."""
    case = case_of(SCENES[scene][0], position, yaw, count)
    draws = Draws(case.scenario.seed, case.scenario.scenario, 0, count)
    design = build_plan_of(case.timeline)
    ours, hands = sample_outcomes_of(design, draws).values.tolist(), PlacementSampler(design, draws).build()
    planks = []
    for each in case.timeline.placements:
        shape = each.brick.shape
        assert isinstance(shape, Box)
        (x, y, z), size = each.pose.position_W, shape.size
        turn = turn_of(each.pose.orientation)
        planks.append(Plank(each.brick.id, x, y, z - 0.5 * size[2], turn, size, each.brick.mass, each.level))
    alike = not_said = asked = 0
    off = 0.0
    for sample in range(count):
        alone = Draws(draws.seed, draws.scenario, sample, 1)
        there = set_down(planks, alone, 1e-3 * position, radians(yaw))
        for plank, placed in zip(there, hands.placed(sample), strict=True):
            off = max(off, *(abs(a - b) for a, b in zip(plank.middle, placed.pose.position_W, strict=True)))
        level, planks_asked = falls_at(there, FRICTION)
        asked += planks_asked
        not_said += level is None
        alike += level == ours[sample]
    return {
        "scene": scene,
        "hands": f"{position:g} mm, {yaw:g} deg",
        "samples": count,
        "asked": asked,
        "alike": alike,
        "contradicted": count - alike - not_said,
        "not_said": not_said,
        "off_nm": 1e9 * off,
    }


def main(arguments: Namespace) -> None:
    """Measure and print the table; write it on request."""
    asked = [(scene, *hands) for scene in SCENES for hands in HANDS]
    rows = {
        f"{scene}, {position:g} mm, {yaw:g} deg": measured(scene, position, yaw, arguments)
        for scene, position, yaw in track(asked, "scenes", console=Console(stderr=True))
    }
    for name, row in rows.items():
        Console().print(name, row)
    apart = {
        f"{scene}, {position:g} mm, {yaw:g} deg": held_apart(scene, position, yaw, arguments.apart)
        for scene, position, yaw in track(
            [each for each in asked if each[0] in FLAT], "apart", console=Console(stderr=True)
        )
    }
    for name, row in apart.items():
        Console().print(name, row)
    if arguments.write:
        record("human-error", "python -m benchmarks.human_error --write", {"scenes": rows, "apart": apart})


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--samples", type=int, default=SAMPLES)
    options.add_argument("--apart", type=int, default=APART)
    options.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    main(options.parse_args())
