"""The systems that can play a scenario: ours, those on reference engines, and modified scenes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from math import sqrt
from typing import TYPE_CHECKING, Self

from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.protocol import EngineSettings
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.sapien.settings import SapienSettings
from stackdsl.timeline import Action, Arrival, FixedWorld, Placement, Timeline

if TYPE_CHECKING:
    from stability.stabilizers.published.support import Readings


# What of a scene is changed before it is played, for an engine that cannot do with what is real.
#
# The publication's second system is of this kind: constants such as gravity and friction are changed until the engine
# stacks. What comes of it is told in lengths of the scenario as it is written, and in seconds as they pass in the
# changed scene; gravity is told in the same lengths, and so is weaker by as much as the bricks are larger.


@dataclass(frozen=True, slots=True)
class Modification:
    """Constants of a scene that are others than its author wrote; nothing is by default."""

    gravity: float | None = None  # [m/s2]
    friction: float | None = None  # Coulomb coefficient of every contact, with ground and walls as well
    size: float = 1.0  # times as large is all that has a length, at the same density

    @property
    def summary(self) -> str:
        """What is changed, in words; empty if nothing is."""
        return ", ".join(self._changes())

    def _changes(self) -> Iterator[str]:
        if self.gravity is not None:
            yield f"gravity {self.gravity:g} m/s2"
        if self.friction is not None:
            yield f"friction {self.friction:g} everywhere"
        if self.size != 1.0:
            yield f"all {self.size:g} times as large"


AS_WRITTEN = Modification()


def as_played(timeline: Timeline, modification: Modification) -> Timeline:
    """A timeline with the constants with which it is played, in the lengths in which it is written.

    Bricks that are larger in the same gravity move as those of the scenario do in a weaker one, so that is what this
    tells; that the engine does meet larger ones is up to who opens the world.
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
    """The same; what is dropped falls for so many times as long, and what is thrown flies as long as it did."""
    if isinstance(action, Placement) and action.arrival is Arrival.DROPPED:
        return replace(action, flight=longer * action.flight)
    return action


# The systems that a scenario can be played on: which engine settings, and with or without the stability extension.
#
# Where PyBullet is not installed, MuJoCo stands in for it in what the extension holds (docs/design/architecture.md).


class Method(Enum):
    """How a stability extension finds out what stands."""

    PROVEN = "proven"  # exact statics, with a proof of every verdict
    PUBLISHED = "published"  # the stack-stability method


@dataclass(frozen=True, slots=True)
class System:
    """One way to play a timeline."""

    name: str
    summary: str
    engine: EngineSettings
    method: Method | None  # None: no extension, the engine holds everything
    modification: Modification = AS_WRITTEN  # of every scene, before it is played
    readings: "Readings | None" = None  # of what the published method leaves open; None: ours

    @property
    def extension(self) -> bool:
        """Whether a stability extension freezes what it finds stable."""
        return self.method is not None

    def refined(self) -> Self:
        """The same with settings that err less. What that changes of a result was no physics."""
        return replace(self, engine=self.engine.refined())

    def at_step(self, factor: float) -> Self:
        """The same with so many times its time step."""
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

# `thesis`: what stands is held by the extension, as published, and what it lets go is stepped by boxes of true size.
HELD = PyBulletSettings(
    time_step=1.0 / 960.0,  # half of it kicks a tower by millimetres
    iterations=50,
    contact_erp=0.4,
    breaking_threshold=0.1,
    scale=100.0,  # 10 is worse, 1000 explodes
    angular_damping=0.02,  # PyBullet's free spin gains energy without it
    most_travel=0.004,  # half a plank's thickness
)

# Chosen by trial against closed forms (docs/design/engines.md), for right verdicts first, then little creep, at less than
# a second of one core for a second with 50 planks. Gravity, friction, sizes and masses are real; edges are rounded, and
# contacts of what leans are soft, by micrometres.
TUNED = replace(
    HELD,
    edge_rounding=2e-5 / 0.0078,  # leaning planks slip where statics say; half of it leaves 14 of 60 ladders stuck
    half_spaces=True,  # beside boxes of 100 m ladders and Vs askew to them stand up to 1 deg, 10 %, beyond their limit
    sinking=2.6e-4,  # two micrometres; without, slips begin up to three times late, and with three steep Vs stick
    friction_cones=True,  # without, ladders askew to the axes stand up to 3 deg too flat now and then
    maximal_coordinates=True,  # planks slide as far in every direction, and spin without gaining energy
    angular_damping=0.0,
    warm_start=0.7,  # a third of the creep of 0.1; from 0.95 on, towers of 25 levels burst
    contact_erp=0.2,  # 0.8 bursts as well, 0.05 lets a tower creep four times as much
    contact_slop=1e-4,  # a micrometre: with less, hulls tremble and pass their loads to and fro
    friction_anchor=True,  # at rest only; a tower of 25 levels creeps 0.01 mm in a second with it, 0.06 mm without
    friction_erp=0.002,  # ten times as much makes a plank stay where a slope is 3 % too steep for it
    exact_fall=True,
    lively_speed=0.3,  # [m/s] a brick that is let go has it after 20 ms, and creep is far below
    lively_iterations=100,  # two planks that meet end-on share their speed to 0.1 %
    most_mass_ratio=16.0,  # a plank under one of 1000 times its mass gives way by 0.02 mm
)

# `exact`: what it wakes moves as it should, without anchors, which hold back what begins to slide.
MOVING = replace(
    TUNED,
    friction_anchor=False,
    # Statics say what leans stands, and with the rounding of `tuned` a hit at 8 m/s moves three planks more.
    edge_rounding=1e-4 / 0.0078,
    fresh_edges=True,  # on edges as sharp as those of `tuned` a V that has landed then slips off with 5 % to spare
    half_spaces=False,
    sinking=0.0,
    sliding_cones=True,  # a plank that is hit with the one below it moves 12 % too little without
    lively_parts=2,  # what a hit moves errs by 3 % then, and by 9 % without
    most_travel=0.001,  # so deep at most it enters what it hits
    first_steps=20,  # so that what is let go starts as it should (docs/design/falls.md)
    first_parts=8,
    first_travel=0.00025,  # onto ends by an overlap of 0.2 mm, at 4 m/s, planks move 40 to 70 % too far without
    first_iterations=400,  # those of 100 leave hits onto two planks at once 10 to 14 % too weak
    # A contact point under 2.5 planks gives way by 0.05 micrometres. With a third of it or three times as much hits
    # differ by 3 %; with none planks hit at 1 m/s stop 11 % too early, under more than their share of the load.
    first_cfm=3e-9,
)

# What stacked best of MuJoCo at real constants: stiffer springs and finer steps cost more and help no longer.
MUJOCO = MuJoCoSettings(
    time_step=0.001,
    iterations=100,
    contact_time=0.004,
    impedance_range=(0.95, 0.99, 0.0005),
    friction_impedance=10.0,
    tolerance=1e-8,
    most_travel=MOVING.most_travel,
)
# In place of PyBullet. With springs as soft as above a hit at 8 m/s on the top of a tower takes off two levels more
# than with any that are stiffer.
MOVING_ON_MUJOCO = replace(MUJOCO, time_step=0.0005, contact_time=0.002)


def available(*alternatives: System) -> System:
    """The first whose engine is installed; if none is, the first of all, which says what it needs."""
    return next((system for system in alternatives if system.engine.package.installed), alternatives[0])


SYSTEMS = {
    system.name: system
    for system in (
        available(
            System("exact", "exact statics, and PyBullet for what moves", MOVING, Method.PROVEN),
            System("exact", "exact statics, and MuJoCo for what moves", MOVING_ON_MUJOCO, Method.PROVEN),
        ),
        available(
            System("thesis", "PyBullet with the published stack-stability method", HELD, Method.PUBLISHED),
            System("thesis", "MuJoCo with the published stack-stability method", MOVING_ON_MUJOCO, Method.PUBLISHED),
        ),
        System("tuned", "PyBullet with the settings that stack best", TUNED, method=None),
        System("stock", "PyBullet as it comes", STOCK, method=None),
        System("modified", "PyBullet as it comes, in weak gravity and with rough bricks", STOCK, None, MODIFIED),
    )
}


# Systems on other engines, to compare with: each can be played where its package is installed.
#
# Only the command line and benchmarks know them. A scenario cannot name them in `systems`, so that it is right or wrong
# alike for those who have the package and those who have not (docs/design/peers-and-figures.md).


# Five times the cost, for straight columns of a hundred planks.
MUJOCO_STIFF = MuJoCoSettings(
    time_step=0.0005,
    iterations=200,
    contact_time=0.0012,
    impedance_range=(0.98, 0.999, 0.0001),
    friction_impedance=10.0,
    tolerance=1e-10,
    most_travel=MOVING.most_travel,
)

SAPIEN = SapienSettings(
    time_step=1.0 / 960.0,
    iterations=20,
    velocity_iterations=1,
    contact_offset=0.001,
    most_travel=MOVING.most_travel,
)

PEERS = {
    system.name: system
    for system in (
        System("mujoco", "MuJoCo with the settings that stack best", MUJOCO, method=None),
        System("mujoco-stiff", "MuJoCo with stiff contacts", MUJOCO_STIFF, method=None),
        System("mujoco-exact", "exact statics, and MuJoCo for what moves", MUJOCO, Method.PROVEN),
        System("mujoco-thesis", "MuJoCo with the published stack-stability method", MUJOCO, Method.PUBLISHED),
        System("sapien", "PhysX 5 with the settings that stack best", SAPIEN, method=None),
        System("sapien-thesis", "PhysX 5 with the published stack-stability method", SAPIEN, Method.PUBLISHED),
    )
}
