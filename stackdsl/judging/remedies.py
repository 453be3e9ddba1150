"""Searches for changes with which a scenario stands: numbers, friction, counterweights, shifts, props."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import floor, inf, log10
from typing import Final, TypeAlias

from stability.analysis.load_factor import load_factor
from stability.analysis.margins import Counterweight, counterweight, least_friction
from stability.analysis.piling import Piling
from stability.analysis.repair import BrickShift, Propping, SeveralShifts, Shifting, propping
from stability.contact_law import Friction, as_friction
from stability.model import BodyId
from stability.problem import Crushing, Placed, Stability, Verdict
from stackdsl.judging.numbers import ScenarioNumber, ScenarioNumbers
from stackdsl.judging.proofs import Proofs, proofs_of
from stackdsl.timeline import Action, JointsAction, Placement, Timeline
from stackdsl.wording import rounded_up

# Bisection between a number for which a property holds and a number for which it fails.
#
# The property may be undecided at the limit and close to it. Then the bisection runs from both sides towards the first
# undecided number, and both ends of the bracket stay certain.


MOST_HALVINGS: Final = 100
OPEN: Final = 0.25  # of the tolerance: distance of either side to an undecided number

Holds: TypeAlias = Callable[[float], bool | None]  # None if undecided


@dataclass(frozen=True, slots=True)
class Bracket:
    """A number for which a property holds and a number for which it fails; both were tried."""

    holds: float
    fails: float
    is_open: bool = False  # whether a number between them was tried and is undecided

    @property
    def width(self) -> float:
        """Relative distance of the two numbers; 0 if both are zero."""
        size = max(abs(self.holds), abs(self.fails))
        return abs(self.holds - self.fails) / size if size else 0.0


@dataclass(frozen=True, slots=True)
class BracketTolerance:
    """Distance of both sides of a bracket at which the bisection ends."""

    within: float  # as a share of the larger of both
    whole: bool = False  # whether only whole numbers are tried, so that the sides end next to each other
    nothing: float = 0.0  # an absolute distance that always suffices, for a limit at zero

    def is_of(self, one: float, other: float) -> bool:
        """Return whether two numbers are within the tolerance."""
        close = 1.0 if self.whole else max(self.nothing, self.within * max(abs(one), abs(other)))
        return abs(one - other) <= close

    def middle(self, one: float, other: float) -> float:
        """Return the middle of two numbers, rounded down if `whole`."""
        middle = 0.5 * (one + other)
        return float(floor(middle)) if self.whole else middle


def narrow_bracket(holds: float, fails: float, closeness: BracketTolerance, holds_at: Holds) -> Bracket:
    """Return the bracket, halved until both sides are close to each other, or close to an undecided number."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(holds, fails):
            break
        middle = closeness.middle(holds, fails)
        is_held = holds_at(middle)
        if is_held is None:
            closer = replace(closeness, within=OPEN * closeness.within)
            return Bracket(
                _closed_in(holds, middle, closer, lambda value: holds_at(value) is True),
                _closed_in(fails, middle, closer, lambda value: holds_at(value) is False),
                is_open=True,
            )
        holds, fails = (middle, fails) if is_held else (holds, middle)
    return Bracket(holds, fails)


def _closed_in(
    certain: float, undecided: float, closeness: BracketTolerance, is_certain: Callable[[float], bool]
) -> float:
    """Return the certain number that is nearest to an undecided one."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(certain, undecided):
            break
        middle = closeness.middle(certain, undecided)
        certain, undecided = (middle, undecided) if is_certain(middle) else (certain, middle)
    return certain


# The least change of one number with which a property holds.
#
# Numbers further and further away are tried on either side until the property holds. Bisection then finds the limit
# between that number and the last one that failed. Every result was itself tried: the property holds there, and fails
# just before.


CLOSE: Final = 1e-6  # of the number: distance of both sides of a limit at which the bisection ends
DIGITS: Final = 4  # significant digits of a reported limit, if the property holds there


@dataclass(frozen=True, slots=True)
class NumberLimit:
    """The nearest number on one side for which a property holds."""

    value: float  # the property holds here
    beyond: float  # and fails here
    least: bool  # whether it holds from `value` upwards, rather than up to `value`


def limits(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> tuple[NumberLimit, ...]:
    """Return the limits on both sides of a number for which a property fails.

    `steps` are increasing distances at which numbers are tried; a limit beyond the last is not found. With `whole`,
    only whole numbers are tried.
    """
    nearest = (_on_side(number, [sign * step for step in steps], whole, holds) for sign in (-1.0, 1.0))
    return tuple(limit for limit in nearest if limit is not None)


def _on_side(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> NumberLimit | None:
    fails = number
    for step in steps:
        tried = number + step
        held = holds(tried)
        if held:
            return _limit_between(tried, fails, whole, holds)
        if held is False:
            fails = tried
    return None


def _limit_between(held: float, fails: float, whole: bool, holds: Holds) -> NumberLimit | None:
    """Return the limit between a number that holds and one that fails; None if undecided numbers keep them apart."""
    bracket = narrow_bracket(held, fails, BracketTolerance(CLOSE, whole), holds)
    if whole:
        return _limit(bracket.holds, bracket.fails)
    return _rounded(bracket.holds, bracket.fails, holds) if bracket.width <= 2.0 * CLOSE else None


def _rounded(held: float, fails: float, holds: Holds) -> NumberLimit:
    """Return the limit rounded to `DIGITS`, to nearest or else towards the side that holds; exact if neither holds."""
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
# With another number or more friction, the whole build that statics can judge must stand. With a counterweight, the
# build must stand up to and including the step that falls now; a later step may still fall.


MOST_NUMBERS: Final = 8
MOST_FRICTIONS: Final = 5  # steps of the build, one after the other, that may need more friction than those before
MOST_COUNTERWEIGHTS: Final = 5  # that are tried by a verdict, the least first
HEAVIEST: Final = 1e3  # times the mass of all bricks: a heavier counterweight is not reported


@dataclass(frozen=True, slots=True)
class OtherNumber:
    """A number of the file, and the nearest value with which everything stands."""

    number: ScenarioNumber
    limit: NumberLimit


@dataclass(frozen=True, slots=True)
class MoreFriction:
    """The least friction with which everything stands."""

    factor: float  # on all coefficients; inf if it is proven that no friction is enough
    coefficient: float  # between bricks, with that factor
    alike: bool  # whether all coefficients are equal


@dataclass(frozen=True, slots=True)
class HeavierBrick:
    """The least counterweight: a brick that is heavier from the start."""

    brick: BodyId
    mass: float  # to add to the brick [kg]
    next_to_fall: tuple[BodyId, ...]  # bricks that then fall at a later step; empty if everything stands


@dataclass(frozen=True, slots=True)
class StrongerJoints:
    """All joints stronger by a common factor."""

    factor: float  # inf if no strength is enough: a motion opens no joint


@dataclass(frozen=True, slots=True)
class Remedies:
    """Changes with which a falling scenario stands; each was tried."""

    numbers: tuple[OtherNumber, ...] = ()
    friction: MoreFriction | None = None  # None if no amount is proven to be enough, nor that none is
    joints: StrongerJoints | None = None  # likewise; None also without joints
    counterweight: HeavierBrick | None = None  # None if none was found
    nothing_rises: bool = False  # whether no brick rises in the fall, which proves that no counterweight helps
    crushing: Crushing | None = None  # the cause, if no brick falls before one crushes

    def in_order(self) -> Iterator[OtherNumber | MoreFriction | StrongerJoints | HeavierBrick]:
        """Yield what helps: first what keeps all that is built, then other counts, such as fewer levels."""
        yield from (remedy for remedy in self.numbers if not remedy.number.whole)
        if self.joints is not None and self.joints.factor < inf:
            yield self.joints
        if self.friction is not None and self.friction.factor < inf:
            yield self.friction
        if self.counterweight is not None:
            yield self.counterweight
        yield from (remedy for remedy in self.numbers if remedy.number.whole)


def remedies_of(scenario_numbers: ScenarioNumbers, timeline: Timeline, proofs: Proofs) -> Remedies:
    """Return the remedies of a timeline whose `proofs` end with a fall."""
    verdict = proofs.assembly.verdict()
    if verdict.stability is not Stability.UNSTABLE:
        return Remedies()
    if verdict.crushing is not None:
        numbers = tuple(_numbers(scenario_numbers, set(verdict.moving)))
        return Remedies(numbers, crushing=verdict.crushing)
    if timeline.world.has_joints:
        numbers = tuple(_numbers(scenario_numbers, set(verdict.moving)))
        return Remedies(numbers, joints=stronger_joints(timeline, proofs))
    rising = rising_in(verdict)
    return Remedies(
        tuple(_numbers(scenario_numbers, set(verdict.moving))),
        more_friction(timeline, proofs),
        counterweight=_counterweight(timeline, proofs, rising),
        nothing_rises=not rising,
    )


def _verdict(timeline: Timeline) -> tuple[Stability, tuple[BodyId, ...]]:
    """Return the verdict on the part of a timeline that statics can judge, and the bricks that move in a fall."""
    verdict = proofs_of(timeline, names_smallest=False).assembly.verdict()
    return verdict.stability, verdict.moving


def _stands(timeline: Timeline | None) -> bool | None:
    """Return whether a timeline stands; None if it is missing or undecided."""
    stability = Stability.UNDECIDED if timeline is None else _verdict(timeline)[0]
    return None if stability is Stability.UNDECIDED else stability is Stability.STABLE


def _numbers(scenario_numbers: ScenarioNumbers, moving: set[BodyId]) -> Iterator[OtherNumber]:
    for _, number in zip(range(MOST_NUMBERS), scenario_numbers.numbers(moving), strict=False):

        def holds(value: float, number: ScenarioNumber = number) -> bool | None:
            return _stands(scenario_numbers.timeline(number, value))

        yield from (OtherNumber(number, limit) for limit in limits(number.number, number.steps, number.whole, holds))


def stronger_joints(timeline: Timeline, proofs: Proofs) -> StrongerJoints | None:
    """Return the strength that the worst step needs, as a multiple of the present one; None if it is not found.

    Joints of s times the strength bear a load if the present ones bear 1 / s of it: dry contacts bear both alike.
    """
    strength = 1.0
    for _ in range(MOST_FRICTIONS):
        found = load_factor(proofs.assembly.problem())
        if found is None or not found.factor < 1.0:
            return None
        if found.factor == 0.0:
            return StrongerJoints(inf)
        needed = strength / found.factor
        strength = float(rounded_up(needed, 4))
        proofs = proofs_of(with_stronger_joints(timeline, strength), names_smallest=False)
        if proofs.verdict.stability is Stability.STABLE:
            return StrongerJoints(strength)
    return None


def with_stronger_joints(timeline: Timeline, factor: float) -> Timeline:
    """Return the timeline with all joints stronger by a factor."""
    actions = [
        replace(action, joints=action.joints.times(factor)) if isinstance(action, JointsAction) else action
        for action in timeline.actions
    ]
    world = replace(timeline.world, joints=timeline.world.joints.times(factor))
    return replace(timeline, world=world, actions=tuple(actions))


def more_friction(timeline: Timeline, proofs: Proofs) -> MoreFriction | None:
    """Return the friction that the worst step needs: raise it for the next step that falls, until none does."""
    factor = 1.0
    world = timeline.world
    if proofs.assembly.problem().ties:
        return None  # not computed for tensions that are not known
    written, usual, alike = world.roughest, as_friction(world.friction).usual, world.has_uniform_friction
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
    """Return numbers of three digits to try for a limit between these two, the least first; the last is enough.

    For example, a limit of 150 is proven to lie between 149.9999 and 150.0001; rounding up only the second gives 151,
    more than is needed.
    """
    return sorted({float(rounded_up(number)) for number in (too_little, enough) if number > 0.0})


def masses_of(weight: Counterweight, gravity: float) -> list[float]:
    """Return the masses to try as a counterweight [kg], the least first."""
    return in_three_digits(weight.too_little / gravity, weight.weight / gravity)


def with_friction(timeline: Timeline, factor: float) -> Timeline:
    """Return a timeline with all coefficients of friction times a factor."""
    world = timeline.world
    planes = tuple(replace(plane, friction=factor * plane.friction) for plane in world.planes)
    friction = world.friction
    rougher = friction.times(factor) if isinstance(friction, Friction) else factor * friction
    return replace(timeline, world=replace(world, friction=rougher, planes=planes))


def rising_in(verdict: Verdict) -> Sequence[BodyId]:
    """Return the bricks that rise in a fall; weight on any other brick does not reduce the power of the motion."""
    motion = verdict.motion
    return [name for name, (velocity, _) in sorted(motion.velocity.items()) if velocity[2] > 0.0] if motion else []


def _counterweight(timeline: Timeline, proofs: Proofs, rising: Sequence[BodyId]) -> HeavierBrick | None:
    """Return the least counterweight on a rising brick that prevents the fall."""
    problem, gravity = proofs.assembly.problem(), timeline.world.gravity
    rising = () if problem.ties else rising
    weights = [weight for brick in rising if (weight := counterweight(problem, brick)) is not None]
    total = sum(placed.brick.mass for placed in problem.bricks.values())
    for weight in sorted(weights, key=lambda each: (each.weight, each.brick))[:MOST_COUNTERWEIGHTS]:
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
    """Return a timeline with another mass of a brick [kg]."""

    def changed(action: Action) -> Action:
        if not isinstance(action, Placement) or action.brick.id != brick:
            return action
        return replace(action, brick=replace(action.brick, mass=mass))

    return replace(timeline, actions=tuple(map(changed, timeline.actions)))


# Changes with which a falling build stands: shifts, counterweights, friction, props. Each is tried.


Suggestion = BrickShift | SeveralShifts | HeavierBrick | MoreFriction | StrongerJoints | Propping


@dataclass(frozen=True, slots=True)
class FallingBuild:
    """A build that falls."""

    timeline: Timeline
    proofs: Proofs

    @property
    def verdict(self) -> Verdict:
        """The verdict of the fall."""
        return self.proofs.verdict


def suggestions(build: FallingBuild, piling: Piling, on_progress: Callable[[], None]) -> Iterator[Suggestion]:
    """Yield changes as they are found: quick ones first, then shifts, the least first.

    `on_progress` is called after each trial.
    """
    if build.timeline.world.has_joints:  # the other changes are searched for dry contacts
        joints = stronger_joints(build.timeline, build.proofs)
        if joints is not None and joints.factor < inf:
            yield joints
        return
    if build.verdict.crushing is not None:
        return
    # Other changes are searched for rigid bricks under their weight alone.
    world = build.timeline.world
    if build.timeline.has_loads or world.strengths or world.ties:
        rougher = more_friction(build.timeline, build.proofs)
        if rougher is not None and rougher.factor < inf:
            yield rougher
        heavier = _counterweight(build.timeline, build.proofs, rising_in(build.verdict))
        if heavier is not None:
            yield heavier
        return
    fall = piling.first_fall()
    if fall is None or fall[1].stability is not Stability.UNSTABLE:
        return
    yield from _counterweights(build, piling, fall[0])
    friction = more_friction(build.timeline, build.proofs)
    if friction is not None and friction.factor < float("inf"):
        yield friction
    props = propping(piling, lambda _: on_progress())
    if props is not None:
        yield props
    yield from _shifts(Shifting(piling, on_progress), fall[0], build.verdict)


def _shifts(shifting: Shifting, turn: int, verdict: Verdict) -> Iterator[BrickShift | SeveralShifts]:
    """Yield the least shift of every brick for which one is enough, or else shifts of several bricks.

    An interruption by the user still yields the shifts found so far.
    """
    shifts: list[BrickShift] = []
    interruption: KeyboardInterrupt | None = None
    try:
        for brick in shifting.candidates(turn, verdict):
            shift = shifting.least(brick, {})
            shifts += [shift] if shift is not None else []
    except KeyboardInterrupt as error:
        interruption = error
    yield from sorted(shifts, key=lambda each: (each.length, each.brick))
    if interruption is not None:
        raise interruption
    if not shifts and (several := shifting.several()) is not None:
        yield several


def _counterweights(build: FallingBuild, piling: Piling, first: int) -> Iterator[HeavierBrick]:
    """Yield a counterweight for every brick on which one is enough, the least first; each was tried."""
    problem, gravity = build.proofs.assembly.problem(), build.timeline.world.gravity
    weights = [weight for brick in rising_in(build.verdict) if (weight := counterweight(problem, brick)) is not None]
    for weight in sorted(weights, key=lambda each: (each.weight, each.brick)):
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
