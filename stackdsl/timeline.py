"""What the compiler hands to the runner and the judge: plain data in SI units, without YAML and without engine.

Frame W: z up against gravity. A tilted scene is turned as a whole, so gravity always points down.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import groupby
from math import inf
from typing import Literal, TypeAlias

from stability.contact_law import GivenFriction, as_friction
from stability.dynamics.ground_motion import GroundMotion, HandCourse
from stability.model import AT_REST, BodyId, Brick, Plane, Pose, Vec3
from stability.problem import Tolerances
from stability.statics.assembly import Assembly


@dataclass(frozen=True, slots=True)
class FixedWorld:
    """What does not move."""

    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick: one number, unless some rub otherwise
    planes: tuple[Plane, ...]  # the ground first
    touching: float = inf  # [m] statics count no wider gap as contact, as `Tolerances.within`

    def assembly(self) -> Assembly:
        """What statics judges, with no bricks as yet."""
        return Assembly(self.planes, self.friction, self.gravity, self.tolerances, overlap=inf)

    @property
    def tolerances(self) -> Tolerances:
        """How exact statics is."""
        return Tolerances(within=self.touching)

    @property
    def roughest(self) -> float:
        """The largest coefficient of all that are said."""
        return max(as_friction(self.friction).most, *(plane.friction for plane in self.planes))

    @property
    def rubs_alike(self) -> bool:
        """Whether all that touches has the same coefficient."""
        return all(plane.friction == self.friction for plane in self.planes)


class Arrival(StrEnum):
    """How a brick comes."""

    SET_DOWN = "set down"
    SLID_IN = "slid in"  # into what stands by then, rather than built on
    BY_HAND = "by hand"  # in one, which lowers it to where it is to stay, and lets it go there
    LET_GO = "let go"  # in the air, to fall onto what stands by then and be a part of it
    DROPPED = "dropped"  # by an impact, onto what stands by then
    THROWN = "thrown"  # by an impact, at what stands by then


@dataclass(frozen=True, slots=True)
class ErrorSpread:
    """How an error about zero is spread."""

    kind: Literal["normal", "uniform"]
    width: float  # standard deviation, or how far to either side


@dataclass(frozen=True, slots=True)
class Jitter:
    """The errors with which hands set something down, from where it belongs on what is there."""

    position: ErrorSpread | None = None  # along each of two level axes [m]
    yaw: ErrorSpread | None = None  # about the upright [rad]


@dataclass(frozen=True, slots=True)
class Placement:
    """One brick that comes at a time."""

    time: float  # [s]
    brick: Brick
    level: int  # storey, counted from 1; 0 for what an impact drops or throws, which belongs to none
    pose: Pose
    arrival: Arrival = Arrival.SET_DOWN
    velocity_W: Vec3 = AT_REST  # with which it comes [m/s]
    flight: float = 0.0  # until what an impact drops or throws meets what it is aimed at [s]
    step: str = ""  # of the build, such as `step 5`, where several build its level
    came: Pose | None = None  # where a hand comes with it, if one does; it lets it go at `pose`
    together: bool = False  # whether hands set it down as one with the brick before it

    @property
    def at_rest(self) -> bool:
        """Whether it is where it is to stay as it comes."""
        return self.arrival in (Arrival.SET_DOWN, Arrival.SLID_IN)

    @property
    def builds(self) -> bool:
        """Whether it is built on, rather than slid in or flying."""
        return self.arrival in (Arrival.SET_DOWN, Arrival.LET_GO, Arrival.BY_HAND)

    @property
    def hits(self) -> bool:
        """Whether an impact drops or throws it, so that it is no part of the structure."""
        return self.arrival in (Arrival.DROPPED, Arrival.THROWN)


@dataclass(frozen=True, slots=True)
class Removal:
    """Bricks pulled out together at a time."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class PushAction:
    """An impulse on a brick at a time."""

    time: float  # [s]
    brick: BodyId
    impulse_W: Vec3  # [N s]
    offset_W: Vec3 = (0.0, 0.0, 0.0)  # from the centre of the brick to the point that is pushed [m]


@dataclass(frozen=True, slots=True)
class ShakeAction:
    """The ground begins to shake."""

    time: float  # [s]
    motion: GroundMotion


@dataclass(frozen=True, slots=True)
class MoveAction:
    """A hand moves a brick: it carries it, and holds it at rest from the end of the way on, or slides it."""

    time: float  # [s]
    brick: BodyId
    course: HandCourse
    free_W: Vec3 | None = None  # unit; along it what is slid moves by itself, and may tilt; None if it is carried
    lowers: bool = False  # whether it came in this hand, through air in which it meets nothing


@dataclass(frozen=True, slots=True)
class HoldAction:
    """Hands hold bricks at rest from now on, as firmly as the ground; where some are in a hand already, these."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class LetGo:
    """Hands let bricks go, all at once, and withdraw."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


Handled: TypeAlias = MoveAction | HoldAction | LetGo
Done: TypeAlias = Removal | PushAction | ShakeAction | Handled
Action: TypeAlias = Placement | Done
Moment: TypeAlias = tuple[Placement, ...] | Done  # what is done together


def time_of_arrival(action: Action) -> float:
    """When it has done all that it does to the structure: at once, unless it has to fly there, or goes on [s]."""
    if isinstance(action, ShakeAction):
        return action.motion.ends
    return action.time + (action.flight if isinstance(action, Placement) else 0.0)


def leaves_to_engine(action: Action) -> bool:
    """Whether something is dropped, thrown, pushed, shaken or in a hand, which only an engine can follow."""
    return isinstance(action, PushAction | ShakeAction | Handled) or (
        isinstance(action, Placement) and not action.at_rest
    )


def _ends_bringing(action: Action, let_go: Mapping[BodyId, float]) -> bool:
    """Whether it is a part of how hands bring bricks, which they let go at these times [s]."""
    if isinstance(action, MoveAction):
        return action.lowers and action.brick in let_go
    return isinstance(action, LetGo) and all(let_go.get(brick) == action.time for brick in action.bricks)


@dataclass(frozen=True, slots=True)
class Timeline:
    """All that happens to the structure, in order of time."""

    world: FixedWorld
    actions: tuple[Action, ...]  # by time, then in the author's order
    hold: float  # how long the structure is watched after the last action, or the last hit that arrives later [s]
    # Whether anything is asked that only motion shows. If not, a system with proofs does without an engine.
    watched: bool = True
    margins: tuple[str, ...] = ()  # those of the proof that are asked for, such as `tilt`
    told_margins: tuple[str, ...] = ()  # those that are told of few bricks, and that nothing depends on
    closely: bool = False  # whether it is asked how something begins to fall, or where it lands
    measures: tuple[str, ...] = ()  # what is measured only if it is asked for: `sway`, `penetration`
    followed: float = 1.0  # how long a collapse is followed, at most [s]
    jitter: Mapping[BodyId, Jitter] = field(default_factory=dict)  # by brick, of those that are set down with errors
    aftermath: bool = True  # whether a collapse is followed for a while; if not, a run ends as soon as it is known

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The actions by which a brick comes."""
        return tuple(action for action in self.actions if isinstance(action, Placement))

    def moments(self) -> Iterator[Moment]:
        """What is done together: the bricks set down at one time, or else one action."""
        for (_, placing), group in groupby(self.actions, key=lambda action: (action.time, type(action) is Placement)):
            if placing:
                yield tuple(action for action in group if isinstance(action, Placement))
            else:
                yield from (action for action in group if not isinstance(action, Placement))

    def as_set_down(self) -> "Timeline":
        """The same for statics: what a hand brings, and does not hold, is set down when it is let go."""
        held = {brick for action in self.actions if isinstance(action, HoldAction) for brick in action.bricks}
        brought = {each.brick.id for each in self.placements if each.arrival is Arrival.BY_HAND} - held
        let_go = {
            brick: action.time
            for action in reversed(self.actions)
            if isinstance(action, LetGo)
            for brick in action.bricks
            if brick in brought
        }
        actions: list[Action] = []
        for action in self.actions:
            if isinstance(action, Placement) and action.brick.id in let_go:
                time = let_go[action.brick.id]
                actions.append(replace(action, time=time, arrival=Arrival.SET_DOWN, came=None))
            elif not _ends_bringing(action, let_go):
                actions.append(action)
        return replace(self, actions=tuple(sorted(actions, key=lambda action: action.time))) if let_go else self

    @property
    def built(self) -> float:
        """When the last brick of the structure is placed [s]."""
        return max(placement.time for placement in self.placements if not placement.hits)

    @property
    def end(self) -> float:
        """Until when the structure is watched [s]."""
        return max(time_of_arrival(action) for action in self.actions) + self.hold

    @property
    def levels(self) -> int:
        """The number of the highest level."""
        return max(placement.level for placement in self.placements)
