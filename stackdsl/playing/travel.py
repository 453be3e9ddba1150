"""How far may what moves travel in one step of an engine? What is fast would pass through something otherwise."""

from collections.abc import Mapping
from math import hypot

from stability.engines.protocol import World
from stability.engines.scene_scale import SAMPLING
from stability.model import BodyId, BodyState


def limit_travel(world: World, states: Mapping[BodyId, BodyState], gravity: float) -> int:
    """Let the world step finely enough for what moves now, as fast as it may get until the next look.

    Returns into how many parts it splits a step for that.
    """
    fastest = max((hypot(*state.velocity_W) for state in states.values()), default=0.0)
    fastest += SAMPLING * gravity
    world.limit_travel(fastest)
    return world.settings.parts_for_travel(fastest)
