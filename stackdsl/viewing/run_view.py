"""All that can be seen of one run: what was asked, what happened, where everything was, and what was proven of it."""

from collections.abc import Mapping
from dataclasses import dataclass

from stability.model import BodyId
from stackdsl.checking.gathering import Case
from stackdsl.compiling.compiler import places_of
from stackdsl.diagnostics import Span
from stackdsl.outcome import VariantResult
from stackdsl.recording.recording import Recording
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.modification import as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import Trace
from stackdsl.viewing.shown_proofs import ShownProofs, shown_proofs


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


def view_of(case: Case, trace: Trace, recording: Recording, result: VariantResult) -> RunView:
    """What is to be seen of a case that was played."""
    timeline = as_played(case.timeline, system_named(case.system).modification)
    return RunView(
        case.name,
        case.system,
        case.scenario.description or "",
        timeline,
        trace,
        recording,
        result,
        shown_proofs(timeline, trace),
        places_of(case.scenario, case.source),
    )
