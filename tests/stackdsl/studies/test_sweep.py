"""A sweep has one row per sample in order, independent of its workers, and resumes where it ended."""

import json
import platform
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from statistics import NormalDist
from typing import Any

import pytest

from stackdsl.judging.statistics import interval
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import judge_sample
from stackdsl.sampling.samples import Draws, build_plan_of
from stackdsl.studies import sweep as sweeping
from stackdsl.studies import sweep_plan
from stackdsl.studies.sweep import SweepError, sweep
from stackdsl.studies.sweep_plan import JudgedSamples, OtherProgram, judged_piece
from stackdsl.studies.sweep_workers import Workers
from stackdsl.supervising.executors import SupervisedExecutor
from tests.stackdsl.studies.sweeps import STEPS, Here, cases, deadly, plan, swept

pytestmark = pytest.mark.usefixtures("at_once")


@pytest.fixture(scope="module")
def processes() -> Iterator[SupervisedExecutor]:
    with SupervisedExecutor(2) as executor:
        yield executor


def rows_of(out: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in out.read_text().splitlines()]


def test_each_sample_has_the_row_that_statics_give_it_from_an_empty_site_on(tmp_path: Path) -> None:
    (counted,) = swept(plan(samples=60), tmp_path / "rows.jsonl")
    rows = rows_of(tmp_path / "rows.jsonl")
    assert [row["sample"] for row in rows] == [*range(60)]
    (case,) = cases(samples=60)
    design, levels = build_plan_of(case.timeline), []
    for sample in range(60):
        placed = PlacementSampler(design, Draws(1, "shaky", sample, 1)).build().placed(0)
        levels.append(judge_sample(design, placed) or None)
    assert [row["level"] for row in rows] == levels
    assert {row["verdict"] for row in rows if row["level"] is None} == {"stands"}
    assert counted.verdicts == {"stands": levels.count(None), "collapses": 60 - levels.count(None)}
    assert counted.fell == {level: levels.count(level) for level in sorted({level for level in levels if level})}


def test_rows_are_the_same_to_the_byte_for_all_executors_and_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, processes: SupervisedExecutor
) -> None:
    swept(plan(), tmp_path / "here.jsonl")
    sweep(plan(), tmp_path / "two.jsonl", lambda: nullcontext(Workers(processes, lambda: 2)))
    for first, most in ((1, 7), (64, 1000)):
        monkeypatch.setattr(sweeping, "FIRST", first)
        monkeypatch.setattr(sweeping, "MOST", most)
        monkeypatch.setattr(sweep_plan, "TOGETHER", 50)
        swept(plan(), tmp_path / f"{most}.jsonl")
    assert len({file.read_bytes() for file in tmp_path.glob("*.jsonl")}) == 1
    assert len([*tmp_path.glob("*.jsonl")]) == 4


def test_rows_of_variants_come_sample_by_sample_so_that_more_samples_are_more_rows_at_the_end(tmp_path: Path) -> None:
    swept(plan(STEPS, 30), tmp_path / "rows.jsonl")
    few = (tmp_path / "rows.jsonl").read_bytes()
    assert [(row["sample"], row["case"]) for row in rows_of(tmp_path / "rows.jsonl")][:3] == [
        (0, "shaky[step=2mm,exact]"),
        (0, "shaky[step=7mm,exact]"),
        (1, "shaky[step=2mm,exact]"),
    ]
    swept(plan(STEPS, 50), tmp_path / "rows.jsonl")
    swept(plan(STEPS, 50), tmp_path / "at once.jsonl")
    more = (tmp_path / "rows.jsonl").read_bytes()
    assert more.startswith(few)
    assert more == (tmp_path / "at once.jsonl").read_bytes()


def test_cases_with_fewer_samples_drop_out_of_the_rows_and_a_kill_at_any_row_makes_no_difference(
    tmp_path: Path,
) -> None:
    """A case that is played once has one row, and another 9: the order is that of samples, then of cases."""
    text = STEPS.replace("5 mm", "9 mm") + "---\nscenario: once\nbuild: [column: {{levels: 2}}]\n"
    asked = plan(text, 9)
    assert [entry.count for entry in asked.entries] == [9, 9, 1]
    swept(asked, tmp_path / "whole.jsonl")
    whole = (tmp_path / "whole.jsonl").read_bytes()
    rows = rows_of(tmp_path / "whole.jsonl")
    assert [row["case"] for row in rows[:4]] == [*(entry.name for entry in asked.entries), asked.entries[0].name]
    assert rows[2] == {
        "case": "once[exact]", "system": "exact", "variable_step": None, "seed": None, "sample": None,
        "verdict": "stands", "level": None, "how": "proven"
    }  # fmt: skip
    lines = whole.splitlines(keepends=True)
    (tmp_path / "torn.jsonl.sweep").write_bytes((tmp_path / "whole.jsonl.sweep").read_bytes())
    for kept in range(len(lines)):
        torn = b"".join(lines[:kept]) + lines[kept][: len(lines[kept]) // 2]
        (tmp_path / "torn.jsonl").write_bytes(torn)
        counted = swept(asked, tmp_path / "torn.jsonl")
        assert (tmp_path / "torn.jsonl").read_bytes() == whole
        assert sum(each.rows for each in counted) == 19


ASKED: list[int] = []


def noted(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    ASKED.append(count)
    return judged_piece(case, first, count, program)


class Ends(Here):
    """Interrupts, as Ctrl-C does, after some calls."""

    def __init__(self, after: int) -> None:
        self.left = after

    def submit(self, fn: Callable[..., Any], /, *args: object, **kwargs: object) -> Future[Any]:
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt
        return super().submit(fn, *args, **kwargs)


def test_an_interrupt_keeps_the_rows_that_are_there_and_the_next_call_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweeping, "MOST", 20)
    monkeypatch.setattr(sweeping, "FIRST", 20)
    swept(plan(), tmp_path / "whole.jsonl")
    with pytest.raises(KeyboardInterrupt):
        sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(Ends(9), lambda: 2)))
    there = len(rows_of(tmp_path / "rows.jsonl"))
    assert 0 < there < 300
    ASKED.clear()
    monkeypatch.setattr(sweeping, "judged_piece", noted)
    swept(plan(), tmp_path / "rows.jsonl")
    assert (tmp_path / "rows.jsonl").read_bytes() == (tmp_path / "whole.jsonl").read_bytes()
    assert sum(ASKED) == 300 - there


class Waits(Here):
    """Does the first call last of all that it is asked for before it is waited for, and counts how many that are."""

    def __init__(self) -> None:
        self.first: tuple[Future[Any], Callable[[], Any]] | None = None
        self.asked = 0
        self.most = 0

    def submit(self, fn: Callable[..., Any], /, *args: object, **kwargs: object) -> Future[Any]:
        self.asked += 1
        self.most = max(self.most, self.asked)
        if self.first is None and self.asked == 1:
            self.first = (Future(), lambda: fn(*args, **kwargs))
            return self.first[0]
        return super().submit(fn, *args, **kwargs)

    def capacity(self) -> int:
        return 2

    def waited(self, rows: int) -> None:
        """Nothing more is asked for as long as the first row lacks: now it comes."""
        if self.first is not None and self.asked == self.most:
            self.most += 1
        elif self.first is not None:
            future, call = self.first
            self.first = None
            future.set_result(call())


def test_rows_are_written_in_order_and_few_pieces_wait(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweeping, "FIRST", 5)
    monkeypatch.setattr(sweeping, "MOST", 5)
    executor = Waits()
    before: list[int] = []

    def waited(rows: int) -> None:
        if executor.first is not None:
            before.append(executor.asked)
        executor.waited(rows)

    sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(executor, executor.capacity)), waited)
    assert before[-1] == sweeping.AHEAD * 2 * 2  # of 60 pieces
    assert [row["sample"] for row in rows_of(tmp_path / "rows.jsonl")] == [*range(300)]


def test_a_sample_that_crashes_its_worker_costs_that_row_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, processes: SupervisedExecutor
) -> None:
    swept(plan(), tmp_path / "sound.jsonl")
    monkeypatch.setattr(sweeping, "judged_piece", deadly)
    monkeypatch.setattr(sweeping, "FIRST", 4)  # so that few processes die on the way to the sample
    monkeypatch.setattr(sweeping, "MOST", 4)
    (counted,) = sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(processes, lambda: 2)))
    sound, rows = rows_of(tmp_path / "sound.jsonl"), rows_of(tmp_path / "rows.jsonl")
    assert [number for number in range(300) if rows[number] != sound[number]] == [77, 200]
    assert (rows[77]["verdict"], rows[77]["how"]) == ("failed", "the worker was killed by SIGSEGV")
    assert (rows[200]["verdict"], rows[200]["how"]) == ("failed", "MemoryError: of sample 200")
    assert counted.rows == 300
    stood = counted.verdicts["stands"]
    assert counted.stands == interval(stood, stood + 2, 300, 0.05)  # neither counts for a side


def always(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    raise RuntimeError("no such luck")


def test_a_sweep_of_which_everything_fails_ends_and_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweeping, "judged_piece", always)
    monkeypatch.setattr(sweeping, "MOST_FAILED", 5)
    with pytest.raises(SweepError, match=r"samples failed, one of shaky\[exact\]: RuntimeError: no such luck"):
        swept(plan(), tmp_path / "rows.jsonl")


def elsewhere(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    return judged_piece(case, first, count, "0123456789abcdef")


def test_a_worker_with_another_program_is_refused_by_the_name_of_its_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweeping, "judged_piece", elsewhere)
    monkeypatch.setattr(platform, "node", lambda: "node7")
    with pytest.raises(SweepError, match="the worker on node7 has a different program: its digest is"):
        swept(plan(), tmp_path / "rows.jsonl")


class Lacks(Here):
    """An executor whose workers have no such program."""

    def submit(self, fn: Callable[..., Any], /, *args: object, **kwargs: object) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_exception(ModuleNotFoundError("No module named 'stackdsl'"))
        return future


class Fails(Here):
    """An executor that loses calls."""

    def __init__(self, often: int) -> None:
        self.left = often

    def submit(self, fn: Callable[..., Any], /, *args: object, **kwargs: object) -> Future[Any]:
        self.left -= 1
        if self.left < 0:
            return super().submit(fn, *args, **kwargs)
        future: Future[Any] = Future()
        future.set_exception(OSError("the network is down"))
        return future


def test_lost_pieces_are_sent_again_a_limited_number_of_times(tmp_path: Path) -> None:
    swept(plan(), tmp_path / "whole.jsonl")
    sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(Fails(2), lambda: 1)))
    assert (tmp_path / "rows.jsonl").read_bytes() == (tmp_path / "whole.jsonl").read_bytes()
    with pytest.raises(SweepError, match="failed 3 times with the same samples: OSError: the network is down"):
        sweep(plan(), tmp_path / "lost.jsonl", lambda: nullcontext(Workers(Fails(1000), lambda: 1)))
    with pytest.raises(
        SweepError, match="a worker has a different program: No module named 'stackdsl'; install the same"
    ):
        sweep(plan(), tmp_path / "lacks.jsonl", lambda: nullcontext(Workers(Lacks(), lambda: 1)))


def test_what_becomes_of_a_cluster_is_told(tmp_path: Path) -> None:
    def gone() -> int:
        raise OSError("the scheduler has gone")

    with pytest.raises(SweepError, match="the executor no longer answers: OSError: the scheduler has gone"):
        sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(Here(), gone)))
    broken = ThreadPoolExecutor(1)
    broken.shutdown()
    with pytest.raises(
        SweepError, match="the executor accepts no more work: RuntimeError: cannot schedule new futures"
    ):
        sweep(plan(), tmp_path / "rows.jsonl", lambda: nullcontext(Workers(broken, lambda: 1)))


def test_samples_with_values_of_their_own_are_swept_too_and_a_mistaken_one_is_a_row(tmp_path: Path) -> None:
    """A block on a slope of which friction is drawn stands where that is above the tangent, 0.2."""
    text = """
scenario: slope
samples: {samples}
seed: {seed}
uncertain: {{mu: {{normal: 0.2 ± 0.2}}}}
friction: ${{mu}}
world: {{ground: {{friction: "${{mu}}"}}, tilt: 11.309932474020213 deg}}
build:
  - column: {{levels: 1}}
"""
    (counted,) = swept(plan(text, 40), tmp_path / "rows.jsonl")
    values = Draws(1, "slope", 0, 40).uniform("= mu")[0]
    drawn = [0.2 + 0.2 * NormalDist().inv_cdf(value) for value in values.tolist()]
    rows = rows_of(tmp_path / "rows.jsonl")
    told = [str(row["verdict"]) for row in rows]
    assert told == ["failed" if mu < 0.0 else "stands" if mu > 0.2 else "collapses" for mu in drawn]
    assert {"failed", "stands", "collapses"} == set(told)
    assert counted.verdicts["failed"] == told.count("failed")
    first = told.index("failed")
    assert f"sample {first} has mu = " in str(rows[first]["how"])


def test_nothing_is_started_where_all_rows_are_there(tmp_path: Path) -> None:
    swept(plan(), tmp_path / "rows.jsonl")

    def ignore_progress() -> AbstractContextManager[Workers]:
        raise AssertionError("nobody is wanted")

    (counted,) = sweep(plan(), tmp_path / "rows.jsonl", ignore_progress)
    assert counted.rows == 300
