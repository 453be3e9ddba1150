"""How deep are bodies in each other? By their shapes alone, whatever an engine takes for a contact.

Exact for every shape; of where bricks are at one time. What is not looked at does not move.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from stability.geometry.neighbours import Neighbours
from stability.model import BodyId, Brick, Plane, Pose
from stability.shapes.apart import InPlace, apart_from_plane, bodies_apart, in_place
from stackdsl.trace import Penetration


@dataclass
class OverlapMeter:
    """Looks for the two bodies that are deepest in each other."""

    planes: Sequence[Plane]
    penetration: Penetration | None = None  # None before anything was placed
    _blocks: dict[BodyId, InPlace] = field(default_factory=dict)
    _near: Neighbours[BodyId] = field(default_factory=Neighbours)

    def see(self, time: float, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        self.put(bricks, poses)
        for name, pose in poses.items():
            self._compare(time, bricks[name], pose, poses)

    def put(self, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Some are here by now. What moves beside them was seen before, so that nothing is compared yet."""
        for name, pose in poses.items():
            self.forget([name])
            block = self._blocks[name] = in_place(bricks[name].shape, pose)
            self._near.add(name, block.low_W, block.high_W)

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out."""
        for name in bricks:
            if self._blocks.pop(name, None) is not None:
                self._near.remove(name)

    def _compare(self, time: float, brick: Brick, pose: Pose, moving: Mapping[BodyId, Pose]) -> None:
        for plane in self.planes:
            self._found(time, brick.id, plane.id, -apart_from_plane(brick.shape, pose, plane).gap)
        for other in self._near.near(brick.id, 0.0):
            if other not in moving or brick.id < other:  # each pair once
                self._found(time, brick.id, other, -bodies_apart(self._blocks[brick.id], self._blocks[other]).gap)

    def _found(self, time: float, brick: BodyId, other: BodyId, depth: float) -> None:
        if depth > (self.penetration.depth if self.penetration is not None else -1.0):
            self.penetration = Penetration(max(0.0, depth), brick, other, time)
