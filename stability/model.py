"""The facts that every part of the extension shares: bodies, poses, motions, contacts. SI units, frame W, z up."""

from dataclasses import dataclass
from typing import TypeAlias

Vec3: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]  # x, y, z, w; unit length
BodyId: TypeAlias = str  # a brick or a fixed body; compared and sorted as text, so names decide every order

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
AT_REST: Vec3 = (0.0, 0.0, 0.0)  # a velocity
EARTH = 9.81  # [m/s2]
GROUND: BodyId = "ground"


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a body is: its centre of mass in W [m] and its turn from body axes to W."""

    position_W: Vec3
    orientation: Quaternion = IDENTITY


@dataclass(frozen=True, slots=True)
class Brick:
    """A homogeneous box."""

    id: BodyId
    size: Vec3  # full lengths along the body axes [m]
    mass: float  # [kg]


@dataclass(frozen=True, slots=True)
class Box:
    """The shape of a brick, and of many a table."""

    size: Vec3  # full lengths along the body axes [m]


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """The shape of ground without end: all that lies behind a plane through the body's position."""

    normal: Vec3  # unit, out of the solid, in body axes


Shape: TypeAlias = Box | HalfSpace | None  # None for any other


@dataclass(frozen=True, slots=True)
class Plane:
    """A fixed half-space that bricks rest on or lean against: the ground, or a wall."""

    id: BodyId
    point_W: Vec3  # any point of the surface [m]
    normal_W: Vec3  # unit, out of the solid
    friction: float  # Coulomb coefficient of a brick on it


@dataclass(frozen=True, slots=True)
class BodyState:
    """Pose and motion of one body, as the engine has it."""

    pose: Pose
    velocity_W: Vec3 = (0.0, 0.0, 0.0)  # of the centre of mass [m/s]
    angular_velocity_W: Vec3 = (0.0, 0.0, 0.0)  # [rad/s]


@dataclass(frozen=True, slots=True)
class ContactPoint:
    """One point at which the engine says that body `a` touches body `b`."""

    a: BodyId
    b: BodyId
    position_W: Vec3  # [m]
    normal_BA_W: Vec3  # unit normal from b towards a
    gap: float  # distance between the surfaces [m], negative where they overlap
    normal_force: float = 0.0  # what the engine's last step pressed with [N]
    friction_W: Vec3 = (0.0, 0.0, 0.0)  # force of b on a along the surfaces in that step [N]
