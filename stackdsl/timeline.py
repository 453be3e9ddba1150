"""What the compiler hands to the runner and the judge: plain data in SI units, without YAML and without engine.

Frame W: z up against gravity. A tilted scene is turned as a whole, so gravity always points down.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import TypeAlias

from stability.model import AT_REST, BodyId, Brick, Plane, Pose, Vec3


@dataclass(frozen=True, slots=True)
class World:
    """What does not move."""

    gravity: float  # [m/s2], along -z
    friction: float  # Coulomb coefficient of brick on brick
    planes: tuple[Plane, ...]  # the ground first


@dataclass(frozen=True, slots=True)
class Placement:
    """One brick set down at a time; or let go in the air if `drop`, or thrown."""

    time: float  # [s]
    brick: Brick
    level: int  # storey, counted from 1
    pose: Pose
    drop: bool = False
    inserted: bool = False  # slid into what stands by then, rather than built on
    # Whether an impact throws it, or lets it go above, at what stands by then. So it is no part of the structure and
    # belongs to no level, which is 0.
    thrown: bool = False
    velocity_W: Vec3 = AT_REST  # with which it comes [m/s]
    flight: float = 0.0  # until a thrown one meets what it is aimed at [s]


@dataclass(frozen=True, slots=True)
class Removal:
    """Bricks pulled out together at a time."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class Push:
    """An impulse on a brick at a time."""

    time: float  # [s]
    brick: BodyId
    impulse_W: Vec3  # [N s]
    offset_W: Vec3 = (0.0, 0.0, 0.0)  # from the centre of the brick to the point that is pushed [m]


Action: TypeAlias = Placement | Removal | Push
Moment: TypeAlias = tuple[Placement, ...] | Removal | Push  # what is done together


def arrival_of(action: Action) -> float:
    """When it does something to the structure: at once, unless it has to fly there [s]."""
    return action.time + (action.flight if isinstance(action, Placement) else 0.0)


@dataclass(frozen=True, slots=True)
class Timeline:
    """All that happens to the structure, in order of time."""

    world: World
    actions: tuple[Action, ...]  # by time, then in the author's order
    hold: float  # how long the structure is watched after the last action, or the last hit that arrives later [s]
    # Whether anything is asked that only motion shows. If not, a system with proofs does without an engine.
    watched: bool = True
    margins: tuple[str, ...] = ()  # those of the proof that are asked for, such as `tilt`
    closely: bool = False  # whether it is asked how something begins to fall, or where it lands
    aftermath: bool = True  # whether a collapse is followed for a while; if not, a run ends as soon as it is known

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The actions that set down, or let go, a brick."""
        return tuple(action for action in self.actions if isinstance(action, Placement))

    def moments(self) -> Iterator[Moment]:
        """What is done together: the bricks set down at one time, or one removal or push."""
        for (_, placing), group in groupby(self.actions, key=lambda action: (action.time, type(action) is Placement)):
            if placing:
                yield tuple(action for action in group if isinstance(action, Placement))
            else:
                yield from (action for action in group if not isinstance(action, Placement))

    @property
    def built(self) -> float:
        """When the last brick of the structure is placed [s]."""
        return max(placement.time for placement in self.placements if not placement.thrown)

    @property
    def end(self) -> float:
        """Until when the structure is watched [s]."""
        return max(arrival_of(action) for action in self.actions) + self.hold

    @property
    def levels(self) -> int:
        """The number of the highest level."""
        return max(placement.level for placement in self.placements)
