"""The claim `height`."""

from collections.abc import Set
from typing import ClassVar

from pydantic import Field

from stability.geometry.placed_shape import top_W
from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, placed, within
from stackdsl.language.model_base import Shorthand
from stackdsl.trace import BrickState, Collapse, Trace
from stackdsl.wording import how_many, level_text, mm


@claim("height", "the height of the structure")
class Height(Shorthand, ClaimKind):
    """The height of the structure."""

    within: t.LengthTolerance = Field(alias="is", description="the height")
    of: t.BodyName | None = Field(None, description="the brick whose top is measured; default: the highest")

    scalar_key: ClassVar[str] = "is"
    identifying_keys: ClassVar[tuple[str, ...]] = ("of",)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the highest top of the standing bricks, or the top of one brick."""
        tracks = [track for track in placed(trace) if self.of in (None, track.brick.id)]
        if not tracks:
            return ClaimResult("never placed", 0.0, "mm", passed=False)
        if self.of is None:
            down = _without_support(trace)
            tracks = [track for track in tracks if track.brick.id not in down]
        top = max((top_W(track.brick.shape, track.final) for track in tracks), default=0.0)
        return within(self.within, top, "mm", f"{mm(top)}{_after(trace.collapse)}")


def _without_support(trace: Trace) -> Set[BodyId]:
    """Return the bricks that fell or are unsettled, and those that lean on them: all bricks below them are among these.

    The supports of a brick are those of its first proof, which may follow a fall; then the ground counts for nothing.
    """
    lost = (BrickState.FALLEN, BrickState.UNSETTLED)
    down = {name for name, track in trace.tracks.items() if track.state in lost}
    supports = {
        name: {edge.lower for edge in edges if edge.lower in trace.tracks}
        for name, edges in trace.edges_when_placed.items()
    }
    while leaning := {name for name, lower in supports.items() if lower and lower <= down} - down:
        down |= leaning
    return down


def _after(fell: Collapse | None) -> str:
    """Return that the structure fell, since its height alone does not show it."""
    if fell is None:
        return ""
    if fell.fallen:
        return f", after {len(fell.fallen)} of {how_many(fell.bricks, 'brick')} fell"
    return f", after a collapse at {level_text(fell.level, fell.step)}"
