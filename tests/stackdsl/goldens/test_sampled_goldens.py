"""A golden file of samples locks what became of them, count by count."""

from dataclasses import replace
from pathlib import Path

import pytest

from stackdsl.goldens.golden import check_golden
from stackdsl.goldens.snapshot import Identity, Snapshot, snapshot_of_samples
from stackdsl.results import GoldenStatus
from stackdsl.timeline import FixedWorld
from stackdsl.trace import Ensemble

BEFORE = Ensemble(100, 200, 7, stood=90, fell={9: 4, 10: 5}, undecided=1)


def snapshot(ensemble: Ensemble) -> Snapshot:
    return snapshot_of_samples(
        ensemble, FixedWorld(9.81, 0.5, ()), Identity("tower", "exact", "exact"), {"python": "3.11"}
    )


@pytest.fixture
def golden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("CI", raising=False)
    check_golden(snapshot(BEFORE), tmp_path, update=True)
    return tmp_path


def test_the_same_counts_agree(golden: Path) -> None:
    again = replace(BEFORE, cpu_time=9.0, ways={"full statics": 100})
    assert check_golden(snapshot(again), golden, update=False).status is GoldenStatus.SAME


@pytest.mark.parametrize(
    ("after", "told"),
    [
        (replace(BEFORE, stood=91, fell={9: 3, 10: 5}), {("stood", "90", "91"), ("fell at level 9", "4", "3")}),
        (replace(BEFORE, fell={9: 4, 11: 5}), {("fell at level 10", "5", "none"), ("fell at level 11", "none", "5")}),
        (replace(BEFORE, seed=8), {("seed", "7", "8")}),
        (replace(BEFORE, undecided=0, unfit=1), {("undecided", "1", "0"), ("unfit", "0", "1")}),
    ],
)
def test_a_difference_of_sampled_goldens_names_each_count(
    golden: Path, after: Ensemble, told: set[tuple[str, str, str]]
) -> None:
    found = check_golden(snapshot(after), golden, update=False)
    assert found.status is GoldenStatus.DIFFERENT
    assert {(each.quantity, each.expected, each.got) for each in found.differences} == told


def test_a_misspelt_count_is_refused(golden: Path) -> None:
    (file,) = golden.rglob("*.json")
    file.write_text(file.read_text(encoding="utf-8").replace('"unfit"', '"unfitting"'), encoding="utf-8")
    assert check_golden(snapshot(BEFORE), golden, update=False).status is GoldenStatus.UNREADABLE
