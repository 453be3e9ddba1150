"""Options that several commands have."""

from collections.abc import Iterable
from math import isfinite
from pathlib import Path

import click

from stability.engines.settings import Package
from stackdsl.checking.keywords import KeywordError, expression_of
from stackdsl.systems.known_systems import KNOWN, needs_of

FilePath = click.Path(path_type=Path)


class Number(click.FloatRange):
    """A number within a range; `nan`, which is neither above a bound nor below one, is none."""

    def convert(self, value: float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number."""
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"'{value}' is no number that means anything", param, ctx)
        return number


class SystemChoice(click.Choice[str]):
    """The name of a system: one of those that are listed, or of one that another package offers."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name. What other packages offer is looked up only if it is none of ours."""
        if value in self.choices:
            return value
        from stackdsl.systems.foreign import ForeignSystemError, foreign_names, foreign_system  # noqa: PLC0415 -- rare

        try:
            others = foreign_names()
            if value in others:
                return foreign_system(value).name
        except ForeignSystemError as error:
            self.fail(str(error), param, ctx)
        listed = ", ".join(f"'{name}'" for name in (*self.choices, *others))
        self.fail(f"'{value}' is not one of {listed}", param, ctx)


SYSTEM_CHOICE = SystemChoice(list(KNOWN))


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


ONE_FILE = click.argument("file", type=FilePath)
ON_SYSTEMS = click.option(
    "--system",
    "systems",
    multiple=True,
    type=SYSTEM_CHOICE,
    callback=lambda *given: playable(given[-1]),
    help="Only these systems. Those on other engines than PyBullet are played wherever they are asked for.",
)


def _expression(texts: tuple[str, ...]) -> str:
    """All of the expressions that were given, as one."""
    for text in texts:
        try:
            expression_of(text)
        except KeywordError as error:
            raise click.BadParameter(str(error)) from error
    given = [text for text in texts if text.strip()]
    return given[0] if len(given) == 1 else " and ".join(f"({text})" for text in given)


ON_KEYWORD = click.option(
    "-k",
    "keyword",
    multiple=True,
    callback=lambda *given: _expression(given[-1]),
    help="Only cases whose name contains this, as in 'tower and not (tuned or stock)'; all of several.",
)
ON_TAGS = click.option(
    "--tag", "tags", multiple=True, help="Only scenarios with this tag; with ! in front, without it."
)
LONGEST_LIMIT = 1e6  # [s] eleven days; waiting takes a number of milliseconds in 31 bits
