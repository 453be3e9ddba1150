"""Explains assertions on results by the lines of the reports, where pytest would cut the text of the value."""

from collections.abc import Iterator

import pytest

from stability.notebook import display_of
from stackdsl.api.run import Run
from stackdsl.results import ClaimOutcome, GoldenResult

HEAD = 60  # [characters] of the text of a value that identify it in a message, before pytest cuts it
TRUTH = ("assert ", "assert False\n +  where False = ")  # before the value in `assert value` and `assert value.passed`


def explain(failure: pytest.ExceptionInfo[BaseException]) -> str:
    """Put the lines of the asserted result into the message of a failed assertion; return a line for the summary.

    The summary is empty, and the message unchanged, if the assertion is not about the truth of one result.
    """
    message = str(failure.value)
    for value in _false_results(failure):
        for before in TRUTH:
            own, found, _ = message.partition(before + repr(value)[:HEAD].replace("\n", "\\n"))
            if found:
                display = display_of(value)
                head = f"assert <{display.word}: {display.title}>"
                failure.value.args = ("\n".join([own + head, *display.text.splitlines()[1:]]),)
                told = [f"{label} {text}" for label, text in display.lines if label in ("expected", "measured")]
                return own.strip() or ", ".join(told) or head
    return ""


def _false_results(failure: pytest.ExceptionInfo[BaseException]) -> Iterator[Run | ClaimOutcome | GoldenResult]:
    """Yield the false results in reach of the assertion; pytest keeps values of an expression in local variables."""
    frame = failure.traceback[-1].frame
    for value in (*frame.f_locals.values(), *frame.f_globals.values()):
        if isinstance(value, Run):
            if not all(value.outcomes):  # `bool(run)` would warn of a run without claims
                yield value
        elif isinstance(value, ClaimOutcome | GoldenResult) and not value:
            yield value
