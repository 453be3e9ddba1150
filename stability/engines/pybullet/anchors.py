"""Springs that hold the resting contacts of bricks in place, while all is quiet."""

from collections.abc import Collection
from dataclasses import dataclass, field

from stability.engines.pybullet.client_bodies import ClientBodies
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.model import BodyId


@dataclass
class Anchors:
    """Which bricks are anchored: those that lie square, as those that lean would stand where they should slip."""

    bodies: ClientBodies
    wanted: bool  # whether any brick is to be anchored
    _quiet: bool = field(default=True, init=False)
    _bricks: set[BodyId] = field(default_factory=set, init=False)

    def add(self, brick: BodyId) -> None:
        """Anchor a new brick, as long as all is quiet."""
        if self.wanted:
            self._bricks.add(brick)
            self._tell([brick])

    def remove(self, brick: BodyId) -> None:
        """Forget a brick."""
        self._bricks.discard(brick)

    def renew(self, brick: BodyId) -> None:
        """Anchor a brick that has got another body, if it was anchored."""
        if brick in self._bricks:
            self._tell([brick])

    def choose(self, lively: bool) -> None:
        """Hold all of them while nothing is fast."""
        self._quiet = not lively
        self._tell(sorted(self._bricks, key=self.bodies.numbers.__getitem__))

    def _tell(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            body = self.bodies.numbers[brick]
            pybullet.changeDynamics(body, -1, frictionAnchor=int(self._quiet), physicsClientId=self.bodies.client)
