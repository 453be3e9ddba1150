"""Looks up the systems that other packages offer by entry points, without loading them.

The time of a look-up grows with the number of installed packages, so it is done only for an unknown name of a system,
or for the list of all systems.
"""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "stackdsl.systems"


class PluginError(Exception):
    """A system of another package cannot be used, or its engine failed. The message is complete, in one line."""


@cache
def offered_systems() -> Mapping[str, tuple["EntryPoint", ...]]:
    """Return the entry points of installed packages by system name. More than one for a name is a conflict."""
    from importlib.metadata import entry_points  # noqa: PLC0415 -- slow to import, and most commands do not need it

    by_name: dict[str, tuple[EntryPoint, ...]] = {}
    for entry in entry_points(group=GROUP):
        by_name[entry.name] = (*by_name.get(entry.name, ()), entry)
    return dict(sorted(by_name.items()))


# Systems to choose for an engine, by the names that users give the engine.
ENGINES: Mapping[str, str] = {
    **dict.fromkeys(
        ("pybullet", "bullet"), "write tuned for PyBullet with settings for stacks, or stock for its default settings"
    ),
    "mujoco": "remove it; MuJoCo is chosen in the call, with `--system mujoco`",
}


def engine_remedy(name: str) -> str:
    """Return the remedy for the name of an engine in place of a system; empty for other names."""
    return ENGINES.get(name.lower(), "")
