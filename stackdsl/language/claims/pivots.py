"""What falls begins to as the proof says that it does, over the first 5 degrees."""

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


@claim("pivots", "how what falls begins to")
class Pivots(AtLeastOneKey, ClaimKind):
    """What falls begins to as the proof says that it does, over the first 5 degrees."""

    about: t.BodyOrPlaneName | None = Field(None, description="what stands still and is turned about; or ground")
    within: t.Slope | None = Field(None, description="between where bricks go and where the proof says, at most")
    proportions: t.ShareOfLimit | None = Field(
        None, description="between how far bricks go and the proof says, both as shares of the furthest, at most"
    )

    needs_close_looks: ClassVar[bool] = True
    requires_physical_collapse: ClassVar[bool] = True

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        return True

    def is_decided(self, trace: Trace) -> bool:
        return trace.onset is not None  # the first is kept

    def judge(self, trace: Trace) -> ClaimResult:
        """Whether what falls begins to as the proof says: about what, in which directions, in which proportions."""
        if trace.onset is None:
            named = trace.statics is not None and trace.statics.motion is not None
            why = "nothing that was proven to fall turned by 5 deg" if named else "no proof names a motion"
            return ClaimResult(why, -1.0, "", passed=False)
        pairs = seen_displacements(trace.onset)
        if pairs is None:
            return ClaimResult("the motion that the proof names does not turn", -1.0, "", passed=False)
        return all_of(self._parts(trace.onset, pairs))

    def _parts(self, onset: Onset, pairs: Pairs) -> list[ClaimResult]:
        parts = []
        if self.about is not None:
            found = ", ".join(onset.about) or "nothing"
            held = self.about in onset.about
            parts.append(ClaimResult(f"about {found}", inf if held else -1.0, "" if held else "bodies", passed=held))
        if self.within is not None:
            angle = widest_angle(pairs)
            parts.append(at_most(self.within, angle, "deg", f"within {degrees(angle):.3g} deg"))
        if self.proportions is not None:
            off = largest_difference(pairs)
            parts.append(at_most(self.proportions, off, "%", f"proportions within {PERCENT * off:.3g} %"))
        return parts
