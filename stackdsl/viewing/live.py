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
from typing import Final, TypeAlias, TypeVar

from stability.model import BodyId, BodyState
from stability.process_settings import exclude_from_collection, uncollected
from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.exits import INTERRUPTS
from stackdsl.judging.judge import known_of
from stackdsl.judging.numbers import ScenarioNumbers
from stackdsl.judging.proofs import margins_of_assembly, proofs_of
from stackdsl.report.statics import TOLD, Extent, proven_lines
from stackdsl.report.text import run_text
from stackdsl.results import RunStatus, VariantResult
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recorder
from stackdsl.simulation.systems import as_played
from stackdsl.timeline import Placement, Removal, Timeline, leaves_to_engine
from stackdsl.trace import BrickState, BrickTrack, Cost, Event, EventKind, Trace, VerdictMargins
from stackdsl.viewing.replay.page import told
from stackdsl.viewing.run_view import RunView, ShownProofs, shown_proofs, view_of
from stackdsl.viewing.server import HOST, Board, PageServer, WebSite, listening

# What a case comes to before it is played: what is built, and what statics says of it. No engine is asked.
#
# Each structure is judged once, as it is set down, up to the first that is not proven to stand. What is dropped,
# thrown, pushed or shaken, and all that comes after it, has to be played.


def preview_of(case: Case) -> RunView:
    """A run in which everything stays where it is set down, up to what is not proven to stand."""
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
    """When that which is not proven to stand is set down, or the last thing [s]."""
    end = proofs.standing[-1].end if proofs.standing else 0.0
    return min(end, max((action.time for action in timeline.actions), default=0.0))


def _verdict(proofs: ShownProofs, timeline: Timeline) -> str:
    if proofs.fall is not None:
        return "proven to fall; how is being played"
    whole = bool(timeline.actions) and bool(proofs.standing) and proofs.standing[-1].end == inf
    return "proven to stand; what comes of it is being played" if whole else "being played"


def _trace(timeline: Timeline, proven: set[BodyId]) -> Trace:
    """Everything as it is set down."""
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
            yield Event(moment[0].time, EventKind.PLACED, names)
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


# What a live page is told of a case: at once what statics says of it, then how it was played, then its margins.


MANNERS = 10  # of a worker beside the browser, which is to draw first what is known already


@dataclass(frozen=True, slots=True)
class Played:
    """A case that was played."""

    told: str  # JSON for the page
    text: str  # for a terminal
    result: VariantResult


@dataclass(frozen=True, slots=True)
class Margined:
    """What the proofs of a case would survive."""

    lines: tuple[str, ...]
    weakest: BodyId | None  # the brick that the lines call so


@uncollected()  # what is made is small, and who looks waits
def preview(case: Case) -> str:
    """What a page is told at once."""
    return told(preview_of(case), hurried=True)


def played(case: Case) -> Played:
    """What a worker does: play, and tell a page and a terminal of it. Raises BlockedPlacementError."""
    os.nice(MANNERS)
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system), recorder=recorder)
    result = judged(case, trace)
    run = view_of(case, trace, recorder.recording(), result)
    return Played(told(run, hurried=True), run_text(trace, result), result)


def margined(case: Case) -> Margined:
    """What a worker does: tell what the proofs would survive, and what gives way first."""
    os.nice(MANNERS)
    timeline = as_played(case.timeline, system_named(case.system).modification)
    count = sum(not placement.hits for placement in timeline.placements)
    knobs, proofs = ScenarioNumbers(case.scenario, case.variant), proofs_of(timeline)
    is_whole = sum(len(judged.bricks) for judged in proofs.judged) == count
    margins = margins_of_assembly(proofs.assembly, TOLD) if is_whole else VerdictMargins()
    lines = proven_lines(proofs, timeline, count, Extent(margins=True), knobs, margins)
    weakest = margins.weakest.brick if margins.weakest is not None else None
    return Margined(tuple(line.strip() for line in lines), weakest)


# Whether files were saved: looked up a hundred times a second, which costs next to nothing for those of a scenario.
#
# Libraries that are told by the system bring threads, see no files on some network drives, and lose files that an
# editor replaces; and what a scenario takes from others can lie anywhere.


INTERVAL = 0.01  # [s] between looks
TICK = 0.01  # [s] of the clock of a file system: of two saves within one, stamps may know the first alone
SETTLED = 0.02  # [s] without a change, after which a file that makes no sense counts as written

Stamps: TypeAlias = Mapping[Path, tuple[int, int, int] | None]
Read = TypeVar("Read")


def stamps_of(files: Iterable[Path]) -> Stamps:
    """What tells of each file whether it is as it was; None of one that is not there."""
    return {file: _stamp(file) for file in files}


def read_whole(
    files: Iterable[Path], read: Callable[[], Read], makes_sense: Callable[[Read], bool]
) -> tuple[Stamps, Read]:
    """What `read` makes of files that nobody changed meanwhile, and the stamps that they had.

    Many editors empty a file before they write it: what makes no sense is believed only after a while without a change.
    """
    files = list(files)
    while True:
        sleep(TICK)
        stamps = stamps_of(files)
        found = read()
        if not makes_sense(found):
            sleep(SETTLED)
        if not is_saved_since(stamps):
            return stamps, found


def is_saved_since(stamps: Stamps) -> bool:
    """Whether a file is not as it was."""
    return any(_stamp(file) != stamp for file, stamp in stamps.items())


def _stamp(file: Path) -> tuple[int, int, int] | None:
    try:
        found = os.stat(file)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


# The server as whoever plays runs sees it: a process of its own, so that a run that takes long keeps no page waiting.
#
# And so that who plays has no threads: only of such a process are copies safe, which start in a hundredth of a second.


TOKEN_BYTES = 24  # 192 bits


@dataclass(frozen=True)
class Showing:
    """A site that is served."""

    url: str
    _connection: Connection

    def put(self, name: str, value: object) -> None:
        """Show a value, as JSON, under a name. Raises OSError if the server is gone."""
        self.put_text(name, json.dumps(value, allow_nan=False))

    def put_text(self, name: str, text: str) -> None:
        """Show JSON in one line under a name. Raises OSError if the server is gone."""
        self._connection.send((name, text))

    def drop(self, name: str) -> None:
        """Show nothing under a name any more. Raises OSError if the server is gone."""
        self._connection.send((name, None))


@contextmanager
def showing(site: WebSite) -> Iterator[Showing]:
    """Serve a site until the end of the block. Raises OSError if no port of this machine can be had."""
    token = token_urlsafe(TOKEN_BYTES)
    with listening() as listener:
        ours, theirs = multiprocessing.Pipe()
        url = f"http://{HOST}:{listener.getsockname()[1]}/{token}/"
        context = multiprocessing.get_context("fork")
        process = context.Process(target=_serve, args=(listener, token, site, theirs, ours), daemon=True)
        process.start()
        theirs.close()
    try:
        yield Showing(url, ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def _serve(listener: socket.socket, token: str, site: WebSite, told: Connection, others: Connection) -> None:
    """What the process does, until nobody tells it anything any more."""
    for number in INTERRUPTS:  # whoever started it decides what they mean
        signal.signal(number, signal.SIG_IGN)
    others.close()
    board = Board()
    server = PageServer(listener, token, site, board)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        while True:
            name, text = told.recv()
            if text is None:
                board.drop(name)
            else:
                board.put(name, text)
    except (EOFError, OSError):
        os._exit(0)  # threads that wait for browsers would keep it


# A live page of runs: what it is told, by whoever plays them. `live.ts` hears it.


@dataclass
class RunPage:
    """What a page shows of some runs, which are known by their numbers."""

    showing: Showing
    runs: int = 0
    mistakes: tuple[str, ...] = ()  # in the file
    doing: str = ""  # while something is still to come

    def expect(self, runs: int) -> None:
        """There are so many runs from now on; those beyond are forgotten."""
        for number in range(runs, self.runs):
            self.showing.drop(f"run {number}")
            self.showing.drop(f"lines {number}")
        self.runs = runs

    def tell_mistakes(self, mistakes: Iterable[str]) -> None:
        """What is wrong with the file; what is seen of runs stays."""
        self.mistakes = tuple(mistakes)
        self._say()

    def tell_doing(self, doing: str) -> None:
        """What is being done; nothing any more, if this is empty."""
        self.doing = doing
        self._say()

    def _say(self) -> None:
        self.showing.put("status", {"runs": self.runs, "mistakes": self.mistakes, "doing": self.doing})

    def show(self, number: int, told: str) -> None:
        """A run as JSON, instead of what was shown of it."""
        self.showing.put_text(f"run {number}", f'{{"run":{number},"told":{told}}}')

    def note(self, number: int, lines: Sequence[str], weakest: BodyId | None = None) -> None:
        """What else there is to say of a run, and which of its bricks that calls the weakest."""
        self.showing.put(f"lines {number}", {"run": number, "lines": list(lines), "weakest": weakest})


# Imports what statics may need before anything is saved: libraries that solve take longer to import than to ask.


# Imported elsewhere where a verdict first needs them, which most runs never do.
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
    """Import it, and let the collector of garbage pass over all that there is by now, here and in copies of this."""
    for name in SELDOM:
        import_module(name)
    exclude_from_collection()
