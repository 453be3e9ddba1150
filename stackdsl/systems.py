"""The systems that a scenario can be played on: which engine settings, and with or without the stability extension."""

from dataclasses import dataclass

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

TUNED = EngineSettings(
    time_step=1.0 / 960.0,
    iterations=50,
    contact_erp=0.8,
    breaking_threshold=0.001,
    scale=100.0,
)

SYSTEMS = {
    system.name: system
    for system in (
        System("thesis", "PyBullet with the published stack-stability method", TUNED, extension=True),
        System("tuned", "PyBullet with the settings that stack best", TUNED, extension=False),
        System("stock", "PyBullet as it comes", STOCK, extension=False),
    )
}
