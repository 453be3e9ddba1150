"""One brick is carried by another."""

from math import inf, isnan
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, within
from stackdsl.language.model_base import AuthorModel
from stackdsl.trace import Trace


@claim("rests_on", "one brick is carried by another")
class RestsOn(AuthorModel, ClaimKind):
    """One brick is carried by another."""

    brick: t.BodyName = Field(description="the upper brick")
    support: t.BodyOrPlaneName = Field(description="the lower one, or ground")
    share: t.ShareTolerance | None = Field(None, description="part of its load that goes there")

    same: ClassVar[tuple[str, ...]] = ("brick", "support")

    def judge(self, trace: Trace) -> ClaimResult:
        """Whether one brick is carried by another, and how much of its load."""
        edge = next((edge for edge in trace.edges if (edge.upper, edge.lower) == (self.brick, self.support)), None)
        share = 0.0 if edge is None else edge.share
        if edge is None:
            margin = share if self.share is None else self.share.margin(share)
            return ClaimResult("it does not rest there", min(margin, 0.0), "of its load", passed=False)
        if isnan(share):
            known = "it rests there, and its share is not known: friction, leaning or a counterweight holds it"
            return ClaimResult(known, inf if self.share is None else -inf, "", passed=self.share is None)
        if self.share is None:
            return ClaimResult(f"share {share:.3f}", share, "of its load", passed=True)
        return within(self.share, share, "of its load", f"share {share:.3f}")
