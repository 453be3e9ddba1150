"""Scenarios as tests of pytest, and golden files for tests in Python.

Registered by its entry point: `pytest scenarios` collects every variant on every system as a test. A test in Python
writes `assert snapshot == golden(snapshot.identity)`, which needs syrupy; nothing else here does. Both read and write
the golden files of `stackdsl check`.

Every run of pytest loads this module if stackdsl is installed, so its imports are inside functions.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from stackdsl.pytest_plugin.scenario_file import ScenarioFile
    from stackdsl.pytest_plugin.shared_snapshots import Golden

NEEDS_SYRUPY = "the fixture `golden` needs syrupy; try: pip install 'stackdsl[pytest]'"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options for the directories of golden files and scenarios, and for their comparison."""
    parser.addini(
        "golden_directory",
        "directory of golden files, relative to the root directory; that of the project, if nothing is said",
        default="",
    )
    parser.addini(
        "scenario_directories",
        "directories of scenarios, relative to the root directory; YAML files elsewhere are tests if they are named",
        type="args",
        default=["scenarios"],
    )
    group = parser.getgroup("stackdsl", "scenarios of stacked bricks")
    group.addoption(
        "--accept-failing", action="store_true", help="let --snapshot-update accept scenarios that fail, too"
    )
    group.addoption("--no-golden", action="store_true", help="hold scenarios against no golden files")


def pytest_configure(config: pytest.Config) -> None:
    """Import all modules that scenarios need, if pytest itself is run within this process.

    The fixture `pytester` unloads the imports of such a run, and C libraries cannot be imported twice.
    """
    if config.pluginmanager.has_plugin("pytester"):
        import numpy as np  # noqa: F401, PLC0415 -- never used here
        import pint  # noqa: F401, PLC0415 -- likewise; where dask is installed, it takes the finder of packages apart
        import scipy.optimize  # noqa: F401, PLC0415 -- likewise
        import yaml  # noqa: F401, PLC0415 -- likewise


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "ScenarioFile | None":
    """Return a collector for a YAML file of scenarios: one that is named, or in a directory of scenarios."""
    if file_path.suffix.lower() not in (".yaml", ".yml"):
        return None
    homes = [parent.config.rootpath / name for name in parent.config.getini("scenario_directories")]
    if not parent.session.isinitpath(file_path) and not any(file_path.is_relative_to(home) for home in homes):
        return None
    from stackdsl.pytest_plugin.scenario_file import ScenarioFile  # noqa: PLC0415 -- only where there are scenarios

    return ScenarioFile.from_parent(parent, path=file_path)


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> "Golden":
    """Return a function from an identity to the object to compare a snapshot with; see the module's docstring."""
    if not request.config.pluginmanager.has_plugin("syrupy"):
        pytest.fail(NEEDS_SYRUPY, pytrace=False)
    from stackdsl.goldens.golden import keeper_of  # noqa: PLC0415 -- only where it is asked for
    from stackdsl.pytest_plugin.golden_directory import golden_directory, scenario_directory  # noqa: PLC0415 -- only where it is asked for
    from stackdsl.pytest_plugin.shared_snapshots import compare_with_golden  # noqa: PLC0415 -- syrupy need not be installed

    folder = golden_directory(request.config, request.path)
    keeper = keeper_of(str(request.path), folder, scenario_directory(request.config, request.path))
    return compare_with_golden(request.getfixturevalue("snapshot"), folder, keeper)
