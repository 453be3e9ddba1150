"""`stackdsl settle` and `stackdsl pushover`: structures that move by finite displacements."""

from collections.abc import Callable, Iterator
from functools import partial
from math import inf
from pathlib import Path

import click

from stackdsl.checking.cases import Case
from stackdsl.cli.one_file import ON_PICTURE, Request, Writing, draw, refuse_several, statics_command
from stackdsl.cli.options import Number
from stackdsl.cli.terminal import counted, tell
from stackdsl.exits import ExitCode
from stackdsl.report.large_motion import motion_lines, motion_table
from stackdsl.studies.large_motion import FollowedMotion, pushed_over_in, settled_in
from stackdsl.studies.limit_search import SearchError
from stackdsl.viewing.plots import drawn_motion
from stackdsl.viewing.settled import drawn_positions

MOTIONS = Writing[FollowedMotion](motion_lines, motion_table)
INSTEAD = "use fewer bricks"

Follow = Callable[[Case, str, Callable[[float], None]], FollowedMotion]


@statics_command("settle", plot=True)
@ON_PICTURE
@click.option(
    "--until",
    type=Number(1e-6, 1e6),
    help="Largest multiple of the written movement. Default: until the structure falls.",
)
def settle_command(request: Request, picture: Path | None, until: float | None) -> ExitCode:
    """Move the supports of FILE until the structure falls, and list its hinges and its thrust."""
    most = inf if until is None else until
    return _followed(request, picture, lambda case, name, on_step: settled_in(case, name, most, on_step))


@statics_command("pushover", plot=True)
@ON_PICTURE
def pushover_command(request: Request, picture: Path | None) -> ExitCode:
    """Push the structure of FILE over by its loads, and list the load factor by displacement."""
    return _followed(request, picture, pushed_over_in)


def _followed(request: Request, picture: Path | None, follow: Follow) -> ExitCode:
    cases = request.variants()
    refuse_several(request.plot or picture, len(cases))
    questions = ((name, _motion(name, case, follow)) for name, case in cases.items())
    found, code = request.answer(questions, MOTIONS, INSTEAD)
    if request.plot is not None and found:
        draw(partial(drawn_motion, found[0]), request.plot)
    if picture is not None and found:
        draw(partial(drawn_positions, found[0], cases[found[0].case]), picture)
    return ExitCode.USAGE if code is ExitCode.OK and not found else code


def _motion(name: str, case: Case, follow: Follow) -> Iterator[FollowedMotion]:
    try:
        with counted(None, f"{name}: positions") as known:
            steps = 0

            def count(_amount: float) -> None:
                nonlocal steps
                steps += 1
                known(steps)

            found = follow(case, name, count)
    except (SearchError, ValueError) as error:
        tell(f"{name}: {error}")
    else:
        yield found
