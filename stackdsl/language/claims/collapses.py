"""The claim `collapses`."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from math import inf
from typing import ClassVar, Self

from pydantic import Field, model_validator

from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, ImpliedOutcome, claim
from stackdsl.language.claims.claim_result import ClaimResult, margin_to_collapse, placed, within
from stackdsl.language.model_base import Shorthand
from stackdsl.language.quantities import InputError
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Trace
from stackdsl.wording import broke_text, level_text


@claim("collapses", "the structure collapses")
class Collapses(Shorthand, ClaimKind):
    """A brick that came to rest falls later: it moves, sinks or tilts too far."""

    at: t.LevelTolerance | None = Field(None, description="level under construction at the time of the collapse")
    brick: t.BodyName | None = Field(None, description="first brick that falls")
    time: t.DurationTolerance | None = Field(None, description="time of the collapse")

    share: t.ShareOfSamples | None = Field(None, description="share of the samples in which the structure collapses")

    scalar_word: ClassVar[str] = "any"
    opposite: ClassVar[str] = "stands: all"
    requires_physical_collapse: ClassVar[bool] = True
    allows_removed_bricks: ClassVar[bool] = True

    @property
    def wanted_share(self) -> Tolerance | None:
        return self.share

    def holds_for_sample(self, fell_at: int | None) -> bool:
        return fell_at is not None and (self.at is None or self.at.holds(fell_at))

    @model_validator(mode="after")
    def _check_share(self) -> Self:
        parts = [key for key in ("brick", "time") if getattr(self, key) is not None]
        if self.share is not None and parts:
            message = f"`{parts[0]}` is unavailable with `share`, since samples record only the level of a collapse"
            raise InputError("SD108", message, f"use `at` instead of `{parts[0]}`, or remove `share`")
        return self

    @property
    def implied_outcome(self) -> ImpliedOutcome | None:
        if self.share is not None:
            return None
        return ImpliedOutcome(stands=False, level=self.at, time=self.time, seen=True)

    def counts(self) -> Iterator[Count]:
        if self.at is not None:
            yield Count("at", self.at.least_count, "levels")

    def must_fall(self, levels: Mapping[BodyId, int]) -> Iterable[Collection[BodyId]]:
        if self.share is not None:
            return
        yield [name for name in levels if self.brick in (None, name)]  # every brick that can be the first to fall

    def rests_on_fate_of(self, trace: Trace) -> Collection[BodyId]:
        return () if self.brick is None else (self.brick,)

    def is_decided(self, trace: Trace) -> bool:
        return trace.collapse is not None  # the first collapse does not change

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare level, time and first brick of the collapse."""
        if trace.collapse is None:
            margin, unit = min((margin_to_collapse(track) for track in placed(trace)), default=(inf, "mm"))
            return ClaimResult("nothing fell", -margin, unit, passed=False)
        level, time, brick = trace.collapse.level, trace.collapse.time, trace.collapse.brick
        broke = broke_text(trace.collapse.broke, trace.collapse.gave_way)
        where = level_text(level, trace.collapse.step)
        if trace.collapse.fallen:
            where = "after the build" if self.at is None else f"after the build, whose last is {where}"
        measured = f"{where}, {brick} at {time:.3f} s{broke}"
        parts = [ClaimResult(measured, inf, "", passed=True)]
        if self.at is not None:
            parts.append(within(self.at, level, "levels"))
        if self.time is not None:
            parts.append(within(self.time, time, "s"))
        if self.brick is not None:
            parts.append(ClaimResult("", 0.0 if self.brick == brick else -1.0, "bricks", passed=self.brick == brick))
        worst = min(parts, key=lambda part: (part.passed, part.margin))
        numbers = tuple(number for part in parts for number in part.numbers)
        return ClaimResult(parts[0].measured, worst.margin, worst.unit, all(part.passed for part in parts), numbers)
