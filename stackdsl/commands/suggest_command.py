"""`stackdsl suggest`: what would let a scenario stand that falls, each answer tried by a verdict."""

from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import click

from stability.statics.facts import Stability
from stackdsl.checking.gathering import Case
from stackdsl.checking.selection import Selection
from stackdsl.commands.asking_statics import AS, Rows, told
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write
from stackdsl.judging.designs import piling_of
from stackdsl.judging.proofs import Proofs, proofs_of
from stackdsl.judging.suggesting import Asked, Suggestion, suggestions
from stackdsl.report.suggestion_text import suggestion_row


@click.command("suggest")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@AS
@click.pass_context
def suggest_command(context: click.Context, file: Path, systems: tuple[str, ...], keyword: str, form: str) -> None:
    """Find what would let FILE stand that falls: shifts, counterweights, friction, props; each is tried."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    try:
        for name, case in variants_of(selected).items():
            _case(name, case, form, rows)
    finally:  # an interruption keeps what is known
        told(rows, form)
    context.exit(code_without_runs(gathered, selected))


def _case(name: str, case: Case, form: str, rows: Rows) -> None:
    proofs = proofs_of(case.timeline)
    verdict = proofs.verdict
    if verdict.stability is not Stability.UNSTABLE:
        said = "is proven to stand" if verdict.stability is Stability.STABLE else f"is undecided: {verdict.reason}"
        tell(f"{name}: what statics can judge {said}, so there is nothing to mend")
        return
    if form == "text":
        write(f"{name}\n  {verdict.reason}\n")
    found = list(_found(name, case, proofs, form, rows))
    if not found:
        tell(f"{name}: nothing was found that lets it stand")


def _found(name: str, case: Case, proofs: Proofs, form: str, rows: Rows) -> Iterator[Suggestion]:
    """Each as it is found, when it is written down."""
    with counted(None, f"{name}: verdicts") as bar:
        for suggestion in suggestions(Asked(case.timeline, proofs), piling_of(case.timeline), _ticking(bar)):
            row = suggestion_row(suggestion)
            rows.append((name, row))
            if form == "text":
                write(f"    {row['text']}\n")
            yield suggestion


def _ticking(bar: Callable[[int], None]) -> Callable[[], None]:
    turns = count(1)
    return lambda: bar(next(turns))
