"""The outline of a report: cases by scenario, systems that agree merged, and the lines of a failure."""

import shlex
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import isfinite

from stackdsl.report.text import margin_text, outcome_text, unchecked_text
from stackdsl.report.warnings import wrong_edges_text, wrong_friction_text
from stackdsl.results import UNCHECKED, ClaimOutcome, Report, RunStatus, VariantResult
from stackdsl.simulation.known_systems import KNOWN
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.wording import energy_fault, how_many, level_text, significant


class Status(StrEnum):
    """The status of a case; in this order, reports show them."""

    FAILED = "failed"
    DIFFERS = "golden differs"
    EXPECTED_FAILURE = "expected failure"
    UNCHECKED = "unchecked"
    NOT_RUN = "not run"  # the check was interrupted before its end
    SKIPPED = "skipped"
    PASSED = "passed"


MARKS = {  # of a status, without its colour
    Status.FAILED: "\u2717",
    Status.DIFFERS: "\u2260",
    Status.EXPECTED_FAILURE: "!",
    Status.UNCHECKED: "!",
    Status.NOT_RUN: "\u2013",
    Status.SKIPPED: "\u2013",
    Status.PASSED: "\u2713",
}


def status_of(result: VariantResult) -> Status:
    """Return the status of a case."""
    if result.status is RunStatus.SKIPPED:
        return Status.SKIPPED
    if result.status is RunStatus.NOT_RUN:
        return Status.NOT_RUN
    if result.status is not RunStatus.DONE or result.unexpected:
        return Status.FAILED
    if result.golden_failed:
        return Status.DIFFERS
    if not result.passed:
        return Status.EXPECTED_FAILURE
    return Status.UNCHECKED if result.conclusion == UNCHECKED else Status.PASSED


@dataclass(frozen=True, slots=True)
class CaseRow:
    """Cases that differ only in their system, and agree."""

    status: Status
    results: tuple[VariantResult, ...]  # at least one

    @property
    def first(self) -> VariantResult:
        """Return the case that stands for all."""
        return self.results[0]

    @property
    def wall_time(self) -> float:
        """Return the wall time of all [s]."""
        return sum(result.cost.wall_time for result in self.results if result.cost is not None)


@dataclass(frozen=True, slots=True)
class Group:
    """The cases of one scenario, the worst first."""

    file: str
    scenario: str
    rows: tuple[CaseRow, ...]

    @property
    def status(self) -> Status:
        """Return the worst status."""
        return self.rows[0].status

    @property
    def wall_time(self) -> float:
        """Return the wall time of all cases [s]."""
        return sum(row.wall_time for row in self.rows)

    def count(self, status: Status) -> int:
        """Return the number of cases of a status."""
        return sum(len(row.results) for row in self.rows if row.status is status)


def outline(report: Report) -> tuple[Group, ...]:
    """Return the cases by scenario; groups and rows with the worst status come first."""
    order = list(Status)
    scenarios: defaultdict[tuple[str, str], list[VariantResult]] = defaultdict(list)
    for result in report.results:
        scenarios[result.file, result.scenario].append(result)
    groups = [
        Group(file, scenario, tuple(sorted(_rows(results), key=lambda row: order.index(row.status))))
        for (file, scenario), results in scenarios.items()
    ]
    return tuple(sorted(groups, key=lambda group: order.index(group.status)))


def _rows(results: Iterable[VariantResult]) -> Iterator[CaseRow]:
    """Yield rows; systems agree if status, result and failed claims are the same."""
    alike: defaultdict[tuple[object, ...], list[VariantResult]] = defaultdict(list)
    for result in results:
        failed = tuple((outcome.name, outcome.measured) for outcome in result.outcomes if not outcome.passed)
        alike[result.case, status_of(result), result_text(result), failed, result.message].append(result)
    for key, agreeing in alike.items():
        yield CaseRow(Status(str(key[1])), tuple(agreeing))


def result_text(result: VariantResult) -> str:
    """Return what happened, on one line."""
    if result.status is not RunStatus.DONE:
        return ": ".join(filter(None, [result.status.value, result.message or _mistake(result)]))
    if result.ensemble is not None:
        return result.ensemble.summary
    if result.collapse is not None:
        cause = result.why.why if result.why is not None else ""
        if result.collapse.fallen:
            return f"{result.collapse.text}; {cause}" if cause else result.collapse.text
        where = f"collapses at {level_text(result.collapse.level, result.collapse.step)}"
        return f"{where}: {cause}" if cause else f"{where}, first {result.collapse.brick}"
    if result.unchecked and result.fell:
        return unchecked_text(result)
    failed = any(not outcome.passed for outcome in result.outcomes)
    return f"{result.verdict}, but is still moving at the end" if result.moving and failed else result.verdict


def _mistake(result: VariantResult) -> str:
    return f"{result.mistake.code} {result.mistake.message}" if result.mistake is not None else ""


def failure_lines(result: VariantResult) -> Iterator[tuple[str, str]]:
    """Yield the lines of a failure: expected, measured, other failed claims, why, after, first to move."""
    failed = [outcome for outcome in result.outcomes if not outcome.passed]
    if failed:
        yield "expected", f"{failed[0].name}: {failed[0].expected}"
        yield "measured", f"{failed[0].measured}{margin_text(failed[0])}"
        yield from (("also", outcome_text(outcome)) for outcome in failed[1:])
    elif result.status is not RunStatus.DONE:
        yield from _stop_lines(result)
    elif result.unchecked:
        yield "expected", "at least one expectation under `expect`"
        yield "measured", unchecked_text(result)
    elif result.unexpected:
        yield "expected", f"a failure, as `xfail` says: {result.xfail}"
        yield "measured", "all expectations are met"
    if result.numerical:
        yield "why", f"a numerical collapse: {result.numerical}"
    elif result.why is not None and (cause := result.why.why):
        yield "why", cause
    if result.why is not None and result.why.before:
        yield "after", result.why.before
    if result.why is not None and result.why.first:
        yield "first", result.why.first
    note = engine_warning(result)
    if note and not any(note in outcome.measured for outcome in failed):
        yield "note", note


def _stop_lines(result: VariantResult) -> Iterator[tuple[str, str]]:
    yield "measured", result_text(result)
    if result.remedy:
        line = "; to see the line that hangs, interrupt the command below with Ctrl-C"
        yield "helps", f"{result.remedy}{line * _may_hang(result)}"


def run_command(result: VariantResult) -> str:
    """Return the shell command that plays the case of a result again."""
    # No scenario names a system of another engine, so it has to be chosen.
    system = [] if result.system in SYSTEMS else ["--system", result.system]
    return shlex.join(["stackdsl", "run", result.file, *system, "-k", result.name])


def see_line(result: VariantResult, page: str) -> tuple[str, str]:
    """Return the label and the shell command of what shows a failure: the traceback of a crash, or a page of the run.

    A run that takes too long has no page, but prints its events as they happen.
    """
    command = run_command(result)
    if result.status is RunStatus.CRASHED:
        return "traceback", f"STACKDSL_DEBUG=1 {command}"
    if result.status is RunStatus.TIMED_OUT:
        return "see it", f"STACKDSL_DEBUG=1 {command}" if _may_hang(result) else command
    return "see it", f"{command} --html {shlex.quote(page)}"


def stop_text(result: VariantResult) -> str:
    """Return why a case did not end, and what helps, on one line."""
    return "; ".join(filter(None, [result.message, remedy_text(result)]))


def remedy_text(result: VariantResult) -> str:
    """Return what helps a case that did not end, and the command that shows where it ended; empty for others."""
    _, command = see_line(result, "")
    shown = f"for the traceback: {command}" if result.status is RunStatus.CRASHED else ""
    if _may_hang(result):
        shown = f"to see the line that hangs, interrupt this with Ctrl-C: {command}"
    return "; ".join(filter(None, [result.remedy, shown]))


def _may_hang(result: VariantResult) -> bool:
    """Return whether an engine of another package took too long, so that its author may look for an endless loop."""
    return result.status is RunStatus.TIMED_OUT and result.system not in KNOWN


def engine_warning(result: VariantResult) -> str:
    """Return why the motion of a run cannot be trusted; empty if nothing is known against it."""
    if result.energy_gained:
        return energy_fault(result.energy_gained)
    if result.wrong_edges is not None:
        return wrong_edges_text(result.wrong_edges, result.collapse)
    return wrong_friction_text(result.wrong_friction) if result.wrong_friction is not None else ""


@dataclass(frozen=True, slots=True)
class Nearest:
    """The claim that is nearest to failing."""

    result: VariantResult
    outcome: ClaimOutcome
    share: float | None  # margin as a share of the limit; None for a claim without a number and limit

    @property
    def text(self) -> str:
        """Return the margin in the unit of its claim: `drift 3.9 mm from its limit`."""
        margin = f"{significant(self.outcome.margin)} {self.outcome.unit}".rstrip()
        unclear = f", with {self.outcome.unclear} unclear" if self.outcome.unclear else ""
        return f"{self.outcome.name} {margin} from its limit{unclear}"


def nearest(results: Iterable[VariantResult]) -> list[Nearest]:
    """Return for each passed case the claim that is nearest to failing, the nearest first.

    Claims of different units are compared by their margin as a share of the limit. Claims without a limit, such as
    `stands`, come last, as their margins cannot be compared.
    """
    found = [near for result in results if status_of(result) is Status.PASSED for near in _nearest(result)]
    return sorted(found, key=lambda near: (near.share is None, near.share or 0.0))


def _nearest(result: VariantResult) -> list[Nearest]:
    margins = [outcome for outcome in result.outcomes if isfinite(outcome.margin) and not outcome.moved]
    finite = [Nearest(result, outcome, _share(outcome)) for outcome in margins if outcome.margin > 0.0]
    return [min(finite, key=lambda near: (near.share is None, near.share or 0.0))] if finite else []


def _share(outcome: ClaimOutcome) -> float | None:
    """Return the margin of a claim as a share of its limit, or of half the width between two limits."""
    widths = []
    for number in outcome.numbers:
        limits = [limit for limit in (number.least, number.most) if limit is not None]
        width = (max(limits) - min(limits)) / 2.0 if len(limits) > 1 else max(map(abs, limits), default=0.0)
        margin = min((abs(number.value - limit) for limit in limits), default=0.0)
        widths += [margin / width] if width > 0.0 else []
    return min(widths, default=None)


def headline(report: Report) -> str:
    """Return the verdict of a report in a few words."""
    counts = counts_of(report.results)
    total = len(report.results) - counts[Status.SKIPPED]
    mistakes = f"{how_many(len(report.diagnostics), 'mistake')} in the files" if report.diagnostics else ""
    if report.interrupted:
        not_run = f"Interrupted: {counts[Status.NOT_RUN]} of {how_many(total, 'case')} not run"
        bad = [f"{counts[status]} {status}" for status in (Status.FAILED, Status.DIFFERS) if counts[status]]
        return ", ".join([not_run, *filter(None, [mistakes]), *(bad or ["none of the others failed"])])
    if mistakes:
        failed = f", {counts[Status.FAILED]} of {how_many(total, 'case')} failed"
        return mistakes + failed * bool(counts[Status.FAILED])
    differ = f"{how_many(counts[Status.DIFFERS], 'golden file')} differ{'s' * (counts[Status.DIFFERS] == 1)}"
    if counts[Status.FAILED]:
        failed = f"{counts[Status.FAILED]} of {how_many(total, 'case')} failed"
        return f"{failed}, {differ}" if counts[Status.DIFFERS] else failed
    if counts[Status.DIFFERS]:
        return differ
    if not total:
        return "No case was played"
    others = [f"{counts[status]} {status}" for status in (Status.EXPECTED_FAILURE, Status.UNCHECKED) if counts[status]]
    passed = (
        f"All {total} cases passed" if total > 1 and not others else f"{how_many(counts[Status.PASSED], 'case')} passed"
    )
    return ", ".join([passed, *others])


def counts_of(results: Sequence[VariantResult]) -> dict[Status, int]:
    """Return the number of cases of each status."""
    statuses = [status_of(result) for result in results]
    return {status: statuses.count(status) for status in Status}
