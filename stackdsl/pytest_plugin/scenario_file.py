"""Scenarios as tests: each file is a collector, and each variant on each system is an item."""

import os
from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING
from warnings import warn

import pytest
from _pytest._code.code import ReprFileLocation, TerminalRepr
from _pytest._io import TerminalWriter

from stackdsl.checking.cases import Case, gather, shared_name
from stackdsl.checking.check import note_pending, unused_goldens
from stackdsl.checking.play_case import play_case, played_or_blocked
from stackdsl.checking.results import Goldens, blocked_result, compare_with_golden, judged, snapshot_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.file_format import golden_name
from stackdsl.goldens.golden import GoldenWriteRefusedError, PendingStore, is_ci
from stackdsl.judging.judge import stop_condition_of
from stackdsl.language.yaml.source import Source
from stackdsl.pytest_plugin.golden_directory import golden_directory, scenario_directory, state_directory
from stackdsl.pytest_plugin.scenario_warnings import ENGINE_INDEPENDENT, OtherEngineWarning, ScenarioWarning
from stackdsl.report.check_text import report_text
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.report.formats import warnings_of
from stackdsl.report.outline import failure_lines
from stackdsl.results import GoldenResult, GoldenStatus, Report, VariantResult
from stackdsl.simulation.brick_tracks import Blocked
from stackdsl.simulation.known_systems import unplayable
from stackdsl.simulation.systems import SYSTEMS

if TYPE_CHECKING:
    from _pytest._code.code import ExceptionInfo, TracebackStyle

Name = pytest.StashKey[dict[str, Source]]()  # the first scenario of each name
Unused = pytest.StashKey[dict[Path, tuple[str, ...]]]()  # golden files without a scenario, by their directory

LockedFiles = pytest.StashKey[dict[Path, GoldenResult]]()  # golden files that this session has written


ACCEPT = "pytest --snapshot-update"
ACCEPT_FAILING = f"{ACCEPT} --accept-failing"
REVIEW = "stackdsl golden review"
IN_CI = "pytest outside of CI, and commit the golden file"
NEEDS_SYRUPY = " (after: pip install 'stackdsl[pytest]')"


class MissedError(Exception):
    """A scenario failed its expectations or differs from its golden file. The text is the report."""

    def __init__(self, text: str, summary: str = "") -> None:
        super().__init__(text)
        self.summary = summary  # one line for the summary of pytest


class _Failure(TerminalRepr):
    """The report of a case, with one line for the summary of pytest."""

    def __init__(self, text: str, file: str, summary: str) -> None:
        self._text = text
        self.reprcrash = ReprFileLocation(file, 0, summary)

    def __str__(self) -> str:
        return self._text

    def toterminal(self, tw: TerminalWriter) -> None:
        """Print the report."""
        tw.line(self._text)


class ScenarioFile(pytest.File):
    """Scenarios of one YAML file."""

    def collect(self) -> Iterable[pytest.Item]:
        """Yield one item per case. Raises CollectError with all diagnostics if the file is invalid."""
        here = Path.cwd()
        gathered = gather([self.path.relative_to(here) if self.path.is_relative_to(here) else self.path])
        if gathered.diagnostics:
            raise self.CollectError("\n\n".join(map(diagnostic_text, gathered.diagnostics)))
        firsts = self.config.stash.setdefault(Name, {})
        for name, cases in groupby(gathered.cases, lambda case: case.scenario_name):
            case, *others = cases
            first = firsts.setdefault(name, case.written)
            if first.file == case.file:
                yield from (ScenarioItem.from_parent(self, name=each.name, case=each) for each in (case, *others))
            else:
                yield NamesakeItem.from_parent(self, name=name, mistake=shared_name(case.written, first))


class NamesakeItem(pytest.Item):
    """A scenario with the name of another: fails, and the other scenarios run."""

    def __init__(self, *, mistake: Diagnostic, **others: object) -> None:
        super().__init__(**others)  # type: ignore[arg-type]  # pytest's own arguments
        self.mistake = mistake

    def runtest(self) -> None:
        """Raise MissedError with the place of both scenarios."""
        raise MissedError(diagnostic_text(self.mistake), f"{self.mistake.code} {self.mistake.message}")

    def repr_failure(
        self, excinfo: "ExceptionInfo[BaseException]", style: "TracebackStyle | None" = None
    ) -> "str | TerminalRepr":
        """Return the diagnostic."""
        return _Failure(str(excinfo.value), str(self.path), getattr(excinfo.value, "summary", ""))

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the place of the scenario."""
        return self.path, self.mistake.span.line - 1, self.name


class ScenarioItem(pytest.Item):
    """One variant of a scenario on one system: passes if it meets its expectations and its golden file."""

    def __init__(self, *, case: Case, **others: object) -> None:
        super().__init__(**others)  # type: ignore[arg-type]  # pytest's own arguments
        self.case = case
        for tag in case.scenario.tags:
            self.config.addinivalue_line("markers", f"{tag}: a tag of scenarios")  # required by --strict-markers
            self.add_marker(tag)

    def runtest(self) -> None:
        """Play the case and judge it. Raises MissedError."""
        if why := self.case.skip or unplayable(self.case.system):
            pytest.skip(why)
        start = perf_counter()
        result = self._result()
        if not is_ci(os.environ):
            note_pending(result, self._waiting())
        if result.golden is not None and result.golden.status in (GoldenStatus.NEW, GoldenStatus.WRITTEN):
            self.config.stash.setdefault(LockedFiles, {})[Path(result.golden.file)] = result.golden
        if result.golden is not None and result.golden.status is GoldenStatus.OTHER_ENGINE:
            warn(OtherEngineWarning(f"{ENGINE_INDEPENDENT}: {result.golden.note}"), stacklevel=1)
        for finding in warnings_of(result):
            warn(ScenarioWarning(f"{finding.title}: {finding.text}"), stacklevel=1)
        if result.xfail is not None and not result.passed and not result.golden_failed:
            pytest.xfail(result.xfail)
        if result.unexpected or result.golden_failed:
            report = Report(
                (result,),
                accept=self._accept(result),
                accept_failing=ACCEPT_FAILING,
                review="" if is_ci(os.environ) else REVIEW,
                wall_time=perf_counter() - start,
            )
            lines = list(failure_lines(result)) if result.unexpected else []
            claims = ("expected", "measured", "also")
            summary = ", ".join(f"{label} {text}" for label, text in lines if label in claims)
            missing = result.golden is not None and result.golden.status is GoldenStatus.MISSING
            raise MissedError(
                report_text(report), summary or ("has no golden file" if missing else "differs from its golden file")
            )

    def _waiting(self) -> PendingStore | None:
        """Return the store of differences that await a decision, as of `stackdsl check`."""
        if self.config.getoption("no_golden"):
            return None
        folder = golden_directory(self.config, self.path)
        return PendingStore(state_directory(self.config, self.path, folder), folder)

    def _accept(self, result: VariantResult) -> str:
        """Return the command that accepts the difference of a result from its golden file; empty if none may."""
        if not (result.golden_failed and result.may_be_locked):
            return ""
        if is_ci(os.environ):
            return IN_CI
        if result.golden is not None and result.golden.status is GoldenStatus.RENAMED:
            return "stackdsl check --update"
        return ACCEPT + NEEDS_SYRUPY * (not self.config.pluginmanager.has_plugin("syrupy"))

    def _result(self) -> VariantResult:
        case = self.case
        if case.is_sampled:
            return self._sampled()
        trace = played_or_blocked(play_case, case.timeline, case.system, stop_condition_of(case.scenario, case.system))
        if isinstance(trace, Blocked):
            return blocked_result(case, trace)
        result = judged(case, trace)
        if case.system not in SYSTEMS or self.config.getoption("no_golden"):
            return result
        return replace(
            result, golden=compare_with_golden(snapshot_of(case, trace), self._goldens(), str(self.path), result)
        )

    def _goldens(self) -> Goldens:
        """Return the options for golden files."""
        if self.config.getoption("no_golden"):
            return Goldens(None)
        update = bool(self.config.getoption("update_snapshots", default=False))  # an option of syrupy
        folder, scenarios = golden_directory(self.config, self.path), scenario_directory(self.config, self.path)
        is_new = not (folder / golden_name(self.case.identity)).exists()
        return Goldens(
            folder,
            update,
            unused=self._unused(folder, scenarios) if is_new and not update else (),
            write_new_goldens=not update and not is_ci(os.environ),
            accept_failing=self.config.getoption("accept_failing"),
            scenarios=scenarios,
        )

    def _unused(self, folder: Path, scenarios: Path) -> tuple[str, ...]:
        """Return the golden files without a scenario; this scenario may have been renamed from one of them."""
        known = self.config.stash.setdefault(Unused, {})
        if folder not in known:
            known[folder] = unused_goldens(gather([scenarios]), folder) if folder.is_dir() else ()
        return known[folder]

    def _sampled(self) -> VariantResult:
        """Return the result of a sampled case."""
        from stackdsl.checking.ensembles import sampled_result  # noqa: PLC0415 -- imports scipy

        return sampled_result(self.case, os.cpu_count() or 1, self._goldens())

    def repr_failure(
        self, excinfo: "ExceptionInfo[BaseException]", style: "TracebackStyle | None" = None
    ) -> "str | TerminalRepr":
        """Return the report of the case, or a traceback for other errors."""
        if isinstance(excinfo.value, MissedError | GoldenWriteRefusedError):
            return _Failure(str(excinfo.value), str(self.path), getattr(excinfo.value, "summary", ""))
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the place of the scenario."""
        return self.path, self.case.source.key_span_of(("scenario",)).line - 1, self.name
