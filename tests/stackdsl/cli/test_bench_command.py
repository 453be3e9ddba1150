"""`stackdsl bench` as a user meets it: the table, the files, stopping and going on."""

import json
import re
from pathlib import Path

import pytest

from tests.command_line import AMPLE, Stackdsl, started
from tests.engines_at_hand import needs_pybullet

pytestmark = pytest.mark.usefixtures("interruptible")

# The second scene falls with plank floor(117.6 / 40) + 1 = 3.
SCENES = """\
scenario: flat
build:
  - column: {levels: 2}
truth:
  - stands: all
    source: closed form, nothing leans
---
scenario: stepped
build:
  - column: {levels: 3, step: 40 mm}
    every: 0.3 s
truth:
  - collapses: {at: level 3}
    source: closed form, N d <= L
"""
# The command, with a Ctrl-C once two runs are written down.
INTERRUPTED = """
import signal
from itertools import count
from stackdsl.bench.journal import Journal
from stackdsl.cli.main import main
add, added = Journal.add, count(1)

def interrupted(journal, record):
    add(journal, record)
    if next(added) == 2:
        signal.raise_signal(signal.SIGINT)

Journal.add = interrupted
main()
"""
QUICK = ("bench", "scenes.yaml", "--system", "exact", "--system", "stock", "--resolutions", "1,1/2", "--output", "out")


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    (tmp_path / "scenes.yaml").write_text(SCENES, encoding="utf-8")
    return tmp_path


@needs_pybullet
def test_a_bench_is_interrupted_resumed_and_written_down(stackdsl: Stackdsl, folder: Path) -> None:
    journal = folder / "out" / "runs.jsonl"
    process = started(folder, *QUICK, program=("-c", INTERRUPTED))
    out, _ = process.communicate(timeout=AMPLE)
    assert process.returncode == 130
    assert "interrupted, go on with --resume" in out.splitlines()[-1]
    kept = [line for line in journal.read_text(encoding="utf-8").splitlines() if '"status": "done"' in line]
    assert len(kept) >= 2

    code, out, err = stackdsl(*QUICK, "--resume")
    assert code == 0
    assert "8 of 8 runs done, 0 wrong verdicts" in out
    assert journal.read_text(encoding="utf-8").splitlines()[: len(kept)] == kept
    assert "[8/8]" in err

    report = json.loads((folder / "out" / "bench.json").read_text(encoding="utf-8"))
    assert [run["case"] for run in report["runs"]] == ["flat"] * 4 + ["stepped"] * 4
    assert {run["wrong_verdict"] for run in report["runs"]} == {False}
    assert all(run["peak_memory_bytes"] > 2**20 and run["wall_time_s"] > 0.0 for run in report["runs"])
    exact = [run for run in report["runs"] if run["system"] == "exact"]
    assert [run["creep_mm"] for run in exact] == [0.0, 0.0, 0.0, 0.0]  # what falls had not moved before either
    assert [run["steps"] for run in exact[:2]] == [0, 0]
    assert exact[3]["settings"]["time_step"] == exact[2]["settings"]["time_step"] / 2.0
    assert {"python", "pybullet", "numpy"} <= set(report["versions"])
    assert "# Speed against error" in (folder / "out" / "speed-against-error.md").read_text(encoding="utf-8")


@needs_pybullet
def test_a_coarse_step_is_found_to_bring_down_what_stands(stackdsl: Stackdsl, folder: Path) -> None:
    # PyBullet as it comes with four times its step: the stack falls, and statics prove that it stands.
    text = SCENES.split("---", maxsplit=1)[0].replace(
        "column: {levels: 2}", "four_stack: {levels: 8}\n    every: 0.5 s"
    )
    (folder / "scenes.yaml").write_text(text, encoding="utf-8")
    code, out, _ = stackdsl("bench", "scenes.yaml", "--system", "stock", "--resolutions", "4", "--output", "out")
    assert code == 0
    assert re.search(r"flat on stock, step x 4: falls at level \d, known from truth", out)
    assert "flat on stock, step x 4: statics prove that it stands" in out
    assert "1 wrong verdict, 1 numerical collapse" in out.splitlines()[-1]


@pytest.mark.parametrize(
    ("resolutions", "told"),
    [("2,x", "no list of numbers"), ("1/0", "no list of numbers"), ("1,-1", "from 1/64 to 64"), ("65", "1/64 to 64")],
)
def test_resolutions_are_numbers_within_reason(stackdsl: Stackdsl, folder: Path, resolutions: str, told: str) -> None:
    code, _, err = stackdsl("bench", "scenes.yaml", "--resolutions", resolutions)
    assert code == 4
    assert told in err
    assert not (folder / "bench").exists()


def test_selecting_nothing_is_wrong_usage(stackdsl: Stackdsl, folder: Path) -> None:
    code, _, err = stackdsl("bench", "scenes.yaml", "-k", "nothing-like-it")
    assert code == 4
    assert "nothing selected" in err


@needs_pybullet
def test_an_output_that_cannot_be_written_is_told(stackdsl: Stackdsl, folder: Path) -> None:
    (folder / "out").write_text("a file", encoding="utf-8")
    code, _, err = stackdsl(*QUICK)
    assert code == 4
    assert "out cannot be written" in err


@needs_pybullet
def test_resuming_where_other_jobs_were_done_is_told_and_loses_nothing(stackdsl: Stackdsl, folder: Path) -> None:
    exact = ("bench", "scenes.yaml", "--system", "exact", "--resolutions", "1", "--output", "out")
    assert stackdsl(*exact).code == 0
    journal = folder / "out" / "runs.jsonl"
    runs = journal.read_text(encoding="utf-8")
    assert len(runs.splitlines()) == 2

    stock = (*exact[:3], "stock", *exact[4:])
    code, _, err = stackdsl(*stock, "--resume")
    assert code == 4
    assert "out holds 2 runs (flat on exact, step x 1, ...), and asked for are 2 runs (flat on stock, step x 1" in err
    assert "use another --output" in err
    assert journal.read_text(encoding="utf-8") == runs

    code, out, err = stackdsl(*exact, "-k", "flat", "--resume")
    assert code == 0
    assert "1 of 1 runs done" in out
    assert "kept in out/runs.of-other-jobs.jsonl" in err
    aside = (folder / "out" / "runs.of-other-jobs.jsonl").read_text(encoding="utf-8")
    assert sorted((journal.read_text(encoding="utf-8") + aside).splitlines()) == sorted(runs.splitlines())

    code, out, err = stackdsl(*exact, "--resume")
    assert (code, sorted(journal.read_text(encoding="utf-8").splitlines())) == (0, sorted(runs.splitlines()))
    assert "kept in" not in err


def test_what_cannot_be_compiled_is_told_again_below_the_table(stackdsl: Stackdsl, folder: Path) -> None:
    (folder / "bad.yaml").write_text("scenario: bad\nbuild: []\n", encoding="utf-8")
    code, out, err = stackdsl("bench", ".", "-k", "flat", "--system", "exact", "--resolutions", "1")
    assert code == 2
    assert "1 of 1 runs done" in out
    assert err.rstrip().endswith("1 mistake in scenarios, told above: these were not played")
