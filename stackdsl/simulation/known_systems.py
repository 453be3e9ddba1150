"""All systems by name, those of other packages included, and the package that each needs."""

from collections.abc import Iterable

from stability.engines.protocol import Package
from stackdsl.simulation.systems import PEERS, SYSTEMS, Method, System

KNOWN = {**SYSTEMS, **PEERS}  # by name: those that come with this package


def system_named(name: str) -> System:
    """Return a system of this or another package. Raises KeyError if no system has that name."""
    if name in KNOWN:
        return KNOWN[name]
    from stackdsl.simulation.plugins import foreign_system  # noqa: PLC0415 -- it reads the installed packages

    return foreign_system(name)


def needs_of(names: Iterable[str]) -> list[tuple[str, Package]]:
    """Return each system with the package that it needs."""
    return [(name, system_named(name).engine.package) for name in names]


def missing(names: Iterable[str]) -> list[tuple[str, Package]]:
    """Return the systems whose package is not installed, with that package."""
    return [(name, package) for name, package in needs_of(names) if not package.installed]


def unplayable(name: str) -> str:
    """Return why a system cannot be played here, and the remedy; empty if it can.

    A system with proofs is always tried, as it needs no engine until a brick moves.
    """
    system = system_named(name)
    if system.method is Method.PROVEN or system.engine.package.installed:
        return ""
    return f"'{name}' needs {system.engine.package.name}, which is not installed; try: {system.engine.package.remedy}"
