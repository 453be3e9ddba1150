"""Opens the world in which a system plays a timeline, and the stability extension that watches it."""

from collections.abc import Collection
from typing import cast

from stability.engines.lazy_world import EngineFactory, RestingWorld, load_engine, stepped_world
from stability.engines.protocol import EngineSettings, RecordsSteps, World
from stability.engines.resized_world import ResizedWorld
from stability.engines.scene_scale import SceneScale
from stability.model import Brick
from stability.stabilizers.protocol import Stabilizer
from stability.stabilizers.rest import RestLimits
from stackdsl.entry_points import offered_systems
from stackdsl.simulation.known_systems import KNOWN
from stackdsl.simulation.systems import Method, System
from stackdsl.timeline import Timeline


def scale_of(timeline: Timeline) -> SceneScale:
    """Return how much larger and slower the scene of a timeline is than the usual scene."""
    return SceneScale.of([placement.brick for placement in timeline.placements], timeline.world.gravity)


def rest_limits(timeline: Timeline) -> RestLimits:
    """Return the rest limits of the published method, scaled by the thickest brick."""
    scale = scale_of(timeline)
    return RestLimits().scaled(lengths=scale.thickest_side, times=scale.times(scale.thickest_side))


def settings_for(timeline: Timeline, system: System) -> EngineSettings:
    """Return the engine settings of a system, scaled to the size and gravity of a timeline."""
    return system.engine.scaled(scale_of(timeline).resized(system.modification.size))


def _is_foreign(system: System) -> bool:
    """Check that another package offers a system, so that faults of its engine are reported as that package's."""
    return system.name not in KNOWN and system.name in offered_systems()


def load(system: System) -> None:
    """Import the modules of a system before the run, so that the run time of the first case does not include it."""
    if system.method is Method.PROVEN:
        import stability.stabilizers.exact.stabilizer  # noqa: F401, PLC0415 -- other systems need no statics
    elif not _is_foreign(system):
        load_engine(system.engine)
    else:
        from stackdsl.simulation.plugins import world_class  # noqa: PLC0415 -- it reads the installed packages

        world_class(system)


def opened_world(timeline: Timeline, system: System) -> World:
    """Open a world with the planes of a timeline and no bricks; close it after use."""
    scene, settings, size = timeline.world, settings_for(timeline, system), system.modification.size

    def engine(settings: EngineSettings, heaviest: float) -> World:
        if not _is_foreign(system):
            return stepped_world(settings, size * scene.gravity, scene.friction, heaviest)
        from stackdsl.simulation.plugin_world import opened_plugin_world  # noqa: PLC0415 -- rare

        return opened_plugin_world(system, settings, size * scene.gravity, scene.friction, heaviest)

    def settings_of(bricks: Collection[Brick]) -> EngineSettings:
        return system.engine.scaled(SceneScale.of(bricks, size * scene.gravity))

    world = (
        RestingWorld(EngineFactory(settings, settings_of, engine))
        if system.method is Method.PROVEN
        else engine(settings, size**3 * max(placement.brick.mass for placement in timeline.placements))
    )
    if size != 1.0:
        world = ResizedWorld(world, size)
    for plane in scene.planes:
        world.add_plane(plane)
    return world


def extension_for(timeline: Timeline, system: System, world: World) -> Stabilizer | None:
    """Return the stability extension of a system; without guard, as no other code changes the world."""
    scene = timeline.world
    match system.method:
        case Method.PROVEN:
            from stability.stabilizers.exact.stabilizer import ProvenStability  # noqa: PLC0415 -- imports statics

            limits = RestLimits().scaled(lengths=1.0, times=scale_of(timeline).times(1.0))
            return ProvenStability(
                world,
                scene.planes,
                scene.friction,
                scene.gravity,
                limits,
                guard=False,
                joiner=world,
                presser=world,
                tolerances=scene.tolerances,
                joints=scene.joints,
                strengths=scene.strengths,
                ties=scene.ties,
                recorder=cast("RecordsSteps", world) if scene.has_joints else None,
            )
        case Method.PUBLISHED:
            from stability.stabilizers.published.stabilizer import StackStability  # noqa: PLC0415 -- likewise
            from stability.stabilizers.published.support import AS_READ  # noqa: PLC0415 -- likewise

            return StackStability(
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
