"""How MuJoCo steps; no engine is needed to say so."""

from dataclasses import dataclass

from stability.engines.settings import EngineSettings
from stability.model import Vec3


@dataclass(frozen=True, slots=True, kw_only=True)
class MuJoCoSettings(EngineSettings):
    """Settings with what MuJoCo has beside them: its contacts are springs, and may overlap a little.

    There is no share of an overlap that a step takes back, and only what overlaps is a contact, so both are 0.
    """

    contact_erp: float = 0.0
    breaking_threshold: float = 0.0
    contact_time: float  # [s] of the spring of a contact (the first of `solref`), which is damped critically
    impedance_range: Vec3  # of a contact: without overlap, with some, and with how much [m] (the first of `solimp`)
    friction_impedance: float  # of friction, in units of that of the normal: the more, the less a contact creeps
    tolerance: float  # of the solver, which stops at it
