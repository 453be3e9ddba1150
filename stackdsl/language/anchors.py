"""Times tied to events, as people write them: `built`, `level 9 + 1 s`, `brick L3.2`, `impact 1`."""

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Self

from pydantic import Field, model_validator

from stackdsl.language.author_models import Choice
from stackdsl.language.author_types import NAME, REPEAT, Duration, Reads, text_schema
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import DURATION, parse_quantity, quantity_pattern


@dataclass(frozen=True, slots=True)
class Anchor:
    """A time tied to an event: the start, the end of building, a brick or the last of a level set, or an impact."""

    event: str  # start, built, level, brick, or impact
    name: str = ""  # of the brick, or the number of the level or the impact
    offset: float = 0.0  # after the event [s]


_EVENT = rf"start|built|(?:level|impact)\s+[1-9][0-9]{{0,5}}|brick\s+{NAME}"


def parse_anchor(written: object) -> Anchor:
    """An anchor such as `built`, `level 9 + 1 s`, or `brick L3.2`."""
    match = re.fullmatch(rf"({_EVENT})(?:\s*\+\s*(.+))?", written.strip()) if isinstance(written, str) else None
    if match is None:
        raise MistakeError("SD110", f"{shown(written)} is not an event", _meant(written))
    offset = parse_quantity(match[2], DURATION) if match[2] else 0.0
    event, *name = match[1].split()
    return Anchor(event, "".join(name), offset)


def _meant(written: object) -> str:
    """What to write instead; of a word that is close to one of ours, which one that may be."""
    hint = "write start, built, level 9, brick L3.2, or impact 1, perhaps + 1 s; for a clock time there is `at`"
    word, *rest = str(written).split(maxsplit=1) or [""]
    close = get_close_matches(word, ("start", "built", "level", "brick", "impact"), n=1, cutoff=0.6)
    return f"did you mean '{' '.join([close[0], *rest])}'? Else {hint}" if close and close[0] != word else hint


_ANCHOR = rf"(?:{_EVENT})(?:\s*\+\s*{quantity_pattern(DURATION)})?"
AnchorText = Annotated[
    Anchor, Reads(parse_anchor, text_schema(_ANCHOR, "an event, and a time after it", "built + 2 s"))
]


class Timed(Choice):
    """A step that begins at a time, or after an event, or else after what comes before it."""

    repeat: REPEAT = Field(None, description="variables that each repetition has its own values of")
    at: Duration | None = Field(None, description="when the step begins; default: after the previous step")
    after: AnchorText | None = Field(None, description="the event that the step begins after")

    @model_validator(mode="after")
    def _begin_once(self) -> Self:
        if self.at is not None and self.after is not None:
            raise MistakeError("SD108", "a step begins `at` a time or `after` an event, not both", "remove one of them")
        return self
