"""Which systems other packages offer, by their entry points. Nothing of them is loaded, and nothing is read before.

Looking them up takes as long as the packages of the environment are many, so it is done where one is asked for by name,
or where all are asked for.
"""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "stackdsl.systems"


@cache
def offered() -> Mapping[str, tuple["EntryPoint", ...]]:
    """The entry points of all packages that are installed, by the name of a system; there should be one of a name."""
    from importlib.metadata import entry_points  # noqa: PLC0415 -- no start of a command pays for it

    found: dict[str, tuple[EntryPoint, ...]] = {}
    for entry in entry_points(group=GROUP):
        found[entry.name] = (*found.get(entry.name, ()), entry)
    return dict(sorted(found.items()))
