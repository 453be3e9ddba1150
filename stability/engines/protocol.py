"""What stability needs from a physics engine. SI units, world frame W, z up."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from math import ceil
from typing import ClassVar, Final, Protocol, Self, TypeVar, runtime_checkable

from stability.contact_law import GivenFriction
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.scene_scale import SceneScale, power_of_two
from stability.geometry.vectors import add_scaled, dot
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3

# Settings common to all engines. Each engine adds its own; nothing is left to defaults.


@dataclass(frozen=True, slots=True)
class Package:
    """A Python package that not everybody has."""

    name: str  # as it is imported
    remedy: str  # what brings it, as one types it

    @property
    def installed(self) -> bool:
        """Whether the package is there; it is not imported."""
        return find_spec(self.name) is not None


@dataclass(frozen=True, kw_only=True)
class EngineSettings(ABC):
    """How an engine steps, which engine it is, and how its settings follow the scene. Times and lengths are in SI.

    Settings can be made, scaled and told where the engine is not installed: a world is imported when it is opened.
    """

    package: ClassVar[Package]  # what the engine comes with
    world: ClassVar[str]  # `module:class` of its worlds, which is an `OpensWorlds` of `stability.engines.protocol`

    time_step: float  # [s]
    # [m] A body must not get further in one step, or it passes through a plank; steps are split while one is that fast.
    most_travel: float | None = None

    @abstractmethod
    def numerics(self) -> Iterator[str]:
        """What matters of the settings beside the time step, each in a few words."""

    def summary(self) -> str:
        """The settings in words."""
        return ", ".join((f"step 1/{1.0 / self.time_step:g} s", *self.numerics()))

    def at_step(self, factor: float) -> Self:
        """So many times the time step; all else as it was."""
        return replace(self, time_step=factor * self.time_step)

    def refined(self) -> Self:
        """Settings that err less: half the time step, and twice the iterations where an engine iterates."""
        return self.at_step(0.5)

    def scaled(self, scene: SceneScale) -> Self:
        """Settings that were chosen for the usual scene, for one of another size or gravity (Froude).

        The time that a brick takes to topple goes with its diagonal, and how deep it may be struck with its smallest
        side. All go by powers of two, so that scenes which hardly differ are stepped alike.
        """
        travel = self.most_travel
        return replace(
            self,
            time_step=self.time_step * power_of_two(scene.slower),
            most_travel=None if travel is None else travel * power_of_two(scene.smallest_side),
        )

    def suffice_for(self, wanted: Self) -> bool:
        """Whether a world with these settings may go on where these others would be chosen."""
        finer = self.time_step <= wanted.time_step
        return finer and (self.most_travel or 0.0) <= (wanted.most_travel or 0.0)

    def parts_for_travel(self, fastest: float) -> int:
        """Into how many parts a step is split while a body is so fast [m/s], so that none passes through another."""
        if self.most_travel is None:
            return 1
        return max(1, ceil(fastest * self.time_step / self.most_travel))


# Prescribed motion: of the ground with everything fixed to it, and of single bricks.


# Times its own mass that a carried brick has in engines which know no bodies that move by themselves alone: all that it
# meets changes its speed by a millionth of what it would otherwise, and that only until the next step.
FIRM: Final = 1e6


@dataclass(frozen=True, slots=True)
class Guided:
    """How a brick moves in the coming step, whatever it meets: carried, without weight and without turning, or slid.

    What is slid keeps its weight, and all that presses on it: along `free_W` it moves by itself, and may tilt. Its own
    velocity is given to it anew in each engine step, so that it falls behind by what friction takes of that in one.
    """

    velocity_W: Vec3  # of its centre [m/s]; of what is slid, across `free_W`
    free_W: Vec3 | None = None  # unit; None if it is carried

    @property
    def carried(self) -> bool:
        """Whether it has no motion of its own."""
        return self.free_W is None

    def motion(self, own: BodyState) -> tuple[Vec3, Vec3]:
        """Velocity [m/s] and angular velocity [rad/s] that it is to have, from those that it has."""
        if self.free_W is None:
            return self.velocity_W, AT_REST
        along, about = dot(self.free_W, own.velocity_W), dot(self.free_W, own.angular_velocity_W)
        across_W = add_scaled(self.velocity_W, -dot(self.free_W, self.velocity_W), self.free_W)
        return add_scaled(across_W, along, self.free_W), add_scaled(own.angular_velocity_W, -about, self.free_W)


@dataclass
class PrescribedMotion:
    """What a world reads before each step; whoever steps it writes it."""

    # Of all that is fixed [m/s2]. All is told as seen from there: bodies feel their mass times that, the other way.
    acceleration_W: Vec3 = AT_REST
    # None of these bricks is frozen or joined. What is no longer here moves by itself, as fast as it was.
    guided: dict[BodyId, Guided] = field(default_factory=dict)


# The protocols of worlds. SI units, world frame W, z up.


Settings_contra = TypeVar("Settings_contra", bound=EngineSettings, contravariant=True)


class Engine(Protocol):
    """A running engine, reached only through its public interface.

    Contacts may also name bodies that are neither bricks nor fixed, such as robots; nothing is taken to rest on them.
    """

    def time(self) -> float:
        """The engine's clock [s]."""

    def masses(self) -> Mapping[BodyId, float]:
        """The mass of every brick, frozen or not [kg]; the same object as long as no body comes or goes."""

    def fixed(self) -> Set[BodyId]:
        """The bodies that never move, such as ground and walls; the same object as long as no body comes or goes."""

    def shape(self, body: BodyId) -> Shape:
        """The shape of a body, brick or fixed, centred on its position and along its axes."""

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m]: a superset, by bounding boxes, in a fixed order."""

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Pose and motion of these bodies, bricks or fixed."""

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        """The contact points of a brick as of the last step."""

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is, without velocity; it goes on colliding."""

    def holds(self, brick: BodyId) -> bool:
        """Whether a brick is still as `freeze` left it: the same body, and held."""

    def wake(self, brick: BodyId) -> None:
        """Give a frozen brick back to the engine, at rest, with the mass that it had."""

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Put a frozen brick somewhere else."""


@runtime_checkable
class TellsGravity(Protocol):
    """An engine that knows its gravity; an extension then need not be told, and refuses what it cannot reckon with."""

    def gravity_W(self) -> Vec3:
        """The acceleration of what falls freely [m/s2]."""


class Joining(Protocol):
    """Bricks that move together as one rigid body, with their true mass, centre and inertia.

    Asked about a joined brick, an engine answers with its own pose, motion, contacts and neighbours; bricks that are
    joined to each other are no neighbours. Until it is parted, a joined brick is neither frozen nor moved by itself.
    """

    def weld(self, bricks: Collection[BodyId]) -> None:
        """Let these bricks move from now on as one, with the momentum and angular momentum that they have."""

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Let all that a brick is joined to move one by one, each with the motion that it has; these are they."""


class AcceptsForces(Protocol):
    """Bricks on which something presses that the engine does not step."""

    def apply_forces(self, brick: BodyId, pressed: Sequence[AppliedForce]) -> None:
        """Let these forces, and their friction, act on a brick that moves by itself, until it is said anew.

        Each keeps its direction, and where it acts on the brick; what is frozen, joined or removed is pressed no more.
        """


class World(Engine, Joining, AcceptsForces, Protocol):
    """An engine's world of one's own: bricks and planes come in, and time goes on."""

    prescribed: PrescribedMotion  # what moves as somebody outside says; read before each step

    @property
    def settings(self) -> EngineSettings:
        """How the world is stepped."""

    def step(self) -> None:
        """Let one time step of the settings pass."""

    def set_max_speed(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s], so that none passes through another."""

    def substep_next_contact(self) -> None:
        """Say that bodies which did not press on each other begin to with the coming step."""

    def skip(self, duration: float) -> None:
        """Let time pass in which nothing can move [s]."""

    def add_plane(self, plane: Plane) -> None:
        """Put up the ground or a wall."""

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick that is not frozen somewhere else, in motion."""

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        """Give a brick that is not frozen an impulse [N s] at a point [m]."""

    def remove_brick(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again. What it was joined to is parted."""

    def close(self) -> None:
        """End the world; nothing of it is left."""


class OpensWorlds(Protocol[Settings_contra]):
    """The class of an engine's worlds, as settings name it."""

    def opened(
        self, settings: Settings_contra, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> World:
        """A new, empty world, with settings of the engine's own class; close it after use.

        Gravity [m/s2] is along -z, friction that of brick on brick, one number unless the scene has several, `heaviest`
        the mass of the heaviest brick that is to come [kg], if that is known.
        """


# The clock of a world that takes its steps in parts, while something is fast.


@dataclass
class StepClock:
    """What time it is, and in how many parts the next step is taken."""

    settings: EngineSettings
    time: float = 0.0  # [s]
    parts: int = 1

    def set_max_speed(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s], so that none passes through another."""
        self.parts = self.settings.parts_for_travel(fastest)

    def pass_step(self) -> int:
        """Go on by a step; returns in how many parts the engine has to take it."""
        self.time += self.settings.time_step
        return self.parts


# The friction error of an engine: the two bodies, and the difference from the coefficient asked for.


@dataclass(frozen=True, slots=True)
class WrongFriction:
    """The worst coefficient that an engine has had for two bodies which press on each other."""

    one: BodyId
    other: BodyId
    asked: float
    had: float
    time: float  # on the engine's clock [s]

    @property
    def error(self) -> float:
        """How far off it was."""
        return abs(self.had - self.asked)


@dataclass
class FrictionRecord:
    """What is kept of it while a world is stepped."""

    worst: WrongFriction | None = None

    def note(self, wrong: WrongFriction) -> None:
        """Keep the worst."""
        if self.worst is None or wrong.error > self.worst.error:
            self.worst = wrong


@runtime_checkable
class TellsFriction(Protocol):
    """A world whose engine may not have the friction that is asked of every pair, and which notes what it had."""

    frictions: FrictionRecord


def wrong_friction_of(world: object) -> WrongFriction | None:
    """The worst friction that a world has had, if it says so; None where all had what was asked."""
    return world.frictions.worst if isinstance(world, TellsFriction) else None
