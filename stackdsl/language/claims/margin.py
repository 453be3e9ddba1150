"""The claim `margin`."""

from collections.abc import Collection
from math import inf
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import SHOWN_PER_SI, ClaimResult, all_of, within
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Trace


@claim("margin", "safety margins of the proof of stability")
class Margin(AtLeastOneKey, ClaimKind):
    """Disturbances under which the structure is still proven stable."""

    acceleration: t.GravityTolerance | None = Field(
        None, description="permissible horizontal acceleration in the worst direction, as a multiple of gravity"
    )
    tilt: t.SlopeTolerance | None = Field(None, description="permissible tilt of the scene in the worst direction")
    friction: t.FrictionTolerance | None = Field(
        None, description="smallest friction coefficient with which the structure stands"
    )
    placement: t.LengthTolerance | None = Field(None, description="permissible error in the position of every brick")

    needs_statics: ClassVar[bool] = True

    @property
    def needed_margins(self) -> Collection[str]:
        return self.written_keys

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the margins of the proof."""
        return all_of([_part(key, getattr(self, key), getattr(trace.margins, key)) for key in self.written_keys])


def _part(key: str, wanted: Tolerance, value: float | None) -> ClaimResult:
    """Compare one margin with its tolerance."""
    unit = {"acceleration": "g", "tilt": "deg", "friction": "", "placement": "mm"}[key]
    if value is None:
        return ClaimResult(f"no margin of {key} is proven", -inf, unit, passed=False)
    return within(wanted, value, unit, f"{key} {SHOWN_PER_SI.get(unit, 1.0) * value:.4g} {unit}".rstrip())
