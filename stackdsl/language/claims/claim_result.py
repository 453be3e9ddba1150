"""What a claim comes to, and whom it may speak of.

A margin is positive inside, negative outside, in the unit of what was measured; where a claim has several parts, the
part closest to failing speaks for it.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import degrees, inf, isfinite

from stability.model import BodyId
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import (
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    NO_PART,
    BrickState,
    BrickTrack,
    Measure,
    Trace,
)
from stackdsl.wording import MILLIMETRES

PERCENT = 100.0
SHOWN_PER_SI = {"mm": MILLIMETRES, "deg": degrees(1.0), "%": PERCENT}  # by the unit of a margin


@dataclass(frozen=True, slots=True)
class ClaimResult:
    """What was measured for one claim, or for one part of it."""

    measured: str
    margin: float
    unit: str
    passed: bool
    numbers: tuple[Measure, ...] = ()  # what of it is a number, with its limits


def remaining(trace: Trace) -> Collection[tuple[BodyId, BrickTrack]]:
    """The structure: all bricks but those that were thrown, pulled out or are to be, of which nothing is expected."""
    gone = trace.gone
    return [(name, track) for name, track in trace.tracks.items() if track.state not in NO_PART and name not in gone]


def placed(trace: Trace) -> Collection[BrickTrack]:
    """Those of the structure that were placed."""
    return [track for _, track in remaining(trace) if track.state is not BrickState.UNPLACED]


def is_over(duration: float, trace: Trace) -> bool:
    """Whether so long a time [s] after the last action, or after the last hit was to arrive, has passed."""
    return not trace.undone and trace.cost.simulated_time >= _after_all(trace) + duration


def in_time(duration: float, track: BrickTrack, trace: Trace) -> bool:
    """Whether a brick had left its place by then."""
    return track.left_at is not None and track.left_at <= _after_all(trace) + duration


def _after_all(trace: Trace) -> float:
    return max(trace.last_action, trace.last_arrival)


def within(wanted: Tolerance, value: float, unit: str, measured: str = "") -> ClaimResult:
    """A number held against a tolerance."""
    margin = SHOWN_PER_SI.get(unit, 1.0) * wanted.margin(value)
    return ClaimResult(measured, margin, unit, wanted.holds(value), _measure(value, wanted.low, wanted.high, unit))


def at_most(limit: float, value: float, unit: str, measured: str = "") -> ClaimResult:
    """A number held against a limit."""
    margin = SHOWN_PER_SI.get(unit, 1.0) * (limit - value)
    return ClaimResult(measured, margin, unit, value <= limit, _measure(value, -inf, limit, unit))


def _measure(value: float, least: float, most: float, unit: str) -> tuple[Measure, ...]:
    """A number with its limits, given in SI, in the unit that people are told; none if it is not finite."""
    scale = SHOWN_PER_SI.get(unit, 1.0)
    low, high = (scale * limit if isfinite(limit) else None for limit in (least, most))
    return (Measure(scale * value, low, high, unit),) if isfinite(value) else ()


def all_of(parts: Sequence[ClaimResult]) -> ClaimResult:
    """Several parts of a claim as one: all that was measured, and the margin of the worst."""
    worst = min(parts, key=lambda part: (part.passed, part.margin))
    measured = ", ".join(part.measured for part in parts if part.measured)
    numbers = tuple(number for part in parts for number in part.numbers)
    return replace(worst, measured=measured, passed=all(part.passed for part in parts), numbers=numbers)


def margin_to_collapse(track: BrickTrack) -> tuple[float, str]:
    """How much further a brick may shift, or sink after a hit, or turn if that is closer, before it has collapsed."""
    limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * track.brick.shape.least_thickness
    lost = track.shift if track.sunk is None else track.sunk
    if track.tilt / COLLAPSE_TILT > lost / limit:
        return degrees(COLLAPSE_TILT - track.tilt), "deg"
    return MILLIMETRES * (limit - lost), "mm"
