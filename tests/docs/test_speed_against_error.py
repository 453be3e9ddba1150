"""What a bench writes is what the pages are rendered from."""

import json
from dataclasses import replace

import pytest

from benchmarks.speed_against_error import cases_text, taken_over
from stackdsl.bench.conduct import Bench
from stackdsl.bench.points import points_of
from stackdsl.bench.scoring import scores_of
from stackdsl.bench.summary import bench_json
from tests.stackdsl.bench.runs import FELL, SHOULD_STAND, run


def test_a_bench_is_taken_over_with_its_points_and_its_runs() -> None:
    runs = [replace(run(system="exact"), wall_time=0.01), run(), run(FELL, factor=0.5), run(system="cra", factor=0.0)]
    scores = tuple(scores_of(runs, {"tower": SHOULD_STAND}))
    bench = Bench(scores, tuple(points_of(scores)), {"tower": SHOULD_STAND}, {"python": "3.11"}, 4, interrupted=False)
    points, cases = taken_over(json.loads(bench_json(bench)))
    assert points.tables["bench"]["whole"]["wrong"] == 1
    assert points.value("systems", "tuned", "times_exact") == pytest.approx(200.0)
    assert points.value("points", "tuned, step : 2", "wrong") == 1
    assert points.value("assessors", "cra stands", "mean") == pytest.approx(200.0)
    assert set(cases.tables["runs"]) == {"tower, exact", "tower, tuned", "tower, cra"}
    assert "### tower: stands, truth" in "".join(cases_text(cases))
    assert points.versions == {"python": "3.11"}
