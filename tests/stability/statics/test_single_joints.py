"""Parts that hang on one joint of studs: closed forms without a program."""

import random
from math import inf

import pytest

from benchmarks.equilibrium_programs import UprightBox
from benchmarks.studded import LEGO_STRENGTH, assembly_of, drawn
from benchmarks.studded_programs import PITCH, StudStrength, load_factors
from stability.problem import Forces, Motion, Tolerances
from stability.statics.proof import check_forces, check_motion
from stability.statics.single_joints import single_joints

HEIGHT, MASS = 0.0096, 0.002  # [m, kg]
WEIGHT = 9.81 * MASS  # [N]


def cantilever(length: int, pull: float) -> tuple[Forces | None, Motion | None]:
    """The forces or the motion of a brick of 1 x `length` studs that a brick of one stud holds at its end."""
    boxes = [
        UprightBox((0.5 * PITCH, 0.5 * PITCH, 0.5 * HEIGHT), (PITCH, PITCH, HEIGHT), 100.0),
        UprightBox((0.5 * length * PITCH, 0.5 * PITCH, 1.5 * HEIGHT), (length * PITCH, PITCH, HEIGHT), MASS),
    ]
    assembly, bricks = assembly_of(boxes, StudStrength(pull, pull, 100.0))
    assembly.add_all(bricks)
    single = single_joints(assembly.problem())
    if isinstance(single, Motion):
        return None, single
    assert not single.rest.bricks
    return single.whole_forces(Forces(())), None


@pytest.mark.parametrize("length", range(3, 9))
def test_a_brick_on_one_stud_turns_about_the_edge_when_its_weight_outweighs_the_pull(length: int) -> None:
    limit = WEIGHT * (0.5 * length - 1.0) / 0.5  # [N] pull in the middle of the first cell, about its outer edge
    forces, _ = cantilever(length, limit * (1.0 + 1e-9))
    assert forces is not None
    _, motion = cantilever(length, limit * (1.0 - 1e-9))
    assert motion is not None
    assert list(motion.velocity) == ["b001"]


@pytest.mark.parametrize("seed", range(12))
def test_parts_on_single_joints_do_not_change_whether_a_structure_stands(seed: int) -> None:
    draw = random.Random(seed)
    boxes = drawn(draw, draw.randint(4, 40))
    low, high = load_factors(boxes, LEGO_STRENGTH)
    if high == inf:
        return
    for factor in (0.97 * low, 1.03 * high):
        assembly, bricks = assembly_of(boxes, LEGO_STRENGTH.times(1.0 / factor))
        assembly.add_all(bricks, names_smallest=False)
        problem = assembly.problem()
        single = single_joints(problem)
        if isinstance(single, Motion):
            assert factor > high
            assert check_motion(problem, single, Tolerances()).holds
        elif not single.rest.bricks:
            assert factor < low
            assert check_forces(problem, single.whole_forces(Forces(())), Tolerances()).holds
        else:
            weight = sum(-load.force_W[2] for load in problem.loads.values())
            kept = sum(-load.force_W[2] for load in single.rest.loads.values())
            assert kept <= weight * (1.0 + 1e-12)
            names = [name for part in single.parts.values() for name in part]
            assert len(names) == len(set(names))
