"""The upright box in which bricks have been, and may be soon."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot, inf

from stability.engines.scene_scale import SAMPLING
from stability.model import BodyId, BodyState, Brick, Vec3

# [s] Looks at what moves are a SAMPLING apart, those at others may be one behind, and a hit makes something faster.
AHEAD = 3.0 * SAMPLING


@dataclass
class Space:
    """Grows, and never shrinks: where something has been, something may lie."""

    low_W: Vec3 = (inf, inf, inf)
    high_W: Vec3 = (-inf, -inf, -inf)

    def takes(self, brick: Brick, state: BodyState, gravity: float) -> None:
        """Reach as far as a brick may get before it is seen again."""
        shape = brick.shape
        speed = hypot(*state.velocity_W) + AHEAD * gravity
        reach = shape.bounding_radius + shape.least_thickness + AHEAD * speed
        (x, y, z), (ax, ay, az), (bx, by, bz) = state.pose.position_W, self.low_W, self.high_W
        self.low_W = (min(ax, x - reach), min(ay, y - reach), min(az, z - reach))
        self.high_W = (max(bx, x + reach), max(by, y + reach), max(bz, z + reach))

    def follows(self, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState], gravity: float) -> None:
        """Reach as far as bricks may get, of all by name."""
        for name, state in states.items():
            self.takes(bricks[name], state, gravity)

    def joins(self, other: "Space") -> None:
        """Reach as far as another one, too."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        (cx, cy, cz), (dx, dy, dz) = other.low_W, other.high_W
        self.low_W, self.high_W = (min(ax, cx), min(ay, cy), min(az, cz)), (max(bx, dx), max(by, dy), max(bz, dz))

    def meets(self, other: "Space") -> bool:
        """Whether another one comes into it."""
        pairs = zip(self.low_W, other.high_W, strict=True), zip(other.low_W, self.high_W, strict=True)
        return all(low <= high for pair in pairs for low, high in pair)
