"""Trace -> outcomes: compares each claim with what happened, with the margin to its threshold."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from stability.problem import Stability
from stackdsl.judging.before_impacts import fallen_before_impacts
from stackdsl.language.claims.claim import Claim
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.claim_result import ClaimResult
from stackdsl.language.schema import Scenario
from stackdsl.language.variants import Variant, repeated
from stackdsl.language.yaml.source import KeyPath, Plain, Source
from stackdsl.results import Change, ClaimOutcome, changes, observations
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import Known, never_stop_early
from stackdsl.simulation.systems import Method, System, as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import UNRELIABLE, Collapse, Ensemble, Trace
from stackdsl.wording import energy_fault, how_many, names_text

if TYPE_CHECKING:
    from stackdsl.judging.statistics import Decision


# Fails claims that bricks still moving at the end of the run may change.


def may_still_change(stated: ClaimKind, trace: Trace) -> bool:
    """Whether what still moves could make a claim come out otherwise."""
    return bool(trace.moving or trace.unsettled) and not stated.final_once_watched and not stated.is_decided(trace)


def still_moving(found: ClaimResult, trace: Trace) -> ClaimResult:
    """The finding, with why it is none."""
    why = []
    if count := len(trace.moving):
        why.append(f"still moving at the end of the watch: {how_many(count, 'brick')}")
    if slow := [track for track in trace.unsettled if track.brick.id not in trace.moving]:
        causes = dict.fromkeys(track.gives_way or "it has not come to rest" for track in slow)
        why.append(
            f"not settled at the end of the watch: {names_text([t.brick.id for t in slow])}: {'; '.join(causes)}"
        )
    watched = trace.cost.simulated_time - max(trace.last_action, trace.last_arrival)  # [s]
    advice = f"watch longer, such as `watch: {2 * max(1, round(watched))} s`"
    return ClaimResult(f"{found.measured}; {'; '.join(why)}; {advice}", -inf, "", passed=False, numbers=found.numbers)


# Numerical effects of a run: a collapse that statics disproves, and what a finer resolution changes.


REMOVED = "at half the step and twice the iterations it stands"


@dataclass(frozen=True, slots=True)
class Refinement:
    """A run, and each of its observations beside the same of the refined run; none where no step was taken."""

    trace: Trace
    changes: tuple[Change, ...] = ()


def with_numerical_collapse(trace: Trace, timeline: Timeline, system: System) -> Trace:
    """The trace, its collapse marked where statics of the scene as it is played disprove it.

    What `exact` lets fall is proven to.
    """
    if trace.collapse is None or system.method is Method.PROVEN:
        return trace
    from stackdsl.judging.proofs import held_against_statics  # noqa: PLC0415 -- statics brings numpy

    return held_against_statics(trace, as_played(timeline, system.modification))


def held_against_refined(trace: Trace, fine: Trace, timeline: Timeline) -> Refinement:
    """The run and its changes; a collapse that is gone with refined settings is marked as numerical.

    Not so if what fell is proven to fall: then the refined run is wrong, or too slow to show it.
    """
    if trace.collapse is not None and fine.collapse is None and not _proven_to_fall(timeline, trace.collapse):
        trace = replace(trace, numerical=", and ".join(filter(None, [trace.numerical, REMOVED])))
    return Refinement(trace, changes(observations(trace), observations(fine)))


def _proven_to_fall(timeline: Timeline, collapse: Collapse) -> bool:
    from stackdsl.judging.proofs import verdict_until  # noqa: PLC0415 -- statics brings numpy

    return verdict_until(timeline, collapse.time).stability is Stability.UNSTABLE


# Fails claims that depend on motion to which the engine has added energy.


def hangs_on_fault(stated: ClaimKind, trace: Trace) -> bool:
    """Whether the result of a claim may depend on energy that the engine added."""
    before = trace.before_fault
    if before is None or stated.of_the_engine:
        return False
    nothing_to_come = before.collapse is not None or not before.undone
    return not (nothing_to_come and stated.is_decided(before))


def unreliable(found: ClaimResult, trace: Trace) -> ClaimResult:
    """The finding, with why it is none."""
    measured = f"{found.measured}; {UNRELIABLE}: {energy_fault(trace.energy_gained)}"
    return ClaimResult(measured, -inf, "", passed=False, numbers=found.numbers)


# Trace -> outcomes: each expectation held against what happened, with the margin to its threshold.


def judge(trace: Trace, scenario: Scenario, variant: Variant, source: Source, system: str) -> tuple[ClaimOutcome, ...]:
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
) -> tuple[tuple[ClaimOutcome, ...], tuple[ClaimOutcome, ...], tuple["Decision", ...]]:
    """Of many samples, the outcomes of expectations and of what is known from outside.

    And what is decided of the expectations, for whoever asks whether more samples are needed; see `shares`.
    """
    from stackdsl.judging.statistics import judged  # noqa: PLC0415 -- it brings scipy, and few scenarios have samples

    expected = [(("expect", number), claim) for number, claim in expected_of(scenario, system)]
    known = [(("truth", number), claim) for number, claim in enumerate(scenario.truth)]
    outcomes, decisions = [], []
    for path, claim in (*expected, *known):
        found, decision = judged(claim.stated, ensemble, scenario.confidence)
        outcomes.append(_told(path, claim, found, variant, source))
        decisions.append(decision)
    cut = len(expected)
    return tuple(outcomes[:cut]), tuple(outcomes[cut:]), tuple(decisions[:cut])


def compare_with_truth(trace: Trace, scenario: Scenario, variant: Variant, source: Source) -> tuple[ClaimOutcome, ...]:
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
    asked: Sequence[tuple[KeyPath, Claim]], trace: Trace, variant: Variant, source: Source
) -> tuple[ClaimOutcome, ...]:
    return tuple(_outcome(path, claim, trace, variant, source) for path, claim in asked)


def _outcome(path: KeyPath, claim: Claim, trace: Trace, variant: Variant, source: Source) -> ClaimOutcome:
    return _told(path, claim, _found(claim.stated, trace), variant, source)


def _told(path: KeyPath, claim: Claim, found: ClaimResult, variant: Variant, source: Source) -> ClaimOutcome:
    kind = claim.kind
    place = (*path, kind)
    expected = as_written(repeated(_at(source.values, place), _at(variant.values, place)))
    span = source.key_span_of(place)
    return ClaimOutcome(kind, expected, found.measured, found.margin, found.unit, found.passed, span, found.numbers)


def _found(stated: ClaimKind, trace: Trace) -> ClaimResult:
    if trace.numerical and stated.requires_physical_collapse:
        return _numerical(trace)
    found = stated.judge(trace)
    if hangs_on_fault(stated, trace):
        return unreliable(found, trace)
    return still_moving(found, trace) if may_still_change(stated, trace) else found


def _numerical(trace: Trace) -> ClaimResult:
    """What a claim about a collapse comes to if there was none but the solver's."""
    return ClaimResult(f"a numerical collapse: {trace.numerical}", -inf, "", passed=False)


def _at(values: Plain, path: KeyPath) -> Plain:
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


# Decides whether every claim is decided. Each kind of claim says when later events cannot change it.


@dataclass(frozen=True, slots=True)
class AllKnown:
    """Whether each of some claims comes to what it comes to, whatever else happens; pickled with a run."""

    claims: tuple[ClaimKind, ...]

    def __call__(self, trace: Trace) -> bool:
        """Of a run so far that has collapsed."""
        return all(claim.is_decided(trace) for claim in self.claims)


def known_of(scenario: Scenario, system: str) -> Known:
    """When all is known that is expected of a run on a system, and that is compared with what is known from outside.

    Where nothing is expected, everything is worth seeing.
    """
    expected = [claim.stated for _, claim in expected_of(scenario, system) if claim.stated.wanted_share is None]
    if not expected:
        return never_stop_early
    proves = system_named(system).method is Method.PROVEN
    compared = [claim.stated for claim in scenario.truth if proves or not claim.stated.needs_statics]
    compared = [stated for stated in compared if stated.wanted_share is None]
    return AllKnown((*expected, *compared))
