"""Does it matter how what begins to move begins? Only then is it worth an engine's finest steps.

Bricks that move collide among themselves without being eased in. What hits frozen bricks with a small share of the
energy of all that moves adds no more than that to the error of those collisions, but all pay for its steps. When a
crowd has come down, its last brick that still slides has most of the energy that is left, but next to none of what the
crowd fell with: where the others lie, and so what is hit, is known no better than those collisions were.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

from stability.engines.protocol import World
from stability.geometry.vectors import dot
from stability.model import BodyId, BodyState
from stability.watching.extension import Update

LEAST_SHARE: Final = 0.02  # of the energy of motion; the foremost of a row of dominoes has more than that
# Bricks that move at once: of more, what they had at most counts as well. To ease one of so many in takes as long as
# they take for a third of a second, and where one of hundreds comes to lie is chance.
CROWD: Final = 200


@dataclass
class Beginnings:
    """Looks at what moves in a world, and knows what a crowd has had."""

    world: World
    _most: float = field(default=0.0, init=False)  # of a crowd, since something was done with it; twice that [J]

    def done(self) -> None:
        """Something is done: how it goes on has nothing to do with what fell before."""
        self._most = 0.0

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if len(states) > CROWD:
            self._most = max(self._most, sum(self._energies(states).values()))

    def matters(self, update: Update, moving: Collection[BodyId]) -> bool:
        """Whether what hits or presses the woken bricks has a share of the energy of motion which counts."""
        moves = [brick for brick in moving if brick not in update.woken]
        if not update.by or not moves:
            return True
        energies = self._energies(self.world.states(moves))
        there_is = sum(energies.values())
        all_of_it = max(there_is, self._most) if len(moves) > CROWD else there_is
        return sum(energies.get(brick, 0.0) for brick in update.by) >= LEAST_SHARE * all_of_it

    def absorb(self, other: "Beginnings") -> None:
        """Know what the bricks of another have had, which are of this world by now."""
        self._most += other._most

    def _energies(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, float]:
        """Twice the energy of each by its velocity [J]."""
        masses = self.world.masses()
        return {brick: masses[brick] * dot(state.velocity_W, state.velocity_W) for brick, state in states.items()}
