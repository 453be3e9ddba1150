"""What to say of a thrown brick that passed through another one."""

from collections.abc import Iterable, Iterator

from stackdsl.outcome import VariantResult
from stackdsl.trace import Passed
from stackdsl.wording import mm


def passed_text(passed: Passed) -> str:
    """Which through which, why, and what that leaves in doubt."""
    seen = (
        f"{passed.brick} passed through {passed.through} by {passed.time:.3f} s, {mm(passed.travel)} from look to look"
    )
    why = "the engine's steps are too long for that speed"
    return f"{seen}: {why}, and what the hit does is not to be trusted; throw it more slowly, or play it on `exact`"


def passed_through(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run in which that happened."""
    for result in results:
        if result.passed_through is not None:
            yield f"{result.name}: {passed_text(result.passed_through)}"
