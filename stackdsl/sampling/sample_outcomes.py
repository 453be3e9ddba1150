"""Outcome of each sample, by statics alone: it stands, collapses at a level, or is undecided."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from stability.analysis.sampled_columns import GROUND as ON_GROUND
from stability.analysis.sampled_columns import SampledForces, SampleSite, Support, falls_as_one
from stability.problem import Placed, Stability
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.samples import BuildPlan, DesignedBrick, Draws


class SampleOutcome(IntEnum):
    """Outcome of a sample; a number above zero is the level under construction when it fell."""

    STANDS = 0
    UNDECIDED = -1  # statics proves neither
    UNFIT = -2  # no free space for a brick beside the others


class Way(StrEnum):
    """The proof that decided a sample."""

    FORCES = "force propagation"  # from the forces of the design, corrected for the sample and checked
    FALL = "rigid-body tipping"  # of the bricks that these forces do not hold, as one body, checked
    ANEW = "full statics"  # of all placements, from an empty site on


@dataclass(frozen=True, slots=True)
class SampleOutcomes:
    """Outcomes of a batch of samples, in order of their numbers."""

    values: NDArray[np.int32]
    ways: tuple[Way | None, ...]  # None for an unfit sample, which is not judged


def sample_outcomes_of(design: BuildPlan, draws: Draws) -> SampleOutcomes:
    """Judge a batch of samples."""
    hands, count = PlacementSampler(design, draws).build(), draws.count
    values = np.full(count, SampleOutcome.UNFIT, dtype=np.int32)
    ways: list[Way | None] = [None] * count
    doubtful = np.full(count, ON_GROUND), np.zeros(count, dtype=np.int64)
    remaining = hands.fits.copy()
    if design.is_flat:
        supports = [_supports(part, hands) for part in design.parts]
        failing, moments = _held(design, hands, supports)
        held = hands.fits & (moments < 0)
        values[held] = SampleOutcome.STANDS
        ways = [Way.FORCES if each else None for each in held]
        doubtful, remaining = (failing, moments), hands.fits & ~held
    for sample in np.nonzero(remaining)[0].tolist():
        placed = hands.placed(sample)
        brick, moment = int(doubtful[0][sample]), int(doubtful[1][sample])
        if design.is_flat and _falls(design, supports, placed, brick, moment, sample):
            values[sample], ways[sample] = design.moments[moment].level, Way.FALL
        else:
            values[sample], ways[sample] = judge_sample(design, placed), Way.ANEW
    return SampleOutcomes(values, tuple(ways))


def judge_sample(design: BuildPlan, placed: Sequence[Placed]) -> int:
    """Return the outcome of one sample by full statics, one placement after the other."""
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
    """Return, by sample, brick and moment at which force propagation first fails; -1 and -1 if it never does."""
    weights = [part.placed.brick.mass * design.gravity for part in design.parts]
    passed = SampledForces(hands.flat(), weights, supports)
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
    supports = [Support(part.number, other.number, touches) for other, touches in hands.touching(part)]
    grounded = hands.on_ground(part)
    return [*supports, Support(part.number, ON_GROUND, grounded)] if grounded.any() else supports


def _falls(  # noqa: PLR0913, PLR0917 -- a sample, and the result of force propagation
    design: BuildPlan,
    supports: Sequence[Sequence[Support]],
    placed: Sequence[Placed],
    brick: int,
    moment: int,
    sample: int,
) -> bool:
    """Return whether a brick and all bricks on it at a moment are proven to tip as one body."""
    present = [part.number for each in design.moments[: moment + 1] for unit in each.units for part in unit.parts]
    moving = {brick}
    for number in present:
        if number > brick and any(s.lower in moving and s.touches[sample] for s in supports[number]):
            moving.add(number)
    rest = [placed[number] for number in present if number not in moving]
    upper = [placed[number] for number in present if number in moving]
    return falls_as_one(upper, rest, SampleSite(design.planes_W, design.friction, design.gravity)) is not None
