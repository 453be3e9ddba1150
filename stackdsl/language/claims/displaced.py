"""The claim `displaced`."""

from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, placed, within
from stackdsl.language.model_base import AuthorModel
from stackdsl.trace import Trace


@claim("displaced", "number of displaced bricks")
class Displaced(AuthorModel, ClaimKind):
    """The number of bricks that have moved."""

    bricks: t.CountTolerance = Field(description="number of displaced bricks")
    by: t.LengthLowerBound = Field(description="smallest displacement that is counted")

    identifying_keys: ClassVar[tuple[str, ...]] = ("by",)

    def is_decided(self, trace: Trace) -> bool:
        return self.bricks.same_for(self._count(trace), len(placed(trace)))  # the largest shift of a brick only grows

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the number of bricks that moved at least so far."""
        count = self._count(trace)
        return within(self.bricks, count, "bricks", f"{count} bricks")

    def _count(self, trace: Trace) -> int:
        return sum(self.by.holds(track.shift) for track in placed(trace))
