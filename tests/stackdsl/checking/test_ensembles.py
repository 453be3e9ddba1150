"""Samples are drawn look by look until all is decided, the same in whatever parts, and none twice."""

from pathlib import Path

import pytest

from stackdsl.checking import ensembles
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case
from stackdsl.checking.ensembles import CHUNK, Chunk, Drawing, Run, draw, draw_samples, judged_chunk, judged_samples
from stackdsl.sampling.samples import Draws
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import TaskStatus
from stackdsl.trace import Ensemble
from tests.scenes import compiled
from tests.stackdsl.checking.in_process import run_here

COLUMN = """
scenario: column
samples: {samples}
build:
  - column: {{levels: 8, step: 8 mm}}
    every: 1 s
    jitter: {{position: 4 mm}}
expect:
  - stands: {{share: "{share}"}}
"""
LIMIT = 120.0  # [s] for what takes less than one


def case(samples: int, share: str = ">= 50 %") -> Case:
    cases, mistakes = compiled(COLUMN.format(samples=samples, share=share))
    assert mistakes == []
    return cases[0]


def ensemble(samples: int, share: str, workers: int = 1, run: Run = run_here) -> Ensemble:
    drawing = draw_samples(case(samples, share), workers, LIMIT, run)
    assert drawing is not None
    return drawing.ensemble()


def test_no_more_samples_are_drawn_than_decide() -> None:
    assert ensemble(1600, ">= 50 %").drawn == 100
    assert ensemble(1600, "< 20 %").drawn == 100
    close = ensemble(1600, ">= 80 %")
    assert close.drawn == close.planned == 1600


@pytest.mark.slow
def test_any_number_of_processes_draws_the_same() -> None:
    assert ensemble(1200, ">= 80 %", 3, run_supervised) == ensemble(1200, ">= 80 %")


def test_remembered_samples_are_not_drawn_again_and_missing_ones_are_added(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after a call that was killed: its chunks are remembered one by one."""
    asked: list[int] = []

    def counted(drawing: Drawing, first: int, count: int) -> tuple[object, ...]:
        asked.append(first)
        return judged_chunk, (drawing.case.timeline, drawing.case.system, Draws(1, "column", first, count))

    monkeypatch.setattr(ensembles, "_call", counted)
    whole, ended = case(2000, ">= 80 %"), list[Drawing]()
    memory = ResultCache(tmp_path)
    draw({0: Drawing(whole, "digest")}, 1, LIMIT, memory, lambda _, drawing: ended.append(drawing), run=run_here)
    assert sorted(asked) == [0, 125, 250, 500, 1000, 1500]
    records = sorted(tmp_path.rglob("*.json"), key=lambda file: file.stat().st_size)
    records[-1].unlink()  # one of the chunks of 500
    asked.clear()
    draw({0: Drawing(whole, "digest")}, 1, LIMIT, memory, lambda _, drawing: ended.append(drawing), run=run_here)
    assert len(asked) == 1
    assert ended[0].ensemble() == ended[1].ensemble()
    asked.clear()
    draw({0: Drawing(whole, "another text")}, 1, LIMIT, memory, lambda _, drawing: ended.append(drawing), run=run_here)
    assert len(asked) == 6


def test_remembered_samples_beyond_the_deciding_ones_do_not_count(tmp_path: Path) -> None:
    """So that a case comes to the same whether it was drawn further before or not."""
    memory, ended = ResultCache(tmp_path), list[Drawing]()
    for share in (">= 80 %", ">= 50 %"):
        drawing = Drawing(case(2000, share), "digest")
        draw({0: drawing}, 1, LIMIT, memory, lambda _, drawn: ended.append(drawn), run=run_here)
    assert [drawing.ensemble().drawn for drawing in ended] == [2000, 125]


def fails(*_: object) -> Chunk:
    raise RuntimeError("no such luck")


def test_a_chunk_that_fails_is_told_and_ends_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ensembles, "judged_chunk", fails)
    drawing = draw_samples(case(CHUNK), 1, LIMIT)
    assert drawing is not None
    assert drawing.failed is not None
    assert drawing.failed.status is TaskStatus.CRASHED
    assert "no such luck" in drawing.failed.message


def test_the_result_says_what_was_drawn_and_how_it_is_known() -> None:
    sampled = case(400, ">= 50 %")
    drawing = draw_samples(sampled, 1, LIMIT, run_here)
    assert drawing is not None
    result = judged_samples(sampled, drawing.ensemble())
    assert result.passed
    assert result.ensemble is not None
    assert result.verdict == f"{result.ensemble.stood} of 100 stand"
    assert sum(result.ensemble.ways.values()) == 100
    assert result.ensemble.stood + sum(result.ensemble.fell.values()) == 100


def test_progress_is_reported_for_each_chunk_of_samples() -> None:
    told: list[tuple[str, int, int]] = []
    draw_samples(case(1600, ">= 80 %"), 1, LIMIT, run_here, on_drawn=lambda *each: told.append(each))
    assert told == [("column[exact]", count, 1600) for count in (0, 100, 200, 400, 500, 800, 1000, 1500, 1600)]
