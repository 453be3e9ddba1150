"""Says which bodies are too deep in each other to count as touching, for the reason of a verdict."""

from stability.geometry.separation import box_above_plane, boxes_apart
from stability.geometry.touching import reach_between
from stability.model import BodyId
from stability.statics.structure import Structure

MILLIMETRES = 1000.0


def overlap_in_words(structure: Structure, brick: BodyId) -> str:
    """The body that a brick is deepest in, in words; empty if it is in none by more than still counts as touching."""
    placed = structure.bricks[brick]
    size, pose = placed.brick.size, placed.pose
    share, thickness = structure.tolerances.gap, min(size)
    found = [
        (-box_above_plane(size, pose, plane).gap, plane.id, reach_between(thickness, share=share))
        for plane in structure.planes
    ]
    for other in structure.near(brick):
        reach = reach_between(thickness, min(other.brick.size), share)
        found.append((-boxes_apart(size, pose, other.brick.size, other.pose).gap, other.brick.id, reach))
    depth, deepest = max(((depth, other) for depth, other, reach in found if depth > reach), default=(0.0, ""))
    if not deepest:
        return ""
    return f"{brick} is {MILLIMETRES * depth:.3g} mm deep in {deepest}, so they are not taken to touch"
