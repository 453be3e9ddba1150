"""Says which bodies are too deep in each other to count as touching, for the reason of a verdict."""

from stability.geometry.touching import reach_between
from stability.model import BodyId
from stability.shapes.apart import apart, apart_from_plane
from stability.statics.structure import Structure

MILLIMETRES = 1000.0


def overlap_in_words(structure: Structure, brick: BodyId) -> str:
    """The body that a brick is deepest in, in words; empty if it is in none by more than still counts as touching."""
    placed = structure.bricks[brick]
    shape, pose, share = placed.brick.shape, placed.pose, structure.tolerances.gap
    thickness = shape.least_thickness
    found = [
        (-apart_from_plane(shape, pose, plane).gap, plane.id, reach_between(thickness, share=share))
        for plane in structure.planes
    ]
    for other in structure.near(brick):
        reach = reach_between(thickness, other.brick.shape.least_thickness, share)
        found.append((-apart(shape, pose, other.brick.shape, other.pose).gap, other.brick.id, reach))
    depth, deepest = max(((depth, other) for depth, other, reach in found if depth > reach), default=(0.0, ""))
    if not deepest:
        return ""
    return f"{brick} is {MILLIMETRES * depth:.3g} mm deep in {deepest}, so they are not taken to touch"
