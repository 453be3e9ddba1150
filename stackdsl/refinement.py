"""What of a run moves when it is played again at half the step and twice the iterations? That much was the solver's."""

from dataclasses import dataclass, replace

from stackdsl.observations import Change, changes, observations
from stackdsl.trace import Trace

REMOVED = "at half the step and twice the iterations it stands"


@dataclass(frozen=True, slots=True)
class Refinement:
    """A run, and each of its observations beside the same of the refined run; none where no step was taken."""

    trace: Trace
    changes: tuple[Change, ...] = ()


def held_against_refined(trace: Trace, fine: Trace) -> Refinement:
    """The run and its changes; a collapse that is gone with refined settings is marked as numerical."""
    if trace.collapse is not None and fine.collapse is None:
        trace = replace(trace, numerical=", and ".join(filter(None, [trace.numerical, REMOVED])))
    return Refinement(trace, changes(observations(trace), observations(fine)))
