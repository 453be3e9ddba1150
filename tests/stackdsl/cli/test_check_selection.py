"""Selecting and stopping, as one does a hundred times a day."""

import json
from pathlib import Path

import pytest

from tests.command_line import AMPLE, GOOD, Stackdsl, StackdslIn, saved, started, write

BAD = GOOD.replace("good", "bad") + "  - height: 20 mm ± 1 mm\n"
THREE = "---\n".join([BAD, GOOD, GOOD.replace("good", "other")])
NAMES = ["bad[exact]", "good[exact]", "other[exact]"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write(tmp_path, THREE)
    return tmp_path


def listed(stackdsl: Stackdsl, *arguments: str) -> list[str]:
    return stackdsl("check", "scene.yaml", "--list", *arguments).out.split()


@pytest.mark.usefixtures("folder")
def test_keywords_are_an_expression_and_several_are_all_asked_for(stackdsl: Stackdsl) -> None:
    assert listed(stackdsl, "-k", "good or other") == NAMES[1:]
    assert listed(stackdsl, "-k", "o", "-k", "not good") == ["other[exact]"]
    wrong = stackdsl("check", "scene.yaml", "-k", "good other")
    assert (wrong.code, "column 6" in wrong.err) == (4, True)


@pytest.mark.usefixtures("folder")
def test_a_line_of_a_file_means_the_scenario_there(stackdsl: Stackdsl) -> None:
    def at(place: str) -> list[str]:
        return stackdsl("check", f"scene.yaml:{place}", "--list").out.split()

    last = str(len(THREE.splitlines()))
    assert [at("1"), at("7:5"), at("9"), at(last)] == [[NAMES[0]], [NAMES[0]], [NAMES[1]], [NAMES[2]]]
    assert at("400") == []


@pytest.mark.usefixtures("folder")
def test_the_first_failure_is_the_last_that_is_played(stackdsl: Stackdsl) -> None:
    result = stackdsl("check", "scene.yaml", "-x", "--jobs", "1")
    assert result.code == 1
    assert "1 failed, 2 not run after a failure" in result.out
    assert json.loads(stackdsl("check", "scene.yaml", "-x", "--jobs", "1", "--format", "json").out)["not_played"] == 2


@pytest.mark.usefixtures("folder")
def test_failed_plays_the_last_failures_until_they_pass(stackdsl: Stackdsl, folder: Path) -> None:
    assert "no recorded failures" in stackdsl("check", "scene.yaml", "--failed", "--list").err
    stackdsl("check", "scene.yaml")
    assert listed(stackdsl, "--failed") == NAMES[:1]
    stackdsl("check", "scene.yaml", "-k", "good")  # of which nothing is said of the others
    assert listed(stackdsl, "--failed") == NAMES[:1]
    write(folder, THREE.replace("20 mm", "23 mm"))
    assert stackdsl("check", "scene.yaml", "--failed").code == 0
    assert listed(stackdsl, "--failed") == NAMES


@pytest.mark.usefixtures("folder")
def test_changed_plays_the_cases_without_a_remembered_pass(stackdsl: Stackdsl, folder: Path) -> None:
    for _ in range(2):
        stackdsl("check", "scene.yaml")
    assert listed(stackdsl, "--changed") == NAMES[:1]
    write(folder, GOOD)
    for _ in range(2):
        stackdsl("check", "scene.yaml")
    nothing = stackdsl("check", "scene.yaml", "--changed")
    assert (nothing.code, nothing.out, "no selected case has changed" in nothing.err) == (0, "", True)


def test_parts_are_disjoint_whole_and_the_same_in_any_order(stackdsl: Stackdsl, tmp_path: Path) -> None:
    matrix = "matrix: {step: [" + ", ".join(f"{number} mm" for number in range(1, 13)) + "]}\n"
    text = GOOD.replace("levels: 3", 'levels: 3, step: "${step}"')
    write(tmp_path, text + matrix)
    parts = [listed(stackdsl, "--shard", f"{number}/3") for number in (1, 2, 3)]
    assert sorted(name for part in parts for name in part) == sorted(listed(stackdsl))
    assert all(parts)
    write(tmp_path, text + matrix.replace("1 mm, 2 mm", "2 mm, 1 mm"))
    assert [set(listed(stackdsl, "--shard", f"{number}/3")) for number in (1, 2, 3)] == list(map(set, parts))
    write(tmp_path, GOOD)
    codes = [stackdsl("check", "scene.yaml", "--shard", f"{number}/2").code for number in (1, 2)]
    assert codes == [0, 0]  # one of them has nothing to do
    assert stackdsl("check", "scene.yaml", "--shard", "3/2").code == 4


def test_a_scenario_may_come_by_a_pipe(stackdsl_in: StackdslIn, tmp_path: Path) -> None:
    done = stackdsl_in(tmp_path, "check", "-", keys=BAD)
    assert (done.code, "<stdin>:7:5" in done.out) == (1, True)
    assert not (tmp_path / "golden").exists()


@pytest.mark.usefixtures("folder")
def test_statics_alone_play_nothing(stackdsl: Stackdsl, folder: Path) -> None:
    write(folder, GOOD + "---\n" + GOOD.replace("good", "far").replace("levels: 3", "levels: 12, step: 12 mm"))
    result = stackdsl("check", "scene.yaml", "--statics")
    assert result.code == 0
    assert "2 variants: 1 stands, 1 falls; no simulation" in result.out
    said = json.loads(stackdsl("check", "scene.yaml", "--statics", "--format", "json").out)["variants"]
    # N planks stand while N d is at most a plank, 117.6 mm: nine of them do, and the tenth comes at 9 s.
    assert [(each["statics"], each["proven"], each["time_s"]) for each in said] == [
        ("stands", 3, None),
        ("falls", 9, 9.0),
    ]


@pytest.mark.usefixtures("folder")
def test_a_list_may_be_json(stackdsl: Stackdsl) -> None:
    cases = json.loads(stackdsl("check", "scene.yaml", "--list", "--format", "json").out)["cases"]
    assert [case["name"] for case in cases] == NAMES
    assert [case["line"] for case in cases] == [1, 8, 15]  # with what divides them from those before


@pytest.mark.usefixtures("folder")
def test_quiet_tells_failures_alone_and_verbose_what_passed(stackdsl: Stackdsl) -> None:
    quiet, verbose = (stackdsl("check", "scene.yaml", option).out for option in ("-q", "-v"))
    assert quiet.startswith("✗ FAILED  bad[exact]")
    assert "Passed expectations" in verbose
    assert ": good[exact]: stands: expected all" in verbose
    slowest = stackdsl("check", "scene.yaml", "-q", "--durations", "2").out.split("Slowest\n")[1]
    assert slowest.count(" s  ") == 2


@pytest.mark.usefixtures("folder")
def test_golden_files_may_be_left_alone(stackdsl: Stackdsl, folder: Path) -> None:
    assert stackdsl("check", "scene.yaml", "-k", "good", "--no-golden", CI="true").code == 0
    assert not (folder / "golden").exists()
    assert stackdsl("check", "scene.yaml", "--no-golden", "--update").code == 4


def test_a_first_run_is_green_at_home_and_red_in_ci(stackdsl: Stackdsl, folder: Path) -> None:
    text = "---\n".join(GOOD.replace("good", name) for name in ("one", "two", "three"))
    write(folder, text)
    ci = stackdsl("check", "scene.yaml", CI="true")
    assert ci.code == 3
    assert sum("missing: golden/" in line for line in ci.out.splitlines()) == 1
    assert "3 missing: " in ci.out
    home = stackdsl("check", "scene.yaml")
    assert (home.code, "3 new: " in home.out) == (0, True)
    assert stackdsl("check", "scene.yaml", CI="true").code == 0


def test_a_failing_case_writes_no_golden_file(stackdsl: Stackdsl, folder: Path) -> None:
    write(folder, BAD)
    assert stackdsl("check", "scene.yaml").code == 1
    assert not list((folder / "golden").rglob("*.json"))


def test_a_watch_checks_again_when_a_scenario_is_saved(folder: Path) -> None:
    write(folder, GOOD)
    process = started(folder, "check", "scene.yaml", "--watch", "-q")
    assert process.stdout is not None
    try:
        assert "1 passed" in next(line for line in process.stdout if " case" in line)
        saved(folder / "scene.yaml", BAD)
        assert "1 failed" in next(line for line in process.stdout if " case" in line)
    finally:
        process.terminate()
        process.communicate(timeout=AMPLE)


@pytest.mark.slow
def test_a_watch_of_a_file_notices_what_the_file_is_made_of(folder: Path) -> None:
    (folder / "stackdsl.toml").write_text("", encoding="utf-8")
    base = folder / "base.yaml"
    base.write_text(GOOD, encoding="utf-8")
    write(folder, "extends: base.yaml\nscenario: derived\n")
    process = started(folder, "check", "scene.yaml", "--watch", "-q")
    assert process.stdout is not None
    try:
        assert "1 passed" in next(line for line in process.stdout if " case" in line)
        saved(base, BAD)
        assert "1 failed" in next(line for line in process.stdout if " case" in line)
    finally:
        process.terminate()
        process.communicate(timeout=AMPLE)
