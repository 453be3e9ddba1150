"""`stackdsl run --watch`: plays a file whenever it is saved, and shows it in a page that hears of it at once.

A save while something is still played ends that: what is shown is always of what is in the file, or, while there is a
mistake in it, of what was there before, with the mistake beside it.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import sleep
from typing import NoReturn

import click

from stackdsl.checking.gathering import STDIN, Case, Gathered, gather
from stackdsl.checking.one_case import played_or_blocked
from stackdsl.checking.results import held_up, set_aside, skipped
from stackdsl.checking.selection import Selection, why_nothing
from stackdsl.commands.options import LONGEST_LIMIT
from stackdsl.commands.selecting import complain
from stackdsl.commands.terminal import tell, write
from stackdsl.diagnostics import Diagnostic
from stackdsl.exits import ExitCode
from stackdsl.outcome import Report, VariantResult, exit_code
from stackdsl.playing.clearance import Blocked
from stackdsl.report.diagnostic_text import diagnostic_text
from stackdsl.supervising.processes import EnoughSeenError, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from stackdsl.systems.known_systems import unplayable
from stackdsl.viewing.live.live_runs import Margined, Played, margined, played, preview
from stackdsl.viewing.live.run_page import RunPage
from stackdsl.viewing.live.saved import INTERVAL, Stamps, is_saved_since, read_whole, stamps_of
from stackdsl.viewing.live.showing import showing
from stackdsl.viewing.live.sites import OnePage
from stackdsl.viewing.live.warming import warm_up
from stackdsl.viewing.replay.replay_page import live_page

LONGEST_MARGINS = 60.0  # [s] that margins may take: of hundreds of bricks they take minutes


def watch_run(file: Path, selection: Selection) -> int:
    """Play now and at every save, until interrupted; the exit code of what was played last."""
    if file == STDIN:
        raise click.UsageError("--watch needs a file that can be saved; leave one of --watch and - out")
    if not os.path.exists(file):
        raise click.UsageError(f"{file} is not there to be watched")
    try:
        with showing(OnePage(live_page(file.name))) as page:
            tell(f"open {page.url}")
            warm_up()
            live = _Live(file, selection, RunPage(page))
            try:
                live.go_on()
            except KeyboardInterrupt:
                return live.code
    except OSError as error:
        raise click.ClickException(f"no page can be shown: {error.strerror or error}") from error


@dataclass
class _Live:
    """One file under watch."""

    file: Path
    selection: Selection
    page: RunPage
    code: int = 0  # how the last play ended
    cases: Sequence[Case] = ()  # that the file holds now; none while there are only mistakes
    files: set[Path] = field(default_factory=set)  # what the scenarios were made of
    stamps: Stamps = field(default_factory=dict)

    def go_on(self) -> NoReturn:
        """Until interrupted."""
        self.files.add(self.file)
        self._read()
        while True:
            while not self._play():
                pass
            tell("watching; Ctrl-C ends it")
            while not self._is_overtaken():
                sleep(INTERVAL)

    def _is_overtaken(self) -> bool:
        """Whether something else is there to be played; mistakes in it are told, and end nothing that is played."""
        if not is_saved_since(self.stamps):
            return False
        tell("saved")
        self._read()
        return bool(self.cases)

    def _read(self) -> None:
        self.stamps, gathered = read_whole(self.files, lambda: gather([self.file]), _makes_sense)
        self.cases = self.selection.of(gathered.cases)
        self._watch_also(gathered.diagnostics)
        complain(gathered.diagnostics)
        mistakes = [diagnostic_text(diagnostic) for diagnostic in gathered.diagnostics]
        if not self.cases and not mistakes:
            mistakes = [why_nothing(self.selection, gathered.cases, [self.file])]
            tell(mistakes[0])
        self.code = exit_code(Report((), gathered.diagnostics)) if gathered.diagnostics else ExitCode.OK
        self.page.tell_mistakes(mistakes)

    def _play(self) -> bool:
        """Play what there is; whether it came to its end, and nothing else is there to be played."""
        if not self.cases:
            return True
        self.page.expect(len(self.cases))
        playing = _Playing(self.cases, self.page, self._is_overtaken)
        try:
            return playing.play()
        finally:
            results = tuple(playing.found[number] for number in sorted(playing.found))
            self.code = max(self.code, exit_code(Report(results, ()))) if results else self.code

    def _watch_also(self, mistakes: Iterable[Diagnostic]) -> None:
        """The files that scenarios take from, and those with mistakes, are saved as well."""
        others = {Path(part) for case in self.cases for part in case.source.parts}
        others |= {Path(mistake.span.file) for mistake in mistakes}
        self.stamps = {**stamps_of(others - self.files), **self.stamps}
        self.files |= others


def _makes_sense(gathered: Gathered) -> bool:
    return bool(gathered.cases) and not gathered.diagnostics


@dataclass
class _Playing:
    """What a file holds now, being played."""

    cases: Sequence[Case]
    page: RunPage
    is_overtaken: Callable[[], bool]  # so that nobody wants to know any more
    found: dict[int, VariantResult] = field(default_factory=dict)

    def play(self) -> bool:
        """Preview, play and judge all cases; False if something else was there to be played before that was done."""
        able = [number for number, case in enumerate(self.cases) if self._is_playable(number, case)]
        self.page.tell_doing("playing" if able else "")
        for number in able[:1]:  # who works on several looks at the first
            self.page.show(number, preview(self.cases[number]))
        for number in able:
            self.page.note(number, [])  # what was said was of another structure
        tasks = [Task(played_or_blocked, (played, self.cases[number]), LONGEST_LIMIT) for number in able]
        tasks += [Task(margined, (self.cases[number],), LONGEST_MARGINS) for number in able]
        pool = run_supervised(tasks, 2, lambda place, result: self._done(able, place, result), self._look)
        if pool.interrupted:
            raise KeyboardInterrupt
        if TaskStatus.NOT_RUN in {result.status for result in pool.results}:
            return False
        self.page.tell_doing("")
        return True

    def _is_playable(self, number: int, case: Case) -> bool:
        why = case.skip or unplayable(case.system)
        if why:
            self.found[number] = set_aside(case) if case.skip is not None else skipped(case, why)
            self.page.note(number, [f"{case.name} is skipped: {why}"])
        return not why

    def _look(self) -> None:
        if self.is_overtaken():
            raise EnoughSeenError

    def _done(self, able: Sequence[int], place: int, result: TaskResult) -> None:
        number = able[place % len(able)]
        case = self.cases[number]
        match result.value:
            case Played():
                self.found[number] = result.value.result
                self.page.show(number, result.value.told)
                if len(self.found) == len(self.cases):
                    self.page.tell_doing("working out margins")
                write(f"{case.name}\n{result.value.text}\n\n")
            case Blocked():
                self._held_up(number, held_up(case, result.value))
            case Margined():
                self.page.note(number, result.value.lines, result.value.weakest)
            case _:
                what = "margins" if place >= len(able) else "the run"
                self.page.note(number, [f"{what}: {result.message or result.status.value}"])

    def _held_up(self, number: int, result: VariantResult) -> None:
        self.found[number] = result
        if result.mistake is not None:
            complain([result.mistake])
            self.page.tell_mistakes((*self.page.mistakes, diagnostic_text(result.mistake)))
