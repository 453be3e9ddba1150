"""A brick that flies at what stands by then."""

from pydantic import Field

from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel, default
from stackdsl.language.bricks import BrickKind
from stackdsl.language.impacts.aims import AimText
from stackdsl.language.impacts.impact_kind import ImpactKind, Missile, impact


class Start(AuthorModel):
    """Where a thrown brick comes from."""

    bearing: t.Angle = Field(description="where it comes from, seen from the aim: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = default("10 mm", "between its nose and the first brick on its way")


@impact("throw", "throw a brick at it")
class Throw(ImpactKind):
    """A brick that flies, end-on unless turned, at what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: thrown-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is thrown; default: the scenario's brick")
    at: AimText = Field(description="the aim: the middle of a level, or of a brick")
    from_: Start = Field(alias="from", description="where it comes from")
    speed: t.Speed = Field(description="how fast it comes along the ground")
    turn: t.Angle = default("0 deg", "about its upright axis, from end-on; at 90 deg it comes broadside")

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "thrown")
