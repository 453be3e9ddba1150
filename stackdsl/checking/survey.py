"""Paths -> what cases there are, without reading again what is remembered of files that are as they were."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TypeAlias

from stackdsl.checking.gathering import STDIN, Case, cases_of, files_under, gather, identity_of, loaded_from
from stackdsl.checking.memory import Memory
from stackdsl.diagnostics import Diagnostic
from stackdsl.reading.characters import visible
from stackdsl.reading.source import MAX_BYTES
from stackdsl.snapshots.record import Identity

FIELDS = ("scenario_name", "parameters", "system", "tags", "lines")


class ChangedMeanwhileError(RuntimeError):
    """A file is another than it was a moment ago."""


@dataclass
class _File:
    """A file whose cases are remembered."""

    path: Path
    digest: str  # of its text then

    @cached_property
    def cases(self) -> Mapping[Identity, Case]:
        """Its cases, compiled. Raises ChangedMeanwhileError."""
        loaded = loaded_from(self.path)
        cases, mistakes = cases_of(loaded)
        if mistakes or loaded.digest != self.digest:
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
        found = _File(path, _digest_of(path))
        key = memory.key("file", visible(path.as_posix()), found.digest)
        if found.digest and (entries := _recalled(memory.recall(key), found)):
            names += {entry.scenario_name for entry in entries}
            digests[entries[0].file] = found.digest
            cases += entries
            continue
        loaded = loaded_from(path)
        own, mistakes = cases_of(loaded)
        diagnostics += mistakes
        cases += own
        names += [str(source.values.get("scenario")) for source in loaded.sources]
        digests |= {source.file: loaded.digest for source in loaded.sources}
        if not mistakes and loaded.digest == found.digest:
            memory.remember(key, [_record(case) for case in own])
    if len(set(names)) < len(names):  # two scenarios of one name are told with both places, so all are read
        gathered = gather(paths)
        return Surveyed(gathered.cases, gathered.diagnostics, {})
    return Surveyed(tuple(cases), tuple(diagnostics), digests)


def _digest_of(path: Path) -> str:
    """The digest of a file's text; empty where it cannot be read, or is not to be."""
    if path == STDIN or not path.is_file():
        return ""
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError:
        return ""
    return sha256(data).hexdigest()


def _record(case: Case) -> list[object]:
    return [getattr(case, name) for name in FIELDS]


def _recalled(value: object, file: _File) -> list[Entry]:
    """The cases that a record tells of; none if it tells of none."""
    return list(_entries(value, file)) if isinstance(value, list) else []


def _entries(records: Iterable[list[object]], file: _File) -> Iterator[Entry]:
    shown = visible(file.path.as_posix())
    for scenario, parameters, system, tags, lines in records:
        assert isinstance(parameters, list)
        assert isinstance(tags, list)
        assert isinstance(lines, list)
        chosen = tuple((str(name), str(text)) for name, text in parameters)
        yield Entry(file, shown, str(scenario), chosen, str(system), tuple(map(str, tags)), (lines[0], lines[1]))
