"""Round bodies that roll, slide, tip and collide on the rigid-body engine, against closed forms."""

from collections.abc import Mapping
from dataclasses import replace
from math import atan2, cos, dist, hypot, pi, sin, sqrt, tan
from random import Random

import numpy as np
import pytest

from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.geometry.placed_shape import apart, apart_from_plane
from stability.geometry.round_solid import RoundSolid, capsule, cylinder, frustum, pipe, sphere
from stability.geometry.vectors import about, body_axes, cross, dot, multiply, norm, rotate, scale, unit
from stability.model import AT_REST, GROUND, IDENTITY, BodyState, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.systems import RIGID

GRAVITY, RADIUS = 9.81, 0.05
LYING: Quaternion = about((1.0, 0.0, 0.0), 0.5 * pi)  # its axis along y
LOG, BALL, PIPE = cylinder(RADIUS, 0.4), sphere(RADIUS), pipe(RADIUS, 0.01, 0.4)
CAPSULE = capsule(RADIUS, 0.3)
BODIES = {"log": LOG, "ball": BALL, "pipe": PIPE, "capsule": CAPSULE}
# Of the gravity along a slope: 1 / (1 + I / (m r^2)), with I of a solid and a hollow cylinder, and of a ball.
SHARES = {"log": 2.0 / 3.0, "ball": 5.0 / 7.0, "pipe": 1.0 / (1.0 + 0.5 * (1.0 + 0.8**2))}


def opened(friction: float, normal: Vec3 = (0.0, 0.0, 1.0), height: float = 0.0) -> RigidWorld:
    world = RigidWorld.opened(RIGID, GRAVITY, friction)
    world.add_plane(Plane(GROUND, (0.0, 0.0, height), normal, friction))
    return world


def add(world: RigidWorld, name: str, shape: ConvexShape, at: Vec3, turn: Quaternion = IDENTITY) -> None:
    world.add_brick(Brick(name, shape, 1.0), Pose(at, turn))


def set_off(world: RigidWorld, name: str, velocity_W: Vec3, spin_W: Vec3) -> None:
    world.set_state(name, replace(state_of(world, name), velocity_W=velocity_W, angular_velocity_W=spin_W))


def state_of(world: RigidWorld, name: str) -> BodyState:
    return world.states([name])[name]


def played(world: RigidWorld, steps: int) -> RigidWorld:
    for _ in range(steps):
        world.step()
    return world


def energy(world: RigidWorld) -> float:
    """Return the energy of motion and height of all bricks [J]."""
    total = 0.0
    for name, state in world.states([*world.own.bricks]).items():
        brick, turn = world.own.bricks[name], state.pose.orientation
        spin = [dot(axis, state.angular_velocity_W) for axis in body_axes(turn)]
        turning = sum(m * w * w for m, w in zip(brick.shape.moments(brick.mass), spin, strict=True))
        moving = brick.mass * norm(state.velocity_W) ** 2
        total += 0.5 * (moving + turning) + brick.mass * GRAVITY * state.pose.position_W[2]
    return total


def way_down(shape: RoundSolid, friction: float, slope: float, on_box: bool) -> float:
    """Return the acceleration of a body that lies on a slope, from its way in 0.3 s [m/s2]."""
    normal = (sin(slope), 0.0, cos(slope))
    world = opened(friction, height=-9.0) if on_box else opened(friction, normal)
    if on_box:
        add(world, "base", Box((4.0, 1.0, 0.2)), scale(-0.1, normal), about((0.0, 1.0, 0.0), slope))
        world.freeze("base")
    add(world, "it", shape, scale(RADIUS, normal), LYING)
    at = state_of(played(world, 300), "it").pose.position_W
    assert dot(at, normal) == pytest.approx(RADIUS, abs=1e-9)
    return 2.0 * dot(at, (cos(slope), 0.0, -sin(slope))) / 0.3**2


@pytest.mark.parametrize("on_box", [False, True])
@pytest.mark.parametrize("slope", [0.1, 0.5])
@pytest.mark.parametrize("name", SHARES)
def test_a_body_rolls_down_a_slope_by_its_inertia(name: str, slope: float, on_box: bool) -> None:
    expected = SHARES[name] * GRAVITY * sin(slope)
    assert way_down(BODIES[name], 0.9, slope, on_box) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_log_slides_where_the_slope_exceeds_three_times_its_friction(share: float) -> None:
    friction, slope = 0.2, atan2(0.6 * share, 1.0)
    rolls, slides = 2.0 / 3.0 * sin(slope), sin(slope) - friction * cos(slope)
    expected = GRAVITY * (slides if share > 1.0 else rolls)
    # Sweeps end when they change closing speeds by 3e-4 of the speed of the fastest body.
    assert way_down(LOG, friction, slope, on_box=False) == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize(("name", "share"), [("ball", 5.0 / 7.0), ("log", 2.0 / 3.0)])
def test_a_body_that_slides_without_spin_rolls_in_the_end(name: str, share: float) -> None:
    world = opened(0.3)
    add(world, "it", BODIES[name], (0.0, 0.0, RADIUS), LYING)
    set_off(world, "it", (1.0, 0.0, 0.0), AT_REST)
    state = state_of(played(world, 400), "it")
    assert state.velocity_W[0] == pytest.approx(share, rel=1e-6)
    assert state.angular_velocity_W[1] == pytest.approx(share / RADIUS, rel=1e-6)


@pytest.mark.parametrize("name", BODIES)
def test_a_body_that_rolls_keeps_its_energy(name: str) -> None:
    world = opened(0.5)
    add(world, "it", BODIES[name], (0.0, 0.0, RADIUS), LYING)
    set_off(world, "it", (1.0, 0.0, 0.0), (0.0, 1.0 / RADIUS, 0.0))
    before = energy(world)
    assert energy(played(world, 500)) == pytest.approx(before, abs=2e-5)
    assert state_of(world, "it").pose.position_W[0] == pytest.approx(0.5, abs=1e-5)


def test_a_cone_rolls_around_its_apex() -> None:
    """It turns about its contact line with w, and this line turns with w times the tangent of its half angle."""
    cone, half = frustum(0.05, 0.0, 0.1), atan2(0.05, 0.1)
    turn = about((0.0, 1.0, 0.0), -(0.5 * pi + half))
    at = scale(-(0.05 - cone.centre_of_mass[2]), rotate(turn, (0.0, 0.0, 1.0)))
    world = opened(2.0)
    add(world, "cone", cone, at, turn)
    spin = (5.0, 0.0, 0.0)
    set_off(world, "cone", cross(spin, at), spin)
    x, y, _ = state_of(played(world, 400), "cone").pose.position_W
    assert atan2(y, x) == pytest.approx(-5.0 * tan(half) * 0.4, rel=1e-3)
    assert hypot(x, y) == pytest.approx(at[0], rel=1e-3)


def pendulum_time(length: float, moment: float, start: float, end: float) -> float:
    """Return the time in which a body of 1 kg falls from one angle over its pivot to another, from rest [s]."""
    roots, weights = np.polynomial.legendre.leggauss(60)
    # With the angle as start + u^2 the integrand has no pole.
    most = sqrt(end - start)
    u = 0.5 * most * (roots + 1.0)
    speeds = np.sqrt(2.0 * GRAVITY * length / moment * (cos(start) - np.cos(start + u * u)))
    return float(0.5 * most * weights @ (2.0 * u / speeds))


def test_a_can_falls_over_its_rim_as_a_pendulum() -> None:
    """It stands flat on a slope of 1 % of a radian more than its limit, where its centre is above the rim."""
    radius, height = 0.03, 0.1
    can, length = cylinder(radius, height), hypot(radius, 0.5 * height)
    beyond, end = 0.01, 1.0
    slope = atan2(radius, 0.5 * height) + beyond
    world = opened(2.0, (sin(slope), 0.0, cos(slope)))
    turn = multiply(about((0.0, 1.0, 0.0), slope), about((0.0, 0.0, 1.0), 0.1))
    add(world, "can", can, (0.5 * height * sin(slope), 0.0, 0.5 * height * cos(slope)), turn)
    pivot, steps = (radius * cos(slope), 0.0, -radius * sin(slope)), 0
    while True:
        x, _, z = state_of(played(world, 1), "can").pose.position_W
        steps += 1
        if atan2(x - pivot[0], z - pivot[2]) > end or steps > 1000:
            break
    expected = pendulum_time(length, can.moments(1.0)[0] + length**2, beyond, end)
    assert 0.001 * steps == pytest.approx(expected, rel=0.01)


def test_a_can_stands_on_a_slope_just_below_its_limit() -> None:
    slope = atan2(0.03, 0.05) - 0.01
    world = opened(2.0, (sin(slope), 0.0, cos(slope)))
    at = (0.05 * sin(slope), 0.0, 0.05 * cos(slope))
    add(world, "can", cylinder(0.03, 0.1), at, about((0.0, 1.0, 0.0), slope))
    state = state_of(played(world, 300), "can")
    assert norm(state.velocity_W) < 1e-4
    assert dist(state.pose.position_W, at) < 1e-6


def test_a_ball_that_drops_on_a_slope_keeps_five_sevenths_of_its_speed_along_it() -> None:
    slope, height = 0.3, 0.2
    normal = (sin(slope), 0.0, cos(slope))
    world = opened(2.0, normal)
    start = height + RADIUS / cos(slope)
    add(world, "ball", BALL, (0.0, 0.0, start))
    steps = 0
    while dot(state_of(played(world, 1), "ball").velocity_W, normal) < -1e-3:
        steps += 1
    speed = dot(state_of(world, "ball").velocity_W, (cos(slope), 0.0, -sin(slope)))
    assert speed == pytest.approx(5.0 / 7.0 * sqrt(2.0 * GRAVITY * height) * sin(slope), rel=0.02)


def resting() -> Mapping[str, list[tuple[ConvexShape, Vec3, Quaternion]]]:
    """Return structures in balance."""
    can, lower = cylinder(0.03, 0.1), 0.1 * sqrt(0.5)
    block, across = Box((0.1, 0.4, 0.1)), about((0.0, 1.0, 0.0), 0.5 * pi)
    sides = [(block, (0.05 + 0.2 * side, 0.1, 0.05), IDENTITY) for side in (-0.5, 1.0)]
    ends = [(Box((0.2, 0.1, 0.1)), (0.1, 0.1 + 0.15 * side, 0.05), IDENTITY) for side in (-1, 1)]
    balls = [(BALL, (0.05 + 0.1 * x, 0.05 + 0.1 * y, 0.05), IDENTITY) for x in (0, 1) for y in (0, 1)]
    logs = [(LOG, (0.05 + 0.1 * x, 0.0, 0.05), LYING) for x in (0, 1)]
    return {
        "can on can": [(can, (0.0, 0.0, 0.05), IDENTITY), (can, (0.02, 0.005, 0.15), IDENTITY)],
        "box on can": [(can, (0.0, 0.0, 0.05), IDENTITY), (Box((0.2, 0.2, 0.04)), (0.01, 0.0, 0.12), IDENTITY)],
        "can over an edge": [(Box((0.1, 0.1, 0.1)), (0.0, 0.0, 0.05), IDENTITY), (can, (0.045, 0.0, 0.15), IDENTITY)],
        "crossed logs": [(LOG, (0.0, 0.0, 0.05), LYING), (LOG, (0.0, 0.0, 0.15), across)],
        "log on two": [*logs, (LOG, (0.1, 0.0, 0.05 + 0.05 * sqrt(3.0)), LYING), *sides],
        "four balls under one": [*balls, (BALL, (0.1, 0.1, 0.05 + lower), IDENTITY), *ends, *sides],
    }


@pytest.mark.parametrize("name", resting())
def test_a_structure_in_balance_stays_where_it_is(name: str) -> None:
    world, starts = opened(0.6), {}
    for number, (shape, at, turn) in enumerate(resting()[name]):
        add(world, f"{number}", shape, at, turn)
        starts[f"{number}"] = at
        if isinstance(shape, Box) and shape.size[2] == 0.1:  # the blocks
            world.freeze(f"{number}")
    played(world, 200)
    assert max(dist(state_of(world, each).pose.position_W, at) for each, at in starts.items()) < 2e-6


KINDS: tuple[ConvexShape, ...] = (
    cylinder(0.03, 0.1),
    cylinder(0.04, 0.008),
    frustum(0.05, 0.02, 0.06),
    frustum(0.05, 0.0, 0.08),
    pipe(0.03, 0.005, 0.1),
    sphere(0.04),
    capsule(0.025, 0.06),
    Box((0.06, 0.08, 0.1)),
)


def random_turn(random: Random) -> Quaternion:
    x, y, z = (random.gauss(0.0, 1.0) for _ in range(3))
    return about(unit((x, y, z)), random.uniform(0.0, pi))


@pytest.mark.parametrize("seed", [5, pytest.param(6, marks=pytest.mark.slow), pytest.param(7, marks=pytest.mark.slow)])
def test_bodies_that_fall_into_a_shaft_neither_gain_energy_nor_enter_each_other(seed: int) -> None:
    random, world, height = Random(seed), opened(0.4), 0.1
    for number, (x, y) in enumerate(((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))):
        world.add_plane(Plane(f"wall{number}", (-0.1 * x, -0.1 * y, 0.0), (x, y, 0.0), 0.4))
    for number in range(6):
        shape = random.choice(KINDS)
        height += 1.05 * shape.bounding_radius
        add(world, f"{number}", shape, (random.uniform(-0.02, 0.02), 0.0, height), random_turn(random))
        height += 1.05 * shape.bounding_radius
    now, gained, deepest = energy(world), 0.0, 0.0
    for step in range(800):
        world.step()
        before, now = now, energy(world)
        gained += max(0.0, now - before)
        if step % 20 == 0:
            deepest = min(deepest, least_gap(world))
    assert gained < 1e-3
    assert deepest > -2e-3


def least_gap(world: RigidWorld) -> float:
    """Return the least gap between any two bodies, by the exact distances of statics [m]."""
    placed = [(world.own.bricks[name].shape, state.pose) for name, state in world.states([*world.own.bricks]).items()]
    gaps = [apart_from_plane(*each, plane).gap for each in placed for plane in world.own.planes.values()]
    for number, (shape, pose) in enumerate(placed):
        for other, there in placed[:number]:
            if dist(pose.position_W, there.position_W) < shape.bounding_radius + other.bounding_radius:
                gaps.append(apart(shape, pose, other, there).gap)
    return min(gaps)
