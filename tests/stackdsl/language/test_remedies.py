"""Every mistake has a remedy."""

from pathlib import Path as FilePath

import pytest

from stackdsl.checking.cases import gather
from stackdsl.checking.results import Goldens, checked, judged
from stackdsl.diagnostics import Diagnostic
from stackdsl.report.outline import stop_text
from stackdsl.report.text import run_text
from stackdsl.results import RunStatus
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.supervising.worker import TaskResult, TaskStatus
from tests.scenes import compiled

COLUMN = "scenario: column\nbuild:\n  - column: {levels: 3}\n"
MATRIX = f"matrix: {{{', '.join(f'a{i}: [1, 2]' for i in range(9))}}}\n"


def only(text: str) -> Diagnostic:
    (mistake,) = compiled(text)[1]
    return mistake


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        (COLUMN.replace("3", "0"), "0 is below the minimum of 1", "write 1 to 10000: number of planks"),
        (COLUMN.replace("3", "3 mm"), "not '3 mm'", "write 1 to 10000: number of planks"),
        (COLUMN + "friction: -1\n", "-1 is below the minimum of 0", "write 0 to 10: Coulomb friction coefficient"),
        (COLUMN + "friction: 50 percent\n", "not '50 percent'", "write 0 to 10: Coulomb friction coefficient"),
        (COLUMN + "systems: exact\n", "expected a list", "write [exact]: systems that"),
        (COLUMN + "systems: []\n", "0 items", "write at least 1 items: systems that"),
        (COLUMN + "expect: {stands: all}\n", "not a mapping", "begin each item with `- `: expected"),
        (COLUMN + "description: 5\n", "expected text", "quote it: purpose"),
        (COLUMN + "brick: {size: [1 mm, 2 mm], density: 5 kg/m3}\n", "too few", "write all items: length, width"),
        (COLUMN + MATRIX, "maximum of 256", "several scenarios"),
        (COLUMN.replace("column: {levels: 3}", "bricks: [{name: ground, at: [0 m, 0 m, 3.9 mm]}]"),
         "cannot be the name of a brick, since it is the name of the ground", "another name"),
        (COLUMN.replace("column: {levels: 3}", "bricks: [{name: wall1, at: [0 m, 0 m, 3.9 mm]}]"),
         "cannot be the name of a brick, since it is the name of a wall", "another name"),
        (COLUMN + "expect: [{collapses: {at: level 9 ± 1}}]\n", "needs 8 levels, but the structure has 3", "at most 3"),
        (COLUMN.replace("3}", "3, origin: 5 mm}"), "expected a list, not '5 mm'", "write a list of"),
        (COLUMN.replace("3", "$n"), "not '$n'", "write ${n} if it is an expression"),
        (COLUMN.replace("3", "'{n}'"), "not '{n}'", "write ${n} if it is an expression"),
        (COLUMN.replace("3}", "3, step: 1 m}"), "brick 'L2.1' has no support", "change the dimensions"),
        (COLUMN + "  - column: {levels: 3}\n", "'L1.2' is 7.8 mm inside", "write `origin: [120 mm,"),
        ("a: &a {b: 1}\n<<: *a\n", "merge keys are not supported", "repeat the keys here"),
        (COLUMN + "expect: stands\n", "expected a list, not 'stands'", "write `- stands: all`: expected"),
        (COLUMN + "expect: [stands]\n", "expected a mapping, not 'stands'", "write `stands: all`"),
        (COLUMN + "expect: [height]\n", "expected a mapping, not 'height'", "write `height: ` and its value"),
        (COLUMN + "expect: [{falls: all}]\n", "expected a mapping, not 'all'", "count (number of bricks"),
        (COLUMN + "expect: [{falls: 6}]\n", "expected a mapping, not 6", "write {count: 6}: number of bricks"),
        (
            COLUMN + "expect: [{stands: all, when: name = slow}]\n",
            "unknown key 'when'",
            "a claim applies to every case; give each case its own limit, as in `cases: [{name: slow, most: 0}, "
            "{name: fast, most: 9}]` with `falls: {count: '<= ${most}'}`, or write a second scenario with `extends`; "
            "docs/language.md, Variables",
        ),
        (COLUMN.replace("levels", "levls"), "unknown key 'levls'", "did you mean 'levels'?"),
        (COLUMN.replace("scenario", "scenaro"), "unknown key 'scenaro'", "did you mean 'scenario'?"),
        (COLUMN + "let: {stpe: 1 mm}\nfriction: \"${step}\"\n", "unknown variable 'step'", "did you mean 'stpe'?"),
        (COLUMN + "expect: [{drift: 0.1 mm}]\n", "is a single value", 'or write a limit: "<= 0.1 mm" or ">= 0.1 mm"'),
        (COLUMN + "gravity: 9.81 m/s2\n", "unknown key 'gravity'", "this key belongs in `world`"),
        (
            COLUMN + "expect:\n  - displaced: {brick: L2.1, bricks: 1, by: '>= 1 mm'}\n",
            "unknown key 'brick'",
            "`displaced` counts bricks; for the shift of one brick write `drift: {is: <= 1 mm, bricks: [L2.1]}`",
        ),
        (COLUMN.replace("3}", "3, step: 12,5 mm}"), "a value is missing", "replace the decimal comma by a point"),
        (COLUMN.replace(" {levels: 3}", "\n    levels: 3"), "a value is missing", "indent the lines below"),
        (COLUMN + "   every: 1 s\n", "belongs to no item of the list", "indent `every` by 4 spaces"),
    ],
)  # fmt: skip
def test_every_mistake_has_a_remedy(text: str, message: str, hint: str) -> None:
    mistake = only(text)
    assert message in mistake.message
    assert hint in mistake.hint


def test_collapse_at_a_level_that_may_be_built_is_accepted() -> None:
    assert compiled(COLUMN + "expect: [{collapses: {at: level 4 ± 1}}]\n")[1] == []


@pytest.mark.parametrize(
    ("name", "hint"), [("missing.yaml", "check the path"), ("folder.yaml", "permissions of the file")]
)
def test_unreadable_file_has_a_remedy(tmp_path: FilePath, name: str, hint: str) -> None:
    (tmp_path / "folder.yaml").mkdir()
    (mistake,) = gather([tmp_path / name]).diagnostics
    assert mistake.code == "SD001"
    assert hint in mistake.hint


@pytest.mark.parametrize(
    ("status", "ended", "remedy"),
    [
        (TaskStatus.TIMED_OUT, RunStatus.TIMED_OUT, "raise --time-limit"),
        (
            TaskStatus.CRASHED,
            RunStatus.CRASHED,
            "for the traceback: STACKDSL_DEBUG=1",
        ),
    ],
)
def test_crash_and_timeout_have_a_remedy(status: TaskStatus, ended: RunStatus, remedy: str) -> None:
    case = compiled(COLUMN)[0][0]
    result = checked(case, TaskResult(status, message="why"), Goldens(FilePath("golden")))
    assert result.status is ended
    assert stop_text(result).startswith(f"why; {remedy}")


def test_run_that_ends_with_a_flying_brick_is_unsettled() -> None:
    #   A fall of 100 m takes 4.5 s, and two are watched.
    high = "build:\n  - bricks: [{at: [0 m, 0 m, 100 m], drop: true}]\n"
    case = compiled(f"scenario: high\n{high}")[0][0]
    trace = play(case.timeline, SYSTEMS["exact"])
    assert run_text(trace, judged(case, trace)).startswith("unsettled; ")


def test_unwritable_golden_file_has_a_remedy(tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)  # where none is written at all
    (tmp_path / "golden").write_text("a file, and no directory", encoding="utf-8")
    case = compiled(COLUMN)[0][0]
    played = TaskResult(TaskStatus.DONE, play(case.timeline, SYSTEMS["exact"]))
    golden = checked(case, played, Goldens(tmp_path / "golden", update=True)).golden
    assert golden is not None
    assert "cannot be written" in golden.note
    assert "--golden" in golden.note
