"""The files that bricks are made of: found beside the file that names them, and read once for a scenario."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from stackdsl.diagnostics import Diagnostic
from stackdsl.reading.project import OutsideError, file_in_project, root_of
from stackdsl.reading.source import MAX_BYTES, Path, Plain, Source

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


def _named(source: Source) -> Iterator[tuple[Path, str]]:
    """Where a brick says which file it is of."""
    waiting: list[tuple[Path, Plain]] = [((), source.values)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), inner) for key, inner in reversed(value.items())]
        elif isinstance(value, list):
            waiting += [((*path, index), inner) for index, inner in reversed([*enumerate(value)])]
        elif _is_of_brick(path) and isinstance(value, str) and value.strip() and "\0" not in value:
            yield path, value


def _is_of_brick(path: Path) -> bool:
    return path[-1:] == (FILE,) and ("brick" in path[-2:-1] or "brick_types" in path[-3:-2])


def _with(values: dict[str, Plain], path: Path, leaf: str) -> dict[str, Plain]:
    """The values with another one at a path."""
    changed = _changed(values, path, leaf)
    assert isinstance(changed, dict)
    return changed


def _changed(value: Plain, path: Path, leaf: str) -> Plain:
    if not path:
        return leaf
    key, rest = path[0], path[1:]
    if isinstance(value, dict):
        return {**value, str(key): _changed(value[str(key)], rest, leaf)}
    assert isinstance(value, list)
    return [_changed(item, rest, leaf) if index == key else item for index, item in enumerate(value)]
