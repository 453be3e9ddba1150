"""A bench for other programs: JSON with sorted keys; units end the keys, and what is not known is null."""

import json
import os
import platform
from collections.abc import Mapping
from dataclasses import asdict

from stackdsl.bench.answers import Answer
from stackdsl.bench.conduct import Bench
from stackdsl.bench.points import Point, fronts_of
from stackdsl.bench.run_record import finite
from stackdsl.bench.scoring import Score, numerical_reason
from stackdsl.trace import NUMERICAL_COLLAPSE

FORMAT = 1
RENAMED = {
    "wall_time": "wall_time_s",
    "simulated_time": "simulated_time_s",
    "peak_memory": "peak_memory_bytes",
    "update_median": "update_median_s",
    "update_worst": "update_worst_s",
}  # with their units


def bench_json(bench: Bench) -> str:
    """All of it, with what it was made with."""
    whole = {
        "format": FORMAT,
        "interrupted": bench.interrupted,
        "wanted_runs": bench.wanted,
        "versions": dict(bench.versions),
        "machine": {"architecture": platform.machine(), "system": platform.system(), "cores": os.cpu_count()},
        "answers": {case: _answer(answer) for case, answer in bench.answers.items()},
        "runs": [_run(score) for score in bench.scores],
        "points": [_point(point) for point in bench.points],
        "fronts": {measure: [point.name for point in front] for measure, front in fronts_of(bench.points).items()},
    }
    return json.dumps(whole, indent=2, sort_keys=True, allow_nan=False) + "\n"


def _answer(answer: Answer | None) -> Mapping[str, object] | None:
    if answer is None:
        return None
    return {
        "stands": answer.stands,
        "source": answer.source.value,
        "least_level": finite(answer.least),
        "most_level": finite(answer.most),
    }


def _run(score: Score) -> Mapping[str, object]:
    kept = asdict(score.record)
    del kept["versions"]
    return {RENAMED.get(key, key): value for key, value in kept.items()} | {
        "verdict": score.verdict or None,
        "numerical": numerical_reason(score) if score.verdict == NUMERICAL_COLLAPSE else None,
        "known_from": score.known.value if score.known is not None else None,
        "wrong_verdict": score.wrong,
        "error_levels": score.levels,
        "error_mm": score.mm,
        "error_deg": score.deg,
        "error_s": score.seconds,
        "creep_mm": score.creep,
        "energy_gain_percent": score.energy,
    }


def _point(point: Point) -> Mapping[str, object]:
    renamed = {
        **RENAMED,
        "pace": "wall_s_per_simulated_s",
        "energy": "energy_gain_percent",
        "times_exact": "pace_in_times_of_exact",
    }
    return {renamed.get(key, key): value for key, value in asdict(point).items()} | {"name": point.name}
