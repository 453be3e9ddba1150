"""Systems of other packages, found by their entry points in the group `stackdsl.systems` (docs/own-engine.md).

An entry point is called as its system, and is the place of a `System`. What is wrong with one is told in one line.
"""

from collections.abc import Iterator
from importlib.metadata import EntryPoint

from stability.engines.protocol import EngineSettings
from stackdsl.entry_points import GROUP, offered
from stackdsl.simulation.systems import PEERS, SYSTEMS, System


class ForeignSystemError(Exception):
    """A system of another package cannot be used; the text says in one line which, and why."""


def foreign_names() -> tuple[str, ...]:
    """The names of all systems that other packages offer; none is loaded.

    Raises ForeignSystemError if one of them is called as one of ours.
    """
    for name in {**SYSTEMS, **PEERS}.keys() & offered().keys():
        of = _packages(*offered()[name])
        raise ForeignSystemError(f"{of} offers a system called '{name}', as one of stackdsl is; uninstall {of}")
    return tuple(offered())


def foreign_system(name: str) -> System:
    """The system of this name that another package offers; it is loaded.

    Raises KeyError if there is none, and ForeignSystemError if it cannot be used.
    """
    if name not in foreign_names():
        raise KeyError(name)
    entry, *others = offered()[name]
    if others:
        raise ForeignSystemError(f"{_packages(entry, *others)} all offer a system called '{name}'; keep one of them")
    found = _loaded(entry)
    for why in _mistakes(entry, found):
        raise ForeignSystemError(f"the system '{name}' of {_packages(entry)} cannot be used: {why}")
    assert isinstance(found, System)
    return found


def _loaded(entry: EntryPoint) -> object:
    try:
        return entry.load()
    except (Exception, SystemExit) as error:  # whatever the code of others does when it is imported
        why = " ".join(f"{type(error).__name__}: {error}".split())
        told = f"the system '{entry.name}' of {_packages(entry)} cannot be loaded from {entry.value}: {why}"
        raise ForeignSystemError(told) from error


def _mistakes(entry: EntryPoint, found: object) -> Iterator[str]:
    """What is wrong with what an entry point of the group `stackdsl.systems` stands for."""
    if not isinstance(found, System):
        yield f"{entry.value} is a {type(found).__name__}, and must be a stackdsl.simulation.systems.System"
    elif found.name != entry.name:
        yield f"it calls itself '{found.name}', and must be called as its entry point in {GROUP}"
    elif not isinstance(found.engine, EngineSettings):
        what = type(found.engine).__name__
        yield f"its engine is a {what}, and must be a stability.engines.protocol.EngineSettings"
    else:
        kind = type(found.engine)
        yield from (f"{kind.__name__} says no `{said}`" for said in ("package", "world") if not hasattr(kind, said))


def _packages(*entries: EntryPoint) -> str:
    return " and ".join(entry.dist.name if entry.dist is not None else "a package" for entry in entries)
