"""A brick that a hand holds where it is."""

from collections.abc import Iterable

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.impacts.impact_kind import ImpactKind, impact


@impact("hold", "hold a brick where it is")
class Hold(ImpactKind):
    """A brick that a hand holds where it is, and lets go."""

    brick: t.BodyName = Field(description="the brick")
    for_: t.PositiveDuration = Field(alias="for", description="how long it is held")

    @property
    def lasts(self) -> float:
        return self.for_

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)
