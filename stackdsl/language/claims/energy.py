"""The claim `energy`."""

from math import inf
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import PERCENT, ClaimResult, within
from stackdsl.language.model_base import AuthorModel
from stackdsl.trace import Trace


@claim("energy", "the change of the total energy of all bricks")
class EnergyChange(AuthorModel, ClaimKind):
    """Kinetic and potential energy of all bricks together, from the last action on."""

    gain: t.ShareTolerance = Field(
        description="energy gain, relative to the energy of the moving bricks; potential energy is zero at the ground"
    )

    measures_engine: ClassVar[bool] = True

    @property
    def final_once_watched(self) -> bool:
        return True

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the gain after the last action, as a share of the energy of the moving bricks just after it."""
        if trace.energy is None:
            return ClaimResult("nothing was placed", -inf, "%", passed=False)
        return within(self.gain, trace.energy.gain, "%", f"gain {PERCENT * trace.energy.gain:.3g} %")
