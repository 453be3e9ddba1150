"""The claim `falls`."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import ClassVar

from pydantic import Field

from stability.model import BodyId
from stability.name_order import names_text
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, claim
from stackdsl.language.claims.claim_result import ClaimResult, in_time, is_over, placed, remaining, within
from stackdsl.language.model_base import ExactlyOneKey
from stackdsl.trace import BrickState, Trace
from stackdsl.wording import how_many


@claim("falls", "names or number of the bricks that fall")
class Falls(ExactlyOneKey, ClaimKind):
    """The bricks of the structure that fall."""

    bricks: t.BodyNames | None = Field(None, description="names of all bricks that fall")
    count: t.CountTolerance | None = Field(None, description="number of bricks that fall")

    for_: t.PositiveDuration | None = Field(
        None,
        alias="for",
        description="time after the last action within which they fall; default: until the end of the run",
    )

    one_of: ClassVar[tuple[str, ...]] = ("bricks", "count")
    requires_physical_collapse: ClassVar[bool] = True
    only_falls: ClassVar[bool] = True
    identifying_keys: ClassVar[tuple[str, ...]] = ("for_",)

    @property
    def needed_hold(self) -> float | None:
        return self.for_

    @property
    def final_once_watched(self) -> bool:
        return self.for_ is not None

    def counts(self) -> Iterator[Count]:
        if self.count is not None:
            yield Count("count", self.count.least_count, "bricks")

    def must_fall(self, levels: Mapping[BodyId, int]) -> Iterable[Collection[BodyId]]:
        return ([name] for name in self.bricks or () if name in levels)

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        return self.bricks is not None and set(bricks) <= set(self.bricks)

    def rests_on_fate_of(self, trace: Trace) -> Collection[BodyId]:
        return trace.tracks.keys()

    def is_decided(self, trace: Trace) -> bool:
        if self.for_ is not None and is_over(self.for_, trace):
            return True
        fallen, may_fall = set(self._fallen(trace)), {track.brick.id for track in placed(trace)}
        if self.count is not None:
            return self.count.same_for(len(fallen), len(may_fall))
        wanted = frozenset(self.bricks or ())
        return not fallen <= wanted <= may_fall or fallen == may_fall

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the fallen bricks, or their number."""
        fallen = self._fallen(trace)
        count = f"{how_many(len(fallen), 'brick')} fell"
        if self.count is not None:
            return within(self.count, len(fallen), "bricks", count)
        present, expected = dict(remaining(trace)), self.bricks or ()
        names = names_text(fallen, among=present)
        measured = f"{count}: {names}" if ", " in names else f"{names} fell" if fallen else "nothing fell"
        missing = [name for name in expected if name not in fallen]
        unexpected = [name for name in fallen if name not in expected]
        # Of two long lists a reader wants the difference.
        for label, some, others in (("unexpected", unexpected, expected), ("missing", missing, fallen)):
            if some and others:
                measured += f"; {label}: {names_text(some, among=present)}"
        wrong = len(missing) + len(unexpected)
        return ClaimResult(measured, -float(wrong), "bricks", passed=not wrong)

    def _fallen(self, trace: Trace) -> list[BodyId]:
        fallen = [(name, track) for name, track in remaining(trace) if track.state is BrickState.FALLEN]
        return [name for name, track in fallen if self.for_ is None or in_time(self.for_, track, trace)]
