"""Systems of other packages, found by their entry points in the group `stackdsl.systems` (docs/own-engine.md).

An entry point has the name of its system and refers to a `System`. Errors in an entry point are reported in one line.
"""

from collections.abc import Iterable, Iterator
from importlib.metadata import EntryPoint

from stability.engines.protocol import EngineSettings
from stackdsl.entry_points import GROUP, offered_systems
from stackdsl.simulation.systems import PEERS, SYSTEMS, System


class ForeignSystemError(Exception):
    """A system of another package cannot be used; the message names it and the reason, in one line."""


def foreign_names() -> tuple[str, ...]:
    """Return the names of all systems of other packages, without loading any.

    Raises ForeignSystemError if one of them has the name of a system of this package.
    """
    for name in {**SYSTEMS, **PEERS}.keys() & offered_systems().keys():
        package = _packages(*offered_systems()[name])
        raise ForeignSystemError(
            f"{package} offers a system with the name '{name}', which stackdsl reserves; uninstall {package}"
        )
    return tuple(offered_systems())


def foreign_system(name: str) -> System:
    """Load and return a system of another package.

    Raises KeyError if there is none of that name, and ForeignSystemError if it cannot be used.
    """
    if name not in foreign_names():
        raise KeyError(name)
    entry, *others = offered_systems()[name]
    if others:
        raise ForeignSystemError(
            f"{_packages(entry, *others)} offer systems with the same name '{name}'; uninstall all but one"
        )
    system = _loaded(entry)
    for mistake in _mistakes(entry, system):
        raise ForeignSystemError(f"the system '{name}' of {_packages(entry)} cannot be used: {mistake}")
    assert isinstance(system, System)
    return system


def distributions_of(names: Iterable[str]) -> tuple[str, ...]:
    """The distributions that bring those of some systems that come with other packages, each once."""
    entries = (offered_systems()[name][0] for name in sorted({*names} & offered_systems().keys()))
    return tuple(dict.fromkeys(entry.dist.name for entry in entries if entry.dist is not None))


def _loaded(entry: EntryPoint) -> object:
    try:
        return entry.load()
    except (Exception, SystemExit) as error:  # importing another package may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        message = f"the system '{entry.name}' of {_packages(entry)} cannot be loaded from {entry.value}: {reason}"
        raise ForeignSystemError(message) from error


def _mistakes(entry: EntryPoint, system: object) -> Iterator[str]:
    """Yield every error in the object that an entry point of the group `stackdsl.systems` refers to."""
    if not isinstance(system, System):
        yield f"{entry.value} is of type {type(system).__name__}, but must be a stackdsl.simulation.systems.System"
    elif system.name != entry.name:
        yield f"its name is '{system.name}', but must be the name of its entry point in {GROUP}"
    elif not isinstance(system.engine, EngineSettings):
        kind = type(system.engine).__name__
        yield f"its engine is of type {kind}, but must be a stability.engines.protocol.EngineSettings"
    else:
        engine = type(system.engine)
        yield from (f"{engine.__name__} has no `{name}`" for name in ("package", "world") if not hasattr(engine, name))


def _packages(*entries: EntryPoint) -> str:
    return " and ".join(entry.dist.name if entry.dist is not None else "a package" for entry in entries)
