"""The same shape so many times as large, and how far a shape reaches along its axes."""

from stability.geometry.vectors import scale
from stability.model import ConvexShape, Vec3
from stability.shapes.box import Box, UnknownShapeError
from stability.shapes.convex_solid import ConvexSolid
from stability.shapes.off_centre_box import OffCentreBox

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
