"""What would let a build stand that falls: shifts, counterweights, friction, props, each searched for and tried."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from stability.model import BodyId
from stability.statics.facts import Placed, Stability, Verdict
from stability.statics.margins.counterweight import counterweight
from stability.statics.mending.piling import Piling
from stability.statics.mending.propping import Propping, propping
from stability.statics.mending.shifts import BrickShift, SeveralShifts, Shifting
from stackdsl.judging.proofs import Proofs
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, masses_of, more_friction, rising_in
from stackdsl.timeline import Timeline

Suggestion = BrickShift | SeveralShifts | HeavierBrick | MoreFriction | Propping


@dataclass(frozen=True, slots=True)
class Asked:
    """A build that falls."""

    timeline: Timeline
    proofs: Proofs

    @property
    def verdict(self) -> Verdict:
        """Of what falls."""
        return self.proofs.verdict


def suggestions(asked: Asked, piling: Piling, known: Callable[[], None]) -> Iterator[Suggestion]:
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


def _counterweights(asked: Asked, piling: Piling, first: int) -> Iterator[HeavierBrick]:
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
