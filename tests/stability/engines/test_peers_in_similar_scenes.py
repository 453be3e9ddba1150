"""Other engines are scaled to a scene as `tuned` is, and are then right alike whatever the size and gravity."""

from math import sqrt

import pytest

from stability.engines.lazy_world import stepped_world
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stackdsl.simulation.known_systems import missing, system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.worlds import settings_for
from tests.engines_at_hand import WITH_RIGID
from tests.scenes import timeline_of

EARTH, KAPLA = 9.81, 0.1176  # [m/s2], [m] the length; width and thickness are a fifth and a fifteenth of it
FRICTION, DENSITY = 0.5, 557.0  # [kg/m3]
SCENES = pytest.mark.parametrize(
    ("length", "gravity"),
    [
        (KAPLA, EARTH),
        (0.01, EARTH),
        pytest.param(KAPLA, 100.0, marks=pytest.mark.slow),
        pytest.param(0.01, 100.0, marks=pytest.mark.slow),
    ],
    ids=str,
)


@pytest.fixture(params=["mujoco-stiff", *WITH_RIGID])
def peer(request: pytest.FixtureRequest) -> str:
    for _, package in missing([request.param]):
        pytest.skip(f"{package.name} is not installed")
    return str(request.param)


def longer(length: float, gravity: float) -> float:
    """How many times longer all takes than with KAPLA planks on earth (Froude)."""
    return sqrt(length / KAPLA * EARTH / gravity)


def header(length: float, gravity: float) -> str:
    a, b, c = (1000.0 * length / share for share in (1.0, 5.0, 15.0))
    brick = f"brick: {{size: [{a} mm, {b} mm, {c} mm], density: {DENSITY:g} kg/m3}}"
    return f"{brick}\nworld: {{gravity: {gravity} m/s2}}\n"


@SCENES
def test_a_thrown_plank_slides_v_squared_by_two_mu_g(peer: str, length: float, gravity: float) -> None:
    settings = settings_for(timeline_of("- column: {levels: 1}", header(length, gravity)), system_named(peer))
    size: Vec3 = (length, length / 5.0, length / 15.0)
    mass = DENSITY * size[0] * size[1] * size[2]
    speed = sqrt(length / KAPLA * gravity / EARTH)  # so that it slides as many lengths
    world = stepped_world(settings, gravity, FRICTION, mass)
    try:
        world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION))
        world.add_brick(Brick("plank", Box(size), mass), Pose((0.0, 0.0, size[2] / 2.0)), (speed, 0.0, 0.0))
        world.set_max_speed(speed)
        for _ in range(round(1.2 * speed / (FRICTION * gravity) / settings.time_step)):
            world.step()
        slid = world.states(["plank"])["plank"].pose.position_W[0]
    finally:
        world.close()
    assert slid == pytest.approx(speed**2 / (2.0 * FRICTION * gravity), rel=0.03)


@SCENES
def test_a_tower_creeps_by_as_little_of_its_planks(peer: str, length: float, gravity: float) -> None:
    # Without the scaling, 1 cm planks creep seven to twelve times as far; in 100 m/s2 they fall on `mujoco`.
    # Of the thickness; the truth is nothing.
    # On `rigid` awake planks tremble, by up to 1 mm/s: two sweeps do not settle which contacts carry.
    most = {"mujoco": 0.05, "mujoco-stiff": 0.002, "rigid": 0.01}.get(peer, 0.0005)
    watched = f"expect: [{{stands: {{for: {longer(length, gravity)} s}}}}]"
    trace = play(timeline_of("- four_stack: {levels: 10}", header(length, gravity) + watched), system_named(peer))
    assert trace.collapse is None
    assert trace.drift < most * length / 15.0


@SCENES
def test_a_stepped_column_falls_with_the_first_plank_beyond_l_by_d(peer: str, length: float, gravity: float) -> None:
    #   L / d = 117.6 / 18 = 6.5: six stand, the seventh is too many.
    every, step = longer(length, gravity), 1000.0 * length * 18.0 / 117.6
    build = f"- column: {{levels: 8, step: {step} mm}}\n  every: {every} s"
    trace = play(timeline_of(build, header(length, gravity)), system_named(peer))
    assert trace.collapse is not None
    assert trace.collapse.level == 7
