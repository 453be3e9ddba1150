"""The collision shapes of a world: boxes, and boxes with rounded edges. Lengths in engine metres.

PyBullet gives two boxes that touch along an edge the normal of a face, and planks that lean on each other then need
twice the friction that they should. The convex hull of eight corners does not suffer from this: they stand a small
radius inside the box, and the collision margin of that radius makes the outer size exact (docs/decisions/0012).
"""

from dataclasses import dataclass, field
from itertools import product

from stability.model import Vec3
from stability.pybullet_engine.binding import pybullet


@dataclass
class Solids:
    """The shapes that bodies of one client have in common."""

    client: int
    _boxes: dict[Vec3, int] = field(default_factory=dict, init=False)
    _hulls: dict[tuple[Vec3, float], int] = field(default_factory=dict, init=False)

    def box(self, half_extents: Vec3) -> int:
        """The number of a box."""
        if half_extents not in self._boxes:
            self._boxes[half_extents] = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=self.client
            )
        return self._boxes[half_extents]

    def rounded_box(self, half_extents: Vec3, radius: float) -> int:
        """The number of a box with rounded edges; its body must be given the radius as collision margin."""
        if (half_extents, radius) not in self._hulls:
            corners = [
                [side * (half - radius) for side, half in zip(sides, half_extents, strict=True)]
                for sides in product((-1.0, 1.0), repeat=3)
            ]
            self._hulls[half_extents, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._hulls[half_extents, radius]
