"""`stackdsl check`: plays and judges scenarios, and compares them with their golden files."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import Final, TypedDict, TypeVar, Unpack

import click

from stability.engines.rigid.preparation import is_compiled
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import SUFFIXES, CaseSurvey, ChangedMeanwhileError, Listed, survey
from stackdsl.checking.check import TIME_LIMIT, CheckConfig, check, failed, is_whole_set, recall
from stackdsl.checking.selection import Selection, Shard
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import (
    LONGEST_LIMIT,
    ON_JOBS,
    ON_KEYWORD,
    ON_SYSTEMS,
    ON_TAGS,
    FilePath,
    Number,
    Output,
    OutputChoice,
    code_without_runs,
    outputs_of,
    warn_of_nothing,
    write_report,
)
from stackdsl.cli.terminal import progress, tell
from stackdsl.disk import leads_outside, true_folder
from stackdsl.exits import ExitCode
from stackdsl.goldens.golden import GoldenWriteRefusedError, PendingStore, is_ci, kept_by_python, refuse_in_ci
from stackdsl.language.yaml.includes import root_of
from stackdsl.language.yaml.source import MAX_BYTES
from stackdsl.project_file import Project, ProjectError, confined, project_of
from stackdsl.report.blocks import TextStyle
from stackdsl.results import Report, exit_code
from stackdsl.shown_text import visible
from stackdsl.user_files import read_user_file

# The options of `stackdsl check`, and their allowed values.


Command = TypeVar("Command", bound=Callable[..., object])

LONGEST_NAME: Final = 255  # [bytes] of a file, on most systems
NAME_A_PATH: Final = (
    "name a file or a directory, such as `stackdsl check .`; `stackdsl new NAME` creates a first scenario there"
)
RUN_PYTEST: Final = "run pytest, whose tests in Python keep the golden files, or create a scenario with `stackdsl new`"
_SHARD: Final = re.compile(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})")


class CheckOptions(TypedDict):
    """The options of `check`."""

    paths: tuple[Path, ...]
    systems: tuple[str, ...]
    keyword: str
    tags: tuple[str, ...]
    shard: Shard | None
    only_failed: bool
    only_changed: bool
    list_only: bool
    statics: bool
    first_failure: bool
    strict: bool
    watch: bool
    outputs: tuple[Output, ...]
    verbosity: int
    table: bool
    every_case: bool
    durations: int
    update: bool
    accept_failing: bool
    refine: bool
    sensitivity: bool
    golden: Path | None
    no_golden: bool
    cache: bool
    html: Path | None
    jobs: int
    time_limit: float


def _number(value: float) -> float:
    """Refuse nan, which passes the range check of click."""
    if isnan(value):
        raise click.BadParameter("nan is not a number.")
    return value


def _pages_folder(path: Path | None) -> Path | None:
    """Refuse the name of a file, since the pages are several files."""
    if path is not None and (path.suffix.lower() in (".html", ".htm") or os.path.isfile(path)):
        folder = path.with_suffix("") if path.suffix else path.with_name(f"{path.name}-pages")
        raise click.BadParameter(
            f"'{path}' must be a folder, for an index and a page for each case; write --html {folder}"
        )
    return path


def _shard(text: str | None) -> Shard | None:
    if text is None:
        return None
    match = _SHARD.fullmatch(text)
    if match is None or int(match[1]) > int(match[2]):
        raise click.BadParameter(f"'{text}' is not a valid shard; write I/N with I from 1 to N, such as 1/4")
    return Shard(int(match[1]), int(match[2]))


OPTIONS: Final = (
    click.argument("paths", nargs=-1, type=FilePath),
    ON_SYSTEMS,
    ON_KEYWORD,
    ON_TAGS,
    click.option(
        "--shard", callback=lambda *given: _shard(given[-1]), help="Select part I of N of the cases, such as 1/4."
    ),
    click.option("--failed", "only_failed", is_flag=True, help="Select cases that failed in their last run."),
    click.option("--changed", "only_changed", is_flag=True, help="Select cases without a recorded pass."),
    click.option("--list", "list_only", is_flag=True, help="Print the names of the selected cases and stop."),
    click.option("--statics", is_flag=True, help="Print the verdicts of statics without simulation, and stop."),
    click.option("-x", "first_failure", is_flag=True, help="Stop at the first failure."),
    click.option("--strict", is_flag=True, help="Also fail unchecked cases, which have no expectations."),
    click.option("--watch", is_flag=True, help="Check again at each save of a scenario, until interrupted."),
    click.option(
        "--format",
        "outputs",
        multiple=True,
        type=OutputChoice(),
        help="Format of the report, and optionally its file: text, json, junit=report.xml. Can be repeated.",
    ),
    click.option(
        "--html",
        type=FilePath,
        callback=lambda *given: _pages_folder(given[-1]),
        help="Also write pages into this folder: an index and a replay of each case.",
    ),
    click.option("-q", "--quiet", "verbosity", flag_value=-1, type=int, help="Print only failures and totals."),
    click.option(
        "-v", "--verbose", "verbosity", flag_value=1, type=int, default=0, help="Also print every case and all notes."
    ),
    click.option("--table", is_flag=True, help="Also print a table with a row for each case."),
    click.option("--progress", "every_case", is_flag=True, help="Report each case as it finishes."),
    click.option("--durations", type=click.IntRange(0), default=0, metavar="N", help="Also list the N slowest cases."),
    click.option("--update", is_flag=True, help="Write the results as new golden files. Refused in CI."),
    click.option("--accept-failing", is_flag=True, help="With --update, also accept results that fail expectations."),
    click.option(
        "--refine", is_flag=True, help="Repeat with half the time step and twice the iterations; report changes."
    ),
    click.option(
        "--sensitivity", is_flag=True, help="Repeat with hits a micrometre to either side; report what it decides."
    ),
    click.option("--golden", type=FilePath, help="Directory of golden files. Default: that of the project."),
    click.option("--no-golden", is_flag=True, help="Neither compare nor write golden files."),
    click.option("--cache/--no-cache", default=True, help="Whether to skip cases with a recorded pass."),
    ON_JOBS,
    click.option(
        "--time-limit",
        type=Number(0.001, LONGEST_LIMIT),
        callback=lambda *given: _number(given[-1]),
        default=TIME_LIMIT,
        show_default=True,
        help="Time limit of a case [s].",
    ),
)


def with_options(command: Command) -> Command:
    """Return a command with all these options, in this order."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


# `stackdsl check --watch`: checks again whenever a scenario is saved.
#
# Each check is a new process, so that it runs the code on the disk. The cache spares it the cases that did not change.


WATCHED = (*SUFFIXES, ".obj")  # not CSV and JSON, since a check may write its reports in these formats


def watch(paths: Sequence[Path], html: Path | None) -> int:
    """Check now and after each change below these paths; return the exit code of the last check.

    With `html`, each check writes pages into that folder. They are served on this machine, and reload after each check.
    """
    if html is None:
        return _watch(paths)
    from stackdsl.viewing.live import showing  # noqa: PLC0415 -- few calls do
    from stackdsl.viewing.server import Folder  # noqa: PLC0415 -- likewise

    try:
        true_folder(html, confined(html))
        with showing(Folder(html)) as page:
            tell(f"open {page.url}")
            return _watch(paths, lambda: page.put("written", None))
    except OSError as error:
        raise click.ClickException(f"the pages cannot be served: {error.strerror or error}") from error


def _refuse_links_out(folder: Path) -> None:
    """Raise UsageError for a link to a folder outside, since watchfiles would watch its target too."""
    for parent, names, _ in os.walk(folder):
        for path in (Path(parent, name) for name in names):
            if path.is_symlink() and leads_outside(path, folder):
                raise click.UsageError(f"{os.path.relpath(path)} is a link out of the watched folder; remove it")


def _watch(paths: Sequence[Path], on_checked: Callable[[], None] = lambda: None) -> int:
    try:
        from watchfiles import watch as changes_of  # noqa: PLC0415 -- an optional package
    except ImportError as error:
        raise click.UsageError(
            "--watch needs watchfiles, which is not installed; try: pip install watchfiles"
        ) from error
    missing = [path for path in paths if not os.path.exists(path)]
    if missing:
        raise click.UsageError(f"--watch: {missing[0]} does not exist")
    # -P: otherwise Python would import modules from the watched folder in place of the installed ones.
    command = [sys.executable, "-P", "-m", "stackdsl", *(word for word in sys.argv[1:] if word != "--watch")]
    # A scenario can include any file of its project. A change of another file costs little, due to the cache.
    folders = {Path(root_of(str(path / "any" if os.path.isdir(path) else path))) for path in paths}
    for folder in folders:
        _refuse_links_out(folder)

    def is_meant(_: object, name: str) -> bool:
        path = Path(name)
        own = [path.relative_to(folder).parts for folder in folders if path.is_relative_to(folder)]
        hidden = all(any(part.startswith(".") for part in parts) for parts in own)
        return not hidden and path.suffix.lower() in WATCHED

    code = 0
    try:
        changes = changes_of(*folders, watch_filter=is_meant, yield_on_timeout=True, rust_timeout=500)
        for number, changed in enumerate(changes):
            if number and not changed:
                continue
            for name in sorted({Path(name).name for _, name in changed}):
                tell(f"changed: {name}")
            code = subprocess.run(command, check=False).returncode
            on_checked()
            tell("watching for changes; press Ctrl-C to stop")
    except KeyboardInterrupt:
        pass
    return code


# `stackdsl check`: plays and judges scenarios, and compares them with their golden files.


PLACE: Final = re.compile(r"(.+?):([0-9]{1,9})(?::[0-9]+)?")  # as in reports, with or without a column


@click.command("check", cls=ExplainedCommand)
@with_options
@click.pass_context
def check_command(context: click.Context, **asked: Unpack[CheckOptions]) -> None:
    """Play and judge the scenarios in PATHS (default: scenarios), and compare them with their golden files."""
    _refuse_what_does_not_go_together(asked)
    outputs = outputs_of(asked["outputs"])
    if asked["watch"]:
        context.exit(
            watch([_split(path)[0] for path in asked["paths"]] or [project_around(()).scenarios], asked["html"])
        )
    paths, places = _places(asked["paths"])
    project = project_around(paths)
    paths = paths or (project.scenarios,)
    golden, state = goldens_and_state(project, asked["golden"])
    memory = ResultCache(state, asked["cache"])
    found = survey(paths, memory)
    # A name that is too long for a file has a message of its own.
    is_name = len(os.fsencode(project.scenarios.name)) <= LONGEST_NAME
    if not asked["paths"] and is_name and not os.path.exists(project.scenarios):
        hint = RUN_PYTEST if kept_by_python(golden) else NAME_A_PATH
        message = f"there is no directory '{visible(str(paths[0]))}', which is checked by default"
        found = replace(
            found, diagnostics=tuple(replace(each, message=message, hint=hint) for each in found.diagnostics)
        )
    scenarios = project.scenarios if project.root is not None else None
    terms = _terms(asked, golden, scenarios, memory, found)
    selection = _selection(asked, places, memory)
    selected = selection.of(found.cases)
    if asked["only_changed"]:
        recalled = recall(selected, terms)
        selected = [case for index, case in enumerate(selected) if index not in recalled]
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
    report = _checked(found, selected, whole and not asked["no_golden"], terms, asked["every_case"])
    write_report(report, outputs, TextStyle(asked["verbosity"], asked["durations"], asked["table"]))
    if asked["html"] is not None:
        from stackdsl.cli.html_report import write_html  # noqa: PLC0415 -- few calls want it

        shard = str(asked["shard"] or "")
        write_html(report, () if report.interrupted else selected, asked["html"], terms, shard)
    context.exit(exit_code(report))


def _checked(
    found: CaseSurvey, selected: Sequence[Listed], whole: bool, terms: CheckConfig, every_case: bool
) -> Report:
    recalled = recall(selected, terms)
    if len(recalled) < len(selected) and any(case.system == "exact" for case in selected) and not is_compiled():
        from stability.engines.rigid.world import compile_engine  # noqa: PLC0415 -- the compiler takes a while to import

        compile_engine()  # else each worker would
    try:
        with progress(len(selected) - len(recalled), every_case) as bar:
            shown = replace(terms, on_wait=bar.wait, on_drawn=bar.drawn, on_result=bar.tell)
            report = check(found, selected, whole, shown, recalled)
    except ChangedMeanwhileError as error:
        raise click.ClickException(str(error)) from error
    finished = [result for result in report.results if result.status != "not run"]
    terms.memory.keep_failed(
        [result.name for result in finished if failed(result)], [result.name for result in finished]
    )
    return report


def _terms(
    asked: CheckOptions, golden: Path, scenarios: Path | None, memory: ResultCache, found: CaseSurvey
) -> CheckConfig:
    return CheckConfig(
        golden=None if asked["no_golden"] else golden,
        update=asked["update"],
        accept_failing=asked["accept_failing"],
        scenarios=scenarios,
        workers=asked["jobs"],
        time_limit=asked["time_limit"],
        update_command=_update_command(asked),
        refine=asked["refine"],
        sensitivity=asked["sensitivity"],
        write_new_goldens=not is_ci(os.environ) and not asked["refine"],
        first_failure=asked["first_failure"],
        must_claim=asked["strict"],
        memory=memory,
        waiting=PendingStore(memory.folder, golden) if not is_ci(os.environ) and not asked["refine"] else None,
        digests=found.digests,
    )


def _selection(asked: CheckOptions, places: Sequence[tuple[str, int]], memory: ResultCache) -> Selection:
    names = memory.failed() if asked["only_failed"] else None
    if asked["only_failed"] and not names:
        tell("no recorded failures: running all cases")
    parts = asked["systems"], asked["keyword"], asked["tags"], tuple(places)
    return Selection(*parts, names=names or None, shard=asked["shard"])


def _may_be_none(asked: CheckOptions, found: CaseSurvey) -> bool:
    """Return whether an empty selection is allowed, and report that nothing has changed."""
    if asked["only_changed"]:
        tell("no selected case has changed since it passed")
    return asked["only_changed"] or (asked["shard"] is not None and bool(found.cases))


def _refuse_what_does_not_go_together(asked: CheckOptions) -> None:
    """Raise a usage error for contradicting options, or if golden files must not be written."""
    if asked["update"] and asked["no_golden"]:
        raise click.UsageError("--update writes golden files and --no-golden ignores them; remove one of the two")
    if asked["accept_failing"] and not asked["update"]:
        raise click.UsageError("--accept-failing needs --update; add --update, or remove --accept-failing")
    if asked["only_changed"] and not asked["cache"]:
        raise click.UsageError("--changed needs the cache; remove --changed or --no-cache")
    if asked["watch"] and asked["update"]:
        raise click.UsageError("--watch cannot accept results without review; remove --watch or --update")
    if asked["sensitivity"] and asked["refine"]:
        raise click.UsageError("--refine and --sensitivity repeat runs in different ways; remove one of them")
    if asked["update"] and asked["refine"]:
        raise click.UsageError("--refine writes no golden files; remove --refine or --update")
    if asked["update"]:
        try:
            refuse_in_ci(os.environ)
        except GoldenWriteRefusedError as error:
            raise click.ClickException(str(error)) from error


def project_around(paths: Sequence[Path]) -> Project:
    """Return the project of some files and directories, or of the working directory. Raises click.UsageError."""
    try:
        return project_of(paths)
    except ProjectError as error:
        raise click.UsageError(str(error)) from error


def goldens_and_state(project: Project, golden: Path | None = None) -> tuple[Path, Path]:
    """Return the directory of golden files, by default that of the project, and the state directory.

    Raises click.UsageError if a link leads one of them outside.
    """
    try:
        folder = project.goldens(golden)
        return folder, project.state(folder)
    except ProjectError as error:
        raise click.UsageError(str(error)) from error


def _places(written: Sequence[Path]) -> tuple[tuple[Path, ...], list[tuple[str, int]]]:
    """Return the paths, and the lines among them, such as `tower.yaml:12`, or with a column as in reports."""
    split = [_split(path) for path in written]
    for path, line in split:
        _refuse_beyond(path, line)
    places = [(visible(path.as_posix()), line) for path, line in split if line is not None]
    return tuple(path for path, _ in split), places


def _refuse_beyond(path: Path, line: int | None) -> None:
    """Raise a usage error for a line beyond the end of a file."""
    try:
        lines = read_user_file(path, MAX_BYTES).splitlines() if line is not None and os.path.isfile(path) else []
    except OSError:
        return  # reported when the scenarios of the file are read
    if lines and line is not None and line > len(lines):
        raise click.UsageError(f"{path} has only {len(lines)} lines, so line {line} does not exist")


def _split(path: Path) -> tuple[Path, int | None]:
    place = PLACE.fullmatch(str(path))
    if place is None or os.path.exists(path) or not place[1].lower().endswith(SUFFIXES):
        return path, None
    return Path(place[1]), int(place[2])


def _update_command(asked: CheckOptions) -> str:
    """Return the same check with --update as a shell command, which accepts exactly the shown differences."""
    command = shlex.join(["stackdsl", "check", *_words(asked), "--update"])
    return f"{command} outside of CI, and commit the golden files" if is_ci(os.environ) else command


def _words(asked: CheckOptions) -> Iterator[str]:
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


def _tell_only(asked: CheckOptions, outputs: Sequence[Output], found: CaseSurvey, selected: Sequence[Listed]) -> None:
    from stackdsl.cli.listing import tell_cases, tell_statics  # noqa: PLC0415 -- only where it is asked for

    telling = tell_statics if asked["statics"] else tell_cases
    telling(found, selected, outputs)
