"""Timeline of a compiled scenario, the input of runner and judge: plain data in SI units, without YAML and engine.

Frame W: z up against gravity. A tilted scene is rotated as a whole, so gravity always points down.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from itertools import groupby
from math import inf
from typing import Literal, TypeAlias

from stability.contact_law import GivenFriction, as_friction
from stability.dynamics.ground_motion import GroundMotion, HandCourse
from stability.joints import DRY, Joints
from stability.loads import UNLOADED, LoadCourse, Loads
from stability.model import AT_REST, BodyId, Brick, Plane, Pose, Vec3
from stability.problem import Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.strength import Strength
from stability.supports import SupportMotion
from stability.ties import Tie


@dataclass(frozen=True, slots=True)
class FixedWorld:
    """Fixed parts of the scene: planes, gravity, friction."""

    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick: one coefficient, or a law with exceptions
    planes: tuple[Plane, ...]  # the ground first
    touching: float = inf  # [m] widest gap that statics counts as contact, as `Tolerances.within`
    joints: Joints = DRY
    loads: Loads = UNLOADED
    strengths: Mapping[BodyId, Strength] = field(default_factory=dict)  # of bricks, against crushing
    supports: tuple[SupportMotion, ...] = ()  # movements of the ground below bricks
    ties: tuple[Tie, ...] = ()  # judged at rest only

    def assembly(self) -> Assembly:
        """Return an assembly for statics, without bricks."""
        site = self.planes, self.friction, self.gravity, self.tolerances
        return Assembly(
            *site, overlap=inf, joints=self.joints, loads=self.loads, strengths=self.strengths, ties=self.ties
        )

    @property
    def has_joints(self) -> bool:
        """Return whether bodies may be joined, at any time."""
        return bool(self.joints.rules)

    @property
    def tolerances(self) -> Tolerances:
        """Return the tolerances of statics."""
        return Tolerances(within=self.touching)

    @property
    def roughest(self) -> float:
        """Return the largest coefficient of friction in the scene."""
        return max(as_friction(self.friction).most, *(plane.friction for plane in self.planes))

    @property
    def has_uniform_friction(self) -> bool:
        """Return whether all contacts have the same coefficient of friction."""
        return all(plane.friction == self.friction for plane in self.planes)


class Arrival(StrEnum):
    """How a brick enters the scene."""

    SET_DOWN = "set down"
    SLID_IN = "slid in"  # by an impact, into the existing structure
    BY_HAND = "by hand"  # a hand lowers it to its place and releases it there
    LET_GO = "let go"  # released in the air, to land and become part of the structure
    DROPPED = "dropped"  # by an impact
    THROWN = "thrown"  # by an impact


@dataclass(frozen=True, slots=True)
class ErrorSpread:
    """Distribution of an error with mean zero."""

    kind: Literal["normal", "uniform"]
    width: float  # standard deviation, or half the width of the uniform range


@dataclass(frozen=True, slots=True)
class Jitter:
    """Errors with which hands set a brick down, relative to its place on the bricks below."""

    position: ErrorSpread | None = None  # along each of two horizontal axes [m]
    yaw: ErrorSpread | None = None  # about the vertical axis [rad]


@dataclass(frozen=True, slots=True)
class Placement:
    """One brick enters the scene."""

    time: float  # [s]
    brick: Brick
    level: int  # storey, counted from 1; 0 for bricks that an impact drops or throws
    pose: Pose
    arrival: Arrival = Arrival.SET_DOWN
    velocity_W: Vec3 = AT_REST  # initial velocity [m/s]
    flight: float = 0.0  # time until a dropped or thrown brick hits its target [s]
    step: str = ""  # of the build, such as `step 5`, if several steps build its level
    came: Pose | None = None  # start of the path if a hand brings it; the hand releases it at `pose`
    together: bool = False  # whether it is set down at the same time as the brick before it

    @property
    def at_rest(self) -> bool:
        """Return whether the brick enters at rest in its final place."""
        return self.arrival in (Arrival.SET_DOWN, Arrival.SLID_IN)

    @property
    def builds(self) -> bool:
        """Return whether a build step, rather than an impact, brings the brick."""
        return self.arrival in (Arrival.SET_DOWN, Arrival.LET_GO, Arrival.BY_HAND)

    @property
    def hits(self) -> bool:
        """Return whether an impact drops or throws the brick, so that it is not part of the structure."""
        return self.arrival in (Arrival.DROPPED, Arrival.THROWN)


@dataclass(frozen=True, slots=True)
class Removal:
    """Bricks are pulled out at the same time."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


class JointChange(StrEnum):
    """Change of the joints of a structure."""

    JOINED = "joined"
    CUT = "cut"
    SET = "set"  # mortar or glue, some time after placing


@dataclass(frozen=True, slots=True)
class JointsAction:
    """The joints of the structure change."""

    time: float  # [s]
    joints: Joints  # of all bodies, from now on
    bricks: tuple[BodyId, ...]  # that are in place and whose joints change
    change: JointChange

    def on(self, assembly: Assembly) -> Assembly:
        """Return the structure with these joints, judged again."""
        return assembly.with_joints(self.joints)


@dataclass(frozen=True, slots=True)
class LoadsAction:
    """The loads on bricks change."""

    time: float  # [s]
    course: LoadCourse  # of the loads on all bricks, from now on
    bricks: tuple[BodyId, ...]  # that are in place and whose loads begin; none if loads only go on

    def on(self, assembly: Assembly) -> Assembly:
        """Return the structure under these loads, judged again.

        Contacts that bear the loads at both ends of the course also bear those between.
        """
        judged = assembly.with_loads(self.course.first)
        if self.course.last == self.course.first or judged.verdict().stability is not Stability.STABLE:
            return judged
        return judged.with_loads(self.course.last)


@dataclass(frozen=True, slots=True)
class PushAction:
    """An impulse acts on a brick."""

    time: float  # [s]
    brick: BodyId
    impulse_W: Vec3  # [N s]
    offset_W: Vec3 = (0.0, 0.0, 0.0)  # from the centre of the brick to the point of application [m]


@dataclass(frozen=True, slots=True)
class ShakeAction:
    """The ground begins to shake."""

    time: float  # [s]
    motion: GroundMotion


@dataclass(frozen=True, slots=True)
class MoveAction:
    """A hand slides a brick, or carries it and then holds it at rest at the end of its path."""

    time: float  # [s]
    brick: BodyId
    course: HandCourse
    free_W: Vec3 | None = None  # unit vector along which a sliding brick is free, as in its tilt; None if carried
    lowers: bool = False  # whether the hand brings a new brick through free air


@dataclass(frozen=True, slots=True)
class HoldAction:
    """Hands hold bricks at rest from now on, as firmly as the ground. A hand that has a brick already keeps it."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class ReleaseAction:
    """Hands release bricks, all at once, and withdraw."""

    time: float  # [s]
    bricks: tuple[BodyId, ...]


HandAction: TypeAlias = MoveAction | HoldAction | ReleaseAction
Done: TypeAlias = Removal | JointsAction | LoadsAction | PushAction | ShakeAction | HandAction
Action: TypeAlias = Placement | Done
Moment: TypeAlias = tuple[Placement, ...] | Done  # simultaneous actions


def time_of_arrival(action: Action) -> float:
    """Return the time at which an action takes effect: after the flight of a brick, at the end of shaking [s]."""
    if isinstance(action, ShakeAction):
        return action.motion.ends
    return action.time + (action.flight if isinstance(action, Placement) else 0.0)


def leaves_to_engine(action: Action) -> bool:
    """Return whether an action needs an engine: bricks that are dropped, thrown, pushed, shaken or moved by hand."""
    return isinstance(action, PushAction | ShakeAction | HandAction) or (
        isinstance(action, Placement) and not action.at_rest
    )


def _ends_bringing(action: Action, let_go: Mapping[BodyId, float]) -> bool:
    """Return whether an action belongs to bringing bricks by hand, which are released at the times `let_go` [s]."""
    if isinstance(action, MoveAction):
        return action.lowers and action.brick in let_go
    return isinstance(action, ReleaseAction) and all(let_go.get(brick) == action.time for brick in action.bricks)


@dataclass(frozen=True, slots=True)
class AccelerationTest:
    """A horizontal acceleration that the finished structure must bear."""

    bearing: float  # of the pull on the bricks, from +x towards +y [rad]
    acceleration: float  # as a multiple of gravity
    pulse: bool  # whether a pulse of it is simulated if it is not proven to be borne


@dataclass(frozen=True)
class Timeline:
    """All actions of a scenario, in order of time, and the observations that its claims need."""

    world: FixedWorld
    actions: tuple[Action, ...]  # by time, then in the order of the file
    hold: float  # time to watch the structure after the last action and the arrival of the last hit [s]
    # Whether a claim needs motion. If not, a system with proofs does not start an engine.
    watched: bool = True
    margins: tuple[str, ...] = ()  # margins of the proof that claims need, such as `tilt`
    reported_margins: tuple[str, ...] = ()  # margins that are only reported, and only for few bricks
    closely: bool = False  # whether claims need the onset of a fall or the landing, which are recorded densely
    measures: tuple[str, ...] = ()  # measurements that claims need: `sway`, `penetration`
    followed: float = 1.0  # longest time for which a collapse is simulated [s]
    jitter: Mapping[BodyId, Jitter] = field(default_factory=dict)  # placement errors by brick
    tests: tuple[AccelerationTest, ...] = ()  # of the finished structure
    aftermath: bool = True  # whether the run goes on after a collapse; otherwise it ends at once

    @property
    def placements(self) -> tuple[Placement, ...]:
        """Return the actions that bring a brick."""
        return tuple(action for action in self.actions if isinstance(action, Placement))

    @property
    def final_world(self) -> FixedWorld:
        """Return the fixed world with the joints and loads after all actions."""
        world = self.world
        for action in self.actions:
            if isinstance(action, JointsAction):
                world = replace(world, joints=action.joints)
            elif isinstance(action, LoadsAction):
                world = replace(world, loads=action.course.last)
        return world

    @property
    def has_loads(self) -> bool:
        """Return whether loads act on bricks, at any time."""
        return any(isinstance(action, LoadsAction) for action in self.actions)

    @property
    def pulled_out(self) -> tuple[BodyId, ...]:
        """Return the bricks that are pulled out, in order of time."""
        return tuple(brick for action in self.actions if isinstance(action, Removal) for brick in action.bricks)

    def moments(self) -> Iterator[Moment]:
        """Yield simultaneous actions: all placements of one time together, every other action alone."""
        for (_, placing), group in groupby(self.actions, key=lambda action: (action.time, type(action) is Placement)):
            if placing:
                yield tuple(action for action in group if isinstance(action, Placement))
            else:
                yield from (action for action in group if not isinstance(action, Placement))

    def as_set_down(self) -> "Timeline":
        """Return the timeline for statics: bricks brought by hand are set down at the time of their release.

        Bricks that a hand holds longer keep their actions.
        """
        held = {brick for action in self.actions if isinstance(action, HoldAction) for brick in action.bricks}
        brought = {placed.brick.id for placed in self.placements if placed.arrival is Arrival.BY_HAND} - held
        let_go = {
            brick: action.time
            for action in reversed(self.actions)
            if isinstance(action, ReleaseAction)
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
        """Return the time at which the last brick of the structure is placed [s]."""
        return max(placement.time for placement in self.placements if not placement.hits)

    @cached_property  # every look of a run asks for it
    def end(self) -> float:
        """Time until which the structure is watched [s]."""
        return max(time_of_arrival(action) for action in self.actions) + self.hold

    @property
    def levels(self) -> int:
        """Return the number of the highest level."""
        return max(placement.level for placement in self.placements)
