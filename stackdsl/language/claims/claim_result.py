"""Results of claims, and the bricks that claims apply to.

A margin is positive inside and negative outside the tolerance, in the unit of the measured value. The margin of a claim
of several parts is that of the part closest to failing.
"""

from collections.abc import Collection, Iterable, Sequence
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
from stackdsl.wording import MILLIMETRES, significant

PERCENT = 100.0
SHOWN_PER_SI = {"mm": MILLIMETRES, "deg": degrees(1.0), "%": PERCENT, "kPa": 1e-3}  # by the unit of a margin


@dataclass(frozen=True, slots=True)
class ClaimResult:
    """The measured value and the result of a claim, or of a part of it."""

    measured: str
    margin: float
    unit: str
    passed: bool
    numbers: tuple[Measure, ...] = ()  # measured numbers, with their limits
    moved: str = ""  # largest shift or tilt beside its limit, if `margin` is the rest of it and not a safety margin


def remaining(trace: Trace) -> Collection[tuple[BodyId, BrickTrack]]:
    """Return the bricks of the structure, without those that are thrown or pulled out, now or later."""
    removed = trace.pending_removals
    return [(name, track) for name, track in trace.tracks.items() if track.state not in NO_PART and name not in removed]


def placed(trace: Trace) -> Collection[BrickTrack]:
    """Return the placed bricks of the structure."""
    return [track for _, track in remaining(trace) if track.state is not BrickState.UNPLACED]


def is_over(duration: float, trace: Trace) -> bool:
    """Return whether a time [s] has passed since the last action and since the expected arrival of the last hit."""
    return not trace.undone and trace.cost.simulated_time >= _after_all(trace) + duration


def in_time(duration: float, track: BrickTrack, trace: Trace) -> bool:
    """Return whether a brick left its place within a time [s] after the last action and hit."""
    return track.left_at is not None and track.left_at <= _after_all(trace) + duration


def _after_all(trace: Trace) -> float:
    return max(trace.last_action, trace.last_arrival)


def within(wanted: Tolerance, value: float, unit: str, measured: str = "") -> ClaimResult:
    """Compare a number with a tolerance."""
    margin = SHOWN_PER_SI.get(unit, 1.0) * wanted.margin(value)
    return ClaimResult(measured, margin, unit, wanted.holds(value), _measure(value, wanted.low, wanted.high, unit))


def at_most(limit: float, value: float, unit: str, measured: str = "") -> ClaimResult:
    """Compare a number with an upper limit."""
    margin = SHOWN_PER_SI.get(unit, 1.0) * (limit - value)
    return ClaimResult(measured, margin, unit, value <= limit, _measure(value, -inf, limit, unit))


def _measure(value: float, least: float, most: float, unit: str) -> tuple[Measure, ...]:
    """Convert a number and its limits from SI to the unit of reports; empty for a number that is not finite."""
    scale = SHOWN_PER_SI.get(unit, 1.0)
    low, high = (scale * limit if isfinite(limit) else None for limit in (least, most))
    return (Measure(scale * value, low, high, unit),) if isfinite(value) else ()


def all_of(parts: Sequence[ClaimResult]) -> ClaimResult:
    """Combine the parts of a claim: all measured values, and the margin of the worst part."""
    worst = min(parts, key=lambda part: (part.passed, part.margin))
    measured = ", ".join(part.measured for part in parts if part.measured)
    numbers = tuple(number for part in parts for number in part.numbers)
    return replace(worst, measured=measured, passed=all(part.passed for part in parts), numbers=numbers)


def margin_to_collapse(track: BrickTrack) -> tuple[float, str]:
    """Return the margin of a brick to a collapse, and its unit.

    It is the margin of the shift, of the sinking after a hit, or of the tilt if that is closer to its limit.
    """
    _, value, limit, unit = _towards_collapse(track)
    return limit - value, unit


def moved_text(tracks: Iterable[BrickTrack]) -> str:
    """Return the shift or tilt nearest to its limit: `largest shift 2 mm of 39 mm allowed`; empty without bricks."""
    nearest = max(map(_towards_collapse, tracks), key=lambda each: (each[0], -each[2]), default=None)
    if nearest is None:
        return ""
    _, value, limit, unit = nearest
    what = "tilt" if unit == "deg" else "shift"
    return f"largest {what} {significant(value)} {unit} of {significant(limit)} {unit} allowed"


def _towards_collapse(track: BrickTrack) -> tuple[float, float, float, str]:
    """Return the largest share of a limit, the shift, sinking or tilt that has it, the limit, and the unit."""
    limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * track.brick.shape.least_thickness
    lost = track.shift if track.sunk is None else track.sunk
    if track.tilt / COLLAPSE_TILT > lost / limit:
        return track.tilt / COLLAPSE_TILT, degrees(track.tilt), degrees(COLLAPSE_TILT), "deg"
    return lost / limit, MILLIMETRES * lost, MILLIMETRES * limit, "mm"


def lost_text(tracks: Sequence[BrickTrack]) -> str:
    """Return how many bricks fell, and how many were never placed, since the structure had collapsed before."""
    fallen, missing = (
        sum(track.state is state for track in tracks) for state in (BrickState.FALLEN, BrickState.UNPLACED)
    )
    if not fallen:
        return never_placed_text(missing, len(tracks))
    return f"{fallen} of {len(tracks)} bricks fell, and {never_placed_text(missing)}"


def never_placed_text(count: int, total: int = 0) -> str:
    """Return `2 were never placed`, or with a total `2 of 12 bricks were never placed`."""
    return f"{count}{f' of {total} bricks' * (total > 0)} {'was' if count == 1 else 'were'} never placed"
