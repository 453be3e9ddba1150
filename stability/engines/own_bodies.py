"""What the adapter of a world of one's own keeps itself: its clock, and which planes and bricks there are."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import ceil, sqrt
from types import MappingProxyType

from stability.engines.settings import EngineSettings
from stability.geometry.bounding_boxes import BoundingBoxes
from stability.geometry.vectors import cross, dot
from stability.model import BodyId, Box, Brick, HalfSpace, Plane, Quaternion, Shape, Vec3

OPPOSITE = -1.0 + 1e-12  # cosine below which any turn by 180 deg is the shortest


@dataclass
class KeptBodies(ABC):
    """The part of a world that needs no engine."""

    gravity: float  # [m/s2], along -z
    friction: float  # Coulomb coefficient of brick on brick
    settings: EngineSettings = field(kw_only=True)
    _parts: int = field(default=1, init=False)  # engine steps in one step
    _eased: int = field(default=0, init=False)  # steps to come that are split because bodies begin to press
    _clock: float = field(default=0.0, init=False)
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _fixed: frozenset[BodyId] = field(default=frozenset(), init=False)
    _bricks: dict[BodyId, Brick] = field(default_factory=dict, init=False)
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)
    _masses_view: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # what `masses` answers with

    @abstractmethod
    def _boxes(self) -> BoundingBoxes:
        """The boxes around all bricks as they are now."""

    def time(self) -> float:
        return self._clock

    def skip(self, duration: float) -> None:
        self._clock += duration

    def limit_travel(self, fastest: float) -> None:
        if self.settings.most_travel is not None:
            self._parts = max(1, ceil(fastest * self.settings.time_step / self.settings.most_travel))

    def ease_in(self) -> None:
        self._eased = self.settings.first_steps

    def _count_step(self) -> int:
        """Let the clock go on by a step; returns in how many parts the engine has to take it."""
        parts = max(self._parts, self.settings.first_parts if self._eased else 1)
        self._eased = max(0, self._eased - 1)
        self._clock += self.settings.time_step
        return parts

    def masses(self) -> Mapping[BodyId, float]:
        return self._masses_view

    def fixed(self) -> Set[BodyId]:
        return self._fixed

    def shape(self, body: BodyId) -> Shape:
        return HalfSpace(self._planes[body].normal_W) if body in self._planes else Box(self._bricks[body].size)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        boxes = self._boxes()
        planes = [name for name, plane in self._planes.items() if boxes.reaches_plane(brick, plane, within)]
        return sorted([*boxes.near(brick, within), *planes])

    def _keep_plane(self, plane: Plane) -> None:
        self._planes[plane.id] = plane
        self._fixed = frozenset(self._planes)

    def _keep_brick(self, brick: Brick) -> None:
        self._bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self._masses_view = MappingProxyType(self._masses)  # another object says that a brick has come

    def _forget_brick(self, brick: BodyId) -> None:
        del self._bricks[brick], self._masses[brick]
        self._masses_view = MappingProxyType(self._masses)


def shortest_turn(before: Vec3, after: Vec3) -> Quaternion:
    """The shortest turn that takes one unit vector to another."""
    cosine = dot(before, after)
    if cosine < OPPOSITE:
        x, y, z = before
        return _half_turn_about((0.0, -z, y) if abs(x) < abs(z) else (-y, x, 0.0))
    half = sqrt(2.0 * (1.0 + cosine))
    x, y, z = cross(before, after)
    return (x / half, y / half, z / half, half / 2.0)


def _half_turn_about(axis: Vec3) -> Quaternion:
    length = sqrt(dot(axis, axis))
    return (axis[0] / length, axis[1] / length, axis[2] / length, 0.0)
