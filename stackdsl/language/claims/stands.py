"""The claim `stands`."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import ClassVar, Self

from pydantic import Field, model_validator

from stability.model import BodyId
from stability.name_order import names_text
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, ImpliedOutcome, claim
from stackdsl.language.claims.claim_result import (
    ClaimResult,
    in_time,
    is_over,
    lost_text,
    margin_to_collapse,
    moved_text,
    remaining,
)
from stackdsl.language.model_base import Shorthand
from stackdsl.language.quantities import InputError
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import USED_STRENGTH, BrickState, BrickTrack, EventKind, Trace
from stackdsl.wording import MILLIMETRES, how_many, level_text, mm


@claim("stands", "bricks are where they came to rest")
class Stands(Shorthand, ClaimKind):
    """Bricks are where they came to rest."""

    levels: t.Levels | None = Field(None, description="minimum number of levels that stand, counted from the lowest")
    bricks: t.BodyNames | None = Field(None, description="bricks that stand; default: all")
    for_: t.PositiveDuration | None = Field(
        None, alias="for", description="time after the last action during which they stand"
    )
    share: t.ShareOfSamples | None = Field(None, description="share of the samples in which all bricks stand")

    scalar_word: ClassVar[str] = "all"
    opposite: ClassVar[str] = "collapses: any"
    only_falls: ClassVar[bool] = True
    reported_margins: ClassVar[tuple[str, ...]] = ("friction", "placement", USED_STRENGTH)

    @property
    def needed_hold(self) -> float | None:
        return self.for_

    @property
    def implied_outcome(self) -> ImpliedOutcome | None:
        return ImpliedOutcome(stands=True) if self.bricks is None and self.share is None else None

    @property
    def wanted_share(self) -> Tolerance | None:
        return self.share

    def holds_for_sample(self, fell_at: int | None) -> bool:
        return fell_at is None

    @model_validator(mode="after")
    def _check_share(self) -> Self:
        partial = {"levels": self.levels, "bricks": self.bricks, "for": self.for_}
        parts = [key for key, value in partial.items() if value is not None]
        if self.share is not None and parts:
            message = f"`share` counts samples in which all bricks stand, and cannot be combined with `{parts[0]}`"
            raise InputError("SD108", message, "remove one of them")
        return self

    @property
    def final_once_watched(self) -> bool:
        return self.for_ is not None

    def counts(self) -> Iterator[Count]:
        if self.levels is not None:
            yield Count("levels", self.levels, "levels")

    def must_stand(self, levels: Mapping[BodyId, int], hold: float) -> Collection[BodyId] | None:
        if self.share is not None or (self.for_ is not None and self.for_ < hold):
            return None  # bricks may fall after the time of the claim
        named = levels.keys() if self.bricks is None else levels.keys() & self.bricks
        return {name for name in named if self.levels is None or levels[name] <= self.levels}

    def is_decided(self, trace: Trace) -> bool:
        lost = (BrickState.FALLEN, BrickState.UNPLACED)
        return any(track.state in lost for track in self._in_time(self._tracks(trace), trace)) or self._is_over(trace)

    def _is_over(self, trace: Trace) -> bool:
        """Return whether the time of the claim is over."""
        return self.for_ is not None and is_over(self.for_, trace)

    def judge(self, trace: Trace) -> ClaimResult:
        """Return whether bricks are where they came to rest, or where a hit shifted them."""
        tracks = self._tracks(trace)
        result = self._missing(tracks, trace) or _stand(self._in_time(tracks, trace), dict(remaining(trace)))
        proven = result.passed and all(track.frozen for track in tracks)
        shaken = any(event.kind is EventKind.SHAKEN for event in trace.events)  # margins of proofs are those at rest
        return _with_margin_of_proof(result, trace) if proven and not shaken else result

    def _tracks(self, trace: Trace) -> Sequence[BrickTrack]:
        """Return the bricks that the claim is about."""
        names = frozenset(trace.tracks if self.bricks is None else self.bricks)
        return [track for name, track in remaining(trace) if name in names and self._includes(track.level)]

    def _includes(self, level: int) -> bool:
        return self.levels is None or level <= self.levels

    def _missing(self, tracks: Sequence[BrickTrack], trace: Trace) -> ClaimResult | None:
        """Return the failure if levels are missing, or bricks are not placed, not at rest, or all removed."""
        levels = max((track.level for track in trace.tracks.values()), default=0)
        if self.levels is not None and levels < self.levels:
            return ClaimResult(f"only {levels} levels are built", levels - self.levels, "levels", passed=False)
        missing = sum(track.state is BrickState.UNPLACED for track in tracks)
        if missing:
            cause = (
                f"the structure collapsed at {level_text(fell.level, fell.step)}; "
                if (fell := trace.collapse) is not None
                else ""
            )
            measured = f"{cause}{lost_text(tracks)}"
            return ClaimResult(measured, -missing, "bricks", passed=False)
        unsettled = [track.brick.id for track in tracks if track.state is BrickState.UNSETTLED]
        if unsettled:
            crushing = trace.crushing
            measured = f"{unsettled[0]} has not come to rest" if crushing is None else crushing.text
            return ClaimResult(measured, -len(unsettled), "bricks", passed=False)
        return None if tracks else ClaimResult("all bricks were pulled out or thrown", -1, "bricks", passed=False)

    def _in_time(self, tracks: Sequence[BrickTrack], trace: Trace) -> Sequence[BrickTrack]:
        """Return the tracks without bricks that fall after the time of the claim."""
        if self.for_ is None:
            return tracks
        return [track for track in tracks if track.left_at is None or in_time(self.for_, track, trace)]


def _stand(tracks: Sequence[BrickTrack], assembly: Iterable[BodyId]) -> ClaimResult:
    fallen = [track.brick.id for track in tracks if track.state is BrickState.FALLEN]
    shifted = sum(track.state is BrickState.DISPLACED for track in tracks)
    which = f": {names_text(fallen, among=assembly)}" if len(fallen) < len(tracks) else ""
    measured = f"{len(fallen)} of {len(tracks)} bricks fell{which}" if fallen else _stand_text(len(tracks))
    measured += f", {shifted} of them displaced" if shifted and not fallen else ""
    margin, unit = min((margin_to_collapse(track) for track in tracks), default=(inf, ""))
    return ClaimResult(measured, margin, unit, passed=not fallen, moved=moved_text(tracks))


def _stand_text(count: int) -> str:
    return f"{how_many(count, 'brick')} {'stands' if count == 1 else 'stand'}"


def _with_margin_of_proof(result: ClaimResult, trace: Trace) -> ClaimResult:
    """Return the result with a margin of the proof, in place of the shift that is left until a collapse."""
    margins = trace.margins
    if margins.used_strength is not None:
        measured = f"{result.measured}, with {100.0 * margins.used_strength:.4g} % of their strength"
        return replace(
            result, measured=measured, margin=round(1.0 - margins.used_strength, 9), unit="of strength", moved=""
        )
    if margins.load_factor is not None and margins.load_factor < inf:
        what = "loads" if margins.loaded else "weight"
        measured = f"{result.measured}, also under {margins.load_factor:.4g} times their {what}"
        return replace(result, measured=measured, margin=margins.load_factor - 1.0, unit=f"of {what}", moved="")
    if margins.placement is not None and 0.0 < margins.placement < inf:
        measured = f"{result.measured}, also with placement errors of {mm(margins.placement)}"
        return replace(result, measured=measured, margin=MILLIMETRES * margins.placement, unit="mm", moved="")
    if margins.friction is not None and margins.roughest is not None:
        measured = f"{result.measured}, also with friction reduced to {margins.friction:.4g}"
        lost = margins.roughest - margins.friction
        return replace(result, measured=measured, margin=lost, unit="of friction", moved="")
    return result
