"""What stands, what fell, and how high it reaches."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import takewhile
from math import degrees, inf

from stability.model import BodyId
from stability.shapes.in_pose import top_W
from stackdsl.judging.finding import MILLIMETRES, Finding, mm, placed, remaining, within
from stackdsl.language.claims import Collapses, Falls, Height, Leaves, Stands
from stackdsl.trace import COLLAPSE_SHARE_OF_SMALLEST_SIDE, COLLAPSE_TILT, STAND, BrickState, BrickTrack, Trace

MOST_NAMES = 6  # that are written out


def stands(claim: Stands, trace: Trace) -> Finding:
    """Whether bricks are where they came to rest, or were shifted to by a hit."""
    named = frozenset(trace.tracks if claim.bricks is None else claim.bricks)
    meant = [
        track
        for name, track in remaining(trace)
        if (claim.levels is None or track.level <= claim.levels) and name in named
    ]
    missing = [track for track in meant if track.state is BrickState.UNPLACED]
    levels = max((track.level for track in trace.tracks.values()), default=0)
    if claim.levels is not None and levels < claim.levels:
        return Finding(f"only {levels} levels are built", levels - claim.levels, "levels", passed=False)
    if missing:
        why = f"it fell at level {trace.collapse.level}; " if trace.collapse is not None else ""
        return Finding(f"{why}{len(missing)} of {len(meant)} never placed", -len(missing), "bricks", passed=False)
    unsettled = [track.brick.id for track in meant if track.state is BrickState.UNSETTLED]
    if unsettled:
        return Finding(f"{unsettled[0]} has not come to rest", -len(unsettled), "bricks", passed=False)
    if not meant:
        return Finding("all of it was pulled out or thrown", -1, "bricks", passed=False)
    if claim.for_ is not None:  # what falls later is no matter of this claim
        until = max(trace.last_action, trace.last_arrival) + claim.for_
        meant = [track for track in meant if track.left_at is None or track.left_at <= until]
    fallen = sum(track.state is BrickState.FALLEN for track in meant)
    shifted = sum(track.state is BrickState.DISPLACED for track in meant)
    measured = f"{fallen} of {len(meant)} bricks fell" if fallen else f"{len(meant)} bricks stand"
    measured += f", {shifted} of them displaced" if shifted and not fallen else ""
    margin, unit = min((_margin_to_collapse(track) for track in meant), default=(inf, ""))
    return Finding(measured, margin, unit, passed=not fallen)


def _margin_to_collapse(track: BrickTrack) -> tuple[float, str]:
    """How much further a brick may shift, or sink after a hit, or turn if that is closer, before it has collapsed."""
    limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * track.brick.shape.least_thickness
    lost = track.shift if track.sunk is None else track.sunk
    if track.tilt / COLLAPSE_TILT > lost / limit:
        return degrees(COLLAPSE_TILT - track.tilt), "deg"
    return MILLIMETRES * (limit - lost), "mm"


def collapses(claim: Collapses, trace: Trace) -> Finding:
    """Whether something fell, and when, and what first."""
    if trace.collapse is None:
        margin, unit = min(
            (_margin_to_collapse(track) for track in placed(trace)),
            default=(inf, "mm"),
        )
        return Finding("nothing fell", -margin, unit, passed=False)
    level, time, brick = trace.collapse.level, trace.collapse.time, trace.collapse.brick
    parts = [Finding(f"level {level}, {brick} at {time:.3f} s", inf, "", passed=True)]
    if claim.at is not None:
        parts.append(within(claim.at, level, "levels"))
    if claim.time is not None:
        parts.append(within(claim.time, time, "s"))
    if claim.brick is not None:
        parts.append(Finding("", 0.0 if claim.brick == brick else -1.0, "bricks", passed=claim.brick == brick))
    worst = min(parts, key=lambda part: (part.passed, part.margin))
    return Finding(parts[0].measured, worst.margin, worst.unit, all(part.passed for part in parts))


def leaves(claim: Leaves, trace: Trace) -> Finding:
    """How much stands at the end."""
    if claim.levels is not None:
        count = _levels_standing(trace)
        return within(claim.levels, count, "levels", f"{count} levels stand")
    assert claim.bricks is not None  # it is a choice
    count = sum(track.state in STAND for _, track in remaining(trace))
    return within(claim.bricks, count, "bricks", f"{count} bricks stand")


def _levels_standing(trace: Trace) -> int:
    """How many levels, counted from the ground, have all their bricks standing."""
    levels = defaultdict[int, list[bool]](list)
    for _, track in remaining(trace):
        levels[track.level].append(track.state in STAND)
    return sum(1 for _ in takewhile(lambda level: all(levels[level]), sorted(levels)))


def falls(claim: Falls, trace: Trace) -> Finding:
    """Which bricks fell, or how many."""
    fallen = [name for name, track in remaining(trace) if track.state is BrickState.FALLEN]
    measured = f"{_listed(fallen)} fell" if fallen else "nothing fell"
    if claim.count is not None:
        return within(claim.count, len(fallen), "bricks", f"{len(fallen)} bricks fell")
    wrong = set(fallen).symmetric_difference(claim.bricks or ())
    return Finding(measured, -float(len(wrong)), "bricks", passed=not wrong)


def _listed(names: Sequence[BodyId]) -> str:
    more = len(names) - MOST_NAMES
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:MOST_NAMES])} and {more} more"


def height(claim: Height, trace: Trace) -> Finding:
    """How high what stands reaches, or one brick."""
    meant = [track for track in placed(trace) if claim.of in (None, track.brick.id)]
    if not meant:
        return Finding("never placed", 0.0, "mm", passed=False)
    if claim.of is None:
        meant = [track for track in meant if track.state not in (BrickState.FALLEN, BrickState.UNSETTLED)]
    top = max((top_W(track.brick.shape, track.final) for track in meant), default=0.0)
    return within(claim.within, top, "mm", mm(top))
