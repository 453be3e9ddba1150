"""A golden file of another engine is held against what no engine decides, and never passes for one that agrees."""

import json
from pathlib import Path

import pytest

from stackdsl.goldens.file_format import document
from stackdsl.goldens.golden import check_golden, judge_text
from stackdsl.goldens.snapshot import current_stamp, made_by_other_engine, stamp_note
from stackdsl.report.blocks import TextStyle
from stackdsl.report.check_text import report_text
from stackdsl.results import GoldenStatus, Report, RunStatus, VariantResult, exit_code
from tests.engines_at_hand import needs_pybullet
from tests.stackdsl.goldens.towers import FALL, taken, tower

PYBULLET, MUJOCO = {"pybullet": "3.2.7", "python": "3.11"}, {"mujoco": "4.0.0", "python": "3.12"}
NONE = {"python": "3.12"}
FALLS = taken(tower(collapse=FALL))


@needs_pybullet
def test_a_stamp_names_python_and_the_engine() -> None:
    assert current_stamp("pybullet", steps=12).keys() >= {"python", "pybullet"}
    assert "pybullet" not in current_stamp("pybullet", steps=0)


def test_where_another_engine_stands_in_it_is_named_only_if_it_took_a_step() -> None:
    assert "numpy" in current_stamp("numpy", steps=1)  # in place of an engine that may not be installed
    assert "numpy" not in current_stamp("numpy", steps=0)


@pytest.mark.parametrize(
    ("expected", "got", "differ"),
    [(PYBULLET, MUJOCO, True), (MUJOCO, PYBULLET, True), (PYBULLET, PYBULLET, False), (PYBULLET, NONE, False),
     (NONE, MUJOCO, False), (None, MUJOCO, False)],
)  # fmt: skip
def test_a_golden_without_engine_steps_is_compared_on_every_engine(expected: object, got: object, differ: bool) -> None:
    assert made_by_other_engine(expected, got) is differ


def of_mujoco(change: dict[str, object]) -> str:
    return json.dumps(json.loads(json.dumps(document(FALLS))) | {"stamp": MUJOCO} | change)


def test_of_another_engine_where_debris_came_to_rest_is_not_compared() -> None:
    result = judge_text("", of_mujoco({"height_mm": 3.0, "bricks": {}}), document(FALLS))
    assert (result.status, result.differences) == (GoldenStatus.OTHER_ENGINE, ())
    assert "mujoco 4.0.0 (now none)" in result.note


@pytest.mark.parametrize(("key", "value"), [("verdict", "stands"), ("statics", "stable"), ("collapse", {"level": 7})])
def test_of_another_engine_what_statics_and_the_author_decide_must_agree(key: str, value: object) -> None:
    result = judge_text("", of_mujoco({key: value}), document(FALLS))
    assert result.status is GoldenStatus.DIFFERENT


def test_an_update_leaves_the_file_of_another_engine_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)  # CI writes no golden
    check_golden(FALLS, tmp_path, update=True)
    (file,) = tmp_path.rglob("*.json")
    file.write_text(of_mujoco({}), encoding="ascii")
    before = file.read_bytes()
    assert check_golden(FALLS, tmp_path, update=True).status is GoldenStatus.OTHER_ENGINE
    assert file.read_bytes() == before


def test_a_golden_of_another_engine_counts_as_neither_passed_nor_failed() -> None:
    golden = judge_text("golden/falls.json", of_mujoco({}), document(FALLS))
    played = VariantResult("falls", "exact", "exact", "falls.yaml", RunStatus.DONE, "collapses", golden=golden)
    report = Report((played,))
    text = report_text(report, style=TextStyle(verbosity=1))
    assert exit_code(report) == 0
    assert "1 golden of another engine" in text
    assert "1 file made with mujoco 4.0.0 (now none)" in text


def test_an_engine_that_only_one_of_two_runs_needed_is_no_change_of_versions() -> None:
    needed, unneeded = {"numba": "0.68.1", "python": "3.11"}, {"python": "3.11"}
    assert stamp_note(unneeded, needed) == stamp_note(needed, unneeded) == ""
    assert stamp_note(needed, {"pybullet": "3.2.7", "python": "3.11"}) != ""
