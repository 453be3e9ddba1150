"""How every part of StackDSL writes a length, a limit, how the ground shakes, and a list of names that may be long."""

from collections.abc import Sequence
from math import ceil, floor, log10
from typing import Final, TypeVar

from stability.dynamics.ground_motion import GroundMotion, HandCourse

MILLIMETRES: Final = 1000.0  # in a metre
MOST_NAMES: Final = 6  # that are written out; more fill the line and tell nothing

Name = TypeVar("Name")


def mm(length: float, digits: int = 4) -> str:
    """A length [m] as it is shown, in so many digits at most: `3.9 mm`."""
    return f"{MILLIMETRES * length:.{digits}g} mm"


def touching_text(within: float) -> str:
    """Which gaps a verdict counts on [m]: `, as touching within 0.05 mm`; empty where it counts on none."""
    return f", as touching within {mm(within)}" if within > 0.0 else ""


def how_many(count: int, noun: str) -> str:
    """1 brick, 2 bricks."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def rounded_down(number: float) -> str:
    """Three digits of it, so that what is told to be allowed is."""
    unit = 10.0 ** (floor(log10(number)) - 2)
    return f"{floor(number / unit) * unit:g}"


def rounded_up(number: float) -> str:
    """The same of a lower limit."""
    unit = 10.0 ** (floor(log10(number)) - 2)
    return f"{ceil(number / unit) * unit:g}"


def energy_fault(gained: float) -> str:
    """What to say of energy that an engine added by itself, as a share of what there was, and what to do about it."""
    return (
        f"the engine added {100.0 * gained:.3g} % to the energy that there was, so how bricks moved is not to be "
        "trusted; play it on another system, such as `mujoco`, or expect only what is proven, such as `verdict: stable`"
    )


def shaking_text(motion: GroundMotion) -> str:
    """How the ground shakes: `by up to 4.9 m/s2 for 2 s`."""
    most = max(map(abs, motion.extremes(motion.begins)))
    return f"by up to {most:.4g} m/s2 for {motion.course.duration:g} s"


def moving_text(course: HandCourse) -> str:
    """How a hand moves a brick: `moved by 50 mm in 1.9 s`."""
    return f"moved by {mm(course.length)} in {course.duration:.3g} s"


def shortened(names: Sequence[Name], least: int = 2) -> tuple[Sequence[Name], int]:
    """The names to write out, and how many more there are; fewer than `least` are not worth leaving out."""
    more = len(names) - MOST_NAMES
    return (names, 0) if more < least else (names[:MOST_NAMES], more)


def names_text(names: Sequence[str], least: int = 2) -> str:
    """Names on one line: `a, b, c, d, e, f and 3 more`."""
    shown, more = shortened(names, least)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def broke_text(level: int | None, brick: str | None) -> str:
    """Where a structure broke on which nothing was being built: `, broke at level 2 (L2.1)`; empty elsewhere."""
    return "" if level is None else f", broke at level {level} ({brick})"


def level_text(level: int, step: str) -> str:
    """A level, and the step that builds it where several build one of that number: `level 2 of step 5`."""
    return f"level {level}" + (f" of {step}" if step else "")
