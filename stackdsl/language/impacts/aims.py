"""What a hit is aimed at: one brick, or the middle of a level."""

import re
from dataclasses import dataclass
from typing import Annotated, Final

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.named import NamesBody


@dataclass(frozen=True, slots=True)
class Aim:
    """What a hit is aimed at: one brick, or the middle of a level."""

    brick: BodyId | None = None
    level: int | None = None  # if no brick is meant


_LEVEL: Final = r"level\s+([1-9][0-9]{0,5})"


def _read_aim(written: object) -> Aim:
    text = written.strip() if isinstance(written, str) else ""
    if level := re.fullmatch(_LEVEL, text):
        return Aim(level=int(level[1]))
    if re.fullmatch(t.NAME, text):
        return Aim(brick=text)
    raise MistakeError("SD104", f"{shown(written)} is nothing to aim at", "write a level, such as level 3, or a brick")


def _brick_of(aim: object) -> BodyId | None:
    return aim.brick if isinstance(aim, Aim) else None


AimText = Annotated[
    Aim,
    t.Reads(_read_aim, t.text_schema(rf"{_LEVEL}|{t.NAME}", "a level, or the name of a brick", "level 3")),
    NamesBody(read=_brick_of),
]
