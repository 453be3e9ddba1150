"""One case played: what a worker does, and what a command does that plays in its own process."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from stability.work_limit import TooMuchWorkError, limited
from stackdsl import work
from stackdsl.judging.judge import Refinement, compare_with_refined, with_numerical_collapse
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import StopCondition, never_stop_early, play
from stackdsl.simulation.systems import System, as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import Event, Trace

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder

MOST_FOR_TOLD_MARGINS = 20  # bricks, of which margins that nothing depends on take some tens of milliseconds

Played = TypeVar("Played")


def play_case(
    timeline: Timeline,
    system: str,
    may_stop: StopCondition = never_stop_early,
    on_event: Callable[[Event], None] = lambda event: None,
    recorder: "Recorder | None" = None,
) -> Trace:
    """What a worker does. The engine is imported there, where a scene needs it, and nowhere before."""
    with _limited(timeline):
        return _played(timeline, system_named(system), may_stop, on_event, recorder)


def _played(
    timeline: Timeline,
    system: System,
    may_stop: StopCondition,
    on_event: Callable[[Event], None],
    recorder: "Recorder | None",
) -> Trace:
    trace = with_numerical_collapse(play(timeline, system, on_event, may_stop, recorder), timeline, system)
    wanted = {*timeline.margins, *(timeline.told_margins if len(trace.tracks) <= MOST_FOR_TOLD_MARGINS else ())}
    if not wanted or trace.statics is None:
        return trace
    from stackdsl.judging.proofs import margins_of  # noqa: PLC0415 -- programs bring numpy

    return replace(trace, margins=margins_of(trace, wanted))


@contextmanager
def _limited(timeline: Timeline) -> Iterator[None]:
    """Limit the work of all proofs of a run. Raises BlockedPlacementError where they take more."""
    try:
        with limited(work.limit()):
            yield
    except TooMuchWorkError as error:
        placements = timeline.placements
        many, first = f"{len(placements)} brick{'s' * (len(placements) != 1)}", placements[0]
        told = f"what is proven of {many} takes too much work: {error}"
        raise BlockedPlacementError(Blocked(first.brick.id, first.time, first.brick.id, 0.0, too_much=told)) from error


def played_or_blocked(playing: Callable[..., Played], *arguments: object) -> Played | Blocked:
    """What a worker does: play, or tell what keeps the run from going on, which is no crash."""
    try:
        return playing(*arguments)
    except BlockedPlacementError as error:
        return error.blocked


def play_refined(timeline: Timeline, name: str, may_stop: StopCondition = never_stop_early) -> Refinement:
    """What a worker does to see what of a run is the solver's; where no step was taken, nothing is."""
    trace = play_case(timeline, name, may_stop)
    if trace.cost.steps == 0:
        return Refinement(trace)
    system = system_named(name).refined()
    try:
        with _limited(timeline):
            fine = with_numerical_collapse(play(timeline, system, may_stop=may_stop), timeline, system)
    except BlockedPlacementError as error:
        raise BlockedPlacementError(replace(error.blocked, refined=True)) from error
    return compare_with_refined(trace, fine, as_played(timeline, system.modification))
