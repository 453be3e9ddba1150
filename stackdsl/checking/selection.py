"""Selects cases by name, tag, system and keyword expression."""

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from shlex import quote
from typing import Final, Protocol, Self, TypeAlias, TypeVar

from stackdsl.checking.cases import SUFFIXES
from stackdsl.diagnostics import did_you_mean
from stackdsl.simulation.systems import SYSTEMS

# The expression of `-k`: words joined by `and`, `or`, `not` and parentheses, as in pytest.
#
# A word has no spaces and no parentheses, unless it is quoted. It matches the names that contain it, in upper or lower
# case.


_TOKEN: Final = re.compile(r"""\s*(?:(?P<mark>[()])|"(?P<double>[^"]*)"|'(?P<single>[^']*)'|(?P<bare>[^\s()"']+))""")
OPERATORS: Final = ("and", "or", "not")
MAX_DEPTH: Final = 64  # of parentheses


class KeywordError(ValueError):
    """An expression is invalid; the message has the column, from 1."""


@dataclass(frozen=True, slots=True)
class Word:
    """Matches names that contain a text."""

    text: str  # in lower case

    def __call__(self, name: str) -> bool:
        """Whether the expression matches a name in lower case."""
        return self.text in name


@dataclass(frozen=True, slots=True)
class Not:
    """Matches names that another expression does not match."""

    part: "Expression"

    def __call__(self, name: str) -> bool:
        """Whether the expression matches a name in lower case."""
        return not self.part(name)


@dataclass(frozen=True, slots=True)
class All:
    """Matches names that all parts match."""

    parts: tuple["Expression", ...]

    def __call__(self, name: str) -> bool:
        """Whether the expression matches a name in lower case."""
        return all(part(name) for part in self.parts)


@dataclass(frozen=True, slots=True)
class AnyOf:
    """Matches names that any part matches."""

    parts: tuple["Expression", ...]

    def __call__(self, name: str) -> bool:
        """Whether the expression matches a name in lower case."""
        return any(part(name) for part in self.parts)


Expression: TypeAlias = Word | Not | All | AnyOf


@cache
def expression_of(text: str) -> Expression:
    """Parse an expression; an empty one matches all names. Raises KeywordError."""
    reader = _Reader(text, list(_tokens(text)))
    if not reader.tokens:
        return All(())
    expression = reader.any_of()
    if reader.at < len(reader.tokens):
        raise reader.unexpected("'and' or 'or'")
    return expression


def words_of(expression: Expression) -> Iterator[str]:
    """Yield the words of an expression, except those below a `not`."""
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
        match = _TOKEN.match(text, at)
        if match is None:
            raise KeywordError(f"in '{text}', the quote at column {len(text[:at].rstrip()) + 2} is not closed")
        kind = match.lastgroup or ""
        yield _Token(match[kind], match.start(kind) + 1, kind in ("double", "single"))
        at = match.end()


@dataclass(slots=True)
class _Reader:
    """Parses an expression with the usual precedence: not, and, or."""

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
        negated = False
        while self.took("not"):
            negated = not negated
        part = self.inside() if self.took("(") else self.word()
        return Not(part) if negated else part

    def inside(self) -> Expression:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise KeywordError(f"parentheses are nested more than {MAX_DEPTH} levels deep")
        expression = self.any_of()
        if not self.took(")"):
            raise self.unexpected("')'")
        self.depth -= 1
        return expression

    def word(self) -> Expression:
        if self.at == len(self.tokens) or self.tokens[self.at].is_one(*OPERATORS, "(", ")"):
            raise self.unexpected("a word")
        self.at += 1
        return Word(self.tokens[self.at - 1].text.casefold())

    def took(self, text: str) -> bool:
        matches = self.at < len(self.tokens) and self.tokens[self.at].is_one(text)
        self.at += matches
        return matches

    def unexpected(self, wanted: str) -> KeywordError:
        has_token = self.at < len(self.tokens)
        actual = f"'{self.tokens[self.at].text}' at column {self.tokens[self.at].column}" if has_token else "its end"
        example = "'column and not (tuned or stock)'"
        return KeywordError(f"in '{self.text}', {wanted} is expected instead of {actual}; an example is {example}")


# Selects cases, and explains an empty selection.


class Selectable(Protocol):
    """The properties by which a case is selected."""

    @property
    def name(self) -> str:
        """The displayed name."""

    @property
    def scenario_name(self) -> str:
        """The name of the scenario."""

    @property
    def parameters(self) -> tuple[tuple[str, str], ...]:
        """The value chosen from each row of `matrix`, as written."""

    @property
    def system(self) -> str:
        """The name of the system."""

    @property
    def tags(self) -> tuple[str, ...]:
        """The tags of the scenario."""

    @property
    def file(self) -> str:
        """The displayed path of the scenario's file."""

    @property
    def lines(self) -> tuple[int, int]:
        """The first and the last line of the scenario."""

    def on(self, system: str) -> Self:
        """Return this case on another system."""


Some = TypeVar("Some", bound=Selectable)


@dataclass(frozen=True, slots=True)
class Shard:
    """One of several parts of all cases. The part of a case depends only on its name."""

    number: int  # from 1
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def takes(self, name: str) -> bool:
        """Whether a case of this name belongs to the part."""
        return int.from_bytes(sha256(name.encode()).digest()[:8], "big") % self.count == self.number - 1


@dataclass(frozen=True, slots=True)
class Selection:
    """The criteria of a selection; an empty criterion selects all cases."""

    systems: tuple[str, ...] = ()
    keyword: str = ""  # expression about the name
    tags: tuple[str, ...] = ()  # select any of these; with a leading `!`, none of these
    places: tuple[tuple[str, int], ...] = ()  # files and lines; in these files, only the scenarios at the lines
    names: Collection[str] | None = field(default=None, compare=False)  # such as those of recorded failures
    shard: Shard | None = None

    def of(self, cases: Sequence[Some]) -> list[Some]:
        """Return the selected cases; each variant also on the peers among `systems`, after its own systems."""
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
    """Return the cases of one variant, followed by the variant on the peers."""
    return [*cases, *(cases[0].on(peer) for peer in peers)]


def nothing_selected_text(selection: Selection, cases: Sequence[Selectable], paths: Sequence[Path]) -> str:
    """Return the message for an empty selection from the cases under some paths, with its reasons and a remedy."""
    if not cases:
        where = ", ".join(map(str, paths))
        hint = f"scenario files end in {' or '.join(SUFFIXES)}; `stackdsl new NAME` creates one"
        return f"nothing selected: no scenario in {where}; {hint}"
    reasons = list(_reasons(selection, cases)) or ["no case meets all criteria together"]
    listing = " ".join(["stackdsl check", *(quote(str(path)) for path in paths), "--list"])
    return f"nothing selected: {'; '.join(reasons)}; `{listing}` lists all cases"


def _reasons(selection: Selection, cases: Sequence[Selectable]) -> Iterator[str]:
    """Yield the criteria that no case meets."""
    if not any(Selection(keyword=selection.keyword).takes(case) for case in cases):
        yield from _unmatched_words(selection.keyword, cases)
    tags = sorted({tag for case in cases for tag in case.tags})
    for tag in selection.tags:
        if not tag.startswith("!") and tag not in tags:
            remedy = did_you_mean(tag, tags) if tags else f"none has a tag; add `tags: [{tag}]` to a scenario"
            yield f"no scenario has the tag '{tag}'{_in_brackets(remedy)}"
    if selection.systems and not Selection(selection.systems).of(cases):
        own = ", ".join(sorted({case.system for case in cases}))
        wanted = ", ".join(selection.systems)
        yield f"no scenario has {' or '.join(selection.systems)} among its `systems` ({own}); add `systems: [{wanted}]`"
    for file, line in selection.places:
        if not any(replace(Selection(), places=((file, line),)).takes(case) for case in cases if case.file == file):
            yield f"no scenario of {file} is at line {line}"
    if selection.shard is not None and replace(selection, shard=None).of(cases):
        yield f"no case belongs to shard {selection.shard}"


def _unmatched_words(keyword: str, cases: Sequence[Selectable]) -> Iterator[str]:
    names = {case.name.casefold() for case in cases}
    scenarios = sorted({case.scenario_name for case in cases})
    words = [word for word in words_of(expression_of(keyword)) if not any(word in name for name in names)]
    for word in words:
        yield f"no case has '{word}' in its name{_in_brackets(did_you_mean(word, scenarios))}"
    if not words:
        yield f"no name matches '{keyword}'"


def _in_brackets(remark: str) -> str:
    return f" ({remark})" if remark else ""
