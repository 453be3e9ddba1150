"""The data of docs that a bench comes to."""

from dataclasses import replace

import pytest

from benchmarks.systems.bench import Bench
from benchmarks.systems.measured import cases_text, data_of
from benchmarks.systems.points import points_of
from benchmarks.systems.scoring import scores_of
from tests.benchmarks.systems.runs import FELL, SHOULD_STAND, run


def test_the_data_have_the_points_and_the_runs_at_the_systems_own_steps() -> None:
    runs = [replace(run(system="exact"), wall_time=0.01), run(), run(FELL, factor=0.5), run(system="cra", factor=0.0)]
    scores = tuple(scores_of(runs, {"tower": SHOULD_STAND}))
    bench = Bench(scores, tuple(points_of(scores)), {"tower": SHOULD_STAND}, {"python": "3.11"}, 4, interrupted=False)
    points, cases = data_of(bench)
    assert points.tables["bench"]["whole"]["wrong"] == 1
    assert points.value("systems", "tuned", "times_exact") == pytest.approx(200.0)
    assert points.value("points", "tuned, step : 2", "wrong") == 1
    assert points.value("assessors", "cra stands", "mean") == pytest.approx(200.0)
    assert set(cases.tables["runs"]) == {"tower, exact", "tower, tuned", "tower, cra"}
    assert "### tower: stands, truth" in "".join(cases_text(cases))
    assert points.versions == {"python": "3.11"}
