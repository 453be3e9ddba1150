"""The published impact model: the energy of a hit, and that of the brick and all bricks on it."""

from collections.abc import Collection, Container, Iterable, Mapping
from dataclasses import dataclass, field

from stability.engines.protocol import Engine
from stability.geometry.vectors import dot
from stability.graph import from_the_top, with_all_above
from stability.model import BodyId, Vec3
from stability.stabilizers.approach import HitPredictor, PredictionLimits
from stability.stabilizers.protocol import BrickObserver
from stability.stabilizers.published.leaning import LeaningBrick, height
from stability.stabilizers.published.support import (
    AS_READ,
    ActsAt,
    CarriedLoad,
    Readings,
    SecondObjects,
    StackedBrick,
    shares,
)
from stability.stabilizers.rest import RestLimits

# Source: the stack-stability thesis, section 3.6. Its model:
# - The kinetic energy is that of the hitting brick's translation, from its mass and its speed before the hit; its
#   rotation, the direction of the hit and the point of impact have no effect.
# - The potential energy is that of the hit brick and its load: mass above, times g, times the height of com above over
#   the centre point of the hit brick's main contact.
# - If the kinetic energy exceeds the potential energy, the brick and all bricks above it wake, and the engine simulates
#   the hit. Otherwise none wakes, and the engine simulates the hit as on an immovable stack.
# - Every hit is tested alone; energies of several hits are not added.
#
# So a hit either is ignored or wakes all bricks above, and a tall load makes a brick immovable although only friction
# holds a real one. Both properties are kept. docs/design/publication.md describes the reading of ambiguous text.


MILLI = 1e-3


@dataclass(frozen=True, slots=True)
class ImpactEnergy:
    """Energy of a hit, and its threshold [J]."""

    kinetic: float
    potential: float

    @property
    def disturbs(self) -> bool:
        """Whether the hit wakes the brick and all bricks above it."""
        return self.kinetic > self.potential

    def __str__(self) -> str:
        """Format both energies, as in: kinetic energy 5.98 mJ, potential energy 0.457 mJ."""
        return f"kinetic energy {self.kinetic / MILLI:.3g} mJ, potential energy {self.potential / MILLI:.3g} mJ"


def energy_of_flight(mass: float, velocity_W: Vec3) -> float:
    """Return the kinetic energy of a brick's translation [J]."""
    return 0.5 * mass * dot(velocity_W, velocity_W)


def energy_of_push(mass: float, impulse_W: Vec3) -> float:
    """Return the kinetic energy that an impulse [N s] through its centre gives a free brick at rest [J]."""
    return 0.5 * dot(impulse_W, impulse_W) / mass


def energy_of_load(  # noqa: PLR0913, PLR0917 -- the method's state of a stack, and the readings
    brick: BodyId,
    stack: Mapping[BodyId, StackedBrick],
    loads: Mapping[BodyId, CarriedLoad],
    leaning: LeaningBrick | None,
    gravity: float,
    readings: Readings = AS_READ,
) -> float:
    """Return the potential energy of a brick of the stack and its load, relative to its main contact [J]."""
    lever = height_above(brick, stack, loads, readings) - footing(stack[brick], leaning)
    return loads[brick].mass * gravity * lever


def footing(brick: StackedBrick, leaning: LeaningBrick | None) -> float:
    """Return the height of the centre of a brick's main contact, or of a leaning brick's pivot [m]."""
    if leaning is not None:
        return leaning.pivot.height
    return height([point for area in brick.areas for point in area.points_W])


def height_above(
    brick: BodyId,
    stack: Mapping[BodyId, StackedBrick],
    loads: Mapping[BodyId, CarriedLoad],
    readings: Readings = AS_READ,
) -> float:
    """Return the height of com above of one brick [m]: Eq. 1 and 10 applied vertically, with the shares of the plan.

    By default a share of one of several supports acts at the height of com above of the brick that passes it on.
    """
    rests_on = {name: other.rests_on for name, other in stack.items()}
    above = with_all_above(rests_on, [brick])
    moments = {name: stack[name].mass * stack[name].com_W[2] for name in above}  # [kg m]
    for name in from_the_top({name: rests_on[name] for name in above}):
        upright = moments[name] / loads[name].mass
        load_shares = shares(loads[name], stack[name].areas, readings)
        at_contact = len(load_shares) > 1 and readings.height_acts_at is ActsAt.CONTACT
        contacts = {area.on: height(area.points_W) for area in stack[name].areas} if at_contact else {}
        for share in load_shares:
            if share.on in moments:
                moments[share.on] += share.mass * contacts.get(share.on, upright)
    return moments[brick] / loads[brick].mass


# Hits that the published method counts: those of bricks that are no second impact objects, each once.
#
# Source: the stack-stability thesis, section 3.6.1: "only the direct impacts will be accounted for, and no force from
# second impact objects". By the default reading (`SecondObjects`) a brick that was once part of the stack is a second
# object when it falls on the stack.
#
# Hits must be predicted: when an engine reports the contact, its solver has already removed the speed.


@dataclass(frozen=True, slots=True)
class DirectHit:
    """Imminent hit on a brick of the stack."""

    by: BodyId
    brick: BodyId
    velocity_W: Vec3  # of the hitting brick, before the hit [m/s]


@dataclass
class DirectHits(BrickObserver):
    """Predicts hits on the stack of one engine."""

    engine: Engine
    rest: RestLimits
    second: SecondObjects = SecondObjects.EVER_STACKED
    _approaches: HitPredictor = field(init=False)
    _stacked: set[BodyId] = field(default_factory=set, init=False)  # second objects: once in the stack
    _reported: set[tuple[BodyId, BodyId]] = field(default_factory=set, init=False)  # hits of the last call, as pairs

    def __post_init__(self) -> None:
        self._approaches = HitPredictor(self.engine, lambda _: PredictionLimits(self.rest.dwell, self.rest.speed))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Record bricks of the stack as possible second objects, even after they fall off."""
        if self.second is SecondObjects.EVER_STACKED:
            self._stacked.update(bricks)
        self._approaches.frozen(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the records of removed bricks: a new brick may get the same name."""
        self._stacked.difference_update(bricks)
        self._approaches.removed(bricks)

    def coming(self, awake: Iterable[BodyId], stack: Container[BodyId]) -> list[DirectHit]:
        """Return the hits on bricks of the stack in the next step that were not reported yet."""
        states = self.engine.states([brick for brick in awake if brick not in self._stacked])
        hits = self._approaches.hits(states, stack)
        reported, self._reported = self._reported, {(hit.by, hit.brick) for hit in hits}
        return [
            DirectHit(hit.by, hit.brick, states[hit.by].velocity_W)
            for hit in hits
            if (hit.by, hit.brick) not in reported
        ]
