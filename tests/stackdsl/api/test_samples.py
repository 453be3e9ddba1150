"""Samples from Python are those of YAML."""

import pytest

from stackdsl.api.claims import stands
from stackdsl.api.layouts import column
from stackdsl.api.scenario import Scenario
from stackdsl.checking.sampled_results import drawn_result
from tests.scenes import compiled


def test_samples_from_python_are_those_of_yaml() -> None:
    step = column(levels=8, step="8 mm", every="1 s", jitter={"position": "4 mm"})
    scenario = Scenario("column", build=[step], samples=300, seed=4, confidence="90 %", expect=[stands(share="70 %")])
    result = scenario.draw()
    cases, mistakes = compiled(scenario.to_yaml())
    assert mistakes == []
    assert result.ensemble == drawn_result(cases[0], 1).ensemble
    assert result.ensemble is not None
    assert result.ensemble.seed == 4
    assert result.outcomes[0].measured.endswith(f"({result.ensemble.stood} of {result.ensemble.drawn} samples)")


def test_what_has_no_samples_cannot_be_drawn() -> None:
    with pytest.raises(ValueError, match="has no samples"):
        Scenario("column", build=[column(levels=2)]).draw()
