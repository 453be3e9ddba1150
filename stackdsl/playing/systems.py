"""The systems that a scenario can be played on: which engine settings, and with or without the stability extension."""

from dataclasses import dataclass, replace

from stability.engine_settings import EngineSettings


@dataclass(frozen=True, slots=True)
class System:
    """One way to play a timeline."""

    name: str
    summary: str
    engine: EngineSettings
    extension: bool  # whether the stability extension freezes what it finds stable


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

# What stands is held by the extension, so the engine below it needs no anchor, which costs collapses their energy
# balance, and can afford iterations for the few bricks that move.
THESIS = replace(TUNED, iterations=50, friction_anchor=False)

SYSTEMS = {
    system.name: system
    for system in (
        System("thesis", "PyBullet with the published stack-stability method", THESIS, extension=True),
        System("tuned", "PyBullet with the settings that stack best", TUNED, extension=False),
        System("stock", "PyBullet as it comes", STOCK, extension=False),
    )
}
