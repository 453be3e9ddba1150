"""Verdicts on random assemblies with gaps against linear programmes on contacts that are worked out apart."""

import pytest

from benchmarks.touching import judged, objection, scene
from stability.problem import Stability, Verdict
from stability.statics.assembly import Assembly

SEEDS = range(60)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_verdict_is_contradicted_and_needed_gaps_are_reported(seed: int) -> None:
    found = judged(seed)
    assert found is None or not found.objection


@pytest.mark.slow
@pytest.mark.parametrize("hundred", range(1, 10))
def test_the_same_of_hundreds(hundred: int) -> None:
    found = [judged(seed) for seed in range(100 * hundred, 100 * hundred + 100)]
    assert [each.seed for each in found if each is not None and each.objection] == []


def test_a_programme_objects_to_a_verdict_that_is_not_so() -> None:
    objections = set()
    for seed in SEEDS:
        made = scene(seed)
        if made is None:
            continue
        said = Assembly(made.planes, made.friction, overlap=1e-5).add_all(made.bricks)
        if said.stability is Stability.UNSTABLE or said.touching_within > 0.0:
            objections.add(objection(made, Verdict(Stability.STABLE)))
        else:
            objections.add(objection(made, Verdict(Stability.UNSTABLE)))
    assert {"stable contradicted", "gap not told", "unstable contradicted"} <= objections
