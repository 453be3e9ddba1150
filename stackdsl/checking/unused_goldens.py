"""Which golden files belong to no case of a project's scenarios."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol

from stackdsl.diagnostics import Diagnostic
from stackdsl.snapshots.file_names import golden_file
from stackdsl.snapshots.golden import obsolete
from stackdsl.snapshots.record import Identity


class Named(Protocol):
    """A case, as far as its golden file goes."""

    @property
    def identity(self) -> Identity:
        """What it is called."""

    @property
    def file(self) -> str:
        """The file that has it."""


class AllFound(Protocol):
    """What was found of a whole set of scenarios."""

    @property
    def cases(self) -> Sequence[Named]:
        """All cases without a mistake."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


def unused_goldens(found: AllFound, golden: Path, others: Iterable[str] = ()) -> tuple[str, ...]:
    """The golden files below a directory that belong to no case of a whole set of scenarios.

    None where anything in the set is mistaken, or where it is empty: then nobody knows what belongs to it.
    `others` are files of the set that may have no case.
    """
    if found.diagnostics or not found.cases:
        return ()
    used = [golden_file(golden, case.identity).relative_to(golden).as_posix() for case in found.cases]
    return obsolete(golden, used, whole_set=True, checked={*others, *(case.file for case in found.cases)})
