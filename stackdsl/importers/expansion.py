"""Replaces `import` in build steps by `bricks`, each with its position in the imported file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from pydantic import ValidationError

from stackdsl.diagnostics import Diagnostic, Span, reading_order
from stackdsl.importers.built_deck import BuiltDeck, on_deck
from stackdsl.importers.formats import MAX_IMPORTED
from stackdsl.importers.imported_friction import conflict
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError, written_box
from stackdsl.importers.load_warnings import load_warnings
from stackdsl.importers.overhang import permitted_area
from stackdsl.importers.settling import first_unsettleable, settled
from stackdsl.importers.supervised_reading import load_supervised
from stackdsl.language.imports import DefaultUnits, Import
from stackdsl.language.quantities import InputError
from stackdsl.language.schema import BuildStep
from stackdsl.language.validation import in_flow_style, mistakes_at, report_missing_dependency
from stackdsl.language.value_types import MAX_BRICKS
from stackdsl.language.yaml.includes import Library, OutsideError, composed, file_in_project, root_of
from stackdsl.language.yaml.source import KeyPath, Loaded, PlaceBuilder, Plain, Source

IMPORT: Final = "import"
STRENGTH: Final = "strength"


class _InvalidImportError(Exception):
    """An import is invalid; carries the diagnostics."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__(diagnostics)
        self.diagnostics = diagnostics


def expand_file(loaded: Loaded, library: Library) -> Loaded:
    """Resolve the includes and imports of all scenarios of a file.

    A scenario whose includes or imports fail is left out, and the result has its diagnostics.
    """
    made = composed(loaded, library)
    sources: list[Source] = []
    mistakes: list[Diagnostic] = []
    for written in made.sources:
        source = report_missing_dependency(written) or written
        try:
            sources.append(_expanded(source, library) if any(_import_steps(source)) else source)
        except _InvalidImportError as mistake:
            mistakes += mistake.diagnostics
    return replace(
        made,
        sources=tuple(sources),
        diagnostics=(*made.diagnostics, *sorted(dict.fromkeys(mistakes), key=reading_order)),
    )


def _import_steps(source: Source) -> Iterator[tuple[KeyPath, dict[str, Plain]]]:
    """Yield the build steps that have an `import`, with their paths."""
    steps = source.values.get("build")
    for number, step in enumerate(steps if isinstance(steps, list) else ()):
        if isinstance(step, dict) and IMPORT in step:
            yield ("build", number), step


def _expanded(source: Source, library: Library) -> Source:
    build = source.values["build"]
    assert isinstance(build, list)
    steps, parts, places = list(build), dict.fromkeys(source.parts), PlaceBuilder()
    warnings, decks = list(source.warnings), dict(source.decks)
    expanding = dict(_import_steps(source))
    places.keep(source, dict.fromkeys(expanding))
    for path, step in expanding.items():
        number = path[1]
        assert isinstance(number, int)
        load, deck, file, options = _imported(source, path, step, steps[:number], library)
        parts[file] = None
        others = {key: value for key, value in step.items() if key != IMPORT}
        places.note_all(source, others, path, path)
        where = f"imported from {source.key_span_of((*path, IMPORT))}"
        if (area := permitted_area(load, options)) is not None:
            decks[path] = area
        warnings += [
            replace(warning, span=replace(warning.span, where=where)) for warning in load_warnings(load, options)
        ]
        bricks: list[Plain] = []
        places.value_spans[*path, "bricks"] = source.span_of((*path, IMPORT))
        places.key_spans[*path, "bricks"] = source.key_span_of((*path, IMPORT))
        if deck is not None:
            places.value_spans[*path, "bricks", 0] = source.span_of((*path, IMPORT, "deck"))
            bricks.append(deck.written)
        for box in load.boxes:
            places.value_spans[*path, "bricks", len(bricks)] = replace(box.span, where=where)
            bricks.append(_with_strength(written_box(box), step[IMPORT]))
        steps[number] = {**others, "bricks": bricks}
    values = {**source.values, "build": steps}
    return replace(
        source,
        values=values,
        value_spans=places.value_spans,
        key_spans=places.key_spans,
        parts=tuple(parts),
        warnings=tuple(warnings),
        decks=decks,
    )


def _with_strength(brick: dict[str, Plain], entry: Plain) -> dict[str, Plain]:
    """Return an imported brick with the strength of the import."""
    kind = brick["brick"]
    if not isinstance(entry, dict) or STRENGTH not in entry or not isinstance(kind, dict):
        return brick
    return {**brick, "brick": {**kind, STRENGTH: entry[STRENGTH]}}


def _imported(
    source: Source, path: KeyPath, step: dict[str, Plain], before: Sequence[Plain], library: Library
) -> tuple[ImportedLoad, BuiltDeck | None, str, Import]:
    """Read the import of a step: the settled load, its pallet, the path of its file, and the import options.

    `before` has the steps before this one, without imports.
    """
    here = (*path, IMPORT)
    for other in ("bricks",):
        if other in step:
            message = f"`{IMPORT}` and `{other}` exclude each other in one step"
            raise _InvalidImportError(
                Diagnostic("SD108", source.key_span_of((*path, other)), message, "split the step into two")
            )
    _refuse_misplaced(source, path, step)
    options = _options(source, here, step[IMPORT])
    span = source.span_of((*here, "file"))
    file = _file(options.file, span)

    def read_file(name: str) -> bytes:
        return library.bytes_of(path_beside(name, file), MAX_IMPORTED, root_of(file))

    try:
        data = library.bytes_of(file, MAX_IMPORTED, root_of(span.file))
        load = load_supervised(data, file, options, read_file)
    except UnreadableLoadError as error:
        where = f"imported from {source.key_span_of(here)}"
        diagnostics = [replace(each, span=replace(each.span, where=where)) for each in error.diagnostics]
        if error.proposed and isinstance(step[IMPORT], dict) and not span.key:
            entry = _completed(step[IMPORT], error.proposed)
            hint = f"{diagnostics[0].hint}; in {source.key_span_of(here)}, write `{entry}`"
            diagnostics[0] = replace(diagnostics[0], hint=hint)
        raise _InvalidImportError(*diagnostics) from error
    except OSError as error:
        message = f"cannot read the file: {error.strerror}"
        raise _InvalidImportError(
            Diagnostic("SD113", span, message, "check the path and the permissions of the file")
        ) from error
    if len(load.boxes) > MAX_BRICKS:
        message = f"the load has {len(load.boxes)} boxes; the maximum is {MAX_BRICKS}"
        raise _InvalidImportError(
            Diagnostic("SD206", span, message, "split the file, and import its parts in separate steps")
        )
    if (unfit := first_unsettleable(load, options.settle)) is not None:
        hint = "write `settle: as written`, or import an upright box"
        raise _InvalidImportError(
            Diagnostic(
                "SD115", unfit.span, "`settle` can move upright boxes only, but this body is inclined or a solid", hint
            )
        )
    load, deck = _on_deck(load, options, source.span_of((*here, "deck")))
    load = _with_closed_joints(load, options)
    if (mistake := conflict(load, options, source, span)) is not None:
        raise _InvalidImportError(mistake)
    return _settled(load, deck, options, source, here, before), deck, file, options


def _on_deck(load: ImportedLoad, options: Import, span: Span) -> tuple[ImportedLoad, BuiltDeck | None]:
    """Return the load at the height of its deck, and the pallet that is built. Raises _InvalidImportError."""
    try:
        return on_deck(load, options)
    except InputError as error:
        raise _InvalidImportError(Diagnostic(error.code, span, error.message, error.hint)) from error


def _settled(  # noqa: PLR0913, PLR0917 -- a load, all below it, and its place in the scenario
    load: ImportedLoad,
    deck: BuiltDeck | None,
    options: Import,
    source: Source,
    here: KeyPath,
    before: Sequence[Plain],
) -> ImportedLoad:
    """Return the load, settled on its deck and on the bricks of earlier steps. Raises _InvalidImportError."""
    settle, span = options.settle, source.span_of((*here, "settle"))
    if not settle.lowered and settle.within is None:
        return load
    from stackdsl.importers.placed_before import odd_support, placed_before  # noqa: PLC0415 -- few loads settle

    try:
        below = placed_before(source, before)
    except InputError as error:
        raise _InvalidImportError(Diagnostic(error.code, span, error.message, error.hint)) from error
    if (odd := odd_support(load, below)) is not None:
        box, name = odd
        message = f"`settle` knows upright boxes only, but '{box.name or 'a box'}' lies over '{name}', which is none"
        raise _InvalidImportError(
            Diagnostic("SD115", span, message, "write `settle: as written`, with the heights in the file")
        )
    own = deck.boxes if deck is not None else ()
    return settled(load, settle, supports=(*own, *below.boxes)).load


def _with_closed_joints(load: ImportedLoad, options: Import) -> ImportedLoad:
    """Return the load, with closed joints if the author wants that. Raises _InvalidImportError."""
    if options.settle.closed is None:
        return load
    from stackdsl.importers.closing import OpenJointError, with_closed_joints  # noqa: PLC0415 -- it brings numpy

    try:
        return with_closed_joints(load, options.settle.closed).load
    except OpenJointError as error:
        raise _InvalidImportError(Diagnostic("SD115", error.box.span, error.message, error.hint)) from error


def path_beside(name: str, file: str) -> str:
    """Resolve a file name that stands in an imported file. Raises OSError, also for a path outside the project."""
    try:
        return file_in_project(name, file, root_of(file))
    except OutsideError as error:
        raise OSError(f"{error.message}; {error.hint}") from error


def _completed(written: dict[str, Plain], proposed: Mapping[str, Plain]) -> str:
    """Return an import with the values that are proposed for it."""
    units = {key: value for key, value in proposed.items() if key in DefaultUnits.model_fields}
    others = {key: value for key, value in proposed.items() if key not in units}
    return f"{IMPORT}: {in_flow_style({**written, **({'units': units} if units else {}), **others})}"


def _refuse_misplaced(source: Source, path: KeyPath, step: dict[str, Plain]) -> None:
    """Raise _InvalidImportError for keys of `import` that stand beside it."""
    misplaced = [key for key in step if key in Import.model_fields and key not in BuildStep.model_fields]
    if misplaced and isinstance(written := step[IMPORT], dict):
        whole = in_flow_style({**written, **{key: step[key] for key in misplaced}})
        hint = f"this key belongs in `{IMPORT}`: write `{IMPORT}: {whole}`"
        raise _InvalidImportError(
            *(Diagnostic("SD101", source.key_span_of((*path, key)), f"unknown key '{key}'", hint) for key in misplaced)
        )


def _options(source: Source, here: KeyPath, written: Plain) -> Import:
    try:
        return Import.model_validate(written)
    except ValidationError as error:
        raise _InvalidImportError(*mistakes_at(error, source, here)) from error


def _file(written: str, span: Span) -> str:
    if not written.strip() or "\0" in written:
        raise _InvalidImportError(
            Diagnostic("SD103", span, "expected the path of a file", "write, for example, load.csv")
        )
    try:
        return file_in_project(written.strip(), span.file, root_of(span.file))
    except OutsideError as error:
        raise _InvalidImportError(Diagnostic("SD113", span, error.message, error.hint)) from error
