"""`stackdsl sweep`: every variant and sample as a row of a file, gone on with by the same call."""

import csv
import json
import signal
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest
from click.testing import CliRunner

from stackdsl.cli import sweep as command
from stackdsl.exits import ExitCode
from stackdsl.judging.statistics import interval
from stackdsl.studies.sweep import sweep
from stackdsl.studies.sweep_plan import SweepPlan
from tests.command_line import AMPLE, Stackdsl, stackdsl_in_folder, started, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

pytestmark = pytest.mark.usefixtures("interruptible")

SHAKY = """
scenario: shaky
samples: 400
seed: 3
build:
  - column: {levels: 5, step: 8 mm}
    every: 1 s
    jitter: {position: 5 mm}
"""
STEPS = """
scenario: steps
matrix: {step: [5 mm, 12 mm]}
build:
  - column: {levels: 10, step: "${step}"}
    every: 1 s
"""


def test_sweep_writes_a_row_a_sample_and_prints_the_share_that_stands(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, SHAKY, "shaky.yaml")
    told = stackdsl("sweep", "shaky.yaml", "--out", "rows.jsonl", "--jobs", "2")
    assert told.code == ExitCode.OK
    rows = [json.loads(line) for line in (tmp_path / "rows.jsonl").read_text().splitlines()]
    assert [row["sample"] for row in rows] == [*range(400)]
    stood = sum(row["verdict"] == "stands" for row in rows)
    assert told.out.startswith(
        f"shaky[exact]: 400 of 400 samples, seed 3: {stood} stand, {400 - stood} fall at levels "
    )
    sure = interval(stood, stood, 400, 0.05)
    assert f"share that stands: {100 * sure.low:.3g} % to {100 * sure.high:.3g} %, 95 % confidence" in told.out
    more = stackdsl("sweep", "shaky.yaml", "--out", "rows.jsonl", "--samples", "500", "--format", "csv")
    assert more.err == "rows.jsonl has 400 of 500 rows\n"
    (row,) = csv.DictReader(more.out.splitlines())
    assert (row["case"], row["rows"], row["failed"]) == ("shaky[exact]", "500", "0")
    assert int(row["stands"]) + int(row["collapses"]) == 500


def test_variants_without_samples_have_a_row_each(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, STEPS, "steps.yaml")
    told = stackdsl("sweep", "steps.yaml", "--out", "rows.jsonl")
    assert told.out.splitlines()[0] == "steps[step=5mm,exact]: stands (proven)"
    assert told.out.splitlines()[1].startswith("steps[step=12mm,exact]: collapses at level 10 (")
    said = json.loads(stackdsl("sweep", "steps.yaml", "--out", "rows.jsonl", "--format", "json").out)
    assert [(each["case"], each["verdicts"]) for each in said["cases"]] == [
        ("steps[step=5mm,exact]", {"stands": 1}),
        ("steps[step=12mm,exact]", {"collapses": 1}),
    ]


def test_the_system_and_each_variable_have_a_column_of_numbers_in_si_or_words(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    bricks = 'brick: "${kind}"\nbuild'
    write(tmp_path, STEPS.replace("12 mm]", "12 mm], kind: [kapla, kapla-ideal]").replace("build", bricks), "two.yaml")
    stackdsl("sweep", "two.yaml", "--out", "rows.csv")
    stackdsl("sweep", "two.yaml", "--out", "rows.jsonl")
    rows = [*csv.DictReader((tmp_path / "rows.csv").read_text().splitlines())]
    assert [*rows[0]][:4] == ["case", "system", "variable_step", "variable_kind"]
    chosen = [("exact", step, kind) for step in (0.005, 0.012) for kind in ("kapla", "kapla-ideal")]
    assert [(row["system"], float(row["variable_step"]), row["variable_kind"]) for row in rows] == chosen
    lines = [json.loads(line) for line in (tmp_path / "rows.jsonl").read_text().splitlines()]
    assert [(row["system"], row["variable_step"], row["variable_kind"]) for row in lines] == chosen


def test_ctrl_c_before_the_first_row_says_that_rows_of_earlier_calls_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "rows.csv"
    call = [str(write(tmp_path, STEPS, "steps.yaml")), "--out", str(out)]

    def interrupted(*_: object) -> SweepPlan:
        raise KeyboardInterrupt

    for kept in ("no row was written; the same call starts again", "is as it was; the same call continues it"):
        with monkeypatch.context() as early:
            early.setattr(command, "plan_of", interrupted)
            told = CliRunner().invoke(command.sweep_command, call)
            assert told.exit_code == ExitCode.INTERRUPTED
            assert kept in told.stderr
        assert CliRunner().invoke(command.sweep_command, call).exit_code == ExitCode.OK


def test_ctrl_c_after_the_last_row_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*arguments: Any) -> None:  # noqa: ANN401 -- those of the sweep
        sweep(*arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "sweep", late)
    out = tmp_path / "rows.csv"
    told = CliRunner().invoke(command.sweep_command, [str(write(tmp_path, STEPS, "steps.yaml")), "--out", str(out)])
    assert (told.exit_code, "interrupted" in told.stderr) == (ExitCode.OK, False)
    assert len(out.read_text().splitlines()) == 3


def test_sweep_refuses_bad_arguments_and_keeps_existing_rows(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, SHAKY, "shaky.yaml")
    write(tmp_path, STEPS, "steps.yaml")
    write(tmp_path, "mine\n", "mine.jsonl")

    def refused(*call: str) -> str:
        told = stackdsl("sweep", *call)
        assert (told.code, told.out) == (ExitCode.USAGE, "")
        return told.err

    assert "mine.jsonl is not the file of a sweep" in refused("shaky.yaml", "-o", "mine.jsonl")
    assert (tmp_path / "mine.jsonl").read_text() == "mine\n"
    assert "rows.txt: the name must end in .jsonl or .csv" in refused("shaky.yaml", "-o", "rows.txt")
    assert "has no samples" in refused("steps.yaml", "-o", "rows.jsonl", "--samples", "5")
    assert "--scheduler needs a Dask cluster" in refused("shaky.yaml", "-o", "rows.jsonl", "--scheduler", "x:1")
    assert "--jobs does not apply to a Dask cluster" in refused(
        "shaky.yaml", "-o", "r.jsonl", "--jobs", "1", "--executor", "dask"
    )
    stackdsl("sweep", "shaky.yaml", "-o", "rows.jsonl", "--samples", "5")
    write(tmp_path, SHAKY.replace("seed: 3", "seed: 4"), "shaky.yaml")
    assert "'shaky[exact]' had the seed 3, and has 4 now" in refused("shaky.yaml", "-o", "rows.jsonl")


def test_ctrl_c_keeps_the_rows_and_says_how_to_go_on(tmp_path: Path) -> None:
    write(tmp_path, SHAKY, "shaky.yaml")
    sweep = started(tmp_path, "sweep", "shaky.yaml", "--out", "rows.jsonl", "--jobs", "1", "--samples", "100000000")
    began = monotonic()
    out = tmp_path / "rows.jsonl"
    while not out.exists() or out.stat().st_size < 3_000:
        assert sweep.poll() is None
        assert monotonic() < began + AMPLE
        sleep(0.02)
    sweep.send_signal(signal.SIGINT)
    told, err = sweep.communicate()
    assert sweep.returncode == ExitCode.INTERRUPTED
    assert "Traceback" not in err
    rows = out.read_bytes().count(b"\n")
    assert out.read_bytes().endswith(b"}\n")
    assert f"{rows} of 100000000 rows are in rows.jsonl; the same call continues them" in err
    assert told.startswith(f"shaky[exact]: {rows} of 100000000 samples, seed 3: ")
