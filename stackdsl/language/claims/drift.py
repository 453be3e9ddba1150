"""The claim `drift`."""

from math import inf
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, placed, within
from stackdsl.language.model_base import Shorthand
from stackdsl.trace import BrickTrack, Trace
from stackdsl.wording import mm


@claim("drift", "the largest shift of a brick after it came to rest")
class Drift(Shorthand, ClaimKind):
    """The largest shift of a brick after it came to rest."""

    within: t.LengthTolerance = Field(alias="is", description="the largest shift")
    bricks: t.BodyNames | None = Field(None, description="bricks to measure; default: all")

    scalar_key: ClassVar[str] = "is"
    identifying_keys: ClassVar[tuple[str, ...]] = ("bricks",)

    def is_decided(self, trace: Trace) -> bool:
        worst = self._worst(trace)
        return worst is None or self.within.same_for(worst.shift, inf)  # it only grows

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the largest shift."""
        worst = self._worst(trace)
        if worst is None:
            return ClaimResult("never placed", 0.0, "mm", passed=False)
        return within(self.within, worst.shift, "mm", f"{mm(worst.shift)} ({worst.brick.id})")

    def _worst(self, trace: Trace) -> BrickTrack | None:
        names = frozenset(trace.tracks if self.bricks is None else self.bricks)
        tracks = [track for track in placed(trace) if track.brick.id in names]
        return max(tracks, key=lambda track: track.shift, default=None)
