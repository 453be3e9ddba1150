"""Any convex solid with flat faces: a wedge, a voussoir, a stone.

Where its centre of mass is need not be where that of an even filling is; see `moments` on what that means for turning.
"""

from dataclasses import dataclass, field
from typing import final

from stability.geometry.vectors import dot, scale
from stability.model import Face, Quaternion, Vec3


@final
@dataclass(frozen=True, slots=True)
class ConvexSolid:
    """A convex solid about its centre of mass, made by `stability.shapes.solid_making`, which works out its measures.

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
