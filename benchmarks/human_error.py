"""Towers of the publication as hands set them down: how often each falls where it falls without errors.

Every plank is shifted by a normal error along each of two level axes and turned about the upright; errors add up from
plank to plank. Verdicts are those of statics, level by level. Intervals are those of Clopper and Pearson, at 95 %.

python -m benchmarks.human_error            1,000 samples of each scene for each pair of hands
python -m benchmarks.human_error --write    the same, to docs/data
"""

import os
from argparse import Namespace
from collections import Counter
from typing import Final

from rich.console import Console
from rich.progress import track
from scipy.stats import binomtest

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.ensembles import drawn_alone
from stackdsl.checking.gathering import Case, cases_of
from stackdsl.reading.source import parse
from stackdsl.sampling.fates import Fate

SAMPLES, LIMIT = 1_000, 3600.0
SURE: Final = 0.95
# What is built, and at which level it falls without errors; None if it stands.
SCENES: Final[dict[str, tuple[str, int | None]]] = {
    "slant tower": ("four_stack: {levels: 14, step: 12.8 mm, spacing: 90 mm}", 9),
    "four-stack": ("four_stack: {levels: 25}", None),
    "card house": ("card_house: {levels: 3, angle: 70 deg}", None),
}
HANDS: Final = ((0.5, 0.5), (1.0, 1.0), (2.0, 2.0), (4.0, 4.0))  # standard deviations [mm], [deg]


def case_of(layout: str, position: float, yaw: float, samples: int) -> Case:
    """A scene with errors of hands, of which all samples are drawn, since nothing is expected of them."""
    jitter = f"{{position: {position} mm, yaw: {yaw} deg}}"
    build = f"build:\n  - {layout}\n    every: 1 s\n    jitter: {jitter}\n"
    cases, mistakes = cases_of(
        parse(f"scenario: built-by-hand\nsamples: {samples}\nfriction: 0.5\n{build}", "hands.yaml")
    )
    assert not mistakes, mistakes
    return cases[0]


def measured(scene: str, position: float, yaw: float, arguments: Namespace) -> Row:
    """How often a scene comes to the same end as without errors."""
    layout, level = SCENES[scene]
    drawing = drawn_alone(case_of(layout, position, yaw, arguments.samples), arguments.workers, LIMIT)
    assert drawing is not None
    fates = Counter(int(fate) for first in sorted(drawing.chunks) for fate in drawing.chunks[first].fates)
    alike = sum(fates[each] for each in (Fate.STANDS,)) if level is None else fates[level]
    near = alike if level is None else sum(fates[each] for each in (level - 1, level, level + 1))
    between = binomtest(near, arguments.samples).proportion_ci(SURE, method="exact")
    levels = sorted(fate for fate in fates if fate > 0)
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
        "not_proven": fates[Fate.UNDECIDED],
        "unfit": fates[Fate.UNFIT],
        "cpu_ms_a_sample": 1000.0 * drawing.ensemble().cpu_time / arguments.samples,
    }


def main(arguments: Namespace) -> None:
    """Measure, print, and write if asked to."""
    asked = [(scene, *hands) for scene in SCENES for hands in HANDS]
    rows = {
        f"{scene}, {position:g} mm, {yaw:g} deg": measured(scene, position, yaw, arguments)
        for scene, position, yaw in track(asked, "scenes", console=Console(stderr=True))
    }
    for name, row in rows.items():
        Console().print(name, row)
    if arguments.write:
        record("human-error", "python -m benchmarks.human_error --write", {"scenes": rows})


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--samples", type=int, default=SAMPLES)
    options.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    main(options.parse_args())
