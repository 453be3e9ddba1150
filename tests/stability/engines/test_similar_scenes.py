"""Scenes that are alike but for size and gravity are stepped alike (Froude), and are right alike."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import sqrt

import pytest

from stability.engines.protocol import EngineSettings
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Quaternion
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.simulation.worlds import settings_for
from tests.scenes import timeline_of

EARTH = 9.81  # [m/s2]
KAPLA = 0.1176  # [m] the length; width and thickness are a fifth and a fifteenth of it
FRICTION = 0.5
FLAT_ON: Quaternion = (0.0, sqrt(0.5), 0.0, sqrt(0.5))  # about y


def settings_of(system: str, length: float = KAPLA, gravity: float = EARTH) -> EngineSettings:
    """Of a scene with one plank of a length [m]."""
    scene = f"brick: {brick(length)}\nworld: {{gravity: {gravity} m/s2}}"
    return settings_for(timeline_of("- column: {levels: 1}", scene), SYSTEMS[system])


def brick(length: float) -> str:
    """As an author writes it."""
    return f"{{size: [{1e3 * length} mm, {1e3 * length / 5.0} mm, {1e3 * length / 15.0} mm], density: 557 kg/m3}}"


@contextmanager
def world(length: float, gravity: float) -> Iterator[PyBulletWorld]:
    settings = settings_of("tuned", length, gravity)
    assert isinstance(settings, PyBulletSettings)
    opened = PyBulletWorld.opened(settings, gravity, FRICTION, heaviest=0.012)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION))
        yield opened
    finally:
        opened.close()


def plank(name: str, length: float) -> Brick:
    return Brick(name, Box((length, length / 5.0, length / 15.0)), 0.012)


@pytest.mark.parametrize(
    ("length", "gravity", "steps", "travel"),
    [
        (KAPLA, EARTH, 1.0, 1.0),
        (0.12, 10.0, 1.0, 1.0),  # hardly another
        (KAPLA, 1.0, 2.0, 1.0),  # sqrt(9.8) = 3.1 times as slow
        (KAPLA, 100.0, 0.25, 1.0),
        (0.01, EARTH, 0.25, 1.0 / 16.0),  # sqrt(0.085) = 0.29
        (0.2, EARTH, 1.0, 2.0),
        (4.0 * KAPLA, 4.0 * EARTH, 1.0, 4.0),
    ],
)
@pytest.mark.parametrize("system", ["exact", "tuned"])
def test_steps_go_with_the_time_that_a_brick_takes_to_topple(
    system: str, length: float, gravity: float, steps: float, travel: float
) -> None:
    usual, own = SYSTEMS[system].engine, settings_of(system, length, gravity)
    assert usual.most_travel is not None
    assert (own.time_step, own.most_travel) == (steps * usual.time_step, travel * usual.most_travel)


@pytest.mark.parametrize("system", ["stock", "thesis"])
def test_engine_settings_of_stock_and_thesis_are_not_scaled(system: str) -> None:
    assert settings_of(system, 0.01, 100.0) == SYSTEMS[system].engine


@pytest.mark.parametrize(
    ("length", "gravity"),
    [
        pytest.param(KAPLA, 1.0, marks=pytest.mark.slow),
        pytest.param(KAPLA, EARTH, marks=pytest.mark.slow),
        (KAPLA, 100.0),
        (0.01, EARTH),
    ],
)
def test_a_tower_creeps_by_as_little_of_its_planks_in_any_gravity_and_size(length: float, gravity: float) -> None:
    # Every brick is taken to fall until the next look. That is no motion: where it was taken for one, in strong gravity
    # and of small planks, nothing was ever held as at rest.
    scene = f"brick: {brick(length)}\nworld: {{gravity: {gravity} m/s2}}\nexpect: [{{stands: {{for: 1 s}}}}]"
    trace = play(timeline_of("- four_stack: {levels: 10}", scene), SYSTEMS["tuned"])
    assert trace.drift < 0.025 * length / 15.0


def test_a_small_plank_that_hits_another_squarely_does_not_pass_through_it() -> None:
    #   ----a----  ->  |b|    0.67 mm thick, at 16 m/s
    length, speed = 0.01, 16.0
    with world(length, EARTH) as engine:
        engine.add_brick(plank("a", length), Pose((-8.0 / 15.0 * length - 0.0009, 0.0, 5.0)), (speed, 0.0, 0.0))
        engine.add_brick(plank("b", length), Pose((0.0, 0.0, 5.0), FLAT_ON))
        engine.set_max_speed(speed)
        for _ in range(3):
            engine.step()
        after = [state.velocity_W[0] for state in engine.states(["a", "b"]).values()]
    assert after == pytest.approx([speed / 2.0] * 2, rel=0.01)
