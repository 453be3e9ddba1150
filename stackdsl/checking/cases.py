"""Paths -> cases: every scenario of every file, in every variant, on every system."""

import json
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from typing import Final, TypeAlias

from stability.process_settings import uncollected
from stackdsl.asked_files import read_asked
from stackdsl.checking.cache import ResultCache
from stackdsl.compiler.compile import bricks_at_most, compile_timeline
from stackdsl.diagnostics import Diagnostic, Span, once
from stackdsl.disk import LeadsOutsideError, leads_outside, read_file
from stackdsl.goldens.snapshot import Identity
from stackdsl.importers.expansion import expand_file
from stackdsl.importers.formats import MAX_IMPORTED
from stackdsl.language.repeats import compact
from stackdsl.language.schema import Scenario
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, expand
from stackdsl.language.yaml.includes import Library, root_of
from stackdsl.language.yaml.source import MAX_BYTES, Loaded, Source, load, parsed
from stackdsl.project_file import OWN_FILE, confined, home_of
from stackdsl.shown_text import visible
from stackdsl.timeline import Timeline

# Paths -> cases: every scenario of every file, in every variant, on every system that it names.


SUFFIXES = (".yaml", ".yml")  # or in capitals
STDIN: Final = Path("-")  # in place of a file
STDIN_SHOWN: Final = "<stdin>"
MAX_BRICKS = 100_000  # in all variants of a scenario; some seconds of compiling, and some hundred megabytes


@dataclass(frozen=True, slots=True)
class Case:
    """One scenario in one variant on one system, ready to be played."""

    source: Source  # with what is repeated written out
    scenario: Scenario
    variant: Variant
    timeline: Timeline
    system: str
    written: Source  # as it stands in the file, and in those that it takes from
    lines: tuple[int, int] = (1, sys.maxsize)  # of the file, from what ends the scenario before to its own last

    @property
    def scenario_name(self) -> str:
        """Of its scenario."""
        return self.scenario.scenario

    @property
    def parameters(self) -> tuple[tuple[str, str], ...]:
        """The choice from each row of `matrix`, as written."""
        return self.variant.parameters

    @property
    def tags(self) -> tuple[str, ...]:
        """Of its scenario."""
        return self.scenario.tags

    @property
    def file(self) -> str:
        """The file of its scenario, as it is told."""
        return self.source.file

    def on(self, system: str) -> "Case":
        """The same on another system."""
        return replace(self, system=system)

    def compiled(self) -> "Case":
        """Itself: it is ready."""
        return self

    @property
    def is_sampled(self) -> bool:
        """Whether many samples of it are judged, rather than the one that is designed."""
        return self.scenario.samples is not None

    @property
    def skip(self) -> str | None:
        """Why its author does not want it played; None if he does."""
        mark = self.scenario.skip
        return mark.reason if mark is not None and mark.is_of(self.system) else None

    @property
    def is_unread(self) -> bool:
        """Whether it is made of what cannot be read here, so that no more is known of it than its name."""
        mark = self.scenario.skip
        return mark is not None and mark.without is not None and mark.is_of(self.system)

    @property
    def identity(self) -> Identity:
        """What it is called: `stepped-column`, `step=10mm,thesis`, `thesis`."""
        return identity_of(self.scenario.scenario, self.parameters, self.system)

    @property
    def name(self) -> str:
        """What people call it: the scenario, then the variant in brackets."""
        return f"{self.identity.scenario}[{self.identity.variant}]"


def identity_of(scenario: str, parameters: Iterable[tuple[str, str]], system: str) -> Identity:
    """What a case is called, by its choices from the matrix."""
    chosen = [f"{name}={compact(text)}" for name, text in parameters]
    return Identity(scenario, ",".join([*chosen, system]), system)


@dataclass(frozen=True, slots=True)
class Gathered:
    """The cases of all scenarios without a mistake, in the order of files, scenarios, variants and systems.

    And all that is wrong with the others: what is not meant as it stands is neither played nor accepted.
    """

    cases: tuple[Case, ...]
    diagnostics: tuple[Diagnostic, ...]


def gather(paths: Iterable[Path]) -> Gathered:
    """Read, validate and compile everything under these paths; a directory stands for the YAML files below it."""
    cases: list[Case] = []
    meant, diagnostics = files_under(paths)
    library = Library()
    files = [expand_file(loaded_from(path), library) for path in meant]
    first = _first_of_shared_names(source for loaded in files for source in loaded.sources)
    for loaded in files:
        found, mistakes = cases_of(loaded)
        diagnostics += mistakes
        diagnostics += [
            _shared_name(source, first[name])
            for source in loaded.sources
            if (name := _name(source)) in first and first[name] is not source
        ]
        cases += [case for case in found if case.scenario.scenario not in first]
    return Gathered(tuple(cases), tuple(dict.fromkeys(diagnostics)))  # of a file that several take from, each once


def loaded_from(path: Path) -> Loaded:
    """What a file holds, or the standard input where `-` stands for it."""
    return _from_stdin() if path == STDIN else load(path)


@cache
def _from_stdin() -> Loaded:
    """What the standard input holds; it can be read only once."""
    return parsed(sys.stdin.buffer.read(MAX_BYTES + 1), STDIN_SHOWN)


def files_under(paths: Iterable[Path]) -> tuple[list[Path], list[Diagnostic]]:
    """The files meant by these paths, each once, by name within a directory, and what below them cannot be read.

    What is no directory is left as it is: somebody named it.
    """
    found: dict[str, Path] = {}  # by its one true path, as it was spelled first
    unreadable: list[Diagnostic] = []
    for path in paths:
        for file in _inside(path, unreadable) if _is_folder(path) else [path]:
            found.setdefault(os.path.realpath(file), file)
    return list(found.values()), unreadable


def _inside(folder: Path, unreadable: list[Diagnostic]) -> list[Path]:
    """The scenario files below a directory, by name; what cannot be read is added to `unreadable`."""
    found = []

    def missed(error: OSError) -> None:
        why = f"cannot read the directory: {error.strerror}"
        unreadable.append(_unreadable(str(error.filename), why, "let it be read, or name the files that are meant"))

    home = home_of(folder)

    def outside(path: Path) -> None:
        why, hint = "a link leads out of the project", f"remove it, or mark a folder above as the root by {OWN_FILE}"
        unreadable.append(_unreadable(path.as_posix(), why, hint))

    def is_inside(path: Path) -> bool:
        if not path.is_symlink() or not leads_outside(path, home):
            return True
        outside(path)
        return False

    try:
        confined(folder)
    except LeadsOutsideError:
        outside(folder)
        return []
    for parent, folders, names in _folders(folder, missed, is_inside):
        # A directory that is called like a scenario is a mistake worth telling.
        # And what begins with an underscore is only there for others to take from.
        alike = [file for name in (*names, *folders) if _is_named_alike(file := Path(parent, name))]
        found += [file for file in alike if not file.name.startswith("_")]
    return [file for file in sorted(found) if is_inside(file) and _can_be_read(file, unreadable)]


def _folders(
    folder: Path, missed: Callable[[OSError], None], is_inside: Callable[[Path], bool]
) -> Iterator[tuple[str, list[str], list[str]]]:
    """What `os.walk` tells, each directory once: where it is, rather than where links lead to it, if that is inside."""
    seen: set[str] = set()
    waiting = [folder]
    while waiting:
        for parent, folders, names in os.walk(waiting.pop(0), onerror=missed):
            if (true := os.path.realpath(parent)) in seen:
                folders.clear()
                continue
            seen.add(true)
            yield parent, folders, names
            links = [link for name in sorted(folders) if os.path.islink(link := os.path.join(parent, name))]
            waiting += [path for link in links if is_inside(path := Path(link))]


def _can_be_read(file: Path, unreadable: list[Diagnostic]) -> bool:
    """Whether it is no pipe and no device, of which nobody knows when they end; those are added to `unreadable`."""
    # What is a directory or not there is told when it is read.
    if os.path.isfile(file) or os.path.isdir(file) or not os.path.exists(file):
        return True
    unreadable.append(_unreadable(file.as_posix(), "it is no regular file", "move it elsewhere, or rename it"))
    return False


def _unreadable(file: str, why: str, hint: str) -> Diagnostic:
    return Diagnostic("SD001", Span(visible(file), 1, 1, 1), why, hint)


def _is_folder(path: Path) -> bool:
    return os.path.isdir(path) and not _is_named_alike(path)


def _is_named_alike(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES


@uncollected()
def cases_of(loaded: Loaded) -> tuple[list[Case], list[Diagnostic]]:
    """The cases of the scenarios of one file that are without a mistake, and the mistakes of the others."""
    cases: list[Case] = []
    mistakes = list(loaded.diagnostics)
    for source, lines in zip(loaded.sources, _lines(loaded.sources), strict=True):
        found, wrong = _source_cases(source)
        mistakes += wrong
        # A mistake in one variant may be one in the meaning of all: what its matrix says, for example.
        cases += [] if wrong else [replace(case, lines=lines) for case in found]
    return cases, list(dict.fromkeys(mistakes))


def _lines(sources: Sequence[Source]) -> Iterator[tuple[int, int]]:
    """The first and the last line of each scenario of a file, with the comments above it."""
    first = 1
    for number, source in enumerate(sources, start=1):
        own = (span.line for span in source.value_spans.values() if span.file == source.file)  # some are of others
        last = max(own) if number < len(sources) else sys.maxsize
        yield first, last
        first = last + 1


def _source_cases(source: Source) -> tuple[Sequence[Case], Sequence[Diagnostic]]:
    """The cases of one scenario, and its mistakes, each told once however many variants share it."""
    variants, malformed = expand(source)
    cases: list[Case] = []
    mistakes = dict.fromkeys(malformed)
    validated = [(variant, *validate(variant.source, variant)) for variant in variants]
    bricks = sum(bricks_at_most(scenario) for _, scenario, _ in validated if scenario is not None)
    if bricks > MAX_BRICKS and len(validated) > 1:
        message = f"the variants have up to {bricks} bricks in all, and {MAX_BRICKS} is the most"
        hint = "make several scenarios of it"
        key = "matrix" if "matrix" in source.values else "cases"
        return [], (*mistakes, Diagnostic("SD206", source.key_span_of((key,)), message, hint))
    for variant, scenario, wrong in validated:
        mistakes |= dict.fromkeys(wrong)
        if scenario is not None:
            timeline, misfits = compile_timeline(scenario, variant.source)
            mistakes |= dict.fromkeys(misfits)
            if timeline is not None:
                cases += [
                    Case(variant.source, scenario, variant, timeline, system, source) for system in scenario.systems
                ]
    return cases, tuple(once(mistakes))


def _first_of_shared_names(sources: Iterable[Source]) -> Mapping[str, Source]:
    """By each name that several scenarios have, the first of them; golden files are called by it."""
    named: defaultdict[str, list[Source]] = defaultdict(list)
    for source in sources:
        named[_name(source)].append(source)
    return {name: namesakes[0] for name, namesakes in named.items() if name and len(namesakes) > 1}


def _name(source: Source) -> str:
    """The name of a scenario; empty where it has none, which is told elsewhere."""
    name = source.values.get("scenario")
    return name if isinstance(name, str) else ""


def _shared_name(source: Source, first: Source) -> Diagnostic:
    there = first.span_of(("scenario",))
    message = f"two scenarios are called '{_name(source)}', so that neither is played; the other one is at {there}"
    hint = "give this one another name: -k and golden files know scenarios by their names"
    return Diagnostic("SD203", source.span_of(("scenario",)), message, hint)


# Paths -> what cases there are, without reading again what is remembered of files that are as they were.


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
    loaded = expand_file(read, parts)
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
class CaseEntry:
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

    def on(self, system: str) -> "CaseEntry":
        """The same on another system."""
        return replace(self, system=system, peer=self.peer or self.system)

    def compiled(self) -> Case:
        """The case itself. Raises ChangedMeanwhileError."""
        own = identity_of(self.scenario_name, self.parameters, self.peer or self.system)
        try:
            return self.origin.cases[own].on(self.system)
        except KeyError as error:
            raise ChangedMeanwhileError(f"{self.file} has changed while it was read: call again") from error


Listed: TypeAlias = Case | CaseEntry


@dataclass(frozen=True, slots=True)
class Surveyed:
    """The cases of all scenarios without a mistake, compiled or remembered, and all that is wrong with the others."""

    cases: tuple[Listed, ...]
    diagnostics: tuple[Diagnostic, ...]
    digests: Mapping[str, str]  # of the text of each file that could be read, by what it is called


def survey(paths: Sequence[Path], memory: ResultCache) -> Surveyed:
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


def _recalled(value: object, path: Path, own: str) -> list[CaseEntry]:
    """The cases that a record tells of, if what they took from other files is as it was; none if it tells of none."""
    if not isinstance(value, dict):
        return []
    try:
        file = _File(path, _Made(own, root_of(str(path)), value["parts"]))
        return list(_entries(value["cases"], file)) if file.made.is_current else []
    except (AssertionError, LookupError, TypeError, ValueError):  # whoever sent the project may have written it
        return []


def _entries(records: Iterable[list[object]], file: _File) -> Iterator[CaseEntry]:
    shown = visible(file.path.as_posix())
    for scenario, parameters, system, tags, lines in records:
        assert isinstance(parameters, list)
        assert isinstance(tags, list)
        assert isinstance(lines, list)
        chosen = tuple((str(name), str(text)) for name, text in parameters)
        yield CaseEntry(file, shown, str(scenario), chosen, str(system), tuple(map(str, tags)), (lines[0], lines[1]))
