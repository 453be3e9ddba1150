"""The claim `verdict`."""

from collections.abc import Collection
from dataclasses import dataclass
from math import inf
from typing import ClassVar, Final, Literal, Self, TypeAlias

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from stackdsl.language.claims.claim_kind import ClaimKind, ImpliedOutcome, claim
from stackdsl.language.claims.claim_result import ClaimResult
from stackdsl.trace import Trace
from stackdsl.wording import touching_text

CERTAINTY: Final = ("guaranteed", "possible")  # of a stable structure: standing is certain, or only possible
WITHOUT_GAPS: Final = "stable, counting on no gap"
Word: TypeAlias = Literal["stable", "stable, counting on no gap", "guaranteed", "possible", "unstable", "undecided"]


@claim("verdict", "the verdict of statics after the last change of the structure")
@dataclass(frozen=True)
class Verdict(ClaimKind):
    """The verdict of statics after the last change of the structure, written as one word."""

    word: Word

    needs_statics: ClassVar[bool] = True

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        word = handler.generate_schema(Word)
        return core_schema.no_info_after_validator_function(cls, word)

    @property
    def implied_outcome(self) -> ImpliedOutcome | None:
        return None if self.word == "undecided" else ImpliedOutcome(stands=self.word != "unstable")

    @property
    def needed_margins(self) -> Collection[str]:
        return ("guaranteed",) if self.word in CERTAINTY else ()

    def contradicts(self, other: Self) -> bool:
        return self._stability != other._stability or {self.word, other.word} == set(CERTAINTY)

    @property
    def _stability(self) -> str:
        return "stable" if self.word in (*CERTAINTY, WITHOUT_GAPS) else self.word

    def is_decided(self, trace: Trace) -> bool:
        return not trace.pending_removals  # pulling out a brick needs a new verdict

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the verdict of statics."""
        if trace.statics is None:
            return ClaimResult("no brick was set down at rest", inf, "", passed=False)
        reason = f": {trace.statics.reason}" if trace.statics.reason else ""
        verdict, sure, within = str(trace.statics.stability), trace.margins.guaranteed, trace.statics.touching_within
        if self.word in CERTAINTY and verdict == "stable":
            verdict = "stable, but no brick stands at the end" if sure is None else CERTAINTY[0 if sure else 1]
            reason = f": {trace.margins.certainty}" if trace.margins.certainty else ""
        passed = verdict == self.word or (self.word == WITHOUT_GAPS and verdict == "stable" and within == 0.0)
        return ClaimResult(f"{verdict}{touching_text(within)}{reason}", inf, "", passed=passed)
