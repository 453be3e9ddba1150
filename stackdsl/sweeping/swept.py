"""A whole sweep: rows into a file, on whatever Executor there is; and what came of it."""

from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from stackdsl.judging.shares import Interval, interval
from stackdsl.sweeping.json_lines import JsonLines
from stackdsl.sweeping.parquet_folder import ParquetFolder
from stackdsl.sweeping.pieces import FAILED, Kind
from stackdsl.sweeping.row_text import Counts, RowsError
from stackdsl.sweeping.sweep_plan import Entry, Plan
from stackdsl.sweeping.sweep_run import Sweep
from stackdsl.sweeping.workers import Workers

FORMS: Final[dict[str, type[JsonLines | ParquetFolder]]] = {
    ".jsonl": JsonLines,
    ".parquet": ParquetFolder,
}
UNKNOWN: Final = ("undecided", "unfit", FAILED)  # verdicts of samples that may have stood


@dataclass(frozen=True, slots=True)
class SweptCase:
    """What became of the samples of one case so far, or of the case that has none."""

    entry: Entry
    kinds: Counter[Kind]

    @property
    def rows(self) -> int:
        """How many there are."""
        return self.kinds.total()

    @property
    def verdicts(self) -> dict[str, int]:
        """How many rows have each verdict."""
        return self._by(lambda kind: kind.verdict)

    @property
    def ways(self) -> dict[str, int]:
        """How many rows each way decided."""
        return self._by(lambda kind: kind.how if kind.verdict != FAILED else "")

    @property
    def fell(self) -> dict[int, int]:
        """How many fell, by the level under construction."""
        found = Counter[int]()
        for kind, count in self.kinds.items():
            if kind.level is not None:
                found[kind.level] += count
        return dict(sorted(found.items()))

    @property
    def failed(self) -> dict[str, int]:
        """How many brought down what judged them, and why."""
        return {kind.how: count for kind, count in self.kinds.items() if kind.verdict == FAILED}

    @property
    def stands(self) -> Interval | None:
        """Between which the share that stands lies, as sure as the scenario says; None of what has no samples."""
        if not self.entry.case.is_sampled or not self.rows:
            return None
        stood, unknown = self.verdicts.get("stands", 0), sum(self.verdicts.get(each, 0) for each in UNKNOWN)
        return interval(stood, stood + unknown, self.rows, 1.0 - self.entry.case.scenario.confidence)

    def _by(self, word: Callable[[Kind], str]) -> dict[str, int]:
        found = Counter[str]()
        for kind, count in self.kinds.items():
            if word(kind):
                found[word(kind)] += count
        return dict(sorted(found.items(), key=lambda each: (-each[1], each[0])))


def rows_file(path: Path, plan: Plan) -> JsonLines | ParquetFolder:
    """Where the rows go, by the ending of the path. Raises RowsError."""
    try:
        form = FORMS[path.suffix.lower()]
    except KeyError:
        raise RowsError(f"{path}: write to a file that ends in .jsonl, or to a folder that ends in .parquet") from None
    return form(path, plan)


def sweep(
    plan: Plan,
    out: Path,
    workers: Callable[[], AbstractContextManager[Workers]],
    on_rows: Callable[[int], None] = lambda rows: None,
    on_counts: Callable[[Counts], None] = lambda counts: None,
) -> tuple[SweptCase, ...]:
    """Bring all rows of a plan into a file, those that lack there; `on_counts` is told what is there before it begins.

    Raises RowsError and SweepError, and whatever `workers` raises. However it ends, rows that are there are kept.
    """
    with rows_file(out, plan) as file:
        on_counts(file.counts)
        if file.rows < plan.total:
            with workers() as those:
                Sweep(plan, file, those.executor, those.capacity, on_rows).run()
    return told(plan, file.counts)


def told(plan: Plan, counts: Counts) -> tuple[SweptCase, ...]:
    """What became of each case."""
    return tuple(SweptCase(entry, counts.of.get(index, Counter())) for index, entry in enumerate(plan.entries))
