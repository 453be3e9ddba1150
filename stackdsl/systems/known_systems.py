"""All systems by name: our own, those on other engines, and what each needs."""

from collections.abc import Iterable

from stability.engines.settings import Package
from stackdsl.systems.peers import PEERS
from stackdsl.systems.systems import SYSTEMS, Method, System

KNOWN = {**SYSTEMS, **PEERS}  # by name: those that come with this package


def system_named(name: str) -> System:
    """A system of ours, or on another engine."""
    return KNOWN[name]


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
