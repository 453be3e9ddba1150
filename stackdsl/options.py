"""Options that several commands have."""

import click

from stackdsl.playing.peers import missing


def playable(systems: tuple[str, ...]) -> tuple[str, ...]:
    """The systems that were asked for, if what they need is installed."""
    for peer in missing(systems):
        package = peer.package
        raise click.BadParameter(
            f"'{peer.system.name}' needs {package}, which is not installed; try: pip install 'stackdsl[{package}]'"
        )
    return tuple(dict.fromkeys(systems))
