"""What comes out is the same however many processes play it, in whatever order the files are named, and by pytest."""

import json
import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pytest

from tests.command_line import ROOT, Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

TIMES = ("wall_time_s", "update_median_s", "update_worst_s", "speed_up", "remembered")


def towers(folder: Path) -> list[str]:
    """Columns that lean ever more, of which the last ones fall: three planks stand as long as 3 d <= 117.6 mm."""
    names = []
    for number in range(6):
        text = f"scenario: s{number}\nbuild: [column: {{levels: 3, step: {36 + number} mm}}]\nexpect: [stands: all]\n"
        names.append(write(folder, text, f"scenarios/{number}.yaml").relative_to(folder).as_posix())
    return names


def without_times(value: Any) -> Any:  # noqa: ANN401 -- JSON
    if isinstance(value, dict):
        return {key: without_times(member) for key, member in value.items() if key not in TIMES}
    return [without_times(item) for item in value] if isinstance(value, list) else value


def results(stackdsl: Stackdsl, *arguments: str) -> dict[str, Any]:
    told = stackdsl("check", "--format", "json", "--no-golden", *arguments)
    return {each["scenario"]: without_times(each) for each in json.loads(told.out)["results"]}


def test_the_report_is_the_same_for_any_number_of_processes_and_any_order(stackdsl: Stackdsl, tmp_path: Path) -> None:
    files = towers(tmp_path)
    alone = results(stackdsl, *files, "--jobs", "1")
    assert len(alone) == len(files)
    assert len({each["verdict"] for each in alone.values()}) > 1  # some stand, some fall
    assert results(stackdsl, *files, "--jobs", "2") == alone
    assert results(stackdsl, *files, "--jobs", "4") == alone
    assert results(stackdsl, *files[3:], *files[2::-1], "--jobs", "2") == alone


@pytest.mark.slow
def test_pytest_in_two_processes_writes_the_same_goldens(stackdsl: Stackdsl, tmp_path: Path) -> None:
    towers(tmp_path)
    stackdsl("check", "scenarios", "--update")
    written = {path.name: path.read_bytes() for path in (tmp_path / "golden").rglob("*.json")}
    assert written
    for path in (tmp_path / "golden").rglob("*.json"):
        path.unlink()
    arguments = ("-q", "-n2", "scenarios", "--snapshot-update", "-p", "no:cacheprovider")
    plugin = () if entry_points(group="pytest11", name="stackdsl") else ("-p", "stackdsl.pytest_plugin")
    told = subprocess.run(
        [sys.executable, "-m", "pytest", *plugin, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": ROOT, "CI": ""},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    again = {path.name: path.read_bytes() for path in (tmp_path / "golden").rglob("*.json")}
    assert again == written, told.stdout
