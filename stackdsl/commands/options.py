"""Options that several commands have."""

from collections.abc import Mapping
from pathlib import Path

import click

from stackdsl.systems.peers import NEEDS, PEERS, Extra, missing
from stackdsl.systems.systems import SYSTEMS

FilePath = click.Path(path_type=Path)


def playable(systems: tuple[str, ...], needs: Mapping[str, Extra] = NEEDS) -> tuple[str, ...]:
    """The systems that were asked for, if what they need is installed."""
    for name, extra in missing(systems, needs):
        told = f"'{name}' needs {extra.package}, which is not installed"
        raise click.BadParameter(f"{told}; try: pip install 'stackdsl[{extra.name}]'")
    return tuple(dict.fromkeys(systems))


ONE_FILE = click.argument("file", type=FilePath)
ON_SYSTEMS = click.option(
    "--system",
    "systems",
    multiple=True,
    type=click.Choice([*SYSTEMS, *PEERS]),
    callback=lambda *given: playable(given[-1]),
    help="Only these systems. Those on other engines than PyBullet are played wherever they are asked for.",
)
ON_KEYWORD = click.option("-k", "keyword", default="", help="Only cases whose name contains this.")
ON_TAGS = click.option(
    "--tag", "tags", multiple=True, help="Only scenarios with this tag; with ! in front, without it."
)
LONGEST_LIMIT = 1e6  # [s] eleven days; waiting takes a number of milliseconds in 31 bits
