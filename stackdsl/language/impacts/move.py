"""A brick that a hand moves along a path, with all that is in its way."""

from collections.abc import Iterable
from typing import ClassVar, Self

from pydantic import Field, model_validator

from stability.mechanics.hand_course import HandCourse
from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.author_models import Choice, default
from stackdsl.language.hand_words import Places, SomeWay
from stackdsl.language.impacts.impact_kind import ImpactKind, impact
from stackdsl.language.mistakes import MistakeError


@impact("move", "move a brick by hand")
class Move(Choice, ImpactKind):
    """A brick that a hand moves along a path, with all that is in its way, and lets go."""

    brick: t.BodyName = Field(description="the brick")
    by: SomeWay | None = Field(None, description="how far, straight, as [x, y, z] in the axes of the scene")
    path: Places | None = Field(
        None, description="the places it goes to, one after another, each from where it is at first; it stops in each"
    )
    speed: t.Speed = default("50 mm/s", "the most on the way; it sets out and stops smoothly")
    held: t.Duration = default("0 s", "how long it is held at the end before it is let go")
    slid: t.Flag = Field(False, description="pushed along level rather than carried: it keeps its weight, and may tip")

    one_of: ClassVar[tuple[str, ...]] = ("by", "path")

    @model_validator(mode="after")
    def _slide_level(self) -> Self:
        if self.slid and any(z for _, _, z in self.course.places_W):
            raise MistakeError(
                "SD104", "what is slid goes level, and this way goes up or down", "carry it, or write 0 for z"
            )
        return self

    @property
    def course(self) -> HandCourse:
        """The way, in the axes of the scene."""
        return HandCourse(self.path if self.by is None else (self.by,), self.speed)  # type: ignore[arg-type]  # one is

    @property
    def lasts(self) -> float:
        return self.course.duration + self.held

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)
