"""Formats lengths, limits, ground motion and long lists of names, alike in every report."""

from collections import defaultdict
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from math import degrees, isfinite
from typing import TYPE_CHECKING, Final, TypeVar

from stability.analysis.weakest import Apart, Weakest
from stability.dynamics.ground_motion import GroundMotion, HandCourse
from stability.name_order import MOST_NAMES, names_text
from stability.statics.fall_description import FallSide

if TYPE_CHECKING:
    from stability.problem import PlacementLimit


MILLIMETRES: Final = 1000.0  # in a metre
GRAMS: Final = 1000.0  # in a kilogram
PARTS: Final = "; "  # between the parts of a mechanism
FEW: Final = 3  # parts of a mechanism, or reasons, that are written out
LONG: Final = 3600.0  # [s] from which times are told as a time of day

Name = TypeVar("Name")


def clock(time: float) -> str:
    """Return a time [s] in a column; from an hour on as days and a time of day."""
    if time < LONG:
        return f"{time:9.3f} s"
    minutes, seconds = divmod(round(time), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    of_day = f"{hours}:{minutes:02}:{seconds:02}"
    return f"{f'{days} d {of_day}' if days else of_day:>11}"


def time_text(time: float, digits: int = 6) -> str:
    """Return a time [s] in words; from an hour on as days and a time of day."""
    return f"{time:.{digits}g} s" if time < LONG else clock(time).strip()


def mm(length: float, digits: int = 4) -> str:
    """Format a length [m] in millimetres, with at most `digits` significant digits: `3.9 mm`."""
    return f"{MILLIMETRES * length:.{digits}g} mm"


def touching_text(within: float) -> str:
    """Format the widest gap [m] that a verdict counts as contact: `, if gaps up to 0.05 mm count as contact`, or ``."""
    return f", if gaps up to {mm(within)} count as contact" if within > 0.0 else ""


def how_many(count: int, noun: str) -> str:
    """Format a count and its noun: 1 brick, 2 bricks."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def and_text(names: Sequence[str]) -> str:
    """Return names as `a, b and c`; of many names the first ones, and how many more there are."""
    shown, left_out = shortened(names)
    *first, last = [*shown, f"{left_out} more"] if left_out else [*shown] or [""]
    return f"{', '.join(first)} and {last}" if first else last


def significant(value: float) -> str:
    """Format a number with three significant digits, without an exponent if possible."""
    return f"{float(f'{value:.3g}') + 0.0:g}"  # a zero has no sign


def rounded_down(number: float, digits: int = 3) -> str:
    """Round an upper limit down to a few digits, so that the shown value is still allowed."""
    return _rounded(number, digits, ROUND_FLOOR)


def rounded_up(number: float, digits: int = 3) -> str:
    """Round a lower limit up to a few digits, so that the shown value is still allowed."""
    return _rounded(number, digits, ROUND_CEILING)


def _rounded(number: float, digits: int, way: str) -> str:
    if not isfinite(number):
        return f"{number:g}"
    exact = Decimal(f"{number:.12g}")  # without the noise of floating point, which would count as a part of a digit
    if not exact:
        return "0"
    return f"{float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - digits + 1), way)):.12g}"


def survived_text(value: float) -> str:
    """Round a survived acceleration, angle or length down to three digits, so that a claim of it holds."""
    return rounded_down(value)


def limit_text(value: float) -> str:
    """Format the acceleration above which something moves: three digits, without noise from the sixth digit on."""
    return rounded_down(float(f"{value:.5g}"))


GAPS: Final = "if neighbours may be apart, write gaps between them, such as 2 mm"


def aided_text(apart: Apart) -> str:
    """Say what friction between neighbours adds to a margin of acceleration."""
    if apart.acceleration is None:
        return "only with friction between neighbours that touch; it falls without it"
    return f"with friction between neighbours that touch; {survived_text(apart.acceleration)} g without it"


def apart_text(apart: Apart) -> str:
    """Say what gives way first without friction between neighbours: in a fall, or above an acceleration."""
    way = in_short(apart.gives_way)
    if apart.acceleration is None:
        return f"it stands only with friction between neighbours that touch: without it, {way}"
    return f"without friction between neighbours, above {limit_text(apart.acceleration)} g, {way}"


def in_short(gives_way: str) -> str:
    """Return the first parts of a mechanism."""
    parts = gives_way.split(PARTS)
    if len(parts) <= FEW:
        return gives_way
    return f"{PARTS.join(parts[: FEW - 1])}{PARTS}and {len(parts) - FEW + 1} other parts"


def mass_text(mass: float) -> str:
    """Format a mass [kg] in grams or kilograms: `522 g`, `7.1 kg`."""
    return f"{mass:.4g} kg" if mass >= 1.0 else f"{GRAMS * mass:.4g} g"


def weakest_text(weakest: Weakest) -> str:
    """Return text such as `weakest: above 0.258 g towards 0 deg (+x), L2.1, L3.1 tip over L1.1`."""
    least = limit_text(weakest.acceleration)
    return f"weakest: above {least} g towards {degrees_text(weakest.bearing)}, {gives_way_text(weakest)}"


def joints_text(joints: Sequence["PlacementLimit"]) -> str:
    """Return the contacts that limit the placement error equally, by direction; empty if there are none.

    For example `limiting contacts of the placement error: L2.1 on L1.1, L3.1 on L2.1, towards +y or -y`.
    """
    by_way = defaultdict[str, list[str]](list)
    for each in joints:
        ways = sorted(bearing_text(bearing) for bearing in each.bearings)
        by_way[" or ".join(ways)].append(f"{each.upper} on {each.lower}")
    told = [f"{and_text(contacts)}, towards {ways}" for ways, contacts in by_way.items()]
    return (
        f"limiting contact{'s' * (len(joints) > 1)} of the placement error: {in_short(PARTS.join(told))}"
        if told
        else ""
    )


def opened_text(pairs: Sequence[Sequence[str]]) -> str:
    """Return the joints between pairs of bodies, such as `joint of L1.1 and L2.1`."""
    named = [" and ".join(pair) for pair in pairs]
    return f"joint of {named[0]}" if len(named) == 1 else f"joints of {in_short(PARTS.join(named))}"


def slides_together(weakest: Weakest) -> bool:
    """Return whether the mechanism is that several bricks, and all that there are, slide together."""
    return bool(weakest.slides_on) and len(weakest.bricks) > 1


def gives_way_text(weakest: Weakest) -> str:
    """Describe a mechanism; if all bricks slide together, by their number, their support and its friction."""
    if not slides_together(weakest):
        return weakest.gives_way
    supports = names_text(weakest.slides_on)
    return f"{all_bricks_text(weakest)} slide on {supports} (coefficient of friction {weakest.friction:.4g})"


def all_bricks_text(weakest: Weakest) -> str:
    """Return `all 9 bricks`, for a mechanism of several bricks that is the whole structure."""
    return "both bricks" if len(weakest.bricks) == 2 else f"all {len(weakest.bricks)} bricks"  # noqa: PLR2004


def energy_fault(gained: float) -> str:
    """Describe spurious energy that an engine added, as a share of the total energy, with the remedy."""
    return (
        f"the engine added {100.0 * gained:.3g} % to the total energy, so the motion of the bricks cannot be trusted; "
        "use another system, such as `mujoco`, or expect only proven results, such as `verdict: stable`"
    )


def shaking_text(motion: GroundMotion) -> str:
    """Format a ground motion: `by up to 4.9 m/s2 for 2 s`, with the peak of each component."""
    most = " and ".join(f"{peak:.4g}" for peak in motion.peaks)
    return f"by up to {most} m/s2 for {motion.duration:g} s"


def moving_text(course: HandCourse) -> str:
    """Format the path of a hand: `moved by 50 mm in 1.9 s`."""
    return f"moved by {mm(course.length)} in {course.duration:.3g} s"


def shortened(names: Sequence[Name], least: int = 2) -> tuple[Sequence[Name], int]:
    """Return the names to write out and the number left out, which is 0 or at least `least`."""
    more = len(names) - MOST_NAMES
    return (names, 0) if more < least else (names[:MOST_NAMES], more)


def broke_text(level: int | None, brick: str | None) -> str:
    """Format the level and brick where a finished structure broke: `, broke at level 2 (L2.1)`; empty if it did not."""
    return "" if level is None else f", broke at level {level} ({brick})"


def level_text(level: int, step: str) -> str:
    """Format a level, with its build step where several steps have that level: `level 2 of step 5`."""
    return f"level {level}" + (f" of {step}" if step else "")


# Direction of a fall in words.


AXES = {0: "+x", 90: "+y", 180: "-x", 270: "-y"}  # by bearing [deg]
ROUNDED = 0.05  # [deg] a bearing within this of an axis counts as along it


def side_text(side: FallSide) -> str:
    """Return text such as `towards +x, its weight 1.2 mm beyond the edge`; empty if unknown."""
    told = [f"towards {bearing_text(side.bearing)}"] if side.bearing is not None else []
    told += [f"its weight {mm(side.overhang, 3)} beyond the edge"] if side.overhang is not None else []
    return ", ".join(told)


def degrees_text(bearing: float) -> str:
    """Format a bearing [rad], with the axis along which it points: `270 deg (-y)`."""
    angle, name = f"{round(degrees(bearing), 1) % 360.0:g} deg", bearing_text(bearing)
    return angle if name.endswith("deg") else f"{angle} ({name})"


def bearing_text(bearing: float) -> str:
    """Return a bearing [rad] as the name of an axis, or in degrees from +x towards +y."""
    angle = degrees(bearing) % 360.0
    nearest = 90 * round(angle / 90.0)
    return AXES[nearest % 360] if abs(angle - nearest) <= ROUNDED else f"{angle:.1f} deg"
