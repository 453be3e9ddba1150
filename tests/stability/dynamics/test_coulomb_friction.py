"""Coulomb friction on a brick that slides under applied forces at one point or several."""

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.dynamics.rigid_body import AppliedForce, friction_impulses, pushed
from stability.geometry.vectors import add, norm
from stability.model import BodyState, Pose, Vec3
from tests.planks import LENGTH, MASS, THICKNESS, WIDTH, plank

STEP = 1e-3  # [s]
FRICTION = 0.5
BRICK = plank("a")
TOP = 0.5 * THICKNESS


def moving(velocity_W: Vec3, spin_W: Vec3 = (0.0, 0.0, 0.0)) -> BodyState:
    return BodyState(Pose((0.0, 0.0, 0.0)), velocity_W, spin_W)


def corners(force: float, height: float = 0.0) -> list[AppliedForce]:
    """A load spread evenly over the corners of a plank."""
    places = [(x, y, height) for x in (-0.5 * LENGTH, 0.5 * LENGTH) for y in (-0.5 * WIDTH, 0.5 * WIDTH)]
    return [AppliedForce((0.0, 0.0, -0.25 * force), place, FRICTION) for place in places]


def after(state: BodyState, pressed: list[AppliedForce]) -> BodyState:
    for each, impulse in zip(pressed, friction_impulses(BRICK, state, pressed, STEP), strict=True):
        state = pushed(state, BRICK, impulse, each.at_W)
    return state


def test_friction_slows_a_fast_slide_by_coefficient_times_load() -> None:
    impulses = friction_impulses(BRICK, moving((2.0, 0.0, 0.0)), corners(3.0), STEP)
    assert [sum(parts) for parts in zip(*impulses, strict=True)] == pytest.approx(
        [-FRICTION * 3.0 * STEP, 0.0, 0.0], abs=1e-8
    )


def test_friction_stops_a_slow_slide_without_reversing_it() -> None:
    slow = 0.5 * FRICTION * 3.0 * STEP / MASS
    assert norm(after(moving((0.0, slow, 0.0)), corners(3.0)).velocity_W) < 0.01 * slow


def test_no_friction_acts_on_a_brick_at_rest() -> None:
    assert friction_impulses(BRICK, moving((0.0, 0.0, 0.0)), corners(3.0), STEP) == [(0.0, 0.0, 0.0)] * 4


def test_no_friction_acts_on_a_vertical_motion() -> None:
    assert friction_impulses(BRICK, moving((0.0, 0.0, 1.0)), corners(3.0), STEP) == [(0.0, 0.0, 0.0)] * 4


def test_friction_slows_a_spin_about_the_vertical_by_its_moment_arms() -> None:
    fast = 100.0
    spin = after(moving((0.0, 0.0, 0.0), (0.0, 0.0, fast)), corners(3.0)).angular_velocity_W[2]
    moment = FRICTION * 3.0 * hypot(0.5 * LENGTH, 0.5 * WIDTH)
    inertia = MASS / 12.0 * (LENGTH**2 + WIDTH**2)
    assert fast - spin == pytest.approx(moment * STEP / inertia, rel=1e-6)


speeds = st.floats(-3.0, 3.0)


@given(speeds, speeds, st.floats(-30.0, 30.0), st.floats(0.01, 20.0))
def test_friction_takes_energy_and_never_exceeds_its_cone(vx: float, vy: float, spin: float, force: float) -> None:
    state, pressed = moving((vx, vy, 0.0), (0.0, 0.0, spin)), corners(force, TOP)
    impulses = friction_impulses(BRICK, state, pressed, STEP)
    work = 0.0
    for each, impulse in zip(pressed, impulses, strict=True):
        assert norm(impulse) <= FRICTION * norm(each.force_W) * STEP * (1.0 + 1e-9)
        x, y, _ = each.at_W
        work += impulse[0] * (vx - spin * y) + impulse[1] * (vy + spin * x)
    assert work <= 1e-12
    assert add(impulses[0], impulses[1])[2] == pytest.approx(0.0, abs=1e-15)
