"""The claim `rests_on`."""

from math import inf, isnan
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, within
from stackdsl.language.model_base import AuthorModel
from stackdsl.trace import Trace


@claim("rests_on", "one brick rests on another")
class RestsOn(AuthorModel, ClaimKind):
    """One brick rests on another."""

    brick: t.BodyName = Field(description="upper brick")
    support: t.BodyOrPlaneName = Field(description="lower brick, or `ground`")
    share: t.ShareTolerance | None = Field(
        None, description="share of the load of the upper brick that the support carries"
    )

    identifying_keys: ClassVar[tuple[str, ...]] = ("brick", "support")

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the share of the load of a brick that the support carries."""
        if self.brick in trace.unknown_loads:
            measured = f"not measured: the engine reports no contact force on {self.brick}"
            return ClaimResult(measured, -inf, "", passed=False)
        edge = next((edge for edge in trace.edges if (edge.upper, edge.lower) == (self.brick, self.support)), None)
        share = 0.0 if edge is None else edge.share
        if edge is None:
            margin = share if self.share is None else self.share.margin(share)
            return ClaimResult("the brick does not rest on this support", min(margin, 0.0), "of its load", passed=False)
        if isnan(share):
            measured = "the share is undetermined: friction, leaning or a counterweight also holds the brick"
            return ClaimResult(measured, inf if self.share is None else -inf, "", passed=self.share is None)
        if self.share is None:
            return ClaimResult(f"share {share:.3f}", share, "of its load", passed=True)
        return within(self.share, share, "of its load", f"share {share:.3f}")
