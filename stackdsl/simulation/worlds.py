"""What a system needs to play a timeline: a world of its own, and the extension that watches it."""

from collections.abc import Collection

from stability.engines.lazy_world import Opening, RestingWorld, load_engine, stepped_world
from stability.engines.protocol import EngineSettings, World
from stability.engines.resized_world import ResizedWorld
from stability.engines.scene_scale import SceneScale
from stability.model import Brick
from stability.stabilizers.protocol import Stabilizer
from stability.stabilizers.rest import RestLimits
from stackdsl.simulation.systems import Method, System
from stackdsl.timeline import Timeline


def scale_of(timeline: Timeline) -> SceneScale:
    """How much larger and slower a timeline is than the usual scene."""
    return SceneScale.of([placement.brick for placement in timeline.placements], timeline.world.gravity)


def rest_limits(timeline: Timeline) -> RestLimits:
    """The usual limits of the published method, scaled by the thickest brick of all."""
    scale = scale_of(timeline)
    return RestLimits().scaled(lengths=scale.thickest_side, times=scale.times(scale.thickest_side))


def settings_for(timeline: Timeline, system: System) -> EngineSettings:
    """The engine settings of a system, scaled to a timeline, as it is played, as the engine asks for."""
    return system.engine.scaled(scale_of(timeline).resized(system.modification.size))


def load(system: System) -> None:
    """Import what a system needs from the start, so that no run is charged for what the first in a process loads."""
    if system.method is Method.PROVEN:
        import stability.stabilizers.exact.stabilizer  # noqa: F401, PLC0415 -- other systems need no statics
    else:
        load_engine(system.engine)


def opened_world(timeline: Timeline, system: System) -> World:
    """An empty world with the planes of a timeline, as it is played; close it after use."""
    scene, settings, size = timeline.world, settings_for(timeline, system), system.modification.size

    def engine(settings: EngineSettings, heaviest: float) -> World:
        return stepped_world(settings, size * scene.gravity, scene.friction, heaviest)

    def settings_of(bricks: Collection[Brick]) -> EngineSettings:
        return system.engine.scaled(SceneScale.of(bricks, size * scene.gravity))

    world = (
        RestingWorld(Opening(settings, settings_of, engine))
        if system.method is Method.PROVEN
        else engine(settings, size**3 * max(placement.brick.mass for placement in timeline.placements))
    )
    if size != 1.0:
        world = ResizedWorld(world, size)
    for plane in scene.planes:
        world.add_plane(plane)
    return world


def extension_for(timeline: Timeline, system: System, world: World) -> Stabilizer | None:
    """The extension of a system; nobody else touches the world, so nothing needs to be guarded."""
    scene = timeline.world
    match system.method:
        case Method.PROVEN:
            from stability.stabilizers.exact.variants import ShakenStability  # noqa: PLC0415 -- other systems need no statics

            limits = RestLimits().scaled(lengths=1.0, times=scale_of(timeline).times(1.0))
            return ShakenStability(
                world,
                scene.planes,
                scene.friction,
                scene.gravity,
                limits,
                guard=False,
                joiner=world,
                presser=world,
                tolerances=scene.tolerances,
            )
        case Method.PUBLISHED:
            from stability.stabilizers.published.stabilizer import HandledStack  # noqa: PLC0415 -- likewise
            from stability.stabilizers.published.support import AS_READ  # noqa: PLC0415 -- likewise

            return HandledStack(
                world,
                rest_limits(timeline),
                guard=False,
                friction=scene.friction,
                planes=scene.planes,
                gravity=scene.gravity,
                readings=system.readings or AS_READ,
            )
        case None:
            return None
