"""Samples from Python are those of YAML."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from stackdsl.api.claims import stands
from stackdsl.api.layouts import column
from stackdsl.api.scenario import Scenario
from stackdsl.api.sweep import sweep
from stackdsl.checking.ensembles import sampled_result
from tests.scenes import compiled


def test_samples_from_python_are_those_of_yaml() -> None:
    step = column(levels=8, step="8 mm", every="1 s", jitter={"position": "4 mm"})
    scenario = Scenario("column", build=[step], samples=300, seed=4, confidence="90 %", expect=[stands(share="70 %")])
    result = scenario.draw()
    cases, mistakes = compiled(scenario.to_yaml())
    assert mistakes == []
    assert result.ensemble == sampled_result(cases[0], 1).ensemble
    assert result.ensemble is not None
    assert result.ensemble.seed == 4
    assert result.outcomes[0].measured.endswith(f"({result.ensemble.stood} of {result.ensemble.drawn} samples)")


def test_what_has_no_samples_cannot_be_drawn() -> None:
    with pytest.raises(ValueError, match="has no samples"):
        Scenario("column", build=[column(levels=2)]).draw()


def test_an_executor_of_somebody_elses_draws_and_sweeps_the_same(tmp_path: Path) -> None:
    step = column(levels=5, step="8 mm", every="1 s", jitter={"position": "5 mm"})
    scenario = Scenario("column", build=[step], samples=150, expect=[stands(share="80 %")])
    with ThreadPoolExecutor(1) as threads:
        ensemble = scenario.draw(executor=threads).ensemble
        (there,) = sweep(scenario.cases, tmp_path / "there.jsonl", executor=threads, workers=1)
    (here,) = sweep(scenario.cases, tmp_path / "here.jsonl", workers=1)
    assert (tmp_path / "there.jsonl").read_bytes() == (tmp_path / "here.jsonl").read_bytes()
    assert ensemble is not None
    assert ensemble == scenario.draw().ensemble
    assert ensemble.drawn == here.rows == 150
    assert here.verdicts == there.verdicts == {"stands": ensemble.stood, "collapses": sum(ensemble.fell.values())}
    assert here.fell == ensemble.fell
