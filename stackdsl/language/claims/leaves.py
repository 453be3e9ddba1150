"""How much of the structure stands at the end."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import takewhile
from typing import ClassVar

from pydantic import Field

from stackdsl.language import author_types as t
from stackdsl.language.author_models import Choice
from stackdsl.language.claims.claim_kind import ClaimKind, Count, claim
from stackdsl.language.claims.finding import Finding, remaining, within
from stackdsl.trace import STAND, Trace


@claim("leaves", "how much of the structure stands at the end")
class Leaves(Choice, ClaimKind):
    """How much of the structure stands at the end."""

    levels: t.CountTolerance | None = Field(None, description="levels, from the lowest, all of whose bricks stand")
    bricks: t.CountTolerance | None = Field(None, description="bricks, whichever they are")

    one_of: ClassVar[tuple[str, ...]] = ("levels", "bricks")
    of_collapses: ClassVar[bool] = True

    def counts(self) -> Iterator[Count]:
        if self.levels is not None:
            yield Count("levels", self.levels.least_count, "levels")
        if self.bricks is not None:
            yield Count("bricks", self.bricks.least_count, "bricks")

    def judge(self, trace: Trace) -> Finding:
        """How much stands at the end."""
        if self.levels is not None:
            count = _levels_standing(trace)
            return within(self.levels, count, "levels", f"{count} levels stand")
        assert self.bricks is not None  # it is a choice
        count = sum(track.state in STAND for _, track in remaining(trace))
        return within(self.bricks, count, "bricks", f"{count} bricks stand")


def _levels_standing(trace: Trace) -> int:
    """How many levels, counted from the ground, have all their bricks standing."""
    levels = defaultdict[int, list[bool]](list)
    for _, track in remaining(trace):
        levels[track.level].append(track.state in STAND)
    return sum(1 for _ in takewhile(lambda level: all(levels[level]), sorted(levels)))
