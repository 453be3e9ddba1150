"""Round bodies on PyBullet and MuJoCo, against closed forms; each engine with its own tolerance."""

from contextlib import closing
from math import atan, atan2, radians, tan

import pytest

from benchmarks.round_bodies import (
    CAN,
    LOGS,
    LYING,
    PYRAMID,
    ROLLING,
    WEDGE,
    Pile,
    engine_of,
    falls,
    played,
    rolling_error,
    shift,
    slides_off,
    world_on,
)
from stability.engines.lazy_world import stepped_world
from stability.geometry.round_solid import RoundSolid, capsule, cylinder, frustum, pipe
from stability.geometry.vectors import about, add_scaled, dot, multiply, norm, rotate, scale
from stability.model import AT_REST, BodyState, Brick, Pose, Vec3
from stackdsl.simulation.known_systems import missing

# By engine: the largest relative error of ways of rolling and sliding bodies, the error of the slope on which a can
# tips [deg], the relative error of the slope on which it slides, and the creep of piles [m]. These are measured errors
# of the engines, rounded up. PyBullet keeps at most four points of a rim, which are the corners of a polygon inside it,
# so a can tips too early, and a log is driven by points beside its line. Its default settings also damp all motion, and
# let small bodies sink in.
TOLERANCES = {
    "stock": (0.08, 6.0, 0.03, 2e-3),
    "thesis": (0.03, 4.0, 0.35, 5e-4),
    "tuned": (0.02, 1.0, 0.01, 1e-3),
    "pybullet-exact": (0.015, 2.0, 0.01, 2e-4),
    "mujoco": (0.003, 0.2, 0.01, 1e-5),
}
ENGINES = list(TOLERANCES)
FINE = ["tuned", "pybullet-exact", "mujoco"]


@pytest.fixture(autouse=True)
def _installed(engine: str) -> None:
    for _, package in missing([engine]):
        pytest.skip(f"{package.name} is not installed")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("body", ROLLING)
def test_a_body_rolls_down_a_slope_by_its_inertia(engine: str, body: str) -> None:
    assert rolling_error(engine_of(engine), ROLLING[body]) == pytest.approx(0.0, abs=TOLERANCES[engine][0])


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_slides_where_its_friction_is_less_than_two_sevenths_of_the_slope(engine: str) -> None:
    error = rolling_error(engine_of(engine), ROLLING["ball"], radians(30.0), friction=tan(radians(30.0)) / 7.0)
    assert error == pytest.approx(0.0, abs=TOLERANCES[engine][0])


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("shape", [CAN, pipe(0.033, 0.003, 0.115), cylinder(0.033, 0.115, (0.0, 0.0, -0.02))])
def test_a_can_tips_where_its_centre_is_beyond_its_rim(engine: str, shape: RoundSolid) -> None:
    limit, near = atan2(shape.widest, shape.reach((0.0, 0.0, -1.0))), radians(TOLERANCES[engine][1])
    assert not falls(engine_of(engine), limit - near, shape)
    assert falls(engine_of(engine), limit + 0.01, shape)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_cone_stands_on_its_wide_end_until_its_centre_is_beyond_its_rim(engine: str) -> None:
    cone = frustum(0.033, 0.02, 0.115)
    limit, near = atan2(0.033, cone.reach((0.0, 0.0, -1.0))), radians(TOLERANCES[engine][1] + 1.0)
    assert not falls(engine_of(engine), limit - near, cone)
    assert falls(engine_of(engine), limit + 0.01, cone)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_can_slides_where_a_slope_is_steeper_than_its_friction(engine: str) -> None:
    limit, near = atan(0.3), TOLERANCES[engine][2]
    assert not slides_off(engine_of(engine), (1.0 - near) * limit, 0.3)
    assert slides_off(engine_of(engine), (1.0 + near) * limit, 0.3)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("pile", [PYRAMID, LOGS, WEDGE], ids=["cans", "logs", "wedge"])
def test_a_pile_in_balance_stays(engine: str, pile: Pile) -> None:
    assert shift(engine_of(engine), pile) < TOLERANCES[engine][3]


# Spinning about an axis across that of symmetry, and about this one, tells the inertia of the engine: a free body
# precesses about its angular momentum with L / I, where I is the moment across its axis.


@pytest.mark.parametrize("engine", FINE)
@pytest.mark.parametrize(
    "shape",
    [CAN, pipe(0.05, 0.01, 0.03), frustum(0.05, 0.02, 0.06), capsule(0.02, 0.1)],
    ids=["can", "pipe", "cone", "capsule"],
)
def test_a_free_body_precesses_by_its_moments_of_inertia(engine: str, shape: RoundSolid) -> None:
    across, _, along = shape.moments(1.0)
    spin: Vec3 = (1.0, 0.0, 4.0)
    momentum = (across * spin[0], 0.0, along * spin[2])
    pose = Pose((0.0, 0.0, 1.0))
    with closing(stepped_world(engine_of(engine), 0.0, 0.5, 1.0)) as world:
        world.add_brick(Brick("body", shape, 1.0), pose)
        world.set_state("body", BodyState(pose, AT_REST, spin))
        axis = rotate(played(world, "body", 0.25).pose.orientation, (0.0, 0.0, 1.0))
        size = dot(momentum, momentum) ** 0.5
        turn = about(scale(1.0 / size, momentum), size / across * world.time())
    assert axis == pytest.approx(rotate(turn, (0.0, 0.0, 1.0)), abs=0.01)


# A body that is pushed to 1 m/s without spin rolls in the end at 1 / (1 + I / (m r^2)), in every direction.


@pytest.mark.parametrize("engine", FINE)
@pytest.mark.parametrize("body", ROLLING)
@pytest.mark.parametrize("bearing", [0.0, 1.0, 2.5])
def test_a_body_that_slides_without_spin_rolls_in_the_end(engine: str, body: str, bearing: float) -> None:
    shape, turn = ROLLING[body], about((0.0, 0.0, 1.0), bearing)
    ahead = rotate(turn, (1.0, 0.0, 0.0))
    with closing(world_on(engine_of(engine), 0.0, 0.3)) as world:
        pose = Pose((0.0, 0.0, shape.widest), multiply(turn, LYING))
        world.add_brick(Brick("body", shape, 1.0), pose)
        world.set_state("body", BodyState(pose, ahead, AT_REST))
        velocity = played(world, "body", 0.4).velocity_W
    share = 1.0 / (1.0 + shape.moments(1.0)[2] / shape.widest**2)
    assert dot(velocity, ahead) == pytest.approx(share, rel=TOLERANCES[engine][0])
    assert norm(add_scaled(velocity, -dot(velocity, ahead), ahead)) < 0.02
