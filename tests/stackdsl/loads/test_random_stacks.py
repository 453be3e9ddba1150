"""Random stacks under random loads: verdicts of the cascade agree with the load factor of the whole structure."""

import random

import pytest

from stability import Assembly, Box, Brick, Load, Loads, Placed, Pose, Stability, load_factor
from stability.problem import Tolerances
from stability.statics.proof import check_forces, check_motion


def drawn(seed: int) -> tuple[list[Placed], Loads]:
    """Return blocks on two piers with a beam, a stack on it, and loads on some; half of the loads are vertical."""
    draw = random.Random(seed)
    bricks = []
    for name, x in (("left", -0.4), ("right", 0.4)):
        bricks += [_brick(f"{name}{level}", x + draw.uniform(-0.03, 0.03), 0.1 + 0.2 * level) for level in range(3)]
    bricks.append(Placed(Brick("beam", Box((1.2, 0.2, 0.1)), 10.0), Pose((draw.uniform(-0.05, 0.05), 0.0, 0.65))))
    bricks += [_brick(f"top{level}", draw.uniform(-0.05, 0.05), 0.8 + 0.2 * level) for level in range(3)]
    loads = []
    for placed in draw.sample(bricks, 3):
        upright = draw.random() < 0.5
        size = 10 ** draw.uniform(-0.5, 2.2)
        sideways = (0.0, 0.0) if upright else (draw.uniform(-1.0, 1.0), draw.uniform(-0.3, 0.3))
        force = (size * sideways[0], size * sideways[1], size * draw.uniform(-1.0, 0.4))
        point = (draw.uniform(-0.1, 0.1), draw.uniform(-0.05, 0.05), 0.05)
        moment = (0.0, 0.0, 0.0) if upright else (0.0, 0.1 * size * draw.uniform(-1.0, 1.0), 0.0)
        loads.append(Load(placed.brick.id, force, point, moment, turns=draw.random() < 0.5))
    return bricks, Loads(tuple(loads))


def _brick(name: str, x: float, z: float) -> Placed:
    return Placed(Brick(name, Box((0.2, 0.2, 0.2)), 8.0), Pose((x, 0.0, z)))


@pytest.mark.parametrize("seed", range(60))
def test_verdicts_agree_with_the_load_factor_and_outlast_an_undone_removal(seed: int) -> None:
    bricks, loads = drawn(seed)
    together = Assembly(loads=loads)
    verdict = together.add_all(bricks)
    problem = together.problem()
    found = load_factor(problem.unloaded, problem.applied)
    assert found is not None
    assert not found.factor <= 1.0 <= found.too_large  # the draw has no case at its limit
    assert verdict.stability is (Stability.STABLE if found.factor > 1.0 else Stability.UNSTABLE)
    if verdict.motion is not None:
        assert check_motion(problem, verdict.motion, Tolerances()).holds
        return
    forces = together.forces()
    assert forces is not None
    assert check_forces(problem, forces, Tolerances()).holds
    again = Assembly()
    again.add_all(bricks)
    assert again.with_loads(loads).verdict().stability is Stability.STABLE
    state = together.state()
    together.remove(["top2"])
    together.restore(state)
    assert together.forces() == forces
