"""Resolves `extends`, `include`, mesh files of solids and records, within the root of the project."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path as FilePath
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span, did_you_mean, reading_order
from stackdsl.disk import read_file
from stackdsl.language.mesh_files import mesh_kind
from stackdsl.language.yaml.parsing import MAX_VALUES, NO_MAPPING
from stackdsl.language.yaml.source import MAX_BYTES, KeyPath, Loaded, PlaceBuilder, Plain, Source, load, similar_file
from stackdsl.project_file import OWN_FILE, ProjectError, root_around

# Access to files: a scenario may only use files inside the root of its project.


OTHER_MARKS: Final = ("pyproject.toml", ".git")  # mark a root where there is no file of StackDSL


class OutsideError(ValueError):
    """A file that a scenario may not use."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint


def root_of(file: str) -> str:
    """Return the resolved root of the project around a file. Golden files are below the same root.

    The root is marked by the project file of StackDSL, or else by `OTHER_MARKS`; without a mark it is the folder of the
    file. Raises OutsideError if the project file cannot be read.
    """
    folder = FilePath(os.path.realpath(os.path.dirname(file) or "."))
    try:
        root = root_around(folder)
    except ProjectError as error:
        raise OutsideError(str(error), "correct that file, which marks the root of the project") from error
    marked = (above for above in (folder, *folder.parents) if any(os.path.exists(above / mark) for mark in OTHER_MARKS))
    return str(root or next(marked, folder))


def file_in_project(written: str, beside: str, root: str) -> str:
    """Return the path of a file that the file `beside` names relative to itself. Raises OutsideError.

    A `..` removes the name before it, even if that is a link. All other links are followed before the check, so that
    none leads outside.
    """
    if os.path.isabs(written) or written.startswith(("~", "\\")) or written[1:2] == ":":
        raise OutsideError(f"'{written}' is an absolute path", "write a path relative to the folder of this file")
    path = os.path.normpath(os.path.join(os.path.dirname(beside), written))
    true = os.path.realpath(path)
    if os.path.commonpath([true, root]) != root:
        message = f"'{written}' is outside the project, whose root is {os.path.relpath(root)}"
        raise OutsideError(
            message, f"move the file into the project, or mark a folder above as its root with a file {OWN_FILE}"
        )
    if not os.path.exists(true):
        hint = similar_file(path, beside) or "check the path, which is relative to the folder of this file"
        raise OutsideError(f"the file {path} does not exist", hint)
    if not os.path.isfile(true):
        raise OutsideError(f"{path} is not a regular file", "write the path of a YAML file")
    return path


# Mesh files of bricks, and records of shaking and loads: relative to the file that names them, and read once for a
# scenario.


FILE: Final = "file"
RECORDS: Final = frozenset({FILE, "across", "up"})  # keys of `shake`
MAX_RECORD: Final = 4 * MAX_BYTES  # as much as 100,000 values of an AT2 file need
MAX_FILES: Final = 1000  # of one scenario


def with_named_files(source: Source, read: Callable[[str, int, str], bytes]) -> tuple[Source, tuple[Diagnostic, ...]]:
    """Return the scenario with the texts of its mesh files and records, by path, and the diagnostics.

    `read` takes a path, a number of bytes and the root of the project, and returns at most one byte more than that. It
    may raise OSError.
    """
    named = list(_named(source))
    if not named:
        return source, ()
    values, mistakes = source.values, []
    texts: dict[str, str] = {}
    for path, written in named:
        try:
            beside = source.span_of(path).file  # a brick may come from an included file
            root = root_of(source.file)
            file = file_in_project(written.strip(), beside, root)
            if file not in texts:
                if len(texts) == MAX_FILES:
                    raise OutsideError(f"the scenario refers to more than {MAX_FILES} files", "use fewer files")
                texts[file] = _text(file, read, root, MAX_BYTES if _is_of_brick(path) else MAX_RECORD)
        except OutsideError as error:
            mistakes.append(Diagnostic("SD113", source.span_of(path), error.message, error.hint))
            continue
        values = _with(values, path, file)
    return replace(source, values=values, files=texts, parts=(*source.parts, *texts)), tuple(mistakes)


def _text(file: str, read: Callable[[str, int, str], bytes], root: str, most: int) -> str:
    try:
        data = read(file, most, root)
    except OSError as error:
        raise OutsideError(f"cannot read {file}: {error.strerror}", "check the permissions of the file") from error
    if len(data) > most:
        raise OutsideError(f"{file} is larger than {most >> 20} MiB", "use a smaller file")
    if mesh_kind(file):  # may be binary
        return data.decode("latin-1")
    return data.decode("utf-8", "replace")


def _named(source: Source) -> Iterator[tuple[KeyPath, str]]:
    """Yield the paths and values of the keys that name mesh files or records."""
    waiting: list[tuple[KeyPath, Plain]] = [((), source.values)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), inner) for key, inner in reversed(value.items())]
        elif isinstance(value, list):
            waiting += [((*path, index), inner) for index, inner in reversed([*enumerate(value)])]
        elif (
            (_is_of_brick(path) or _is_of_record(path))
            and isinstance(value, str)
            and value.strip()
            and "\0" not in value
        ):
            yield path, value


def _is_of_brick(path: KeyPath) -> bool:
    return path[-1:] == (FILE,) and ("brick" in path[-2:-1] or "brick_types" in path[-3:-2])


def _is_of_record(path: KeyPath) -> bool:
    of_shake = path[:2] == ("world", "shake") and path[2:3] != () and path[2] in RECORDS
    return of_shake or (path[:1] == ("loads",) and path[2:] == (FILE,))


def _with(values: dict[str, Plain], path: KeyPath, leaf: str) -> dict[str, Plain]:
    """Return the values with the one at a path replaced."""
    changed = _changed(values, path, leaf)
    assert isinstance(changed, dict)
    return changed


def _changed(value: Plain, path: KeyPath, leaf: str) -> Plain:
    if not path:
        return leaf
    key, rest = path[0], path[1:]
    if isinstance(value, dict):
        return {**value, str(key): _changed(value[str(key)], rest, leaf)}
    assert isinstance(value, list)
    return [_changed(item, rest, leaf) if index == key else item for index, item in enumerate(value)]


# `extends` and `include`: a scenario from several files, each value with its place in its own file.


EXTENDS: Final = "extends"
INCLUDE: Final = "include"
LISTS: Final = ("build", "impacts", "expect", "truth")  # lists that may include items, besides `bricks`
MERGED: Final = ("world", "let", "matrix", "brick_types")  # merged key by key; all other keys are replaced
MAX_PARTS: Final = 1000  # references to files in all scenarios of one file
MAX_TAKEN: Final = MAX_VALUES  # values copied from other files, with repetitions; a second
LONGEST_PATH: Final = 1000  # [characters] as it is written
MAX_TRAIL: Final = 16  # nesting of references


@dataclass(slots=True)
class Library:
    """Cache of the files that scenarios refer to."""

    files: dict[str, Loaded] = field(default_factory=dict)  # by resolved path

    def read(self, path: str, root: str) -> Loaded:
        """Load a file within the root of a project, with its diagnostics."""
        true = os.path.realpath(path)
        if true not in self.files:
            self.files[true] = load(FilePath(path), root)
        return self.files[true]

    def bytes_of(self, path: str, most: int, root: str) -> bytes:
        """Return the content of a file within the root, at most one byte more than `most`. Raises OSError."""
        return read_file(FilePath(path), most + 1, root)


class _InvalidImportError(Exception):
    """Carries the diagnostics of a part."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__(diagnostics)
        self.diagnostics = diagnostics


def _of_bare_list(mistake: Diagnostic, key: str, including: Span) -> Diagnostic:
    """Return the mistake of an included file that is the list itself with its remedy; any other unchanged."""
    if mistake.message != NO_MAPPING + "a list" or mistake.span.where:
        return mistake
    message = f"the list has no key; an included file has its list under `{key}:`"
    span = replace(mistake.span, where=f"included from {including}")
    return replace(mistake, span=span, message=message, hint=f"write `{key}:` above the list and indent the list")


def composed(loaded: Loaded, library: Library) -> Loaded:
    """Return the scenarios of a file with all references resolved; those with mistakes become diagnostics."""
    composer = _Composer(library, loaded.sources)
    sources: list[Source] = []
    mistakes: list[Diagnostic] = []
    for source in loaded.sources:
        try:
            resolved = composer.resolve(source, ()) if _is_composed(source) else source
        except _InvalidImportError as mistake:
            mistakes += mistake.diagnostics
            continue
        resolved, unread = with_named_files(resolved, library.bytes_of)
        mistakes += unread
        sources += [] if unread else [resolved]
    sources = [_spared(source) if source.value_spans[()] in composer.bases else source for source in sources]
    return Loaded(tuple(sources), (*loaded.diagnostics, *sorted(dict.fromkeys(mistakes), key=reading_order)))


def _spared(source: Source) -> Source:
    """Return a scenario that others extend, which may define what only they use."""
    return replace(source, inherited=source.inherited.union(definitions_of(source.values)))


def _is_composed(source: Source) -> bool:
    return EXTENDS in source.values or any(_includes(source.values.get(key)) for key in LISTS)


def _includes(items: Plain) -> bool:
    """Return whether a list, or a list of `bricks` in it, includes items of another file."""
    mappings = [item for item in items if isinstance(item, dict)] if isinstance(items, list) else []
    return any(INCLUDE in item or _includes(item.get("bricks")) for item in mappings)


@dataclass(slots=True)
class _Composer:
    """Resolves the references of the scenarios of one file, within limits."""

    library: Library
    siblings: Sequence[Source]
    parts: int = 0  # references so far
    taken: int = 0  # values copied so far
    read: int = 0  # [bytes]
    seen: dict[str, None] = field(default_factory=dict)  # files so far, in order
    bases: set[Span] = field(default_factory=set)  # places of the scenarios that others extend

    def resolve(self, source: Source, trail: tuple[Source, ...]) -> Source:
        """Resolve all references of a scenario, or of a part. `trail` is the chain of references to it.

        Raises _InvalidImportError.
        """
        self._check_trail(source, trail)
        trail = (*trail, source)
        for key in LISTS:
            if _includes(source.values.get(key)):
                source = self._with_included(source, key, trail)
        return self._extended(source, trail) if EXTENDS in source.values else source

    def _check_trail(self, source: Source, trail: Sequence[Source]) -> None:
        """Raise _InvalidImportError for a circular reference, or for too deep nesting."""
        circle = any(part.file == source.file and part.value_spans[()] == source.value_spans[()] for part in trail)
        if not circle and len(trail) < MAX_TRAIL:
            return
        files = " -> ".join(part.file for part in (*trail, source))
        message = f"circular reference between files: {files}"
        if not circle:
            message = f"the references are nested more than {MAX_TRAIL} deep: {files}"
        itself = circle and trail[-1].file == source.file
        hint = "name another file, or remove the key" if itself else "shorten the chain of references"
        raise _InvalidImportError(Diagnostic("SD113", _named_at(trail[-1]), message, hint))

    # --- include ------------------------------------------------------------------------------------------------------

    def _with_included(self, source: Source, key: str, trail: tuple[Source, ...]) -> Source:
        places = PlaceBuilder()
        places.keep(source, {(key,): None})
        places.note(source, (key,), (key,))
        values = {**source.values, key: self._list(source, source.values[key], (key,), (key,), places, trail)}
        return replace(
            source, values=values, value_spans=places.value_spans, key_spans=places.key_spans, parts=tuple(self.seen)
        )

    def _list(  # noqa: PLR0913, PLR0917 -- a value, its old path and its new path
        self, source: Source, items: Plain, old: KeyPath, new: KeyPath, places: PlaceBuilder, trail: tuple[Source, ...]
    ) -> list[Plain]:
        made: list[Plain] = []
        for index, item in enumerate(items if isinstance(items, list) else ()):
            here = (*old, index)
            if isinstance(item, dict) and INCLUDE in item:
                part, where = self._part(source, here, item, trail), f"included from {source.span_of(here)}"
                for number, (value, goes) in enumerate(zip(_items(part, str(old[-1])), count(len(made)), strict=False)):
                    self._take(part, value, (str(old[-1]), number), (*new, goes), places, where)
                    made.append(value)
                continue
            goes_to = (*new, len(made))
            if isinstance(item, dict) and old == ("build",) and _includes(item.get("bricks")):
                places.note_all(source, {key: value for key, value in item.items() if key != "bricks"}, here, goes_to)
                places.note(source, (*here, "bricks"), (*goes_to, "bricks"))
                bricks = self._list(source, item["bricks"], (*here, "bricks"), (*goes_to, "bricks"), places, trail)
                made.append({**item, "bricks": bricks})
            else:
                places.note_all(source, item, here, goes_to)
                made.append(item)
        return made

    def _part(self, source: Source, path: KeyPath, item: Mapping[str, Plain], trail: tuple[Source, ...]) -> Source:
        """Return the file that an item includes, with its own references resolved."""
        span = source.span_of((*path, INCLUDE))
        if len(item) > 1:
            other = next(key for key in item if key != INCLUDE)
            message = f"an item with `{INCLUDE}` cannot have other keys, but this item has '{other}'"
            hint = f"move '{other}' to the included file, or to another item"
            raise _InvalidImportError(Diagnostic("SD108", source.key_span_of((*path, other)), message, hint))
        key = str(path[-2])
        try:
            part = self.resolve(self._document(source, item[INCLUDE], "", span), trail)
        except _InvalidImportError as mistake:
            raise _InvalidImportError(*(_of_bare_list(each, key, span) for each in mistake.diagnostics)) from None
        if not isinstance(part.values.get(key), list):
            message = f"{part.file} has no list `{key}` to include"
            raise _InvalidImportError(
                Diagnostic("SD113", span, message, f"begin that file with `{key}:`, followed by the items")
            )
        return part

    # --- extends ------------------------------------------------------------------------------------------------------

    def _extended(self, source: Source, trail: tuple[Source, ...]) -> Source:
        written = self._base(source)
        self.bases.add(written.value_spans[()])
        base = self.resolve(written, trail)
        own = {key: value for key, value in source.values.items() if key != EXTENDS}
        overridden = {"scenario", *own} - set(MERGED)
        base_values = {key: value for key, value in base.values.items() if key not in overridden}
        merged = [key for key in MERGED if isinstance(own.get(key), dict) and isinstance(base_values.get(key), dict)]
        copied = {key: value for key, value in base_values.items() if key not in own or key in merged}
        where = f"extended from {source.key_span_of((EXTENDS,))}"
        places = PlaceBuilder()
        for key in [key for key in copied if key not in merged]:
            self._take(base, copied[key], (key,), (key,), places, where)
        for key in merged:
            for name in [name for name in _mapping(base_values[key]) if name not in _mapping(own[key])]:
                self._take(base, _mapping(base_values[key])[name], (key, name), (key, name), places, where)
        for key, value in own.items():
            places.note_all(source, value, (key,), (key,))
        places.note(source, (), ())
        values = {**copied, **own, **{key: {**_mapping(base_values[key]), **_mapping(own[key])} for key in merged}}
        inherited = frozenset(definitions_of(copied)).difference(definitions_of(own)) | base.inherited
        return replace(
            source,
            values=values,
            value_spans=places.value_spans,
            key_spans=places.key_spans,
            inherited=inherited,
            parts=tuple(self.seen),
            ambiguous=(*base.ambiguous, *source.ambiguous),
        )

    def _base(self, source: Source) -> Source:
        """Return the unresolved scenario that `extends` refers to."""
        written = source.values[EXTENDS]
        span = source.span_of((EXTENDS,))
        if isinstance(written, str):
            return self._document(source, written, "", span)
        if not isinstance(written, dict) or not written or set(written) - {"file", "scenario"}:
            hint = "write, for example, base.yaml, or {file: base.yaml, scenario: tower}"
            raise _InvalidImportError(
                Diagnostic(
                    "SD103", span, "expected the path of a file, or a mapping with the keys file and scenario", hint
                )
            )
        name = written.get("scenario", "")
        if not isinstance(name, str):
            span = source.span_of((EXTENDS, "scenario"))
            raise _InvalidImportError(Diagnostic("SD103", span, "expected the name of a scenario", "quote it"))
        place = (EXTENDS, "file") if "file" in written else (EXTENDS, "scenario")
        return self._document(source, written.get("file"), name, source.span_of(place))

    def _document(self, source: Source, written: Plain, name: str, span: Span) -> Source:
        """Return the only document of a file, or the one with a name; of the current file if `written` is None."""
        self.parts += 1
        if self.parts > MAX_PARTS:
            message = f"the scenarios of this file have more than {MAX_PARTS} keys `extends` and `include`"
            raise _InvalidImportError(Diagnostic("SD206", span, message, "combine the included files into fewer files"))
        file, documents = source.file, self.siblings
        if written is not None:
            file = self._file(source, written, span)
            documents = self._read(file, span)
        elif self.siblings and source.file != self.siblings[0].file:
            documents = self._read(file, span)
        matches = [document for document in documents if not name or document.values.get("scenario") == name]
        if len(matches) == 1:
            return matches[0]
        if name:
            names = [str(document.values.get("scenario")) for document in documents]
            raise _InvalidImportError(
                Diagnostic("SD113", span, f"{file} has no scenario '{name}'", did_you_mean(name, names))
            )
        hint = "write {file: base.yaml, scenario: tower}; a file for `include` must have a single document"
        raise _InvalidImportError(Diagnostic("SD113", span, f"{file} contains {len(documents)} scenarios", hint))

    @property
    def _root(self) -> str:
        return root_of(self.siblings[0].file)

    def _file(self, source: Source, written: Plain, span: Span) -> str:
        if not isinstance(written, str) or not written.strip() or "${" in written or "\0" in written:
            raise _InvalidImportError(
                Diagnostic("SD103", span, "expected the path of a file", "write, for example, base.yaml")
            )
        if len(written) > LONGEST_PATH:  # longer than systems allow, and slow to resolve
            message = f"the path of a file is longer than {LONGEST_PATH} characters"
            raise _InvalidImportError(Diagnostic("SD113", span, message, "write, for example, base.yaml"))
        try:
            return file_in_project(written.strip(), source.file, self._root)
        except OutsideError as error:
            raise _InvalidImportError(Diagnostic("SD113", span, error.message, error.hint)) from error

    def _read(self, file: str, span: Span) -> Sequence[Source]:
        if file not in self.seen:
            self.seen[file] = None
            self.read += os.path.getsize(file)
        if self.read > MAX_BYTES:
            message = f"the files of `extends` and `include` exceed {MAX_BYTES >> 20} MiB in total"
            raise _InvalidImportError(Diagnostic("SD206", span, message, "use smaller files"))
        loaded = self.library.read(file, self._root)
        if loaded.diagnostics:
            raise _InvalidImportError(*loaded.diagnostics)
        return loaded.sources

    def _take(  # noqa: PLR0913, PLR0917 -- likewise
        self, part: Source, value: Plain, old: KeyPath, new: KeyPath, places: PlaceBuilder, where: str
    ) -> None:
        self.taken += _size(value)
        if self.taken > MAX_TAKEN:
            message = f"`extends` and `include` insert more than {MAX_TAKEN} values"
            raise _InvalidImportError(Diagnostic("SD206", part.span_of(old), message, "include less, or use a layout"))
        places.note_all(part, value, old, new, where)


# --- access to values -------------------------------------------------------------------------------------------------


def _named_at(source: Source) -> Span:
    """Return the place of the first reference in a file."""
    if EXTENDS in source.values:
        return source.span_of((EXTENDS,))
    paths = (path for path in source.value_spans if path and path[-1] == INCLUDE)
    return source.span_of(next(paths, ()))


def _items(part: Source, key: str) -> list[Plain]:
    items = part.values[key]
    return items if isinstance(items, list) else []


def _mapping(value: Plain) -> dict[str, Plain]:
    return value if isinstance(value, dict) else {}


def _size(value: Plain) -> int:
    if isinstance(value, dict | list):
        return 1 + sum(map(_size, value.values() if isinstance(value, dict) else value))
    return 1


def definitions_of(values: Mapping[str, Plain]) -> tuple[KeyPath, ...]:
    """Return the paths at which the variables and the kinds of bricks of a scenario are defined."""
    cases = values.get("cases")
    first = _mapping(cases[0]) if isinstance(cases, list) and cases else {}
    named = [(key, name) for key in ("matrix", "uncertain", "let", "brick_types") for name in _mapping(values.get(key))]
    return (*named, *(("cases", 0, name) for name in first))
