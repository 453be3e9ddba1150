"""`stackdsl golden`: lists pending changes of golden files, and accepts or rejects them."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click

from stability.name_order import names_text
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import STDIN, GatheredCases, gather, survey
from stackdsl.checking.check import unused_goldens
from stackdsl.checking.selection import KeywordError, expression_of
from stackdsl.cli.check import goldens_and_state, project_around
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import FilePath
from stackdsl.cli.terminal import paper, tell, write
from stackdsl.diagnostics import did_you_mean
from stackdsl.disk import is_stream, leads_outside
from stackdsl.exits import ExitCode
from stackdsl.goldens.golden import (
    GoldenWriteRefusedError,
    Pending,
    PendingStore,
    StaleError,
    is_lost,
    kept_by_python,
    obsolete,
    refuse_in_ci,
    remove_obsolete,
)
from stackdsl.report.blocks import blocks_text, line
from stackdsl.report.golden_differences import difference_lines
from stackdsl.shown_text import visible
from stackdsl.wording import how_many

# Pending changes whose case does not exist any more, since its scenario was renamed or removed after the check.


def no_longer_cases(pending: Sequence[Pending], waiting: PendingStore) -> frozenset[str]:
    """Return the golden files of pending snapshots whose YAML file no longer has such a case.

    Changed files are read again; a file with mistakes has no known cases. Pending files may come with a project, so no
    file outside the project is read.
    """
    named = {each.file for each in pending if each.file}
    files = sorted(file for file in named if _is_own(file, waiting.home))
    memory = ResultCache(waiting.state, used=True)
    found = {file: {case.name for case in survey([waiting.home / file], memory).cases} for file in files}
    return frozenset(each.golden for each in pending if each.file in found and each.case not in found[each.file])


def _is_own(file: str, home: Path) -> bool:
    """Return whether a name is that of a file below a folder: "-" is the input, and `..` or a link may lead outside."""
    path = home / file
    return path != STDIN and not is_stream(path) and not leads_outside(path, home)


def why_not(pending: Pending, waiting: PendingStore) -> str:
    """Return the message for a snapshot that cannot be accepted, since its case does not exist any more."""
    exists = os.path.isfile(waiting.home / Path(pending.file))
    lacks = (
        f"{pending.file} has no case {pending.case} any more" if exists else f"{pending.file} does not exist any more"
    )
    return f"{lacks}; check again, or discard the change with: stackdsl golden reject"


# `stackdsl golden`: lists pending changes, and accepts or rejects them.


RENAMED: Final = "if it was renamed, pytest --snapshot-update names the new file; otherwise delete the golden files"
KEYS: Final = "a: accept, r: reject, s: skip, q: quit"
KEYS_OF_FAILING: Final = "A: accept although it fails, r: reject, s: skip, q: quit"


@dataclass(frozen=True, slots=True)
class GoldenFiles:
    """The golden files of a project, and the pending changes of them."""

    golden: Path
    scenarios: Path
    waiting: PendingStore

    @property
    def none_pending(self) -> str:
        """The message that no change is pending, with the command that compares with the golden files."""
        only_python = not os.path.exists(self.scenarios) and bool(kept_by_python(self.golden))
        return f"0 pending; {'pytest' if only_python else 'stackdsl check'} compares with the golden files"

    def pending(self, keyword: str) -> list[Pending]:
        """Return the pending changes of the cases that a keyword selects."""
        try:
            is_meant = expression_of(keyword)
        except KeywordError as error:
            raise click.UsageError(str(error)) from error
        waiting = list(self.waiting.all())
        found = [each for each in waiting if is_meant(each.case.casefold())]
        if keyword and waiting and not found:
            names = ", ".join(visible(each.case) for each in waiting)
            raise click.UsageError(f"no pending change is of a case with '{keyword}' in its name; pending: {names}")
        return found


ON_CASES = click.option("-k", "keyword", default="", help="Select cases whose name contains this word, as for check.")


class GoldenGroup(click.Group):
    """The commands on golden files; an unknown one gets an error that names the one that is meant."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the called command. Raises click.UsageError with the name that may be meant."""
        if args[0] not in self.commands and not args[0].startswith("-") and not ctx.resilient_parsing:
            remedy = did_you_mean(args[0], list(self.commands), MEANT)
            raise click.UsageError(f"unknown command 'golden {args[0]}'; {remedy}", ctx)
        return super().resolve_command(ctx, args)


MEANT: Final = {"list": "status", "ls": "status", "diff": "review", "show": "review", "update": "accept"}


@click.group("golden", cls=GoldenGroup)
@click.option("--golden", type=FilePath, help="Directory of golden files. Default: that of the project.")
@click.pass_context
def golden_command(context: click.Context, golden: Path | None) -> None:
    """List differences from golden files, and accept or reject them."""
    if golden is not None and not os.path.isdir(golden):
        shown = visible(str(golden))
        raise click.UsageError(f"there is no directory '{shown}'; `stackdsl check --golden {shown}` creates it")
    project = project_around(())
    folder, state = goldens_and_state(project, golden)
    context.obj = GoldenFiles(folder, project.scenarios, PendingStore(state, folder))


@golden_command.command("status", cls=ExplainedCommand)
@ON_CASES
@click.pass_context
def status(context: click.Context, keyword: str) -> None:
    """List pending changes. The exit code is 3 if there are any."""
    place: GoldenFiles = context.obj
    pending = place.pending(keyword)
    gone = no_longer_cases(pending, place.waiting)
    for each in pending:
        told = visible(why_not(each, place.waiting)) if each.golden in gone else _summary(each, place)
        write(f"{visible(each.status)}: {_named(each)}: {told}")
    write(f"{len(pending)} pending; stackdsl golden review shows them" if pending else place.none_pending)
    context.exit(ExitCode.GOLDEN if pending else ExitCode.OK)


def _named(pending: Pending) -> str:
    return visible(f"{pending.case}: {pending.golden}")


def _summary(pending: Pending, place: GoldenFiles) -> str:
    count = len(pending.compared(place.waiting).differences)
    told = [f"{count} difference{'s' * (count != 1)}"] if count else []
    told += [f"was {visible(pending.renamed_from)}"] if pending.renamed_from else []
    told += [f"fails {how_many(len(pending.failed), 'expectation')}"] if pending.failed else []
    told += ["the golden file has changed since the check: check again"] if pending.is_stale(place.waiting) else []
    return ", ".join(told) or "no golden file yet"


@golden_command.command("review", cls=ExplainedCommand)
@ON_CASES
@click.option("-v", "--verbose", is_flag=True, help="Show the change of every brick.")
@click.pass_context
def review(context: click.Context, keyword: str, verbose: bool) -> None:
    """Show each pending change and read a key for it, from the terminal or a pipe."""
    _refuse_in_ci()
    place: GoldenFiles = context.obj
    left = place.pending(keyword)
    chosen = {each.golden for each in left}
    gone = no_longer_cases(left, place.waiting)
    while left:
        pending = left.pop(0)
        if pending.golden in gone:
            tell(f"{_named(pending)}: {visible(why_not(pending, place.waiting))}")
            continue
        write(_shown(pending, place, verbose))
        key = _decision(pending)
        if key == "q":
            break
        with _told():
            if key in "aA":
                place.waiting.accept(pending)
                write(f"accepted: {visible(pending.golden)}")
            elif key == "r":
                place.waiting.reject(pending)
                write(f"rejected: {visible(pending.golden)} is unchanged")
    waiting = sum(each.golden in chosen for each in place.waiting.all())
    write(f"{waiting} pending" if chosen else place.none_pending)
    context.exit(ExitCode.GOLDEN if waiting else ExitCode.OK)


def _shown(pending: Pending, place: GoldenFiles, every: bool) -> str:
    found = pending.compared(place.waiting)
    width, colour = paper()
    head = [line(f"{visible(pending.status)}: {_named(pending)}", "bold"), line(f"  {_summary(pending, place)}")]
    failed = [line(f"  fails: {visible(text)}") for text in pending.failed]
    changes = map(line, difference_lines(found, width, every, "-v lists all"))
    return blocks_text([[*head, *failed, *changes]], width, colour)


def _decision(pending: Pending) -> str:
    """Read the key of a decision; return `q` at the end of the input."""
    tell(f"  {KEYS_OF_FAILING if pending.failed else KEYS}")
    while True:
        key = click.getchar() if sys.stdin.isatty() else sys.stdin.read(1)
        if key in ("", "\x04"):
            return "q"
        if key == "a" and pending.failed:
            tell("the result fails expectations; press A to accept it anyway")
        elif key in "aArsq":
            return key


def _found(place: GoldenFiles, keyword: str) -> list[Pending]:
    """Return the selected pending changes; print that there are none."""
    if not (found := place.pending(keyword)):
        write(place.none_pending)
    return found


@golden_command.command("accept", cls=ExplainedCommand)
@ON_CASES
@click.option("--accept-failing", is_flag=True, help="Also accept results that fail expectations.")
@click.pass_context
def accept(context: click.Context, keyword: str, accept_failing: bool) -> None:
    """Write pending changes to the golden files. Results that fail expectations need --accept-failing."""
    _refuse_in_ci()
    place: GoldenFiles = context.obj
    refused = 0
    found = _found(place, keyword)
    gone = no_longer_cases(found, place.waiting)
    for pending in found:
        if pending.golden in gone:
            tell(f"not accepted: {_named(pending)}: {visible(why_not(pending, place.waiting))}")
            refused += 1
            continue
        if pending.failed and not accept_failing:
            why = f"it fails: {visible(pending.failed[0])}; accept it anyway with --accept-failing"
            tell(f"not accepted: {_named(pending)}: {why}")
            refused += 1
            continue
        with _told() as told:
            unclear = pending.unclear.text
            place.waiting.accept(pending)
            was = f", was {visible(pending.renamed_from)}" if pending.renamed_from else ""
            write(f"accepted: {visible(pending.golden)}{was}{'; ' * bool(unclear)}{unclear}")
        refused += len(told)
    context.exit(ExitCode.GOLDEN if refused else ExitCode.OK)


@golden_command.command("reject", cls=ExplainedCommand)
@ON_CASES
@click.pass_context
def reject(context: click.Context, keyword: str) -> None:
    """Discard pending changes. The golden files stay unchanged."""
    place: GoldenFiles = context.obj
    for pending in _found(place, keyword):
        with _told():
            place.waiting.reject(pending)
            write(f"rejected: {visible(pending.golden)} is unchanged")


@golden_command.command("prune", cls=ExplainedCommand)
@click.option("--dry-run", is_flag=True, help="List the files without removing them.")
@click.pass_context
def prune(context: click.Context, dry_run: bool) -> None:
    """Remove golden files without a variant in the scenarios of the project, unless a scenario is invalid."""
    place: GoldenFiles = context.obj
    unused = _unused(context, place)
    if not dry_run:
        _refuse_in_ci()
    for file in unused if dry_run else remove_obsolete(unused):
        write(f"{'obsolete' if dry_run else 'removed'}: {file}")
    if not unused:
        write("nothing to remove")
    for keeper, files in kept_by_python(place.golden).items():
        lost = is_lost(keeper, place.golden)
        remedy = f", which does not exist; {RENAMED}" if lost else "; pytest tells which of them no test uses"
        if lost or not unused:
            write(f"kept: {visible(names_text(files))}, by {visible(keeper)}{remedy}")
    if not dry_run:
        waiting = place.pending("")
        gone = no_longer_cases(waiting, place.waiting)
        for pending in waiting:
            if pending.golden in gone:
                place.waiting.reject(pending)


def _unused(context: click.Context, place: GoldenFiles) -> tuple[str, ...]:
    """Return the golden files that have no owner; exit if that is unknown."""
    gathered = gather([place.scenarios]) if os.path.exists(place.scenarios) else GatheredCases((), ())
    if gathered.diagnostics:
        tell(f"{place.scenarios} has invalid scenarios, so unused golden files are unknown; check it first")
        context.exit(ExitCode.INVALID)
    if not gathered.cases and (unknown := obsolete(place.golden, (), whole_set=True)):
        told = f"{place.scenarios} has no scenarios, so the owner of {visible(names_text(unknown))} is unknown"
        tell(f"{told}; set `scenarios` in stackdsl.toml, or delete the golden files without scenarios")
        context.exit(ExitCode.INVALID)
    return unused_goldens(gathered, place.golden)


def _refuse_in_ci() -> None:
    try:
        refuse_in_ci(os.environ)
    except GoldenWriteRefusedError as error:
        raise click.ClickException(str(error)) from error


@contextmanager
def _told() -> Iterator[list[str]]:
    """Report errors of a decision and continue with the next; the list holds the messages."""
    told: list[str] = []
    try:
        yield told
    except StaleError as error:
        told.append(str(error))
    except OSError as error:
        told.append(f"{error.filename} cannot be written: {error.strerror}")
    for text in told:
        tell(text)
