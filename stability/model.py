"""The facts that every part of the extension shares: bodies, poses, motions, contacts. SI units, frame W, z up."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias, final

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
class Face:
    """A flat side of a convex shape."""

    normal: Vec3  # unit, out of the solid, in body axes
    corners: tuple[int, ...]  # places among the corners of the shape, counter-clockwise seen from outside


class ConvexShape(Protocol):
    """What a shape promises: all that statics, engines and compiler ask of a convex solid.

    All of it is in body axes, whose origin is the centre of mass: that need not be the middle of the box around the
    shape, and the axes need not be principal axes of inertia. `stability.geometry` says where a shape is in a pose. A
    shape is a value: frozen, comparable, hashable.
    """

    @property
    def corners(self) -> Sequence[Vec3]:
        """Its corners [m], always in the same order."""

    @property
    def edges(self) -> Sequence[tuple[int, int]]:
        """The two ends of each edge, as places among the corners."""

    @property
    def faces(self) -> Sequence[Face]:
        """Its faces; no two of them lie in one plane."""

    @property
    def least_thickness(self) -> float:
        """The least distance of two parallel planes between which it fits [m]; the smallest side of a box."""

    @property
    def length(self) -> float:
        """The longest side of the box around it along its body axes [m]."""

    @property
    def bounding_radius(self) -> float:
        """How far its farthest corner is from the centre of mass [m]; half the diagonal of a box."""

    @property
    def volume(self) -> float:
        """In [m3]."""

    @property
    def principal_axes(self) -> Quaternion:
        """The turn from its principal axes of inertia to its body axes."""

    def moments(self, mass: float) -> Vec3:
        """The moments of inertia about its principal axes through the centre of mass, at a mass [kg m2]."""

    def reach(self, direction: Vec3) -> float:
        """How far it extends from the centre of mass along a direction of any length, times that length [m]."""

    def support(self, direction: Vec3) -> Vec3:
        """A corner that is farthest along a direction [m]; of several that are, always the same."""


@dataclass(frozen=True, slots=True)
class Brick:
    """A convex solid."""

    id: BodyId
    shape: ConvexShape
    mass: float  # [kg]


@final
@dataclass(frozen=True, slots=True)
class HalfSpace:
    """The shape of ground without end: all that lies behind a plane through the body's position."""

    normal: Vec3  # unit, out of the solid, in body axes


Shape: TypeAlias = ConvexShape | HalfSpace | None  # None for any other


def convex(shape: Shape) -> ConvexShape | None:
    """The shape of a body if it is a convex solid."""
    return None if isinstance(shape, HalfSpace) else shape


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
    rounded: tuple[float, float] = (0.0, 0.0)  # by how much the edges of a and b are in the engine [m]; 0 if sharp
    slid: float = 0.0  # how far a has slid over b since the engine found the point [m]; 0 if it found it in that step
