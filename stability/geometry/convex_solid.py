"""Convex solids with flat faces, and scaled copies of shapes."""

from dataclasses import dataclass, field
from typing import final

from stability.geometry.box import Box, OffCentreBox, UnknownShapeError
from stability.geometry.vectors import dot, scale
from stability.model import ConvexShape, Face, Quaternion, Vec3

# Any convex solid with flat faces: a wedge, a voussoir, a stone.
#
# Where its centre of mass is need not be where that of an even filling is; see `moments` on what that means for
# turning.


@final
@dataclass(frozen=True, slots=True)
class ConvexSolid:
    """A convex solid about its centre of mass, made by `stability.geometry.solid_making`, which works out its measures.

    Two solids with the same corners, faces and moments are one shape.
    """

    corners: tuple[Vec3, ...]  # from the centre of mass, in body axes [m]
    faces: tuple[Face, ...]
    unit_moments: Vec3  # principal moments of inertia at a mass of 1 [m2]
    principal_axes: Quaternion  # from the principal axes to the body axes
    edges: tuple[tuple[int, int], ...] = field(compare=False)
    volume: float = field(compare=False)  # [m3]
    least_thickness: float = field(compare=False)  # [m]
    length: float = field(compare=False)  # [m]
    bounding_radius: float = field(compare=False)  # [m]

    def moments(self, mass: float) -> Vec3:
        """The moments of inertia about its principal axes through the centre of mass [kg m2].

        They are those of the same solid filled evenly, about the middle of that: if its centre of mass is elsewhere,
        how its mass is spread about that is not known.
        """
        return scale(mass, self.unit_moments)

    def reach(self, direction: Vec3) -> float:
        """How far it extends from its centre of mass along a direction of any length, times that length [m]."""
        return max([dot(corner, direction) for corner in self.corners])

    def support(self, direction: Vec3) -> Vec3:
        """A corner that is farthest along a direction [m]; the first of several."""
        return max(self.corners, key=lambda corner: dot(corner, direction))


# The error for input that is no convex solid.


class NotASolidError(ValueError):
    """Points, an outline or a mesh that make no convex solid."""

    def __init__(self, message: str, hint: str, number: int | None = None) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint
        self.number = number  # of the corner or the face that is wrong, from 0; None if it is the whole


# The same shape so many times as large, and how far a shape reaches along its axes.


AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def scaled(shape: ConvexShape, factor: float) -> ConvexShape:
    """A shape with all its lengths so many times as long. Raises UnknownShapeError for one of somebody else's."""
    match shape:
        case Box(size):
            return Box(scale(factor, size))
        case OffCentreBox(size, centre):
            return OffCentreBox(scale(factor, size), scale(factor, centre))
        case ConvexSolid():
            return ConvexSolid(
                tuple(scale(factor, corner) for corner in shape.corners),
                shape.faces,
                scale(factor * factor, shape.unit_moments),
                shape.principal_axes,
                shape.edges,
                factor**3 * shape.volume,
                factor * shape.least_thickness,
                factor * shape.length,
                factor * shape.bounding_radius,
            )
        case _:
            raise UnknownShapeError("a world of another size", shape)


def half_lengths(shape: ConvexShape) -> Vec3:
    """Half the sides of the least box along the body axes, about the centre of mass, that holds a shape [m]."""
    a, b, c = (max(shape.reach(axis), shape.reach(scale(-1.0, axis))) for axis in AXES)
    return (a, b, c)
