"""Directories of golden files and scenarios of a test: the setting of pytest, or else those of `stackdsl check`."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from stackdsl.disk import true_folder
from stackdsl.project_file import Project, ProjectError, confined, project_of


def golden_directory(config: pytest.Config, test: Path) -> Path:
    """Return the directory of the golden files for a test in this file. Fail the test if the project is invalid."""
    if configured := config.getini("golden_directory"):
        golden = Path(os.path.normpath(config.rootpath / str(configured)))
        if not golden.is_relative_to(config.rootpath):
            raise pytest.UsageError(
                f"golden_directory = {configured} is outside of {config.rootpath}; choose a directory inside it"
            )
        return _confined(config, golden)
    return _confined(config, _in_project(config, test, lambda project: project.golden))


def _confined(config: pytest.Config, golden: Path) -> Path:
    try:
        true_folder(golden, confined(golden, config.rootpath))
    except OSError as error:
        pytest.fail(f"{golden}: {error.strerror}", pytrace=False)
    return golden


def scenario_directory(config: pytest.Config, test: Path) -> Path:
    """Return the directory of all scenarios of the project around a test. Fail the test if the project is invalid."""
    return _in_project(config, test, lambda project: project.scenarios)


def state_directory(config: pytest.Config, test: Path, golden: Path) -> Path:
    """Return the directory of pending differences from these golden files, as `stackdsl golden` reads it."""
    return _in_project(config, test, lambda project: project.state(golden))


def _in_project(config: pytest.Config, test: Path, named: Callable[[Project], Path]) -> Path:
    try:
        project = project_of([test.parent])
    except ProjectError as error:
        pytest.fail(str(error), pytrace=False)
    home = config.rootpath if project.root is None else Path.cwd()  # paths of the project are relative to it
    return Path(os.path.normpath(home / named(project)))
