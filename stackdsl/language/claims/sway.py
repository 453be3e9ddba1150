"""The claim `sway`."""

from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, all_of, within
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.trace import Trace
from stackdsl.wording import mm


@claim("sway", "amplitude and frequency of the sway of a brick after it came to rest")
class Sways(AtLeastOneKey, ClaimKind):
    """The largest sway of a brick before a collapse."""

    amplitude: t.LengthTolerance | None = Field(None, description="amplitude, half of the full swing")
    frequency: t.FrequencyTolerance | None = Field(None, description="frequency of full cycles")

    needed_measures: ClassVar[tuple[str, ...]] = ("sway",)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the largest swing. A motion without return is not a sway."""
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
