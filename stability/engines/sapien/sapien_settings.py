"""How SAPIEN steps; no engine is needed to say so."""

from dataclasses import dataclass

from stability.engines.settings import EngineSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class SapienSettings(EngineSettings):
    """Settings with what PhysX has beside them.

    `iterations` are those of positions; no share of an overlap is what a step takes back, and no share of the size of a
    brick decides which contacts are dropped.
    """

    contact_erp: float = 0.0
    breaking_threshold: float = 0.0
    contact_offset: float  # [m] shapes closer to each other than twice this have contacts
    velocity_iterations: int  # of the solver, per step
