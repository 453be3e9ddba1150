"""Does it matter how what begins to move begins? Only then is it worth an engine's finest steps.

Bricks that move collide among themselves without being eased in. What hits frozen bricks with a small share of the
energy of all that moves adds no more than that to the error of those collisions, but all pay for its steps.
"""

from collections.abc import Collection
from typing import Final

from stability.engines.protocol import World
from stability.geometry.vectors import dot
from stability.model import BodyId
from stability.watching.extension import Update

LEAST_SHARE: Final = 0.02  # of the energy of motion; the foremost of a row of dominoes has more than that


def begins_to_matter(world: World, update: Update, moving: Collection[BodyId]) -> bool:
    """Whether what hits or presses the woken bricks has a share of the energy of all that moves which counts."""
    moves = [brick for brick in moving if brick not in update.woken]
    if not update.by or not moves:
        return True
    masses, states = world.masses(), world.states(moves)
    speeds = {brick: dot(state.velocity_W, state.velocity_W) for brick, state in states.items()}
    energy = {brick: masses[brick] * squared for brick, squared in speeds.items()}
    return sum(energy.get(brick, 0.0) for brick in update.by) >= LEAST_SHARE * sum(energy.values())
