"""All that can be seen of one run: what was asked, what happened, where everything was, and what was proven of it."""

from collections.abc import Mapping
from dataclasses import dataclass

from stability.model import BodyId
from stability.statics.margins.weakest import Weakest
from stackdsl.checking.gathering import Case
from stackdsl.compiling.compiler import places_of
from stackdsl.diagnostics import Span
from stackdsl.judging.margins import MOST_FOR_PROGRAMS, weakest_of
from stackdsl.judging.proofs import proofs_of
from stackdsl.outcome import VariantResult
from stackdsl.recording.recording import Recording
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.modification import as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import UNRELIABLE, Trace
from stackdsl.viewing.shown_proofs import ShownProofs, shown_proofs
from stackdsl.wording import energy_fault


@dataclass(frozen=True)
class RunView:
    """One run, as renderers see it; they compute nothing of what happened."""

    name: str  # what people call the case
    system: str
    description: str
    timeline: Timeline  # as it was played
    trace: Trace
    recording: Recording
    result: VariantResult
    proofs: ShownProofs
    places: Mapping[BodyId, Span]  # of what sets down each brick, in the file
    verdict: str  # in words
    # Of what a golden file tells: what differs from the run beside it, in words, by brick or what else it is of.
    marks: Mapping[str, tuple[str, ...]] | None = None

    @property
    def least_room(self) -> tuple[BodyId, float] | None:
        """The brick of the last structure that is proven to stand whose centre has least room, and how much [m].

        Room is how deep the centre of a brick lies inside what carries it down to the ground, in plan. Of a brick that
        stands by friction alone, or by the weight of others, that says nothing, and it is passed over.
        """
        standing = self.proofs.standing[-1:] if self.proofs.fall is None else ()
        told = [(brick.depth, name) for proof in standing for name, brick in proof.bricks.items()]
        depth, name = min(((depth, name) for depth, name in told if depth is not None), default=(0.0, ""))
        return (name, depth) if name else None

    def weakest(self) -> Weakest | None:
        """Which mechanism of what was built opens first; None where something falls, or is left to an engine.

        That takes seconds, and of more than a few bricks minutes: nothing is told of these.
        """
        bricks = sum(not placement.hits for placement in self.timeline.placements)
        if not self.proofs.standing or self.proofs.fall is not None or bricks > MOST_FOR_PROGRAMS:
            return None
        proofs = proofs_of(self.timeline)
        return weakest_of(proofs.assembly) if sum(len(each.bricks) for each in proofs.judged) == bricks else None


def view_of(
    case: Case, trace: Trace, recording: Recording, result: VariantResult, proofs: ShownProofs | None = None
) -> RunView:
    """What is to be seen of a case that was played; `proofs`, if they are known already."""
    timeline = as_played(case.timeline, system_named(case.system).modification)
    return RunView(
        case.name,
        case.system,
        case.scenario.description or "",
        timeline,
        trace,
        recording,
        result,
        shown_proofs(timeline, trace) if proofs is None else proofs,
        places_of(case.scenario, case.source),
        _told(trace),
    )


def _told(trace: Trace) -> str:
    told, collapse = trace.reported_verdict, trace.collapse
    if told == UNRELIABLE:
        told = f"{UNRELIABLE}, {energy_fault(trace.energy_gained)}: {trace.verdict}"
    return told if collapse is None else f"{told} at level {collapse.level} after {collapse.time:.3f} s"
