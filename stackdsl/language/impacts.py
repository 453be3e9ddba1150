"""What may be done to a structure, step by step, while it is built or after."""

from typing import ClassVar

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.anchors import Timed
from stackdsl.language.author_models import Choice
from stackdsl.language.bricks import SetBrick
from stackdsl.language.claims import BodyNames


class Remove(Choice):
    """Bricks pulled out, all at once."""

    brick: t.BodyName | None = Field(None, description="the brick")
    bricks: BodyNames | None = Field(None, description="the bricks")

    one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks")

    @property
    def names(self) -> tuple[BodyId, ...]:
        """The bricks, in the author's order."""
        return self.bricks or ((self.brick,) if self.brick is not None else ())


class Insert(SetBrick):
    """A brick slid into what stands by then."""


class Impact(Timed):
    """One thing done to the structure. Another kind is another key here, and another action of the timeline."""

    remove: Remove | None = Field(None, description="pull bricks out")
    insert: Insert | None = Field(None, description="slide a brick in")

    one_of: ClassVar[tuple[str, ...]] = ("remove", "insert")
