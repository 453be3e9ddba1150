"""The claim `leaves`."""

from collections import defaultdict
from collections.abc import Iterator, Set
from itertools import takewhile
from typing import ClassVar

from pydantic import Field

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, claim
from stackdsl.language.claims.claim_result import ClaimResult, remaining, within
from stackdsl.language.model_base import ExactlyOneKey
from stackdsl.trace import STAND, BrickState, Trace


@claim("leaves", "number of levels or bricks that stand at the end")
class Leaves(ExactlyOneKey, ClaimKind):
    """Number of levels or bricks that stand at the end."""

    levels: t.CountTolerance | None = Field(
        None, description="number of complete levels that stand, counted from the lowest"
    )
    bricks: t.CountTolerance | None = Field(None, description="number of bricks that stand")

    one_of: ClassVar[tuple[str, ...]] = ("levels", "bricks")
    requires_physical_collapse: ClassVar[bool] = True
    only_falls: ClassVar[bool] = True

    def counts(self) -> Iterator[Count]:
        if self.levels is not None:
            yield Count("levels", self.levels.least_count, "levels")
        if self.bricks is not None:
            yield Count("bricks", self.bricks.least_count, "bricks")

    def is_decided(self, trace: Trace) -> bool:
        # Every standing brick may fall, and every unsettled one may come to rest.
        may_stand = STAND | {BrickState.UNSETTLED}
        if self.levels is not None:
            return self.levels.same_for(0.0, _levels_standing(trace, may_stand))
        assert self.bricks is not None  # exactly one of them is written
        return self.bricks.same_for(0.0, _bricks_standing(trace, may_stand))

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the number of standing levels or bricks."""
        if self.levels is not None:
            count = _levels_standing(trace, STAND)
            return within(self.levels, count, "levels", f"{count} levels stand")
        assert self.bricks is not None  # exactly one of them is written
        count = _bricks_standing(trace, STAND)
        return within(self.bricks, count, "bricks", f"{count} bricks stand")


def _bricks_standing(trace: Trace, states: Set[BrickState]) -> int:
    return sum(track.state in states for _, track in remaining(trace))


def _levels_standing(trace: Trace, states: Set[BrickState]) -> int:
    """Return the number of levels, counted from the ground, with all bricks in one of some states."""
    levels = defaultdict[int, list[bool]](list)
    for _, track in remaining(trace):
        levels[track.level].append(track.state in states)
    return sum(1 for _ in takewhile(lambda level: all(levels[level]), sorted(levels)))
