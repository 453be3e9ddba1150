"""The pages of `stackdsl check --html`."""

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import click

from stackdsl.checking.cases import ChangedMeanwhileError, Listed
from stackdsl.checking.check import CheckConfig
from stackdsl.cli.terminal import progress, tell
from stackdsl.project_file import root_around
from stackdsl.results import Report
from stackdsl.viewing.check_report.commit import commit_of
from stackdsl.viewing.check_report.page import Origin, write_folder


@dataclass(frozen=True, slots=True)
class _Recorded:
    """A case that was played again for its page."""

    name: str
    conclusion: str = "recorded"


def _origin(shard: str) -> Origin:
    """Return project, commit, date and command of this call."""
    project = root_around(Path.cwd()) or Path.cwd()
    now = datetime.now().astimezone().strftime("%d %b %Y, %H:%M %Z")
    return Origin(project.name, commit_of(project), now, shlex.join(["stackdsl", *sys.argv[1:]]), shard)


def write_html(report: Report, selected: Sequence[Listed], folder: Path, terms: CheckConfig, shard: str = "") -> None:
    """Write the pages of a report and the replays of `selected`. Raises click.ClickException if it cannot write."""
    try:
        cases = [case.compiled() for case in selected]
        with progress(len(cases)) as bar:
            told = replace(terms, on_wait=bar.wait)
            index = write_folder(
                report, cases, folder, told, lambda case: bar.tell(_Recorded(case.name)), _origin(shard)
            )
    except ChangedMeanwhileError as error:
        raise click.ClickException(str(error)) from error
    except OSError as error:
        raise click.ClickException(f"{error.filename or folder} cannot be written: {error.strerror}") from error
    tell(f"wrote {index}")
