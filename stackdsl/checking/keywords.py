"""What `-k` takes: words joined by `and`, `or`, `not` and parentheses, as pytest reads them.

A word is whatever holds no space and no parenthesis, or anything in quotes, and is true of a name that contains it,
whatever its case.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, TypeAlias

_TOKEN: Final = re.compile(r"""\s*(?:(?P<mark>[()])|"(?P<double>[^"]*)"|'(?P<single>[^']*)'|(?P<bare>[^\s()"']+))""")
OPERATORS: Final = ("and", "or", "not")
MAX_DEPTH: Final = 64  # of parentheses


class KeywordError(ValueError):
    """An expression that is none; the message says where, counted from 1."""


@dataclass(frozen=True, slots=True)
class Word:
    """True of names that contain it."""

    text: str  # in small letters

    def __call__(self, name: str) -> bool:
        """Whether it is true of a name in small letters."""
        return self.text in name


@dataclass(frozen=True, slots=True)
class Not:
    """True where another one is not."""

    part: "Expression"

    def __call__(self, name: str) -> bool:
        """Whether it is true of a name in small letters."""
        return not self.part(name)


@dataclass(frozen=True, slots=True)
class All:
    """True where all of some are."""

    parts: tuple["Expression", ...]

    def __call__(self, name: str) -> bool:
        """Whether it is true of a name in small letters."""
        return all(part(name) for part in self.parts)


@dataclass(frozen=True, slots=True)
class AnyOf:
    """True where any of some is."""

    parts: tuple["Expression", ...]

    def __call__(self, name: str) -> bool:
        """Whether it is true of a name in small letters."""
        return any(part(name) for part in self.parts)


Expression: TypeAlias = Word | Not | All | AnyOf


@cache
def expression_of(text: str) -> Expression:
    """What a text means; nothing is true of everything. Raises KeywordError."""
    reader = _Reader(text, list(_tokens(text)))
    if not reader.tokens:
        return All(())
    found = reader.any_of()
    if reader.at < len(reader.tokens):
        raise reader.unexpected("'and' or 'or'")
    return found


def words_of(expression: Expression) -> Iterator[str]:
    """The words that are asked for, those below a `not` left out."""
    if isinstance(expression, Word):
        yield expression.text
    elif isinstance(expression, All | AnyOf):
        for part in expression.parts:
            yield from words_of(part)


@dataclass(frozen=True, slots=True)
class _Token:
    text: str
    column: int
    quoted: bool = False

    def is_one(self, *texts: str) -> bool:
        return not self.quoted and self.text in texts


def _tokens(text: str) -> Iterator[_Token]:
    at = 0
    while text[at:].strip():
        found = _TOKEN.match(text, at)
        if found is None:
            raise KeywordError(f"in '{text}' a quote is opened at column {len(text[:at].rstrip()) + 2} and not closed")
        kind = found.lastgroup or ""
        yield _Token(found[kind], found.start(kind) + 1, kind in ("double", "single"))
        at = found.end()


@dataclass(slots=True)
class _Reader:
    """Reads one expression, by the usual order: not, and, or."""

    text: str
    tokens: Sequence[_Token]
    at: int = 0
    depth: int = 0

    def any_of(self) -> Expression:
        parts = [self.all_of()]
        while self.took("or"):
            parts.append(self.all_of())
        return parts[0] if len(parts) == 1 else AnyOf(tuple(parts))

    def all_of(self) -> Expression:
        parts = [self.part()]
        while self.took("and"):
            parts.append(self.part())
        return parts[0] if len(parts) == 1 else All(tuple(parts))

    def part(self) -> Expression:
        turned = False
        while self.took("not"):
            turned = not turned
        found = self.inside() if self.took("(") else self.word()
        return Not(found) if turned else found

    def inside(self) -> Expression:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise KeywordError(f"parentheses are nested more than {MAX_DEPTH} deep")
        found = self.any_of()
        if not self.took(")"):
            raise self.unexpected("')'")
        self.depth -= 1
        return found

    def word(self) -> Expression:
        if self.at == len(self.tokens) or self.tokens[self.at].is_one(*OPERATORS, "(", ")"):
            raise self.unexpected("a word")
        self.at += 1
        return Word(self.tokens[self.at - 1].text.casefold())

    def took(self, text: str) -> bool:
        taken = self.at < len(self.tokens) and self.tokens[self.at].is_one(text)
        self.at += taken
        return taken

    def unexpected(self, wanted: str) -> KeywordError:
        there = self.at < len(self.tokens)
        what = f"'{self.tokens[self.at].text}' at column {self.tokens[self.at].column}" if there else "its end"
        return KeywordError(
            f"in '{self.text}' {wanted} is expected in place of {what}; write it like 'column and not (tuned or stock)'"
        )
