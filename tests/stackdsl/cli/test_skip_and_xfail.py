"""`skip` and `xfail`: cases that are not played, known failures, and unexpected passes."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.command_line import Stackdsl, write

STANDS = "scenario: column\nbuild: [{column: {levels: 3}}]\nexpect: [{stands: all}]\n"
FALLS = STANDS.replace("stands: all", "collapses: any")


Checked = Callable[[str], tuple[dict[str, Any], int]]


@pytest.fixture
def checked(stackdsl: Stackdsl, tmp_path: Path) -> Checked:
    """What a check of one scenario prints as JSON, once its golden files are written; and how it ends."""

    def check(text: str) -> tuple[dict[str, Any], int]:
        write(tmp_path, text, "s/a.yaml")
        stackdsl("check", "s", "--update")
        result = stackdsl("check", "s", "--format", "json")
        return json.loads(result.out), result.code

    return check


@pytest.mark.parametrize(
    ("text", "mark", "conclusion", "code"),
    [
        (STANDS, "skip: too slow", "skipped", 0),
        (FALLS, "skip: too slow", "skipped", 0),
        (FALLS, "", "failed", 1),
        (FALLS, "xfail: nobody knows why", "xfailed", 0),
        (FALLS, "xfail: {reason: nobody knows why, system: exact}", "xfailed", 0),
        (STANDS, "xfail: nobody knows why", "xpassed", 1),
        (STANDS, "xfail: {reason: nobody knows why, strict: false}", "xpassed", 0),
        (STANDS, "", "passed", 0),
    ],
)
def test_a_mark_says_what_becomes_of_a_failure(
    checked: Checked, text: str, mark: str, conclusion: str, code: int
) -> None:
    report, ended = checked(text + mark)
    assert (report["conclusions"], ended) == ({"passed": 0} | {conclusion: 1}, code)
    (result,) = report["results"]
    assert result["set_aside"] is (conclusion == "skipped")
    if mark.startswith("xfail"):
        assert result["xfail"] == {"reason": "nobody knows why", "strict": "false" not in mark}


def test_the_reason_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    other = STANDS.replace("scenario: column", "scenario: other")
    write(tmp_path, f"{FALLS}xfail: the statics are wrong\n---\n{other}skip: later\n", "a.yaml")
    stackdsl("check", "a.yaml", "--update")
    result = stackdsl("check", "a.yaml")
    assert result.code == 0
    assert "later: other[exact]" in result.out
    assert "1 expected to fail" in result.out
    verbose = stackdsl("check", "a.yaml", "-v").out
    assert "column[exact]: the statics are wrong: collapses: expected any, measured nothing fell" in verbose
    assert "1 skipped, 1 xfailed" in result.out
    assert "expected failure (xfail): the statics are wrong" in stackdsl("run", "a.yaml").out


def test_a_known_failure_writes_its_golden_at_the_first_run(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{FALLS}xfail: why", "a.yaml")
    assert stackdsl("check", "a.yaml").code == 0
    again = stackdsl("check", "a.yaml")
    assert (again.code, "1 xfailed" in again.out) == (0, True)


def test_a_golden_file_that_differs_is_a_failure_also_of_what_is_known_to_fail(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, f"{FALLS}xfail: why", "a.yaml")
    stackdsl("check", "a.yaml")
    write(tmp_path, f"{FALLS.replace('levels: 3', 'levels: 4')}xfail: why", "a.yaml")
    result = stackdsl("check", "a.yaml")
    assert result.code == 3
    assert "golden different" in result.out


def test_a_known_failure_with_passing_variants_is_a_failure(stackdsl: Stackdsl, tmp_path: Path) -> None:
    column = '  - column: {levels: "${count}", step: 12 mm}\n'  # nine of these stand, and the tenth is one too many
    text = f"scenario: both\nmatrix: {{count: [9, 10]}}\nbuild:\n{column}expect: [{{stands: all}}]\nxfail: too long\n"
    write(tmp_path, text, "both.yaml")
    told = stackdsl("check", "both.yaml", "--no-golden").out
    assert "other variants fail: split the scenario in two, or add `strict: false`" in told
    assert "remove `xfail`" not in told
