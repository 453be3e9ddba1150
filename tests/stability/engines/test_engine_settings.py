"""Settings of the engines: own settings of each, and common methods for code that does not depend on the engine."""

from dataclasses import fields
from itertools import combinations
from math import sqrt
from pkgutil import resolve_name

import pytest

from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.protocol import EngineSettings
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.scene_scale import USUAL_DIAGONAL, USUAL_GRAVITY, SceneScale
from stability.geometry.box import Box
from stability.model import Brick, Vec3
from stackdsl.simulation.known_systems import KNOWN
from stackdsl.simulation.systems import HELD, MOVING, MUJOCO, MUJOCO_STIFF, STOCK, TUNED

ENGINES = (PyBulletSettings, MuJoCoSettings)
ITERATES = {"iterations"}  # which is no field of all: an engine may have no solver that iterates
SCALED = (TUNED, MOVING, MUJOCO, MUJOCO_STIFF)
KAPLA: Vec3 = (0.1176, 0.0234, 0.0078)  # [m]


def scale_of(factor: float = 1.0, gravity: float = USUAL_GRAVITY) -> SceneScale:
    a, b, c = KAPLA
    return SceneScale.of([Brick("plank", Box((factor * a, factor * b, factor * c)), 0.012)], gravity)


def own_fields(kind: type[EngineSettings]) -> set[str]:
    return {field.name for field in fields(kind)} - {field.name for field in fields(EngineSettings)}


@pytest.mark.parametrize(("one", "other"), [*combinations(ENGINES, 2)])
def test_no_engine_carries_the_fields_of_another(one: type[EngineSettings], other: type[EngineSettings]) -> None:
    assert own_fields(one) & own_fields(other) == ITERATES


@pytest.mark.parametrize("system", KNOWN)
def test_settings_name_the_class_of_their_worlds(system: str) -> None:
    settings = KNOWN[system].engine
    if not settings.package.installed:
        pytest.skip(f"{settings.package.name} is not installed")
    assert callable(resolve_name(settings.world).opened)


def test_settings_have_a_text_summary() -> None:
    assert STOCK.summary() == (
        "step 1/240 s, 50 iterations, contact ERP 0.2, breaking threshold 0.02 of half a diagonal, scale 1, "
        "friction anchor off, damping 0.04 linear and 0.04 angular"
    )
    assert MUJOCO.summary() == (
        "step 1/1000 s, 100 iterations, contact time 4 ms, impedance 0.95 0.99 0.0005, friction impedance 10, "
        "tolerance 1e-08"
    )


@pytest.mark.parametrize("settings", SCALED)
def test_the_usual_scene_is_stepped_with_the_settings_as_they_are(settings: EngineSettings) -> None:
    assert settings.scaled(scale_of()) == settings


@pytest.mark.parametrize("settings", SCALED)
@pytest.mark.parametrize(("factor", "gravity", "slower"), [(1 / 12, 9.81, 0.25), (1.0, 100.0, 0.25), (4.0, 9.81, 2.0)])
def test_every_engine_is_stepped_by_the_time_that_a_brick_takes_to_topple(
    settings: EngineSettings, factor: float, gravity: float, slower: float
) -> None:
    #   sqrt(length / gravity), in powers of two; the step is at most a quarter of a doubling longer than that
    own = settings.scaled(scale_of(factor, gravity))
    assert own.time_step == slower * settings.time_step
    exactly = sqrt(factor * USUAL_GRAVITY / gravity)
    assert exactly / 2.0 < slower <= 2.0**0.25 * exactly


@pytest.mark.parametrize("settings", [HELD, STOCK])
def test_settings_of_stock_and_published_engines_are_not_scaled(settings: EngineSettings) -> None:
    assert settings.scaled(scale_of(1 / 12)) is settings


@pytest.mark.parametrize("settings", [MUJOCO, MUJOCO_STIFF])
def test_springs_of_mujoco_take_as_many_steps_and_give_way_by_as_much_of_a_brick(settings: MuJoCoSettings) -> None:
    #   1/16 of the lengths, so 1/4 of the times: what a spring sinks by under a weight goes with g t^2
    own = settings.scaled(scale_of(1 / 16))
    assert own.contact_time / own.time_step == settings.contact_time / settings.time_step
    assert own.impedance_range[:2] == settings.impedance_range[:2]
    assert own.impedance_range[2] == settings.impedance_range[2] / 16.0
    assert (own.contact_time / settings.contact_time) ** 2 == 1 / 16


@pytest.mark.parametrize("settings", [*SCALED, HELD, STOCK])
def test_refined_settings_step_twice_as_often(settings: EngineSettings) -> None:
    assert settings.refined().time_step == settings.time_step / 2.0
    assert settings.at_step(0.25).time_step == settings.time_step / 4.0


def test_a_step_is_split_until_nothing_gets_further_than_allowed() -> None:
    assert (MUJOCO.most_travel, MUJOCO.time_step) == (0.001, 0.001)
    assert [MUJOCO.parts_for_travel(speed) for speed in (0.0, 0.99, 1.01, 9.9)] == [1, 1, 2, 10]
    assert STOCK.parts_for_travel(1000.0) == 1  # as it comes


def test_the_usual_plank_has_the_usual_diagonal() -> None:
    assert scale_of().longest_diagonal * USUAL_DIAGONAL == pytest.approx(0.12016, abs=1e-5)
