"""The systems that a scenario can be played on: which engine settings, and with or without the stability extension."""

from dataclasses import dataclass, replace
from enum import Enum

from stability.engine_settings import EngineSettings


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

    @property
    def extension(self) -> bool:
        """Whether a stability extension freezes what it finds stable."""
        return self.method is not None


STOCK = EngineSettings(
    time_step=1.0 / 240.0,
    iterations=50,
    contact_erp=0.2,
    breaking_threshold=0.02,
    linear_damping=0.04,
    angular_damping=0.04,
    residual_threshold=1e-7,
)

# Chosen by trial on four-stacks, columns, slant towers and overhangs, for right verdicts first, then little creep, at
# about 0.9 s of one core for a second with 50 planks. Real constants: what is tuned is the numerics alone.
TUNED = EngineSettings(
    time_step=1.0 / 960.0,  # half of it kicks a tower by millimetres
    iterations=20,  # at equal cost smaller steps beat more iterations
    contact_erp=0.4,  # 0.8 halves the creep, and with the anchor flings planks out of a collapse
    breaking_threshold=0.001,
    scale=100.0,  # 10 is worse, 1000 explodes
    angular_damping=0.02,  # PyBullet's free spin gains energy without it
    most_travel=0.004,  # half a plank's thickness
    friction_anchor=True,  # without it tall stacks creep until they fall
)
# trial
MAXI = replace(
    TUNED,
    iterations=50,
    contact_erp=0.2,
    angular_damping=0.0,
    friction_anchor=False,
    edge_radius=1e-4,
    maximal_coordinates=True,
    warm_start=0.7,
    exact_fall=True,
    lively_speed=0.3,
    lively_iterations=100,
    most_mass_ratio=16.0,
)

# What stands is held by an extension, so the engine below it needs no anchor, which costs collapses their energy
# balance, and can afford iterations for the few bricks that move.
HELD = replace(TUNED, iterations=50, friction_anchor=False)

# What `exact` lets go must move as it should (docs/decisions/0012); the published method stays as it was published.
MOVING = replace(
    HELD,
    edge_radius=1e-4,  # leaning planks slip where statics say, and stacks creep a fifth as much
    contact_erp=0.2,  # what flies into a brick is pushed out of it half as fast, and stacks creep no more
    angular_damping=0.005,  # 0.02 takes 15 % of a falling tower's energy of rotation in 0.2 s
    first_steps=20,  # so that what is let go starts as it should (docs/decisions/0014)
    first_parts=8,
)

SYSTEMS = {
    system.name: system
    for system in (
        System("exact", "exact statics, and PyBullet for what moves", MOVING, Method.PROVEN),
        System("thesis", "PyBullet with the published stack-stability method", HELD, Method.PUBLISHED),
        System("tuned", "PyBullet with the settings that stack best", TUNED, method=None),
        System("stock", "PyBullet as it comes", STOCK, method=None),
    )
}
