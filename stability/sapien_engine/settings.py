"""How SAPIEN steps; no engine is needed to say so."""

from dataclasses import dataclass

from stability.engine_settings import EngineSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class SapienSettings(EngineSettings):
    """Settings with what PhysX has beside them.

    `iterations` are those of positions, `breaking_threshold` is the contact offset of a shape, and there is no share of
    an overlap that a step takes back.
    """

    contact_erp: float = 0.0
    velocity_iterations: int  # of the solver, per step
