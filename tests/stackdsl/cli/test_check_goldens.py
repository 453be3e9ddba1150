"""`stackdsl check` and golden files: written when told to, removed when obsolete, and never in CI."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_line import GOOD, Result, Stackdsl, StackdslIn, write
from tests.paths import ROOT

MOVED = GOOD.replace("{levels: 3}", "{levels: 3, origin: [5 mm, 0 mm, 0 mm]}")


@pytest.fixture(scope="module")
def written(stackdsl_in: StackdslIn, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with two scenarios, their golden files, and a draft beside."""
    folder = tmp_path_factory.mktemp("project")
    for name in ("scenarios/good", "scenarios/part/deep", "wip/draft"):
        write(folder, GOOD.replace("good", Path(name).name), f"{name}.yaml")
    assert stackdsl_in(folder, "check", "--update").code == 0
    assert len(list((folder / "golden").iterdir())) == 2
    return folder


@pytest.fixture
def project(written: Path, tmp_path: Path) -> Path:
    """A copy of that project, where `stackdsl` is called."""
    return shutil.copytree(written, tmp_path, dirs_exist_ok=True)


def test_missing_then_written_then_same_then_different(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD)
    assert stackdsl("check", str(path), CI="true").code == 3
    assert not (tmp_path / "golden").exists()
    assert stackdsl("check", str(path), "--update").code == 0
    locked = (tmp_path / "golden" / "good" / "exact.json").read_bytes()
    assert stackdsl("check", str(path)).code == 0
    write(tmp_path, MOVED)
    moved = stackdsl("check", str(path))
    assert moved.code == 3
    row = next(line for line in moved.out.splitlines() if line.startswith("  x when placed "))
    assert "0" in row
    assert "5" in row
    assert "0.01 mm" in row
    assert (tmp_path / "golden" / "good" / "exact.json").read_bytes() == locked


HEAP = """scenario: heap
build:
  - column: {levels: 3, step: STEP}
expect:
  - collapses: any
"""


def test_what_a_golden_file_does_not_compare_is_told_when_it_is_locked_and_when_it_differs(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    write(tmp_path, HEAP.replace("STEP", "66 mm"), "scenarios/heap.yaml")
    left = "2 states, 2 places, the height and the number of standing levels are unclear and not compared"
    told = f"{left}: states and places of L2.1, L3.1"
    locked = stackdsl("check", CI="").out
    assert f"golden/heap/exact.json: {told}\n" in locked
    assert locked.count("unclear") == 1  # all of the other case is compared
    write(tmp_path, HEAP.replace("STEP", "66.3 mm"), "scenarios/heap.yaml")
    checked = stackdsl("check", CI="").out
    assert f"  unclear        {told}\n" in checked
    assert "  fallen         now 1 brick; the golden has 0 fallen, and up to 2 more\n" in checked
    junit = stackdsl("check", "--format", "junit", CI="").out
    assert told in junit
    assert "fallen now 1 brick; the golden has 0 fallen, and up to 2 more" in junit
    assert f"  unclear        {told}\n" in stackdsl("golden", "review", CI="").out
    assert stackdsl("golden", "accept", CI="").out == f"accepted: golden/heap/exact.json; {told}\n"
    assert "unclear" not in stackdsl("check", CI="").out
    for name in ("mound", "pile"):
        write(tmp_path, HEAP.replace("heap", name).replace("STEP", "66 mm"), f"scenarios/{name}.yaml")
    files = "golden/mound/exact.json, golden/pile/exact.json"
    several = f"4 states and 4 places in 2 files are unclear and not compared: {files}\n"
    assert several in stackdsl("check", CI="").out


def test_a_golden_of_no_variant_is_obsolete_when_all_were_checked(stackdsl: Stackdsl, project: Path) -> None:
    write(project, '{"format": 1}', "golden/gone/exact.json")
    result = stackdsl("check")
    assert result.code == 3
    assert "gone/exact.json" in result.out
    assert "obsolete" in result.out
    assert stackdsl("check", "scenarios/good.yaml").code == 0
    assert stackdsl("check", "--update").code == 0
    assert stackdsl("check").code == 0


@pytest.mark.parametrize("checked", ["empty", "wip", "scenarios/part", "golden"])
def test_a_directory_of_other_scenarios_removes_no_golden(stackdsl: Stackdsl, project: Path, checked: str) -> None:
    (project / "empty").mkdir()
    before = {entry.name for entry in (project / "golden").iterdir()}
    assert "obsolete" not in stackdsl("check", checked).out
    stackdsl("check", checked, "--update")
    assert before <= {entry.name for entry in (project / "golden").iterdir()}


def test_the_whole_set_is_known_by_where_it_is_and_holds_a_case(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    gone = write(tmp_path, '{"format": 1}', "golden/gone/exact.json")
    for path in ("scenarios", ".", "scenarios/../scenarios"):
        assert "gone/exact.json" in stackdsl("check", path).out
    (tmp_path / "scenarios" / "good.yaml").unlink()
    assert stackdsl("check", "--update").code == 4
    assert gone.exists()


def test_links_are_followed_and_remove_no_golden(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "", "stackdsl.toml")
    write(tmp_path, GOOD, "elsewhere/good.yaml")
    write(tmp_path, GOOD.replace("good", "other"), "project/other.yaml")
    (tmp_path / "project" / "scenarios").symlink_to("../elsewhere")
    golden = ("--golden", "project/golden", "--update")
    assert stackdsl("check", "project/scenarios", *golden).code == 0
    assert stackdsl("check", "project", *golden).code == 0
    assert (tmp_path / "project" / "golden" / "good" / "exact.json").exists()


def test_linked_directories_and_capital_suffixes_belong_to_the_whole_set(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    write(tmp_path, "", "stackdsl.toml")
    write(tmp_path, GOOD.replace("good", "linked"), "elsewhere/linked.yaml")
    write(tmp_path, GOOD.replace("good", "capital"), "scenarios/capital.YAML")
    (tmp_path / "scenarios" / "sub").symlink_to("../elsewhere")
    assert stackdsl("check", "scenarios/sub", "scenarios/capital.YAML", "scenarios/good.yaml", "--update").code == 0
    golden = tmp_path / "golden"
    written = sorted(golden.rglob("*.json"))
    assert written == [golden / name / "exact.json" for name in ("capital", "good", "linked")]
    result = stackdsl("check", "--update")
    assert (result.code, "removed" in result.out) == (0, False)
    assert sorted(golden.rglob("*.json")) == written


def test_goldens_that_the_disk_keeps_stay_obsolete_in_a_whole_report(stackdsl: Stackdsl, project: Path) -> None:
    write(project, '{"format": 1}', "golden/gone/exact.json")
    refused = "def refuse(*_, **__): raise PermissionError(13, 'Permission denied')"
    code = f"import os\n{refused}\nos.unlink = refuse\nfrom stackdsl.cli.main import main\nmain()"
    done = stackdsl("check", "--update", program=code)
    assert done.code == 3
    assert "2 passed" in done.out
    assert "obsolete" in done.out
    assert "fault" not in done.err


def test_a_golden_directory_in_a_loop_of_links_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    (tmp_path / "loop").symlink_to("loop")
    result = stackdsl("check", "scenarios", "--golden", "loop")
    assert result.code == 3
    assert "symbolic links" in result.out


def test_a_file_that_is_given_twice_is_checked_once(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD)
    (tmp_path / "link.yaml").symlink_to(path)
    listed = stackdsl("check", "scene.yaml", str(path), "./scene.yaml", "link.yaml", "--list")
    assert (listed.code, listed.out.split(), listed.err) == (0, ["good[exact]"], "")
    wrong = stackdsl("check", write(tmp_path, GOOD.replace("1 s", "1")).name, str(path))
    assert [line.split(":")[0] for line in wrong.out.splitlines() if "SD105" in line] == ["scene.yaml"]


def accepting(result: Result) -> list[str]:
    """The arguments of the command that a report names."""
    (line,) = (line for line in result.out.splitlines() if " with: stackdsl " in line)
    return shlex.split(line.partition(" with: stackdsl ")[2])


def test_the_command_told_accepts_what_was_shown_and_nothing_else(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD + "tags: [short]\nsystems: [exact, tuned]\n", "my scenes/a.yaml")
    write(tmp_path, GOOD.replace("good", "other") + "systems: [exact]\n", "my scenes/b.yaml")
    call = ("check", "my scenes", "--golden", "locked here", "--system", "exact", "-k", "goo", "--tag", "!long")
    assert stackdsl(*call).code == 0  # which locks
    write(tmp_path, MOVED + "tags: [short]\nsystems: [exact, tuned]\n", "my scenes/a.yaml")
    assert stackdsl(*call).code == 3
    told = accepting(stackdsl(*call, "--time-limit", "99"))
    assert told == [*call[:2], *call[4:], *call[2:4], "--time-limit", "99.0", "--update"]
    assert stackdsl(*told).code == 0
    assert [*(tmp_path / "locked here").rglob("*.json")] == [tmp_path / "locked here" / "good" / "exact.json"]
    assert {entry.name for entry in tmp_path.iterdir()} == {"my scenes", "locked here", ".stackdsl"}
    assert stackdsl(*call).code == 0


def test_the_command_told_removes_what_is_obsolete(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    write(tmp_path, '{"format": 1}', "golden/gone/exact.json")
    told = accepting(stackdsl("check"))
    assert told == ["check", "--update"]
    assert stackdsl(*told).code == 0
    assert stackdsl("check").code == 0


IN_PYTHON = """
from stackdsl.api.layouts import column
from stackdsl.api.scenario import Scenario

def test_column(golden):
    run = Scenario("in-python", build=[column(levels=2)]).play()
    run.golden("golden", update=True)

def test_other(golden):
    from stackdsl.checking.results import snapshot_of
    run = Scenario("in-a-test", build=[column(levels=2)]).play()
    snapshot = snapshot_of(run.case, run.trace)
    assert snapshot == golden(snapshot.identity)
"""


def test_golden_files_that_somebody_else_keeps_are_not_removed(stackdsl: Stackdsl, project: Path) -> None:
    tests = write(project, IN_PYTHON, "trials/test_column.py")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "CI": "", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    plugins = ("-p", "syrupy", "-p", "stackdsl.pytest_plugin")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, "--snapshot-update", "trials"]
    subprocess.run(command, cwd=project, env=environment, check=True, capture_output=True)
    assert stackdsl("check", "wip/draft.yaml").code == 0  # which locks, beside the directory of scenarios
    theirs = [project / "golden" / name / "exact.json" for name in ("in-python", "in-a-test", "draft")]
    assert [json.loads(file.read_text())["kept_by"] for file in theirs] == [
        "trials/test_column.py",
        "trials/test_column.py",
        "wip/draft.yaml",
    ]
    result = stackdsl("check", "--update")
    assert (result.code, "removed" in result.out) == (0, False)
    assert [file.exists() for file in theirs] == [True, True, True]
    pruned = stackdsl("golden", "prune").out
    assert pruned.startswith(
        "nothing to remove\nkept: golden/in-a-test/exact.json, golden/in-python/exact.json, by trials/"
    )
    tests.rename(tests.with_name("test_renamed.py"))  # only pytest knows that its tests still use them
    assert stackdsl("check", "--update").code == 0
    assert [file.exists() for file in theirs] == [True, True, True]
    assert (
        "by trials/test_column.py, which does not exist; if it was renamed, pytest" in stackdsl("golden", "prune").out
    )
    shutil.rmtree(project / "scenarios")
    told = stackdsl("golden", "prune")
    assert (told.code, "in-a-test" in told.err, "has no scenarios, so the owner of golden/" in told.err) == (
        2,
        False,
        True,
    )
    for file in {*project.glob("golden/*/*.json")} - {*theirs[:2]}:
        file.unlink()
    told = stackdsl("golden", "prune", "--dry-run")
    assert (told.code, told.out.startswith("nothing to remove\nkept: golden/in-a-test/")) == (0, True)


def test_a_failing_case_is_accepted_only_with_accept_failing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    stackdsl("check")
    locked = tmp_path / "golden" / "good" / "exact.json"
    was = locked.read_text()
    write(tmp_path, MOVED + "  - height: 20 mm ± 1 mm\n", "scenarios/good.yaml")
    for options in ([], ["--update"]):
        result = stackdsl("check", *options)
        assert (result.code, locked.read_text()) == (1, was)
        assert "1 of these results fails expectations; only --update --accept-failing would accept it" in result.out
        assert "accept with" not in result.out
    assert stackdsl("check", "--accept-failing").code == 4
    assert stackdsl("check", "--update", "--accept-failing").code == 1
    assert locked.read_text() != was


def test_goldens_are_never_written_in_ci(stackdsl: Stackdsl, tmp_path: Path) -> None:
    result = stackdsl("check", str(write(tmp_path, GOOD)), "--update", CI="true")
    assert result.code == 4
    assert not (tmp_path / "golden").exists()
