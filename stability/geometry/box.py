"""Boxes: of uniform density, or with a centre of mass off their middle."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from math import hypot
from typing import Final, final

from stability.geometry.vectors import norm, subtract
from stability.model import IDENTITY, ConvexShape, Face, Quaternion, Vec3

# The box: the shape of a plank, and of many a table.


# The corners run through -x to x, in each through -y to y, in each of those through -z to z.
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
SIZES = 256  # whose corners are kept; few scenes know more


class UnknownShapeError(TypeError):
    """A shape came to where it is not known."""

    def __init__(self, where: str, shape: object) -> None:
        super().__init__(f"{where} does not know the shape {type(shape).__name__}")


@final
@dataclass(frozen=True, slots=True)
class Box:
    """A box about its centre of mass, its sides along the body axes."""

    size: Vec3  # full lengths along the body axes [m]

    @property
    def corners(self) -> tuple[Vec3, ...]:
        """Its eight corners [m]."""
        return _corners(self.size)

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Its twelve edges: four along each axis."""
        return EDGES

    @property
    def faces(self) -> tuple[Face, ...]:
        """Its six faces."""
        return FACES

    @property
    def least_thickness(self) -> float:
        """Its smallest side [m]."""
        return min(self.size)

    @property
    def length(self) -> float:
        """Its longest side [m]."""
        return max(self.size)

    @property
    def bounding_radius(self) -> float:
        """Half its diagonal [m]."""
        return 0.5 * hypot(*self.size)

    @property
    def volume(self) -> float:
        """Length times width times thickness [m3]."""
        return self.size[0] * self.size[1] * self.size[2]

    @property
    def principal_axes(self) -> Quaternion:
        """No turn: its body axes are principal axes."""
        return IDENTITY

    def moments(self, mass: float) -> Vec3:
        """The moments of inertia about its axes, at a mass [kg m2]."""
        a, b, c = (side * side for side in self.size)
        return (mass * (b + c) / 12.0, mass * (a + c) / 12.0, mass * (a + b) / 12.0)

    def reach(self, direction: Vec3) -> float:
        """How far it extends from its centre along a direction of any length, times that length [m]."""
        (a, b, c), (x, y, z) = self.size, direction
        return 0.5 * (a * abs(x) + b * abs(y) + c * abs(z))

    def support(self, direction: Vec3) -> Vec3:
        """The corner that is farthest along a direction [m]; on the side of the positive axes if several are."""
        (a, b, c), (x, y, z) = self.size, direction
        return (-0.5 * a if x < 0.0 else 0.5 * a, -0.5 * b if y < 0.0 else 0.5 * b, -0.5 * c if z < 0.0 else 0.5 * c)


def as_box(shape: ConvexShape, where: str) -> Box:
    """A shape where only boxes are known: the box that it is. Raises UnknownShapeError for any other.

    `where` says what does not know more. Whoever adds a shape finds each such place by this function.
    """
    if isinstance(shape, Box):
        return shape
    raise UnknownShapeError(where, shape)


@lru_cache(maxsize=SIZES)
def _corners(size: Vec3) -> tuple[Vec3, ...]:
    a, b, c = size
    return tuple((x * a, y * b, z * c) for x, y, z in product((-0.5, 0.5), repeat=3))


# A box whose mass is not in its middle: a carton that is packed on one side.


KEPT: Final = 256  # shapes whose corners are kept

MIDDLE: Vec3 = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, slots=True)
class OffCentreBox:
    """A box about its centre of mass, its sides along the body axes.

    Its moments are those of the box filled evenly, about its middle: how the mass is spread is not known.
    """

    size: Vec3  # full lengths along the body axes [m]
    centre_of_mass: Vec3  # from the middle of the box [m]

    @property
    def box(self) -> Box:
        """The same box filled evenly."""
        return Box(self.size)

    @property
    def corners(self) -> tuple[Vec3, ...]:
        """Its eight corners from the centre of mass [m]."""
        return _off_centre_corners(self)

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Its twelve edges: four along each axis."""
        return self.box.edges

    @property
    def faces(self) -> tuple[Face, ...]:
        """Its six faces."""
        return self.box.faces

    @property
    def least_thickness(self) -> float:
        """Its smallest side [m]."""
        return self.box.least_thickness

    @property
    def length(self) -> float:
        """Its longest side [m]."""
        return self.box.length

    @property
    def bounding_radius(self) -> float:
        """How far its farthest corner is from the centre of mass [m]."""
        return max(map(norm, self.corners))

    @property
    def volume(self) -> float:
        """Length times width times thickness [m3]."""
        return self.box.volume

    @property
    def principal_axes(self) -> Quaternion:
        """No turn: its body axes are principal axes."""
        return self.box.principal_axes

    def moments(self, mass: float) -> Vec3:
        """Those of the box filled evenly, at a mass [kg m2]."""
        return self.box.moments(mass)

    def reach(self, direction: Vec3) -> float:
        """How far it extends from its centre of mass along a direction of any length, times that length [m]."""
        (a, b, c), (x, y, z) = self.centre_of_mass, direction
        return self.box.reach(direction) - (a * x + b * y + c * z)

    def support(self, direction: Vec3) -> Vec3:
        """The corner that is farthest along a direction [m]; on the side of the positive axes if several are."""
        return subtract(self.box.support(direction), self.centre_of_mass)


def box_of(shape: ConvexShape) -> tuple[Box, Vec3] | None:
    """The box that a shape is, with the way from its centre of mass to its middle [m]; None of any other shape.

    What knows a shorter way for boxes asks this.
    """
    if isinstance(shape, Box):
        return shape, MIDDLE
    if isinstance(shape, OffCentreBox):
        return shape.box, subtract(MIDDLE, shape.centre_of_mass)
    return None


@lru_cache(maxsize=KEPT)
def _off_centre_corners(shape: OffCentreBox) -> tuple[Vec3, ...]:
    return tuple(subtract(corner, shape.centre_of_mass) for corner in shape.box.corners)
