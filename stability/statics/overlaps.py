"""Says which bodies are too deep in each other to count as touching, for the reason of a verdict."""

from stability.model import BodyId
from stability.shapes.apart import apart, apart_from_plane
from stability.statics.structure import Structure

MILLIMETRES = 1000.0


def overlap_in_words(structure: Structure, brick: BodyId) -> str:
    """The body that a brick is deepest in, in words; empty if it is in none by more than still counts as touching."""
    placed = structure.bricks[brick]
    shape, pose = placed.brick.shape, placed.pose
    found = [(-apart_from_plane(shape, pose, plane).gap, plane.id) for plane in structure.planes]
    for other in structure.near(brick):
        found.append((-apart(shape, pose, other.brick.shape, other.pose).gap, other.brick.id))
    depth, deepest = max(found, default=(0.0, ""))
    if depth <= structure.tolerances.gap * shape.least_thickness:
        return ""
    return f"{brick} is {MILLIMETRES * depth:.3g} mm deep in {deepest}, so they are not taken to touch"
