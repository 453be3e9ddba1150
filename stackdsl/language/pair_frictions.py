"""What an author may say of how bricks rub on each other, beside the one coefficient that most scenarios have."""

from typing import Annotated, Final, Literal

from pydantic import Field

from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel

MAX_PAIRS: Final = 1000

RubbingName = Annotated[str, t.TYPE_NAME]


class PairOfBodies(AuthorModel):
    """Two bodies, or kinds of bricks, and how they rub on each other."""

    pair: tuple[RubbingName, RubbingName] = Field(
        description="two kinds of brick, or bricks, the ground, walls by name; one kind twice for two of its bricks"
    )
    friction: t.Friction = Field(description="Coulomb coefficient of the one on the other")


class Frictions(AuthorModel):
    """What two surfaces have on each other."""

    rule: Literal["lower", "higher", "mean", "geometric"] = Field(
        "lower", description="what two bodies have on each other, of the friction that each has"
    )
    between: Annotated[tuple[PairOfBodies, ...], Field(max_length=MAX_PAIRS)] = Field(
        (), description="what certain pairs have, whatever each has by itself"
    )
