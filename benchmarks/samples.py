"""Measures cost and correctness of samples: towers of 100 planks with errors of 1 mm and 1 deg.

python -m benchmarks.samples            10,000 samples of each tower, 500 of them judged without caches
python -m benchmarks.samples --write    the same, to docs/data
python -m benchmarks.samples --engines 3    a number of samples of a short tower on engines
"""

import os
from argparse import Namespace
from collections.abc import Iterator
from time import perf_counter, process_time
from typing import Final

from rich.console import Console

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.ensembles import Chunk, Drawing, draw_samples, judged_chunk
from stackdsl.language.yaml.source import parse
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, Way, judge_sample
from stackdsl.sampling.samples import Draws, build_plan_of
from stackdsl.simulation.known_systems import unplayable

SAMPLES, COLD, LIMIT = 10_000, 500, 3600.0
TOWERS: Final = {
    "column": "column: {levels: 100}",
    "four-stack": "four_stack: {levels: 50}",
}
SHORT: Final = "column: {levels: 12, step: 6 mm}"  # engines play it in seconds, and it falls in some samples
ENGINES: Final = ("tuned", "stock", "mujoco", "sapien")


def case_of(layout: str, samples: int, jitter: str, every: str = "1 s") -> Case:
    """Return a scenario of one layout without expectations, so that all samples are drawn."""
    text = f"scenario: tower\nsamples: {samples}\nbuild:\n  - {layout}\n    every: {every}\n    jitter: {jitter}\n"
    cases, mistakes = cases_of(parse(text, "tower.yaml"))
    assert not mistakes, mistakes
    return cases[0]


def tower(layout: str, workers: int) -> Row:
    """Return the cost and the outcomes of a tower, and the number of samples with another verdict without caches."""
    case = case_of(layout, SAMPLES, "{position: 1 mm, yaw: 1 deg}")
    started = perf_counter()
    drawing = draw_samples(case, workers, LIMIT)
    wall = perf_counter() - started
    assert drawing is not None
    ensemble = drawing.ensemble()
    cold_started = process_time()
    differing = sum(outcome != cold for outcome, cold in _cold(case, drawing))
    cold = process_time() - cold_started
    return {
        "samples": ensemble.drawn,
        "stood": ensemble.stood,
        "undecided": ensemble.unknown,
        "forces_passed_on": ensemble.ways.get(Way.FORCES, 0),
        "a_fall_passed_on": ensemble.ways.get(Way.FALL, 0),
        "asked_anew": ensemble.ways.get(Way.ANEW, 0),
        "wall_s": wall,
        "workers": workers,
        "cpu_ms_a_sample": 1000.0 * ensemble.cpu_time / ensemble.drawn,
        "cold_samples": COLD,
        "cold_ms_a_sample": 1000.0 * cold / COLD,
        "cold_verdicts_that_differ": differing,
    }


def _cold(case: Case, drawing: Drawing) -> Iterator[tuple[int, int]]:
    """Yield the outcomes of some samples, judged together and one by one by all of statics."""
    together = [outcome for first in sorted(drawing.chunks) for outcome in drawing.chunks[first].outcomes]
    design = build_plan_of(case.timeline)
    for sample in range(0, SAMPLES, SAMPLES // COLD):
        one = Draws(case.scenario.seed, case.scenario.scenario, sample, 1)
        yield together[sample], judge_sample(design, PlacementSampler(design, one).build().placed(0))


def engines(count: int) -> Rows:
    """Compare samples of a short tower on engines with statics: the cost, and the number of different verdicts."""
    case = case_of(SHORT, count, "{position: 3 mm, yaw: 2 deg}", every="0.5 s")
    draws = Draws(case.scenario.seed, case.scenario.scenario, 0, count)
    truth = judged_chunk(case.timeline, "exact", draws)
    rows = {"exact": _row(truth, truth)}
    for system in (each for each in ENGINES if not unplayable(each)):
        rows[system] = _row(judged_chunk(case.timeline, system, draws), truth)
    return rows


def _row(played: Chunk, truth: Chunk) -> Row:
    pairs = list(zip(played.outcomes, truth.outcomes, strict=True))
    return {
        "samples": len(pairs),
        "cpu_ms_a_sample": 1000.0 * played.cpu_time / len(pairs),
        "wrong": sum((outcome == SampleOutcome.STANDS) != (true == SampleOutcome.STANDS) for outcome, true in pairs),
        "other_level": sum(outcome != true for outcome, true in pairs),
    }


def main(arguments: Namespace) -> None:
    """Measure and print the table; write it on request."""
    tables: dict[str, Rows] = {"towers": {name: tower(layout, arguments.workers) for name, layout in TOWERS.items()}}
    if arguments.engines:
        tables["engines"] = engines(arguments.engines)
    console = Console()
    for rows in tables.values():
        for name, row in rows.items():
            cells = (
                f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()
            )
            console.print(f"{name}: {', '.join(cells)}")
    if arguments.write:
        record("samples", f"python -m benchmarks.samples --write --engines {arguments.engines}", tables)


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--engines", type=int, default=0, help="samples of a short tower that engines play")
    options.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    main(options.parse_args())
