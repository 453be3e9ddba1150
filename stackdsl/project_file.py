"""The project that scenarios belong to: the nearest directory upwards that says it is one, and what it says.

That is a directory with `stackdsl.toml`, or with a `pyproject.toml` that has a table `[tool.stackdsl]`. Golden files
and what is remembered belong to it, wherever the command is called. Else the working directory counts.
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
REPOSITORY: Final = ".git"  # marks what somebody sent as a whole
KEYS: Final = ("golden", "scenarios")
MOST: Final = 1 << 20  # [bytes] of such a file
STATE: Final = ".stackdsl"  # what is remembered from call to call; nothing is lost with it
STATE_PARTS: Final = (("passed",), ("pending",), ("failed.json",), (".gitignore",))  # what is in it
LONGEST_TOLD: Final = 60  # [characters] of a key
LINKED: Final = f"remove the link, or mark a folder above as the root by a file {OWN_FILE}"


class ProjectError(ValueError):
    """The file that marks a project cannot be read or says what it cannot mean, or a link leads out of the project.

    The message says which, where and what to do.
    """


@dataclass(frozen=True, slots=True)
class Project:
    """Where things are, as seen from the working directory."""

    golden: Path = GOLDEN
    scenarios: Path = SCENARIOS
    root: Path | None = None  # None where nothing marks one

    def goldens(self, asked: Path | None = None) -> Path:
        """The directory of golden files: the one that was asked for, or else the project's own.

        Raises ProjectError where it is written as inside the project, and a link leads it outside.
        """
        golden = asked or self.golden
        try:
            true_folder(golden, confined(golden, self.root or Path()))
        except LeadsOutsideError as error:
            raise ProjectError(f"{golden}: {error.strerror}; {LINKED}") from error
        return golden

    def state(self, golden: Path) -> Path:
        """Where to remember what concerns a directory of golden files.

        Raises ProjectError where it, or a part of it, is a link.
        """
        home = self.root if self.root is not None and golden == self.golden else golden.parent
        for part in STATE_PARTS:
            try:
                unlinked(home / STATE, *part)
            except LeadsOutsideError as error:
                raise ProjectError(f"{error.filename} is a link, which is not followed; remove it") from error
            except OSError:  # what cannot be looked at remembers nothing
                continue
        return home / STATE


def project_of(paths: Sequence[Path]) -> Project:
    """The project around some files and directories, or around the working directory if there are none.

    Raises ProjectError.
    """
    found = _marked(_common(paths) if paths else Path.cwd())
    return Project() if found is None else _project(*found)


def root_around(folder: Path) -> Path | None:
    """The root of the project around a folder; None where nothing marks one. Raises ProjectError."""
    found = _marked(folder)
    return None if found is None else found[0]


def _marked(start: Path) -> tuple[Path, Path, Mapping[str, object]] | None:
    """The nearest folder upwards that is marked as the root of a project, the file that marks it, and its settings.

    The search ends at the root of a repository: a clone that is not marked belongs to no project around it.
    """
    for folder in (start, *start.parents):
        found = _settings(folder)
        if found is not None:
            return folder, *found
        if os.path.exists(folder / REPOSITORY):
            return None
    return None


def _common(paths: Sequence[Path]) -> Path:
    """The directory around all of them; links are left as they are, for goldens belong to where somebody points."""
    try:
        return Path(os.path.commonpath([os.path.abspath(path) for path in paths]))
    except ValueError:  # on several drives, or a NUL in a name, which is told when the file is read
        return Path.cwd()


def _settings(folder: Path) -> tuple[Path, Mapping[str, object]] | None:
    """The file that makes this directory a project, and its settings; None if there is none."""
    own, shared = folder / OWN_FILE, folder / SHARED_FILE
    if os.path.isfile(own):
        return own, _read(own)
    if os.path.isfile(shared) and "stackdsl" in (table := _table(_read(shared), "tool", shared)):
        return shared, _table(table, "stackdsl", shared)
    return None


def _read(file: Path) -> Mapping[str, object]:
    from tomllib import loads  # noqa: PLC0415 -- most directories on the way up have no such file

    try:
        text = read_file(file, MOST + 1, within=file.parent)
        if len(text) > MOST:
            raise ProjectError(f"{_seen(file)} is larger than {MOST >> 20} MiB")
        return loads(text.decode())
    except ProjectError:
        raise
    except LeadsOutsideError as error:
        raise ProjectError(f"{_seen(file)}: {error.strerror}; put the file itself there") from error
    except OSError as error:
        raise ProjectError(f"{_seen(file)} cannot be read: {error.strerror}") from error
    except RecursionError as error:
        raise ProjectError(f"{_seen(file)}: its values are nested too deeply; leave out what is not of use") from error
    except ValueError as error:  # no TOML, no UTF-8, or a number of thousands of digits
        raise ProjectError(f"{_seen(file)} is no TOML: {visible(str(error).partition(';')[0])}") from error


def _table(holder: Mapping[str, object], key: str, file: Path) -> Mapping[str, object]:
    value = holder.get(key, {})
    if not isinstance(value, dict):
        raise ProjectError(f"{_seen(file)}: '{key}' is to be a table, such as [tool.stackdsl]")
    return value


def _project(folder: Path, file: Path, settings: Mapping[str, object]) -> Project:
    for key, value in settings.items():
        if key not in KEYS:
            raise ProjectError(
                f"{_place(file, key)}: unknown key '{_short(key)}' of stackdsl; there are {' and '.join(KEYS)}"
            )
        if isinstance(value, str) and (odd := next((c for c in value if not c.isprintable()), "")):
            message = f"{key} has the character U+{ord(odd):04X}, which is not seen"
            raise ProjectError(f"{_place(file, key)}: {message}; write the name of a directory below the file")
        if not isinstance(value, str) or not value or os.path.isabs(value) or ".." in Path(value).parts:
            raise ProjectError(
                f'{_place(file, key)}: {key} is to be a directory below the file, such as {key} = "{key}"'
            )
    golden, scenarios = (
        str(settings.get(key, default)) for key, default in zip(KEYS, (GOLDEN, SCENARIOS), strict=True)
    )
    return Project(_seen(folder / golden), _seen(folder / scenarios), _seen(folder))


def _short(text: str) -> str:
    return visible(text[:LONGEST_TOLD]) + ("..." if len(text) > LONGEST_TOLD else "")


def _place(file: Path, key: str) -> str:
    """The file, line and column of a key; the file alone if no line begins with the key."""
    written = re.compile(rf"""\s*(?:tool\.)?(?:stackdsl\.)?["']?({re.escape(key)})["']?\s*=""")
    inside = file.name == OWN_FILE
    for number, line in enumerate(
        read_file(file, MOST, within=file.parent).decode("utf-8", "replace").splitlines(), start=1
    ):
        inside = line.split("#")[0].strip() == "[tool.stackdsl]" if line.lstrip().startswith("[") else inside
        if (found := written.match(line)) is not None and (inside or "stackdsl." in line):
            return f"{_seen(file)}:{number}:{found.start(1) + 1}"
    return f"{_seen(file)}"


def home_of(folder: Path) -> Path:
    """The root of the project around a folder; the folder itself where nothing that can be read marks one."""
    try:
        return root_around(folder.absolute()) or folder
    except ProjectError:
        return folder


def confined(path: Path, *folders: Path) -> str:
    """The true path of a file or a directory. Raises LeadsOutsideError if a link leads it out of a folder around it.

    Such folders are every project and repository that the path is written inside of, the project of the working
    directory, and `folders`. Outer projects count too: the target of a link may be marked as a project itself.
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
    """Whether a folder is marked as the root of a project, or by a file that cannot be read."""
    try:
        return _settings(folder) is not None
    except ProjectError:
        return True


def _seen(path: Path) -> Path:
    """A path as it is told: from the working directory on."""
    try:
        return Path(os.path.relpath(path))
    except ValueError:  # on another drive
        return path
