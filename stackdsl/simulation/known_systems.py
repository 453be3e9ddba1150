"""All systems by name: our own, those on other engines, those of other packages, and what each needs."""

from collections.abc import Iterable

from stability.engines.protocol import Package
from stackdsl.simulation.systems import PEERS, SYSTEMS, Method, System

KNOWN = {**SYSTEMS, **PEERS}  # by name: those that come with this package


def system_named(name: str) -> System:
    """A system of ours, on another engine, or of another package. Raises KeyError if there is none of that name."""
    if name in KNOWN:
        return KNOWN[name]
    from stackdsl.simulation.plugins import foreign_system  # noqa: PLC0415 -- it reads what is installed

    return foreign_system(name)


def needs_of(names: Iterable[str]) -> list[tuple[str, Package]]:
    """What each of some systems needs."""
    return [(name, system_named(name).engine.package) for name in names]


def missing(names: Iterable[str]) -> list[tuple[str, Package]]:
    """Those of some systems that need what is not installed, and what that is."""
    return [(name, package) for name, package in needs_of(names) if not package.installed]


def unplayable(name: str) -> str:
    """Why a system cannot be played here, and what to do about it; empty if it can.

    Proofs need no engine until something moves, so a system that proves is always tried.
    """
    system = system_named(name)
    if system.method is Method.PROVEN or system.engine.package.installed:
        return ""
    return f"'{name}' needs {system.engine.package.name}, which is not installed; try: {system.engine.package.remedy}"
