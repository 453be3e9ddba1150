"""Random assemblies of round bodies and boxes: no verdict contradicts the linear programs written apart."""

from collections import Counter

import numpy as np
import pytest

from stability.problem import Stability
from stability.statics.assembly import Assembly
from tests.stability.statics.round_programs import KINDS


def contradicted(kind: str, seeds: range) -> tuple[list[int], Counter[str]]:
    """Return the seeds whose verdict a program contradicts, and the number of verdicts."""
    wrong, counts = [], Counter[str]()
    for seed in seeds:
        case = KINDS[kind](np.random.default_rng(seed))
        if not case.placed:
            continue
        assembly = Assembly(planes=case.planes, friction=case.friction)
        found = assembly.add_all(case.placed)
        counts[found.stability if "may roll" not in found.reason else "may roll"] += 1
        balanced = found.stability is Stability.STABLE or "may roll" in found.reason
        if (balanced and not case.may_stand()) or (found.stability is Stability.UNSTABLE and case.can_stand()):
            wrong.append(seed)
    return wrong, counts


@pytest.mark.parametrize("kind", KINDS)
def test_no_verdict_contradicts_a_program_written_apart(kind: str) -> None:
    wrong, counts = contradicted(kind, range(8))
    assert wrong == []
    assert len(counts) > 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_no_verdict_of_many_contradicts_a_program_written_apart(kind: str) -> None:
    wrong, counts = contradicted(kind, range(700))
    assert wrong == []
    assert counts[Stability.STABLE] > 50
    assert counts[Stability.UNSTABLE] > 50
