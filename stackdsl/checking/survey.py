"""Paths -> what cases there are, without reading again what is remembered of files that are as they were."""

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TypeAlias

from stackdsl.asked_files import read_asked
from stackdsl.checking.gathering import STDIN, Case, cases_of, files_under, gather, identity_of, loaded_from
from stackdsl.checking.memory import Memory
from stackdsl.diagnostics import Diagnostic
from stackdsl.disk import read_file
from stackdsl.importing.expansion import whole
from stackdsl.importing.load_formats import MAX_IMPORTED
from stackdsl.reading.composing import Library
from stackdsl.reading.project import root_of
from stackdsl.reading.source import Loaded
from stackdsl.shown_text import visible
from stackdsl.snapshots.record import Identity

FIELDS = ("scenario_name", "parameters", "system", "tags", "lines")


class ChangedMeanwhileError(RuntimeError):
    """A file is another than it was a moment ago."""


@dataclass
class _Parts(Library):
    """The files that one file takes from, what they held, and where in the project they truly are."""

    root: str = ""
    digests: dict[str, str] = field(default_factory=dict)  # by the path that was asked for, links and all

    def read(self, path: str, root: str) -> Loaded:
        """What a file holds; that it was asked for is noted."""
        loaded = super().read(path, root)
        self.digests[path] = _digest_there(path, self.root, loaded.digest)
        return loaded

    def bytes_of(self, path: str, most: int, root: str) -> bytes:
        """What a file of another program holds; that it was asked for is noted."""
        data = super().bytes_of(path, most, root)
        self.digests[path] = _digest_there(path, self.root, sha256(data).hexdigest())
        return data


@dataclass(frozen=True, slots=True)
class _Made:
    """Which texts a file's scenarios were made of."""

    own: str  # digest of the file itself
    root: str = ""  # of the project, beyond which no file leads
    parts: Mapping[str, str] = field(default_factory=dict)  # of the others, by path

    @property
    def digest(self) -> str:
        """One digest of all; empty where the file itself could not be read."""
        return sha256(json.dumps([self.own, *sorted(self.parts.items())]).encode()).hexdigest() if self.own else ""

    @property
    def is_current(self) -> bool:
        """Whether the others are as they were."""
        now = {path: _digest_there(path, self.root, _digest_of(Path(path), self.root)) for path in self.parts}
        return now == self.parts and all(now.values())


def _compiled(path: Path) -> tuple[Loaded, _Made, list[Case], list[Diagnostic]]:
    """What a file holds, which texts that is made of, and its cases and mistakes."""
    parts = _Parts(root=root_of(str(path)))
    read = loaded_from(path)
    loaded = whole(read, parts)
    return loaded, _Made(read.digest, parts.root, parts.digests), *cases_of(loaded)


@dataclass
class _File:
    """A file whose cases are remembered."""

    path: Path
    made: _Made  # then

    @cached_property
    def cases(self) -> Mapping[Identity, Case]:
        """Its cases, compiled. Raises ChangedMeanwhileError."""
        _, made, cases, mistakes = _compiled(self.path)
        if mistakes or made.digest != self.made.digest:
            raise ChangedMeanwhileError(f"{self.path} has changed while it was read: call again")
        return {case.identity: case for case in cases}


@dataclass(frozen=True, slots=True)
class Entry:
    """A case that is known by name, and compiled where it must be."""

    origin: _File = field(repr=False)
    file: str
    scenario_name: str
    parameters: tuple[tuple[str, str], ...]
    system: str
    tags: tuple[str, ...]
    lines: tuple[int, int]
    peer: str = ""  # in the place of `system`

    @property
    def identity(self) -> Identity:
        """What it is called."""
        return identity_of(self.scenario_name, self.parameters, self.system)

    @property
    def name(self) -> str:
        """What people call it: the scenario, then the variant in brackets."""
        return f"{self.scenario_name}[{self.identity.variant}]"

    def on(self, system: str) -> "Entry":
        """The same on another system."""
        return replace(self, system=system, peer=self.peer or self.system)

    def compiled(self) -> Case:
        """The case itself. Raises ChangedMeanwhileError."""
        own = identity_of(self.scenario_name, self.parameters, self.peer or self.system)
        try:
            return self.origin.cases[own].on(self.system)
        except KeyError as error:
            raise ChangedMeanwhileError(f"{self.file} has changed while it was read: call again") from error


Listed: TypeAlias = Case | Entry


@dataclass(frozen=True, slots=True)
class Surveyed:
    """The cases of all scenarios without a mistake, compiled or remembered, and all that is wrong with the others."""

    cases: tuple[Listed, ...]
    diagnostics: tuple[Diagnostic, ...]
    digests: Mapping[str, str]  # of the text of each file that could be read, by what it is called


def survey(paths: Sequence[Path], memory: Memory) -> Surveyed:
    """All cases under these paths, as `gather` finds them; of files that are as they were, only their names."""
    meant, diagnostics = files_under(paths)
    cases: list[Listed] = []
    names: list[str] = []
    digests: dict[str, str] = {}
    for path in meant:
        shown, own = visible(path.as_posix()), _digest_of(path)
        key = memory.key("file", shown, own)
        if own and (known := _recalled(memory.recall(key), path, own)):
            names += {(entry.scenario_name, entry.lines): entry.scenario_name for entry in known}.values()
            digests[shown] = known[0].origin.made.digest
            cases += known
            continue
        loaded, made, compiled, mistakes = _compiled(path)
        diagnostics += mistakes
        cases += compiled
        names += [str(source.values.get("scenario")) for source in loaded.sources]
        digests |= {source.file: made.digest for source in loaded.sources}
        if not mistakes and made.own == own:
            memory.remember(key, {"parts": dict(made.parts), "cases": [_record(case) for case in compiled]})
    if len(set(names)) < len(names):  # two scenarios of one name are told with both places, so all are read
        gathered = gather(paths)
        return Surveyed(gathered.cases, gathered.diagnostics, {})
    return Surveyed(tuple(cases), tuple(dict.fromkeys(diagnostics)), digests)


def _digest_of(path: Path, within: str = "") -> str:
    """The digest of a file's text; empty where it cannot be read, or is not to be."""
    if path == STDIN or not os.path.isfile(path):  # what a shell gives as a pipe can be read only once
        return ""
    try:
        data = read_file(path, MAX_IMPORTED + 1, within) if within else read_asked(path, MAX_IMPORTED + 1)
    except OSError:
        return ""
    return sha256(data).hexdigest()


def _digest_there(path: str, root: str, digest: str) -> str:
    """A digest of what a file holds and of where in the project it is; empty where it cannot be read."""
    return f"{digest} {os.path.relpath(os.path.realpath(path), root)}" if digest else ""


def _record(case: Case) -> list[object]:
    return [getattr(case, name) for name in FIELDS]


def _recalled(value: object, path: Path, own: str) -> list[Entry]:
    """The cases that a record tells of, if what they took from other files is as it was; none if it tells of none."""
    if not isinstance(value, dict):
        return []
    try:
        file = _File(path, _Made(own, root_of(str(path)), value["parts"]))
        return list(_entries(value["cases"], file)) if file.made.is_current else []
    except (AssertionError, LookupError, TypeError, ValueError):  # whoever sent the project may have written it
        return []


def _entries(records: Iterable[list[object]], file: _File) -> Iterator[Entry]:
    shown = visible(file.path.as_posix())
    for scenario, parameters, system, tags, lines in records:
        assert isinstance(parameters, list)
        assert isinstance(tags, list)
        assert isinstance(lines, list)
        chosen = tuple((str(name), str(text)) for name, text in parameters)
        yield Entry(file, shown, str(scenario), chosen, str(system), tuple(map(str, tags)), (lines[0], lines[1]))
