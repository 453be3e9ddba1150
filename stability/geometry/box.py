"""Boxes of uniform density, and boxes with an off-centre mass."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from math import hypot
from typing import Final, final

from stability.geometry.vectors import norm, subtract
from stability.model import IDENTITY, ConvexShape, Face, Quaternion, Vec3

# The order of the corners: from -x to x, for each from -y to y, for each of these from -z to z.
FACES: Final = (
    Face((-1.0, 0.0, 0.0), (0, 1, 3, 2)),
    Face((1.0, 0.0, 0.0), (4, 6, 7, 5)),
    Face((0.0, -1.0, 0.0), (0, 4, 5, 1)),
    Face((0.0, 1.0, 0.0), (2, 3, 7, 6)),
    Face((0.0, 0.0, -1.0), (0, 2, 6, 4)),
    Face((0.0, 0.0, 1.0), (1, 5, 7, 3)),
)
EDGES: Final = (
    *((0, 4), (1, 5), (2, 6), (3, 7)),
    *((0, 2), (1, 3), (4, 6), (5, 7)),
    *((0, 1), (2, 3), (4, 5), (6, 7)),
)
SIZES = 256  # cache size; few scenes have more different boxes


class UnknownShapeError(TypeError):
    """A shape is not supported."""

    def __init__(self, where: str, shape: object) -> None:
        super().__init__(f"{where} does not support the shape {type(shape).__name__}")


@final
@dataclass(frozen=True, slots=True)
class Box:
    """Box of uniform density, centred on its centre of mass, with sides along the body axes."""

    size: Vec3  # full lengths along the body axes [m]

    @property
    def corners(self) -> tuple[Vec3, ...]:
        """The eight corners [m]."""
        return _corners(self.size)

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """The twelve edges: four along each axis."""
        return EDGES

    @property
    def faces(self) -> tuple[Face, ...]:
        """The six faces."""
        return FACES

    @property
    def least_thickness(self) -> float:
        """The smallest side [m]."""
        return min(self.size)

    @property
    def length(self) -> float:
        """The longest side [m]."""
        return max(self.size)

    @property
    def bounding_radius(self) -> float:
        """Half its diagonal [m]."""
        return 0.5 * hypot(*self.size)

    @property
    def volume(self) -> float:
        """The volume [m3]."""
        return self.size[0] * self.size[1] * self.size[2]

    @property
    def principal_axes(self) -> Quaternion:
        """The identity: the body axes are principal axes."""
        return IDENTITY

    def moments(self, mass: float) -> Vec3:
        """Return the moments of inertia about the body axes at a mass [kg m2]."""
        a, b, c = (side * side for side in self.size)
        return (mass * (b + c) / 12.0, mass * (a + c) / 12.0, mass * (a + b) / 12.0)

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre along a direction, times the length of the direction [m]."""
        (a, b, c), (x, y, z) = self.size, direction
        return 0.5 * (a * abs(x) + b * abs(y) + c * abs(z))

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest corner along a direction [m]; of several the one on the side of the positive axes."""
        (a, b, c), (x, y, z) = self.size, direction
        return (-0.5 * a if x < 0.0 else 0.5 * a, -0.5 * b if y < 0.0 else 0.5 * b, -0.5 * c if z < 0.0 else 0.5 * c)


def as_box(shape: ConvexShape, where: str) -> Box:
    """Return a shape as a box where only boxes are supported. Raises UnknownShapeError for any other shape.

    `where` names the caller in the error. Calls of this function mark all code that must change for a new shape.
    """
    if isinstance(shape, Box):
        return shape
    raise UnknownShapeError(where, shape)


@lru_cache(maxsize=SIZES)
def _corners(size: Vec3) -> tuple[Vec3, ...]:
    a, b, c = size
    return tuple((x * a, y * b, z * c) for x, y, z in product((-0.5, 0.5), repeat=3))


# Boxes with an off-centre mass, such as a carton that is packed on one side.


KEPT: Final = 256  # cache size

MIDDLE: Vec3 = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, slots=True)
class OffCentreBox:
    """Box with an off-centre mass, relative to its centre of mass, with sides along the body axes.

    Its moments of inertia are those of a box of uniform density about its geometric centre, as the distribution of its
    mass is unknown.
    """

    size: Vec3  # full lengths along the body axes [m]
    centre_of_mass: Vec3  # from the middle of the box [m]

    @property
    def box(self) -> Box:
        """The box with uniform density."""
        return Box(self.size)

    @property
    def corners(self) -> tuple[Vec3, ...]:
        """The eight corners, from the centre of mass [m]."""
        return _off_centre_corners(self)

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """The twelve edges: four along each axis."""
        return self.box.edges

    @property
    def faces(self) -> tuple[Face, ...]:
        """The six faces."""
        return self.box.faces

    @property
    def least_thickness(self) -> float:
        """The smallest side [m]."""
        return self.box.least_thickness

    @property
    def length(self) -> float:
        """The longest side [m]."""
        return self.box.length

    @property
    def bounding_radius(self) -> float:
        """The distance of the farthest corner from the centre of mass [m]."""
        return max(map(norm, self.corners))

    @property
    def volume(self) -> float:
        """The volume [m3]."""
        return self.box.volume

    @property
    def principal_axes(self) -> Quaternion:
        """The identity: the body axes are principal axes."""
        return self.box.principal_axes

    def moments(self, mass: float) -> Vec3:
        """Return the moments of the box with uniform density at a mass [kg m2]."""
        return self.box.moments(mass)

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre of mass along a direction, times the length of the direction [m]."""
        (a, b, c), (x, y, z) = self.centre_of_mass, direction
        return self.box.reach(direction) - (a * x + b * y + c * z)

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest corner along a direction [m]; of several the one on the side of the positive axes."""
        return subtract(self.box.support(direction), self.centre_of_mass)


def box_of(shape: ConvexShape) -> tuple[Box, Vec3] | None:
    """Return the box of a shape and the vector from its centre of mass to its centre [m]; None for other shapes.

    Callers use it for faster code for boxes.
    """
    if isinstance(shape, Box):
        return shape, MIDDLE
    if isinstance(shape, OffCentreBox):
        return shape.box, subtract(MIDDLE, shape.centre_of_mass)
    return None


@lru_cache(maxsize=KEPT)
def _off_centre_corners(shape: OffCentreBox) -> tuple[Vec3, ...]:
    return tuple(subtract(corner, shape.centre_of_mass) for corner in shape.box.corners)
