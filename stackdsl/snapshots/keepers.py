"""Who keeps a golden file that is not of the project's own scenarios: a test in Python, or YAML that stands elsewhere.

The file says so itself, in one line, so that whoever checks all scenarios of a project knows what is not theirs to
remove. Nothing is compared with it, and what is locked is the same whoever keeps it.
"""

import json
import os
import re
from collections.abc import Collection
from contextlib import suppress
from errno import ENAMETOOLONG
from pathlib import Path
from typing import Final

from stackdsl.disk import leads_outside, read_file

ELSEWHERE: Final = "elsewhere"  # in the place of a file that is not below the project, or is none, as in a notebook
LINE: Final = re.compile(rb'^  "kept_by": ("(?:[^"\\\n]|\\.)*"),?\r?$', re.MULTILINE)


def keeper_of(file: str, golden: Path, scenarios: Path) -> str:
    """What a golden file is to say of who keeps it; empty of what is written below the directory of scenarios.

    `file` is where the scenario, or the test, is written; `golden` the directory of golden files, `scenarios` that of
    the scenarios that are checked together with it.
    """
    ways = [(Path(way(file)), Path(way(scenarios)), Path(way(golden.parent))) for way in (_absolute, os.path.realpath)]
    if any(own.is_relative_to(folder) for own, folder, _ in ways):
        return ""
    inside = [own.relative_to(home).as_posix() for own, _, home in ways if own.is_relative_to(home)]
    return next((name for name in inside if is_there(name, golden)), ELSEWHERE)


def _absolute(path: str | Path) -> str:
    return os.path.abspath(path)  # a link is left as it is


def keeper_in(content: object) -> str:
    """Who keeps a golden file by what it holds; empty where it says nothing."""
    found = LINE.search(content) if isinstance(content, bytes) else None
    with suppress(ValueError):
        value = json.loads(found[1]) if found is not None else ""
        return value if isinstance(value, str) else ""
    return ""


def is_there(keeper: str, golden: Path) -> bool:
    """Whether who keeps a file of a directory is still there, as far as one knows; outside of the project is nobody."""
    if keeper in ("", ELSEWHERE):
        return bool(keeper)
    try:
        return not leads_outside(golden.parent / keeper, golden.parent) and os.path.isfile(golden.parent / keeper)
    except OSError as error:  # where one may not look, it may be there
        return error.errno != ENAMETOOLONG
    except ValueError:  # a name that no file has
        return False


def is_kept(file: Path, golden: Path, checked: Collection[str]) -> bool:
    """Whether somebody else keeps a golden file, beside those files, by their true paths, of which all is known."""
    try:
        keeper = keeper_in(read_file(file, within=golden))
    except OSError:
        return False
    return is_there(keeper, golden) and os.path.realpath(golden.parent / keeper) not in checked
