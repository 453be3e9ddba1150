"""The claim `untouched`."""

from collections.abc import Iterator
from math import dist, inf
from typing import ClassVar, Final

from pydantic import Field

from stability.geometry.vectors import turn_between
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, Count, claim
from stackdsl.language.claims.claim_result import ClaimResult, remaining
from stackdsl.language.model_base import ExactlyOneKey
from stackdsl.trace import BrickState, BrickTrack, Trace
from stackdsl.wording import MILLIMETRES, mm

EXACTLY: Final = 1e-9  # [m] and [rad], above the rounding error of a pose that goes into an engine and back


@claim("untouched", "bricks are exactly where they came to rest")
class Untouched(ExactlyOneKey, ClaimKind):
    """Bricks are exactly where they came to rest."""

    bricks: t.BodyNames | None = Field(None, description="bricks that did not move")
    levels: t.Levels | None = Field(None, description="number of levels that did not move, counted from the lowest")
    except_: t.BodyNames | None = Field(None, alias="except", description="exceptions: no brick except these moved")

    one_of: ClassVar[tuple[str, ...]] = ("bricks", "levels", "except_")

    def counts(self) -> Iterator[Count]:
        if self.levels is not None:
            yield Count("levels", self.levels, "levels")

    def judge(self, trace: Trace) -> ClaimResult:
        """Return whether bricks are exactly where they came to rest, at the end."""
        names = frozenset(trace.tracks if self.bricks is None else self.bricks).difference(self.except_ or ())
        tracks = [track for name, track in remaining(trace) if name in names and self._includes(track.level)]
        if not tracks or any(track.state is BrickState.UNPLACED for track in tracks):
            return ClaimResult("never placed", 0.0, "mm", passed=False)
        moved = [track for track in tracks if not _is_where_it_was(track)]
        if not moved:
            return ClaimResult(f"{len(tracks)} bricks have not moved", inf, "", passed=True)
        worst = max(moved, key=_moved_by)
        measured = f"{len(moved)} of {len(tracks)} bricks moved, {worst.brick.id} by {mm(_moved_by(worst))}"
        return ClaimResult(measured, -MILLIMETRES * _moved_by(worst), "mm", passed=False)

    def _includes(self, level: int) -> bool:
        return self.levels is None or level <= self.levels


def _is_where_it_was(track: BrickTrack) -> bool:
    return _moved_by(track) <= EXACTLY and turn_between(track.rest, track.final) <= EXACTLY


def _moved_by(track: BrickTrack) -> float:
    return dist(track.rest.position_W, track.final.position_W)
