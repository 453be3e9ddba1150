"""Formats lengths, limits, ground motion and long lists of names, alike in every report."""

from collections.abc import Sequence
from math import ceil, floor, log10
from typing import Final, TypeVar

from stability.dynamics.ground_motion import GroundMotion, HandCourse
from stability.name_order import MOST_NAMES

MILLIMETRES: Final = 1000.0  # in a metre

Name = TypeVar("Name")


def mm(length: float, digits: int = 4) -> str:
    """Format a length [m] in millimetres, with at most `digits` significant digits: `3.9 mm`."""
    return f"{MILLIMETRES * length:.{digits}g} mm"


def touching_text(within: float) -> str:
    """Format the widest gap [m] that a verdict counts as contact: `, if gaps up to 0.05 mm count as contact`, or ``."""
    return f", if gaps up to {mm(within)} count as contact" if within > 0.0 else ""


def how_many(count: int, noun: str) -> str:
    """Format a count and its noun: 1 brick, 2 bricks."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def rounded_down(number: float) -> str:
    """Round an upper limit down to three digits, so that the shown value is still allowed."""
    unit = 10.0 ** (floor(log10(number)) - 2)
    return f"{floor(number / unit) * unit:g}"


def rounded_up(number: float) -> str:
    """Round a lower limit up to three digits, so that the shown value is still allowed."""
    unit = 10.0 ** (floor(log10(number)) - 2)
    return f"{ceil(number / unit) * unit:g}"


def energy_fault(gained: float) -> str:
    """Describe spurious energy that an engine added, as a share of the total energy, with the remedy."""
    return (
        f"the engine added {100.0 * gained:.3g} % to the total energy, so the motion of the bricks cannot be trusted; "
        "use another system, such as `mujoco`, or expect only proven results, such as `verdict: stable`"
    )


def shaking_text(motion: GroundMotion) -> str:
    """Format a ground motion: `by up to 4.9 m/s2 for 2 s`."""
    most = max(map(abs, motion.extremes(motion.begins)))
    return f"by up to {most:.4g} m/s2 for {motion.course.duration:g} s"


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
