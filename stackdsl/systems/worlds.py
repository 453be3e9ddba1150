"""What a system needs to play a timeline: a world of its own, and the extension that watches it."""

from dataclasses import replace
from math import floor, hypot, log2, sqrt
from statistics import median_low

from stability.engines.lazy_world import RestingWorld
from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.protocol import World
from stability.engines.sapien.sapien_settings import SapienSettings
from stability.engines.settings import EngineSettings
from stability.watching.extension import Extension
from stability.watching.freezing import RestLimits
from stackdsl.systems.systems import Method, System
from stackdsl.timeline import Timeline

# The scene that limits and settings were chosen for: KAPLA planks on earth.
USUAL_GRAVITY, USUAL_SIZE, USUAL_DIAGONAL = 9.81, 0.0078, 0.1202  # [m/s2], [m], [m]
# Steps are no more than this share of a doubling longer than in the usual scene, or they are halved.
MOST_LONGER = 0.25
SAMPLING = 0.01  # [s] between looks at all that moves; a free fall covers half a millimetre in the first


def rest_limits(timeline: Timeline) -> RestLimits:
    """The usual limits, scaled so that larger bricks or weaker gravity give the same verdicts (Froude)."""
    size = _largest_side(timeline)
    return RestLimits().scaled(lengths=size, times=_times(size, timeline))


def settings_for(timeline: Timeline, system: System) -> EngineSettings:
    """The engine settings of a system; those that were chosen for the usual scene are scaled in the same way.

    The time that a brick takes to topple goes with its diagonal, and how deep it may be struck with its smallest side.
    The engine sees most bricks as large as the usual ones, so that what it takes for little is. All go by powers of
    two, so that scenes which hardly differ are stepped alike.
    """
    usual = system.engine
    if usual.lively_speed is None or usual.most_travel is None:  # as it comes, or as published
        return usual
    bricks = [placement.brick for placement in timeline.placements]
    smallest = min(min(brick.size) for brick in bricks) / USUAL_SIZE
    diagonals = [hypot(*brick.size) / USUAL_DIAGONAL for brick in bricks]
    largest = _largest_side(timeline)
    slower = largest / _times(largest, timeline)
    # What is compared with this allows for a fall until the next look, which is no motion yet.
    seen = usual.lively_speed - SAMPLING * USUAL_GRAVITY
    return replace(
        usual,
        time_step=usual.time_step * _power_of_two(_times(max(diagonals), timeline)),
        scale=usual.scale / _power_of_two(median_low(diagonals)),
        most_travel=usual.most_travel * _power_of_two(smallest),
        lively_speed=max(usual.lively_speed * slower, seen * slower + SAMPLING * timeline.world.gravity),
    )


def _largest_side(timeline: Timeline) -> float:
    """The largest smallest side of a brick, in that of the usual one."""
    return max(min(placement.brick.size) for placement in timeline.placements) / USUAL_SIZE


def _times(lengths: float, timeline: Timeline) -> float:
    """How many times longer all takes than in the usual scene, where lengths are so many times larger."""
    return sqrt(lengths * USUAL_GRAVITY / timeline.world.gravity)


def _power_of_two(factor: float) -> float:
    """The largest power of two that is hardly larger."""
    return float(2.0 ** floor(log2(factor) + MOST_LONGER))


def load(system: System) -> None:
    """Import what a system needs from the start, so that no run is charged for what the first in a process loads."""
    if system.method is Method.PROVEN:
        import stability.exact.proven_stability  # noqa: F401, PLC0415 -- other systems need no statics
    else:
        load_engine(system.engine)


def load_engine(settings: EngineSettings) -> None:
    """Import the engine that these are settings of."""
    match settings:
        case MuJoCoSettings():
            import stability.engines.mujoco.mujoco_world  # noqa: PLC0415 -- not where no engine may be needed
        case SapienSettings():
            import stability.engines.sapien.sapien_world  # noqa: PLC0415 -- likewise
        case _:
            import stability.engines.pybullet  # noqa: F401, PLC0415 -- likewise


def opened_world(timeline: Timeline, system: System) -> World:
    """An empty world with the planes of the timeline; close it after use."""
    scene, heaviest = timeline.world, max(placement.brick.mass for placement in timeline.placements)
    settings = settings_for(timeline, system)

    def engine() -> World:
        return stepped_world(settings, scene.gravity, scene.friction, heaviest)

    world = RestingWorld(settings, engine) if system.method is Method.PROVEN else engine()
    for plane in scene.planes:
        world.add_plane(plane)
    return world


def stepped_world(settings: EngineSettings, gravity: float, friction: float, heaviest: float) -> World:
    """An empty world of the engine that these are settings of; it is imported here, when something must be stepped.

    Gravity [m/s2] is along -z, friction that of brick on brick, `heaviest` the mass of the heaviest brick to come [kg].
    """
    match settings:
        case MuJoCoSettings():
            from stability.engines.mujoco.mujoco_world import MuJoCoWorld  # noqa: PLC0415 -- not before

            return MuJoCoWorld.opened(settings, gravity, friction)
        case SapienSettings():
            from stability.engines.sapien.sapien_world import SapienWorld  # noqa: PLC0415 -- likewise

            return SapienWorld.opened(settings, gravity, friction)
        case _:
            from stability.engines.pybullet import PyBulletWorld  # noqa: PLC0415 -- likewise

            return PyBulletWorld.opened(settings, gravity, friction, heaviest)


def extension_for(timeline: Timeline, system: System, world: World) -> Extension | None:
    """The extension of a system; nobody else touches the world, so nothing needs to be guarded."""
    limits, scene = rest_limits(timeline), timeline.world
    match system.method:
        case Method.PROVEN:
            from stability.exact.proven_stability import ProvenStability  # noqa: PLC0415 -- other systems need no statics

            return ProvenStability(
                world, scene.planes, scene.friction, scene.gravity, limits, guard=False, joiner=world
            )
        case Method.PUBLISHED:
            from stability.published.stack_stability import StackStability  # noqa: PLC0415 -- likewise

            return StackStability(
                world, limits, guard=False, friction=scene.friction, planes=scene.planes, gravity=scene.gravity
            )
        case None:
            return None
