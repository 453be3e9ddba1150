"""What statics says of the structure after its last change."""

from dataclasses import dataclass
from math import inf
from typing import ClassVar, Literal, Self

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from stackdsl.language.claims.claim_kind import ClaimKind, Fate, claim
from stackdsl.language.claims.finding import Finding
from stackdsl.trace import Trace


@claim("verdict", "what statics says of the structure after its last change")
@dataclass(frozen=True)
class Verdict(ClaimKind):
    """What statics says of the structure after its last change; written as one word."""

    word: Literal["stable", "unstable", "undecided"]

    needs_statics: ClassVar[bool] = True
    needs_aftermath: ClassVar[bool] = False
    scored_apart: ClassVar[bool] = True

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        word = handler.generate_schema(Literal["stable", "unstable", "undecided"])
        return core_schema.no_info_after_validator_function(cls, word)

    @property
    def fate(self) -> Fate | None:
        return None if self.word == "undecided" else Fate(stands=self.word == "stable")

    def is_apart_from(self, other: Self) -> bool:
        return self.word != other.word

    def is_decided(self, trace: Trace) -> bool:
        return not trace.gone  # it is asked anew when something is pulled out

    def judge(self, trace: Trace) -> Finding:
        """What statics says."""
        if trace.statics is None:
            return Finding("nothing was set down at rest", inf, "", passed=False)
        reason = f": {trace.statics.reason}" if trace.statics.reason else ""
        return Finding(f"{trace.statics.stability}{reason}", inf, "", passed=trace.statics.stability == self.word)
