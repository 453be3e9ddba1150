"""A layout, a claim and an impact as somebody else would write them: all that each of them needs is here."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import degrees
from typing import ClassVar

from pydantic import Field

from stability.geometry.vectors import rotate
from stability.model import Vec3
from stackdsl.compiler.impact_scene import ImpactScene, MissError
from stackdsl.compiler.impacts import actions_of
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import CLAIMS, ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, within
from stackdsl.language.impacts import IMPACTS, ImpactKind, impact
from stackdsl.language.layouts.registry import LAYOUTS, BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import AuthorModel
from stackdsl.timeline import PushAction
from stackdsl.trace import Trace

# --- a layout ---------------------------------------------------------------------------------------------------------


class StairsParams(LayoutParams):
    """Columns of planks side by side, each one plank higher than the one before."""

    steps: t.Levels = Field(description="how many columns")

    count: ClassVar[str] = "steps"

    @property
    def bricks_at_most(self) -> int:
        return self.steps * (self.steps + 1) // 2


def stairs(params: StairsParams, size: Vec3) -> Specs:
    """Columns side by side along y, each one plank higher than the one before."""
    pitch = 2.0 * size[1]  # free of each other
    return tuple(
        BrickSpec(level, (0.0, column * pitch, height(level, size[2])))
        for level in range(1, params.steps + 1)
        for column in range(level - 1, params.steps)
    )


# --- a claim ----------------------------------------------------------------------------------------------------------


class Tilts(AuthorModel, ClaimKind):
    """How far a brick tilts after it came to rest."""

    brick: t.BodyName = Field(description="the brick")
    by: t.SlopeTolerance = Field(description="how far it tilts")

    identifying_keys: ClassVar[tuple[str, ...]] = ("brick",)

    def judge(self, trace: Trace) -> ClaimResult:
        """The largest tilt of the brick, whatever became of it."""
        tilt = trace.tracks[self.brick].tilt
        return within(self.by, tilt, "deg", f"{degrees(tilt):.3g} deg")


# --- an impact --------------------------------------------------------------------------------------------------------


class Shake(ImpactKind):
    """The same impulse on every brick of a level."""

    level: t.Levels = Field(description="the level")
    impulse: tuple[t.Impulse, t.Impulse, t.Impulse] = Field(description="[x, y, z] in the axes of the scene")


def shaken(shake: Shake, scene: ImpactScene) -> tuple[PushAction, ...]:
    """A push of every brick of the level that stands by then. Raises MissError."""
    meant = [brick for brick in scene.resting if brick.level == shake.level]
    if not meant:
        raise MissError("level", "SD205", f"no brick of level {shake.level} stands by then", "begin later")
    impulse_W = rotate(scene.tilt, shake.impulse)
    return tuple(PushAction(scene.moment.time, brick.name, impulse_W) for brick in meant)


# --- all of them, for a while -----------------------------------------------------------------------------------------


@contextmanager
def registered() -> Iterator[None]:
    """While the kinds are known; in a module of its own, each would be registered by a decorator as it is imported."""
    layout("stairs", StairsParams)(stairs)
    claim("tilts", "how far a brick tilts")(Tilts)
    impact("shake", "shake a level")(Shake)
    actions_of.register(shaken)
    try:
        yield
    finally:
        LAYOUTS.forget("stairs")
        CLAIMS.forget("tilts")
        IMPACTS.forget("shake")
