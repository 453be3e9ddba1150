"""Resolves `extends`, `include` and solid files within the root of the project."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from itertools import count, islice
from pathlib import Path as FilePath
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span, did_you_mean, reading_order
from stackdsl.disk import read_file
from stackdsl.language.yaml.parsing import MAX_VALUES
from stackdsl.language.yaml.source import MAX_BYTES, KeyPath, Loaded, PlaceBuilder, Plain, Source, load
from stackdsl.project_file import OWN_FILE, ProjectError, root_around

# Which files a scenario may be made of: those inside the root of its project, and no other.


MOST_BESIDE: Final = 1000  # files of a folder among which one is looked for that is called alike
OTHER_MARKS: Final = ("pyproject.toml", ".git")  # of what is no project of stackdsl by its own word


class OutsideError(ValueError):
    """A file that a scenario may not be made of."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint


def root_of(file: str) -> str:
    """The true path of the root of the project around a file, to which its golden files belong as well.

    Where nothing marks one, that of whatever project or repository is around it, or else its own folder. Raises
    OutsideError where the file that marks it cannot be read.
    """
    folder = FilePath(os.path.realpath(os.path.dirname(file) or "."))
    try:
        root = root_around(folder)
    except ProjectError as error:
        raise OutsideError(str(error), "mend that file, so that it can be known what is inside the project") from error
    marked = (each for each in (folder, *folder.parents) if any(os.path.exists(each / mark) for mark in OTHER_MARKS))
    return str(root or next(marked, folder))


def file_in_project(written: str, beside: str, root: str) -> str:
    """The path of a file that is named in another one, relative to it. Raises OutsideError.

    A `..` takes back the name before it, whether that is a link or not; all other links are followed, so that no way
    leads outside.
    """
    if os.path.isabs(written) or written.startswith(("~", "\\")) or written[1:2] == ":":
        raise OutsideError(f"'{written}' is an absolute path", "write it as seen from the folder of this file")
    path = os.path.normpath(os.path.join(os.path.dirname(beside), written))
    true = os.path.realpath(path)
    if os.path.commonpath([true, root]) != root:
        message = f"'{written}' leads outside of the project, whose root is {os.path.relpath(root)}"
        raise OutsideError(message, f"keep all files inside, or mark a folder above as the root by a file {OWN_FILE}")
    if not os.path.exists(true):
        raise OutsideError(f"there is no file {path}", _meant(path))
    if not os.path.isfile(true):
        raise OutsideError(f"{path} is no regular file", "name a file of YAML")
    return path


def _meant(path: str) -> str:
    """What to do about a file that is not there: name one beside it that is called alike, where there is one."""
    hint = "check its name; it is looked for from the folder of this file"
    folder, name = os.path.split(path)
    try:
        with os.scandir(folder or ".") as entries:
            beside = [entry.name for entry in islice(entries, MOST_BESIDE) if entry.is_file()]
    except OSError:
        return hint
    return next((f"did you mean '{one}'?" for one in get_close_matches(name, sorted(beside), n=1)), hint)


# The files that bricks are made of: found beside the file that names them, and read once for a scenario.


FILE: Final = "file"
MAX_FILES: Final = 1000  # of one scenario


def with_solid_files(source: Source, read: Callable[[str, int, str], bytes]) -> tuple[Source, tuple[Diagnostic, ...]]:
    """The scenario with the texts of the files of its bricks, each named by its path from here; and what is wrong.

    `read` gives what a file within the root of a project holds, by its path, up to one byte more than is asked for. It
    may raise OSError.
    """
    named = list(_named(source))
    if not named:
        return source, ()
    values, mistakes = source.values, []
    texts: dict[str, str] = {}
    for path, written in named:
        try:
            beside = source.span_of(path).file  # a brick may come from a file that is included
            root = root_of(source.file)
            file = file_in_project(written.strip(), beside, root)
            if file not in texts:
                if len(texts) == MAX_FILES:
                    raise OutsideError(f"the bricks come from more than {MAX_FILES} files", "take fewer")
                texts[file] = _text(file, read, root)
        except OutsideError as error:
            mistakes.append(Diagnostic("SD113", source.span_of(path), error.message, error.hint))
            continue
        values = _with(values, path, file)
    return replace(source, values=values, files=texts, parts=(*source.parts, *texts)), tuple(mistakes)


def _text(file: str, read: Callable[[str, int, str], bytes], root: str) -> str:
    try:
        data = read(file, MAX_BYTES, root)
    except OSError as error:
        raise OutsideError(f"cannot read {file}: {error.strerror}", "name a file that can be read") from error
    if len(data) > MAX_BYTES:
        raise OutsideError(f"{file} is larger than {MAX_BYTES >> 20} MiB", "write a simpler solid")
    return data.decode("utf-8", "replace")


def _named(source: Source) -> Iterator[tuple[KeyPath, str]]:
    """Where a brick says which file it is of."""
    waiting: list[tuple[KeyPath, Plain]] = [((), source.values)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), inner) for key, inner in reversed(value.items())]
        elif isinstance(value, list):
            waiting += [((*path, index), inner) for index, inner in reversed([*enumerate(value)])]
        elif _is_of_brick(path) and isinstance(value, str) and value.strip() and "\0" not in value:
            yield path, value


def _is_of_brick(path: KeyPath) -> bool:
    return path[-1:] == (FILE,) and ("brick" in path[-2:-1] or "brick_types" in path[-3:-2])


def _with(values: dict[str, Plain], path: KeyPath, leaf: str) -> dict[str, Plain]:
    """The values with another one at a path."""
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


# `extends` and `include`: one scenario out of several files, each value with its place in its own file.


EXTENDS: Final = "extends"
INCLUDE: Final = "include"
LISTS: Final = ("build", "impacts", "expect", "truth")  # whose items may come from another file; and those of `bricks`
MERGED: Final = ("world", "let", "matrix", "brick_types")  # key by key; all else is replaced
MAX_PARTS: Final = 1000  # files that all scenarios of one file name, one by one
MAX_TAKEN: Final = MAX_VALUES  # values that these bring, however often; a second
LONGEST_PATH: Final = 1000  # [characters] as it is written
MAX_TRAIL: Final = 16  # files that name one another


@dataclass(slots=True)
class Library:
    """Files that others name, each read once."""

    files: dict[str, Loaded] = field(default_factory=dict)  # by their true paths

    def read(self, path: str, root: str) -> Loaded:
        """What a file within the root of a project holds, whatever is wrong with it."""
        true = os.path.realpath(path)
        if true not in self.files:
            self.files[true] = load(FilePath(path), root)
        return self.files[true]

    def bytes_of(self, path: str, most: int, root: str) -> bytes:
        """What a file of another program within it holds, up to one byte more than `most`. Raises OSError."""
        return read_file(FilePath(path), most + 1, root)


class _MistakeError(Exception):
    """What is wrong with a part, as diagnostics."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__(diagnostics)
        self.diagnostics = diagnostics


def composed(loaded: Loaded, library: Library) -> Loaded:
    """The scenarios of a file with all that they take from others; those that cannot have it are left out, and told."""
    composing = _Composing(library, loaded.sources)
    sources: list[Source] = []
    mistakes: list[Diagnostic] = []
    for source in loaded.sources:
        try:
            whole = composing.whole(source, ()) if _is_composed(source) else source
        except _MistakeError as mistake:
            mistakes += mistake.diagnostics
            continue
        whole, unread = with_solid_files(whole, library.bytes_of)
        mistakes += unread
        sources += [] if unread else [whole]
    return Loaded(tuple(sources), (*loaded.diagnostics, *sorted(dict.fromkeys(mistakes), key=reading_order)))


def _is_composed(source: Source) -> bool:
    return EXTENDS in source.values or any(_includes(source.values.get(key)) for key in LISTS)


def _includes(items: Plain) -> bool:
    """Whether anything in a list comes from another file."""
    mappings = [item for item in items if isinstance(item, dict)] if isinstance(items, list) else []
    return any(INCLUDE in item or _includes(item.get("bricks")) for item in mappings)


@dataclass(slots=True)
class _Composing:
    """The scenarios of one file while they take what they name."""

    library: Library
    siblings: Sequence[Source]
    parts: int = 0
    taken: int = 0
    read: int = 0  # [bytes]
    seen: dict[str, None] = field(default_factory=dict)  # the files

    def whole(self, source: Source, trail: tuple[Source, ...]) -> Source:
        """A scenario, or a part of one, with all that it takes. `trail` is what led to it. Raises _MistakeError."""
        self._keep_off(source, trail)
        trail = (*trail, source)
        for key in LISTS:
            if _includes(source.values.get(key)):
                source = self._with_included(source, key, trail)
        return self._extended(source, trail) if EXTENDS in source.values else source

    def _keep_off(self, source: Source, trail: Sequence[Source]) -> None:
        """Raise _MistakeError if a part leads back to itself, or too deep."""
        circle = any(each.file == source.file and each.value_spans[()] == source.value_spans[()] for each in trail)
        if not circle and len(trail) < MAX_TRAIL:
            return
        files = " -> ".join(each.file for each in (*trail, source))
        message = f"the files name each other in a circle: {files}"
        if not circle:
            message = f"more than {MAX_TRAIL} files name one another: {files}"
        raise _MistakeError(Diagnostic("SD113", _named_at(trail[-1]), message, "name what is meant at once"))

    # --- include ------------------------------------------------------------------------------------------------------

    def _with_included(self, source: Source, key: str, trail: tuple[Source, ...]) -> Source:
        places = PlaceBuilder()
        places.keep(source, {(key,): None})
        places.note(source, (key,), (key,))
        values = {**source.values, key: self._list(source, source.values[key], (key,), (key,), places, trail)}
        return replace(
            source, values=values, value_spans=places.value_spans, key_spans=places.key_spans, parts=tuple(self.seen)
        )

    def _list(  # noqa: PLR0913, PLR0917 -- a value, where it comes from and where it goes
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
        """The file that an item names, with all that it takes itself."""
        span = source.span_of((*path, INCLUDE))
        if len(item) > 1:
            other = next(key for key in item if key != INCLUDE)
            message = f"`{INCLUDE}` stands alone in its item, without '{other}'"
            hint = "write what else there is in the file that is included, or in an item of its own"
            raise _MistakeError(Diagnostic("SD108", source.key_span_of((*path, other)), message, hint))
        part = self.whole(self._document(source, item[INCLUDE], "", span), trail)
        key = str(path[-2])
        if not isinstance(part.values.get(key), list):
            message = f"{part.file} has no list `{key}` that could be included here"
            raise _MistakeError(Diagnostic("SD113", span, message, f"begin it with `{key}:`, and its items below"))
        return part

    # --- extends ------------------------------------------------------------------------------------------------------

    def _extended(self, source: Source, trail: tuple[Source, ...]) -> Source:
        base = self.whole(self._base(source), trail)
        own = {key: value for key, value in source.values.items() if key != EXTENDS}
        kept = {"scenario", *own} - set(MERGED)
        theirs = {key: value for key, value in base.values.items() if key not in kept}
        merged = [key for key in MERGED if isinstance(own.get(key), dict) and isinstance(theirs.get(key), dict)]
        replaced = {key: value for key, value in theirs.items() if key not in own or key in merged}
        where = f"extended from {source.key_span_of((EXTENDS,))}"
        places = PlaceBuilder()
        for key in [key for key in replaced if key not in merged]:
            self._take(base, replaced[key], (key,), (key,), places, where)
        for key in merged:
            for name in [name for name in _mapping(theirs[key]) if name not in _mapping(own[key])]:
                self._take(base, _mapping(theirs[key])[name], (key, name), (key, name), places, where)
        for key, value in own.items():
            places.note_all(source, value, (key,), (key,))
        places.note(source, (), ())
        values = {**replaced, **own, **{key: {**_mapping(theirs[key]), **_mapping(own[key])} for key in merged}}
        inherited = variables_of(replaced) - variables_of(own) | base.inherited
        return Source(source.file, values, places.value_spans, places.key_spans, inherited, tuple(self.seen))

    def _base(self, source: Source) -> Source:
        """The scenario that another one extends, as it is written."""
        written = source.values[EXTENDS]
        span = source.span_of((EXTENDS,))
        if isinstance(written, str):
            return self._document(source, written, "", span)
        if not isinstance(written, dict) or not written or set(written) - {"file", "scenario"}:
            hint = "write such as base.yaml, or {file: base.yaml, scenario: tower}"
            raise _MistakeError(Diagnostic("SD103", span, "expected a file, or a mapping of file and scenario", hint))
        name = written.get("scenario", "")
        if not isinstance(name, str):
            span = source.span_of((EXTENDS, "scenario"))
            raise _MistakeError(Diagnostic("SD103", span, "expected the name of a scenario", "quote it"))
        place = (EXTENDS, "file") if "file" in written else (EXTENDS, "scenario")
        return self._document(source, written.get("file"), name, source.span_of(place))

    def _document(self, source: Source, written: Plain, name: str, span: Span) -> Source:
        """The one document of a file, or the one that is called so; of this file, if none is named."""
        self.parts += 1
        if self.parts > MAX_PARTS:
            message = f"the scenarios of this file take from others more than {MAX_PARTS} times"
            raise _MistakeError(Diagnostic("SD206", span, message, "take more at a time"))
        file, documents = source.file, self.siblings
        if written is not None:
            file = self._file(source, written, span)
            documents = self._read(file, span)
        elif self.siblings and source.file != self.siblings[0].file:
            documents = self._read(file, span)
        named = [each for each in documents if not name or each.values.get("scenario") == name]
        if len(named) == 1:
            return named[0]
        if name:
            names = [str(each.values.get("scenario")) for each in documents]
            raise _MistakeError(
                Diagnostic("SD113", span, f"{file} has no scenario '{name}'", did_you_mean(name, names))
            )
        hint = "say which: {file: base.yaml, scenario: tower}; what is included stands in a file of its own"
        raise _MistakeError(Diagnostic("SD113", span, f"{file} holds {len(documents)} scenarios", hint))

    @property
    def _root(self) -> str:
        return root_of(self.siblings[0].file)

    def _file(self, source: Source, written: Plain, span: Span) -> str:
        if not isinstance(written, str) or not written.strip() or "${" in written or "\0" in written:
            raise _MistakeError(Diagnostic("SD103", span, "expected the path of a file", "write such as base.yaml"))
        if len(written) > LONGEST_PATH:  # no system has such; and to follow all of its folders takes seconds
            message = f"the path of a file is longer than {LONGEST_PATH} characters"
            raise _MistakeError(Diagnostic("SD113", span, message, "write such as base.yaml"))
        try:
            return file_in_project(written.strip(), source.file, self._root)
        except OutsideError as error:
            raise _MistakeError(Diagnostic("SD113", span, error.message, error.hint)) from error

    def _read(self, file: str, span: Span) -> Sequence[Source]:
        if file not in self.seen:
            self.seen[file] = None
            self.read += os.path.getsize(file)
        if self.read > MAX_BYTES:
            message = f"the files that are taken from have more than {MAX_BYTES >> 20} MiB in all"
            raise _MistakeError(Diagnostic("SD206", span, message, "take from smaller ones"))
        loaded = self.library.read(file, self._root)
        if loaded.diagnostics:
            raise _MistakeError(*loaded.diagnostics)
        return loaded.sources

    def _take(  # noqa: PLR0913, PLR0917 -- likewise
        self, part: Source, value: Plain, old: KeyPath, new: KeyPath, places: PlaceBuilder, where: str
    ) -> None:
        self.taken += _size(value)
        if self.taken > MAX_TAKEN:
            message = f"what is taken from other files comes to more than {MAX_TAKEN} values"
            raise _MistakeError(Diagnostic("SD206", part.span_of(old), message, "take less, or use a layout"))
        places.note_all(part, value, old, new, where)


# --- small things -----------------------------------------------------------------------------------------------------


def _named_at(source: Source) -> Span:
    """Where a file names another one."""
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


def variables_of(values: Mapping[str, Plain]) -> frozenset[KeyPath]:
    """Where the variables of a scenario are defined."""
    named = [(key, name) for key in ("let", "matrix") for name in _mapping(values.get(key))]
    cases = values.get("cases")
    first = _mapping(cases[0]) if isinstance(cases, list) and cases else {}
    return frozenset([*named, *(("cases", 0, name) for name in first)])
