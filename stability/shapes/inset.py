"""The corners of a shape whose faces have all moved inwards: what an engine rounds outwards again by the same."""

from collections.abc import Sequence

from stability.geometry.vectors import scale
from stability.model import ConvexShape, Vec3
from stability.shapes.box import Box
from stability.shapes.off_centre_box import box_of


def inset_corners(shape: ConvexShape, distance: float) -> Sequence[Vec3]:
    """The corners of the part of a shape that is so deep inside [m], from its centre of mass in body axes.

    `distance` is less than a quarter of the least thickness: so deep at least is the middle of any convex solid.
    """
    boxed = box_of(shape)
    if boxed is not None:
        (a, b, c), (x, y, z) = boxed[0].size, boxed[1]
        inner = Box((a - 2.0 * distance, b - 2.0 * distance, c - 2.0 * distance))
        return inner.corners if boxed[0] is shape else [(x + p, y + q, z + r) for p, q, r in inner.corners]
    import numpy as np  # noqa: PLC0415 -- boxes do without
    from scipy.spatial import ConvexHull, HalfspaceIntersection  # noqa: PLC0415

    from stability.shapes.mesh_integrals import integrals  # noqa: PLC0415

    unit = 1.0 / shape.length  # Qhull's limits are those of numbers near one
    faces = [(*face.normal, unit * (distance - shape.reach(face.normal))) for face in shape.faces]
    middle = integrals(shape.corners, [face.corners for face in shape.faces]).centre
    points = HalfspaceIntersection(np.array(faces), np.array(scale(unit, middle))).intersections
    corners = points[np.sort(ConvexHull(points).vertices)]
    return [(float(x) / unit, float(y) / unit, float(z) / unit) for x, y, z in corners]
