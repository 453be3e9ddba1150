"""Expands paths to cases: every scenario of every file, in every variant, on every system."""

import json
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import FrozenInstanceError, dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn, TypeAlias

from stability.notebook import Displayed
from stability.process_settings import uncollected
from stackdsl.checking.cache import ResultCache
from stackdsl.compiler.compile import bricks_at_most, compile_timeline
from stackdsl.diagnostics import Diagnostic, Span, unknown_attribute, without_duplicates
from stackdsl.disk import NOT_REGULAR, Content, LeadsOutsideError, leads_outside, read_file, with_digest
from stackdsl.goldens.snapshot import Identity
from stackdsl.importers.expansion import expand_file
from stackdsl.importers.formats import MAX_IMPORTED
from stackdsl.language.repeats import compact
from stackdsl.language.schema import Scenario
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, expand, unused_kinds, variables_of
from stackdsl.language.yaml.includes import Library, root_of
from stackdsl.language.yaml.source import MAX_BYTES, Loaded, Source, load, parsed
from stackdsl.project_file import OWN_FILE, confined, home_of
from stackdsl.shown_text import visible
from stackdsl.timeline import Timeline
from stackdsl.user_files import read_user_file

SUFFIXES = (".yaml", ".yml")  # in any case
STDIN: Final = Path("-")
STDIN_SHOWN: Final = "<stdin>"
MAX_BRICKS = 100_000  # in all variants of a scenario; takes some seconds and some hundred megabytes to compile


PICTURES: Final = ("animate", "draw", "html", "picture", "plot", "render", "replay", "show", "view")  # guessed names
FUNCTIONS_OF_A_CASE: Final = ("play", "find", "fragility", "margins", "sensitivities", "survive", "sweep")  # in Python


@dataclass(frozen=True, slots=True, repr=False)
class Case(Displayed):
    """One scenario in one variant on one system, ready to be played."""

    source: Source  # with all repeats expanded
    scenario: Scenario
    variant: Variant
    timeline: Timeline
    system: str
    written: Source  # as written in the file and its includes
    lines: tuple[int, int] = (1, sys.maxsize)  # of the file, from the line after the previous scenario to its last

    @property
    def scenario_name(self) -> str:
        """The name of the scenario."""
        return self.scenario.scenario

    @property
    def parameters(self) -> tuple[tuple[str, str], ...]:
        """The value chosen from each row of `matrix`, as written."""
        return self.variant.parameters

    @property
    def variables(self) -> dict[str, dict[str, float | str | None]]:
        """The value chosen from each row of `matrix`: `written`, `number` and `unit`, and `si`, its value in SI.

        The last three are None for a word.
        """
        from stackdsl.language.quantities import quantity_of  # noqa: PLC0415 -- slow to import

        return {name: quantity_of(written) for name, written in self.parameters}

    @property
    def tags(self) -> tuple[str, ...]:
        """The tags of the scenario."""
        return self.scenario.tags

    @property
    def file(self) -> str:
        """The displayed path of the scenario's file."""
        return self.source.file

    @property
    def is_in_file(self) -> bool:
        """Return true if commands on its file select this case: it is YAML, and no variable has a value from Python."""
        places = (self.written.value_spans.get(("matrix", name)) for name, _ in self.parameters)
        in_yaml = self.file == STDIN_SHOWN or Path(self.file).suffix.lower() in SUFFIXES
        return in_yaml and not any(place is not None and place.key for place in places)

    def on(self, system: str) -> "Case":
        """Return this case on another system."""
        return replace(self, system=system)

    def compiled(self) -> "Case":
        """Return this case, which is compiled already."""
        return self

    @property
    def is_sampled(self) -> bool:
        """Whether random samples are judged instead of the exact design."""
        return self.scenario.samples is not None

    @property
    def skip(self) -> str | None:
        """Why the author skips this case; None to run it."""
        mark = self.scenario.skip
        return mark.reason if mark is not None and mark.is_of(self.system) else None

    @property
    def is_unread(self) -> bool:
        """Whether an optional package is missing that its imports need, so that only its name is known."""
        mark = self.scenario.skip
        return mark is not None and mark.without is not None and mark.is_of(self.system)

    @property
    def identity(self) -> Identity:
        """The identity of the case: `stepped-column`, `step=10mm,thesis`, `thesis`."""
        return identity_of(self.scenario.scenario, self.parameters, self.system)

    @property
    def name(self) -> str:
        """The displayed name: the scenario, then the variant in brackets."""
        return f"{self.identity.scenario}[{self.identity.variant}]"

    def __repr__(self) -> str:
        """Return the name; all fields would fill pages."""
        return f"<Case {self.name}>"

    if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which says which function of `stackdsl` to call."""
            remedies = {each: f"write `{each}(case)` with {each} of stackdsl" for each in FUNCTIONS_OF_A_CASE}
            remedies |= dict.fromkeys(
                PICTURES, "a notebook shows the replay of a run; write `play(case)` as the last line of a cell"
            )
            remedies |= dict.fromkeys(
                ("with_", "replace", "set"), "write `load(path, step=...)` for another value of the variable `step`"
            )
            raise unknown_attribute(self, name, remedies)


def _refuse_change(case: Case, name: str, value: object) -> NoReturn:
    """Raise FrozenInstanceError, which says how to get a case with another number."""
    variables = list(dict.fromkeys(variables_of(case.variant)))
    example = name if name in variables else next(iter(variables), "step")
    remedy = f"`load(path, {example}=...)` for a case with another value of the variable '{example}'"
    remedy += "" if variables else ", which the scenario needs under `let`"
    if name == "system":
        remedy = f"`case.on({value!r})`"
    raise FrozenInstanceError(f"a case cannot be changed, so '{name}' cannot be set; write {remedy}")


# For names of no field, a frozen class with slots raises a TypeError about `super` (CPython issue 90562).
Case.__setattr__ = _refuse_change  # type: ignore[method-assign,assignment]


@cache
def identity_of(scenario: str, parameters: tuple[tuple[str, str], ...], system: str) -> Identity:
    """Return the identity of a case with the given choices from the matrix."""
    chosen = [f"{name}={compact(text)}" for name, text in parameters]
    return Identity(scenario, ",".join([*chosen, system]), system)


@dataclass(frozen=True, slots=True)
class GatheredCases:
    """The cases of all valid scenarios, in the order of files, scenarios, variants and systems.

    The diagnostics are those of the invalid scenarios, which have no cases.
    """

    cases: tuple[Case, ...]
    diagnostics: tuple[Diagnostic, ...]


def gather(paths: Iterable[Path]) -> GatheredCases:
    """Read, validate and compile all scenarios in these paths; a directory includes all YAML files below it."""
    cases: list[Case] = []
    paths_of_files, diagnostics = files_under(paths)
    library = Library()
    files = [expand_file(loaded_from(path), library) for path in paths_of_files]
    first = _first_of_shared_names(source for loaded in files for source in loaded.sources)
    for loaded in files:
        compiled, mistakes = cases_of(loaded)
        diagnostics += mistakes
        diagnostics += [
            shared_name(source, first[name])
            for source in loaded.sources
            if (name := _name(source)) in first and first[name] is not source
        ]
        cases += [case for case in compiled if case.scenario.scenario not in first]
    return GatheredCases(tuple(cases), tuple(dict.fromkeys(diagnostics)))  # a shared include repeats its diagnostics


def loaded_from(path: Path, content: Content | None = None) -> Loaded:
    """Load a file, or the standard input for `-`; `content` is that of the file if it was read before."""
    return _from_stdin() if path == STDIN else load(path, content=content)


@cache
def _from_stdin() -> Loaded:
    """Load the standard input, which can be read only once."""
    return parsed(with_digest(sys.stdin.buffer.read(MAX_BYTES + 1)), STDIN_SHOWN)


def files_under(paths: Iterable[Path]) -> tuple[list[Path], list[Diagnostic]]:
    """Return the scenario files under these paths, each once and sorted within a directory, and the unreadable ones.

    A path that is not a directory is returned as it is.
    """
    files: dict[str, Path] = {}  # by real path, as first spelled
    unreadable: list[Diagnostic] = []
    for path in paths:
        for file in _inside(path, unreadable) if _is_folder(path) else [path]:
            files.setdefault(os.path.realpath(file), file)
    return list(files.values()), unreadable


def _inside(folder: Path, unreadable: list[Diagnostic]) -> list[Path]:
    """Return the scenario files below a directory, sorted; add a diagnostic to `unreadable` for each unreadable one."""
    files = []

    def report(error: OSError) -> None:
        why = f"cannot read the directory: {error.strerror}"
        unreadable.append(_unreadable(str(error.filename), why, "make it readable, or name the files"))

    home = home_of(folder)

    def report_outside(path: Path) -> None:
        why, hint = "a link leads out of the project", f"remove it, or put {OWN_FILE} into a common parent folder"
        unreadable.append(_unreadable(path.as_posix(), why, hint))

    def is_inside(path: Path) -> bool:
        if not path.is_symlink() or not leads_outside(path, home):
            return True
        report_outside(path)
        return False

    try:
        confined(folder)
    except LeadsOutsideError:
        report_outside(folder)
        return []
    for parent, folders, names in _folders(folder, report, is_inside):
        # A directory with the name of a scenario is reported later as a mistake.
        candidates = [file for name in (*names, *folders) if _has_scenario_suffix(file := Path(parent, name))]
        # A leading underscore marks files that others include.
        files += [file for file in candidates if not file.name.startswith("_")]
    return [file for file in sorted(files) if is_inside(file) and _can_be_read(file, unreadable)]


def _folders(
    folder: Path, on_error: Callable[[OSError], None], is_inside: Callable[[Path], bool]
) -> Iterator[tuple[str, list[str], list[str]]]:
    """Walk a directory like `os.walk`; follow links inside the project, and visit each directory once."""
    seen: set[str] = set()
    waiting = [folder]
    while waiting:
        for parent, folders, names in os.walk(waiting.pop(0), onerror=on_error):
            if (real := os.path.realpath(parent)) in seen:
                folders.clear()
                continue
            seen.add(real)
            yield parent, folders, names
            links = [link for name in sorted(folders) if os.path.islink(link := os.path.join(parent, name))]
            waiting += [path for link in links if is_inside(path := Path(link))]


def _can_be_read(file: Path, unreadable: list[Diagnostic]) -> bool:
    """Whether a path is not a pipe or a device, which may never end; add a diagnostic to `unreadable` otherwise."""
    # Reading reports directories and missing files.
    if os.path.isfile(file) or os.path.isdir(file) or not os.path.exists(file):
        return True
    unreadable.append(_unreadable(file.as_posix(), NOT_REGULAR, "move it elsewhere, or rename it"))
    return False


def _unreadable(file: str, why: str, hint: str) -> Diagnostic:
    return Diagnostic("SD001", Span(visible(file), 1, 1, 1), why, hint)


def _is_folder(path: Path) -> bool:
    return os.path.isdir(path) and not _has_scenario_suffix(path)


def _has_scenario_suffix(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES


@uncollected()
def cases_of(loaded: Loaded) -> tuple[list[Case], list[Diagnostic]]:
    """Return the cases of the valid scenarios of a file, and the mistakes of the others."""
    cases: list[Case] = []
    mistakes = list(loaded.diagnostics)
    for source, lines in zip(loaded.sources, _lines(loaded.sources), strict=True):
        compiled, own_mistakes = _source_cases(source)
        # An ambiguous word, such as `yes`, is a mistake at its place, which says what to write; or text is permitted.
        explained = {mistake.span for mistake in own_mistakes}
        for word in set(source.ambiguous).intersection(mistakes):  # not of a base that is handled already
            position = mistakes.index(word)
            quoted = replace(word, hint=f'quote it: "{word.span.text}"')
            mistakes[position : position + 1] = [] if word.span in explained else [quoted]
        mistakes += own_mistakes
        # A mistake in one variant may affect all, such as one in the matrix.
        cases += [] if own_mistakes or source.ambiguous else [replace(case, lines=lines) for case in compiled]
    return cases, list(dict.fromkeys(mistakes))


def _lines(sources: Sequence[Source]) -> Iterator[tuple[int, int]]:
    """Yield the first and last line of each scenario of a file, including the comments above it."""
    first = 1
    for number, source in enumerate(sources, start=1):
        own = (span.line for span in source.value_spans.values() if span.file == source.file)  # without includes
        last = max(own) if number < len(sources) else sys.maxsize
        yield first, last
        first = last + 1


def _source_cases(source: Source) -> tuple[Sequence[Case], Sequence[Diagnostic]]:
    """Return the cases of one scenario, and its mistakes without repetition."""
    variants, malformed = expand(source)
    cases: list[Case] = []
    mistakes = dict.fromkeys(malformed)
    validated = [(variant, *validate(variant.source, variant)) for variant in variants]
    bricks = sum(bricks_at_most(scenario) for _, scenario, _ in validated if scenario is not None)
    if bricks > MAX_BRICKS and len(validated) > 1:
        message = f"the variants have up to {bricks} bricks in total; at most {MAX_BRICKS} are allowed"
        hint = "split it into several scenarios"
        key = "matrix" if "matrix" in source.values else "cases"
        return [], (*mistakes, Diagnostic("SD206", source.key_span_of((key,)), message, hint))
    for variant, scenario, invalid in validated:
        mistakes |= dict.fromkeys(invalid)
        if scenario is not None:
            timeline, misfits = compile_timeline(scenario, variant.source)
            mistakes |= dict.fromkeys(misfits)
            if timeline is not None:
                cases += [
                    Case(variant.source, scenario, variant, timeline, system, source) for system in scenario.systems
                ]
    return cases, tuple(without_duplicates(mistakes or unused_kinds(source, variants)))


def _first_of_shared_names(sources: Iterable[Source]) -> Mapping[str, Source]:
    """Return the first scenario of each name that several have; golden files are named after scenarios."""
    named: defaultdict[str, list[Source]] = defaultdict(list)
    for source in sources:
        named[_name(source)].append(source)
    return {name: namesakes[0] for name, namesakes in named.items() if name and len(namesakes) > 1}


def _name(source: Source) -> str:
    """Return the name of a scenario; "" if it has none, which validation reports."""
    name = source.values.get("scenario")
    return name if isinstance(name, str) else ""


def shared_name(source: Source, first: Source) -> Diagnostic:
    """Return the mistake of a scenario with the name of another, `first`."""
    there = first.span_of(("scenario",))
    message = f"two scenarios are called '{_name(source)}'; the other one is at {there}"
    hint = "rename this one, since -k and golden files identify scenarios by name"
    return Diagnostic("SD203", source.span_of(("scenario",)), message, hint)


# Paths to case names. Files that have not changed are not read again: their case names come from the cache.


FIELDS = ("scenario_name", "parameters", "system", "tags", "lines")


class ChangedMeanwhileError(RuntimeError):
    """A file changed while it was read."""


@dataclass
class _ProjectFiles(Library):
    """The files of one project that its scenarios include or import; each is read once for its digest."""

    root: str = ""
    _digests: dict[str, str] = field(default_factory=dict)

    def digest(self, path: str) -> str:
        """Return the digest of a file with its real path in the project; "" if it cannot be read."""
        if path not in self._digests:
            self._digests[path] = _digest_there(path, self.root, _digest_of(Path(path), self.root))
        return self._digests[path]


@dataclass
class _Parts(Library):
    """The library of one file; records the digests and real paths of the files that it includes or imports."""

    root: str = ""
    shared: Library = field(default_factory=Library)  # of all files of the project
    digests: dict[str, str] = field(default_factory=dict)  # by path as requested, with unresolved links

    def read(self, path: str, root: str) -> Loaded:
        """Read a scenario file and record its digest."""
        loaded = self.shared.read(path, root)
        self.digests[path] = _digest_there(path, self.root, loaded.digest)
        return loaded

    def bytes_of(self, path: str, most: int, root: str) -> bytes:
        """Read a file of another program and record its digest."""
        data = self.shared.bytes_of(path, most, root)
        self.digests[path] = _digest_there(path, self.root, sha256(data).hexdigest())
        return data


@dataclass(frozen=True, slots=True)
class _InputDigests:
    """The digests of a file and of all files that its scenarios include or import."""

    own: str  # of the file itself
    parts: Mapping[str, str] = field(default_factory=dict)  # of the other files, by path

    @property
    def digest(self) -> str:
        """The digest of all files; "" if the file itself could not be read."""
        return sha256(json.dumps([self.own, *sorted(self.parts.items())]).encode()).hexdigest() if self.own else ""

    def is_current(self, files: _ProjectFiles) -> bool:
        """Whether the other files are unchanged."""
        now = {path: files.digest(path) for path in self.parts}
        return now == self.parts and all(now.values())


def _compiled(
    path: Path, content: Content | None, files: _ProjectFiles
) -> tuple[Loaded, _InputDigests, list[Case], list[Diagnostic]]:
    """Load and compile a file; return it with its input digests, cases and mistakes."""
    parts = _Parts(root=files.root, shared=files)
    read = loaded_from(path, content)
    loaded = expand_file(read, parts)
    return loaded, _InputDigests(read.digest, parts.digests), *cases_of(loaded)


@dataclass
class _File:
    """A file whose case names come from the cache."""

    path: Path
    content: Content
    files: _ProjectFiles
    inputs: _InputDigests  # at the time of the record

    @cached_property
    def cases(self) -> Mapping[Identity, Case]:
        """The compiled cases. Raises ChangedMeanwhileError."""
        _, inputs, cases, mistakes = _compiled(self.path, self.content, self.files)
        if mistakes or inputs.digest != self.inputs.digest:
            raise ChangedMeanwhileError(f"{self.path} changed while it was read; run the command again")
        return {case.identity: case for case in cases}


@dataclass(frozen=True, slots=True)
class CaseEntry:
    """A case whose name comes from the cache; it is compiled when it must run."""

    origin: _File = field(repr=False)
    file: str
    scenario_name: str
    parameters: tuple[tuple[str, str], ...]
    system: str
    tags: tuple[str, ...]
    lines: tuple[int, int]
    peer: str = ""  # system of the record, if `system` differs from it

    @property
    def identity(self) -> Identity:
        """The identity of the case."""
        return identity_of(self.scenario_name, self.parameters, self.system)

    @property
    def name(self) -> str:
        """The displayed name: the scenario, then the variant in brackets."""
        return f"{self.scenario_name}[{self.identity.variant}]"

    def on(self, system: str) -> "CaseEntry":
        """Return this case on another system."""
        return replace(self, system=system, peer=self.peer or self.system)

    def compiled(self) -> Case:
        """Compile the case. Raises ChangedMeanwhileError."""
        own = identity_of(self.scenario_name, self.parameters, self.peer or self.system)
        try:
            return self.origin.cases[own].on(self.system)
        except KeyError as error:
            raise ChangedMeanwhileError(f"{self.file} changed while it was read; run the command again") from error


Listed: TypeAlias = Case | CaseEntry


@dataclass(frozen=True, slots=True)
class CaseSurvey:
    """The cases of all valid scenarios, compiled or from the cache, and the diagnostics of the others."""

    cases: tuple[Listed, ...]
    diagnostics: tuple[Diagnostic, ...]
    digests: Mapping[str, str]  # of the inputs of each readable file, by displayed path


def survey(paths: Sequence[Path], memory: ResultCache) -> CaseSurvey:
    """Return all cases under these paths, like `gather`; compile only those of files that have changed."""
    files, diagnostics = files_under(paths)
    cases: list[Listed] = []
    names: list[str] = []
    digests: dict[str, str] = {}
    projects: dict[str, _ProjectFiles] = {}
    for path in files:
        shown, content, root = visible(path.as_posix()), _content_of(path), root_of(str(path))
        project = projects.setdefault(root, _ProjectFiles(root=root))
        key = memory.key("file", shown, content.digest if content is not None else "")
        if content is not None and (entries := _cached_entries(memory.recall(key), path, content, project)):
            names += {(entry.scenario_name, entry.lines): entry.scenario_name for entry in entries}.values()
            digests[shown] = entries[0].origin.inputs.digest
            cases += entries
            continue
        loaded, inputs, compiled, mistakes = _compiled(path, content, project)
        diagnostics += mistakes
        cases += compiled
        names += [str(source.values.get("scenario")) for source in loaded.sources]
        digests |= {source.file: inputs.digest for source in loaded.sources}
        if not mistakes and content is not None:
            memory.remember(key, {"parts": dict(inputs.parts), "cases": [_record(case) for case in compiled]})
    if len(set(names)) < len(names):  # the diagnostic of a shared name has both positions, so read all files
        gathered = gather(paths)
        return CaseSurvey(gathered.cases, gathered.diagnostics, {})
    return CaseSurvey(tuple(cases), tuple(dict.fromkeys(diagnostics)), digests)


def _content_of(path: Path) -> Content | None:
    """Return the content of a scenario file; None if it cannot be read, or only once."""
    if path == STDIN or not os.path.isfile(path):  # a pipe can be read only once
        return None
    with suppress(OSError):
        return with_digest(read_user_file(path, MAX_BYTES + 1))
    return None


def _digest_of(path: Path, within: str) -> str:
    """Return the digest of an included or imported file; "" if it cannot be read, or only once."""
    if not os.path.isfile(path):
        return ""
    with suppress(OSError):
        return sha256(read_file(path, MAX_IMPORTED + 1, within)).hexdigest()
    return ""


def _digest_there(path: str, root: str, digest: str) -> str:
    """Return the digest of a file with its real path in the project; "" if it cannot be read."""
    return f"{digest} {os.path.relpath(os.path.realpath(path), root)}" if digest else ""


def _record(case: Case) -> list[object]:
    return [getattr(case, name) for name in FIELDS]


def _cached_entries(value: object, path: Path, content: Content, files: _ProjectFiles) -> list[CaseEntry]:
    """Return the cases of a record, if the files that they include and import are unchanged; [] otherwise."""
    if not isinstance(value, dict):
        return []
    try:
        file = _File(path, content, files, _InputDigests(content.digest, value["parts"]))
        return list(_entries(value["cases"], file)) if file.inputs.is_current(files) else []
    except (AssertionError, LookupError, TypeError, ValueError):  # the record may be forged
        return []


def _entries(records: Iterable[list[object]], file: _File) -> Iterator[CaseEntry]:
    shown = visible(file.path.as_posix())
    for scenario, parameters, system, tags, lines in records:
        assert isinstance(parameters, list)
        assert isinstance(tags, list)
        assert isinstance(lines, list)
        choices = tuple((str(name), str(text)) for name, text in parameters)
        yield CaseEntry(file, shown, str(scenario), choices, str(system), tuple(map(str, tags)), (lines[0], lines[1]))
