"""Protocols and settings of the physics engines. SI units, world frame W, z up."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from math import ceil
from typing import ClassVar, Final, Protocol, Self, TypeAlias, TypeVar

from stability.contact_law import GivenFriction, MohrCoulomb
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.scene_scale import SceneScale, power_of_two
from stability.geometry.vectors import add_scaled, dot
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3

# Settings common to all engines. Each engine adds its own and leaves nothing to the engine's defaults.


@dataclass(frozen=True, slots=True)
class Package:
    """Optional Python package."""

    name: str  # import name
    remedy: str  # command that installs it

    @property
    def installed(self) -> bool:
        """Whether the package is installed; this does not import it."""
        return find_spec(self.name) is not None


@dataclass(frozen=True, kw_only=True)
class EngineSettings(ABC):
    """Numerical settings of an engine, which also name the engine. Times and lengths are in SI.

    Settings work without the engine installed: it is imported when a world opens.
    """

    package: ClassVar[Package]  # of the engine
    name: ClassVar[str] = ""  # of the engine in results; empty: that of the package
    world: ClassVar[str]  # `module:class` of its worlds; the class is an `OpensWorlds`
    # Share of the energy of the moving bricks. A scene adds no energy, so a larger rise is an error of the engine.
    most_gain: ClassVar[float] = 0.01
    records_steps: ClassVar[bool] = False  # whether the worlds are `RecordsSteps`, which joined bricks need

    time_step: float  # [s]
    # [m] Largest travel of a body in one step, so that it cannot pass through a plank; faster bodies split the steps.
    most_travel: float | None = None

    @abstractmethod
    def numerics(self) -> Iterator[str]:
        """Yield the settings other than the time step, each as a short phrase."""

    def summary(self) -> str:
        """Return the settings as one line of text."""
        return ", ".join((f"step 1/{1.0 / self.time_step:g} s", *self.numerics()))

    def at_step(self, factor: float) -> Self:
        """Return these settings with the time step multiplied by a factor."""
        return replace(self, time_step=factor * self.time_step)

    def refined(self) -> Self:
        """Return more accurate settings: half the time step, and twice the iterations of an iterative solver."""
        return self.at_step(0.5)

    def scaled(self, scene: SceneScale) -> Self:
        """Adapt settings chosen for the reference scene to a scene of another size or gravity (Froude).

        The time step follows the toppling time of the longest brick, the travel the smallest side of a brick. Both
        change by powers of two, so that similar scenes use the same settings.
        """
        travel = self.most_travel
        return replace(
            self,
            time_step=self.time_step * power_of_two(scene.slower),
            most_travel=None if travel is None else travel * power_of_two(scene.smallest_side),
        )

    def suffice_for(self, required: Self) -> bool:
        """Check that a world with these settings is accurate enough where `wanted` would be chosen."""
        finer = self.time_step <= required.time_step
        return finer and (self.most_travel or 0.0) <= (required.most_travel or 0.0)

    def parts_for_travel(self, fastest: float) -> int:
        """Return the number of sub-steps that keep the travel of the fastest body [m/s] within `most_travel`."""
        if self.most_travel is None:
            return 1
        return max(1, ceil(fastest * self.time_step / self.most_travel))


# Prescribed motion: of the ground with all fixed bodies, and of single bricks.


# Mass factor of a carried brick in engines without kinematic bodies: a collision changes its speed by a millionth of
# the usual change, and only until the next step.
FIRM: Final = 1e6


@dataclass(frozen=True, slots=True)
class Guided:
    """Prescribed motion of a brick in the next step, independent of its contacts: carried or slid.

    A carried brick has no weight and does not turn. A slid brick keeps its weight and loads; along `free_W` it moves
    freely, and it may tilt. Each engine step resets its velocity, so it lags by the loss to friction in one step.
    """

    velocity_W: Vec3  # of its centre [m/s]; of a slid brick the part across `free_W` counts
    free_W: Vec3 | None = None  # unit vector; None for a carried brick

    @property
    def carried(self) -> bool:
        """Whether the brick has no free motion."""
        return self.free_W is None

    def motion(self, own: BodyState) -> tuple[Vec3, Vec3]:
        """Return the prescribed velocity [m/s] and angular velocity [rad/s], from the current state."""
        if self.free_W is None:
            return self.velocity_W, AT_REST
        along, about = dot(self.free_W, own.velocity_W), dot(self.free_W, own.angular_velocity_W)
        across_W = add_scaled(self.velocity_W, -dot(self.free_W, self.velocity_W), self.free_W)
        return add_scaled(across_W, along, self.free_W), add_scaled(own.angular_velocity_W, -about, self.free_W)


@dataclass(frozen=True, slots=True)
class PrescribedMotion:
    """Motion of the ground and of guided bricks that the caller prescribes for one step."""

    # [m/s2] of all fixed bodies. States are relative to them, so each body feels its mass times the opposite.
    acceleration_W: Vec3 = AT_REST
    # None of these bricks is frozen or welded. A brick that leaves this mapping keeps its velocity and moves freely.
    guided: Mapping[BodyId, Guided] = field(default_factory=dict)


NOTHING_PRESCRIBED: Final = PrescribedMotion()


# Friction errors of an engine.


@dataclass(frozen=True, slots=True)
class WrongFriction:
    """Largest friction error of an engine between two bodies that press on each other."""

    first: BodyId
    second: BodyId
    requested: float  # requested coefficient
    actual: float  # coefficient in the engine
    time: float  # on the engine's clock [s]

    @property
    def error(self) -> float:
        """Absolute error of the coefficient."""
        return abs(self.actual - self.requested)


@dataclass
class FrictionRecord:
    """Largest friction error of a world so far."""

    worst: WrongFriction | None = None

    def note(self, wrong: WrongFriction | None) -> None:
        """Record an error if it is the largest."""
        if wrong is not None and (self.worst is None or wrong.error > self.worst.error):
            self.worst = wrong


# The protocols of worlds. SI units, world frame W, z up.


Settings_contra = TypeVar("Settings_contra", bound=EngineSettings, contravariant=True)


class Engine(Protocol):
    """Running engine.

    Contacts may also name bodies that are neither bricks nor fixed, such as robots; these do not count as supports.
    """

    def time(self) -> float:
        """Return the engine's clock [s]."""

    def masses(self) -> Mapping[BodyId, float]:
        """Return the mass of every brick, frozen or not [kg]; the same object until a body is added or removed."""

    def fixed(self) -> Set[BodyId]:
        """Return the fixed bodies, such as ground and walls; the same object until a body is added or removed."""

    def shape(self, body: BodyId) -> Shape:
        """Return the shape of a brick or fixed body, centred on its position and along its axes."""

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """Return the bodies that may be within a distance [m] of a brick: by bounding boxes, in a fixed order."""

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Return pose and motion of bricks and fixed bodies."""

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        """Return the contact points of a brick as of the last step."""

    def freeze(self, brick: BodyId) -> None:
        """Freeze a brick in its pose, at rest; it still collides."""

    def holds(self, brick: BodyId) -> bool:
        """Check that a brick is still frozen: the same body, unchanged since `freeze`."""

    def wake(self, brick: BodyId) -> None:
        """Wake a frozen brick, at rest, with its former mass."""

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Move a frozen brick to another pose."""

    def gravity_W(self) -> Vec3 | None:
        """Return the acceleration of free fall [m/s2]; None if the engine does not report it."""
        return None


class WeldingEngine(Protocol):
    """Engine that can weld bricks into one rigid body, with their true mass, centre and inertia.

    Queries about a welded brick return its own pose, motion, contacts and neighbours; bricks of one group are no
    neighbours of each other. A welded brick cannot be frozen or moved until it is unwelded.
    """

    def weld(self, bricks: Collection[BodyId]) -> None:
        """Weld bricks into one rigid body that keeps their momentum and angular momentum."""

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Split the group of a brick into single bricks that keep their motions; return their names."""


# Mean force [N] and torque about its centre [N m] on each brick that has any, in W, as six numbers.
MeanLoads: TypeAlias = Mapping[BodyId, tuple[float, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """Point at which a joint that yields holds two bodies together, by forces within its law."""

    lower: BodyId  # a brick or a plane
    upper: BodyId  # a brick, on the side that the normal points to
    at_lower: Vec3  # in axes of the body [m]
    at_upper: Vec3
    normal: Vec3  # in axes of the lower body
    law: MohrCoulomb


class RecordsSteps(Protocol):
    """Engine that can take back a step, to repeat it after joints have yielded that do not bear its loads."""

    def record_steps(self) -> None:
        """Record each step from now on."""

    def hit_duration(self) -> float:
        """Return the duration of a step [s], over which the loads are means."""

    def mean_loads(self) -> MeanLoads:
        """Return the mean contact loads on the bricks during the last step, frozen and welded ones included."""

    def undo_step(self) -> None:
        """Return to the state before the last step; nothing may have changed since."""

    def link(self, links: Sequence[Link]) -> None:
        """Hold bodies together at these points from the next step on, and at no others.

        Each mean force in a step is within the law of its link. It pulls, but pushes only by friction.
        """


class AcceptsForces(Protocol):
    """Engine that accepts loads from bodies outside it."""

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        """Apply forces, with their friction, to a freely moving brick, until the next call for it.

        Each keeps its direction and its point of the brick. Freezing, welding or removing the brick ends them.
        """


class World(Engine, WeldingEngine, AcceptsForces, Protocol):
    """World of bricks and planes that an engine steps."""

    @property
    def settings(self) -> EngineSettings:
        """Numerical settings of the world."""

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        """Advance by one time step of the settings, with prescribed motions of the ground and of bricks."""

    def set_max_speed(self, fastest: float) -> None:
        """Set the maximum speed of the bodies in the next steps [m/s], so that none passes through another."""

    def substep_next_contact(self) -> None:
        """Announce new contacts in the next step, which an engine may need to sub-step."""

    def skip(self, duration: float) -> None:
        """Advance the clock [s] without motion."""

    def add_plane(self, plane: Plane) -> None:
        """Add the ground or a wall."""

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Add a brick, at rest or with a velocity of its centre [m/s]."""

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Set the pose and the velocities of a brick that is not frozen."""

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        """Apply an impulse [N s] at a point [m] to a brick that is not frozen, or to its whole welded group."""

    def remove_brick(self, brick: BodyId) -> None:
        """Remove a brick and free its name; the rest of its welded group is unwelded."""

    def wrong_friction(self) -> WrongFriction | None:
        """Return the largest friction error so far; None if the engine is exact or does not report errors."""
        return None

    def close(self) -> None:
        """Close the world and release its resources."""


class OpensWorlds(Protocol[Settings_contra]):
    """Class of an engine's worlds, which the settings name."""

    def opened(
        self, settings: Settings_contra, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> World:
        """Open an empty world with settings of the engine's own class; close it after use.

        Gravity [m/s2] acts along -z. `friction` is that of brick on brick: a number, or a law if the scene has several
        coefficients. `heaviest` is the largest mass of a brick [kg], if known.
        """


class Clock(Protocol):
    """Clock of a world, which also selects the sub-steps."""

    time: float  # [s]

    def set_max_speed(self, fastest: float) -> None:
        """Set the maximum speed of the bodies in the next steps [m/s], so that none passes through another."""

    def pass_step(self) -> int:
        """Advance the clock by a step; return its number of sub-steps."""


@dataclass
class StepClock:
    """Clock of a world, and the number of sub-steps of its next step."""

    settings: EngineSettings
    time: float = 0.0  # [s]
    parts: int = 1
    fastest: float = 0.0  # maximum speed of the bodies [m/s]

    def set_max_speed(self, fastest: float) -> None:
        """Set the maximum speed of the bodies in the next steps [m/s], so that none passes through another."""
        self.fastest = fastest
        self.parts = self.settings.parts_for_travel(fastest)

    def pass_step(self) -> int:
        """Advance the clock by a step; return its number of sub-steps."""
        self.time += self.settings.time_step
        return self.parts
