"""Convex solids with flat faces."""

from dataclasses import dataclass, field
from typing import final

from stability.geometry.vectors import dot, scale
from stability.model import ConvexShape, Face, Quaternion, Vec3


@final
@dataclass(frozen=True, slots=True)
class ConvexSolid:
    """Convex solid with flat faces, relative to its centre of mass; `stability.geometry.solid_making` creates it.

    The centre of mass need not be that of uniform density. Two solids are equal if their corners, faces and moments
    are.
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
        """Return the moments of inertia about the principal axes at a mass [kg m2].

        They are those of uniform density about its centroid, even if the centre of mass differs: the distribution of
        the mass is then unknown.
        """
        return scale(mass, self.unit_moments)

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre of mass along a direction, times the length of the direction [m]."""
        return max([dot(corner, direction) for corner in self.corners])

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest corner along a direction [m]; the first of several."""
        return max(self.corners, key=lambda corner: dot(corner, direction))


class NotASolidError(ValueError):
    """Points, an outline or a mesh do not define a convex solid."""

    def __init__(self, message: str, hint: str, number: int | None = None) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint
        self.number = number  # of the wrong corner or face, from 0; None if the whole is wrong


AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def half_lengths(shape: ConvexShape) -> Vec3:
    """Return the half sizes of the smallest box about the centre of mass, along the body axes, around a shape [m]."""
    a, b, c = (max(shape.reach(axis), shape.reach(scale(-1.0, axis))) for axis in AXES)
    return (a, b, c)
