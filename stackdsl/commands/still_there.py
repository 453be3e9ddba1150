"""Which of what waits is still a case: its scenario may have been renamed, or taken out, since it was checked."""

import os
from collections.abc import Sequence
from pathlib import Path

from stackdsl.checking.gathering import STDIN
from stackdsl.checking.memory import Memory
from stackdsl.checking.survey import survey
from stackdsl.disk import is_stream, leads_outside
from stackdsl.snapshots.pending import Pending, Waiting


def no_longer_cases(pending: Sequence[Pending], waiting: Waiting) -> frozenset[str]:
    """The golden files of what waits, as that names them, of which the file of YAML has no such case any more.

    Files are read anew where they have changed; of one with mistakes no case is known. What waits may have been made by
    whoever sent the project, so no file outside of it is read.
    """
    named = {each.file for each in pending if each.file}
    files = sorted(file for file in named if _is_own(file, waiting.home))
    memory = Memory(waiting.state, used=True)
    found = {file: {case.name for case in survey([waiting.home / file], memory).cases} for file in files}
    return frozenset(each.golden for each in pending if each.file in found and each.case not in found[each.file])


def _is_own(file: str, home: Path) -> bool:
    """Whether a name may be that of a file below a folder: "-" is the input, and a `..` or a link may lead outside."""
    path = home / file
    return path != STDIN and not is_stream(path) and not leads_outside(path, home)


def why_not(pending: Pending, waiting: Waiting) -> str:
    """What is told of one that cannot be accepted, as it is no case any more."""
    there = os.path.isfile(waiting.home / Path(pending.file))
    lacks = f"{pending.file} has no case {pending.case} any more" if there else f"{pending.file} is gone"
    return f"{lacks}: it was renamed, taken out or mistaken since; check again, or forget it by stackdsl golden reject"
