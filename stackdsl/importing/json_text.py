"""JSON in which every value knows where it stands: the standard library's parser, with a place noted beside each."""

import json
import re
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from itertools import accumulate
from json.decoder import JSONArray, JSONObject  # type: ignore[attr-defined]  # what its decoder is made of
from json.scanner import py_make_scanner  # type: ignore[attr-defined]  # likewise
from typing import Any, Final, TypeAlias

from stackdsl.diagnostics import Page, Span
from stackdsl.importing.load import LoadReading, UnreadableLoadError

LONGEST_TOLD: Final = 40  # [characters] of a number
_HALF: Final = re.compile("[\ud800-\udfff]")


@dataclass(frozen=True, slots=True)
class Numeral:
    """A number as it is written."""

    text: str


@dataclass(frozen=True, slots=True)
class Node:
    """A value of JSON, and where it begins in the text."""

    value: "dict[str, Node] | list[Node] | str | Numeral | bool | None"
    start: int


_Scan: TypeAlias = Callable[[str, int], tuple[Any, int]]


class _WrongError(ValueError):
    """JSON that the parser accepts but a load must not have: its position, what is wrong, and the remedy."""

    def __init__(self, start: int, message: str, hint: str) -> None:
        super().__init__(message)
        self.start, self.message, self.hint = start, message, hint


class _Decoder(json.JSONDecoder):
    """The decoder of the standard library, whose values are nodes."""

    def __init__(self) -> None:
        super().__init__(
            object_pairs_hook=_each_once, parse_float=Numeral, parse_int=Numeral, parse_constant=_no_number
        )
        self.parse_object = lambda at, strict, _scan, hook, pairs, memo=None: JSONObject(
            at, strict, self._located, hook, pairs, memo
        )
        self.parse_array = lambda at, _scan: JSONArray(at, self._located)
        self._plain: _Scan = py_make_scanner(self)
        self.scan_once = self._located

    def _located(self, text: str, start: int) -> tuple[Node, int]:
        value, end = self._plain(text, start)
        if isinstance(value, str):
            _refuse_halves(value, start)
        return Node(value, start), end


def _each_once(pairs: "list[tuple[str, Node]]") -> "dict[str, Node]":
    found: dict[str, Node] = {}
    for key, node in pairs:
        _refuse_halves(key, node.start)
        if key in found:
            raise _WrongError(node.start, f"'{key}' is written twice in one object", "keep one of them")
        found[key] = node
    return found


def _refuse_halves(text: str, start: int) -> None:
    """Raise an error for a lone surrogate, which a JSON escape can write but UTF-8 cannot encode."""
    if (half := _HALF.search(text)) is not None:
        escape = f"\\u{ord(half.group()):04x}"
        message = f"{escape} is half of a character, whose other half is not beside it"
        raise _WrongError(start, message, "write the whole character, or leave it out")


def _no_number(word: str) -> None:
    raise ValueError(word)


@dataclass(frozen=True, slots=True)
class JsonText:
    """A text of JSON, and where in the file each of its values is."""

    reading: LoadReading
    root: Node
    starts: tuple[int, ...]  # of the lines

    def span(self, node: Node) -> Span:
        """Where a value is."""
        return _span(self.reading.page, self.starts, node.start)

    def mapping(self, node: Node, what: str) -> "dict[str, Node]":
        """The members of an object; told and empty if it is none."""
        if isinstance(node.value, dict):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no object", "write it in braces")
        return {}

    def items(self, node: Node, what: str) -> "list[Node]":
        """The items of an array; told and empty if it is none."""
        if isinstance(node.value, list):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no list", "write it in square brackets")
        return []

    def member(self, owner: Node, members: "dict[str, Node]", key: str, what: str) -> Node | None:
        """A member that must be there; told and None if it is not."""
        if key in members:
            return members[key]
        if isinstance(owner.value, dict):
            self.reading.wrong(self.span(owner), f"{what} has no '{key}'", "complete it, or mend how it is spelt")
        return None

    def word(self, node: Node, what: str) -> str | None:
        """A text; told and None if it is none."""
        if isinstance(node.value, str):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no text", "put it in quotes")
        return None

    def pass_over(self, owner: "dict[str, Node]", taken: set[str], known: set[str]) -> None:
        """Say of all other members that they are not taken."""
        for key, node in owner.items():
            if key not in taken:
                self.reading.leave(key, self.span(node), key in known)


def json_text(reading: LoadReading) -> JsonText:
    """The JSON of a file. Raises UnreadableLoadError if it is none."""
    text = "\n".join(reading.page.lines)
    starts = tuple(accumulate((len(line) + 1 for line in reading.page.lines), initial=0))
    try:
        return JsonText(reading, _Decoder().decode(text), starts)
    except json.JSONDecodeError as error:
        start, message, hint = error.pos, f"this is no JSON: {error.msg}", "save the file anew as JSON"
    except _WrongError as error:
        start, message, hint = error.start, error.message, error.hint
    except RecursionError:
        start, message, hint = 0, "the JSON is nested too deeply", "save the load by itself"
    except ValueError as error:  # of `_no_number`
        start, message, hint = max(text.find(str(error)), 0), f"{error} is no number of JSON", "write the number"
    reading.wrong(_span(reading.page, starts, min(start, max(len(text) - 1, 0))), message, hint)
    raise UnreadableLoadError(reading.mistakes)


def _span(page: Page, starts: tuple[int, ...], start: int) -> Span:
    line = min(bisect_right(starts, start) - 1, len(page.lines) - 1)
    return page.span(line, min(start - starts[line], max(len(page.lines[line]) - 1, 0)))


def _told(node: Node) -> str:
    match node.value:
        case dict():
            return "an object"
        case list():
            return "a list"
        case str():
            return "a text"
        case Numeral(text):
            return text[:LONGEST_TOLD]
        case value:
            return json.dumps(value)
