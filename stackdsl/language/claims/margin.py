"""The claim `margin`."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf
from typing import ClassVar, Final

from pydantic import Field

from stability.model import BodyId
from stability.name_order import names_text
from stability.problem import Stability
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import (
    SHOWN_PER_SI,
    ClaimResult,
    all_of,
    never_placed_text,
    remaining,
    within,
)
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import USED_STRENGTH, BrickState, BrickTrack, Trace, VerdictMargins
from stackdsl.wording import aided_text

UNITS: Final = {
    "acceleration": "g",
    "tilt": "deg",
    "friction": "",
    "placement": "mm",
    "load_factor": "",
    "settlement": "",
    USED_STRENGTH: "%",
}


@claim("margin", "safety margins of the proof of stability")
class Margin(AtLeastOneKey, ClaimKind):
    """Disturbances under which the structure, with every brick that is not pulled out, is still proven stable."""

    acceleration: t.GravityTolerance | None = Field(
        None, description="permissible horizontal acceleration in the worst direction, as a multiple of gravity"
    )
    tilt: t.SlopeTolerance | None = Field(None, description="permissible tilt of the scene in the worst direction")
    friction: t.FrictionTolerance | None = Field(
        None, description="smallest friction coefficient with which the structure stands"
    )
    placement: t.LengthTolerance | None = Field(None, description="permissible error in the position of every brick")
    load_factor: t.LoadFactorTolerance | None = Field(
        None, description="multiple of its own weight, or of its `loads` if it has some, that the structure bears"
    )

    settlement: t.LoadFactorTolerance | None = Field(
        None, description="multiple of the movement of its `supports` that the structure survives"
    )

    used_strength: t.UsedStrengthTolerance | None = Field(
        None, description="share of their `strength` that the bricks use: the least of all forces that are possible"
    )

    needs_statics: ClassVar[bool] = True

    @property
    def needed_margins(self) -> Collection[str]:
        return self.written_keys

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the margins of the proof, which has to cover all bricks of the structure."""
        bricks = remaining(trace)
        lost = [name for name, track in bricks if track.state is BrickState.FALLEN or not track.frozen]
        if lost:
            unit = UNITS[next(iter(self.written_keys))]
            return ClaimResult(unproven_text("no margin", lost, bricks, trace), -inf, unit, passed=False)
        return self.compared(trace.margins)

    def compared(self, margins: VerdictMargins) -> ClaimResult:
        """Compare the margins of a structure that stands."""
        result = all_of([_part(key, getattr(self, key), getattr(margins, key)) for key in self.written_keys])
        apart = margins.apart
        if apart is None or self.acceleration is None:
            return result
        return replace(result, measured=f"{result.measured}, {aided_text(apart)}")


def unproven_text(
    what_is_missing: str, lost: Sequence[BodyId], bricks: Collection[tuple[BodyId, BrickTrack]], trace: Trace
) -> str:
    """Return why nothing is proven of a structure of which some bricks are lost."""
    absent = [name for name in lost if trace.tracks[name].state is BrickState.UNPLACED]
    there = [name for name in lost if name not in absent]
    states = {trace.tracks[name].state for name in there}
    proven = states <= {BrickState.FALLEN} or (
        trace.statics is not None and trace.statics.stability is Stability.UNSTABLE
    )
    plural = len(there) > 1
    does = ("do" if plural else "does") if proven else ("are" if plural else "is")
    what = f"{does} not stand" if proven else f"{does} not proven to stand"
    names = names_text(there, among=[name for name, _ in bricks])
    told = [f"{len(there)} of {len(bricks)} bricks {what}: {names}"] if there else []
    told += [never_placed_text(len(absent), 0 if there else len(bricks))] if absent else []
    return f"{what_is_missing}: {', and '.join(told)}"


def _part(key: str, wanted: Tolerance, value: float | None) -> ClaimResult:
    """Compare one margin with its tolerance."""
    unit = UNITS[key]
    if value is None:
        return ClaimResult(f"no margin of {key} is proven", -inf, unit, passed=False)
    return within(wanted, value, unit, f"{key} {SHOWN_PER_SI.get(unit, 1.0) * value:.4g} {unit}".rstrip())
