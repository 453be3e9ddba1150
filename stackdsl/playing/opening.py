"""What a system needs to play a timeline: a world of its own, and the extension that watches it."""

from math import sqrt

from stability.engine import World
from stability.extension import StackStability
from stability.freezing import RestLimits
from stability.resting_world import RestingWorld
from stability.watching import Extension
from stackdsl.playing.systems import Method, System
from stackdsl.timeline import Timeline

# The scene that the rest limits were chosen for: KAPLA planks on earth.
USUAL_GRAVITY, USUAL_SIZE = 9.81, 0.0078  # [m/s2], [m]


def rest_limits(timeline: Timeline) -> RestLimits:
    """The usual limits, scaled so that larger bricks or weaker gravity give the same verdicts (Froude)."""
    size = max(min(placement.brick.size) for placement in timeline.placements) / USUAL_SIZE
    return RestLimits().scaled(lengths=size, times=sqrt(size * USUAL_GRAVITY / timeline.world.gravity))


def load(system: System) -> None:
    """Import what a system needs from the start, so that no run is charged for what the first in a process loads."""
    if system.method is Method.PROVEN:
        import stability.proven_extension  # noqa: PLC0415 -- other systems need no statics
    else:
        import stability.pybullet_engine  # noqa: F401, PLC0415 -- not where no engine may be needed


def opened_world(timeline: Timeline, system: System) -> World:
    """An empty world with the planes of the timeline; close it after use."""
    heaviest = max(placement.brick.mass for placement in timeline.placements)

    def engine() -> World:
        from stability.pybullet_engine import PyBulletWorld  # noqa: PLC0415 -- not before something must be stepped

        return PyBulletWorld.opened(system.engine, timeline.world.gravity, timeline.world.friction, heaviest)

    world = RestingWorld(system.engine, engine) if system.method is Method.PROVEN else engine()
    for plane in timeline.world.planes:
        world.add_plane(plane)
    return world


def extension_for(timeline: Timeline, system: System, world: World) -> Extension | None:
    """The extension of a system; nobody else touches the world, so nothing needs to be guarded."""
    limits, scene = rest_limits(timeline), timeline.world
    match system.method:
        case Method.PROVEN:
            from stability.proven_extension import ProvenStability  # noqa: PLC0415 -- other systems need no statics

            return ProvenStability(
                world, scene.planes, scene.friction, scene.gravity, limits, guard=False, joiner=world
            )
        case Method.PUBLISHED:
            return StackStability(
                world, limits, guard=False, friction=scene.friction, planes=scene.planes, gravity=scene.gravity
            )
        case None:
            return None
