"""Bricks are where they came to rest."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import ClassVar, Self

from pydantic import Field, model_validator

from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, ImpliedOutcome, claim
from stackdsl.language.claims.claim_result import ClaimResult, in_time, is_over, margin_to_collapse, remaining
from stackdsl.language.model_base import Shorthand
from stackdsl.language.quantities import MistakeError
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import BrickState, BrickTrack, Trace
from stackdsl.wording import MILLIMETRES, level_text, mm, names_text


@claim("stands", "bricks are where they came to rest")
class Stands(Shorthand, ClaimKind):
    """Bricks are where they came to rest."""

    levels: t.Levels | None = Field(None, description="at least so many levels, from the lowest")
    bricks: t.BodyNames | None = Field(None, description="these bricks")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="this long after the last action")
    share: t.ShareOfSamples | None = Field(None, description="in this share of the samples, all of it")

    scalar_word: ClassVar[str] = "all"
    told_margins: ClassVar[tuple[str, ...]] = ("friction", "placement")

    @property
    def needed_hold(self) -> float | None:
        return self.for_

    @property
    def fate(self) -> ImpliedOutcome | None:
        return ImpliedOutcome(stands=True) if self.bricks is None and self.share is None else None

    @property
    def wanted_share(self) -> Tolerance | None:
        return self.share

    def holds_of(self, fell_at: int | None) -> bool:
        return fell_at is None

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        of_a_part = {"levels": self.levels, "bricks": self.bricks, "for": self.for_}
        parts = [key for key, value in of_a_part.items() if value is not None]
        if self.share is not None and parts:
            message = f"a share is of samples that stand as a whole, and `{parts[0]}` is of a part"
            raise MistakeError("SD108", message, "leave one of them out")
        return self

    @property
    def final_once_watched(self) -> bool:
        return self.for_ is not None

    def counts(self) -> Iterator[Count]:
        if self.levels is not None:
            yield Count("levels", self.levels, "levels")

    def must_stand(self, levels: Mapping[BodyId, int], hold: float) -> Collection[BodyId] | None:
        if self.share is not None or (self.for_ is not None and self.for_ < hold):
            return None  # what stands for a while may fall after it
        named = levels.keys() if self.bricks is None else levels.keys() & self.bricks
        return {name for name in named if self.levels is None or levels[name] <= self.levels}

    def is_decided(self, trace: Trace) -> bool:
        lost = (BrickState.FALLEN, BrickState.UNPLACED)
        return any(track.state in lost for track in self._in_time(self._meant(trace), trace)) or self._is_over(trace)

    def _is_over(self, trace: Trace) -> bool:
        """Whether the time is over that it speaks of."""
        return self.for_ is not None and is_over(self.for_, trace)

    def judge(self, trace: Trace) -> ClaimResult:
        """Whether bricks are where they came to rest, or were shifted to by a hit."""
        meant = self._meant(trace)
        found = self._missing(meant, trace) or _stand(self._in_time(meant, trace))
        proven = found.passed and all(track.frozen for track in meant)
        return _with_margin_of_proof(found, trace) if proven else found

    def _meant(self, trace: Trace) -> Sequence[BrickTrack]:
        named = frozenset(trace.tracks if self.bricks is None else self.bricks)
        return [track for name, track in remaining(trace) if name in named and self._reaches(track.level)]

    def _reaches(self, level: int) -> bool:
        return self.levels is None or level <= self.levels

    def _missing(self, meant: Sequence[BrickTrack], trace: Trace) -> ClaimResult | None:
        """What says already that they do not stand: too few, never placed, still on the move, or none at all."""
        levels = max((track.level for track in trace.tracks.values()), default=0)
        if self.levels is not None and levels < self.levels:
            return ClaimResult(f"only {levels} levels are built", levels - self.levels, "levels", passed=False)
        missing = sum(track.state is BrickState.UNPLACED for track in meant)
        if missing:
            why = f"it fell at {level_text(fell.level, fell.step)}; " if (fell := trace.collapse) is not None else ""
            return ClaimResult(f"{why}{missing} of {len(meant)} never placed", -missing, "bricks", passed=False)
        unsettled = [track.brick.id for track in meant if track.state is BrickState.UNSETTLED]
        if unsettled:
            return ClaimResult(f"{unsettled[0]} has not come to rest", -len(unsettled), "bricks", passed=False)
        return None if meant else ClaimResult("all of it was pulled out or thrown", -1, "bricks", passed=False)

    def _in_time(self, meant: Sequence[BrickTrack], trace: Trace) -> Sequence[BrickTrack]:
        """Without those that fall later than this claim speaks of."""
        if self.for_ is None:
            return meant
        return [track for track in meant if track.left_at is None or in_time(self.for_, track, trace)]


def _stand(meant: Sequence[BrickTrack]) -> ClaimResult:
    fallen = [track.brick.id for track in meant if track.state is BrickState.FALLEN]
    shifted = sum(track.state is BrickState.DISPLACED for track in meant)
    which = f": {names_text(fallen)}" if len(fallen) < len(meant) else ""
    measured = f"{len(fallen)} of {len(meant)} bricks fell{which}" if fallen else f"{len(meant)} bricks stand"
    measured += f", {shifted} of them displaced" if shifted and not fallen else ""
    margin, unit = min((margin_to_collapse(track) for track in meant), default=(inf, ""))
    return ClaimResult(measured, margin, unit, passed=not fallen)


def _with_margin_of_proof(found: ClaimResult, trace: Trace) -> ClaimResult:
    """The same with what the proof survives, in place of how far bricks may shift before that counts as fallen."""
    margins = trace.margins
    if margins.placement is not None and 0.0 < margins.placement < inf:
        measured = f"{found.measured}, and would with every brick {mm(margins.placement)} beside its place"
        return replace(found, measured=measured, margin=MILLIMETRES * margins.placement, unit="mm")
    if margins.friction is not None and margins.roughest is not None:
        measured = f"{found.measured}, and would with friction down to {margins.friction:.4g}"
        return replace(found, measured=measured, margin=margins.roughest - margins.friction, unit="of friction")
    return found
