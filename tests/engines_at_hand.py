"""Tests that reach for an engine where it is not installed are skipped, each by name and with the reason."""

from collections.abc import Generator
from importlib.util import find_spec

import pytest

from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.plugins import foreign_names
from stackdsl.simulation.systems import Method, System

HAS_PYBULLET = find_spec("pybullet") is not None
REASON = "needs PyBullet, which has wheels up to CPython 3.11 only"
REASONS = {"pybullet": REASON, "mujoco": "mujoco is in the extra mujoco", "numba": "numba is in the extra rigid"}
# Systems of packages that are installed beside this one, as plugins/stackdsl-sapien is, are held to the same tests.
FOREIGN: list[System] = [system for system in map(system_named, foreign_names()) if system.engine.package.installed]
PEERS = ["mujoco", *(system.name for system in FOREIGN if system.method is None)]  # bare engines
WITH_RIGID = [*PEERS, "rigid"]
THESIS_PEERS = ["mujoco-thesis", *(system.name for system in FOREIGN if system.method is Method.PUBLISHED)]
# For tests that would not reach for it themselves, but for a command that says so.
needs_pybullet = pytest.mark.skipif(not HAS_PYBULLET, reason=REASON)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Generator[None, None, None]:
    """Fixtures may reach for it."""
    return (yield from _skipped_without())


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, None, None]:
    """So may tests."""
    return (yield from _skipped_without())


def _skipped_without() -> Generator[None, None, None]:
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name not in REASONS or find_spec(error.name) is not None:
            raise
        pytest.skip(REASONS[error.name])


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Files of tests that are all about it may import it."""
    report = yield
    if not HAS_PYBULLET and report.failed and "No module named 'pybullet'" in str(report.longrepr):
        report.outcome, report.longrepr = "skipped", (str(collector.path), 1, f"Skipped: {REASON}")
    return report
