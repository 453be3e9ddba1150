"""Says which bodies are too deep in each other to count as touching, for the reason of a verdict."""

from stability.geometry.separation import box_above_plane, boxes_apart
from stability.model import BodyId
from stability.statics.structure import Structure

MILLIMETRES = 1000.0


def overlap_in_words(structure: Structure, brick: BodyId) -> str:
    """The body that a brick is deepest in, in words; empty if it is in none by more than still counts as touching."""
    placed = structure.bricks[brick]
    size, pose = placed.brick.size, placed.pose
    found = [(-box_above_plane(size, pose, plane).gap, plane.id) for plane in structure.planes]
    for other in structure.near(brick):
        found.append((-boxes_apart(size, pose, other.brick.size, other.pose).gap, other.brick.id))
    depth, deepest = max(found, default=(0.0, ""))
    if depth <= structure.tolerances.gap * min(size):
        return ""
    return f"{brick} is {MILLIMETRES * depth:.3g} mm deep in {deepest}, so they are not taken to touch"
