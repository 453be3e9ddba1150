"""Distributions in place of a value: `friction: 0.5 ± 0.05`, each a variable of its own that has no name.

Done for each variant once its expressions are worked out and its repeats written out, so that every repetition has a
variable of its own, and all later stages see a plain value.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Final, TypeAlias

from stackdsl.language.choices import Mistakes, add
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.quantities import QUANTITY
from stackdsl.language.uncertain import KEYS, ONE_LINE, Distribution, distribution
from stackdsl.reading.source import Path, Plain

ROOTS: Final = ("friction", "world", "brick", "brick_types", "build")  # what is built, and of what
# What a step says of when and by whose hands, and what it is called.
NOT_OF_A_STEP: Final = ("repeat", "name", "every", "until", "place", "jitter", "at", "after", "import")
SILENT: Final = "${}"  # in place of what is mistaken and told: whoever validates it passes over it
_MARK: Final = re.compile(r"±|\+/?-|\.\.|^(?:" + "|".join(ONE_LINE) + ") ")
_EITHER: Final = re.compile(r"(.+?)\s*(?:±|\+/?-|\.\.)\s*(.+)")

Pick: TypeAlias = Callable[[str, Distribution], Plain]  # the value that a variable has


def is_inline(written: Plain) -> bool:
    """Whether a value is a distribution in one line."""
    if not isinstance(written, str):
        return False
    text = written.strip()
    if not _MARK.search(text):
        return False
    if text.partition(" ")[0] in ONE_LINE and " " in text:
        return True
    match = _EITHER.fullmatch(text)
    return match is not None and all(QUANTITY.fullmatch(part) for part in match.groups())


def subject(path: Path) -> str:
    """What the variable at a path is called: `build[0].column.step`."""
    text = "".join(f"[{each}]" if isinstance(each, int) else f".{each}" for each in path)
    return text.removeprefix(".")


class Inline:
    """Puts values in place of the distributions of a variant."""

    def __init__(self, pick: Pick, mistakes: Mistakes) -> None:
        self.found: dict[Path, Plain] = {}  # by path, as written
        self._pick, self._mistakes = pick, mistakes

    def of(self, value: Plain, path: Path) -> Plain:
        """A value without distributions."""
        if path[0] not in ROOTS or (path[0] == "build" and path[2:] in _LEFT_TO_STEPS):
            return value
        if isinstance(value, dict) and _is_spelt_out(value, path):
            add(
                self._mistakes,
                path,
                MistakeError("SD103", "in place of a value a distribution is one line", _line(value)),
            )
            return SILENT
        if isinstance(value, dict):
            return {key: self.of(member, (*path, key)) for key, member in value.items()}
        if isinstance(value, list):
            return [self.of(item, (*path, index)) for index, item in enumerate(value)]
        return self._picked(value, path) if is_inline(value) and path[-1] != "name" else value

    def _picked(self, written: Plain, path: Path) -> Plain:
        try:
            value = self._pick(subject(path), distribution(written))
        except MistakeError as mistake:
            add(self._mistakes, path, mistake)
            return SILENT
        self.found[path] = written
        return value

    def without_samples(self) -> Iterator[tuple[Path, MistakeError]]:
        """The mistakes where there are no samples of which each could have another value."""
        for path, written in self.found.items():
            message = f"'{written}' is another value in each sample, and there are no samples"
            yield path, MistakeError("SD102", message, "add samples: 1000 to the scenario, or write one value")


def _is_spelt_out(value: Mapping[str, Plain], path: Path) -> bool:
    """Whether a mapping is a distribution, as `uncertain` has it."""
    elsewhere = path[:2] == ("world", "shake") or "jitter" in path or path == ("brick_types",)  # have keys called so
    return not elsewhere and any(kind in value for kind in ONE_LINE) and value.keys() <= {*KEYS}


def _line(value: Mapping[str, Plain]) -> str:
    """The same in one line."""
    kind = next(key for key in ONE_LINE if key in value)
    first = value[kind]
    table = "; ".join(map(str, first)) if isinstance(first, list) else str(first)
    return " ".join(["write", kind, table, *(f"{key} {value[key]}" for key in KEYS if key in value and key != kind)])


_LEFT_TO_STEPS: Final = tuple((key,) for key in NOT_OF_A_STEP)
