"""Trace -> outcomes: judges each claim, with the margin to its threshold."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from stability.model import BodyId
from stability.name_order import in_order, names_text
from stability.problem import Stability
from stackdsl.goldens.snapshot import unclear_falls
from stackdsl.judging.before_impacts import falls_before_impacts
from stackdsl.language.claims.claim import Claim
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.claim_result import ClaimResult
from stackdsl.language.schema import Scenario
from stackdsl.language.variants import Variant, repeated
from stackdsl.language.yaml.source import KeyPath, Plain, Source
from stackdsl.results import Change, ClaimOutcome, changes, observations
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import StopCondition, never_stop_early
from stackdsl.simulation.systems import Method, System, as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import NOT_MODELLED, UNRELIABLE, Collapse, Ensemble, Trace
from stackdsl.wording import energy_fault

if TYPE_CHECKING:
    from stackdsl.judging.statistics import Decision


# Fails claims that bricks still moving at the end of the run may change.


def moving_for(claim: ClaimKind, trace: Trace) -> Sequence[BodyId]:
    """Return the moving bricks that could change the result of a claim.

    A fallen brick stays fallen, and one that only rocks in place does not bring down others.
    """
    return [name for name in trace.moving if not (claim.only_falls and name in trace.rocking)]


def may_still_change(claim: ClaimKind, trace: Trace) -> bool:
    """Return whether bricks that still move could change the result of a claim."""
    may_change = moving_for(claim, trace) or trace.unsettled
    return bool(may_change) and not claim.final_once_watched and not claim.is_decided(trace)


def still_moving(claim: ClaimKind, result: ClaimResult, trace: Trace) -> ClaimResult:
    """Return the result as failed, with the bricks that still move, and how to judge it."""
    reasons = []
    if moving := moving_for(claim, trace):
        reasons.append(f"still moving when the simulation ended: {names_text(in_order(moving), among=trace.tracks)}")
    if slow := [track for track in trace.unsettled if track.brick.id not in trace.moving]:
        causes = dict.fromkeys(track.gives_way or "not at rest" for track in slow)
        named = names_text([track.brick.id for track in slow], among=trace.tracks)
        reasons.append(f"not settled when the simulation ended: {named}: {'; '.join(causes)}")
    watched = trace.cost.simulated_time - max(trace.last_action, trace.last_arrival)  # [s]
    seconds = max(1, round(watched))
    advice = f"simulate longer, for example with `watch: {2 * seconds} s`"
    if hasattr(claim, "for_"):
        advice += f", or judge only this time with `for: {seconds} s`"
    return ClaimResult(
        f"{result.measured}; {'; '.join(reasons)}; {advice}", -inf, "", passed=False, numbers=result.numbers
    )


def not_modelled(result: ClaimResult, trace: Trace) -> ClaimResult:
    """Return the result as failed, since the motion after a brick has crushed is not modelled."""
    text = trace.crushing.text if trace.crushing is not None else ""
    cause = text if result.measured != text else ""
    measured = "; ".join(filter(None, [result.measured, cause, NOT_MODELLED]))
    return ClaimResult(measured, -inf, "", passed=False, numbers=result.numbers)


# Numerical effects in a run: a collapse that statics disproves, and changes at a finer resolution.


REMOVED = "at half the step and twice the iterations it stands"


@dataclass(frozen=True, slots=True)
class Refinement:
    """A run, and the changes of its observations in the refined run; none if the engine took no step."""

    trace: Trace
    changes: tuple[Change, ...] = ()


def with_numerical_collapse(trace: Trace, timeline: Timeline, system: System) -> Trace:
    """Return the trace, with its collapse marked as numerical if statics of the scene as played disprove it.

    `exact` is skipped: it lets bricks fall only by a proof.
    """
    if trace.collapse is None or system.method is Method.PROVEN:
        return trace
    from stackdsl.judging.proofs import compare_with_statics  # noqa: PLC0415 -- statics brings numpy

    return compare_with_statics(trace, as_played(timeline, system.modification))


def compare_with_refined(trace: Trace, fine: Trace, timeline: Timeline) -> Refinement:
    """Return the run and its changes; mark a collapse as numerical if it does not occur with refined settings.

    A collapse that statics prove is not marked: then the refined run is wrong, or too slow to show it.
    """
    if trace.collapse is not None and fine.collapse is None and not _proven_to_fall(timeline, trace.collapse):
        trace = replace(trace, numerical=", and ".join(filter(None, [trace.numerical, REMOVED])))
    return Refinement(trace, changes(observations(trace), observations(fine)))


def _proven_to_fall(timeline: Timeline, collapse: Collapse) -> bool:
    from stackdsl.judging.proofs import verdict_until  # noqa: PLC0415 -- statics brings numpy

    return verdict_until(timeline, collapse.time).stability is Stability.UNSTABLE


# Fails claims that depend on motion to which the engine has added energy.


def depends_on_energy_fault(claim: ClaimKind, trace: Trace) -> bool:
    """Return whether the result of a claim may depend on energy that the engine added."""
    before = trace.before_fault
    if before is None or claim.measures_engine:
        return False
    nothing_follows = before.collapse is not None or not before.undone
    return not (nothing_follows and claim.is_decided(before))


def unreliable(result: ClaimResult, trace: Trace) -> ClaimResult:
    """Return the result as failed, with the energy that the engine added."""
    measured = f"{result.measured}; {UNRELIABLE}: {energy_fault(trace.energy_gained)}"
    return ClaimResult(measured, -inf, "", passed=False, numbers=result.numbers)


# Trace -> outcomes: one outcome per claim.


def judge(trace: Trace, scenario: Scenario, variant: Variant, source: Source, system: str) -> tuple[ClaimOutcome, ...]:
    """Return the outcome of every expectation that applies to this system, in the order of the file.

    The last outcome is a failure if bricks fell before the first impact and no claim expects that.
    """
    expectations = [
        (("expect", number), claim) for number, claim in expected_of(scenario, system) if _of_one_run(claim)
    ]
    expected = [claim.content for claim in (*(claim for _, claim in expectations), *scenario.truth)]
    outcomes = _outcomes(expectations, trace, variant, source)
    # Before the end of the build, a proof decides what falls; the rest of a fall after a hit is chaotic.
    after_build = trace.collapse is not None and bool(trace.collapse.fallen)
    if after_build and any(claim.content.rests_on_fate_of(trace) for _, claim in expectations):
        unclear = unclear_falls(trace, system_named(system).extension)
        shared = [len(unclear.intersection(claim.content.rests_on_fate_of(trace))) for _, claim in expectations]
        outcomes = tuple(replace(each, unclear=count) for each, count in zip(outcomes, shared, strict=True))
    return (*outcomes, *falls_before_impacts(trace, expected, scenario, source))


def expected_of(scenario: Scenario, system: str) -> Sequence[tuple[int, Claim]]:
    """Return the expectations that apply to a system, with their numbers.

    Claims that need statics are left out for a system without proofs, as peers also run scenarios written for `exact`.
    """
    proves = system_named(system).method is Method.PROVEN
    return [
        (number, claim)
        for number, claim in enumerate(scenario.expect)
        if (claim.system is None or system in claim.system) and (proves or not claim.content.needs_statics)
    ]


def judge_shares(
    ensemble: Ensemble, scenario: Scenario, variant: Variant, source: Source, system: str
) -> tuple[tuple[ClaimOutcome, ...], tuple[ClaimOutcome, ...], tuple["Decision", ...]]:
    """Judge the shares of many samples: return outcomes of `expect`, outcomes of `truth`, decisions on `expect`.

    The decisions tell the caller whether more samples are needed; see `stackdsl.judging.statistics`.
    """
    from stackdsl.judging.statistics import judge_share  # noqa: PLC0415 -- it brings scipy, and few scenarios have samples

    expected = [(("expect", number), claim) for number, claim in expected_of(scenario, system)]
    truth = [(("truth", number), claim) for number, claim in enumerate(scenario.truth)]
    outcomes, decisions = [], []
    for path, claim in (*expected, *truth):
        result, decision = judge_share(claim.content, ensemble, scenario.confidence)
        outcomes.append(_outcome(path, claim, result, variant, source))
        decisions.append(decision)
    count = len(expected)
    return tuple(outcomes[:count]), tuple(outcomes[count:]), tuple(decisions[:count])


def compare_with_truth(trace: Trace, scenario: Scenario, variant: Variant, source: Source) -> tuple[ClaimOutcome, ...]:
    """Return the outcomes of the claims of `truth`; those that need statics are skipped if the run has no verdict."""
    claims = [
        (("truth", number), claim)
        for number, claim in enumerate(scenario.truth)
        if _of_one_run(claim) and (trace.statics is not None or not claim.content.needs_statics)
    ]
    return _outcomes(claims, trace, variant, source)


def _of_one_run(claim: Claim) -> bool:
    """Return whether a claim is about one run rather than about a share of samples."""
    return claim.content.wanted_share is None


def _outcomes(
    claims: Sequence[tuple[KeyPath, Claim]], trace: Trace, variant: Variant, source: Source
) -> tuple[ClaimOutcome, ...]:
    return tuple(_outcome(path, claim, _result(claim.content, trace), variant, source) for path, claim in claims)


def _outcome(path: KeyPath, claim: Claim, result: ClaimResult, variant: Variant, source: Source) -> ClaimOutcome:
    kind = claim.kind
    place = (*path, kind)
    expected = as_written(repeated(_at(source.values, place), _at(variant.values, place)))
    span = source.key_span_of(place)
    return ClaimOutcome(
        kind,
        expected,
        result.measured,
        result.margin,
        result.unit,
        result.passed,
        span,
        result.numbers,
        moved=result.moved,
    )


def _result(claim: ClaimKind, trace: Trace) -> ClaimResult:
    if trace.numerical and claim.requires_physical_collapse:
        return _numerical(trace)
    result = claim.judge(trace)
    if depends_on_energy_fault(claim, trace):
        return unreliable(result, trace)
    if not may_still_change(claim, trace):
        return result
    return not_modelled(result, trace) if trace.crushing is not None else still_moving(claim, result, trace)


def _numerical(trace: Trace) -> ClaimResult:
    """Return the failed result of a claim about a collapse that only the solver caused."""
    return ClaimResult(f"a numerical collapse: {trace.numerical}", -inf, "", passed=False)


def _at(values: Plain, path: KeyPath) -> Plain:
    for step in path:
        values = values[step]  # type: ignore[index]  # the path of a validated claim
    return values


def as_written(value: Plain) -> str:
    """Return a value of the file as one line, without brackets."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {as_written(part)}" for key, part in value.items())
    if isinstance(value, list):
        return " ".join(as_written(part) for part in value)
    return str(value)


# Stop condition of a run: every claim is decided. Each kind of claim knows when later events cannot change it.


@dataclass(frozen=True, slots=True)
class AllDecided:
    """Stop condition: no later event can change the result of any of these claims; pickled with a run."""

    claims: tuple[ClaimKind, ...]

    def __call__(self, trace: Trace) -> bool:
        """Return whether all claims are decided by a run so far that has collapsed."""
        return all(claim.is_decided(trace) for claim in self.claims)


def stop_condition_of(scenario: Scenario, system: str) -> StopCondition:
    """Return the stop condition of a run on a system: all claims of `expect` and `truth` are decided.

    A scenario without expectations never stops early.
    """
    expected = [claim.content for _, claim in expected_of(scenario, system) if claim.content.wanted_share is None]
    if not expected:
        return never_stop_early
    proves = system_named(system).method is Method.PROVEN
    compared = [claim.content for claim in scenario.truth if proves or not claim.content.needs_statics]
    compared = [claim for claim in compared if claim.wanted_share is None]
    return AllDecided((*expected, *compared))
