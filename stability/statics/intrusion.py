"""Refuses bricks that are put inside of others, or of what is fixed: statics would take them as apart."""

from collections.abc import Sequence

from stability.geometry.neighbours import Neighbours
from stability.geometry.touching import LIMIT_ITSELF, reach_between
from stability.geometry.vectors import add, subtract
from stability.model import BodyId, Vec3
from stability.shapes.apart import apart, apart_from_plane
from stability.shapes.in_pose import bounds_W
from stability.statics.facts import Placed
from stability.statics.structure import Structure

# [m] What is forgiven: rounding in files, far below what bricks are made to. Less is of bodies so thin that they would
# no longer touch.
OVERLAP = 1e-4
MILLIMETRES = 1000.0


def refuse_overlaps(structure: Structure, coming: Sequence[Placed], overlap: float, leaving: BodyId = "") -> None:
    """Raise ValueError for the first brick that is deeper than this [m] in another body, be it there or coming too.

    `leaving` is a brick that is there now, and will not be.
    """
    among: Neighbours[BodyId] = Neighbours()
    new: dict[BodyId, Placed] = {}
    for placed in coming:
        low_W, high_W = bounds_W(placed.brick.shape, placed.pose)
        for plane in structure.planes:
            gap = apart_from_plane(placed.brick.shape, placed.pose, plane).gap
            _refuse(placed, plane.id, gap, min(overlap, reach_between(placed.brick.shape.least_thickness)))
        inside = _shrunk(low_W, high_W, min(overlap, reach_between(placed.brick.shape.least_thickness)))
        others = structure.within(*inside)
        for other in (*others, *(new[name] for name in among.around(*inside, 0.0))):
            if other.brick.id != leaving:
                forgiven = reach_between(placed.brick.shape.least_thickness, other.brick.shape.least_thickness)
                gap = apart(placed.brick.shape, placed.pose, other.brick.shape, other.pose).gap
                _refuse(placed, other.brick.id, gap, min(overlap, forgiven))
        among.add(placed.brick.id, low_W, high_W)
        new[placed.brick.id] = placed


def _shrunk(low_W: Vec3, high_W: Vec3, by: float) -> tuple[Vec3, Vec3]:
    """A box within another: what does not meet it is not deeper than this in the other, along some axis."""
    a, b, c = (min(by, 0.25 * side) for side in subtract(high_W, low_W))
    return add(low_W, (a, b, c)), subtract(high_W, (a, b, c))


def _refuse(placed: Placed, other: BodyId, gap: float, forgiven: float) -> None:
    if -gap > LIMIT_ITSELF * forgiven:
        depth = f"{MILLIMETRES * -gap:.3g} mm deep in '{other}'"
        raise ValueError(f"brick '{placed.brick.id}' is {depth}; move it, or give Assembly a larger `overlap`")
