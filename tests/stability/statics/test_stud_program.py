"""Structures of many studded bricks: the small programs propose the same load factor as a program written apart."""

import random

import pytest

from benchmarks.studded import LEGO_STRENGTH, assembly_of, drawn
from benchmarks.studded_programs import StudStrength, load_factors
from stability.analysis.load_factor import load_factor
from stability.problem import Stability, Tolerances, rounded
from stability.statics.equilibrium import balance
from stability.statics.proof import check_forces, check_motion

SLIPPERY = StudStrength(1.7, 2.8, 0.3)  # [N] studs that slip before they open


@pytest.mark.parametrize("seed", range(8))
def test_random_lego_structures_stand_below_their_load_factor_and_fall_above_it(seed: int) -> None:
    draw = random.Random(seed)
    boxes = drawn(draw, draw.randint(20, 60))
    low, high = load_factors(boxes, LEGO_STRENGTH)
    for factor, stability in ((low * 0.999, Stability.STABLE), (high * 1.001, Stability.UNSTABLE)):
        assembly, bricks = assembly_of(boxes, LEGO_STRENGTH.times(1.0 / factor))
        verdict = assembly.add_all(bricks)
        assert verdict.stability is stability
        problem = assembly.problem()
        tolerances = rounded(problem, Tolerances())
        if verdict.motion is not None:
            assert check_motion(problem, verdict.motion, tolerances).holds
        else:
            forces = assembly.forces()
            assert forces is not None
            assert check_forces(problem, forces, tolerances).holds


@pytest.mark.parametrize("strength", [LEGO_STRENGTH, SLIPPERY], ids=["lego", "slippery"])
@pytest.mark.parametrize("seed", range(4))
def test_both_bounds_of_the_load_factor_of_random_structures_are_close(seed: int, strength: StudStrength) -> None:
    draw = random.Random(seed)
    boxes = drawn(draw, draw.randint(20, 60))
    low, high = load_factors(boxes, strength)
    assembly, bricks = assembly_of(boxes, strength)
    assembly.add_all(bricks, names_smallest=False)
    found = load_factor(assembly.problem())
    assert found is not None
    assert found.too_large <= found.factor * (1.0 + 2e-5)
    assert found.too_large >= low * (1.0 - 1e-6)  # `low` has less strength along studs, and no friction
    if strength is LEGO_STRENGTH:
        assert found.factor == pytest.approx(high, rel=1e-6)
    else:
        assert found.factor <= high * (1.0 + 1e-6)


def test_forces_of_studs_without_friction_are_free_of_self_stress() -> None:
    boxes = drawn(random.Random(1), 30)
    assembly, bricks = assembly_of(boxes, LEGO_STRENGTH.times(2.0 / load_factors(boxes, LEGO_STRENGTH)[0]))
    assembly.add_all(bricks)
    assert balance(assembly.problem()).frictionless
