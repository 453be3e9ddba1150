"""`import stackdsl`: all that a user needs, loaded at first use, and YAML from files and texts."""

import subprocess
import sys
from pathlib import Path

import pytest

import stackdsl
from stackdsl import ScenarioError, load, loads, play
from tests.paths import ROOT

LEANING = """\
scenario: leaning
matrix: {levels: [9, 12]}
build:
  - column: {levels: "${levels}", step: 12 mm}
expect:
  - stands: all
"""


def test_every_public_name_is_there() -> None:
    assert [name for name in stackdsl.__all__ if not hasattr(stackdsl, name)] == []
    assert set(stackdsl.__all__) <= set(dir(stackdsl))
    with pytest.raises(AttributeError, match="has no attribute 'Tower'"):
        _ = stackdsl.Tower  # type: ignore[attr-defined]


def test_importing_the_package_loads_nothing_slow() -> None:
    code = "import sys, stackdsl; sys.exit(bool({'numpy', 'pydantic', 'scipy', 'yaml'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


def test_cases_come_from_a_file_a_folder_and_a_text(tmp_path: Path) -> None:
    (tmp_path / "leaning.yaml").write_text(LEANING, encoding="utf-8")
    names = ["leaning[levels=9,exact]", "leaning[levels=12,exact]"]
    for cases in (load(tmp_path / "leaning.yaml"), load(str(tmp_path)), loads(LEANING)):
        assert [case.name for case in cases] == names
    # 12 levels of 12 mm lean further than a plank of 117.6 mm
    assert [bool(play(case)) for case in loads(LEANING)] == [True, False]


def test_what_cannot_be_loaded_is_told_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"tower.yaml:4:35: SD101 unknown key 'stp'") as told:
        loads(LEANING.replace("step:", "stp:"), "tower.yaml")
    assert "did you mean 'step'?" in str(told.value)
    with pytest.raises(ScenarioError, match="SD001"):
        load(tmp_path / "none.yaml")
    with pytest.raises(LookupError, match="there is no scenario in"):
        load(tmp_path)
