"""The claim `lands`."""

from collections.abc import Collection
from math import degrees, pi, remainder
from typing import ClassVar

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, all_of, at_most, within
from stackdsl.language.model_base import AtLeastOneKey, default
from stackdsl.trace import Trace
from stackdsl.wording import mm


@claim("lands", "landing place of the fallen bricks")
class Lands(AtLeastOneKey, ClaimKind):
    """The landing place of the common centre of mass of the fallen bricks, relative to its place before the fall."""

    reach: t.LengthTolerance | None = Field(None, description="horizontal distance from the place before the fall")
    bearing: t.Angle | None = Field(
        None, description="direction from the place before the fall: 0 deg = +x, 90 deg = +y"
    )
    within: t.Slope = default("10 deg", "largest deviation from the bearing")

    defaults: ClassVar[tuple[str, ...]] = ("within",)
    needs_dense_recording: ClassVar[bool] = True
    requires_physical_collapse: ClassVar[bool] = True

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        return True

    def is_decided(self, trace: Trace) -> bool:
        return trace.landing is not None and trace.landing.over and not trace.undone

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare distance and direction of the landing."""
        landing = trace.landing
        if landing is None:
            return ClaimResult("nothing fell", -1.0, "", passed=False)
        parts = []
        if self.reach is not None:
            parts.append(within(self.reach, landing.reach, "mm", f"reach {mm(landing.reach)}"))
        if self.bearing is not None:
            off = abs(remainder(landing.bearing - self.bearing, 2.0 * pi))
            parts.append(at_most(self.within, off, "deg", f"bearing {degrees(landing.bearing):.3g} deg"))
        return all_of(parts)
