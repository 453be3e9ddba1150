"""Data types shared by the whole package: bodies, poses, motions, contacts. SI units, frame W, z up."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias, final

Vec3: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]  # x, y, z, w; unit length
BodyId: TypeAlias = str  # name of a brick or a fixed body; sorted as text

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
AT_REST: Vec3 = (0.0, 0.0, 0.0)  # zero velocity
EARTH = 9.81  # [m/s2]
GROUND: BodyId = "ground"


@dataclass(frozen=True, slots=True)
class Pose:
    """Position of a body's centre of mass in W [m], and rotation from body axes to W."""

    position_W: Vec3
    orientation: Quaternion = IDENTITY


@dataclass(frozen=True, slots=True)
class Face:
    """Flat face of a convex shape."""

    normal: Vec3  # unit, outward, in body axes
    corners: tuple[int, ...]  # indices of corners of the shape, counter-clockwise seen from outside


class ConvexShape(Protocol):
    """Protocol of convex solids.

    All values are in body axes with the origin at the centre of mass, which need not be the centre of the shape's
    bounding box; the axes need not be principal axes of inertia. `stability.geometry.placed_shape` converts them to W.
    A shape is a value: frozen, comparable, hashable.
    """

    @property
    def corners(self) -> Sequence[Vec3]:
        """The corners [m], in a fixed order."""

    @property
    def edges(self) -> Sequence[tuple[int, int]]:
        """The two ends of each edge, as indices of corners."""

    @property
    def faces(self) -> Sequence[Face]:
        """The faces, in different planes."""

    @property
    def least_thickness(self) -> float:
        """The least distance of two parallel planes that enclose the shape [m]; the smallest side of a box."""

    @property
    def length(self) -> float:
        """The longest side of the box around the shape along its body axes [m]."""

    @property
    def bounding_radius(self) -> float:
        """The distance of the farthest corner from the centre of mass [m]; half the diagonal of a box."""

    @property
    def volume(self) -> float:
        """The volume [m3]."""

    @property
    def principal_axes(self) -> Quaternion:
        """The rotation from the principal axes of inertia to the body axes."""

    def moments(self, mass: float) -> Vec3:
        """Return the moments of inertia about the principal axes through the centre of mass, at a mass [kg m2]."""

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre of mass along a direction, times the length of the direction [m]."""

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest corner along a direction [m]; of several always the same."""


@dataclass(frozen=True, slots=True)
class Brick:
    """Brick: a convex solid with a name and a mass."""

    id: BodyId
    shape: ConvexShape
    mass: float  # [kg]


@final
@dataclass(frozen=True, slots=True)
class HalfSpace:
    """Shape of unbounded ground: the half-space behind a plane through the body's position."""

    normal: Vec3  # unit, outward, in body axes


Shape: TypeAlias = ConvexShape | HalfSpace | None  # None for any other


def convex(shape: Shape) -> ConvexShape | None:
    """Return the shape of a body if it is a convex solid, else None."""
    return None if isinstance(shape, HalfSpace) else shape


@dataclass(frozen=True, slots=True)
class Plane:
    """Fixed half-space: the ground, or a wall."""

    id: BodyId
    point_W: Vec3  # any point of the surface [m]
    normal_W: Vec3  # unit, outward
    friction: float  # Coulomb coefficient of a brick on it


@dataclass(frozen=True, slots=True)
class BodyState:
    """Pose and motion of a body."""

    pose: Pose
    velocity_W: Vec3 = (0.0, 0.0, 0.0)  # of the centre of mass [m/s]
    angular_velocity_W: Vec3 = (0.0, 0.0, 0.0)  # [rad/s]


@dataclass(frozen=True, slots=True)
class ContactPoint:
    """Contact point between body `a` and body `b` in an engine."""

    a: BodyId
    b: BodyId
    position_W: Vec3  # [m]
    normal_BA_W: Vec3  # unit normal from b towards a
    gap: float  # distance between the surfaces [m], negative where they overlap
    normal_force: float = 0.0  # in the last step [N]
    friction_W: Vec3 = (0.0, 0.0, 0.0)  # tangential force of b on a in the last step [N]
    rounded: tuple[float, float] = (0.0, 0.0)  # edge radii of a and b in the engine [m]; 0 if sharp
    slid: float = 0.0  # slip of a over b since the engine detected the point [m]
