"""Puts bricks that were woken and hardly moved back where they were, because engines let every brick creep a little.

What was struck is the exception: a tap moves it by little, and a hundred taps by a lot. It stays where it comes to
rest.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

from stability.geometry.rotations import turn_between
from stability.model import BodyId, Pose
from stability.statics.facts import Placed
from stability.watching.life_cycle import BrickObserver

# Shares of the smallest side, for a plank 0.3 and 0.02 mm. If all that was woken has moved less than the first, the hit
# moved nothing; if something did move, only what the engine's creep has moved goes back.
HIT_NOTHING = 0.04
CREPT = 0.0026
DRIVEN = 5e-4  # 4 micrometres: what a hand may have moved and did not move further has crept; hands push slowly
NOTHING = 1e-4  # a micrometre: what was struck and did not move even so far was not moved


@dataclass
class RestPoses(BrickObserver):
    """Where bricks stood when a hit woke them."""

    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)
    _struck: set[BodyId] = field(default_factory=set, init=False)  # those of them that were pushed along the ground
    _driven: set[BodyId] = field(default_factory=set, init=False)  # those that a hand may have moved, by however little

    def remember(self, poses: Mapping[BodyId, Pose], struck: Collection[BodyId] = ()) -> None:
        """Remember where bricks stand that a hit wakes, and which of them it meant to move along the ground.

        A brick that has not come to rest since an earlier hit keeps the rest pose that it had before that one.
        """
        self._poses = {**poses, **self._poses}
        self._struck.update(struck)

    def remember_driven(self, poses: Mapping[BodyId, Pose]) -> None:
        """The same of bricks that a hand may move: what it pushes keeps its shift, however little that is."""
        self.remember(poses)
        self._driven.update(poses)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Where bricks are frozen again is where they stand."""
        for brick in bricks:
            self._poses.pop(brick, None)
        self._struck.difference_update(bricks)
        self._driven.difference_update(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone has no place to go back to."""
        self.frozen(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._poses |= other._poses
        self._struck |= other._struck
        self._driven |= other._driven

    def __contains__(self, brick: object) -> bool:
        return brick in self._poses

    def put_back(self, coming: Sequence[Placed]) -> list[Placed]:
        """The bricks that come to rest; each that hardly moved, and was not struck, is at its rest pose."""
        moves = {placed.brick.id: self._moved(placed) for placed in coming if placed.brick.id in self._poses}
        limit = HIT_NOTHING if all(move <= HIT_NOTHING for move in moves.values()) else CREPT
        limits = {brick: NOTHING if brick in self._struck else limit for brick in moves}
        limits |= {brick: min(DRIVEN, limits[brick]) for brick in moves if brick in self._driven}
        return [
            replace(placed, pose=self._poses[placed.brick.id])
            if placed.brick.id in moves and moves[placed.brick.id] <= limits[placed.brick.id]
            else placed
            for placed in coming
        ]

    def _moved(self, placed: Placed) -> float:
        """How far any point of a brick may have moved, as a share of its smallest side."""
        home, shape = self._poses[placed.brick.id], placed.brick.shape
        shift = dist(home.position_W, placed.pose.position_W) + 0.5 * shape.length * turn_between(home, placed.pose)
        return shift / shape.least_thickness
