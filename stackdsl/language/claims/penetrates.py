"""How deep two bodies get into each other."""

from math import inf
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, within
from stackdsl.language.model_base import Shorthand
from stackdsl.trace import Trace
from stackdsl.wording import mm


@claim("penetration", "how deep two bodies get into each other, at most")
class Penetrates(Shorthand, ClaimKind):
    """How deep two bodies get into each other, of bricks, ground and walls, what is thrown included."""

    depth: t.LengthTolerance = Field(alias="is", description="the depth")

    scalar_key: ClassVar[str] = "is"
    needed_measures: ClassVar[tuple[str, ...]] = ("penetration",)

    def judge(self, trace: Trace) -> ClaimResult:
        """The deepest that two were in each other."""
        found = trace.penetration
        if found is None:
            return ClaimResult("nothing was placed", -inf, "mm", passed=False)
        return within(self.depth, found.depth, "mm", f"{mm(found.depth)} ({found.brick} in {found.other})")
