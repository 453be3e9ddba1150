"""Writes the report of a check into a folder: cases are played once more, recorded, in supervised processes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from urllib.parse import quote

from stackdsl.asked_files import make_asked, write_asked
from stackdsl.checking.check import Terms
from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import played_or_blocked
from stackdsl.outcome import Report
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task, TaskResult
from stackdsl.systems.known_systems import unplayable
from stackdsl.viewing.check_report.index_page import index_page
from stackdsl.viewing.check_report.shown_case import PlayedCase, ShownCase, file_name, show_case
from stackdsl.viewing.replay.replay_page import page_of

REPLAYS: Final = "replays"


def write_folder(
    report: Report,
    cases: Sequence[Case],
    folder: Path,
    terms: Terms,
    on_done: Callable[[Case], None] = lambda case: None,
) -> Path:
    """Write the replays of all cases and the index of them; returns the index. Raises OSError.

    All systems that play the same share a page, where any two of them can be seen side by side.
    """
    make_asked(folder / REPLAYS)
    playable = [case for case in cases if case.skip is None and not unplayable(case.system)]
    golden = {result.name: result.golden for result in report.results}
    tasks = [Task(played_or_blocked, (show_case, case, golden.get(case.name)), terms.time_limit) for case in playable]
    pages = _Pages(folder, playable)

    def done(number: int, result: TaskResult) -> None:
        pages.take(number, result)
        on_done(playable[number])

    run_supervised(tasks, terms.workers, done, terms.on_wait)
    index = folder / "index.html"
    write_asked(index, index_page(report, pages.shown, pages.unseen).encode(), folder)
    return index


@dataclass
class _Pages:
    """The pages of replays, each written once all that belongs on it is there."""

    folder: Path
    cases: Sequence[Case]
    shown: dict[str, ShownCase] = field(default_factory=dict)  # by case
    unseen: dict[str, str] = field(default_factory=dict)  # why there is nothing to look at, by case
    _told: dict[int, tuple[str, ...]] = field(default_factory=dict)  # by number of a case, until its page is written
    _groups: dict[str, list[int]] = field(default_factory=dict)  # cases of a page, by what it is called

    def __post_init__(self) -> None:
        for number, case in enumerate(self.cases):
            self._groups.setdefault(_page_name(case), []).append(number)

    def take(self, number: int, result: TaskResult) -> None:
        """What became of a case that was to be played."""
        case = self.cases[number]
        page = _page_name(case)
        file = f"{REPLAYS}/{file_name(page)}"
        if isinstance(result.value, PlayedCase):
            self._told[number] = result.value.told
            self.shown[case.name] = ShownCase(f"{quote(file)}#{quote(case.name)}", result.value.picture)
        else:
            self._told[number] = ()
            self.unseen[case.name] = result.message or result.status.value
        group = self._groups[page]
        if self._told.keys() >= {*group}:
            told = [text for each in group for text in self._told.pop(each)]
            write_asked(self.folder / file, page_of(told, page).encode(), self.folder)


def _page_name(case: Case) -> str:
    """What the page of a case is called, which all systems that play the same share."""
    chosen = ",".join(f"{name}={text}" for name, text in case.parameters)
    return f"{case.scenario_name}[{chosen}]" if chosen else case.scenario_name
