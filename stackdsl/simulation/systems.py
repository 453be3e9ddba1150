"""The systems that can play a scenario: our own, reference engines, and modified scenes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from math import sqrt
from typing import TYPE_CHECKING, Self

from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.protocol import EngineSettings
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.rigid.settings import RigidSettings, Solving
from stackdsl.timeline import Action, Arrival, FixedWorld, Placement, Timeline

if TYPE_CHECKING:
    from stability.stabilizers.published.support import Readings


# Changes of a scene before it is played, for an engine that cannot stack with real constants.
#
# The second system of the publication works like this: gravity and friction are changed until the engine stacks.
# Results have the lengths of the scenario as written, and the time of the changed scene. Gravity is converted to the
# lengths as written, so it is weaker by the factor by which the bricks are larger.


@dataclass(frozen=True, slots=True)
class Modification:
    """Changed constants of a scene; by default none is changed."""

    gravity: float | None = None  # [m/s2]
    friction: float | None = None  # Coulomb coefficient of every contact, ground and walls included
    size: float = 1.0  # factor on all lengths, at the same density

    @property
    def summary(self) -> str:
        """The changes in words; empty if there are none."""
        return ", ".join(self._changes())

    def _changes(self) -> Iterator[str]:
        if self.gravity is not None:
            yield f"gravity {self.gravity:g} m/s2"
        if self.friction is not None:
            yield f"friction {self.friction:g} everywhere"
        if self.size != 1.0:
            yield f"lengths times {self.size:g}"


AS_WRITTEN = Modification()


def as_played(timeline: Timeline, modification: Modification) -> Timeline:
    """Return a timeline with the modified constants, in the lengths as written.

    Larger bricks in the same gravity move as the original ones in weaker gravity. So this changes gravity only;
    `opened_world` enlarges the bricks for the engine.
    """
    if modification == AS_WRITTEN:
        return timeline
    world = _world(timeline.world, modification)
    longer = sqrt(timeline.world.gravity / world.gravity)
    return replace(timeline, world=world, actions=tuple(_action(action, longer) for action in timeline.actions))


def _world(world: FixedWorld, modification: Modification) -> FixedWorld:
    gravity = world.gravity if modification.gravity is None else modification.gravity
    changed = replace(world, gravity=gravity / modification.size)
    if modification.friction is None:
        return changed
    planes = tuple(replace(plane, friction=modification.friction) for plane in world.planes)
    return replace(changed, friction=modification.friction, planes=planes)


def _action(action: Action, longer: float) -> Action:
    """Return an action with a longer fall of dropped bricks; the flight of thrown bricks stays the same."""
    if isinstance(action, Placement) and action.arrival is Arrival.DROPPED:
        return replace(action, flight=longer * action.flight)
    return action


# The systems for scenarios: engine settings, with or without a stability extension.
#
# Without PyBullet, `thesis` uses MuJoCo instead (docs/design/architecture.md).


class Method(Enum):
    """The method of a stability extension to decide which bricks stand."""

    PROVEN = "proven"  # exact statics, with a proof of every verdict
    PUBLISHED = "published"  # the stack-stability method


@dataclass(frozen=True, slots=True)
class System:
    """One way to play a timeline."""

    name: str
    summary: str
    engine: EngineSettings
    method: Method | None  # None: no extension, the engine moves every brick
    modification: Modification = AS_WRITTEN  # of every scene, before it is played
    readings: "Readings | None" = None  # of points that the publication leaves open; None: the default reading

    @property
    def extension(self) -> bool:
        """Whether a stability extension freezes stable bricks."""
        return self.method is not None

    def refined(self) -> Self:
        """Return the system with more accurate settings. A result that then changes is a numerical effect."""
        return replace(self, engine=self.engine.refined())

    def at_step(self, factor: float) -> Self:
        """Return the system with its time step times a factor."""
        return replace(self, engine=self.engine.at_step(factor))


STOCK = PyBulletSettings(
    time_step=1.0 / 240.0,
    iterations=50,
    contact_erp=0.2,
    breaking_threshold=0.02,
    linear_damping=0.04,
    angular_damping=0.04,
    residual_threshold=1e-7,
)

# `modified`: the constants that the publication gave up for its second system (docs/design/runs.md).
MODIFIED = Modification(gravity=1.0, friction=1.5)

# `thesis`: the published extension holds bricks that stand; the engine moves the others, as boxes of true size.
HELD = PyBulletSettings(
    time_step=1.0 / 960.0,  # half of it kicks a tower by millimetres
    iterations=50,
    contact_erp=0.4,
    breaking_threshold=0.1,
    scale=100.0,  # 10 is worse, 1000 explodes
    angular_damping=0.02,  # PyBullet's free spin gains energy without it
    most_travel=0.004,  # half a plank's thickness
)

# Chosen by trial against closed forms (docs/design/engines.md): first for right verdicts, then for little creep, in
# real time on one core for 50 planks. Gravity, friction, sizes and masses are real; edges are rounded, and contacts of
# leaning bricks are soft, both by micrometres.
TUNED = replace(
    HELD,
    edge_rounding=2e-5 / 0.0078,  # leaning planks slip at the limit of statics; with half of it 14 of 60 ladders stick
    half_spaces=True,  # on boxes of 100 m, ladders and Vs askew to them stand up to 1 deg, 10 %, beyond their limit
    sinking=2.6e-4,  # two micrometres; with 0 slips begin up to three times too late; with it three steep Vs stick
    friction_cones=True,  # without, ladders askew to the axes sometimes stand up to 3 deg too flat
    maximal_coordinates=True,  # planks slide equally far in every direction, and spin without gaining energy
    angular_damping=0.0,
    warm_start=0.7,  # a third of the creep with 0.1; from 0.95 on, towers of 25 levels burst
    contact_erp=0.2,  # with 0.8 towers burst as well, with 0.05 they creep four times as much
    contact_slop=1e-4,  # a micrometre: with less, hulls tremble and their loads alternate between contacts
    friction_anchor=True,  # at rest only; a tower of 25 levels creeps 0.01 mm in a second with it, 0.06 mm without
    friction_erp=0.002,  # with ten times as much a plank sticks on a slope that is 3 % too steep
    exact_fall=True,
    lively_speed=0.3,  # [m/s] a falling brick reaches it after 30 ms; creep is far below
    lively_iterations=100,  # two planks that collide end-on share their speed to 0.1 %
    most_mass_ratio=16.0,  # a plank under one of 1000 times its mass gives way by 0.02 mm
)

# `pybullet-exact`: woken bricks move without friction anchors, which would delay the start of a slide.
MOVING = replace(
    TUNED,
    friction_anchor=False,
    # Statics, not the engine, decide whether leaning bricks stand. With the rounding of `tuned` a hit at 8 m/s moves
    # three more planks.
    edge_rounding=1e-4 / 0.0078,
    fresh_edges=True,  # with the sharp edges of `tuned`, a V slips off after landing though 5 % within its limit
    half_spaces=False,
    sinking=0.0,
    sliding_cones=True,  # without, a plank that is hit together with the one below it moves 12 % too little
    lively_parts=2,  # motions after a hit err by 3 % with it, by 9 % without
    most_travel=0.001,  # limits the depth of penetration of a fast brick
    first_steps=20,  # for the right start of a motion (docs/design/falls.md)
    first_parts=8,
    first_travel=0.00025,  # without, planks hit end-on at 4 m/s with an overlap of 0.2 mm move 40 to 70 % too far
    first_iterations=400,  # with 100, hits on two planks at once are 10 to 14 % too weak
    # A contact point under 2.5 planks gives way by 0.05 micrometres. With a third or three times of it the results of
    # hits differ by 3 %; with 0 planks hit at 1 m/s stop 11 % too early, as they carry more than their share of the
    # load.
    first_cfm=3e-9,
)

# The engine of this project moves what `exact` wakes (docs/design/rigid-engine.md).
RIGID = RigidSettings(
    time_step=0.001,
    falling=Solving(parts=8, sweeps=50, accuracy=2e-6),
    struck=Solving(parts=4, sweeps=50, accuracy=2e-5),
    hit=0.02,
    recovery=0.05,
    edge_radius=1e-4,
    most_travel=MOVING.most_travel,
)

# Best MuJoCo settings for stacking at real constants: stiffer springs and finer steps cost more without improvement.
MUJOCO = MuJoCoSettings(
    time_step=0.001,
    iterations=100,
    contact_time=0.004,
    impedance_range=(0.95, 0.99, 0.0005),
    friction_impedance=10.0,
    tolerance=1e-8,
    most_travel=MOVING.most_travel,
)
# Replacement of PyBullet. With the softer springs above, a hit at 8 m/s on the top of a tower removes two more levels
# than with any stiffer ones.
MOVING_ON_MUJOCO = replace(MUJOCO, time_step=0.0005, contact_time=0.002)


def available(*alternatives: System) -> System:
    """Return the first system whose engine is installed; if none is, the first of all."""
    return next((system for system in alternatives if system.engine.package.installed), alternatives[0])


SYSTEMS = {
    system.name: system
    for system in (
        System("exact", "exact statics, and our own rigid-body engine for moving bricks", RIGID, Method.PROVEN),
        available(
            System("thesis", "PyBullet with the published stack-stability method", HELD, Method.PUBLISHED),
            System("thesis", "MuJoCo with the published stack-stability method", MOVING_ON_MUJOCO, Method.PUBLISHED),
        ),
        System("tuned", "PyBullet with settings tuned for stacks", TUNED, method=None),
        System("stock", "PyBullet with its default settings", STOCK, method=None),
        System("modified", "PyBullet with its default settings, weak gravity and rough bricks", STOCK, None, MODIFIED),
    )
}


# Systems on other engines, for comparison. Each needs its package.
#
# Only the command line and benchmarks know them. A scenario cannot name them in `systems`, so its validity does not
# depend on installed packages (docs/design/peers-and-figures.md).


# Five times the cost of `mujoco`, for straight columns of a hundred planks.
MUJOCO_STIFF = MuJoCoSettings(
    time_step=0.0005,
    iterations=200,
    contact_time=0.0012,
    impedance_range=(0.98, 0.999, 0.0001),
    friction_impedance=10.0,
    tolerance=1e-10,
    most_travel=MOVING.most_travel,
)

PEERS = {
    system.name: system
    for system in (
        System("rigid", "our own rigid-body engine", RIGID, method=None),
        System("pybullet-exact", "exact statics, and PyBullet for moving bricks", MOVING, Method.PROVEN),
        System("mujoco", "MuJoCo with settings tuned for stacks", MUJOCO, method=None),
        System("mujoco-stiff", "MuJoCo with stiff contacts", MUJOCO_STIFF, method=None),
        System("mujoco-exact", "exact statics, and MuJoCo for moving bricks", MUJOCO, Method.PROVEN),
        System("mujoco-thesis", "MuJoCo with the published stack-stability method", MUJOCO, Method.PUBLISHED),
    )
}
