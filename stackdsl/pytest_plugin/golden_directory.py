"""The directory of golden files of a test: the one configured in pytest, or otherwise that of `stackdsl check`."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from stackdsl.disk import true_folder
from stackdsl.project_file import Project, ProjectError, confined, project_of


def golden_directory(config: pytest.Config, test: Path) -> Path:
    """Return the directory of golden files for a test in this file. Fails the test if the project file is invalid."""
    if named := config.getini("golden_directory"):
        golden = Path(os.path.normpath(config.rootpath / str(named)))
        if not golden.is_relative_to(config.rootpath):
            raise pytest.UsageError(f"golden_directory = {named} leads out of {config.rootpath}; name one below")
        return _confined(config, golden)
    return _confined(config, _in_project(config, test, lambda project: project.golden))


def _confined(config: pytest.Config, golden: Path) -> Path:
    try:
        true_folder(golden, confined(golden, config.rootpath))
    except OSError as error:
        pytest.fail(f"{golden}: {error.strerror}", pytrace=False)
    return golden


def scenario_directory(config: pytest.Config, test: Path) -> Path:
    """Return the directory of the scenarios checked together with a test. Fails the test likewise."""
    return _in_project(config, test, lambda project: project.scenarios)


def _in_project(config: pytest.Config, test: Path, named: Callable[[Project], Path]) -> Path:
    try:
        project = project_of([test.parent])
    except ProjectError as error:
        pytest.fail(str(error), pytrace=False)
    home = config.rootpath if project.root is None else Path.cwd()  # the project is displayed relative to this path
    return Path(os.path.normpath(home / named(project)))
