"""Selects cases by name, tag, system and keyword expression."""

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from typing import Final, Protocol, Self, TypeAlias, TypeVar

from stackdsl.checking.cases import SUFFIXES
from stackdsl.diagnostics import did_you_mean
from stackdsl.simulation.systems import SYSTEMS

# The expression of `-k`: words joined by `and`, `or`, `not` and parentheses, as in pytest.
#
# A word is whatever holds no space and no parenthesis, or anything in quotes, and is true of a name that contains it,
# whatever its case.


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


# Which of the cases found are played, and why there may be none.


class Selectable(Protocol):
    """What a case is selected by."""

    @property
    def name(self) -> str:
        """What people call it."""

    @property
    def scenario_name(self) -> str:
        """Of its scenario."""

    @property
    def parameters(self) -> tuple[tuple[str, str], ...]:
        """The choice from each row of `matrix`, as written."""

    @property
    def system(self) -> str:
        """What it is played on."""

    @property
    def tags(self) -> tuple[str, ...]:
        """Of its scenario."""

    @property
    def file(self) -> str:
        """The file of its scenario, as it is told."""

    @property
    def lines(self) -> tuple[int, int]:
        """The first and the last line of its scenario."""

    def on(self, system: str) -> Self:
        """The same on another system."""


Some = TypeVar("Some", bound=Selectable)


@dataclass(frozen=True, slots=True)
class Shard:
    """One of several parts of all cases; to which one a case belongs, its name alone decides."""

    number: int  # from 1
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def takes(self, name: str) -> bool:
        """Whether a case of this name belongs to it."""
        return int.from_bytes(sha256(name.encode()).digest()[:8], "big") % self.count == self.number - 1


@dataclass(frozen=True, slots=True)
class Selection:
    """Which cases to play; empty parts select everything."""

    systems: tuple[str, ...] = ()
    keyword: str = ""  # an expression of words that the name holds
    tags: tuple[str, ...] = ()  # any of these; with `!` in front: none of these
    places: tuple[tuple[str, int], ...] = ()  # lines of files; of a file with places, only what is there
    names: Collection[str] | None = field(default=None, compare=False)  # only these, as somebody remembers them
    shard: Shard | None = None

    def of(self, cases: Sequence[Some]) -> list[Some]:
        """The cases selected, and where a peer is asked for, each variant on it as well, after its own systems."""
        peers = [system for system in self.systems if system not in SYSTEMS]
        return [
            case
            for _, own in groupby(cases, key=lambda case: (case.scenario_name, case.parameters))
            for case in _with(peers, list(own))
            if self.takes(case)
        ]

    def takes(self, case: Selectable) -> bool:
        """Whether a case is selected."""
        wanted = {tag for tag in self.tags if not tag.startswith("!")}
        unwanted = {tag[1:] for tag in self.tags if tag.startswith("!")}
        own = set(case.tags)
        return (
            (not self.systems or case.system in self.systems)
            and expression_of(self.keyword)(case.name.casefold())
            and (not wanted or bool(wanted & own))
            and not unwanted & own
            and self._is_there(case)
            and (self.names is None or case.name in self.names)
            and (self.shard is None or self.shard.takes(case.name))
        )

    def _is_there(self, case: Selectable) -> bool:
        lines = [line for file, line in self.places if file == case.file]
        return not lines or any(case.lines[0] <= line <= case.lines[1] for line in lines)


def _with(peers: Iterable[str], cases: Sequence[Some]) -> list[Some]:
    """The cases of one variant, also on these systems."""
    return [*cases, *(cases[0].on(peer) for peer in peers)]


def why_nothing(selection: Selection, cases: Sequence[Selectable], paths: Sequence[Path]) -> str:
    """Why nothing is selected of these cases, which were found under some paths, and what to do about it."""
    if not cases:
        where = ", ".join(map(str, paths))
        written = f"scenarios are in files that end in {' or '.join(SUFFIXES)}, and `stackdsl new NAME` writes one"
        return f"nothing selected: there is no scenario in {where}; {written}"
    reasons = list(_reasons(selection, cases)) or ["no case meets all that is asked for together"]
    return f"nothing selected: {'; '.join(reasons)}; `stackdsl check --list` names what there is"


def _reasons(selection: Selection, cases: Sequence[Selectable]) -> Iterator[str]:
    """What is asked for and no case has."""
    if not any(Selection(keyword=selection.keyword).takes(case) for case in cases):
        yield from _words_of_no_name(selection.keyword, cases)
    known = sorted({tag for case in cases for tag in case.tags})
    for tag in selection.tags:
        if not tag.startswith("!") and tag not in known:
            yield f"no scenario has the tag '{tag}'{_in_brackets(did_you_mean(tag, known))}"
    if selection.systems and not Selection(selection.systems).of(cases):
        yield f"none is played on {' or '.join(selection.systems)}, which a scenario says by `systems:`"
    for file, line in selection.places:
        if not any(replace(Selection(), places=((file, line),)).takes(case) for case in cases if case.file == file):
            yield f"no scenario of {file} is at line {line}"
    if selection.shard is not None and replace(selection, shard=None).of(cases):
        yield f"of so few cases, none is in part {selection.shard}"


def _words_of_no_name(keyword: str, cases: Sequence[Selectable]) -> Iterator[str]:
    names = {case.name.casefold() for case in cases}
    known = sorted({case.scenario_name for case in cases})
    words = [word for word in words_of(expression_of(keyword)) if not any(word in name for name in names)]
    for word in words:
        yield f"no case has '{word}' in its name{_in_brackets(did_you_mean(word, known))}"
    if not words:
        yield f"no name is as '{keyword}' says"


def _in_brackets(remark: str) -> str:
    return f" ({remark})" if remark else ""
