"""Finds the project of scenarios, the nearest marked directory upwards, and reads its settings.

A directory is marked by `stackdsl.toml`, or by a `pyproject.toml` with a table `[tool.stackdsl]`. Golden files and
cached results belong to the project, from wherever the command is called. Without a mark, the working directory counts.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from errno import ELOOP
from pathlib import Path
from typing import Final

from stackdsl.disk import LeadsOutsideError, called, is_below, read_file, true_folder, unlinked
from stackdsl.shown_text import visible

GOLDEN: Final = Path("golden")
SCENARIOS: Final = Path("scenarios")
OWN_FILE: Final = "stackdsl.toml"
SHARED_FILE: Final = "pyproject.toml"
REPOSITORY: Final = ".git"  # marks a repository, which may come from somebody else
KEYS: Final = ("golden", "scenarios")
MOST: Final = 1 << 20  # [bytes] of a project file
STATE: Final = ".stackdsl"  # cache directory, which can be deleted at any time
STATE_PARTS: Final = (("passed",), ("pending",), ("failed.json",), (".gitignore",))  # its contents
LONGEST_KEY: Final = 60  # [characters] of a key in a message
LINKED: Final = f"remove the link, or mark a folder above as the root by a file {OWN_FILE}"


class ProjectError(ValueError):
    """A project file is unreadable or invalid, or a link leads out of the project.

    The message has the file, the cause and the remedy.
    """


@dataclass(frozen=True, slots=True)
class Project:
    """The directories of a project, relative to the working directory."""

    golden: Path = GOLDEN
    scenarios: Path = SCENARIOS
    root: Path | None = None  # None without a mark

    def goldens(self, requested: Path | None = None) -> Path:
        """Return the directory of golden files: `requested`, or by default that of the project.

        Raises ProjectError if it is inside the project by its name, but a link leads outside.
        """
        golden = requested or self.golden
        try:
            true_folder(golden, confined(golden, self.root or Path()))
        except LeadsOutsideError as error:
            raise ProjectError(f"{golden}: {error.strerror}; {LINKED}") from error
        return golden

    def state(self, golden: Path) -> Path:
        """Return the cache directory for a directory of golden files.

        Raises ProjectError if it, or a part of it, is a link.
        """
        home = self.root if self.root is not None and golden == self.golden else golden.parent
        for part in STATE_PARTS:
            try:
                unlinked(home / STATE, *part)
            except LeadsOutsideError as error:
                raise ProjectError(f"{error.filename} is a link, which is not followed; remove it") from error
            except OSError:  # an unreadable cache is empty
                continue
        return home / STATE


def project_of(paths: Sequence[Path]) -> Project:
    """Return the project around files and directories, or around the working directory if there are none.

    Raises ProjectError.
    """
    marked = _marked(_common(paths) if paths else Path.cwd())
    return Project() if marked is None else _project(*marked)


def root_around(folder: Path) -> Path | None:
    """Return the root of the project around a folder; None without a mark. Raises ProjectError."""
    marked = _marked(folder)
    return None if marked is None else marked[0]


def _marked(start: Path) -> tuple[Path, Path, Mapping[str, object]] | None:
    """Return the nearest marked folder upwards, the project file in it, and its settings.

    The search ends at the root of a repository: a clone without a mark does not belong to a project around it.
    """
    for folder in (start, *start.parents):
        marked = _settings(folder)
        if marked is not None:
            return folder, *marked
        if os.path.exists(folder / REPOSITORY):
            return None
    return None


def _common(paths: Sequence[Path]) -> Path:
    """Return the common parent directory. Links are not resolved, so that goldens are near the path that is given."""
    try:
        return Path(os.path.commonpath([os.path.abspath(path) for path in paths]))
    except ValueError:  # on several drives, or a NUL in a name, which is reported when the file is read
        return Path.cwd()


def _settings(folder: Path) -> tuple[Path, Mapping[str, object]] | None:
    """Return the project file in a directory and its settings; None if there is none."""
    own, shared = folder / OWN_FILE, folder / SHARED_FILE
    if os.path.isfile(own):
        return own, _read(own)
    if os.path.isfile(shared) and "stackdsl" in (table := _table(_read(shared), "tool", shared)):
        return shared, _table(table, "stackdsl", shared)
    return None


def _read(file: Path) -> Mapping[str, object]:
    from tomllib import loads  # noqa: PLC0415 -- most directories have no such file

    try:
        text = read_file(file, MOST + 1, within=file.parent)
        if len(text) > MOST:
            raise ProjectError(f"{_seen(file)} is larger than {MOST >> 20} MiB")
        return loads(text.decode())
    except ProjectError:
        raise
    except LeadsOutsideError as error:
        raise ProjectError(f"{_seen(file)}: {error.strerror}; replace the link by the file") from error
    except OSError as error:
        raise ProjectError(f"{_seen(file)} cannot be read: {error.strerror}") from error
    except RecursionError as error:
        raise ProjectError(f"{_seen(file)}: its values are nested too deeply; remove unused values") from error
    except ValueError as error:  # no TOML, no UTF-8, or a number of thousands of digits
        raise ProjectError(f"{_seen(file)} is not valid TOML: {visible(str(error).partition(';')[0])}") from error


def _table(holder: Mapping[str, object], key: str, file: Path) -> Mapping[str, object]:
    value = holder.get(key, {})
    if not isinstance(value, dict):
        raise ProjectError(f"{_seen(file)}: '{key}' must be a table, such as [tool.stackdsl]")
    return value


def _project(folder: Path, file: Path, settings: Mapping[str, object]) -> Project:
    for key, value in settings.items():
        if key not in KEYS:
            raise ProjectError(
                f"{_place(file, key)}: unknown key '{_short(key)}' of stackdsl; the keys are {' and '.join(KEYS)}"
            )
        if isinstance(value, str) and (odd := next((c for c in value if not c.isprintable()), "")):
            message = f"{key} has the invisible character U+{ord(odd):04X}"
            raise ProjectError(f"{_place(file, key)}: {message}; write the name of a directory below the file")
        if not isinstance(value, str) or not value or os.path.isabs(value) or ".." in Path(value).parts:
            raise ProjectError(
                f'{_place(file, key)}: {key} must be a directory below the file, such as {key} = "{key}"'
            )
    golden, scenarios = (
        str(settings.get(key, default)) for key, default in zip(KEYS, (GOLDEN, SCENARIOS), strict=True)
    )
    return Project(_seen(folder / golden), _seen(folder / scenarios), _seen(folder))


def _short(text: str) -> str:
    return visible(text[:LONGEST_KEY]) + ("..." if len(text) > LONGEST_KEY else "")


def _place(file: Path, key: str) -> str:
    """Return file, line and column of a key; the file alone if no line begins with the key."""
    pattern = re.compile(rf"""\s*(?:tool\.)?(?:stackdsl\.)?["']?({re.escape(key)})["']?\s*=""")
    inside = file.name == OWN_FILE
    for number, line in enumerate(
        read_file(file, MOST, within=file.parent).decode("utf-8", "replace").splitlines(), start=1
    ):
        inside = line.split("#")[0].strip() == "[tool.stackdsl]" if line.lstrip().startswith("[") else inside
        if (match := pattern.match(line)) is not None and (inside or "stackdsl." in line):
            return f"{_seen(file)}:{number}:{match.start(1) + 1}"
    return f"{_seen(file)}"


def home_of(folder: Path) -> Path:
    """Return the root of the project around a folder; the folder itself without a readable mark."""
    try:
        return root_around(folder.absolute()) or folder
    except ProjectError:
        return folder


def confined(path: Path, *folders: Path) -> str:
    """Return the resolved path of a file or directory. Raises LeadsOutsideError if a link leads out of a folder.

    The folders are all projects and repositories around the path as written, the project of the working directory, and
    `folders`. Outer projects count too, since the target of a link may be marked as a project itself.
    """
    written, true = os.path.abspath(path), os.path.realpath(path)
    if written == true:
        return true
    for folder in (*_around(written), *folders):
        if is_below(written, os.path.abspath(folder)) and not is_below(true, true_folder(folder)):
            raise LeadsOutsideError(ELOOP, f"a link leads out of {called(folder)}", str(path))
    return true


def _around(written: str) -> Iterator[Path]:
    yield home_of(Path())
    for folder in Path(written).parents:
        if _is_marked(folder) or os.path.exists(folder / REPOSITORY):
            yield folder


def _is_marked(folder: Path) -> bool:
    """Return whether a folder has a project file, readable or not."""
    try:
        return _settings(folder) is not None
    except ProjectError:
        return True


def _seen(path: Path) -> Path:
    """Return a path relative to the working directory, for messages."""
    try:
        return Path(os.path.relpath(path))
    except ValueError:  # on another drive
        return path
