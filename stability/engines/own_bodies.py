"""What a world of one's own knows without asking an engine: which planes and bricks there are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from stability.model import BodyId, Brick, HalfSpace, Plane, Shape

if TYPE_CHECKING:
    from stability.geometry.bounding_boxes import BoundingBoxes


@dataclass
class OwnBodies:
    """The planes and bricks of a world by name, in the order in which they came."""

    planes: dict[BodyId, Plane] = field(default_factory=dict)
    bricks: dict[BodyId, Brick] = field(default_factory=dict)
    # As `Engine` promises, these are other objects once something has come or gone.
    masses: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # of bricks [kg]
    fixed: frozenset[BodyId] = field(default=frozenset(), init=False)  # the planes
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)

    def add_plane(self, plane: Plane) -> None:
        """Know a plane from now on."""
        self.planes[plane.id] = plane
        self.fixed = frozenset(self.planes)

    def add_brick(self, brick: Brick) -> None:
        """Know a brick from now on."""
        self.bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self.masses = MappingProxyType(self._masses)

    def remove_brick(self, brick: BodyId) -> None:
        """Forget a brick."""
        del self.bricks[brick], self._masses[brick]
        self.masses = MappingProxyType(self._masses)

    def shape(self, body: BodyId) -> Shape:
        """The shape of a body, as it was asked for."""
        return HalfSpace(self.planes[body].normal_W) if body in self.planes else self.bricks[body].shape

    def near(self, brick: BodyId, boxes: "BoundingBoxes", within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m], by the boxes around all bricks as they are now."""
        planes = [name for name, plane in self.planes.items() if boxes.reaches_plane(brick, plane, within)]
        return sorted([*boxes.near(brick, within), *planes])
