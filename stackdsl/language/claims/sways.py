"""How far, and how fast, bricks go to and fro before anything collapses."""

from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, all_of, within
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.trace import Trace
from stackdsl.wording import mm


@claim("sway", "how far, and how fast, a brick goes to and fro after it came to rest")
class Sways(AtLeastOneKey, ClaimKind):
    """How far, and how fast, bricks go to and fro before anything collapses; the largest swing of all tells."""

    amplitude: t.LengthTolerance | None = Field(None, description="how far to either side")
    frequency: t.FrequencyTolerance | None = Field(None, description="how many times a second, there and back")

    needed_measures: ClassVar[tuple[str, ...]] = ("sway",)

    def judge(self, trace: Trace) -> ClaimResult:
        """The largest swing; what does not come back does not sway."""
        sway = trace.sway
        parts = []
        if self.amplitude is not None:
            measured = f"{mm(sway.amplitude)} ({sway.brick})" if sway is not None else "no sway"
            parts.append(within(self.amplitude, sway.amplitude if sway is not None else 0.0, "mm", measured))
        if self.frequency is not None and sway is None:
            parts.append(ClaimResult("no sway", -1.0, "", passed=False))
        elif self.frequency is not None and sway is not None:
            parts.append(within(self.frequency, sway.frequency, "Hz", f"{sway.frequency:.3g} Hz"))
        return all_of(parts)
