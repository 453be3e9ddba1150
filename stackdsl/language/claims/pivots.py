"""The claim `pivots`."""

from collections.abc import Collection
from math import degrees, inf
from typing import ClassVar

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import PERCENT, ClaimResult, all_of, at_most
from stackdsl.language.claims.onset_motion import Pairs, largest_difference, seen_displacements, widest_angle
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.trace import Onset, Trace


@claim("pivots", "initial motion of a fall")
class Pivots(AtLeastOneKey, ClaimKind):
    """The fall begins with the proven motion, over the first 5 degrees."""

    about: t.BodyOrPlaneName | None = Field(
        None, description="standing brick about which the falling bricks rotate, or `ground`"
    )
    within: t.Slope | None = Field(
        None, description="largest angle between the simulated and the proven displacement of a brick"
    )
    proportions: t.ShareOfLimit | None = Field(
        None, description="largest error of a displacement, as a share of the largest proven displacement"
    )

    needs_dense_recording: ClassVar[bool] = True
    requires_physical_collapse: ClassVar[bool] = True

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        return True

    def is_decided(self, trace: Trace) -> bool:
        return trace.onset is not None  # only the first onset is recorded

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the pivot, and the directions and proportions of displacements, with the proof."""
        if trace.onset is None:
            has_motion = trace.statics is not None and trace.statics.motion is not None
            reason = "no brick with a proven fall rotated by 5 deg" if has_motion else "no fall is proven"
            return ClaimResult(reason, -1.0, "", passed=False)
        pairs = seen_displacements(trace.onset)
        if pairs is None:
            return ClaimResult("the proven motion has no rotation", -1.0, "", passed=False)
        return all_of(self._parts(trace.onset, pairs))

    def _parts(self, onset: Onset, pairs: Pairs) -> list[ClaimResult]:
        parts = []
        if self.about is not None:
            pivots = ", ".join(onset.about) or "no body"
            passed = self.about in onset.about
            margin, unit = (inf, "") if passed else (-1.0, "bodies")
            parts.append(ClaimResult(f"about {pivots}", margin, unit, passed=passed))
        if self.within is not None:
            angle = widest_angle(pairs)
            parts.append(at_most(self.within, angle, "deg", f"within {degrees(angle):.3g} deg"))
        if self.proportions is not None:
            off = largest_difference(pairs)
            parts.append(at_most(self.proportions, off, "%", f"proportions within {PERCENT * off:.3g} %"))
        return parts
