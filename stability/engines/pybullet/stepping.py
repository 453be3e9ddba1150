"""How finely an engine must step, from what is awake: what a scene does not need is not paid for.

Model: an iterative contact solver lets a light brick under a heavy one give way in proportion to their ratio of masses
and to the square of the step; a body that is inside another when the engine first sees them is pushed out of it, and
flies off; contacts that last from step to step are solved from where they were left, those of an impact from nothing.
"""

from dataclasses import dataclass
from math import ceil, sqrt

from stability.engines.pybullet.pybullet_settings import PyBulletSettings

MOST_PARTS_OF_HITS = 32  # 8 m/s at steps of 1/960 s


@dataclass(frozen=True, slots=True)
class Awake:
    """What is known of the bodies that move, or may."""

    fastest: float = 0.0  # [m/s] no body will be faster before the next look
    mass_ratio: float = 1.0  # of the heaviest to the lightest
    begins: bool = False  # whether bodies that did not press on each other begin to


@dataclass(frozen=True, slots=True)
class Stepping:
    """How one time step is taken."""

    parts: int  # engine steps in it
    iterations: int  # of the contact solver in each
    lively: bool  # whether something may hit something
    may_hit: bool = False  # whether that is about to be, for the first time


def stepping(settings: PyBulletSettings, awake: Awake) -> Stepping:
    """How to step what is awake with these settings."""
    lively = settings.lively_speed is not None and awake.fastest > settings.lively_speed
    may_hit = lively and awake.begins
    parts = (
        settings.parts_for_travel(awake.fastest),
        _for_hits(settings, awake.fastest) if may_hit else 1,
        _for_masses(settings, awake.mass_ratio),
        settings.first_parts if awake.begins else 1,
        settings.lively_parts if lively else 1,
    )
    iterations = settings.lively_iterations if lively else settings.iterations
    if may_hit:
        iterations = max(iterations, settings.first_iterations)
    return Stepping(max(parts), iterations, lively, may_hit)


def _for_hits(settings: PyBulletSettings, fastest: float) -> int:
    """Into how many parts, so that what hits something by a narrow overlap does not slip past it."""
    if settings.first_travel is None:
        return 1
    return max(1, min(MOST_PARTS_OF_HITS, ceil(fastest * settings.time_step / settings.first_travel)))


def _for_masses(settings: PyBulletSettings, ratio: float) -> int:
    """Into how many parts, so that a light brick stays firm under a heavy one."""
    if settings.most_mass_ratio is None:
        return 1
    return max(1, min(settings.most_parts, ceil(sqrt(ratio / settings.most_mass_ratio))))
