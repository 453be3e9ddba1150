"""Rigid bodies of several convex parts, such as an L, a U, a hollow block or a table."""

from dataclasses import dataclass, field
from typing import Final, final

from stability.geometry.vectors import dot, scale
from stability.model import ConvexShape, Face, Pose, Quaternion, Vec3

MOST_PARTS: Final = 200  # of one body; contacts compare all parts of two bodies


@dataclass(frozen=True, slots=True)
class Part:
    """Convex part of a compound."""

    shape: ConvexShape
    place: Pose  # of the centre of mass and the axes of the part, in the frame of the compound


@final
@dataclass(frozen=True, slots=True)
class Compound:
    """Rigid body of convex parts, relative to its centre of mass; `stability.geometry.compound_making` creates it.

    `corners`, `edges` and `faces` are those of all parts, so two faces lie on either side of each seam. Extents and
    supporting corners are those of the convex hull.
    """

    parts: tuple[Part, ...]
    unit_moments: Vec3  # principal moments of inertia at a mass of 1 [m2]
    principal_axes: Quaternion  # from the principal axes to the body axes
    corners: tuple[Vec3, ...] = field(compare=False, repr=False)  # [m]
    edges: tuple[tuple[int, int], ...] = field(compare=False, repr=False)
    faces: tuple[Face, ...] = field(compare=False, repr=False)
    volume: float = field(compare=False)  # [m3]
    least_thickness: float = field(compare=False)  # of the thinnest part [m]
    length: float = field(compare=False)  # [m]
    bounding_radius: float = field(compare=False)  # [m]

    def moments(self, mass: float) -> Vec3:
        """Return the moments of inertia about the principal axes at a mass [kg m2]: those of uniform density."""
        return scale(mass, self.unit_moments)

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre of mass along a direction, times the length of the direction [m]."""
        return max([dot(corner, direction) for corner in self.corners])

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest corner along a direction [m]; the first of several."""
        return max(self.corners, key=lambda corner: dot(corner, direction))


def parts_of(shape: ConvexShape) -> tuple[Part, ...]:
    """Return the convex parts of a shape: those of a compound, or the shape itself."""
    return shape.parts if isinstance(shape, Compound) else (Part(shape, Pose((0.0, 0.0, 0.0))),)
