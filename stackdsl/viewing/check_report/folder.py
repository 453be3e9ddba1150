"""Writes the report of a check into a folder: cases are played once more, recorded, in supervised processes."""

from collections.abc import Callable, Sequence
from pathlib import Path

from stackdsl.checking.check import Terms
from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import played_or_blocked
from stackdsl.checking.processes import run_supervised
from stackdsl.checking.worker import Task, TaskResult
from stackdsl.outcome import Report
from stackdsl.systems.known_systems import unplayable
from stackdsl.viewing.check_report.index_page import index_page
from stackdsl.viewing.check_report.shown_case import ShownCase, show_case


def write_folder(
    report: Report,
    cases: Sequence[Case],
    folder: Path,
    terms: Terms,
    on_done: Callable[[Case], None] = lambda case: None,
) -> Path:
    """Write a replay of each case and the index of them all; returns the index. Raises OSError."""
    replays = folder / "replays"
    replays.mkdir(parents=True, exist_ok=True)
    playable = [case for case in cases if not unplayable(case.system)]
    tasks = [Task(played_or_blocked, (show_case, case, replays), terms.time_limit) for case in playable]
    pool = run_supervised(tasks, terms.workers, lambda number, result: on_done(playable[number]), terms.on_wait)
    shown: dict[str, ShownCase] = {}
    unseen: dict[str, str] = {}
    for case, result in zip(playable, pool.results, strict=True):
        if isinstance(result.value, ShownCase):
            shown[case.name] = result.value
        else:
            unseen[case.name] = _why(result)
    index = folder / "index.html"
    index.write_text(index_page(report, shown, unseen), encoding="utf-8")
    return index


def _why(result: TaskResult) -> str:
    return result.message or result.status.value
