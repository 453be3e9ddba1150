"""Times tied to events, as people write them: `built`, `level 9 + 1 s`, `brick L3.2`."""

import re
from dataclasses import dataclass
from typing import Annotated

from stackdsl.language.author_types import NAME, Reads, text_schema
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import DURATION, parse_quantity, quantity_pattern


@dataclass(frozen=True, slots=True)
class Anchor:
    """A time tied to an event: the start, the end of building, or when a brick or the first of a level is set."""

    event: str  # start, built, level, or brick
    name: str = ""  # of the brick, or the number of the level
    offset: float = 0.0  # after the event [s]


_EVENT = rf"start|built|level\s+[1-9]\d{{0,5}}|brick\s+{NAME}"


def parse_anchor(written: object) -> Anchor:
    """An anchor such as `built`, `level 9 + 1 s`, or `brick L3.2`."""
    match = re.fullmatch(rf"({_EVENT})(?:\s*\+\s*(.+))?", written.strip()) if isinstance(written, str) else None
    if match is None:
        hint = "write start, built, level 9, or brick L3.2, and if need be + 1 s; for a clock time there is `at`"
        raise MistakeError("SD110", f"{shown(written)} is not an event", hint)
    offset = parse_quantity(match[2], DURATION) if match[2] else 0.0
    event, *name = match[1].split()
    return Anchor(event, "".join(name), offset)


_ANCHOR = rf"(?:{_EVENT})(?:\s*\+\s*{quantity_pattern(DURATION)})?"
AnchorText = Annotated[
    Anchor, Reads(parse_anchor, text_schema(_ANCHOR, "an event, and a time after it", "built + 2 s"))
]
