"""Mistakes as whoever reads one value raises them; where in the file that value stands is not known there."""

import re
from collections.abc import Callable
from typing import Final

DECIMAL_COMMA: Final = re.compile(r"((?:[<>]=?\s*)?[-+]?\d{1,9}),(\d{1,9})(\s*[a-zA-Z%][^,]*)?")


class MistakeError(ValueError):
    """A mistake of the author in one value; a `ValueError`, so that pydantic carries it.

    A hint that takes long to find, such as what else is called alike, is looked for only where the mistake is told.
    """

    def __init__(self, code: str, message: str, hint: str | Callable[[], str] = "") -> None:
        super().__init__(message)
        self.code, self.message, self._hint = code, message, hint

    @property
    def hint(self) -> str:
        """What to do about it."""
        return self._hint if isinstance(self._hint, str) else self._hint()


class EchoError(ValueError):
    """What follows from a mistake that is told elsewhere, and is itself none."""


def without_comma(written: object) -> str:
    """What to write in place of a number with a decimal comma; empty for anything else."""
    found = DECIMAL_COMMA.fullmatch(written.strip()) if isinstance(written, str) else None
    return f"write a decimal point in place of the comma: {found[1]}.{found[2]}{found[3] or ''}" if found else ""


def shown(written: object) -> str:
    """What the author wrote, for a message."""
    match written:
        case None:
            return "nothing"
        case bool():
            return str(written).lower()
        case str():
            return f"'{written}'" if len(written) <= 40 else f"'{written[:39]}…'"  # noqa: PLR2004 -- what fits a line
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
    return repr(written)
