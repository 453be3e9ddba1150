"""The published impact model: has a hit the energy to disturb the brick that it meets, and all that rests on it?

Source: the stack-stability thesis, section 3.6. Its model:
- The kinetic energy is that of the hitting brick's flight, from its mass and its speed before the hit; its turning
  counts for nothing, and neither do the direction of the hit and the place where it lands.
- The potential energy is that of the hit brick and of what it carries: mass above, times g, times the height of com
  above over the centre point of the hit brick's main contact.
- A threshold: with more kinetic than potential energy the brick and all above it are woken, and the engine handles the
  hit. With less nothing happens, and the engine handles it as if the stack could not move.
- Every hit is tested by itself; energies of several hits are not added.

So a hit is ignored or tears all loose that stands above it, and a tall load makes a brick immovable although a real one
is only held by friction. Both are kept. docs/decisions/0013 says how the text was read where it leaves something open.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from stability.geometry.vectors import dot
from stability.graph import from_the_top, with_all_above
from stability.model import BodyId, Vec3
from stability.published.leaning import LeaningBrick, height
from stability.published.readings import AS_READ, ActsAt, Readings
from stability.published.support import Load, StackedBrick, shares

MILLI = 1e-3


@dataclass(frozen=True, slots=True)
class Impact:
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
    loads: Mapping[BodyId, Load],
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
    loads: Mapping[BodyId, Load],
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
