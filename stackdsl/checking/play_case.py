"""Plays one case, in a worker or in the process of a command."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from stability.problem import Stability, Stage
from stability.work_limit import TooMuchWorkError, limited
from stackdsl import work
from stackdsl.checking.micrometre import Nearby, compared, either_side
from stackdsl.judging.judge import Refinement, compare_with_refined, with_numerical_collapse
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import StopCondition, never_stop_early, play
from stackdsl.simulation.systems import System, as_played
from stackdsl.timeline import Timeline
from stackdsl.trace import Event, Trace

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder

MAX_BRICKS_FOR_REPORTED_MARGINS = 20  # with more bricks, margins that no claim needs take more than tens of ms

Played = TypeVar("Played")


def play_case(
    timeline: Timeline,
    system: str,
    may_stop: StopCondition = never_stop_early,
    on_event: Callable[[Event], None] = lambda event: None,
    recorder: "Recorder | None" = None,
) -> Trace:
    """Play a timeline and compute its margins. Imports the engine, which no code before imports."""
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
    tested = with_tests(with_margins(trace, timeline), timeline, system)
    return replace(tested, assembly=None)  # it stays in the process of the run


def with_margins(trace: Trace, timeline: Timeline) -> Trace:
    """Return a trace with the margins of the proof that the claims of a timeline need or report."""
    has_few_bricks = len(trace.tracks) <= MAX_BRICKS_FOR_REPORTED_MARGINS
    margins = {*timeline.margins, *(timeline.reported_margins if has_few_bricks else ())}
    assembly = trace.assembly
    needs_cones = assembly is not None and any(assembly.stage(name) is Stage.CONES for name in assembly.bricks)
    if trace.statics is None or not (margins or needs_cones):
        return trace
    from stackdsl.judging.proofs import fall_apart, margins_of  # noqa: PLC0415 -- imports numpy

    known = margins_of(trace, margins)
    if assembly is not None and known.apart is None and trace.statics.stability is Stability.STABLE:
        with suppress(TooMuchWorkError):  # only a warning depends on it
            known = replace(known, apart=fall_apart(assembly))
    return replace(trace, margins=known)


def with_tests(trace: Trace, timeline: Timeline, system: System) -> Trace:
    """Return a trace with the tests that claims need. A pulse is simulated only if statics leaves its test in doubt."""
    if not timeline.tests or trace.statics is None:
        return trace
    from stackdsl.judging.acceleration_tests import proven_tests, pulse_motion, with_pulse  # noqa: PLC0415 -- likewise
    from stackdsl.simulation.recording import Recorder  # noqa: PLC0415 -- likewise

    results = proven_tests(trace, timeline.tests)
    if results is None:
        return trace
    moved = []
    for result in results:
        pulse = result.test.pulse and not timeline.world.ties  # tied bricks are judged at rest only
        if pulse and result.survived < result.test.acceleration:
            shaken, begins = with_pulse(timeline, result.test)
            again, recorder = play(shaken, system, recorder=(watching := Recorder())), watching
            result = replace(result, motion=pulse_motion(again, recorder.recording(), begins))  # noqa: PLW2901
        moved.append(result)
    return replace(trace, tests=tuple(moved))


@contextmanager
def _limited(timeline: Timeline) -> Iterator[None]:
    """Limit the work of all proofs of a run. Raises BlockedPlacementError beyond the limit."""
    try:
        with limited(work.limit()):
            yield
    except TooMuchWorkError as error:
        placements = timeline.placements
        many, first = f"{len(placements)} brick{'s' * (len(placements) != 1)}", placements[0]
        message = f"the proofs of {many} take too much work: {error}"
        blocked = Blocked(first.brick.id, first.time, first.brick.id, 0.0, too_much=message)
        raise BlockedPlacementError(blocked) from error


def played_or_blocked(playing: Callable[..., Played], *arguments: object) -> Played | Blocked:
    """Call `playing`; return the obstacle if a placement is blocked, which is not a crash."""
    try:
        return playing(*arguments)
    except BlockedPlacementError as error:
        return error.blocked


def play_nearby(timeline: Timeline, name: str, may_stop: StopCondition = never_stop_early) -> Nearby:
    """Play a timeline, and a micrometre to either side. Raises BlockedPlacementError if a run is blocked."""
    runs = [play_case(one, name, may_stop) for one in (timeline, *either_side(timeline))]
    return compared(runs[0], runs[1:])


def play_refined(timeline: Timeline, name: str, may_stop: StopCondition = never_stop_early) -> Refinement:
    """Play a timeline twice, also with refined steps, to detect solver artifacts; once if no step was needed."""
    trace = play_case(timeline, name, may_stop)
    if trace.cost.steps == 0:
        return Refinement(trace)
    system = system_named(name).refined()
    try:
        with _limited(timeline):
            refined = with_numerical_collapse(play(timeline, system, may_stop=may_stop), timeline, system)
    except BlockedPlacementError as error:
        raise BlockedPlacementError(replace(error.blocked, refined=True)) from error
    return compare_with_refined(trace, refined, as_played(timeline, system.modification))
