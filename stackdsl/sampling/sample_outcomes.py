"""What becomes of each sample, by statics alone: stands, collapses at a level, or nothing is proven."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from stability.analysis.sampled_columns import GROUND as ON_GROUND
from stability.analysis.sampled_columns import PassedDown, SampleSite, Support, falls_as_one
from stability.problem import Placed, Stability
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.samples import BuildPlan, DesignedBrick, Draws


class SampleOutcome(IntEnum):
    """What became of a sample; a number above zero is the level under construction when it fell."""

    STANDS = 0
    UNDECIDED = -1  # statics proves neither
    UNFIT = -2  # hands found no place for a brick beside the others


class Way(StrEnum):
    """What decided a sample."""

    FORCES = "forces passed on"  # those of the design, corrected for the sample, and checked
    FALL = "a fall passed on"  # of the part that the forces do not hold, as one body, and checked
    ANEW = "asked anew"  # all of statics, from an empty site on


@dataclass(frozen=True, slots=True)
class SampleOutcomes:
    """What became of some samples, in order of their numbers."""

    fates: NDArray[np.int32]
    ways: tuple[Way | None, ...]  # None where there was nothing to judge


def sample_outcomes_of(design: BuildPlan, draws: Draws) -> SampleOutcomes:
    """The fates of some samples."""
    hands, count = PlacementSampler(design, draws).build(), draws.count
    fates = np.full(count, SampleOutcome.UNFIT, dtype=np.int32)
    ways: list[Way | None] = [None] * count
    doubtful = np.full(count, ON_GROUND), np.zeros(count, dtype=np.int64)
    asked = hands.fits.copy()
    if design.is_flat:
        supports = [_supports(part, hands) for part in design.parts]
        failing, moments = _held(design, hands, supports)
        held = hands.fits & (moments < 0)
        fates[held] = SampleOutcome.STANDS
        ways = [Way.FORCES if each else None for each in held]
        doubtful, asked = (failing, moments), hands.fits & ~held
    for sample in np.nonzero(asked)[0].tolist():
        placed = hands.placed(sample)
        brick, moment = int(doubtful[0][sample]), int(doubtful[1][sample])
        if design.is_flat and _falls(design, supports, placed, brick, moment, sample):
            fates[sample], ways[sample] = design.moments[moment].level, Way.FALL
        else:
            fates[sample], ways[sample] = asked_anew(design, placed), Way.ANEW
    return SampleOutcomes(fates, tuple(ways))


def asked_anew(design: BuildPlan, placed: Sequence[Placed]) -> int:
    """The fate of one sample, by all of statics, from an empty site on."""
    assembly = design.assembly()
    for moment in design.moments:
        bricks = [placed[part.number] for unit in moment.units for part in unit.parts]
        verdict = assembly.add_all(bricks, names_smallest=False)
        if verdict.stability is Stability.UNSTABLE:
            return moment.level
        if verdict.stability is Stability.UNDECIDED:
            return SampleOutcome.UNDECIDED
    return SampleOutcome.STANDS


# --- flat designs -----------------------------------------------------------------------------------------------------


def _held(
    design: BuildPlan, hands: PlacementSampler, supports: Sequence[Sequence[Support]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """By sample, the brick and the moment where its own forces first fail it; -1 and -1 where they hold to the end."""
    weights = [part.placed.brick.mass * design.gravity for part in design.parts]
    passed = PassedDown(hands.flat(), weights, supports)
    brick, moment = np.full(hands.count, ON_GROUND), np.full(hands.count, -1)
    for number, each in enumerate(design.moments):
        for unit in each.units:
            for part in unit.parts:
                passed.add(part.number)
        astray = passed.astray()
        fails = (moment < 0) & ((astray >= 0) | ~passed.carried)
        moment[fails] = number
        brick[fails] = np.where(astray >= 0, astray, each.units[-1].parts[-1].number)[fails]
    return brick, moment


def _supports(part: DesignedBrick, hands: PlacementSampler) -> list[Support]:
    found = [Support(part.number, other.number, touches) for other, touches in hands.touching(part)]
    grounded = hands.on_ground(part)
    return [*found, Support(part.number, ON_GROUND, grounded)] if grounded.any() else found


def _falls(  # noqa: PLR0913, PLR0917 -- a sample, and what is known of it
    design: BuildPlan,
    supports: Sequence[Sequence[Support]],
    placed: Sequence[Placed],
    brick: int,
    moment: int,
    sample: int,
) -> bool:
    """Whether a brick, with all that it carries by then, is proven to tip as one body, and nothing gave way before."""
    there = [part.number for each in design.moments[: moment + 1] for unit in each.units for part in unit.parts]
    moving = {brick}
    for number in there:
        if number > brick and any(s.lower in moving and s.touches[sample] for s in supports[number]):
            moving.add(number)
    rest = [placed[number] for number in there if number not in moving]
    upper = [placed[number] for number in there if number in moving]
    return falls_as_one(upper, rest, SampleSite(design.planes_W, design.friction, design.gravity)) is not None
