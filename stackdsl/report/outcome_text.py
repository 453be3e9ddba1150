"""One expectation as one line: what was expected, what was measured, and how far that is from the threshold."""

from math import isfinite

from stackdsl.outcome import Outcome


def outcome_text(outcome: Outcome) -> str:
    """Without a place and without a verdict."""
    margin = f" (margin {significant(outcome.margin)} {outcome.unit}".rstrip() + ")" if isfinite(outcome.margin) else ""
    return f"{outcome.name}: expected {outcome.expected}, measured {outcome.measured}{margin}"


def significant(value: float) -> str:
    """Three significant digits, without an exponent where there can be none."""
    return f"{float(f'{value:.3g}') + 0.0:g}"  # a zero has no sign
