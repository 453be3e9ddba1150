"""Which files a scenario may be made of: those inside the root of its project, and no other."""

import os
from difflib import get_close_matches
from itertools import islice
from pathlib import Path as FilePath
from typing import Final

from stackdsl.project_file import OWN_FILE, ProjectError, root_around

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
