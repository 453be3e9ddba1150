"""`stackdsl run`: plays one file and tells what happens as it happens."""

import os
from pathlib import Path

import click

from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.checking.results import held_up, judged, set_aside, skipped
from stackdsl.checking.selection import Selection
from stackdsl.commands.keeping import ON_GLB, ON_HTML, ON_RECORD, Keeping
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE
from stackdsl.commands.selecting import complain, selected_of
from stackdsl.commands.terminal import counted, write
from stackdsl.judging.known import known_of
from stackdsl.outcome import Report, VariantResult, exit_code
from stackdsl.playing.clearance import BlockedPlacementError
from stackdsl.report.ensemble_text import ensemble_lines
from stackdsl.report.event_text import event_text
from stackdsl.report.run_text import claim_lines, run_text
from stackdsl.systems.known_systems import unplayable
from stackdsl.trace import Event


@click.command("run")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@ON_RECORD
@ON_HTML
@ON_GLB
@click.option("--watch", is_flag=True, help="Show it in a page of this machine, anew whenever FILE is saved.")
@click.option("--all-names", is_flag=True, help="Name every brick of an event, and all that fell.")
@click.pass_context
def run_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    record: Path | None,
    html: Path | None,
    glb: Path | None,
    watch: bool,
    all_names: bool,
) -> None:
    """Play FILE, print what happens as it happens, and judge it; golden files are not looked at."""
    if watch:
        if any(path is not None for path in (record, html, glb)):
            raise click.UsageError("--watch writes no files; leave it out, or --record, --html and --glb")
        from stackdsl.commands.live_run import watch_run  # noqa: PLC0415 -- few calls do

        context.exit(watch_run(file, Selection(systems, keyword)))
    gathered, selected = selected_of(file, Selection(systems, keyword))
    keeping = Keeping.of(record, html, glb, selected)
    results = tuple(_run(case, keeping, all_names) for case in selected)
    keeping.write()
    context.exit(exit_code(Report(results, gathered.diagnostics)))


def _run(case: Case, keeping: Keeping, all_names: bool) -> VariantResult:
    """Play a case here, and print what happens and how it ended."""
    write(case.name)
    if case.skip is not None:
        write(f"  skipped: {case.skip}\n\n")
        return set_aside(case)
    if why := unplayable(case.system):
        write(f"  skipped: {why}\n\n")
        return skipped(case, why)
    if case.is_sampled and keeping.recorder() is None:
        return _sampled(case)
    try:
        is_known = known_of(case.scenario, case.system)
        recorder = keeping.recorder()

        def told(event: Event) -> None:
            write(event_text(event, all_names))

        trace = play_case(case.timeline, case.system, is_known, told, recorder)
    except BlockedPlacementError as error:
        result = held_up(case, error.blocked)
        complain(filter(None, [result.mistake]))
    else:
        result = judged(case, trace)
        write(run_text(trace, result, all_names))
        keeping.played(case, trace, recorder, result)
    write("\n")
    return result


def _sampled(case: Case) -> VariantResult:
    """Judge the samples of a case, and print what became of them. What is drawn of it is its design, played once."""
    from stackdsl.checking.sampled_results import drawn_result  # noqa: PLC0415 -- it brings scipy

    with counted(case.scenario.samples or 0, f"{case.name}: samples") as known:
        result = drawn_result(case, os.cpu_count() or 1, on_drawn=lambda _, drawn, __: known(drawn))
    complain(filter(None, [result.mistake]))
    lines = [*ensemble_lines(result.ensemble), *claim_lines(result)] if result.ensemble is not None else []
    write("".join(f"{line}\n" for line in lines or [f"{result.status}: {result.message}"]) + "\n")
    return result
