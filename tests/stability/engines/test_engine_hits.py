"""A plank thrown at another, nothing else around: momentum goes where it should, and nothing passes through."""

from math import cos, pi, sin

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.geometry.vectors import add, norm
from stability.model import BodyId, BodyState, Brick, Pose, Vec3
from stackdsl.simulation.systems import MOVING

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS = 0.012
UPRIGHT = (0.0, -sin(pi / 4.0), 0.0, cos(pi / 4.0))
NEARLY = 0.003  # [m] between the two at first


def after_hit(shot: Pose, velocity_W: Vec3) -> dict[BodyId, BodyState]:
    """Return the states of a thrown plank and of a plank at rest in the origin after 40 ms, without gravity."""
    world = PyBulletWorld.opened(MOVING, 0.0, 0.5, heaviest=MASS)
    world.add_brick(Brick("target", Box(SIZE), MASS), Pose((0.0, 0.0, 0.0)))
    world.add_brick(Brick("shot", Box(SIZE), MASS), shot, velocity_W)
    for _ in range(round(0.04 / MOVING.time_step)):
        world.set_max_speed(norm(velocity_W))
        world.step()
    states = dict(world.states(["target", "shot"]))
    world.close()
    return states


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0, 4.0])
def test_after_a_hit_end_on_both_planks_fly_on_with_half_the_speed(speed: float) -> None:
    #   [shot]->  [target]    equal masses, no restitution
    states = after_hit(Pose((-LENGTH - NEARLY, 0.0, 0.0)), (speed, 0.0, 0.0))
    for state in states.values():
        assert state.velocity_W == pytest.approx((speed / 2.0, 0.0, 0.0), abs=0.01 * speed)


@pytest.mark.parametrize("speed", [1.0, 20.0])
@pytest.mark.parametrize(
    ("shot", "way"),
    [
        (Pose((-LENGTH - NEARLY, 0.008, 0.003)), (1.0, 0.0, 0.0)),
        (Pose((0.03, -WIDTH - NEARLY, 0.002)), (0.0, 1.0, 0.0)),
        (Pose((0.03, 0.005, -THICKNESS - NEARLY)), (0.0, 0.0, 1.0)),
    ],
    ids=["end", "side", "flat"],
)
def test_no_hit_makes_or_takes_momentum(shot: Pose, way: Vec3, speed: float) -> None:
    x, y, z = way
    states = after_hit(shot, (speed * x, speed * y, speed * z))
    total = add(states["target"].velocity_W, states["shot"].velocity_W)
    assert total == pytest.approx((speed * x, speed * y, speed * z), abs=0.001 * speed)
    assert norm(states["target"].velocity_W) > 0.3 * speed


@pytest.mark.parametrize("speed", [8.0, 16.0, 20.0])
@pytest.mark.parametrize(
    ("axis", "shot", "extent"),
    [
        (0, Pose((-LENGTH - NEARLY, 0.0, 0.0)), LENGTH),
        (2, Pose((0.0, 0.0, -THICKNESS - NEARLY)), THICKNESS),
        (2, Pose((0.0, 0.0, -(LENGTH + THICKNESS) / 2.0 - NEARLY), UPRIGHT), (LENGTH + THICKNESS) / 2.0),
    ],
    ids=["end-on-end", "flat-on-flat", "end-on-flat"],
)
def test_nothing_passes_through_a_plank(axis: int, shot: Pose, extent: float, speed: float) -> None:
    way = tuple(speed if number == axis else 0.0 for number in range(3))
    states = after_hit(shot, (way[0], way[1], way[2]))
    apart = states["target"].pose.position_W[axis] - states["shot"].pose.position_W[axis]
    assert apart > 0.9 * extent
    assert states["target"].velocity_W[axis] > 0.4 * speed


def finely_stepped(beside: float) -> float:
    """How long steps are fine [s] once a plank flies at one on the edge of a block, and misses it by so much [m]."""
    #   [hit]  <-[shot]     the block brakes the one, and nothing the other, which pushes while it falls past
    #   [block] stays
    world = PyBulletWorld.opened(MOVING, 9.81, 0.5, heaviest=MASS)
    high = 0.1
    world.add_brick(Brick("block", Box((LENGTH, 0.2, high)), MASS), Pose((0.0, -0.1, 0.5 * high)))
    world.freeze("block")
    height = high + 0.5 * THICKNESS
    world.add_brick(Brick("hit", Box(SIZE), MASS), Pose((0.0, -0.5 * WIDTH, height)))
    shot = Pose((beside, 0.5 * WIDTH + 0.005, height))
    world.add_brick(Brick("shot", Box(SIZE), MASS), shot, (0.0, -1.0, 0.0))
    world.substep_next_contact()
    fine = 0
    for _ in range(2 * MOVING.first_steps + 2):
        world.set_max_speed(1.0)
        world.step()
        fine += world.stepper.part <= MOVING.time_step / MOVING.first_parts
    world.close()
    return fine * MOVING.time_step


def test_sub_steps_continue_while_a_plank_pushes_the_brick_that_it_hit() -> None:
    first = MOVING.first_steps * MOVING.time_step
    assert finely_stepped(beside=2.0 * LENGTH) == pytest.approx(first)
    assert finely_stepped(beside=0.0) == pytest.approx(2.0 * first)
