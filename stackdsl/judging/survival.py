"""What a structure survives when it is shaken, by bearing: proven from its own contacts, without an engine."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, inf

from stability.statics.assembly import Assembly
from stability.statics.facts import Motion, Problem, Stability
from stability.statics.margins.acceleration import tilt
from stability.statics.margins.bearings import Survived, by_bearing
from stability.statics.margins.weakest import Weakest, weakest
from stability.statics.solvers.fall_words import described

MOST_FOR_WEAKEST = 300  # bricks; beyond, the worst of all bearings takes many times as long as those that are asked for
ALIKE = 1e-6  # share by which a mechanism must give way sooner than the weakest one does to be named in its place
ALONG = 1e-12  # cosine below which a mechanism bounds nothing in a direction


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
    """All bearings around, from +x on, and what is weakest of all bearings, these or others."""

    along: Sequence[Along]
    weakest: Weakest | None  # None if nothing gives way, or of more bricks than `MOST_FOR_WEAKEST`

    @property
    def worst(self) -> Along:
        """Of these bearings, where least is survived; the first of several."""
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
    first = weakest(problem, assembly.gravity) if len(assembly.bricks) <= MOST_FOR_WEAKEST else None
    told: dict[int, str] = {}  # words are the same for all bearings at which the same motion gives way
    return Survival(tuple(_along(problem, each, first, told) for each in found), first)


def _along(problem: Problem, each: Survived, first: Weakest | None, told: dict[int, str]) -> Along:
    """One bearing. No less is survived along it than in the worst of all, whose mechanism bounds all others."""
    if first is None:
        return Along(each.bearing, each.value, each.upper, tilt(each.value), _words(problem, each.motion, told))
    survived, turn = max(each.value, first.acceleration), cos(each.bearing - first.bearing)
    bound = first.fails / turn if turn > ALONG else inf
    if bound > each.upper * (1.0 + ALIKE):
        return Along(each.bearing, survived, each.upper, tilt(survived), _words(problem, each.motion, told))
    return Along(each.bearing, survived, min(bound, each.upper), tilt(survived), first.gives_way)


def _words(problem: Problem, motion: Motion | None, told: dict[int, str]) -> str:
    if motion is None:
        return ""
    if id(motion) not in told:
        told[id(motion)] = described(problem, motion)
    return told[id(motion)]
