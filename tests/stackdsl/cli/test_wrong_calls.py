"""Wrong calls of the command: each error names the cause, and a call that works."""

from pathlib import Path

import pytest

from tests.command_line import GOOD, Stackdsl, write

# The words of a call in a folder with scene.yaml and other.yaml, and what its error has.
WRONG_CALLS = [
    ("chek", "unknown command 'chek'; did you mean 'check'?"),
    ("simulate scene.yaml", "did you mean 'run'?"),
    ("scene.yaml", "write `stackdsl run scene.yaml` to play this file, or `stackdsl check scene.yaml`"),
    ("--system exact check scene.yaml", "write `stackdsl check --system exact scene.yaml`"),
    ("find scene.yaml --max levels", "--most NAME           Find the largest value of this whole number."),
    ("check scene.yaml --engine exact", "did you mean '--system'?"),
    ("check scene.yaml --no-golden --system pybullet", "write tuned for PyBullet with settings for stacks, or stock"),
    ("check scene.yaml --no-golden --system bullet", "the scenario must list it, too, as in `systems: [tuned]`"),
    ("check scene.yaml --no-golden -k towre", "`stackdsl check scene.yaml --list` lists all cases"),
    ("check --nogolden", "No such option '--nogolden'; did you mean '--no-golden'?"),
    ("picture scene.yaml --out a.png", "did you mean '--output'?"),
    ("run scene.yaml --html", "example: stackdsl run tower.yaml --html tower.html"),
    ("sweep scene.yaml", "example: stackdsl sweep shaky.yaml --out rows.jsonl"),
    ("new", "example: stackdsl new tower"),
    ("check --time-limit 5m", "Time limit of a case [s]."),
    ("run scene.yaml slow", "run takes only FILE; write -k slow to select cases by name"),
    ("run scene.yaml other.yaml", "call `stackdsl run` once for each file"),
    ("new scenarios/foo.yaml", "write `stackdsl new foo`"),
    ("new drafts/My_Tower", "write `stackdsl new my-tower --to drafts`"),
    ("check", "there is no directory 'scenarios', which is checked by default"),
    ("check *.yml", "no file matches this pattern; name a file, or a directory"),
    ("run scen.yaml", "did you mean 'scene.yaml'?"),
    ("explain other", "did you mean 'other.yaml'?"),
    ("check --html page.html scene.yaml", "write --html page"),
    ("run scene.yaml --html .", "write run.html"),
    ("check scene.yaml --no-golden --tag slow", "none has a tag; add `tags: [slow]` to a scenario"),
    ("suggest scene.yaml --system tuned", "no scenario has tuned among its `systems` (exact); add `systems: [tuned]`"),
]


@pytest.mark.parametrize(("call", "told"), WRONG_CALLS, ids=[call for call, _ in WRONG_CALLS])
def test_a_wrong_call_is_answered_by_one_that_works(stackdsl: Stackdsl, tmp_path: Path, call: str, told: str) -> None:
    write(tmp_path, GOOD)
    write(tmp_path, GOOD.replace("good", "other"), "other.yaml")
    result = stackdsl(*call.split())
    assert result.code in {2, 4}
    assert told in result.text
    assert "internal error" not in result.text


def test_help_of_a_command_is_also_a_command(stackdsl: Stackdsl) -> None:
    assert stackdsl("help", "check").out == stackdsl("check", "--help").out
    assert stackdsl("help").out == stackdsl("--help").out


def test_the_folder_of_a_page_is_created(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    assert stackdsl("run", "scene.yaml", "--html", "no/such/page.html").code == 0
    assert (tmp_path / "no" / "such" / "page.html").exists()


def test_a_file_that_cannot_be_written_is_refused_before_the_run(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    (tmp_path / "taken.html").mkdir()
    result = stackdsl("run", "scene.yaml", "--html", "taken.html")
    assert (result.code, result.out) == (4, "")
    assert "taken.html cannot be written: Is a directory; choose another name" in result.err


def test_a_missing_golden_file_in_ci_is_to_be_written_elsewhere(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    result = stackdsl("check", "scene.yaml", CI="true")
    assert "accept with: stackdsl check scene.yaml --update outside of CI, and commit the golden files" in result.out
