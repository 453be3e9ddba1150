"""What an author may claim of what happened: what is expected, and what is known from outside."""

from typing import Annotated, ClassVar, Final

from pydantic import BeforeValidator, Field, WithJsonSchema

from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel, Choice, Shorthand
from stackdsl.language.layouts import MAX_BRICKS, Levels

BodyNames = Annotated[tuple[t.BodyName, ...], Field(min_length=1, max_length=MAX_BRICKS)]


class Stands(Shorthand):
    """Bricks are where they came to rest."""

    levels: Levels | None = Field(None, description="at least so many levels, from the lowest")
    bricks: BodyNames | None = Field(None, description="these bricks")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="this long after the last brick is placed")

    scalar_word: ClassVar[str] = "all"


class Collapses(Shorthand):
    """A brick that had come to rest leaves its place."""

    at: t.LevelTolerance | None = Field(None, description="the level under construction when it does")
    brick: t.BodyName | None = Field(None, description="the first brick that does")
    time: t.DurationTolerance | None = Field(None, description="when it does")

    scalar_word: ClassVar[str] = "any"


class Displaced(AuthorModel):
    """How many bricks have moved."""

    bricks: t.CountTolerance = Field(description="how many")
    by: t.LengthLowerBound = Field(description="how far a brick has at least moved to be counted")


class Drift(Shorthand):
    """The largest shift of a brick after it came to rest."""

    within: t.LengthTolerance = Field(alias="is", description="the shift")
    bricks: BodyNames | None = Field(None, description="of these bricks; default: of all")

    scalar_key: ClassVar[str] = "is"


class RestsOn(AuthorModel):
    """One brick is carried by another."""

    brick: t.BodyName = Field(description="the upper brick")
    support: t.BodyName = Field(description="the lower one, or ground")
    share: t.ShareTolerance | None = Field(None, description="part of its load that goes there")


class Height(Shorthand):
    """How high the structure reaches."""

    within: t.LengthTolerance = Field(alias="is", description="the height")
    of: t.BodyName | None = Field(None, description="the brick whose top is measured; default: the highest")

    scalar_key: ClassVar[str] = "is"


class Claim(Choice):
    """One statement about what happened."""

    stands: Stands | None = Field(None, description="bricks are where they came to rest")
    collapses: Collapses | None = Field(None, description="the structure collapses")
    displaced: Displaced | None = Field(None, description="how many bricks have moved")
    drift: Drift | None = Field(None, description="the largest shift of a brick after it came to rest")
    rests_on: RestsOn | None = Field(None, description="one brick is carried by another")
    height: Height | None = Field(None, description="how high the structure reaches")

    one_of: ClassVar[tuple[str, ...]] = ("stands", "collapses", "displaced", "drift", "rests_on", "height")

    @property
    def kind(self) -> str:
        """The key that is written, such as `stands`."""
        return next(key for key in self.one_of if getattr(self, key) is not None)


def _listed(written: object) -> object:
    return [written] if isinstance(written, str) else written


_ONE: Final[t.JsonSchema] = {"enum": list(t.SYSTEMS)}
_ONE_OR_MORE: Final[t.JsonSchema] = {"anyOf": [_ONE, {"type": "array", "items": _ONE, "minItems": 1}]}


class Expectation(Claim):
    """What must come of the scenario."""

    system: Annotated[t.Systems, BeforeValidator(_listed), WithJsonSchema(_ONE_OR_MORE)] | None = Field(
        None, description="the system, or systems, that this is expected of; default: all"
    )


class Truth(Claim):
    """What is known from outside; compared and reported, but never a failure."""

    source: t.Text = Field(description="where it is known from")
    because: t.Text | None = Field(None, description="why it is so")
