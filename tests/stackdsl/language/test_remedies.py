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
        (COLUMN + "systems: []\n", "0 items", "write at least 1 item: systems that"),
        (COLUMN + "expect: {stands: all}\n", "not a mapping", "write `expect: [{stands: all}]`"),
        (COLUMN + "description: 5\n", "expected text", "quote it: purpose"),
        (COLUMN + "brick: {size: [1 mm, 2 mm], density: 5 kg/m3}\n", "too few", "write all items: length, width"),
        (COLUMN + MATRIX, "maximum of 256", "several scenarios"),
        (COLUMN.replace("column: {levels: 3}", "bricks: [{name: ground, at: [0 m, 0 m, 3.9 mm]}]"),
         "cannot be the name of a brick, since it is the name of the ground", "another name"),
        (COLUMN.replace("column: {levels: 3}", "bricks: [{name: wall1, at: [0 m, 0 m, 3.9 mm]}]"),
         "cannot be the name of a brick, since it is the name of a wall", "another name"),
        (COLUMN + "expect: [{collapses: {at: level 9 ± 1}}]\n", "needs 8 levels, but the structure has 3", "at most 3"),
        (COLUMN.replace("3}", "3, origin: 5 mm}"), "expected a list, not '5 mm'", "write a list of"),
        (COLUMN.replace("3", "$n"), "not '$n'", 'write "${n}" if it is an expression'),
        (COLUMN.replace("3", "'{n}'"), "not '{n}'", 'write "${n}" if it is an expression'),
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
        (COLUMN.replace("3}", "3, step: 12,5 mm}"), "begins another entry", "replace the decimal comma by a point"),
        (COLUMN.replace(" {levels: 3}", "\n    levels: 3"), "a value is missing", "indent the lines below"),
        (COLUMN + "   every: 1 s\n", "`every` is indented by 3 spaces", "indent it by 4 spaces, like `column`"),
        (COLUMN + "      every: 1 s\n", "`every` is indented by 6 spaces", "indent it by 4 spaces, like `column`"),
        (COLUMN.replace("3", "n") + "let: {n: 3}\n", "expected a whole number, not 'n'", 'write "${n}" for the value'),
        (COLUMN.replace("3", "$n") + "let: {n: 3}\n", "a whole number, not '$n'", 'write "${n}" for the value'),
        (COLUMN.replace("3", "{{ n }}") + "let: {n: 3}\n", "{{ n }} is not an expression", 'write "${n}"'),
        (COLUMN + "friction: yes\n", "expected a number, not 'yes'", "write 0 to 10: Coulomb friction"),
        (COLUMN + "description: yes\n", "'yes' is read as true by some YAML parsers", 'quote it: "yes"'),
        (COLUMN.replace("3}", "3, step: \N{MINUS SIGN}2 mm}"), "expected a length", "write -2 mm; U+2212 MINUS SIGN"),
        (COLUMN.replace("column", "stack"), "unknown key 'stack'", "write `column`"),
        (COLUMN + "mu: 0.5\n", "unknown key 'mu'", "write `friction`"),
        (COLUMN + "assert: [{stands: all}]\n", "unknown key 'assert'", "write `expect`"),
        (COLUMN + "system: exact\n", "unknown key 'system'", "write `systems: [exact]`"),
        (COLUMN.replace("3}", "3, every: 1 s}"), "unknown key 'every'", "belongs beside `column`, not in it"),
        (COLUMN + "stands: all\n", "unknown key 'stands'", "this key belongs in an item of `expect`"),
        (COLUMN.replace("scenario", "name"), "unknown key 'name'", "write `scenario`"),
        (COLUMN + "matrix: {n: 1...3}\n", "expected a list of values or a range, not '1...3'", "write 1 .. 3"),
        (COLUMN.replace("3", '"${n}"') + "matrix: [{n: [1, 2]}]\n", "expected a mapping of variables", "without '- '"),
        (COLUMN.replace("3", '"${n}"') + "matrixx: {n: [1, 2]}\n", "unknown key 'matrixx'", "did you mean 'matrix'?"),
        (COLUMN.replace("3", '"${n}"') + "let: [{n: 2}]\n", "expected a mapping of variables", "{length: 120 mm}"),
        (
            COLUMN + "impacts: [{remove: {brick: L3.1}, at: built + 1 s}]\n",
            "is a value of `after`, not of `at`", "`after: built + 1 s`"),
        (COLUMN + "impacts: [{remove: {brick: L3.1}, after: level 9}]\n", "waits for level 9", "level 1 to level 3"),
        (COLUMN + "impacts: [{drop: {onto: ground, height: 9 mm}}]\n", "no brick 'ground'", "from: L1.1, L2.1, L3.1"),
        (
            COLUMN + "impacts: [{throw: {brick: L2.1, from: {bearing: 0 deg}, speed: 1 m/s}}]\n",
            "'L2.1' is a value of `at`, not of `brick`",
            "write `at: L2.1`",
        ),
        (COLUMN + "expect: [{margin: 3 mm}]\n", "not '3 mm'", 'write {placement: ">= 3 mm"}; the keys'),
        (COLUMN + "expect: [{stands: none}]\n", "not 'none'", "write `collapses: any`"),
        (COLUMN + "expect: [{collapses: never}]\n", "not 'never'", "write `stands: all`"),
        (COLUMN + "expect: [{height: 20 mm - 25 mm}]\n", "cannot be read", "write 20 mm .. 25 mm"),
        (COLUMN + "expect: [{height: 20 ± 1}]\n", "'20' has no unit", "write 20 ± 1 mm"),
        (COLUMN + "expect: [{height: 20 mm ± 5 %}]\n", "has a width in percent", "write 20 mm ± 1 mm"),
        (COLUMN.replace("3}", "3, origin: 0 0 5 mm}"), "not '0 0 5 mm'", "write [0 mm, 0 mm, 5 mm]"),
        (COLUMN.replace("3}", "3, origin: [0 m, 0 m, 0 m, 0 m]}"), "4 items; the maximum is 3", "write 3 items:"),
        (COLUMN.replace("3", "n + 1") + "let: {n: 3}\n", "not 'n + 1'", 'write "${n + 1}" for the value'),
        (COLUMN.replace("column: {", "column: ").replace("}", ""), "a second key", "write `column: {levels: 3}`"),
        (COLUMN.replace("{levels: 3}", "(levels=3)"), "not '(levels=3)'", "write {levels: 3}"),
        (COLUMN.replace("column: ", "column:"), "a space is missing after 'column:'", "write `column: {levels: 3}`"),
        (COLUMN + "    - every: 1 s\n", "an item begins inside the item of line 3", "remove the '- ' if `every`"),
        (COLUMN + "g: 9.81 m/s2\n", "unknown key 'g'", "write `gravity`; this key belongs in `world`"),
        (COLUMN + "world: {friction: 0.5}\n", "expected a mapping, not 0.5", "write `friction: 0.5` beside `world`"),
        (COLUMN + "systems: all\n", "expected a list, not 'all'", "choose from: exact"),
        (COLUMN + "brick: wood\n", "there is no brick 'wood'", "or define it under `brick_types`"),
        (COLUMN + "matrix: {n: 1,2,3}\n", "the ',' before this text begins another entry", "put a list in brackets"),
        (COLUMN + COLUMN, "a second scenario begins here", "write a line with only --- above it"),
        ("name,x,y,z,length\na,0,0,0,400\n", "this document is a table", "`stackdsl import scene.yaml`"),
        (COLUMN + "brick_types: {slab: {size: [9 mm, 9 mm, 9 mm], mass: 1 g}}\n", "'slab' is unused", "`brick: slab`"),
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
