"""What a structure survives when it is shaken, by bearing: proven from its own contacts, without an engine."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stability.statics.assembly import Assembly
from stability.statics.facts import Motion, Problem, Stability
from stability.statics.margins.acceleration import tilt
from stability.statics.margins.bearings import by_bearing
from stability.statics.solvers.fall_words import described

ALIKE = 1e-6  # share by which one bearing must be worse than one before it: rounding does not choose which is named


@dataclass(frozen=True, slots=True)
class Along:
    """What is survived along one bearing."""

    bearing: float  # that bricks are pulled along, from +x towards +y [rad]
    survived: float  # proven [g]; inf if nothing gives way
    fails: float  # proven to bring something down [g]; inf if nothing is proven to
    tilt: float  # of the whole, downwards along the bearing, that is survived [rad]
    gives_way: str  # what comes down first, and how, in words; empty if nothing is proven to


@dataclass(frozen=True, slots=True)
class Survival:
    """All bearings around, from +x on."""

    along: Sequence[Along]

    @property
    def worst(self) -> Along:
        """Where least is survived; the first of several."""
        least = min(each.survived for each in self.along)
        return next(each for each in self.along if each.survived <= least * (1.0 + ALIKE))


def survival_of(
    assembly: Assembly, count: int, accuracy: float, known: Callable[[int], None] = lambda _: None
) -> Survival | None:
    """What an assembly survives along `count` bearings, each to a relative accuracy; None if it is not proven to stand.

    `known` is told of how many bearings enough is known, as it goes on.
    """
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return None
    problem = assembly.problem()
    found = by_bearing(problem, count, accuracy, assembly.gravity, known=known)
    if found is None:
        return None
    told: dict[int, str] = {}  # words are the same for all bearings at which the same motion gives way
    return Survival(
        tuple(
            Along(each.bearing, each.value, each.upper, tilt(each.value), _words(problem, each.motion, told))
            for each in found
        )
    )


def _words(problem: Problem, motion: Motion | None, told: dict[int, str]) -> str:
    if motion is None:
        return ""
    if id(motion) not in told:
        told[id(motion)] = described(problem, motion)
    return told[id(motion)]
