"""All that failed, as single findings, worst first: for outputs that show only so many."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from stackdsl.diagnostics import Span
from stackdsl.outcome import Report, RunStatus, VariantResult
from stackdsl.report.outcome_text import TO_CLAIM, outcome_text, unchecked_text
from stackdsl.report.why_text import cause_text
from stackdsl.shown_text import visible

MOST_SEEN = 3  # differences of one golden file; the rest is in the text


class Rank(IntEnum):
    """How bad a finding is; what makes others least trustworthy comes first."""

    INVALID = 0
    STOPPED = 1
    FAILED = 2
    GOLDEN = 3
    WARNED = 4  # of what fails nothing


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to look into."""

    rank: Rank
    title: str
    text: str
    file: str
    line: int = 1
    column: int = 1


def findings(report: Report) -> list[Finding]:
    """All of them, worst first, and otherwise in the order of the report; what is only a warning comes last."""
    found = [
        Finding(Rank.INVALID, each.code, f"{each.message}{f'; {each.hint}' if each.hint else ''}", *_place(each.span))
        for each in report.diagnostics
    ]
    found += [finding for result in report.results for finding in findings_of(result)]
    found += [finding for result in report.results for finding in warnings_of(result)]
    found += [
        Finding(Rank.GOLDEN, "obsolete golden file", "no variant has this name", visible(file))
        for file in report.obsolete
    ]
    return sorted(found, key=lambda finding: finding.rank)


def findings_of(result: VariantResult) -> Iterator[Finding]:
    """What one result has to be looked into for."""
    if result.mistake is not None:
        yield Finding(Rank.INVALID, result.name, result.mistake.message, *_place(result.mistake.span))
    elif result.status not in (RunStatus.DONE, RunStatus.SKIPPED):
        yield Finding(Rank.STOPPED, result.name, f"{result.status}: {result.message}", result.file)
    for outcome in result.outcomes:
        if not outcome.passed:
            cause = cause_text(result.why) if result.why is not None else ""
            text = "; ".join(filter(None, [outcome_text(outcome), cause]))
            yield Finding(Rank.FAILED, result.name, text, *_place(outcome.span))
    if result.unchecked and result.must_claim:
        yield Finding(Rank.FAILED, result.name, _unchecked(result), result.file)
    if result.golden is not None and result.golden_failed:
        golden = result.golden
        seen = [f"{one.subject}: {one.quantity}: was {one.expected}, is {one.got}" for one in golden.differences]
        more = [f"and {len(seen) - MOST_SEEN} more"] if len(seen) > MOST_SEEN else []
        told = "; ".join(filter(None, [golden.note, *seen[:MOST_SEEN], *more]))
        text = f"{golden.file}: {golden.status}{f': {told}' if told else ''}"
        yield Finding(Rank.GOLDEN, result.name, text, result.file)


def warnings_of(result: VariantResult) -> Iterator[Finding]:
    """What one result has to be looked into for that fails nothing: what is odd, and what fell unexpectedly."""
    for odd in result.warnings:
        yield Finding(Rank.WARNED, result.name, "; ".join(filter(None, [odd.message, odd.hint])), *_place(odd.span))
    if result.unchecked and result.fell and not result.must_claim:
        yield Finding(Rank.WARNED, result.name, _unchecked(result), result.file)


def _unchecked(result: VariantResult) -> str:
    cause = cause_text(result.why) if result.why is not None else ""
    return "; ".join(filter(None, [unchecked_text(result), cause, TO_CLAIM]))


def _place(span: Span) -> tuple[str, int, int]:
    return span.file, span.line, span.column
