"""How far bricks moved, and how energy went."""

from math import dist, inf

from stability.geometry.rotations import turn_between
from stackdsl.judging.finding import MILLIMETRES, PERCENT, Finding, mm, placed, remaining, within
from stackdsl.language.claims import Displaced, Drift, EnergyChange, Untouched
from stackdsl.trace import BrickState, BrickTrack, Trace

EXACTLY = 1e-9  # [m] and [rad]: more than a pose loses on its way into an engine and back


def displaced(claim: Displaced, trace: Trace) -> Finding:
    """How many bricks moved by so much."""
    count = sum(claim.by.holds(track.shift) for track in placed(trace))
    return within(claim.bricks, count, "bricks", f"{count} bricks")


def drift(claim: Drift, trace: Trace) -> Finding:
    """The largest shift of a brick."""
    named = frozenset(trace.tracks if claim.bricks is None else claim.bricks)
    meant = [track for track in placed(trace) if track.brick.id in named]
    worst = max(meant, key=lambda track: track.shift, default=None)
    if worst is None:
        return Finding("never placed", 0.0, "mm", passed=False)
    return within(claim.within, worst.shift, "mm", f"{mm(worst.shift)} ({worst.brick.id})")


def untouched(claim: Untouched, trace: Trace) -> Finding:
    """Whether bricks are exactly where they came to rest, at the end."""
    apart = frozenset(claim.except_ or ())
    meant = [
        track
        for _, track in remaining(trace)
        if track.brick.id not in apart
        and (claim.bricks is None or track.brick.id in claim.bricks)
        and (claim.levels is None or track.level <= claim.levels)
    ]
    if not meant or any(track.state is BrickState.UNPLACED for track in meant):
        return Finding("never placed", 0.0, "mm", passed=False)
    moved = [track for track in meant if not _is_where_it_was(track)]
    if not moved:
        return Finding(f"{len(meant)} bricks are where they were", inf, "", passed=True)
    worst = max(moved, key=_moved_by)
    measured = f"{len(moved)} of {len(meant)} bricks moved, {worst.brick.id} by {mm(_moved_by(worst))}"
    return Finding(measured, -MILLIMETRES * _moved_by(worst), "mm", passed=False)


def _is_where_it_was(track: BrickTrack) -> bool:
    return _moved_by(track) <= EXACTLY and turn_between(track.rest, track.final) <= EXACTLY


def _moved_by(track: BrickTrack) -> float:
    return dist(track.rest.position_W, track.final.position_W)


def energy(claim: EnergyChange, trace: Trace) -> Finding:
    """How much kinetic + potential energy rose after the last action, of the potential energy above the ground then."""
    if trace.energy is None:
        return Finding("nothing was placed", -inf, "%", passed=False)
    return within(claim.gain, trace.energy.gain, "%", f"gain {PERCENT * trace.energy.gain:.3g} %")
