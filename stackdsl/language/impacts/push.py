"""An impulse on one brick."""

from collections.abc import Iterable

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.author_models import default
from stackdsl.language.impacts.impact_kind import ImpactKind, impact


@impact("push", "give a brick an impulse")
class Push(ImpactKind):
    """An impulse on one brick."""

    brick: t.BodyName = Field(description="the brick")
    impulse: tuple[t.Impulse, t.Impulse, t.Impulse] = Field(description="[x, y, z] in the axes of the scene")
    point: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "where it is pushed, from its centre, in the axes of the scene"
    )

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)
