"""Bricks pulled out, all at once."""

from collections.abc import Iterable
from typing import ClassVar

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.author_models import Choice
from stackdsl.language.impacts.impact_kind import ImpactKind, impact
from stackdsl.language.named import Named, named_in


@impact("remove", "pull bricks out")
class Remove(Choice, ImpactKind):
    """Bricks pulled out, all at once."""

    brick: t.BodyName | None = Field(None, description="the brick")
    bricks: t.BodyNames | None = Field(None, description="the bricks")

    one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks")

    @property
    def pulled_out(self) -> Iterable[Named]:
        return named_in(self)

    @property
    def struck(self) -> Iterable[BodyId]:
        return (named.name for named in self.pulled_out)
