"""A brick let go above what stands by then."""

from pydantic import Field

from stackdsl.language import author_types as t
from stackdsl.language.bricks import BrickKind
from stackdsl.language.impacts.aims import AimText
from stackdsl.language.impacts.impact_kind import ImpactKind, Missile, impact


@impact("drop", "drop a brick onto it")
class Drop(ImpactKind):
    """A brick let go above what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: dropped-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is dropped; default: the scenario's brick")
    onto: AimText = Field(description="the aim: the middle of a level, or of a brick")
    height: t.PositiveLength = Field(description="how far it falls until it meets what it is dropped onto")
    rotate: tuple[t.Angle, t.Angle, t.Angle] | None = Field(
        None, description="turn about x, then y, then z, the axes of the scene; default: flat, along what it falls onto"
    )

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "dropped")
