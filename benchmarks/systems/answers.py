"""Known results of a case before any run: from the scenario's `truth`, or otherwise from exact statics."""

from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf

from stability.problem import Stability
from stackdsl.judging.proofs import proofs_of, stands_until
from stackdsl.language.schema import Scenario
from stackdsl.language.tolerances import Tolerance
from stackdsl.timeline import Timeline, leaves_to_engine


class Source(StrEnum):
    """Source of an answer."""

    TRUTH = "truth"
    STATICS = "exact statics"
    CONVERGED = "converged runs"  # of a bare engine at its finest time steps


@dataclass(frozen=True, slots=True)
class Answer:
    """Verdict on a structure: it stands, or it falls at a level."""

    stands: bool
    source: Source
    least: float = -inf  # level under construction at the fall
    most: float = inf
    earliest: float = -inf  # time of the fall [s]
    latest: float = inf
    undisturbed: bool = False  # without drops, throws and pushes, nothing should move before a fall

    def levels_off(self, fell_at: float | None, levels: int) -> float:
        """Return the error in levels of a run that fell at a level, or not at all, in a structure of `levels`."""
        reached = levels + 1.0 if fell_at is None else fell_at
        if self.stands:
            return levels + 1.0 - reached
        return max(0.0, self.least - reached, reached - self.most if self.most < inf else 0.0)

    @property
    def still(self) -> bool:
        """Return whether nothing should move at all."""
        return self.stands and self.undisturbed

    @property
    def timed(self) -> bool:
        """Return whether the time of the fall is known."""
        return self.latest < inf

    def seconds_off(self, fell_after: float) -> float:
        """Return the error of the time of a collapse [s]."""
        return max(0.0, self.earliest - fell_after, fell_after - self.latest)


def answer_of(scenario: Scenario, timeline: Timeline) -> Answer | None:
    """Return the answer if it is known without a run."""
    answer, moves = _from_truth(scenario), any(leaves_to_engine(action) for action in timeline.as_set_down().actions)
    if answer is None and not moves:
        answer = _from_statics(timeline)
    return replace(answer, undisturbed=not moves) if answer is not None else None


def _from_truth(scenario: Scenario) -> Answer | None:
    """Return the answer by `truth`; a known collapse has precedence over standing parts."""
    outcomes = [truth.content.implied_outcome for truth in scenario.truth if truth.content.implied_outcome is not None]
    outcome = max(outcomes, key=lambda outcome: outcome.seen, default=None)
    return (
        None if outcome is None else Answer(outcome.stands, Source.TRUTH, *_ends(outcome.level), *_ends(outcome.time))
    )


def _ends(tolerance: Tolerance | None) -> tuple[float, float]:
    return (-inf, inf) if tolerance is None else (tolerance.low, tolerance.high)


def _from_statics(timeline: Timeline) -> Answer | None:
    """Return the answer by statics, for timelines of placements and removals only."""
    if stands_until(timeline, timeline.end):
        return Answer(True, Source.STATICS)
    proofs = proofs_of(timeline)
    if proofs.assembly.verdict().stability is not Stability.UNSTABLE:
        return None
    there = proofs.assembly.bricks
    level = float(max((p.level for p in timeline.placements if p.brick.id in there), default=1))
    return Answer(False, Source.STATICS, level, level)
