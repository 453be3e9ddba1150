"""One expectation as one line: what was expected, what was measured, and how far that is from the threshold.

And what is told of a run of which nothing is expected.
"""

from math import isfinite

from stackdsl.outcome import Outcome, VariantResult
from stackdsl.wording import level_text

TO_CLAIM = "say under `expect` what is to come of it, such as `- stands: all` or `- collapses: any`"


def outcome_text(outcome: Outcome) -> str:
    """Without a place and without a verdict."""
    margin = f" (margin {significant(outcome.margin)} {outcome.unit}".rstrip() + ")" if isfinite(outcome.margin) else ""
    return f"{outcome.name}: expected {outcome.expected}, measured {outcome.measured}{margin}"


def unchecked_text(result: VariantResult) -> str:
    """That nothing is expected of a run, and whether it fell all the same."""
    if result.ensemble is not None:
        return f"nothing is expected of it; {result.ensemble.summary}"
    if result.collapse is None:
        return "nothing is expected of it"
    fell = result.collapse
    where = level_text(fell.level, fell.step)
    return f"it fell at {where}, {fell.brick} at {fell.time:.3f} s, and nothing is expected of it"


def significant(value: float) -> str:
    """Three significant digits, without an exponent where there can be none."""
    return f"{float(f'{value:.3g}') + 0.0:g}"  # a zero has no sign
