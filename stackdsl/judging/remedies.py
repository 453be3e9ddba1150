"""What would let a scenario stand that falls: other numbers, more friction, a counterweight. Each is tried.

Numbers of the file and friction are asked to let everything stand that statics can judge; a counterweight, everything
up to and with what falls, as more may fall after it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Final

from stability.friction_law import Friction, law_of
from stability.model import BodyId
from stability.statics.facts import Stability, Verdict
from stability.statics.margins.counterweight import Counterweight, counterweight
from stability.statics.margins.friction import least_friction
from stackdsl.judging.knobs import Knob, Knobs
from stackdsl.judging.limits import Limit, limits
from stackdsl.judging.proofs import Proofs, proofs_of
from stackdsl.timeline import Action, Placement, Timeline
from stackdsl.wording import rounded_up

MOST_KNOBS: Final = 8
MOST_FRICTIONS: Final = 5  # moments, one after the other, that may ask for more than those before
MOST_COUNTERWEIGHTS: Final = 5  # that are tried by a verdict, the least first
HEAVIEST: Final = 1e3  # times the mass of all that there is: what needs more is told as none


@dataclass(frozen=True, slots=True)
class OtherNumber:
    """A number of the file, and the nearest with which everything stands."""

    knob: Knob
    limit: Limit


@dataclass(frozen=True, slots=True)
class MoreFriction:
    """The least friction with which everything stands."""

    factor: float  # on all coefficients; inf if no friction is enough, by proof
    coefficient: float  # the same of brick on brick
    alike: bool  # whether all coefficients are one


@dataclass(frozen=True, slots=True)
class HeavierBrick:
    """The least counterweight: a brick that is heavier from the start."""

    brick: BodyId
    mass: float  # more of it [kg]
    next_to_fall: tuple[BodyId, ...]  # what then falls later; empty if everything stands


@dataclass(frozen=True, slots=True)
class Remedies:
    """What would help, each tried."""

    numbers: tuple[OtherNumber, ...] = ()
    friction: MoreFriction | None = None  # None where neither an amount nor that none is enough could be proven
    counterweight: HeavierBrick | None = None  # None where none was found
    nothing_rises: bool = False  # in the fall, so that no counterweight on a brick holds it, by proof


def remedies_of(knobs: Knobs, timeline: Timeline, proofs: Proofs) -> Remedies:
    """The remedies of a timeline whose `proofs` end with a fall."""
    verdict = proofs.assembly.verdict()
    if verdict.stability is not Stability.UNSTABLE:
        return Remedies()
    rising = rising_in(verdict)
    return Remedies(
        tuple(_numbers(knobs, set(verdict.moving))),
        more_friction(timeline, proofs),
        _counterweight(timeline, proofs, rising),
        not rising,
    )


def _verdict(timeline: Timeline) -> tuple[Stability, tuple[BodyId, ...]]:
    """Of all that statics can judge of a timeline, and what moves if it falls."""
    verdict = proofs_of(timeline, names_smallest=False).assembly.verdict()
    return verdict.stability, verdict.moving


def _stands(timeline: Timeline | None) -> bool | None:
    """None where it is no scenario, or too close to its limit to say."""
    stability = Stability.UNDECIDED if timeline is None else _verdict(timeline)[0]
    return None if stability is Stability.UNDECIDED else stability is Stability.STABLE


def _numbers(knobs: Knobs, moving: set[BodyId]) -> Iterator[OtherNumber]:
    for _, knob in zip(range(MOST_KNOBS), knobs.found(moving), strict=False):

        def holds(value: float, knob: Knob = knob) -> bool | None:
            return _stands(knobs.timeline(knob, value))

        yield from (OtherNumber(knob, limit) for limit in limits(knob.number, knob.steps, knob.whole, holds))


def more_friction(timeline: Timeline, proofs: Proofs) -> MoreFriction | None:
    """As much as the worst moment asks for: the next to fall is asked until nothing does."""
    factor = 1.0
    world = timeline.world
    written, usual, alike = world.roughest, law_of(world.friction).usual, world.rubs_alike
    for _ in range(MOST_FRICTIONS):
        margin = least_friction(proofs.assembly.problem())
        if margin.factor == inf:
            return MoreFriction(inf, inf, alike) if margin.motion is not None else None
        limits = in_three_digits(margin.too_little * factor * written, margin.factor * factor * written)
        for tried in sorted({max(factor, limit / written) for limit in limits}):
            proofs = proofs_of(with_friction(timeline, tried), names_smallest=False)
            stability = proofs.assembly.verdict().stability
            if stability is Stability.STABLE:
                return MoreFriction(tried, tried * usual, alike)
        factor = tried
        if stability is Stability.UNDECIDED:
            return None
    return None


def in_three_digits(too_little: float, enough: float) -> list[float]:
    """The numbers of three digits to try for a limit between these two, the least first; the last is enough.

    A limit of 150 is proven to lie between 149.9999 and 150.0001, and 151 is more than it takes.
    """
    return sorted({float(rounded_up(number)) for number in (too_little, enough) if number > 0.0})


def masses_of(weight: Counterweight, gravity: float) -> list[float]:
    """The masses to try as a counterweight [kg], the least first."""
    return in_three_digits(weight.too_little / gravity, weight.weight / gravity)


def with_friction(timeline: Timeline, factor: float) -> Timeline:
    """A timeline with all coefficients of friction times a factor."""
    world = timeline.world
    planes = tuple(replace(plane, friction=factor * plane.friction) for plane in world.planes)
    friction = world.friction
    rougher = friction.times(factor) if isinstance(friction, Friction) else factor * friction
    return replace(timeline, world=replace(world, friction=rougher, planes=planes))


def rising_in(verdict: Verdict) -> Sequence[BodyId]:
    """The bricks that rise in a fall: more weight on any other leaves the motion as much power, or gives it more."""
    motion = verdict.motion
    return [name for name, (velocity, _) in sorted(motion.velocity.items()) if velocity[2] > 0.0] if motion else []


def _counterweight(timeline: Timeline, proofs: Proofs, rising: Sequence[BodyId]) -> HeavierBrick | None:
    """The least that holds what falls, on any brick that rises."""
    problem, gravity = proofs.assembly.problem(), timeline.world.gravity
    found = [weight for brick in rising if (weight := counterweight(problem, brick)) is not None]
    total = sum(placed.brick.mass for placed in problem.bricks.values())
    for weight in sorted(found, key=lambda each: (each.weight, each.brick))[:MOST_COUNTERWEIGHTS]:
        for mass in masses_of(weight, gravity):
            if mass > HEAVIEST * total:
                return None
            heavier = with_mass(timeline, weight.brick, _mass_of(timeline, weight.brick) + mass)
            if _stands(replace(heavier, actions=heavier.actions[: proofs.done])):
                stability, moving = _verdict(heavier)
                return HeavierBrick(weight.brick, mass, moving if stability is not Stability.STABLE else ())
    return None


def _mass_of(timeline: Timeline, brick: BodyId) -> float:
    return next(each.brick.mass for each in timeline.placements if each.brick.id == brick)


def with_mass(timeline: Timeline, brick: BodyId, mass: float) -> Timeline:
    """A timeline with a brick of another mass [kg]."""

    def other(action: Action) -> Action:
        if not isinstance(action, Placement) or action.brick.id != brick:
            return action
        return replace(action, brick=replace(action.brick, mass=mass))

    return replace(timeline, actions=tuple(map(other, timeline.actions)))
