"""The published impact model: does a hit have the energy to disturb the brick and all that rests on it?"""

from collections.abc import Collection, Container, Iterable, Mapping
from dataclasses import dataclass, field

from stability.engines.protocol import Engine
from stability.geometry.vectors import dot
from stability.graph import from_the_top, with_all_above
from stability.model import BodyId, Vec3
from stability.stabilizers.approach import Approaches, Attention
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

# The published impact model: has a hit the energy to disturb the brick that it meets, and all that rests on it?
#
# Source: the stack-stability thesis, section 3.6. Its model:
# - The kinetic energy is that of the hitting brick's flight, from its mass and its speed before the hit; its turning
#   counts for nothing, and neither do the direction of the hit and the place where it lands.
# - The potential energy is that of the hit brick and of what it carries: mass above, times g, times the height of com
#   above over the centre point of the hit brick's main contact.
# - A threshold: with more kinetic than potential energy the brick and all above it are woken, and the engine handles
#   the hit. With less nothing happens, and the engine handles it as if the stack could not move.
# - Every hit is tested by itself; energies of several hits are not added.
#
# So a hit is ignored or tears all loose that stands above it, and a tall load makes a brick immovable although a real
# one is only held by friction. Both are kept. docs/design/publication.md says how the text was read where it leaves something
# open.


MILLI = 1e-3


@dataclass(frozen=True, slots=True)
class ImpactEnergy:
    """What a hit brings, and what it is held against [J]."""

    kinetic: float
    potential: float

    @property
    def disturbs(self) -> bool:
        """Whether the hit brick is woken, with all above it."""
        return self.kinetic > self.potential

    def __str__(self) -> str:
        """Both energies, as in: 5.98 mJ against 0.457 mJ."""
        return f"{self.kinetic / MILLI:.3g} mJ against {self.potential / MILLI:.3g} mJ"


def energy_of_flight(mass: float, velocity_W: Vec3) -> float:
    """The kinetic energy of a brick's centre of mass [J]."""
    return 0.5 * mass * dot(velocity_W, velocity_W)


def energy_of_push(mass: float, impulse_W: Vec3) -> float:
    """What an impulse [N s] through the centre of a free brick at rest would give it [J]."""
    return 0.5 * dot(impulse_W, impulse_W) / mass


def energy_of_load(  # noqa: PLR0913, PLR0917 -- what the method knows of a stack, and how it is read
    brick: BodyId,
    stack: Mapping[BodyId, StackedBrick],
    loads: Mapping[BodyId, CarriedLoad],
    leaning: LeaningBrick | None,
    gravity: float,
    readings: Readings = AS_READ,
) -> float:
    """The potential energy of a brick of the stack and of what it carries, over what it stands on [J]."""
    lever = height_above(brick, stack, loads, readings) - footing(stack[brick], leaning)
    return loads[brick].mass * gravity * lever


def footing(brick: StackedBrick, leaning: LeaningBrick | None) -> float:
    """The height of the centre point of a brick's main contact; of one that leans, of its pivot [m]."""
    if leaning is not None:
        return leaning.pivot.height
    return height([point for area in brick.areas for point in area.points_W])


def height_above(
    brick: BodyId,
    stack: Mapping[BodyId, StackedBrick],
    loads: Mapping[BodyId, CarriedLoad],
    readings: Readings = AS_READ,
) -> float:
    """The height of com above of one brick [m]: Eq. 1 and 10 upright, with the shares that the plan gives.

    What goes to one of several supports acts as high as com above of the brick that hands it on.
    """
    rests_on = {name: other.rests_on for name, other in stack.items()}
    above = with_all_above(rests_on, [brick])
    moments = {name: stack[name].mass * stack[name].com_W[2] for name in above}  # [kg m]
    for name in from_the_top({name: rests_on[name] for name in above}):
        upright = moments[name] / loads[name].mass
        given = shares(loads[name], stack[name].areas, readings)
        at_contact = len(given) > 1 and readings.height_acts_at is ActsAt.CONTACT
        contacts = {area.on: height(area.points_W) for area in stack[name].areas} if at_contact else {}
        for share in given:
            if share.on in moments:
                moments[share.on] += share.mass * contacts.get(share.on, upright)
    return moments[brick] / loads[brick].mass


# Hits that the published method counts: those of bricks that are no second impact objects, each once.
#
# Source: the stack-stability thesis, section 3.6.1: "only the direct impacts will be accounted for, and no force from
# second impact objects". Unless it is read otherwise (`SecondObjects`), what has been part of the stack and falls on
# what still stands is such a second object.
#
# A hit must be seen before it happens: when an engine reports the contact, its solver has taken the speed away.


@dataclass(frozen=True, slots=True)
class DirectHit:
    """A brick of the stack is about to be hit."""

    by: BodyId
    brick: BodyId
    velocity_W: Vec3  # of the hitting brick, before the hit [m/s]


@dataclass
class DirectHits(BrickObserver):
    """Follows the bricks of one engine that may hit its stack."""

    engine: Engine
    rest: RestLimits
    second: SecondObjects = SecondObjects.EVER_STACKED
    _approaches: Approaches = field(init=False)
    _stacked: set[BodyId] = field(default_factory=set, init=False)  # second objects: are, or once were, in the stack
    _reported: set[tuple[BodyId, BodyId]] = field(
        default_factory=set, init=False
    )  # who was about to hit whom, last time

    def __post_init__(self) -> None:
        self._approaches = Approaches(self.engine, lambda _: Attention(self.rest.dwell, self.rest.speed))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What has become part of the stack may be a second object from now on, also when it falls off."""
        if self.second is SecondObjects.EVER_STACKED:
            self._stacked.update(bricks)
        self._approaches.frozen(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """A name may come back with another brick, which has never been part of the stack."""
        self._stacked.difference_update(bricks)
        self._approaches.gone(bricks)

    def coming(self, awake: Iterable[BodyId], stack: Container[BodyId]) -> list[DirectHit]:
        """The hits on bricks of the stack that the next step will bring, and that were not told of yet."""
        states = self.engine.states([brick for brick in awake if brick not in self._stacked])
        hits = self._approaches.hits(states, stack)
        told, self._reported = self._reported, {(hit.by, hit.brick) for hit in hits}
        return [
            DirectHit(hit.by, hit.brick, states[hit.by].velocity_W) for hit in hits if (hit.by, hit.brick) not in told
        ]
