"""SAPIEN as an external system: its settings, and its discovery by the command through the entry point."""

import os
import sys
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
from stackdsl_sapien import SAPIEN, SAPIEN_THESIS, SETTINGS, SapienSettings

from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.protocol import EngineSettings
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.scene_scale import SceneScale
from stability.geometry.box import Box
from stability.model import Brick
from stackdsl.simulation.systems import MOVING
from tests.command_line import GOOD, Result, Stackdsl, write
from tests.paths import ROOT

PLUGIN = ROOT / "plugins" / "stackdsl-sapien"
needs_sapien = pytest.mark.skipif(not SETTINGS.package.installed, reason="sapien is not installed")


def scale_of(factor: float) -> SceneScale:
    size = (factor * 0.1176, factor * 0.0234, factor * 0.0078)
    return SceneScale.of([Brick("plank", Box(size), 0.012)], 9.81)


def test_settings_tell_themselves_in_words() -> None:
    assert SETTINGS.summary() == "step 1/960 s, 20 iterations, 1 velocity iterations, contact offset 1 mm"
    assert SETTINGS.most_travel == MOVING.most_travel


def test_sapien_settings_share_only_the_iterations_of_other_engines() -> None:
    def own(kind: type[EngineSettings]) -> set[str]:
        return {field.name for field in fields(kind)} - {field.name for field in fields(EngineSettings)}

    for kind in (PyBulletSettings, MuJoCoSettings):
        assert own(kind) & own(SapienSettings) == {"iterations"}


def test_sapien_settings_scale_with_the_size_of_bricks() -> None:
    #   1/16 of the lengths, so 1/4 of the times
    own = SETTINGS.scaled(scale_of(1 / 16))
    assert SETTINGS.scaled(scale_of(1.0)) == SETTINGS
    assert own.contact_offset == SETTINGS.contact_offset / 16.0
    assert own.time_step == SETTINGS.time_step / 4.0


def test_refined_settings_iterate_twice_as_often_at_half_the_step() -> None:
    fine = SETTINGS.refined()
    assert (fine.time_step, fine.iterations) == (SETTINGS.time_step / 2.0, 2 * SETTINGS.iterations)


def test_both_sapien_systems_have_the_same_engine() -> None:
    assert SAPIEN.engine == SAPIEN_THESIS.engine == SETTINGS


# --- by its entry points ----------------------------------------------------------------------------------------------


@pytest.fixture
def path(tmp_path: Path) -> str:
    """Return the paths of the installed package, with the entry points of its pyproject.toml."""
    project = tomllib.loads((PLUGIN / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    facts = f"site/stackdsl_sapien-{project['version']}.dist-info"
    systems = project["entry-points"]["stackdsl.systems"]
    written = "\n".join(["[stackdsl.systems]", *(f"{name} = {place}" for name, place in systems.items())])
    head = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    write(tmp_path, head, f"{facts}/METADATA")
    write(tmp_path, written, f"{facts}/entry_points.txt")
    write(tmp_path, GOOD)
    there = {str(ROOT), str(PLUGIN / "src"), str(tmp_path / "site")}
    return os.pathsep.join([*sorted(there), *(entry for entry in sys.path if entry.endswith("site-packages"))])


SYSTEMS = pytest.mark.parametrize("system", ["sapien", "sapien-thesis"])


def called(stackdsl: Stackdsl, path: str, command: str, system: str) -> Result:
    return stackdsl(command, "scene.yaml", "--system", system, PYTHONPATH=path)


@SYSTEMS
@pytest.mark.skipif(SETTINGS.package.installed, reason="sapien is installed")
def test_without_its_engine_it_says_what_to_install(stackdsl: Stackdsl, path: str, system: str) -> None:
    told = called(stackdsl, path, "check", system)
    assert told.code == 4
    assert f"'{system}' needs sapien, which is not installed; try: pip install stackdsl-sapien" in told.err


@SYSTEMS
@needs_sapien
def test_sapien_plays_a_scenario(stackdsl: Stackdsl, path: str, system: str) -> None:
    told = called(stackdsl, path, "check", system)
    assert told.code == 0, told.text
    assert "1 passed" in told.out
    assert f"{system}: PhysX 5 with" in called(stackdsl, path, "explain", system).out
