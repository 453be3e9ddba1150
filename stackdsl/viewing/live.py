"""Live pages: preview, runs, and reloading when a file is saved."""

import json
import multiprocessing
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from itertools import takewhile
from math import inf
from multiprocessing.connection import Connection
from pathlib import Path
from secrets import token_urlsafe
from time import sleep
from typing import Any, Final, TypeAlias, TypeVar

from stability.model import BodyId, BodyState
from stability.problem import Stability
from stability.process_settings import exclude_from_collection, uncollected
from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.diagnostics import Diagnostic
from stackdsl.exits import INTERRUPTS
from stackdsl.judging.judge import stop_condition_of
from stackdsl.judging.numbers import ScenarioNumbers
from stackdsl.judging.proofs import MOST_FOR_PROGRAMS, margins_of_assembly, proofs_of
from stackdsl.judging.remedies import remedies_of
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.report.statics import TOLD, Extent, proven_lines
from stackdsl.report.text import run_text
from stackdsl.results import RunStatus, VariantResult
from stackdsl.shown_text import visible
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recorder
from stackdsl.simulation.systems import as_played
from stackdsl.timeline import Placement, Removal, Timeline, leaves_to_engine, time_of_arrival
from stackdsl.trace import BrickState, BrickTrack, Cost, Event, EventKind, Trace, VerdictMargins
from stackdsl.viewing.replay.page import run_json, weakest_told
from stackdsl.viewing.replay.verdict_band import remedies_json
from stackdsl.viewing.run_view import RunView, ShownProofs, shown_proofs, view_of
from stackdsl.viewing.server import HOST, PageServer, PublishedTexts, WebSite, listening

# Preview of a case before it is played: the build and its proofs, without an engine.
#
# Each structure is judged once, up to the first that is not proven to stand. The first drop, throw, push or shaking,
# and everything after it, has to be played.


def preview_of(case: Case) -> RunView:
    """Return a run in which every brick stays at its placement, up to the first that is not proven to stand."""
    timeline = as_played(case.timeline, system_named(case.system).modification)
    timeline = replace(timeline, actions=tuple(takewhile(lambda a: not leaves_to_engine(a), timeline.actions)))
    proofs = shown_proofs(timeline, _trace(timeline, set()), names_smallest=False)
    last = proofs.fall.time if proofs.fall is not None else _end(proofs, timeline)
    shown = replace(timeline, actions=tuple(action for action in timeline.actions if action.time <= last))
    proven = {name for proof in proofs.standing for name in proof.bricks}
    unplayed = VariantResult(case.identity.scenario, case.identity.variant, case.system, case.file, RunStatus.NOT_RUN)
    run = view_of(replace(case, timeline=shown), _trace(shown, proven), _recorded(shown).recording(), unplayed, proofs)
    return replace(run, timeline=shown, verdict=_verdict(proofs, timeline))


def _end(proofs: ShownProofs, timeline: Timeline) -> float:
    """Return the time of the first placement that is not proven to stand, or of the last action [s]."""
    end = proofs.standing[-1].end if proofs.standing else 0.0
    return min(end, max((action.time for action in timeline.actions), default=0.0))


def _verdict(proofs: ShownProofs, timeline: Timeline) -> str:
    if proofs.fall is not None:
        return "proven to fall; the simulation of the fall is running"
    whole = bool(timeline.actions) and bool(proofs.standing) and proofs.standing[-1].end == inf
    return "proven to stand; the simulation is running" if whole else "the simulation is running"


def _trace(timeline: Timeline, proven: set[BodyId]) -> Trace:
    """Return a trace with every brick at its placement."""
    tracks = {
        placement.brick.id: BrickTrack(
            placement.brick,
            placement.level,
            BrickState.UNWATCHED,
            placed=placement.pose,
            rest=placement.pose,
            final=placement.pose,
            shift=0.0,
            tilt=0.0,
            frozen=placement.brick.id in proven,
        )
        for placement in timeline.placements
    }
    end = max((action.time for action in timeline.actions), default=0.0)
    cost = Cost(wall_time=0.0, simulated_time=end, steps=0, judgements=0)
    return Trace(tuple(_events(timeline, proven)), tracks, (), None, cost, {}, timeline.world)


def _events(timeline: Timeline, proven: set[BodyId]) -> Iterator[Event]:
    for moment in timeline.moments():
        if isinstance(moment, Removal):
            yield Event(moment.time, EventKind.REMOVED, moment.bricks)
        elif isinstance(moment, tuple):
            names = tuple(placement.brick.id for placement in moment)
            flying = tuple(placement.brick.id for placement in moment if placement.hits)
            yield Event(moment[0].time, EventKind.PLACED, names, flying=flying)
            yield from (Event(time_of_arrival(each), EventKind.HIT, (each.brick.id,)) for each in moment if each.hits)
            if proven.issuperset(names):
                yield Event(moment[0].time, EventKind.FROZEN, names, "proven to stand")


def _recorded(timeline: Timeline) -> Recorder:
    recorder = Recorder()
    for action in timeline.actions:
        if isinstance(action, Placement):
            recorder.add(action.time, action.brick, BodyState(action.pose))
        elif isinstance(action, Removal):
            recorder.remove(action.time, action.bricks)
    return recorder


# Data of a live page for a case: first the preview by statics, then the played run, then its margins.


MANNERS = 10  # niceness of a worker, so that the browser draws the preview first


@dataclass(frozen=True, slots=True)
class Played:
    """A case that was played."""

    json: str  # for the page
    text: str  # for a terminal
    result: VariantResult


@dataclass(frozen=True, slots=True)
class Margined:
    """The margins of the proofs of a case."""

    lines: tuple[str, ...]
    weakest: Mapping[str, Any] | None  # the brick that gives way first, as `weakest_told` returns it
    helps: list[Mapping[str, Any]]  # remedies for a fall, as `remedies_json` returns them


@uncollected()  # the objects are few, and the user waits
def preview(case: Case) -> str:
    """Return the preview of a case as JSON."""
    return run_json(preview_of(case), hurried=True)


def played(case: Case) -> Played:
    """Play a case for a page and a terminal; runs in a worker. Raises BlockedPlacementError."""
    os.nice(MANNERS)
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), recorder=recorder)
    result = judged(case, trace)
    run = view_of(case, trace, recorder.recording(), result)
    return Played(run_json(run, hurried=True), run_text(trace, result), result)


def margined(case: Case) -> Margined:
    """Compute the margins of a case and the mechanism that gives way first; runs in a worker."""
    os.nice(MANNERS)
    timeline = as_played(case.timeline, system_named(case.system).modification)
    count = sum(not placement.hits for placement in timeline.placements)
    numbers, proofs = ScenarioNumbers(case.scenario, case.variant), proofs_of(timeline)
    is_whole = sum(len(judged.bricks) for judged in proofs.judged) == count
    margins = margins_of_assembly(proofs.assembly, TOLD) if is_whole else VerdictMargins()
    lines = proven_lines(proofs, timeline, count, Extent(margins=True, remedies=False), numbers, margins)
    falls = proofs.verdict.stability is Stability.UNSTABLE and count <= MOST_FOR_PROGRAMS
    helps = remedies_json(remedies_of(numbers, timeline, proofs)) if falls else []
    return Margined(tuple(line.strip() for line in lines), weakest_told(margins.weakest), helps)


# Detection of saved files by polling, a hundred times a second; the cost is small for the files of a scenario.
#
# Libraries that use notifications of the system need threads, miss files on some network drives, and lose files that an
# editor replaces. Included files can be in any folder.


INTERVAL = 0.01  # [s] between looks
TICK = 0.01  # [s] resolution of file times: of two saves within it, only the first may show
SETTLED = 0.02  # [s] without a change after which an invalid file counts as completely written

Stamps: TypeAlias = Mapping[Path, tuple[int, int, int] | None]
Read = TypeVar("Read")


def stamps_of(files: Iterable[Path]) -> Stamps:
    """Return the stamp of each file, which changes when it is saved; None for a missing file."""
    return {file: _stamp(file) for file in files}


def read_whole(
    files: Iterable[Path], read: Callable[[], Read], makes_sense: Callable[[Read], bool]
) -> tuple[Stamps, Read]:
    """Read files that do not change meanwhile; return their stamps and the result of `read`.

    Many editors empty a file before they write it, so a result that makes no sense is accepted only after a while
    without a change.
    """
    files = list(files)
    while True:
        sleep(TICK)
        stamps = stamps_of(files)
        result = read()
        if not makes_sense(result):
            sleep(SETTLED)
        if not is_saved_since(stamps):
            return stamps, result


def is_saved_since(stamps: Stamps) -> bool:
    """Return whether a file has changed since its stamp."""
    return any(_stamp(file) != stamp for file, stamp in stamps.items())


def _stamp(file: Path) -> tuple[int, int, int] | None:
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino


# The server in a separate process, so that a long run does not block a page.
#
# The main process then has no threads, so it can be forked safely; a fork starts in a hundredth of a second.


TOKEN_BYTES = 24  # 192 bits


@dataclass(frozen=True)
class ServedSite:
    """A served web site."""

    url: str
    _connection: Connection

    def put(self, name: str, value: object) -> None:
        """Publish a value as JSON under a name. Raises OSError if the server has ended."""
        self.put_text(name, json.dumps(value, allow_nan=False))

    def put_text(self, name: str, text: str) -> None:
        """Publish one line of JSON under a name. Raises OSError if the server has ended."""
        self._connection.send((name, text))

    def drop(self, name: str) -> None:
        """Remove the value of a name. Raises OSError if the server has ended."""
        self._connection.send((name, None))


@contextmanager
def showing(site: WebSite) -> Iterator[ServedSite]:
    """Serve a site until the end of the block. Raises OSError if no port is free."""
    token = token_urlsafe(TOKEN_BYTES)
    with listening() as listener:
        ours, theirs = multiprocessing.Pipe()
        url = f"http://{HOST}:{listener.getsockname()[1]}/{token}/"
        context = multiprocessing.get_context("fork")
        process = context.Process(target=_serve, args=(listener, token, site, theirs, ours), daemon=True)
        process.start()
        theirs.close()
    try:
        yield ServedSite(url, ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def _serve(listener: socket.socket, token: str, site: WebSite, inbox: Connection, others: Connection) -> None:
    """Run the server process until the connection to its parent is closed."""
    for number in INTERRUPTS:  # the parent process handles interrupts
        signal.signal(number, signal.SIG_IGN)
    others.close()
    board = PublishedTexts()
    server = PageServer(listener, token, site, board)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        while True:
            name, text = inbox.recv()
            if text is None:
                board.drop(name)
            else:
                board.put(name, text)
    except (EOFError, OSError):
        os._exit(0)  # at once, as threads that wait for browsers would keep the process alive


# A live page of runs; `live.ts` receives its events.


MOST_LINES = 400  # of a file that are shown beside its run; nobody reads more of them there


@dataclass
class RunPage:
    """The content of a page with several runs, by their numbers."""

    showing: ServedSite
    runs: int = 0
    mistakes: tuple[Mapping[str, Any], ...] = ()  # errors in the file, as `mistake_json` returns them
    text: str = ""  # of the file, as last read
    doing: str = ""  # current activity; empty if none

    def expect(self, runs: int) -> None:
        """Set the number of runs, and remove those beyond."""
        for number in range(runs, self.runs):
            self.showing.drop(f"run {number}")
            self.showing.drop(f"lines {number}")
        self.runs = runs

    def show_file(self, text: str, mistakes: Iterable[Mapping[str, Any]] = ()) -> None:
        """Show the text of the file, and errors in it."""
        self.text = text
        self.show_mistakes(mistakes)

    def show_mistakes(self, mistakes: Iterable[Mapping[str, Any]]) -> None:
        """Show errors in the file, beside the runs."""
        self.mistakes = tuple(mistakes)
        self._publish()

    def show_activity(self, doing: str) -> None:
        """Show the current activity; an empty text shows none."""
        self.doing = doing
        self._publish()

    def _publish(self) -> None:
        known = {"runs": self.runs, "mistakes": self.mistakes, "doing": self.doing}
        self.showing.put("status", {**known, "lines": self.text.split("\n", MOST_LINES)[:MOST_LINES]})

    def show(self, number: int, run: str) -> None:
        """Show a run, given as JSON, in place of its earlier state."""
        self.showing.put_text(f"run {number}", f'{{"run":{number},"told":{run}}}')

    def note(
        self,
        number: int,
        lines: Sequence[str],
        weakest: Mapping[str, Any] | None = None,
        helps: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        """Show further lines about a run, mark its weakest brick, and offer remedies."""
        told = {"run": number, "lines": list(lines), "weakest": weakest, "helps": list(helps)}
        self.showing.put(f"lines {number}", told)


def mistake_json(mistake: Diagnostic | str) -> Mapping[str, Any]:
    """Return a mistake for a page: its place, its message, its remedy, and the marked line."""
    if isinstance(mistake, str):
        return {"code": "", "message": mistake, "hint": "", "place": "", "line": 0, "text": mistake}
    span = mistake.span
    return {
        "code": mistake.code,
        "message": visible(mistake.message),
        "hint": visible(mistake.hint),
        "place": visible(str(span)),
        "line": span.line,
        "text": diagnostic_text(mistake),
    }


# Warm-up: imports the modules of statics before the first save, as solver libraries import longer than they solve.


# Modules that are otherwise imported by the first verdict that needs them, which most runs never have.
SELDOM: Final = (
    "clarabel",
    "scipy.sparse.linalg",
    "stability.geometry.polyhedra",
    "stability.dynamics.onset",
    "stability.contacts.hull_contacts",
    "stability.statics.proof",
    "stability.statics.equilibrium",
    "stability.statics.mechanism",
    "stability.statics.self_stress",
)


def warm_up() -> None:
    """Import these modules, and exclude all existing objects from garbage collection, also in forks."""
    for name in SELDOM:
        import_module(name)
    exclude_from_collection()
