"""Trace -> outcomes: each expectation held against what happened, with the margin to its threshold."""

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING

from stackdsl.ensemble import Ensemble
from stackdsl.judging.before_impacts import fallen_before_impacts
from stackdsl.judging.still_moving import may_still_change, still_moving
from stackdsl.judging.unreliable import hangs_on_fault, unreliable
from stackdsl.language.claims.claim import Claim
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.finding import Finding
from stackdsl.language.schema import Scenario
from stackdsl.language.variants import Variant, repeated
from stackdsl.outcome import Outcome
from stackdsl.reading.source import Path, Plain, Source
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.systems import Method
from stackdsl.trace import Trace

if TYPE_CHECKING:
    from stackdsl.judging.shares import Decision


def judge(trace: Trace, scenario: Scenario, variant: Variant, source: Source, system: str) -> tuple[Outcome, ...]:
    """The outcome of every expectation that speaks of this system, in the order of the file.

    And at the end the failure of what fell before the first impact, if no claim expects that.
    """
    asked = [(("expect", number), claim) for number, claim in expected_of(scenario, system) if _of_one_run(claim)]
    claims = [claim.stated for claim in (*(claim for _, claim in asked), *scenario.truth)]
    return (*_outcomes(asked, trace, variant, source), *fallen_before_impacts(trace, claims, scenario, source))


def expected_of(scenario: Scenario, system: str) -> Sequence[tuple[int, Claim]]:
    """The expectations that speak of a system, by number.

    What only statics can tell is not asked of a system that proves nothing: peers meet scenarios not meant for them.
    """
    proves = system_named(system).method is Method.PROVEN
    return [
        (number, claim)
        for number, claim in enumerate(scenario.expect)
        if (claim.system is None or system in claim.system) and (proves or not claim.stated.needs_statics)
    ]


def judge_shares(
    ensemble: Ensemble, scenario: Scenario, variant: Variant, source: Source, system: str
) -> tuple[tuple[Outcome, ...], tuple[Outcome, ...], tuple["Decision", ...]]:
    """Of many samples, the outcomes of expectations and of what is known from outside.

    And what is decided of the expectations, for whoever asks whether more samples are needed; see `shares`.
    """
    from stackdsl.judging.shares import judged  # noqa: PLC0415 -- it brings scipy, and few scenarios have samples

    expected = [(("expect", number), claim) for number, claim in expected_of(scenario, system)]
    known = [(("truth", number), claim) for number, claim in enumerate(scenario.truth)]
    outcomes, decisions = [], []
    for path, claim in (*expected, *known):
        found, decision = judged(claim.stated, ensemble, scenario.confidence)
        outcomes.append(_told(path, claim, found, variant, source))
        decisions.append(decision)
    cut = len(expected)
    return tuple(outcomes[:cut]), tuple(outcomes[cut:]), tuple(decisions[:cut])


def compare_with_truth(trace: Trace, scenario: Scenario, variant: Variant, source: Source) -> tuple[Outcome, ...]:
    """The same for the answers known from outside; what only statics can tell is passed over where none was asked."""
    asked = [
        (("truth", number), claim)
        for number, claim in enumerate(scenario.truth)
        if _of_one_run(claim) and (trace.statics is not None or not claim.stated.needs_statics)
    ]
    return _outcomes(asked, trace, variant, source)


def _of_one_run(claim: Claim) -> bool:
    """Whether a claim is none of a share of samples: of the design by itself, played once, that says nothing."""
    return claim.stated.wanted_share is None


def _outcomes(
    asked: Sequence[tuple[Path, Claim]], trace: Trace, variant: Variant, source: Source
) -> tuple[Outcome, ...]:
    return tuple(_outcome(path, claim, trace, variant, source) for path, claim in asked)


def _outcome(path: Path, claim: Claim, trace: Trace, variant: Variant, source: Source) -> Outcome:
    return _told(path, claim, _found(claim.stated, trace), variant, source)


def _told(path: Path, claim: Claim, found: Finding, variant: Variant, source: Source) -> Outcome:
    kind = claim.kind
    place = (*path, kind)
    expected = as_written(repeated(_at(source.values, place), _at(variant.values, place)))
    span = source.key_span_of(place)
    return Outcome(kind, expected, found.measured, found.margin, found.unit, found.passed, span, found.numbers)


def _found(stated: ClaimKind, trace: Trace) -> Finding:
    if trace.numerical and stated.of_collapses:
        return _numerical(trace)
    found = stated.judge(trace)
    if hangs_on_fault(stated, trace):
        return unreliable(found, trace)
    return still_moving(found, trace) if may_still_change(stated, trace) else found


def _numerical(trace: Trace) -> Finding:
    """What a claim about a collapse comes to if there was none but the solver's."""
    return Finding(f"a numerical collapse: {trace.numerical}", -inf, "", passed=False)


def _at(values: Plain, path: Path) -> Plain:
    for step in path:
        values = values[step]  # type: ignore[index]  # the path of a claim that was validated
    return values


def as_written(value: Plain) -> str:
    """A value of the file on one line, without the brackets."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {as_written(part)}" for key, part in value.items())
    if isinstance(value, list):
        return " ".join(as_written(part) for part in value)
    return str(value)
