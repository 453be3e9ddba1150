"""Sliding bricks in the engine of `exact` yield sideways: Coulomb friction opposes only the sliding."""

from math import hypot

import pytest

pytest.importorskip("pybullet")

from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stackdsl.simulation.systems import MOVING

GRAVITY, FRICTION, SPEED, SECONDS = 9.81, 0.5, 1.0, 0.05
BELOW, ABOVE = Box((0.4, 0.4, 0.004)), Box((0.1, 0.1, 0.004))  # thin, so that friction tips nothing
MASS = 0.1  # of either [kg]


def unit(x: float, y: float) -> tuple[float, float]:
    return x / hypot(x, y), y / hypot(x, y)


def dragged_aside() -> tuple[float, float]:
    """Where Newton and Coulomb take the lower plate, with both as points: steps of a microsecond, to 1e-5."""
    (u, v), (over_u, over_v), (x, y), step = (SPEED, 0.0), (SPEED, SPEED), (0.0, 0.0), 1e-6
    for _ in range(round(SECONDS / step)):
        along, across = unit(u, v)
        drag_u, drag_v = unit(over_u - u, over_v - v)
        rate = FRICTION * GRAVITY * step  # it carries two plates, and the other one itself
        u, v = u + rate * (drag_u - 2.0 * along), v + rate * (drag_v - 2.0 * across)
        over_u, over_v = over_u - rate * drag_u, over_v - rate * drag_v
        x, y = x + u * step, y + v * step
    return x, y


def test_a_sliding_plate_is_dragged_aside_by_a_plate_sliding_across_it() -> None:
    #   below at 1 m/s along x, above at 1 m/s along x and y: friction between them is along y
    engine = PyBulletWorld.opened(MOVING, GRAVITY, FRICTION, MASS)
    try:
        engine.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION))
        starts: dict[str, tuple[Box, float, Vec3]] = {
            "below": (BELOW, 0.002, (SPEED, 0.0, 0.0)),
            "above": (ABOVE, 0.006, (SPEED, SPEED, 0.0)),
        }
        for name, (shape, height, velocity_W) in starts.items():
            engine.add_brick(Brick(name, shape, MASS), Pose((0.0, 0.0, height)), velocity_W)
        engine.set_max_speed(2.0 * SPEED)
        for _ in range(round(SECONDS / MOVING.time_step)):
            engine.step()
        x, y, _ = engine.states(["below"])["below"].pose.position_W
    finally:
        engine.close()
    assert (x, y) == pytest.approx(dragged_aside(), rel=0.03)
