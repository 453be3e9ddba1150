"""`stackdsl check`: plays and judges scenarios, and holds them against their golden files."""

import os
import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Unpack

import click

from stackdsl.asked_files import read_asked
from stackdsl.checking.check import TIME_LIMIT, Terms, check, failed, is_whole_set, recalled
from stackdsl.checking.gathering import SUFFIXES
from stackdsl.checking.memory import Memory
from stackdsl.checking.selection import Selection
from stackdsl.checking.survey import ChangedMeanwhileError, Listed, Surveyed, survey
from stackdsl.commands.check_options import Asked, with_options
from stackdsl.commands.formats import Output, Style, outputs_of, write_report
from stackdsl.commands.selecting import code_without_runs, warn_of_nothing
from stackdsl.commands.terminal import progress, tell
from stackdsl.exits import ExitCode
from stackdsl.outcome import Report, exit_code
from stackdsl.project_file import Project, ProjectError, project_of
from stackdsl.reading.source import MAX_BYTES
from stackdsl.shown_text import visible
from stackdsl.snapshots.golden import GoldenWriteRefusedError, is_ci, refuse_in_ci
from stackdsl.snapshots.pending import Waiting

PLACE: Final = re.compile(r"(.+?):([0-9]{1,9})(?::[0-9]+)?")  # as reports tell it, with or without a column


@click.command("check")
@with_options
@click.pass_context
def check_command(context: click.Context, **asked: Unpack[Asked]) -> None:
    """Play and judge everything under PATHS (default: scenarios), and compare it with its golden files."""
    _refuse_what_does_not_go_together(asked)
    outputs = outputs_of(asked["outputs"])
    if asked["watch"]:
        from stackdsl.commands.watching import watch  # noqa: PLC0415 -- few calls do

        context.exit(
            watch([_split(path)[0] for path in asked["paths"]] or [project_around(()).scenarios], asked["html"])
        )
    paths, places = _places(asked["paths"])
    project = project_around(paths)
    paths = paths or (project.scenarios,)
    golden, state = goldens_and_state(project, asked["golden"])
    memory = Memory(state, asked["cache"])
    found = survey(paths, memory)
    scenarios = project.scenarios if project.root is not None else None
    terms = _terms(asked, golden, scenarios, memory, found)
    selection = _selection(asked, places, memory)
    selected = selection.of(found.cases)
    if asked["only_changed"]:
        selected = [case for case in selected if recalled(case, terms) is None]
    elif not asked["statics"] or not selected:
        warn_of_nothing(selection, found, selected, paths)
    if not selected and not found.diagnostics and _may_be_none(asked, found):
        memory.settle()
        context.exit(ExitCode.OK)
    if asked["list_only"] or asked["statics"]:
        memory.settle()
        _tell_only(asked, outputs, found, selected)
        context.exit(code_without_runs(found, selected))
    whole = is_whole_set(paths, golden, scenarios)
    report = _checked(found, selected, whole and not asked["no_golden"], terms)
    write_report(report, outputs, Style(asked["verbosity"], asked["durations"]))
    if asked["html"] is not None and not report.interrupted:
        from stackdsl.commands.html_report import write_html  # noqa: PLC0415 -- few calls want it

        write_html(report, selected, asked["html"], terms)
    context.exit(exit_code(report))


def _checked(found: Surveyed, selected: Sequence[Listed], whole: bool, terms: Terms) -> Report:
    left = sum(recalled(case, terms) is None for case in selected)
    try:
        with progress(left) as bar:
            report = check(found, selected, whole, replace(terms, on_wait=bar.wait, on_drawn=bar.drawn), bar.tell)
    except ChangedMeanwhileError as error:
        raise click.ClickException(str(error)) from error
    finished = [result for result in report.results if result.status != "not run"]
    terms.memory.keep_failed(
        [result.name for result in finished if failed(result)], [result.name for result in finished]
    )
    return report


def _terms(asked: Asked, golden: Path, scenarios: Path | None, memory: Memory, found: Surveyed) -> Terms:
    return Terms(
        golden=None if asked["no_golden"] else golden,
        update=asked["update"],
        though_it_fails=asked["though_it_fails"],
        scenarios=scenarios,
        workers=asked["jobs"],
        time_limit=asked["time_limit"],
        update_command=_update_command(asked),
        refine=asked["refine"],
        lock_new=not is_ci(os.environ) and not asked["refine"],
        first_failure=asked["first_failure"],
        must_claim=asked["strict"],
        memory=memory,
        waiting=Waiting(memory.folder, golden) if not is_ci(os.environ) and not asked["refine"] else None,
        digests=found.digests,
    )


def _selection(asked: Asked, places: Sequence[tuple[str, int]], memory: Memory) -> Selection:
    names = memory.failed() if asked["only_failed"] else None
    if asked["only_failed"] and not names:
        tell("nothing failed when it was last played, as far as is known: all are played")
    parts = asked["systems"], asked["keyword"], asked["tags"], tuple(places)
    return Selection(*parts, names=names or None, shard=asked["shard"])


def _may_be_none(asked: Asked, found: Surveyed) -> bool:
    """Whether it is in order that nothing is selected, which is told then."""
    if asked["only_changed"]:
        tell("nothing has changed since it passed")
    return asked["only_changed"] or (asked["shard"] is not None and bool(found.cases))


def _refuse_what_does_not_go_together(asked: Asked) -> None:
    """Raise a usage error if what was asked for cannot be had together, or golden files must not be written."""
    if asked["update"] and asked["no_golden"]:
        raise click.UsageError("--no-golden leaves golden files alone; leave one of --no-golden and --update out")
    if asked["though_it_fails"] and not asked["update"]:
        raise click.UsageError("--though-it-fails says what --update may accept; give both, or leave it out")
    if asked["only_changed"] and not asked["cache"]:
        raise click.UsageError("--changed asks what is remembered; leave one of --changed and --no-cache out")
    if asked["watch"] and asked["update"]:
        raise click.UsageError("--watch accepts nothing that nobody has seen; leave one of --watch and --update out")
    if asked["update"] and asked["refine"]:
        message = (
            "--refine writes no golden files: it asks what of a run would move; leave one of --refine and --update out"
        )
        raise click.UsageError(message)
    if asked["update"]:
        try:
            refuse_in_ci(os.environ)
        except GoldenWriteRefusedError as error:
            raise click.ClickException(str(error)) from error


def project_around(paths: Sequence[Path]) -> Project:
    """The project of some files and directories, or of the working directory. Raises click.UsageError."""
    try:
        return project_of(paths)
    except ProjectError as error:
        raise click.UsageError(str(error)) from error


def goldens_and_state(project: Project, golden: Path | None = None) -> tuple[Path, Path]:
    """The directory of golden files, by default the project's own, and that of what is remembered of them.

    Raises click.UsageError where a link leads one of them away.
    """
    try:
        folder = project.goldens(golden)
        return folder, project.state(folder)
    except ProjectError as error:
        raise click.UsageError(str(error)) from error


def _places(written: Sequence[Path]) -> tuple[tuple[Path, ...], list[tuple[str, int]]]:
    """The paths meant, and the lines of files among them: `tower.yaml:12`, or with a column, as reports tell it."""
    found = [_split(path) for path in written]
    for path, line in found:
        _refuse_beyond(path, line)
    places = [(visible(path.as_posix()), line) for path, line in found if line is not None]
    return tuple(path for path, _ in found), places


def _refuse_beyond(path: Path, line: int | None) -> None:
    """Raise a usage error for a line beyond the end of a file."""
    try:
        lines = read_asked(path, MAX_BYTES).splitlines() if line is not None and os.path.isfile(path) else []
    except OSError:
        return  # which is told when the file is read for its scenarios
    if lines and line is not None and line > len(lines):
        raise click.UsageError(f"{path} has {len(lines)} lines, so there is none numbered {line}")


def _split(path: Path) -> tuple[Path, int | None]:
    place = PLACE.fullmatch(str(path))
    if place is None or os.path.exists(path) or not place[1].lower().endswith(SUFFIXES):
        return path, None
    return Path(place[1]), int(place[2])


def _update_command(asked: Asked) -> str:
    """The same check with --update, for a shell; it accepts what the check shows, and nothing else."""
    return shlex.join(["stackdsl", "check", *_words(asked), "--update"])


def _words(asked: Asked) -> Iterator[str]:
    # A path that begins with a dash would be taken for an option.
    yield from (f"./{path}" if str(path).startswith("-") else str(path) for path in asked["paths"])
    for system in asked["systems"]:
        yield from ("--system", system)
    if asked["keyword"]:
        yield from ("-k", asked["keyword"])
    for tag in asked["tags"]:
        yield from ("--tag", tag)
    if asked["shard"] is not None:
        yield from ("--shard", str(asked["shard"]))
    yield from ["--failed"] * asked["only_failed"]
    yield from ["--changed"] * asked["only_changed"]
    yield from ["--strict"] * asked["strict"]
    if asked["golden"] is not None:
        yield from ("--golden", str(asked["golden"]))
    if asked["time_limit"] != TIME_LIMIT:
        yield from ("--time-limit", str(asked["time_limit"]))


def _tell_only(asked: Asked, outputs: Sequence[Output], found: Surveyed, selected: Sequence[Listed]) -> None:
    from stackdsl.commands.listing import tell_cases, tell_statics  # noqa: PLC0415 -- only where it is asked for

    telling = tell_statics if asked["statics"] else tell_cases
    telling(found, selected, outputs)
