"""Explains an unexpected result: the proof, the last action before it, and the first motion."""

import shlex
from collections.abc import Iterator, Sequence

from stability.name_order import in_order, names_text
from stability.problem import Placed, Stability, Verdict
from stability.stabilizers.approach import IMMINENT, as_hit
from stability.statics.fall_description import FallSide, fall_side
from stackdsl.checking.cases import STDIN_SHOWN, Case
from stackdsl.compiler.compile import origin_of
from stackdsl.judging.before_impacts import EARLY, proof_of_fall, woken_before
from stackdsl.results import FailureCause
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.timeline import (
    Action,
    Arrival,
    HoldAction,
    JointChange,
    JointsAction,
    LoadsAction,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
    time_of_arrival,
)
from stackdsl.trace import BrickState, Event, EventKind, RunVerdict, Trace
from stackdsl.wording import apart_text, clock, joints_text, mm, moving_text, shaking_text, touching_text, weakest_text

NOTICED = 1e-6  # [m] smaller shifts are not reported as motion
ARRIVALS = {
    Arrival.SET_DOWN: "set down",
    Arrival.SLID_IN: "slid in",
    Arrival.BY_HAND: "placed by hand",
    Arrival.LET_GO: "released",
    Arrival.DROPPED: "dropped",
    Arrival.THROWN: "thrown",
}


def failure_cause_of(case: Case, trace: Trace) -> FailureCause:
    """Return the explanation of a run."""
    woken = woken_before(trace)
    verdict = proof_of_fall(trace, woken)
    side = FallSide()
    if verdict is not None:
        side = fall_side(verdict, {name: Placed(track.brick, track.rest) for name, track in trace.tracks.items()})
    limit = _limit_of_margins(case, trace)
    return FailureCause(
        cause=limit or _cause(trace, verdict, woken),
        moving=tuple(in_order(verdict.moving)) if verdict is not None else (),
        bearing=side.bearing,
        overhang=side.overhang,
        before="" if limit else _before(case, trace, woken),
        first="" if limit else _first(trace),
        see=_see(case, proven=verdict is not None or trace.collapse is None),
    )


def _limit_of_margins(case: Case, trace: Trace) -> str:
    """Return the weakest spot of what stands, by which a claim on its margins fails; empty without such a claim."""
    margins = trace.margins
    if trace.verdict is not RunVerdict.STANDS or not case.timeline.margins:
        return ""
    if margins.weakest is not None:
        return "; ".join([weakest_text(margins.weakest), *([apart_text(margins.apart)] if margins.apart else [])])
    return margins.yields or joints_text(margins.joints)


def _see(case: Case, proven: bool) -> str:
    """Return a shell command that shows the proof if there is one, else the run; without one, a call in Python."""
    if not case.is_in_file:
        return "print(run.cause)"
    explains = proven and system_named(case.system).method is Method.PROVEN
    # A path with a leading dash would be read as an option.
    file = f"./{case.file}" if case.file.startswith("-") else "-" if case.file == STDIN_SHOWN else case.file
    system = [] if case.system in case.scenario.systems else ["--system", case.system]
    return shlex.join(["stackdsl", "explain" if explains else "run", file, *system, "-k", case.name])


def _cause(trace: Trace, verdict: Verdict | None, woken: Event | None) -> str:
    if trace.collapse is None:
        if trace.statics is None:
            return ""
        stands = trace.statics.stability is Stability.STABLE
        displaced = sum(track.state is BrickState.DISPLACED for track in trace.tracks.values())
        if stands and displaced:
            hits = [event for event in trace.events if event.kind is EventKind.HIT]
            causes = hits or [event for event in trace.events if event.kind is EventKind.WOKEN and event.reason][-1:]
            cause = f": {'; '.join(event.reason for event in causes)}" if causes else ""
            return f"none of the bricks fell, and {displaced} of them shifted{cause}"
        standing = f"statics prove that it stands{touching_text(trace.statics.touching_within)}"
        if stands and trace.moving:
            moving = names_text(in_order(trace.moving), among=trace.tracks)
            return f"still moving at the end: {moving}; at rest, {standing}"
        return standing if stands else trace.statics.reason
    if trace.numerical:
        return f"numerical, not physical: {trace.numerical}"
    if verdict is not None:
        return verdict.reason
    return _hit_text(trace, woken) if woken is not None else ""


def _hit_text(trace: Trace, woken: Event) -> str:
    """Return why bricks woke; of bricks that woke ahead of a hit, the hit that followed."""
    if IMMINENT not in woken.reason or trace.collapse is None:
        return woken.reason
    hits = (event for event in trace.events if event.kind is EventKind.HIT)
    during = (event for event in hits if woken.time <= event.time <= trace.collapse.time)
    told = (event.reason for event in during if f"{event.bricks[0]} {IMMINENT}" in woken.reason)
    return next(told, as_hit(woken.reason))


def _before(case: Case, trace: Trace, woken: Event | None) -> str:
    """Return the last action before the falling bricks woke or left their places, or before the end of the run."""
    until = trace.cost.simulated_time
    if trace.collapse is not None:
        until = woken.time if woken is not None else trace.collapse.time
    earlier = [action for action in case.timeline.actions if _effect_time(action) <= until]
    if not earlier:
        return ""
    last = sorted(earlier, key=_effect_time)[-1]  # the last in file order of several at one time
    together = (last,) if not isinstance(last, Placement) else tuple(_placed_together(last, case.timeline))
    origin = origin_of(last, case.scenario, case.source)
    where = f"{origin.part} {origin.number}, {origin.kind} at {origin.span}: " if origin is not None else ""
    return f"{where}{_action_text(together, case.timeline)}"


def _effect_time(action: Action) -> float:
    """Return the time at which an action affects the structure [s]; a flying brick may hit a little before its aim."""
    if isinstance(action, ShakeAction):
        return action.time
    flies = isinstance(action, Placement) and action.hits
    return max(action.time, time_of_arrival(action) - EARLY) if flies else time_of_arrival(action)


def _placed_together(last: Placement, timeline: Timeline) -> Iterator[Placement]:
    """Yield the placements with the time and the kind of arrival of `last`."""
    for placement in timeline.placements:
        if (placement.time, placement.arrival) == (last.time, last.arrival):
            yield placement


def _change_text(change: JointsAction | LoadsAction, bricks: str) -> str:
    at = clock(change.time).strip()
    if isinstance(change, LoadsAction):
        return f"{bricks} loaded at {at}"
    about = bricks if change.change is JointChange.JOINED else f"the joints of {bricks}"
    return f"{about} {change.change.value} at {at}"


def _action_text(together: Sequence[Action], timeline: Timeline) -> str:
    assembly = [placement.brick.id for placement in timeline.placements]
    match together[0]:
        case Removal() as removal:
            return f"{names_text(in_order(removal.bricks), among=assembly)} pulled out at {removal.time:g} s"
        case JointsAction() | LoadsAction() as change:
            return _change_text(change, names_text(in_order(change.bricks), among=assembly))
        case PushAction() as push:
            return f"{push.brick} pushed at {push.time:g} s"
        case ShakeAction() as shake:
            return f"the ground shaken {shaking_text(shake.motion)} from {shake.time:g} s on"
        case MoveAction() as move:
            return f"{move.brick} {moving_text(move.course)} by hand from {move.time:g} s on"
        case HoldAction() as hold:
            return f"{names_text(hold.bricks, among=assembly)} held from {hold.time:g} s on"
        case ReleaseAction() as release:
            return f"{names_text(release.bricks, among=assembly)} released at {release.time:g} s"
        case Placement() as first:
            level = f", level {first.level}" if first.level and len(together) == 1 else ""
            names = [placed.brick.id for placed in together if isinstance(placed, Placement)]
            return f"{names_text(names, among=assembly)} {ARRIVALS[first.arrival]} at {first.time:g} s{level}"


def _first(trace: Trace) -> str:
    if trace.collapse is not None:
        if trace.collapse.crushing is not None:
            return ""  # the reason tells it
        return f"{trace.collapse.brick} fell first: it had {trace.collapse.by} at {trace.collapse.time:.3f} s"
    worst = max(trace.tracks.values(), key=lambda track: track.shift, default=None)
    if worst is None or worst.shift < NOTICED:
        return ""
    return f"{worst.brick.id} shifted most, by {mm(worst.shift, 3)}"
