"""Options that several commands have."""

from collections.abc import Iterable

import click

from stability.engines.settings import Package
from stackdsl.systems.known_systems import needs_of


def refuse_missing(needs: Iterable[tuple[str, Package]]) -> None:
    """Refuse what needs a package that is not installed, and say how to get it; `needs` are names and packages."""
    for name, package in needs:
        if not package.installed:
            told = f"'{name}' needs {package.name}, which is not installed"
            raise click.BadParameter(f"{told}; try: {package.remedy}")


def playable(systems: tuple[str, ...]) -> tuple[str, ...]:
    """The systems that were asked for, each once, if what they need is installed."""
    refuse_missing(needs_of(systems))
    return tuple(dict.fromkeys(systems))
