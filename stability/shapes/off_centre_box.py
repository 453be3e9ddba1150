"""A box whose mass is not in its middle: a carton that is packed on one side."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, final

from stability.geometry.vectors import norm, subtract
from stability.model import ConvexShape, Face, Quaternion, Vec3
from stability.shapes.box import Box

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
        return _corners(self)

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
def _corners(shape: OffCentreBox) -> tuple[Vec3, ...]:
    return tuple(subtract(corner, shape.centre_of_mass) for corner in shape.box.corners)
