"""Fails claims that depend on motion to which the engine has added energy."""

from math import inf

from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.finding import Finding
from stackdsl.trace import UNRELIABLE, Trace
from stackdsl.wording import energy_fault


def hangs_on_fault(stated: ClaimKind, trace: Trace) -> bool:
    """Whether the result of a claim may depend on energy that the engine added."""
    before = trace.before_fault
    if before is None or stated.of_the_engine:
        return False
    nothing_to_come = before.collapse is not None or not before.undone
    return not (nothing_to_come and stated.is_decided(before))


def unreliable(found: Finding, trace: Trace) -> Finding:
    """The finding, with why it is none."""
    measured = f"{found.measured}; {UNRELIABLE}: {energy_fault(trace.energy_gained)}"
    return Finding(measured, -inf, "", passed=False, numbers=found.numbers)
