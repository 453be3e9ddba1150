"""Is all known that is asked of a run? Each kind of claim says itself when nothing that may still happen changes it."""

from dataclasses import dataclass

from stackdsl.judging.judge import expected_of
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.schema import Scenario
from stackdsl.playing.ending import Known, nothing_is_known
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.systems import Method
from stackdsl.trace import Trace


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
        return nothing_is_known
    proves = system_named(system).method is Method.PROVEN
    compared = [claim.stated for claim in scenario.truth if proves or not claim.stated.needs_statics]
    compared = [stated for stated in compared if stated.wanted_share is None]
    return AllKnown((*expected, *compared))
