"""What stability needs from a physics engine, and nothing more. SI units, world frame W, z up."""

from collections.abc import Collection, Mapping, Sequence, Set
from typing import Protocol, TypeVar, runtime_checkable

from stability.engines.prescribed import PrescribedMotion
from stability.engines.settings import EngineSettings
from stability.friction_law import GivenFriction
from stability.mechanics.rubbing import Pressed
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3

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

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
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

    def join(self, bricks: Collection[BodyId]) -> None:
        """Let these bricks move from now on as one, with the momentum and angular momentum that they have."""

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Let all that a brick is joined to move one by one, each with the motion that it has; these are they."""


class Pressing(Protocol):
    """Bricks on which something presses that the engine does not step."""

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        """Let these forces, and their friction, act on a brick that moves by itself, until it is said anew.

        Each keeps its direction, and where it acts on the brick; what is frozen, joined or removed is pressed no more.
        """


class World(Engine, Joining, Pressing, Protocol):
    """An engine's world of one's own: bricks and planes come in, and time goes on."""

    prescribed: PrescribedMotion  # what moves as somebody outside says; read before each step

    @property
    def settings(self) -> EngineSettings:
        """How the world is stepped."""

    def step(self) -> None:
        """Let one time step of the settings pass."""

    def limit_travel(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s], so that none passes through another."""

    def ease_in(self) -> None:
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
