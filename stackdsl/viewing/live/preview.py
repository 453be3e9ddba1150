"""What a case comes to before it is played: what is built, and what statics says of it. No engine is asked.

Each structure is judged once, as it is set down, up to the first that is not proven to stand. What is dropped, thrown,
pushed or shaken, and all that comes after it, has to be played.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile
from math import inf

from stability.model import BodyId, BodyState
from stackdsl.checking.gathering import Case
from stackdsl.outcome import RunStatus, VariantResult
from stackdsl.recording.recorder import Recorder
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.modification import as_played
from stackdsl.timeline import Placement, Removal, Timeline, leaves_to_engine
from stackdsl.trace import BrickState, BrickTrack, Cost, Event, EventKind, Trace
from stackdsl.viewing.run_view import RunView, view_of
from stackdsl.viewing.shown_proofs import ShownProofs, shown_proofs


def preview_of(case: Case) -> RunView:
    """A run in which everything stays where it is set down, up to what is not proven to stand."""
    timeline = as_played(case.timeline, system_named(case.system).modification)
    timeline = replace(timeline, actions=tuple(takewhile(lambda a: not leaves_to_engine(a), timeline.actions)))
    proofs = shown_proofs(timeline, _trace(timeline, set()), names_smallest=False)
    last = proofs.fall.time if proofs.fall is not None else _end(proofs, timeline)
    shown = replace(timeline, actions=tuple(action for action in timeline.actions if action.time <= last))
    proven = {name for proof in proofs.standing for name in proof.bricks}
    unplayed = VariantResult(case.identity.scenario, case.identity.variant, case.system, case.file, RunStatus.NOT_RUN)
    run = view_of(replace(case, timeline=shown), _trace(shown, proven), _recorded(shown).recording(), unplayed, proofs)
    return replace(run, timeline=shown, verdict=_verdict(proofs, timeline))


def _end(proofs: ShownProofs, timeline: Timeline) -> float:
    """When that which is not proven to stand is set down, or the last thing [s]."""
    end = proofs.standing[-1].end if proofs.standing else 0.0
    return min(end, max((action.time for action in timeline.actions), default=0.0))


def _verdict(proofs: ShownProofs, timeline: Timeline) -> str:
    if proofs.fall is not None:
        return "proven to fall; how is being played"
    whole = bool(timeline.actions) and bool(proofs.standing) and proofs.standing[-1].end == inf
    return "proven to stand; what comes of it is being played" if whole else "being played"


def _trace(timeline: Timeline, proven: set[BodyId]) -> Trace:
    """Everything as it is set down."""
    tracks = {
        placement.brick.id: BrickTrack(
            placement.brick,
            placement.level,
            BrickState.UNWATCHED,
            placed=placement.pose,
            rest=placement.pose,
            final=placement.pose,
            shift=0.0,
            tilt=0.0,
            frozen=placement.brick.id in proven,
        )
        for placement in timeline.placements
    }
    end = max((action.time for action in timeline.actions), default=0.0)
    cost = Cost(wall_time=0.0, simulated_time=end, steps=0, judgements=0)
    return Trace(tuple(_events(timeline, proven)), tracks, (), None, cost, {}, timeline.world)


def _events(timeline: Timeline, proven: set[BodyId]) -> Iterator[Event]:
    for moment in timeline.moments():
        if isinstance(moment, Removal):
            yield Event(moment.time, EventKind.REMOVED, moment.bricks)
        elif isinstance(moment, tuple):
            names = tuple(placement.brick.id for placement in moment)
            yield Event(moment[0].time, EventKind.PLACED, names)
            if proven.issuperset(names):
                yield Event(moment[0].time, EventKind.FROZEN, names, "proven to stand")


def _recorded(timeline: Timeline) -> Recorder:
    recorder = Recorder()
    for action in timeline.actions:
        if isinstance(action, Placement):
            recorder.add(action.time, action.brick, BodyState(action.pose))
        elif isinstance(action, Removal):
            recorder.remove(action.time, action.bricks)
    return recorder
