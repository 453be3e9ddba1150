"""What of a scene is changed before it is played, for an engine that cannot do with what is real.

The publication's second system is of this kind: constants such as gravity and friction are changed until the engine
stacks. What comes of it is told in lengths of the scenario as it is written, and in seconds as they pass in the changed
scene; gravity is told in the same lengths, and so is weaker by as much as the bricks are larger.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import sqrt

from stackdsl.timeline import Action, Arrival, Placement, Timeline, World


@dataclass(frozen=True, slots=True)
class Modification:
    """Constants of a scene that are others than its author wrote; nothing is by default."""

    gravity: float | None = None  # [m/s2]
    friction: float | None = None  # Coulomb coefficient of every contact, with ground and walls as well
    size: float = 1.0  # times as large is all that has a length, at the same density

    @property
    def summary(self) -> str:
        """What is changed, in words; empty if nothing is."""
        return ", ".join(self._changes())

    def _changes(self) -> Iterator[str]:
        if self.gravity is not None:
            yield f"gravity {self.gravity:g} m/s2"
        if self.friction is not None:
            yield f"friction {self.friction:g} everywhere"
        if self.size != 1.0:
            yield f"all {self.size:g} times as large"


AS_WRITTEN = Modification()


def as_played(timeline: Timeline, modification: Modification) -> Timeline:
    """A timeline with the constants with which it is played, in the lengths in which it is written.

    Bricks that are larger in the same gravity move as those of the scenario do in a weaker one, so that is what this
    tells; that the engine does meet larger ones is up to who opens the world.
    """
    if modification == AS_WRITTEN:
        return timeline
    world = _world(timeline.world, modification)
    longer = sqrt(timeline.world.gravity / world.gravity)
    return replace(timeline, world=world, actions=tuple(_action(action, longer) for action in timeline.actions))


def _world(world: World, modification: Modification) -> World:
    gravity = world.gravity if modification.gravity is None else modification.gravity
    changed = replace(world, gravity=gravity / modification.size)
    if modification.friction is None:
        return changed
    planes = tuple(replace(plane, friction=modification.friction) for plane in world.planes)
    return replace(changed, friction=modification.friction, planes=planes)


def _action(action: Action, longer: float) -> Action:
    """The same; what is dropped falls for so many times as long, and what is thrown flies as long as it did."""
    if isinstance(action, Placement) and action.arrival is Arrival.DROPPED:
        return replace(action, flight=longer * action.flight)
    return action
