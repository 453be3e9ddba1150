"""How much horizontal acceleration each sample survives once it is built: its capacity, which statics knows at once."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from stability.statics.facts import Placed, Stability
from stability.statics.margins.acceleration import acceleration
from stability.statics.margins.bearings import along_bearing
from stackdsl.sampling.design import Design
from stackdsl.sampling.draws import Draws
from stackdsl.sampling.fates import Fate, fates_of
from stackdsl.sampling.setting_down import Hands

ACCURACY = 1e-4  # share of a capacity in the worst direction that may be unproven
UNKNOWN = (0.0, inf)
SOLVED = "its own margin"  # the way of samples that stand


@dataclass(frozen=True, slots=True)
class Capacity:
    """What one sample survives, and what it is proven not to."""

    fate: int  # of its building, see `Fate`
    survived: float = 0.0  # proven [g]
    fails: float = inf  # proven to bring something down [g]; inf if nothing is proven to


def capacities_of(design: Design, draws: Draws, bearing: float | None) -> tuple[list[Capacity], Counter[str]]:
    """The capacities of some samples, and how many each way decided.

    Along one bearing [rad], which bricks are pulled along, or in the worst direction of all.
    """
    fates, ways = fates_of(design, draws), Counter[str]()
    hands = Hands(design, draws).build()
    found = []
    for sample, (fate, way) in enumerate(zip(fates.fates.tolist(), fates.ways, strict=True)):
        if fate == Fate.STANDS:
            found.append(Capacity(fate, *_margin(design, hands.placed(sample), bearing)))
            ways[SOLVED] += 1
        else:
            found.append(Capacity(fate, 0.0, 0.0 if fate > 0 else inf))
            ways.update([str(way)] if way is not None else [])
    return found, ways


def _margin(design: Design, placed: Sequence[Placed], bearing: float | None) -> tuple[float, float]:
    assembly = design.assembly()
    if assembly.add_all(placed, names_smallest=False).stability is not Stability.STABLE:
        return UNKNOWN
    problem = assembly.problem()
    margin = (
        acceleration(problem, ACCURACY, design.gravity)
        if bearing is None
        else along_bearing(problem, bearing, design.gravity)
    )
    return (margin.value, margin.upper) if margin is not None else UNKNOWN
