"""What of a run is the solver's: a collapse that statics disprove, and all that a finer resolution moves."""

from dataclasses import dataclass, replace

from stability.statics.facts import Stability
from stackdsl.observations import Change, changes, observations
from stackdsl.systems.modification import as_played
from stackdsl.systems.systems import Method, System
from stackdsl.timeline import Timeline
from stackdsl.trace import Collapse, Trace

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
