"""Options that several commands have."""

from collections.abc import Mapping

import click

from stackdsl.systems.peers import NEEDS, Extra, missing


def playable(systems: tuple[str, ...], needs: Mapping[str, Extra] = NEEDS) -> tuple[str, ...]:
    """The systems that were asked for, if what they need is installed."""
    for name, extra in missing(systems, needs):
        told = f"'{name}' needs {extra.package}, which is not installed"
        raise click.BadParameter(f"{told}; try: pip install 'stackdsl[{extra.name}]'")
    return tuple(dict.fromkeys(systems))
