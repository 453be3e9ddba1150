"""What `suggest` found: a line each, or a row each."""

from math import atan2, degrees, hypot
from typing import Any

from stability.statics.mending.propping import Propping
from stability.statics.mending.shifts import BrickShift, SeveralShifts
from stackdsl.judging.remedies import HeavierBrick, MoreFriction
from stackdsl.judging.suggesting import Suggestion
from stackdsl.report.remedy_text import counterweight_text, friction_text, later_text

ALONG = {0: "+x", 90: "+y", 180: "-x", -180: "-x", -90: "-y"}  # [deg]


def suggestion_row(suggestion: Suggestion) -> dict[str, Any]:
    """The same keys for every kind; nothing where a kind has none."""
    keys = ("kind", "bricks", "amount", "unit", "fails_with")
    return {**dict(zip(keys, _amounts(suggestion), strict=True)), "text": suggestion_text(suggestion)}


def _amounts(suggestion: Suggestion) -> tuple[str, str, float | None, str, float | None]:
    match suggestion:
        case BrickShift(brick):
            return ("shift", brick, 1e3 * suggestion.length, "mm", 1e3 * suggestion.too_little)
        case SeveralShifts(shifts, too_little):
            longest = max(hypot(*shift) for _, shift in shifts)
            names = " ".join(name for name, _ in shifts)
            return ("shifts", names, 1e3 * longest, "mm", 1e3 * longest * too_little)
        case HeavierBrick(brick, mass):
            return ("counterweight", brick, 1e3 * mass, "g", None)
        case MoreFriction(_, coefficient):
            return ("friction", "", coefficient, "", None)
        case Propping(bricks):
            return ("props", " ".join(bricks), None, "", None)


def suggestion_text(suggestion: Suggestion) -> str:
    """What to do, in words."""
    match suggestion:
        case BrickShift(brick, shift):
            return f"move {brick} by {_shift(shift)}, with what rests on it"
        case SeveralShifts(shifts):
            moves = ", ".join(f"{brick} by {_shift(shift)}" for brick, shift in shifts)
            return f"move {moves}, with what rests on each"
        case HeavierBrick():
            return counterweight_text(suggestion)
        case MoreFriction():
            return friction_text(suggestion)
        case Propping(bricks, later):
            props = f"prop{'s' * (len(bricks) > 1)} under {', '.join(bricks)}, which must stay"
            return props + later_text(later)


def _shift(shift: tuple[float, float]) -> str:
    """Rounded up, in five digits, so that it is enough."""
    bearing = round(degrees(atan2(shift[1], shift[0])), 2)
    towards = ALONG.get(int(bearing)) if bearing == int(bearing) else None
    return f"{1e3 * hypot(*shift):.5g} mm towards {towards or f'{bearing:g} deg'}"
