"""What is known of a case before anybody plays it: from the scenario's `truth`, or else from exact statics."""

from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf

from stability.problem import Stability
from stackdsl.judging.proofs import proofs_of, stands_until
from stackdsl.language.schema import Scenario
from stackdsl.language.tolerances import Tolerance
from stackdsl.timeline import Timeline, leaves_to_engine


class Source(StrEnum):
    """Where an answer comes from."""

    TRUTH = "truth"
    STATICS = "exact statics"
    CONVERGED = "converged runs"  # of a bare engine at its finest time steps


@dataclass(frozen=True, slots=True)
class Answer:
    """Whether it stands, and if not, at which level it falls."""

    stands: bool
    source: Source
    least: float = -inf  # level under construction when it falls
    most: float = inf
    earliest: float = -inf  # when it has fallen [s]
    latest: float = inf
    undisturbed: bool = False  # as nothing is dropped, thrown or pushed, nothing should move that does not fall

    def levels_off(self, fell_at: float | None, levels: int) -> float:
        """How many levels a run is off that fell at this one, or not at all, of a structure of so many."""
        reached = levels + 1.0 if fell_at is None else fell_at
        if self.stands:
            return levels + 1.0 - reached
        return max(0.0, self.least - reached, reached - self.most if self.most < inf else 0.0)

    @property
    def still(self) -> bool:
        """Whether nothing of it should move at all."""
        return self.stands and self.undisturbed

    @property
    def timed(self) -> bool:
        """Whether it is known when it falls."""
        return self.latest < inf

    def seconds_off(self, fell_after: float) -> float:
        """How much too early or too late a collapse is seen [s]."""
        return max(0.0, self.earliest - fell_after, fell_after - self.latest)


def answer_of(scenario: Scenario, timeline: Timeline) -> Answer | None:
    """The answer, if anything but a run can give one."""
    answer, moves = _from_truth(scenario), any(leaves_to_engine(action) for action in timeline.as_set_down().actions)
    if answer is None and not moves:
        answer = _from_statics(timeline)
    return replace(answer, undisturbed=not moves) if answer is not None else None


def _from_truth(scenario: Scenario) -> Answer | None:
    """A collapse that is known outweighs what is known to stand beside it."""
    outcomes = [truth.content.implied_outcome for truth in scenario.truth if truth.content.implied_outcome is not None]
    outcome = max(outcomes, key=lambda outcome: outcome.seen, default=None)
    return (
        None if outcome is None else Answer(outcome.stands, Source.TRUTH, *_ends(outcome.level), *_ends(outcome.time))
    )


def _ends(tolerance: Tolerance | None) -> tuple[float, float]:
    return (-inf, inf) if tolerance is None else (tolerance.low, tolerance.high)


def _from_statics(timeline: Timeline) -> Answer | None:
    """Of what is only built, and pulled out."""
    if stands_until(timeline, timeline.end):
        return Answer(True, Source.STATICS)
    proofs = proofs_of(timeline)
    if proofs.assembly.verdict().stability is not Stability.UNSTABLE:
        return None
    there = proofs.assembly.bricks
    level = float(max((p.level for p in timeline.placements if p.brick.id in there), default=1))
    return Answer(False, Source.STATICS, level, level)
