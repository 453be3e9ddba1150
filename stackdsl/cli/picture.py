"""`stackdsl picture`: draws a run without a display."""

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import or_
from pathlib import Path

import click

from stability.model import BodyId
from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.one_file import refusing, warn_of_missing_text
from stackdsl.cli.options import (
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    Number,
    code_without_runs,
    prepare_file,
    selected_of,
)
from stackdsl.cli.run import write_file
from stackdsl.cli.terminal import counted, tell
from stackdsl.exits import ExitCode
from stackdsl.judging.proofs import MOST_FOR_PROGRAMS
from stackdsl.shown_text import visible
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import unplayable
from stackdsl.simulation.recording import Recorder
from stackdsl.trace import Event, EventKind
from stackdsl.viewing.drawing import NOTHING, VIEWS, Overlay, View
from stackdsl.viewing.pictures import (
    HINT,
    FilmError,
    Panel,
    Sheet,
    film_maker,
    heading_at,
    heading_of,
    moving,
    moving_frames,
    mp4,
    panels_at,
    picture,
    strip,
)
from stackdsl.viewing.run_view import RunView, view_of
from stackdsl.viewing.svg import png

FILM = ".mp4"
STILL, MOVING = (".svg", ".png"), (".gif", ".webp", FILM)
RATE = 20.0  # frames a second of moving pictures
MOST_FRAMES = 400
HELD = 1.5  # [s] for which a moving picture shows its end


@click.command("picture", cls=ExplainedCommand)
@ONE_FILE
@click.option(
    "-o",
    "--output",
    type=FilePath,
    required=True,
    help="File to write: .svg or .png, or .gif, .webp or .mp4 for a film.",
)
@click.option(
    "--view", "views", multiple=True, type=click.Choice(list(VIEWS)), help="Direction of view. Default: three views."
)
@click.option("--at", "time", type=Number(min=0.0), help="Time of the picture [s]. Default: the end.")
@click.option("--strip", "count", type=click.IntRange(2, 40), help="Number of moments to draw, at one scale.")
@click.option("--names", is_flag=True, help="Also write names on bricks, where they fit.")
@click.option("--forces", is_flag=True, help="Also draw the contact forces of the proof, if one holds at that time.")
@click.option("--thrust", is_flag=True, help="Also draw the line of thrust of these forces, its hinges, and loads.")
@click.option("--joints", is_flag=True, help="Colour bricks by the share of strength that their joints use.")
@click.option("--slower", type=Number(0.01, 1000.0), default=1.0, help="Factor by which a film is slowed down.")
@ON_SYSTEMS
@ON_KEYWORD
@click.pass_context
def picture_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    output: Path,
    views: tuple[str, ...],
    time: float | None,
    count: int | None,
    names: bool,
    forces: bool,
    thrust: bool,
    joints: bool,
    slower: float,
    systems: tuple[str, ...],
    keyword: str,
) -> None:
    """Play one case of FILE and draw its end, a given time, a strip of pictures, or a film."""
    if output.suffix.lower() not in (*STILL, *MOVING):
        raise click.UsageError(f"{output}: the file name must end in {', '.join((*STILL, *MOVING))}")
    moves = output.suffix.lower() in MOVING
    _refuse_at_odds(moves, views, time, count)
    if output.suffix.lower() == FILM:
        _refuse_without_film_maker()
    prepare_file(output)
    gathered, selected = selected_of(file, Selection(systems, keyword))
    if not selected:
        context.exit(code_without_runs(gathered, selected))
    if len(selected) > 1:
        first, other = selected[0].name, selected[1].name
        tell(f"drawing {first}, the first of {len(selected)}; choose another with --system or -k, such as -k '{other}'")
    run = _played(selected[0])
    if not moves and not count:
        _warn_of_nothing_there(run, time, forces or thrust)
    marks = {Overlay.FORCES: forces, Overlay.THRUST: thrust, Overlay.NAMES: names, Overlay.JOINTS: joints}
    overlays = _overlays(run, marks)
    seen = [VIEWS[name] for name in views or ("three-quarter", "front", "plan")]
    try:
        with refusing(f"{run.name}: the picture", "choose one --view from a side, or a smaller variant") as refused:
            if moves:
                frames = moving_frames(run, seen[0], RATE / slower, MOST_FRAMES, overlays)
                write_file(output, _moving(run, seen[0], frames, output.suffix[1:]))
                warn_of_missing_text(output)
                return
            if count:
                svg = picture(run, heading_of(run, seen[0]), strip(run, seen[0], count, overlays))
            else:
                at = run.trace.cost.simulated_time if time is None else time
                svg = picture(run, heading_at(run, at), panels_at(seen, at, overlays))
            write_file(output, svg.encode() if output.suffix.lower() == ".svg" else png(svg))
            warn_of_missing_text(output)
        if refused:
            context.exit(ExitCode.INVALID)
    except ModuleNotFoundError as error:
        raise click.ClickException(
            f"{output.suffix} needs {error.name}, which is not installed; try: {HINT}"
        ) from error


def _refuse_at_odds(moves: bool, views: Sequence[str], time: float | None, count: int | None) -> None:
    """Refuse options of which one would be ignored."""
    if time is not None and count is not None:
        raise click.UsageError("--at draws one time and --strip several; remove one of the two")
    if moves and (time is not None or count is not None):
        raise click.UsageError("a film shows the whole run; remove --at and --strip, or write a .svg or .png")
    if (moves or count is not None) and len(views) > 1:
        raise click.UsageError("a strip or a film has one view; give only one --view")


def _overlays(run: RunView, options: Mapping[Overlay, bool]) -> Overlay:
    """Return the chosen marks; report colours of joints that no load factor gives."""
    if options[Overlay.JOINTS] and run.limit is None:
        tell(
            "the colours are those of states: no joint that keeps its force limits the load factor, or there are more "
            f"than {MOST_FOR_PROGRAMS} bricks"
        )
    return reduce(or_, (overlay for overlay, chosen in options.items() if chosen), NOTHING)


def _warn_of_nothing_there(run: RunView, time: float | None, forces: bool) -> None:
    """Report options that have no visible effect."""
    end = run.trace.cost.simulated_time
    if time is not None and time > end:
        raise click.UsageError(f"--at {time:g} is too late: {run.name} ends at {end:.3f} s; write a time until then")
    at = end if time is None else time
    if forces and not any(proof.begin <= at < proof.end for proof in run.proofs.standing):
        spans = ", ".join(f"{p.begin:g} s to {min(p.end, end):g} s" for p in run.proofs.standing) or "never"
        tell(f"no forces are drawn at {at:g} s: they are known only while a proof holds ({spans})")


def _moving(run: RunView, view: View, panels: list[Panel], form: str) -> bytes:
    sheet = Sheet(run, heading_of(run, view), panels, 1)
    pictures = []
    with counted(len(panels), f"{run.name}: pictures") as known:
        for panel in panels:
            pictures.append(sheet.drawn([panel]))
            known(len(pictures))
    pictures += pictures[-1:] * round(RATE * HELD)
    if f".{form.lower()}" != FILM:
        return moving(pictures, RATE, form.lower())
    try:
        return mp4(pictures, RATE)
    except FilmError as error:
        raise click.ClickException(visible(str(error))) from error


def _refuse_without_film_maker() -> None:
    """Refuse a film without a film maker, before anything is played."""
    try:
        film_maker()
    except FilmError as error:
        raise click.ClickException(str(error)) from error


def _played(case: Case) -> RunView:
    """Play a case."""
    if why := unplayable(case.system):
        raise click.ClickException(f"{case.name} cannot be played: {why}")
    recorder, placed = Recorder(), list[BodyId]()
    try:
        with counted(len(case.timeline.placements), f"{case.name}: bricks") as known:

            def told(event: Event) -> None:
                if event.kind is EventKind.PLACED:
                    placed.extend(event.bricks)
                    known(len(placed))

            trace = play_case(case.timeline, case.system, on_event=told, recorder=recorder)
    except BlockedPlacementError as error:
        raise click.ClickException(f"{case.name} was blocked: {error}") from error
    return view_of(case, trace, recorder.recording(), judged(case, trace))
