"""The pytest plugin: collects scenarios as tests, and provides golden files for tests in Python.

Its entry point registers it. `pytest scenarios` collects every variant on every system as a test. A test in Python can
use `assert snapshot == golden(snapshot.identity)`; only this fixture needs syrupy. Both read and write the golden files
of `stackdsl check`.

If stackdsl is installed, every run of pytest loads this plugin. So it imports other modules only when they are needed.
"""

import os
import sys
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from _pytest._code.code import ExceptionChainRepr

if TYPE_CHECKING:
    from stackdsl.pytest_plugin.scenario_file import ScenarioFile
    from stackdsl.pytest_plugin.shared_snapshots import Golden

Collected = pytest.StashKey[list[pytest.Item]]()
NEEDS_SYRUPY = "the fixture `golden` needs syrupy; try: pip install 'stackdsl[pytest]'"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the settings and options of the plugin."""
    parser.addini(
        "golden_directory",
        "directory of golden files, relative to the root directory; default: that of the project",
        default="",
    )
    parser.addini(
        "scenario_directories",
        "directories of scenarios, relative to the root directory; other YAML files are collected only if named",
        type="args",
        default=["scenarios"],
    )
    group = parser.getgroup("stackdsl", "scenarios of stacked bricks")
    group.addoption(
        "--accept-failing", action="store_true", help="with --snapshot-update, also accept scenarios that fail"
    )
    group.addoption("--no-golden", action="store_true", help="do not compare scenarios with golden files")


def pytest_configure(config: pytest.Config) -> None:
    """Import the libraries and modules of scenarios, if tests run pytest within this process.

    The fixture `pytester` removes the modules that such a run imports. C extensions cannot be imported twice, and
    `stackdsl` keeps the public names of removed modules, whose results are then of unknown classes.
    """
    if config.pluginmanager.has_plugin("pytester"):
        import numpy as np  # noqa: F401, PLC0415 -- imported once, not used
        import pint  # noqa: F401, PLC0415 -- likewise; with dask installed, a second import fails
        import scipy.optimize  # noqa: F401, PLC0415 -- likewise
        import yaml  # noqa: F401, PLC0415 -- likewise

        import stackdsl.api.run  # noqa: F401, PLC0415 -- likewise


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "ScenarioFile | None":
    """Collect a YAML file that is named by the user, or in a directory of scenarios."""
    if file_path.suffix.lower() not in (".yaml", ".yml"):
        return None
    homes = [parent.config.rootpath / name for name in parent.config.getini("scenario_directories")]
    if not parent.session.isinitpath(file_path) and not any(file_path.is_relative_to(home) for home in homes):
        return None
    from stackdsl.pytest_plugin.scenario_file import ScenarioFile  # noqa: PLC0415 -- only for scenarios

    return ScenarioFile.from_parent(parent, path=file_path)


def pytest_assertrepr_compare(config: pytest.Config, op: str, left: object, right: object) -> list[str] | None:
    """Explain `assert run.verdict == "stands"`: expected, measured and why."""
    if op != "==" or "stackdsl.api.run" not in sys.modules:  # nothing has a verdict then
        return None
    from stackdsl.api.run import RunVerdict  # noqa: PLC0415 -- only for tests with runs

    for verdict, expected in ((left, right), (right, left)):
        if isinstance(verdict, RunVerdict):
            return [f"{str(left)!r} == {str(right)!r}", *verdict.unlike(expected)]
    return None


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    call: pytest.CallInfo[None],
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Explain `assert run`, `assert run.judge(claim)` and `assert run.golden(directory)` by lines as in reports."""
    summary = ""
    if (
        call.excinfo is not None
        and call.excinfo.errisinstance(AssertionError)
        and "stackdsl.api.notebook" in sys.modules
    ):
        from stackdsl.pytest_plugin.asserted_values import explain  # noqa: PLC0415 -- only for tests with runs

        summary = explain(call.excinfo)
    report = yield
    if summary and isinstance(report.longrepr, ExceptionChainRepr) and report.longrepr.reprcrash is not None:
        report.longrepr.reprcrash.message = summary
    return report


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> "Golden":
    """Return a function from the identity of a snapshot to its golden file; the module docstring shows a test."""
    if not request.config.pluginmanager.has_plugin("syrupy"):
        pytest.fail(NEEDS_SYRUPY, pytrace=False)
    from stackdsl.goldens.golden import REFUSED, is_ci  # noqa: PLC0415 -- only for golden files
    from stackdsl.pytest_plugin.shared_snapshots import compare_with_golden, lock_of  # noqa: PLC0415 -- syrupy is optional

    if request.config.getoption("update_snapshots", default=False) and is_ci(os.environ):
        pytest.fail(REFUSED, pytrace=False)
    return compare_with_golden(request.getfixturevalue("snapshot"), lock_of(request))


def pytest_sessionstart() -> None:
    """Forget which golden files an earlier session of this process has compared."""
    if "stackdsl.goldens.golden" in sys.modules:
        from stackdsl.goldens.golden import COMPARED  # noqa: PLC0415 -- only after a session with scenarios

        COMPARED.clear()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Keep the tests, of which `pytest_terminal_summary` needs to know whether all of a file have passed."""
    session.config.stash[Collected] = session.items


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell what new golden files do not lock, and report or remove golden files that no test uses any more.

    A golden file is unused only if all tests of the file that wrote it were selected and have passed.
    """
    if "stackdsl.pytest_plugin.scenario_file" not in sys.modules:
        return
    from stackdsl.pytest_plugin.scenario_file import ACCEPT, LockedFiles  # noqa: PLC0415 -- only for scenarios
    from stackdsl.report.golden_differences import unclear_lines  # noqa: PLC0415 -- likewise

    for line in unclear_lines(config.stash.get(LockedFiles, {}).values()):
        terminalreporter.write_line(line)
    if "stackdsl.pytest_plugin.shared_snapshots" not in sys.modules:
        return
    from stackdsl.pytest_plugin import shared_snapshots as shared  # noqa: PLC0415 -- syrupy is optional

    passed = _passed_files(terminalreporter, config)
    for file, owner, user in shared.moved_files(config, passed):
        written = shared.hand_over(config, file, user)
        told = "belongs to" if written else f"names {owner}, and {ACCEPT} changes this to"
        terminalreporter.write_line(f"golden file {os.path.relpath(file)} {told} {user}")
    whole = _is_whole(terminalreporter, config, passed)
    for golden_file in shared.forget_gone(config, passed, whole):
        terminalreporter.write_line(f"dropped pending change, which no test has any more: {golden_file}", yellow=True)
    for file in shared.unused_files(config, passed, whole):
        shown = os.path.relpath(file)
        if shared.remove_unused(config, file):
            terminalreporter.write_line(f"removed golden file, which no test uses: {shown}", yellow=True)
        else:
            remedy = f"remove it with: {ACCEPT}"
            terminalreporter.write_line(f"obsolete golden file, which no test uses: {shown}; {remedy}", yellow=True)


def _is_whole(terminalreporter: pytest.TerminalReporter, config: pytest.Config, passed: list[Path]) -> bool:
    """Return whether the test files that have passed are all of the project: none was left out by an option."""
    here = config.invocation_params.dir == config.rootpath
    named = config.args_source is config.ArgsSource.ARGS
    ignored = config.getoption("ignore") or config.getoption("ignore_glob")
    left_out = ignored or terminalreporter.stats.get("deselected") or terminalreporter.stats.get("error")
    items = config.stash.get(Collected, [])
    return here and not named and not left_out and bool(items) and {item.path for item in items} == set(passed)


def _passed_files(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> list[Path]:
    """Return the test files all of whose tests were selected and have passed."""
    stats = terminalreporter.stats
    passed = {report.nodeid for report in stats.get("passed", ())}
    partly = {item.path for item in stats.get("deselected", ())}
    partly |= {Path(os.path.abspath(each.partition("::")[0])) for each in config.args if "::" in each}
    items = config.stash.get(Collected, [])
    partly |= {item.path for item in items if item.nodeid not in passed}
    return sorted({item.path for item in items} - partly)
