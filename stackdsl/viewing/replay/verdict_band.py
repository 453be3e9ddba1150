"""The verdict of a run in words, for the band on top of its page."""

from collections.abc import Iterator, Mapping
from typing import Any, Final, TypeAlias

from stability.work_limit import TooMuchWorkError, limited
from stackdsl.judging.proofs import MOST_FOR_PROGRAMS, proofs_of
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, OtherNumber, Remedies, StrongerJoints, remedies_of
from stackdsl.report.outline import Status, failure_lines, status_of
from stackdsl.report.statics import counterweight_text, friction_text, stronger_text
from stackdsl.report.text import ending_text, margin_words, outcome_text, unchecked_text
from stackdsl.results import ClaimOutcome, RunStatus, VariantResult
from stackdsl.viewing.run_view import RunView
from stackdsl.work import limit

Json: TypeAlias = Mapping[str, Any]

SHOWN: Final = {Status.PASSED: "passed", Status.FAILED: "failed", Status.EXPECTED_FAILURE: "differs"}  # others: open
IN_TABLE: Final = ("expected", "measured", "also")  # of the claims
WARNING: Final = "Warning"  # shown in the band, as in the terminal
TO_FALL: Final = ("collapses", "falls", "pivots")  # claims that no remedy against a fall helps


def verdict_json(run: RunView, hurried: bool = False) -> Json:
    """Return status, headline and facts of a run; `hurried` omits the remedies, which take seconds."""
    result = run.result
    status, headline = _headline(run)
    return {
        "status": status,
        "headline": headline,
        "facts": [[name, text] for name, text in _facts(result) if text],
        "claims": [_claim(outcome) for outcome in result.outcomes],
        "truths": [_claim(outcome) for outcome in result.truths],
        "see": result.why.see if result.why is not None else "",
        "helps": [] if hurried else helps_json(run),
    }


def _headline(run: RunView) -> tuple[str, str]:
    """Return the status, which the page shows in colour and shape, and the answer in one line."""
    result, failed = run.result, [outcome for outcome in run.result.outcomes if not outcome.passed]
    if result.status is not RunStatus.DONE or run.marks is not None:
        return "open", run.verdict[:1].upper() + run.verdict[1:]
    count = len(result.outcomes)
    several = f"{len(failed)} of {count} claims; " if count > 1 else ""
    match status := status_of(result):
        case Status.PASSED:
            answer = f"Passed: {_short(result.outcomes[0])}" if count == 1 else f"Passed: all {count} claims hold"
        case Status.EXPECTED_FAILURE:
            answer = f"Expected failure: {result.xfail}"
        case Status.FAILED if failed:
            answer = f"Failed: {several}{_short(failed[0])}"
        case Status.FAILED if result.xfail is not None:
            answer = f"Passed, but marked `xfail`: {result.xfail}"
        case _ if result.outcomes:
            answer = f"Failed: {result.numerical}"
        case _:
            answer = f"Not checked: {unchecked_text(result)}"
    return SHOWN.get(status, "open"), answer


def _short(outcome: ClaimOutcome) -> str:
    """Return claim and measured value without names of bricks, which follow below."""
    measured = outcome.measured.partition(": ")[0]
    return f"{outcome.name}: expected {outcome.expected}, measured {measured}"


def _facts(result: VariantResult) -> Iterator[tuple[str, str]]:
    """Yield what explains the verdict, in the order of all reports; the table of claims has the others."""
    yield from ((name.capitalize(), text) for name, text in failure_lines(result) if name not in IN_TABLE)
    yield from ((WARNING, f"{odd.span}: {odd.message}") for odd in result.warnings)  # the terminal has the remedies
    disagreeing = [truth for truth in result.truths if not truth.passed]
    yield "Reference disagrees", "; ".join(outcome_text(truth) for truth in disagreeing)
    if result.early_end is not None:
        yield "End", ending_text(result.early_end)


def _claim(outcome: ClaimOutcome) -> Json:
    return {
        "name": outcome.name,
        "expected": outcome.expected,
        "measured": f"{outcome.measured}{f' ({outcome.moved})' * bool(outcome.moved and outcome.passed)}",
        "margin": margin_words(outcome),
        "passed": outcome.passed,
        "place": str(outcome.span),
    }


# Remedies for a run that should stand: each with what can be written in the file.


def helps_json(run: RunView) -> list[Json]:
    """Return the remedies of a run that falls against its claims; none for many bricks, as they take minutes."""
    failed = [outcome for outcome in run.result.outcomes if not outcome.passed]
    bricks = sum(not placement.hits for placement in run.timeline.placements)
    wanted = failed and not any(outcome.name in TO_FALL for outcome in failed)
    if not wanted or run.numbers is None or run.proofs.fall is None or bricks > MOST_FOR_PROGRAMS:
        return []
    try:
        with limited(limit()):
            return remedies_json(remedies_of(run.numbers, run.timeline, proofs_of(run.timeline)))
    except TooMuchWorkError:
        return []


def remedies_json(remedies: Remedies) -> list[Json]:
    """Return the remedies that help, with what to copy, and the line of the file that they change."""
    return [_remedy_json(remedy) for remedy in remedies.in_order()]


def _remedy_json(remedy: OtherNumber | MoreFriction | StrongerJoints | HeavierBrick) -> Json:
    if isinstance(remedy, StrongerJoints):
        return {"text": stronger_text(remedy), "now": "", "copy": f"{remedy.factor:.4g}", "file": "", "line": 0}
    if isinstance(remedy, MoreFriction):
        text = friction_text(remedy).replace(">=", "≥")
        return {"text": text, "now": "", "copy": f"{remedy.coefficient:.4g}", "file": "", "line": 0}
    if isinstance(remedy, HeavierBrick):
        text = counterweight_text(remedy)
        return {"text": text, "now": "", "copy": text, "file": "", "line": 0}
    number, bound = remedy.number, remedy.limit
    new = number.text(bound.value)
    text = f"{number.name} {'≥' if bound.least else '≤'} {new}"
    now, where = f"now {number.text(number.number)}", {"file": number.span.file, "line": number.span.line}
    if number.span.key:  # in a program, not in the file of the scenario
        now, where = f"{now}, {number.span}", {"file": "", "line": 0}
    return {"text": text, "now": now, "copy": new, **where}
