"""Searches for changes with which a scenario stands: numbers, friction, counterweights, shifts, props."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import floor, inf, log10
from typing import Final, TypeAlias

from stability.analysis.margins import Counterweight, counterweight, least_friction
from stability.analysis.repair import BrickShift, Piling, Propping, SeveralShifts, Shifting, propping
from stability.contact_law import Friction, as_friction
from stability.model import BodyId
from stability.problem import Placed, Stability, Verdict
from stackdsl.judging.numbers import ScenarioNumber, ScenarioNumbers
from stackdsl.judging.proofs import Proofs, proofs_of
from stackdsl.timeline import Action, Placement, Timeline
from stackdsl.wording import rounded_up

# Bisection between a number for which a property holds and one for which it does not.
#
# Whether it holds may be open close to the limit, as it is on the limit itself. Then both sides are closed in on what
# is open, and what comes out is still certain on either side.


MOST_HALVINGS: Final = 100
OPEN: Final = 0.25  # of the width: so near to what is open both sides go

Holds: TypeAlias = Callable[[float], bool | None]  # None where that cannot be said


@dataclass(frozen=True, slots=True)
class Bracket:
    """Two numbers between which it changes; both were asked for."""

    holds: float
    fails: float
    is_open: bool = False  # whether a number between them was asked for, and could not be judged

    @property
    def width(self) -> float:
        """How far apart they are, relative to the larger; of zero and zero, nothing."""
        size = max(abs(self.holds), abs(self.fails))
        return abs(self.holds - self.fails) / size if size else 0.0


@dataclass(frozen=True, slots=True)
class BracketTolerance:
    """How near to each other both sides of a limit are to be."""

    within: float  # a share of the larger of both
    whole: bool = False  # of whole numbers: next to each other
    nothing: float = 0.0  # a width that always is narrow; where the limit is at zero, no share of it is

    def is_of(self, one: float, other: float) -> bool:
        """Whether two numbers are as near as that."""
        close = 1.0 if self.whole else max(self.nothing, self.within * max(abs(one), abs(other)))
        return abs(one - other) <= close

    def middle(self, one: float, other: float) -> float:
        """A number between two."""
        middle = 0.5 * (one + other)
        return float(floor(middle)) if self.whole else middle


def narrowed(holds: float, fails: float, closeness: BracketTolerance, asked: Holds) -> Bracket:
    """The bracket halved down until both sides are close enough, or close to what is open."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(holds, fails):
            break
        middle = closeness.middle(holds, fails)
        answer = asked(middle)
        if answer is None:
            closer = replace(closeness, within=OPEN * closeness.within)
            return Bracket(
                _closed_in(holds, middle, closer, lambda value: asked(value) is True),
                _closed_in(fails, middle, closer, lambda value: asked(value) is False),
                is_open=True,
            )
        holds, fails = (middle, fails) if answer else (holds, middle)
    return Bracket(holds, fails)


def _closed_in(certain: float, unsure: float, closeness: BracketTolerance, is_so: Callable[[float], bool]) -> float:
    """The number next to what is open for which it is still certain."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(certain, unsure):
            break
        middle = closeness.middle(certain, unsure)
        certain, unsure = (middle, unsure) if is_so(middle) else (certain, middle)
    return certain


# The least change of one number with which a property holds, shown from both sides.
#
# The number is tried further and further away, on either side, until it holds; between that and the last number for
# which it did not, the limit is halved down. What is handed out was tried itself: it holds there, and not just before.


CLOSE: Final = 1e-6  # of the number's size: sides of a limit this near to each other show it
DIGITS: Final = 4  # of a limit as people are told it, where it holds with so many


@dataclass(frozen=True, slots=True)
class NumberLimit:
    """The nearest number on one side for which it holds."""

    value: float  # it holds here
    beyond: float  # it does not here
    least: bool  # whether it holds from `value` upwards, rather than down to it


def limits(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> tuple[NumberLimit, ...]:
    """The limits on both sides of a number for which something does not hold.

    `steps`: how far away it is tried, each more than the one before; a limit further than the last is not found. Of a
    `whole` number, whole ones are tried.
    """
    found = (_on_side(number, [sign * step for step in steps], whole, holds) for sign in (-1.0, 1.0))
    return tuple(limit for limit in found if limit is not None)


def _on_side(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> NumberLimit | None:
    fails = number
    for step in steps:
        tried = number + step
        held = holds(tried)
        if held:
            return _shown(tried, fails, whole, holds)
        if held is False:
            fails = tried
    return None


def _shown(held: float, fails: float, whole: bool, holds: Holds) -> NumberLimit | None:
    """The limit between a number for which it holds and one for which it does not; None if it cannot be shown."""
    found = narrowed(held, fails, BracketTolerance(CLOSE, whole), holds)
    if whole:
        return _limit(found.holds, found.fails)
    return _told(found.holds, found.fails, holds) if found.width <= 2.0 * CLOSE else None


def _told(held: float, fails: float, holds: Holds) -> NumberLimit:
    """The limit in few digits, if it holds there: the nearest such number, or the next on the side that holds."""
    largest = max(abs(held), abs(fails))
    unit = 10.0 ** (floor(log10(largest)) + 1 - DIGITS) if largest > 0.0 else 1.0
    inwards = unit if held > fails else -unit
    nearest = unit * round(held / unit)
    for tried in (nearest, nearest + inwards):
        shown = float(f"{tried:.{DIGITS}g}")
        if abs(shown - held) <= 1.5 * unit and holds(shown):
            return _limit(shown, fails)
    return _limit(held, fails)


def _limit(held: float, fails: float) -> NumberLimit:
    return NumberLimit(held, fails, least=held > fails)


# Changes with which a falling scenario stands: numbers, friction, a counterweight. Each is tried.
#
# Numbers of the file and friction are asked to let everything stand that statics can judge; a counterweight, everything
# up to and with what falls, as more may fall after it.


MOST_KNOBS: Final = 8
MOST_FRICTIONS: Final = 5  # moments, one after the other, that may ask for more than those before
MOST_COUNTERWEIGHTS: Final = 5  # that are tried by a verdict, the least first
HEAVIEST: Final = 1e3  # times the mass of all that there is: what needs more is told as none


@dataclass(frozen=True, slots=True)
class OtherNumber:
    """A number of the file, and the nearest with which everything stands."""

    knob: ScenarioNumber
    limit: NumberLimit


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


def remedies_of(knobs: ScenarioNumbers, timeline: Timeline, proofs: Proofs) -> Remedies:
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


def _numbers(knobs: ScenarioNumbers, moving: set[BodyId]) -> Iterator[OtherNumber]:
    for _, knob in zip(range(MOST_KNOBS), knobs.found(moving), strict=False):

        def holds(value: float, knob: ScenarioNumber = knob) -> bool | None:
            return _stands(knobs.timeline(knob, value))

        yield from (OtherNumber(knob, limit) for limit in limits(knob.number, knob.steps, knob.whole, holds))


def more_friction(timeline: Timeline, proofs: Proofs) -> MoreFriction | None:
    """As much as the worst moment asks for: the next to fall is asked until nothing does."""
    factor = 1.0
    world = timeline.world
    written, usual, alike = world.roughest, as_friction(world.friction).usual, world.rubs_alike
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


# Changes with which a falling build stands: shifts, counterweights, friction, props. Each is tried.


Suggestion = BrickShift | SeveralShifts | HeavierBrick | MoreFriction | Propping


@dataclass(frozen=True, slots=True)
class FallingBuild:
    """A build that falls."""

    timeline: Timeline
    proofs: Proofs

    @property
    def verdict(self) -> Verdict:
        """Of what falls."""
        return self.proofs.verdict


def suggestions(asked: FallingBuild, piling: Piling, known: Callable[[], None]) -> Iterator[Suggestion]:
    """All that was found, as it is found: what takes a moment first, and then shifts, the least first."""
    fall = piling.first_fall()
    if fall is None or fall[1].stability is not Stability.UNSTABLE:
        return
    yield from _counterweights(asked, piling, fall[0])
    friction = more_friction(asked.timeline, asked.proofs)
    if friction is not None and friction.factor < float("inf"):
        yield friction
    props = propping(piling, lambda _: known())
    if props is not None:
        yield props
    yield from _shifts(Shifting(piling, known), fall[0], asked.verdict)


def _shifts(shifting: Shifting, turn: int, verdict: Verdict) -> Iterator[BrickShift | SeveralShifts]:
    """The least shift of each brick on which one is enough, or several; an interruption keeps those that are found."""
    shifts: list[BrickShift] = []
    pressed: KeyboardInterrupt | None = None
    try:
        for brick in shifting.candidates(turn, verdict):
            found = shifting.least(brick, {})
            shifts += [found] if found is not None else []
    except KeyboardInterrupt as error:
        pressed = error
    yield from sorted(shifts, key=lambda each: (each.length, each.brick))
    if pressed is not None:
        raise pressed
    if not shifts and (several := shifting.several()) is not None:
        yield several


def _counterweights(asked: FallingBuild, piling: Piling, first: int) -> Iterator[HeavierBrick]:
    """On each brick on which one is enough, the least first, each tried."""
    problem, gravity = asked.proofs.assembly.problem(), asked.timeline.world.gravity
    found = [weight for brick in rising_in(asked.verdict) if (weight := counterweight(problem, brick)) is not None]
    for weight in sorted(found, key=lambda each: (each.weight, each.brick)):
        for mass in masses_of(weight, gravity):
            fall = replace(piling, stages=_heavier(piling, weight.brick, mass)).first_fall(names_smallest=True)
            if fall is None or fall[0] > first:
                yield HeavierBrick(weight.brick, mass, fall[1].moving if fall else ())
                break


def _heavier(piling: Piling, brick: BodyId, more: float) -> list[list[Placed]]:
    def loaded(placed: Placed) -> Placed:
        heavy = replace(placed.brick, mass=placed.brick.mass + more)
        return replace(placed, brick=heavy) if placed.brick.id == brick else placed

    return [[loaded(placed) for placed in stage] for stage in piling.stages]
