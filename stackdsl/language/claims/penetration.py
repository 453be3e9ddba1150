"""The claim `penetration`."""

from math import inf
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, within
from stackdsl.language.model_base import Shorthand
from stackdsl.trace import Trace
from stackdsl.wording import mm


@claim("penetration", "the deepest overlap of two bodies")
class Penetrates(Shorthand, ClaimKind):
    """The deepest overlap of two bodies: bricks, thrown bricks, ground and walls."""

    depth: t.LengthTolerance = Field(alias="is", description="the depth")

    scalar_key: ClassVar[str] = "is"
    needed_measures: ClassVar[tuple[str, ...]] = ("penetration",)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the deepest overlap."""
        deepest = trace.penetration
        if deepest is None:
            return ClaimResult("nothing was placed", -inf, "mm", passed=False)
        return within(self.depth, deepest.depth, "mm", f"{mm(deepest.depth)} ({deepest.brick} in {deepest.other})")
