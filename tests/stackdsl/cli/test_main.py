"""The command as a user meets it: exit codes, diagnostics, output, and never a traceback."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stackdsl.cli.options import REPORT_FORMATS
from stackdsl.language.json_schema import schema_text
from tests.command_line import GOOD, Result, Stackdsl, StackdslIn, write
from tests.engines_at_hand import needs_pybullet
from tests.paths import ROOT

ALIAS_BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


# A file, and the code, place and cause that are told of it.
MISTAKES: list[tuple[str | bytes, tuple[str, str, str]]] = [
    (GOOD.replace("levels", "levles"), ("SD101", "scene.yaml:3:14", "did you mean 'levels'?")),
    (GOOD.replace("1 s", "1 mm"), ("SD106", "scene.yaml:4:12", "mm")),
    (GOOD.replace("1 s", "1"), ("SD105", "scene.yaml:4:12", "unit")),
    (GOOD.replace("levels: 3", "step: 1 mm"), ("SD102", "scene.yaml:3", "levels")),
    (GOOD + "build: []\n", ("SD003", "scene.yaml:7:1", "2:1")),
    (GOOD.replace("stands: all", "height: 20 mm"), ("SD107", "scene.yaml:6:13", "is a single value")),
    (GOOD.replace("column: {levels: 3}", "bricks: [{at: [0 m, 0 m, 3.9 mm]}, {at: [0 m, 0 m, 8 mm]}]"),
     ("SD201", "scene.yaml:3", "inside")),
    (ALIAS_BOMB, ("SD008", "scene.yaml", "alias")),
    ("a: " + "[" * 100_000, ("SD007", "scene.yaml:1:67", "more than 64")),
    (b"scenario: caf\xe9\n", ("SD002", "scene.yaml:1:14", "UTF-8")),
    ("", ("SD005", "scene.yaml:1:1", "scenario")),
    ("# nothing here\n", ("SD005", "scene.yaml:1:1", "scenario")),
    (GOOD.replace("every: 1 s", "every: 1_000 s"), ("SD10", "scene.yaml:4", "1_000")),
    (GOOD.replace("levels: 3", "levels: 012"), ("SD009", "scene.yaml:3", "012")),
]  # fmt: skip


@pytest.fixture(scope="module")
def with_mistakes(stackdsl_in: StackdslIn, tmp_path_factory: pytest.TempPathFactory) -> Result:
    """What is told of all these files, each in a folder of its own."""
    folder = tmp_path_factory.mktemp("mistakes")
    for number, (text, _) in enumerate(MISTAKES):
        write(folder, text, f"{number:02}/scene.yaml")
    return stackdsl_in(folder, "check", ".")


@pytest.mark.parametrize("number", range(len(MISTAKES)), ids=[f"{code} {cause}" for _, (code, _, cause) in MISTAKES])
def test_each_mistake_is_told_with_code_place_cause_and_remedy(with_mistakes: Result, number: int) -> None:
    text, (code, place, cause) = MISTAKES[number]
    assert with_mistakes.code == 2
    start = f"{number:02}/{place}"
    (told,) = (told for told in with_mistakes.out.split("\n\n") if told.startswith(start) and code in told)
    assert cause in told
    assert "  = " in told  # the remedy
    assert "^" in told or not text


def test_a_directory_in_place_of_a_file_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "folder.yaml").mkdir()
    result = stackdsl("check", "folder.yaml")
    assert result.code == 2
    assert "SD001" in result.out
    assert "directory" in result.out


@pytest.mark.parametrize("command", ["check", "run", "explain"])
def test_a_missing_file_is_told(stackdsl: Stackdsl, command: str) -> None:
    result = stackdsl(command, "nowhere.yaml")
    assert result.code == 2
    assert "SD001" in result.text
    assert "^" not in result.text


def test_all_mistakes_of_all_files_are_told_at_once_and_the_good_ones_are_played(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, GOOD, "s/good.yaml")
    write(tmp_path, GOOD.replace("1 s", "1").replace("levels", "levles").replace("good", "bad"), "s/bad.yaml")
    result = stackdsl("check", "s")
    assert result.code == 2
    assert [result.out.count(code) for code in ("SD101", "SD102", "SD105")] == [
        1,
        0,
        1,
    ]  # a misspelt key is not missing as well
    assert "1 passed" in result.out


BROKEN_IN_ONE_VARIANT = """\
scenario: broken
matrix: {step: [5 mm, 5]}
build:
  - column: {levels: 3, step: "${step}"}
"""
BROKEN_MATRIX = """\
scenario: broken
matrix: {step: 5 mm}
build:
  - column: {levels: 3}
"""


@pytest.mark.parametrize("text", [BROKEN_IN_ONE_VARIANT, BROKEN_MATRIX], ids=["one variant", "matrix"])
def test_a_scenario_with_a_mistake_is_not_played_in_any_variant(stackdsl: Stackdsl, tmp_path: Path, text: str) -> None:
    write(tmp_path, text + "---\n" + GOOD, "s/both.yaml")
    result = stackdsl("check", "s", "--update")
    assert result.code == 2
    assert [*(tmp_path / "golden").rglob("*.json")] == [tmp_path / "golden" / "good" / "exact.json"]
    assert stackdsl("check", "s", "--list").out.split() == ["good[exact]"]
    assert "broken" not in stackdsl("explain", "s/both.yaml").out


def test_of_scenarios_with_one_name_none_is_played(stackdsl: Stackdsl, tmp_path: Path) -> None:
    for name in ("s/a.yaml", "s/b.yaml", "s/c.yaml"):
        write(tmp_path, GOOD, name)
    write(tmp_path, GOOD.replace("good", "other"), "s/d.yaml")
    result = stackdsl("check", "s", "--update")
    assert result.code == 2
    assert [line.split()[0] for line in result.out.splitlines() if "SD203" in line] == [
        "s/b.yaml:1:11:",
        "s/c.yaml:1:11:",
    ]
    assert [*(tmp_path / "golden").rglob("*.json")] == [tmp_path / "golden" / "other" / "exact.json"]
    assert stackdsl("check", "s", "--list").out.split() == ["other[exact]"]


def test_a_failed_expectation_is_shown_with_its_line_and_margin(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD + "  - height: 20 mm ± 1 mm\n")
    result = stackdsl("check", str(path), "--update")
    assert result.code == 1
    assert "scene.yaml:7:5" in result.out
    assert "23.4 mm" in result.out or "23.39 mm" in result.out
    assert "misses by 2.4 mm" in result.out or "misses by 2.39" in result.out


# PyBullet as it comes shakes this down, though it stands: statics prove it, and a finer step shows it.
TOWER = GOOD.replace("column: {levels: 3}", "four_stack: {levels: 8}").replace("1 s", "0.5 s") + "systems: [stock]\n"


@needs_pybullet
def test_refine_calls_a_numerical_collapse_one_and_fails(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, TOWER.replace("stands: all", "collapses: any"))
    result = stackdsl("check", str(path), "--refine")
    assert result.code == 1
    assert "a numerical collapse: statics prove that it stands" in result.out
    assert "good[stock]: verdict: numerical-collapse -> stands" in result.out
    assert "1 numerical-collapse" in result.out.splitlines()[-1]
    assert not (tmp_path / "golden").exists()


def test_refined_runs_write_no_snapshots(stackdsl: Stackdsl, tmp_path: Path) -> None:
    result = stackdsl("check", str(write(tmp_path, GOOD)), "--refine", "--update")
    assert result.code == 4
    assert "--refine writes no golden files" in result.err


def test_refine_plays_proven_cases_once(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD)
    assert stackdsl("check", str(path), "--update").code == 0
    report = json.loads(stackdsl("check", str(path), "--refine", "--format", "json").out)
    assert report["exit_code"] == 0
    assert report["results"][0]["refinement"] == []


def test_json_goes_to_stdout_alone(stackdsl: Stackdsl, tmp_path: Path) -> None:
    result = stackdsl("check", str(write(tmp_path, GOOD)), "--format", "json")
    report = json.loads(result.out)
    assert report["results"][0]["scenario"] == "good"
    assert report["results"][0]["verdict"] == "stands"


def test_every_format_is_on_the_page_of_the_command() -> None:
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    (row,) = [line for line in page.splitlines() if line.startswith("| `--format")]
    assert [form for form in REPORT_FORMATS if f"`{form}`" not in row] == []


def test_selecting_nothing_is_wrong_usage(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = str(write(tmp_path, GOOD))
    assert stackdsl("check", path, "-k", "nothing-like-it").code == 4
    assert stackdsl("check", path, "--system", "stock").code == 4
    assert stackdsl("check", path, "--frobnicate").code == 4
    assert stackdsl("nonsense").code == 4


@needs_pybullet
def test_list_names_the_selected_cases_and_plays_none(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD + "tags: [short]\nsystems: [exact, tuned]\n", "s/a.yaml")
    write(tmp_path, GOOD.replace("good", "other") + "tags: [long]\n", "s/b.yaml")
    assert stackdsl("check", "s", "--list").out.split() == ["good[exact]", "good[tuned]", "other[exact]"]
    assert stackdsl("check", "s", "--list", "--tag", "!long").out.split() == ["good[exact]", "good[tuned]"]
    assert stackdsl("check", "s", "--list", "--tag", "long").out.split() == ["other[exact]"]
    assert stackdsl("check", "s", "--list", "--system", "tuned").out.split() == ["good[tuned]"]
    assert stackdsl("check", "s", "--list", "-k", "other").out.split() == ["other[exact]"]


@needs_pybullet
def test_a_case_that_overruns_its_time_is_told_and_ends_with_5(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD.replace("every: 1 s", "every: 1000 s") + "systems: [tuned]\n")
    result = stackdsl("check", str(path), "--time-limit", "0.5")
    assert result.code == 5
    assert "timed out" in result.out


@pytest.mark.parametrize("limit", ["nan", "inf", "1e300", "0"])
def test_a_time_limit_is_a_time(stackdsl: Stackdsl, tmp_path: Path, limit: str) -> None:
    result = stackdsl("check", str(write(tmp_path, GOOD)), "--time-limit", limit)
    assert result.code == 4
    assert "--time-limit" in result.err


def test_run_prints_the_timeline_as_it_happens(stackdsl: Stackdsl, tmp_path: Path) -> None:
    result = stackdsl("run", str(write(tmp_path, GOOD)))
    assert result.code == 0
    assert [line.split()[2] for line in result.out.splitlines() if " s  " in line] == ["placed"] * 3
    assert "stands" in result.out


@needs_pybullet
def test_run_judges_and_ends_as_check_does_without_goldens(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD + "  - {height: 20 mm ± 1 mm, system: tuned}\nsystems: [exact, tuned]\n")
    path = "scene.yaml"
    held = stackdsl("run", path, "--system", "exact")
    assert held.code == 0
    assert "stands: expected all, measured 3 bricks stand, also with" in " ".join(held.out.split())
    missed = stackdsl("run", path, "-k", "tuned")
    assert missed.code == 1
    (line,) = (line for line in missed.out.splitlines() if line.startswith("✗ failed  height: "))
    assert line.endswith("(scene.yaml:7:6)")
    assert "expected 20 mm ± 1 mm, measured 23." in line
    assert "(misses by 2." in line
    assert not (tmp_path / "golden").exists()
    write(tmp_path, GOOD + "---\n" + GOOD.replace("1 s", "1"))
    assert stackdsl("run", path).code == 2


@needs_pybullet
def test_explain_takes_a_selection(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = str(write(tmp_path, GOOD + "systems: [exact, tuned]\n---\n" + GOOD.replace("good", "other")))
    explained = stackdsl("explain", path, "--system", "tuned").out
    assert "good, from" in explained
    assert "  tuned: " in explained
    assert "  exact: " not in explained
    assert "other, from" not in explained
    assert "good, from" not in stackdsl("explain", path, "-k", "other").out
    assert stackdsl("explain", path, "-k", "nothing-like-it").code == 4


def test_explain_tells_what_the_proofs_would_survive_unless_told_not_to(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = str(write(tmp_path, GOOD))
    assert "it survives" in stackdsl("explain", path).out
    assert "it survives" not in stackdsl("explain", path, "--no-margins").out


def test_explain_says_where_margins_count_on_contacts_that_may_be_squeezed(stackdsl: Stackdsl, tmp_path: Path) -> None:
    # A plank on the ground between two walls: pressed hard enough by them it would not budge, and maybe they do not.
    squeezed = "pressure statics does not determine"
    assert squeezed not in stackdsl("explain", str(write(tmp_path, GOOD))).out
    walls = "world: {walls: [{bearing: 0 deg, distance: 58.8 mm}, {bearing: 180 deg, distance: 58.8 mm}]}"
    between = f"scenario: between\n{walls}\nbuild: [bricks: [{{name: plank, at: [0 mm, 0 mm, 3.9 mm]}}]]\n"
    assert squeezed in stackdsl("explain", str(write(tmp_path, between))).out


def test_explain_prints_every_brick_with_its_support(stackdsl: Stackdsl, tmp_path: Path) -> None:
    result = stackdsl("explain", str(write(tmp_path, GOOD)))
    assert result.code == 0
    assert "L2.1" in result.out
    assert "on L1.1" in result.out


def test_a_new_scenario_passes_once_its_snapshot_is_accepted(stackdsl: Stackdsl, tmp_path: Path) -> None:
    assert stackdsl("new", "my-tower").code == 0
    assert stackdsl("check", "scenarios/my-tower.yaml", "--update").code == 0
    again = stackdsl("new", "my-tower")
    assert again.code == 4
    assert "exists" in again.err
    assert stackdsl("new", "No Good Name").code == 4


def test_a_new_scenario_in_a_file_is_told_as_that(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "taken").touch()
    result = stackdsl("new", "abc", "--to", "taken")
    assert result.code == 4
    assert "taken is not a directory" in result.err
    assert "exists already" not in result.err
    assert "taken/deeper cannot be created: Not a directory" in stackdsl("new", "abc", "--to", "taken/deeper").err


MODELINE = "# yaml-language-server: $schema="


def test_a_new_scenario_points_editors_to_the_schema_that_the_project_has(tmp_path: Path) -> None:
    packaged = ROOT / "stackdsl"
    # A project that brings the package along can be kept anywhere.
    shutil.copytree(packaged, tmp_path / "lib" / "stackdsl")
    shutil.copytree(packaged.parent / "stability", tmp_path / "lib" / "stability")
    (tmp_path / "lib" / "stackdsl" / "scenario.schema.json").write_text(schema_text(), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "stackdsl", "new", "my-tower", "--to", "scenarios/deep"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": "lib"}, check=True, capture_output=True,
    )  # fmt: skip
    assert b"wrote" in done.stdout
    text = (tmp_path / "scenarios" / "deep" / "my-tower.yaml").read_text(encoding="utf-8")
    assert text.startswith(MODELINE + "../../lib/stackdsl/scenario.schema.json\n")


def test_the_schema_is_valid_json(stackdsl: Stackdsl) -> None:
    assert json.loads(stackdsl("schema").out)["type"] == "object"


def test_no_color_means_no_escape_codes(stackdsl: Stackdsl, tmp_path: Path) -> None:
    assert "\x1b" not in stackdsl("check", str(write(tmp_path, GOOD)), NO_COLOR="1", FORCE_COLOR="1").out


def test_a_bar_tells_how_many_samples_are_drawn(stackdsl: Stackdsl, tmp_path: Path) -> None:
    text = """
scenario: shaky
samples: 200
build:
  - column: {levels: 3, step: 8 mm}
    jitter: {position: 1 mm}
expect:
  - stands: {share: ">= 50 %"}
"""
    file = str(write(tmp_path, text))
    bar = stackdsl("check", "--no-golden", "--no-cache", file, FORCE_COLOR="1", NO_COLOR="1").err
    assert "shaky[exact]: samples" in bar
    assert "0/200" in bar
    assert "100/200" in bar  # the first look
