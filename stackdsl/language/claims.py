"""What an author may claim of what happened: what is expected, and what is known from outside."""

from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel, Choice, Shorthand, default
from stackdsl.language.layouts.registry import MAX_BRICKS, Levels
from stackdsl.language.mistakes import MistakeError

BodyNames = Annotated[tuple[t.BodyName, ...], Field(min_length=1, max_length=MAX_BRICKS)]


class Stands(Shorthand):
    """Bricks are where they came to rest."""

    levels: Levels | None = Field(None, description="at least so many levels, from the lowest")
    bricks: BodyNames | None = Field(None, description="these bricks")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="this long after the last action")

    scalar_word: ClassVar[str] = "all"


class Collapses(Shorthand):
    """A brick that had come to rest leaves its place."""

    at: t.LevelTolerance | None = Field(None, description="the level under construction when it does")
    brick: t.BodyName | None = Field(None, description="the first brick that does")
    time: t.DurationTolerance | None = Field(None, description="when it does")

    scalar_word: ClassVar[str] = "any"


class Leaves(Choice):
    """How much of the structure stands at the end."""

    levels: t.CountTolerance | None = Field(None, description="levels, from the lowest, all of whose bricks stand")
    bricks: t.CountTolerance | None = Field(None, description="bricks, whichever they are")

    one_of: ClassVar[tuple[str, ...]] = ("levels", "bricks")


class Falls(Choice):
    """What of the structure falls."""

    bricks: BodyNames | None = Field(None, description="these bricks, and no other")
    count: t.CountTolerance | None = Field(None, description="how many bricks, whichever they are")

    one_of: ClassVar[tuple[str, ...]] = ("bricks", "count")


class Untouched(Choice):
    """Bricks are exactly where they came to rest."""

    bricks: BodyNames | None = Field(None, description="these bricks")
    levels: Levels | None = Field(None, description="so many levels, from the lowest")
    except_: BodyNames | None = Field(None, alias="except", description="all but these bricks")

    one_of: ClassVar[tuple[str, ...]] = ("bricks", "levels", "except_")


class Asking(AuthorModel):
    """A mapping of which at least one key is due."""

    defaults: ClassVar[tuple[str, ...]] = ()  # keys that ask nothing by themselves

    @property
    def asked(self) -> tuple[str, ...]:
        """The questions that are written."""
        return tuple(key for key in self._questions() if getattr(self, key) is not None)

    @classmethod
    def _questions(cls) -> tuple[str, ...]:
        return tuple(key for key in cls.model_fields if key not in cls.defaults)

    @model_validator(mode="after")
    def _ask_something(self) -> Self:
        if not self.asked:
            cause = "nothing is asked" if self.model_fields_set else "the mapping is empty"
            raise MistakeError("SD102", cause, f"give one of {', '.join(self._questions())}")
        return self


class Pivots(Asking):
    """What falls begins to as the proof says that it does, over the first 5 degrees."""

    about: t.BodyName | None = Field(None, description="what stands still and is turned about; or ground")
    within: t.Slope | None = Field(None, description="between where bricks go and where the proof says, at most")
    proportions: t.ShareOfLimit | None = Field(
        None, description="between how far bricks go and the proof says, both as shares of the furthest, at most"
    )


class Lands(Asking):
    """Where the common centre of mass of what fell comes down, sideways from where it had been."""

    reach: t.LengthTolerance | None = Field(None, description="how far")
    bearing: t.Angle | None = Field(None, description="which way: 0 deg = +x, 90 deg = +y")
    within: t.Slope = default("10 deg", "how far from the bearing, at most")

    defaults: ClassVar[tuple[str, ...]] = ("within",)


class EnergyChange(AuthorModel):
    """Kinetic and potential energy of all bricks together, from the last action on."""

    gain: t.ShareTolerance = Field(description="how much it rises, of the potential energy above the ground")


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


class Margin(Asking):
    """How much the proof that the structure stands would survive."""

    acceleration: t.GravityTolerance | None = Field(
        None, description="sideways in the worst direction, a plain number: times the gravity"
    )
    tilt: t.SlopeTolerance | None = Field(None, description="of the whole scene, in the worst direction")
    friction: t.FrictionTolerance | None = Field(None, description="the least coefficient with which it stands")
    placement: t.LengthTolerance | None = Field(None, description="the error in the place of every brick")


class Claim(Choice):
    """One statement about what happened."""

    stands: Stands | None = Field(None, description="bricks are where they came to rest")
    collapses: Collapses | None = Field(None, description="the structure collapses")
    leaves: Leaves | None = Field(None, description="how much of the structure stands at the end")
    falls: Falls | None = Field(None, description="which bricks fall, or how many")
    pivots: Pivots | None = Field(None, description="how what falls begins to")
    lands: Lands | None = Field(None, description="where what fell comes down")
    displaced: Displaced | None = Field(None, description="how many bricks have moved")
    drift: Drift | None = Field(None, description="the largest shift of a brick after it came to rest")
    rests_on: RestsOn | None = Field(None, description="one brick is carried by another")
    height: Height | None = Field(None, description="how high the structure reaches")
    untouched: Untouched | None = Field(None, description="bricks are exactly where they came to rest")
    energy: EnergyChange | None = Field(None, description="what happens to the energy of all bricks together")

    verdict: Literal["stable", "unstable", "undecided"] | None = Field(
        None, description="what statics says of the structure after its last change"
    )
    margin: Margin | None = Field(None, description="how much the proof that it stands would survive")

    one_of: ClassVar[tuple[str, ...]] = (
        *(
            "stands",
            "collapses",
            "leaves",
            "falls",
            "pivots",
            "lands",
            "displaced",
            "drift",
            "rests_on",
            "height",
            "untouched",
            "energy",
        ),
        *("verdict", "margin"),
    )

    @property
    def kind(self) -> str:
        """The key that is written, such as `stands`."""
        return next(key for key in self.one_of if getattr(self, key) is not None)

    @property
    def needs_statics(self) -> bool:
        """Whether only a system with proofs can tell."""
        return self.verdict is not None or self.margin is not None

    @property
    def needs_aftermath(self) -> bool:
        """Whether it is asked what becomes of a structure that collapses."""
        return self.kind not in ("stands", "collapses", "verdict", "margin")

    @property
    def needs_close_looks(self) -> bool:
        """Whether it is asked how something begins to fall, or where it lands."""
        return self.pivots is not None or self.lands is not None


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
