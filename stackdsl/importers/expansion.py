"""`import` in a step of the build -> `bricks`: each with its place in the file that it comes from."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from pydantic import ValidationError

from stackdsl.diagnostics import Diagnostic, Span, reading_order
from stackdsl.importers.formats import MAX_IMPORTED
from stackdsl.importers.imported_friction import disagreement
from stackdsl.importers.load import UnreadableLoadError, written_box
from stackdsl.importers.overhang import warned
from stackdsl.importers.settling import Settled, cannot_settle, settled
from stackdsl.importers.supervised_reading import load_supervised
from stackdsl.language.imports import Import
from stackdsl.language.validation import mistakes_at, report_missing_dependency
from stackdsl.language.value_types import MAX_BRICKS
from stackdsl.language.yaml.includes import Library, OutsideError, composed, file_in_project, root_of
from stackdsl.language.yaml.source import KeyPath, Loaded, PlaceBuilder, Plain, Source

IMPORT: Final = "import"


class _MistakeError(Exception):
    """What is wrong with an import, as diagnostics."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__(diagnostics)
        self.diagnostics = diagnostics


@dataclass(frozen=True, slots=True)
class Taken:
    """A step that imports, and what came of it."""

    path: KeyPath  # of the step
    settled: Settled


def whole(loaded: Loaded, library: Library) -> Loaded:
    """The scenarios of a file with all that they take from others; those that cannot have it are left out, and told."""
    made = composed(loaded, library)
    sources: list[Source] = []
    mistakes: list[Diagnostic] = []
    for written in made.sources:
        source = report_missing_dependency(written) or written
        try:
            sources.append(_expanded(source, library) if any(_steps(source)) else source)
        except _MistakeError as mistake:
            mistakes += mistake.diagnostics
    return replace(
        made,
        sources=tuple(sources),
        diagnostics=(*made.diagnostics, *sorted(dict.fromkeys(mistakes), key=reading_order)),
    )


def taken(source: Source, library: Library) -> list[Taken]:
    """What each step of a scenario imports. Raises _MistakeError."""
    return [Taken(path, _taken(source, path, step, library)[0]) for path, step in _steps(source)]


def _steps(source: Source) -> Iterator[tuple[KeyPath, dict[str, Plain]]]:
    """The steps that import, with their paths."""
    steps = source.values.get("build")
    for number, step in enumerate(steps if isinstance(steps, list) else ()):
        if isinstance(step, dict) and IMPORT in step:
            yield ("build", number), step


def _expanded(source: Source, library: Library) -> Source:
    build = source.values["build"]
    assert isinstance(build, list)
    steps, parts, places = list(build), dict.fromkeys(source.parts), PlaceBuilder()
    odd = list(source.warnings)
    expanding = dict(_steps(source))
    places.keep(source, dict.fromkeys(expanding))
    for path, step in expanding.items():
        number = path[1]
        assert isinstance(number, int)
        found, file, asked = _taken(source, path, step, library)
        parts[file] = None
        others = {key: value for key, value in step.items() if key != IMPORT}
        places.note_all(source, others, path, path)
        where = f"imported from {source.key_span_of((*path, IMPORT))}"
        odd += [replace(each, span=replace(each.span, where=where)) for each in warned(found.load, asked)]
        bricks: list[Plain] = []
        places.value_spans[*path, "bricks"] = source.span_of((*path, IMPORT))
        places.key_spans[*path, "bricks"] = source.key_span_of((*path, IMPORT))
        for box in found.load.boxes:
            places.value_spans[*path, "bricks", len(bricks)] = replace(box.span, where=where)
            bricks.append(written_box(box))
        steps[number] = {**others, "bricks": bricks}
    values = {**source.values, "build": steps}
    return replace(
        source,
        values=values,
        value_spans=places.value_spans,
        key_spans=places.key_spans,
        parts=tuple(parts),
        warnings=tuple(odd),
    )


def _taken(source: Source, path: KeyPath, step: dict[str, Plain], library: Library) -> tuple[Settled, str, Import]:
    """What a step imports, the file that it comes from, and how it is asked for."""
    here = (*path, IMPORT)
    for other in ("bricks",):
        if other in step:
            message = f"a step has `{IMPORT}` or `{other}`, not both"
            raise _MistakeError(
                Diagnostic("SD108", source.key_span_of((*path, other)), message, "make two steps of them")
            )
    asked = _asked(source, here, step[IMPORT])
    span = source.span_of((*here, "file"))
    file = _file(asked.file, span)

    def beside(named: str) -> bytes:
        return library.bytes_of(file_beside(named, file), MAX_IMPORTED, root_of(file))

    try:
        data = library.bytes_of(file, MAX_IMPORTED, root_of(span.file))
        load = load_supervised(data, file, asked, beside)
    except UnreadableLoadError as error:
        where = f"imported from {source.key_span_of(here)}"
        told = [replace(each, span=replace(each.span, where=where)) for each in error.diagnostics]
        raise _MistakeError(*told) from error
    except OSError as error:
        message = f"cannot read the file: {error.strerror}"
        raise _MistakeError(Diagnostic("SD113", span, message, "name a file that can be read")) from error
    if len(load.boxes) > MAX_BRICKS:
        message = f"the load has {len(load.boxes)} boxes, and {MAX_BRICKS} is the most"
        raise _MistakeError(Diagnostic("SD206", span, message, "import it in parts"))
    if (odd := cannot_settle(load, asked.settle)) is not None:
        hint = "write `settle: as written`, or straighten it"
        raise _MistakeError(Diagnostic("SD115", odd.span, "a box that leans, or a solid, cannot be lowered", hint))
    if (mistake := disagreement(load, source, span)) is not None:
        raise _MistakeError(mistake)
    return settled(load, asked.settle), file, asked


def file_beside(named: str, file: str) -> str:
    """The path of a file that an imported one names. Raises OSError, also for one outside of the project."""
    try:
        return file_in_project(named, file, root_of(file))
    except OutsideError as error:
        raise OSError(f"{error.message}; {error.hint}") from error


def _asked(source: Source, here: KeyPath, written: Plain) -> Import:
    try:
        return Import.model_validate(written)
    except ValidationError as error:
        raise _MistakeError(*mistakes_at(error, source, here)) from error


def _file(written: str, span: Span) -> str:
    if not written.strip() or "\0" in written:
        raise _MistakeError(Diagnostic("SD103", span, "expected the path of a file", "write such as load.csv"))
    try:
        return file_in_project(written.strip(), span.file, root_of(span.file))
    except OutsideError as error:
        raise _MistakeError(Diagnostic("SD113", span, error.message, error.hint)) from error
