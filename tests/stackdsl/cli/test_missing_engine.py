"""Where PyBullet is not installed: what needs no engine is played, what needs it is skipped by name and told why."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from stackdsl.checking.cases import gather
from stackdsl.language import schema
from tests.command_line import GOOD, Result, write
from tests.paths import ROOT

# The command, where some packages cannot be imported.
WITHOUT = """
import sys
sys.modules |= dict.fromkeys({packages}, None)
from stackdsl.__main__ import main
main()
"""
BARE = GOOD.replace("good", "bare") + "systems: [tuned]\n"
BOTH = GOOD + "systems: [exact, thesis, tuned]\n"
FALLS = """\
scenario: falls
build:
  - column: {levels: 4, step: 40 mm}
    every: 0.1 s
expect:
  - collapses: {at: level 4 ± 0}
"""


def without(folder: Path, packages: set[str], *arguments: str) -> Result:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT.format(packages=sorted(packages)), *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "CI": ""},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert "Traceback" not in done.stderr
    return Result(done.returncode, done.stdout, done.stderr)


def test_cases_that_need_pybullet_are_skipped_by_name_and_others_are_played(tmp_path: Path) -> None:
    write(tmp_path, BOTH)
    result = without(tmp_path, {"pybullet", "mujoco"}, "check", "--update", "scene.yaml")
    assert result.code == 0
    assert "1 golden written" not in result.out
    assert "1 passed, 2 skipped" in result.out
    assert "'tuned' needs pybullet, which is not installed; try: pip install pybullet, with Python 3.11" in result.out
    assert "good[tuned]" in result.out
    assert [*(tmp_path / "golden").rglob("*.json")] == [tmp_path / "golden" / "good" / "exact.json"]


def test_a_scenario_that_cannot_be_played_at_all_is_wrong_usage(tmp_path: Path) -> None:
    write(tmp_path, BARE)
    assert without(tmp_path, {"pybullet"}, "check", "scene.yaml").code == 4


def test_a_system_that_is_asked_for_is_refused_as_those_of_other_engines_are(tmp_path: Path) -> None:
    write(tmp_path, BARE)
    result = without(tmp_path, {"pybullet"}, "check", "scene.yaml", "--system", "tuned")
    assert result.code == 4
    assert "'tuned' needs pybullet, which is not installed; try: pip install pybullet" in result.err


@pytest.mark.skipif(not find_spec("mujoco"), reason="mujoco is not installed")
def test_without_pybullet_mujoco_steps_falls_and_report_and_golden_name_it(tmp_path: Path) -> None:
    write(tmp_path, FALLS)
    assert without(tmp_path, {"pybullet"}, "check", "--update", "scene.yaml").code == 0
    result = without(tmp_path, {"pybullet"}, "check", "--format", "json", "scene.yaml")
    (played,) = json.loads(result.out)["results"]
    golden = json.loads((tmp_path / "golden" / "falls" / "exact.json").read_text(encoding="ascii"))
    assert (result.code, played["engine"]) == (0, "mujoco")
    assert {"mujoco"} == golden["stamp"].keys() & {"mujoco", "pybullet"}
    assert "mujoco" in without(tmp_path, {"pybullet"}, "check", "scene.yaml").out


UNREAD = """\
scenario: crates
build: [{import: {file: crates.xml, format: mjcf}}]
expect: [{pivots: {about: crate}}]
skip: {reason: MuJoCo reads it, without: mujoco}
"""


def test_a_scenario_is_skipped_without_a_package_that_its_skip_names(tmp_path: Path) -> None:
    write(tmp_path, UNREAD, "crates.yaml")
    checked = without(tmp_path, {"mujoco"}, "check", ".", "--format", "json")
    assert json.loads(checked.out)["conclusions"] == {"passed": 0, "skipped": 1}
    explained = without(tmp_path, {"mujoco"}, "explain", "crates.yaml")
    assert (explained.code, explained.out) == (4, "")
    assert explained.err == "crates is skipped: MuJoCo reads it; try: pip install 'stackdsl[mujoco]'\n"


def test_a_scenario_is_read_with_the_package_that_its_skip_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, UNREAD, "crates.yaml")
    monkeypatch.setattr(schema, "find_spec", lambda _: True)
    (mistake,) = gather([tmp_path / "crates.yaml"]).diagnostics
    assert mistake.message.endswith("does not exist")


def test_skip_without_names_only_optional_packages(tmp_path: Path) -> None:
    write(tmp_path, UNREAD.replace("import: {file: crates.xml, format: mjcf}", "column: {levels: 2}"), "good.yaml")
    write(tmp_path, (tmp_path / "good.yaml").read_text().replace("without: mujoco", "without: numpy"), "bad.yaml")
    (mistake,) = gather([tmp_path / "bad.yaml"]).diagnostics
    assert mistake.code == "SD104"
