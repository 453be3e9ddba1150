"""Golden files in pytest: the same files, comparison and bytes as in `stackdsl check`."""

import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from syrupy.location import PyTestLocation

from stackdsl.goldens.file_format import canonical_text, golden_name
from stackdsl.goldens.golden import PendingStore
from stackdsl.pytest_plugin.shared_snapshots import GoldenExtension
from tests.stackdsl.goldens.towers import IDENTITY, taken, tower

TEXT = canonical_text(taken(tower()))
MOVED = TEXT.replace(
    '"L2.1": {"level": 2, "state": "frozen", "at_mm": [0.0,', '"L2.1": {"level": 2, "state": "frozen", "at_mm": [3.0,'
)
NEAR = TEXT.replace('"height_mm": 24.0', '"height_mm": 24.4')


@pytest.fixture
def file(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The golden file of a project whose one test takes the snapshot of the tower."""
    monkeypatch.delenv("CI", raising=False)
    pytester.makeconftest('pytest_plugins = ["stackdsl.pytest_plugin"]')
    pytester.makepyfile(
        """
        from tests.stackdsl.goldens.towers import taken, tower

        def test_tower(golden):
            snapshot = taken(tower())
            assert snapshot == golden(snapshot.identity)
        """
    )
    path = pytester.path / "golden" / golden_name(IDENTITY)
    path.parent.mkdir(parents=True)
    return path


@pytest.mark.parametrize("text", [TEXT, NEAR], ids=["equal", "within tolerance"])
@pytest.mark.parametrize("arguments", [[], ["--snapshot-update"]], ids=["read", "update"])
def test_a_file_that_agrees_passes_and_is_not_rewritten(
    text: str, arguments: list[str], file: Path, pytester: pytest.Pytester
) -> None:
    file.write_text(text, encoding="utf-8")
    pytester.runpytest(*arguments).assert_outcomes(passed=1)
    assert file.read_text(encoding="utf-8") == text


def test_a_difference_fails_and_is_told_as_in_reports_with_the_commands_that_decide_on_it(
    file: Path, pytester: pytest.Pytester
) -> None:
    file.write_text(MOVED, encoding="utf-8")
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    commands = ["*accept with: pytest --snapshot-update", "*decide with: stackdsl golden review"]
    result.stdout.fnmatch_lines([*commands, "* x  L2.1: 3.00 mm -> 0.00 mm (tolerance ± 0.5 mm)"])
    assert file.read_text(encoding="utf-8") == MOVED


def test_a_difference_is_pending_until_it_is_accepted(file: Path, pytester: pytest.Pytester) -> None:
    waiting = PendingStore(pytester.path / ".stackdsl")
    file.write_text(MOVED, encoding="utf-8")
    pytester.runpytest().assert_outcomes(failed=1)
    (pending,) = waiting.all()
    assert (pending.case, len(pending.compared(waiting).differences)) == (IDENTITY.case, 1)
    waiting.accept(pending)
    pytester.runpytest().assert_outcomes(passed=1)
    assert not list(waiting.all())


def test_an_update_leaves_nothing_pending(file: Path, pytester: pytest.Pytester) -> None:
    file.write_text(MOVED, encoding="utf-8")
    pytester.runpytest("--snapshot-update").assert_outcomes(passed=1)
    assert not list(PendingStore(pytester.path / ".stackdsl").all())


def test_nothing_is_pending_in_ci(file: Path, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    file.write_text(MOVED, encoding="utf-8")
    pytester.runpytest().stdout.fnmatch_lines(["*accept with: pytest --snapshot-update outside of CI*"])
    assert not (pytester.path / ".stackdsl").exists()


def test_a_missing_file_fails_with_the_remedy(file: Path, pytester: pytest.Pytester) -> None:
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    named = f"*Snapshot 'test_tower[[]golden/{golden_name(IDENTITY)}[]]' does not exist!"
    result.stdout.fnmatch_lines([named, "*pytest --snapshot-update*"])
    assert not file.exists()


@pytest.mark.parametrize("content", [b"", b"<<<<<<< HEAD", b"\xff\xfe"], ids=["empty", "conflict", "not UTF-8"])
def test_an_unreadable_file_fails(content: bytes, file: Path, pytester: pytest.Pytester) -> None:
    file.write_bytes(content)
    pytester.runpytest().assert_outcomes(failed=1)


@pytest.mark.parametrize("before", [None, MOVED, "<<<<<<< HEAD"], ids=["missing", "different", "unreadable"])
def test_an_update_writes_the_bytes_of_stackdsl_check_and_which_test_keeps_them(
    before: str | None, file: Path, pytester: pytest.Pytester
) -> None:
    if before is not None:
        file.write_text(before, encoding="utf-8")
    pytester.runpytest("--snapshot-update").assert_outcomes(passed=1)
    (test,) = pytester.path.glob("test_*.py")
    kept = canonical_text(replace(taken(tower()), kept_by=test.name))
    assert file.read_bytes() == kept.encode("ascii")
    assert kept.replace(f'  "kept_by": "{test.name}",\n', "") == TEXT


def test_ci_refuses_to_write(file: Path, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    result = pytester.runpytest("--snapshot-update")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["golden files are not written in CI*"])
    result.stdout.no_fnmatch_line("*Traceback*")
    assert not file.exists()


@pytest.mark.parametrize("arguments", [[], ["--snapshot-update"]], ids=["read", "update"])
def test_files_of_other_variants_are_left_alone(arguments: list[str], file: Path, pytester: pytest.Pytester) -> None:
    file.write_text(TEXT, encoding="utf-8")
    other = file.with_name("other.stock.json")
    other.write_text("{}", encoding="utf-8")
    result = pytester.runpytest(*arguments)
    assert result.ret == 0
    assert other.exists()


def test_the_directory_can_be_set(file: Path, pytester: pytest.Pytester) -> None:
    pytester.makeini("[pytest]\ngolden_directory = elsewhere/locked")
    pytester.runpytest("--snapshot-update").assert_outcomes(passed=1)
    assert (pytester.path / "elsewhere" / "locked" / golden_name(IDENTITY)).exists()


@pytest.mark.parametrize("named", ["../{name}-out", "{parent}/{name}-out"])
def test_a_directory_outside_of_the_root_of_the_tests_is_refused(
    named: str, file: Path, pytester: pytest.Pytester
) -> None:
    outside = pytester.path / (named := named.format(name=pytester.path.name, parent=pytester.path.parent))
    pytester.makeini(f"[pytest]\ngolden_directory = {named}")
    result = pytester.runpytest("--snapshot-update")
    assert result.ret != 0
    assert "is outside of" in result.stdout.str() + result.stderr.str()
    assert not outside.exists()


@pytest.mark.parametrize("linked", ["golden", "golden/{}", "golden/{}/{}"])
def test_golden_files_that_a_link_leads_outside_are_neither_read_nor_written(
    linked: str, file: Path, pytester: pytest.Pytester
) -> None:
    shutil.rmtree(pytester.path / "golden", ignore_errors=True)
    name = linked.format(*golden_name(IDENTITY).split("/"))
    outside = pytester.path.parent / f"{pytester.path.name}-outside"
    (outside / name).parent.mkdir(parents=True)
    (pytester.path / name).parent.mkdir(parents=True, exist_ok=True)
    (outside / golden_name(IDENTITY)).parent.mkdir(parents=True, exist_ok=True)
    (outside / golden_name(IDENTITY)).write_text(TEXT, encoding="utf-8")
    locked = outside / golden_name(IDENTITY)
    (pytester.path / name).symlink_to([outside, locked.parent, locked][name.count("/")])
    assert pytester.runpytest().ret == 1
    before = (outside / golden_name(IDENTITY)).stat().st_mtime_ns
    pytester.runpytest("--snapshot-update")
    assert (outside / golden_name(IDENTITY)).stat().st_mtime_ns == before
    assert [path.name for path in outside.rglob("*.json")] == [golden_name(IDENTITY).split("/")[1]]


def test_two_variants_in_one_test_have_a_file_each(file: Path, pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        from dataclasses import replace
        from tests.stackdsl.goldens.towers import taken, tower

        def test_towers(golden):
            one = taken(tower())
            other = replace(one, identity=replace(one.identity, variant="step=1mm,thesis"))
            held, held_other = golden(one.identity), golden(other.identity)
            assert one == held
            assert other == held_other
        """
    )
    pytester.runpytest("--snapshot-update").assert_outcomes(passed=1)
    assert sorted(path.name for path in file.parent.iterdir()) == ["step-1mm.thesis.json", file.name]


def test_only_snapshots_are_kept(file: Path, pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        from tests.stackdsl.goldens.towers import IDENTITY

        def test_tower(golden):
            assert {"height": 3} == golden(IDENTITY)
        """
    )
    result = pytester.runpytest("--snapshot-update")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*a golden file needs a Snapshot of stackdsl, not dict*"])
    assert not file.exists()


TOWERS = """
import pytest
from stackdsl import Scenario, claims, layouts

@pytest.mark.parametrize("levels", [2, 3])
def test_tower(golden, levels):
    scenario = Scenario("NAME", build=[layouts.column(levels=levels, step="STEP")], expect=[claims.stands("all")])
    snapshot = scenario.play().snapshot()
    assert snapshot == golden(snapshot.identity)
"""


@pytest.fixture
def towers(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> Callable[..., pytest.RunResult]:
    """Runs two tests of towers with a name and a step."""
    monkeypatch.delenv("CI", raising=False)
    pytester.makeconftest('pytest_plugins = ["stackdsl.pytest_plugin"]')

    def run(name: str, step: str, *options: str) -> pytest.RunResult:
        text = TOWERS.replace('"NAME"', name).replace("STEP", step)
        (pytester.path / "test_towers.py").write_text(text, encoding="utf-8")
        return pytester.runpytest_subprocess(*options)

    return run


def test_two_tests_do_not_lock_different_runs_in_one_file(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    result = towers('"tower"', "5 mm", "--snapshot-update")
    result.assert_outcomes(passed=1, failed=1)
    both = "test_towers.py::test_tower[[]2[]] and test_towers.py::test_tower[[]3[]]"
    result.stdout.fnmatch_lines([f"SD203 two tests *'tower'*: {both}", '*= *f"tower-{levels}"'])
    assert not (pytester.path / "golden" / "tower").exists()


def test_a_golden_file_stays_as_it_was_if_two_tests_have_different_runs(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    towers('"tower"', "5 mm", "--snapshot-update", "-k", "2").assert_outcomes(passed=1, deselected=1)
    file = pytester.path / "golden" / "tower" / "exact.json"
    before = file.read_bytes()
    towers('"tower"', "6 mm", "--snapshot-update").assert_outcomes(passed=1, failed=1)
    assert file.read_bytes() == before


def test_a_failing_run_is_accepted_only_with_accept_failing(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    refused = towers('f"tower-{levels}"', "44 mm", "--snapshot-update")
    refused.assert_outcomes(passed=1, failed=1)
    refused.stdout.fnmatch_lines(["*tower-3/exact.json: not written, *stands: expected all*; --accept-failing *"])
    assert [path.name for path in (pytester.path / "golden").iterdir()] == ["tower-2"]
    towers('f"tower-{levels}"', "44 mm", "--snapshot-update", "--accept-failing").assert_outcomes(passed=2)
    towers('f"tower-{levels}"', "44 mm", "--snapshot-update").assert_outcomes(passed=2)  # nothing is to be accepted


def test_what_is_not_compared_is_told_where_a_golden_file_is_written_and_where_it_differs(
    towers: Callable[..., pytest.RunResult],
) -> None:
    told = "2 states, 2 places, * are unclear and not compared: states and places of L2.1, L3.1"
    written = towers('f"tower-{levels}"', "66 mm", "--snapshot-update", "--accept-failing")
    written.stdout.fnmatch_lines([f"golden/tower-3/exact.json: {told}"])
    written.stdout.no_fnmatch_line("*tower-2/exact.json: *")  # it has come to rest on the ground, where it is compared
    towers('f"tower-{levels}"', "66.3 mm", "-k", "3").stdout.fnmatch_lines(["E *unclear *", "E *L2.1, L3.1"])


def test_golden_files_of_a_scenario_that_has_another_name_now_are_told_and_removed_by_an_update(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    def files() -> list[str]:
        return sorted(file.parent.name for file in Path(pytester.path, "golden").glob("*/*.json"))

    towers('f"tower-{levels}"', "5 mm", "--snapshot-update").stdout.no_fnmatch_line("*golden file, which*")
    other = Path(pytester.path, "golden", "by-another-test", "exact.json")
    other.parent.mkdir()
    theirs = Path(pytester.path, "golden/tower-2/exact.json").read_text().replace("test_towers.py", "test_other.py")
    other.write_text(theirs)
    Path(pytester.path, "test_other.py").touch()
    for part in (("-k", "2"), ("test_towers.py::test_tower[2]",)):
        towers('f"stack-{levels}"', "5 mm", "--snapshot-update", *part).stdout.no_fnmatch_line("*golden file, which*")
    told = towers('f"stack-{levels}"', "5 mm", "--snapshot-update").stdout
    told.fnmatch_lines([f"removed golden file, which no test uses: golden/tower-{n}/exact.json" for n in (2, 3)])
    assert files() == ["by-another-test", "stack-2", "stack-3"]
    Path(pytester.path, "golden/stack-2").rename(Path(pytester.path, "golden/left"))
    told = towers('f"stack-{levels}"', "5 mm").stdout
    told.no_fnmatch_line("*golden file, which*")  # the test that misses its file has failed


def test_a_golden_file_follows_its_test_into_another_file_and_is_unused_only_if_no_test_of_the_project_uses_it(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    towers('f"tower-{levels}"', "5 mm", "--snapshot-update").assert_outcomes(passed=2)
    golden = [Path(pytester.path, f"golden/tower-{levels}/exact.json") for levels in (2, 3)]
    before, test = golden[0].read_text(), Path(pytester.path, "test_towers.py")
    test = test.rename(test.with_name("test_planks.py"))
    read = pytester.runpytest_subprocess()
    told = "golden file golden/tower-2/exact.json names test_towers.py, and pytest --snapshot-update changes this to *"
    read.stdout.fnmatch_lines([told])
    read.stdout.no_fnmatch_line("*obsolete*")
    assert golden[0].read_text() == before
    pytester.runpytest_subprocess("--snapshot-update", "-k", "2")
    assert golden[0].read_text() == before.replace("test_towers.py", "test_planks.py")
    test.write_text("def test_nothing(golden): pass")
    one_tower = TOWERS.replace('"NAME"', '"tower-2"').replace("[2, 3]", "[2]").replace("STEP", "5 mm")
    Path(pytester.path, "test_other.py").write_text(one_tower)
    pytester.runpytest_subprocess("test_planks.py", "--snapshot-update", "-k", "nothing")
    assert golden[1].exists()  # the owner of this file does not exist, and tests of other files may use it
    update = pytester.runpytest_subprocess("--snapshot-update").stdout
    update.fnmatch_lines(["removed golden file, which no test uses: golden/tower-3/exact.json"])
    assert '"kept_by": "test_other.py"' in golden[0].read_text()


def test_a_missing_file_is_told_with_those_that_no_test_of_the_file_has_used(
    towers: Callable[..., pytest.RunResult],
) -> None:
    towers('f"tower-{levels}"', "5 mm", "--snapshot-update").assert_outcomes(passed=2)
    told = towers('f"tower-{levels - 1}"', "5 mm").stdout  # tower-2 is now another tower, and tower-1 is missing
    told.fnmatch_lines(
        [
            "*tower-1/exact.json*does not exist*",
            "*golden/tower-2/exact.json, golden/tower-3/exact.json: kept by this file*",
        ]
    )
    for line in told.lines:
        assert "kept by this file" not in line or "belongs to the name of the scenario" in line


def test_an_update_drops_the_pending_difference_of_a_scenario_that_no_test_has_any_more(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    def pending() -> list[str]:
        return [each.case for each in PendingStore(pytester.path / ".stackdsl").all()]

    towers('f"tower-{levels}"', "5 mm").assert_outcomes(failed=2)
    towers('f"stack-{levels}"', "5 mm", "--snapshot-update", "-k", "2")
    assert pending() == ["tower-2[exact]", "tower-3[exact]"]  # the tests that were not selected may have them
    told = towers('f"stack-{levels}"', "5 mm", "--snapshot-update").stdout
    told.fnmatch_lines(
        [f"dropped pending change, which no test has any more: golden/tower-{n}/exact.json" for n in (2, 3)]
    )
    assert pending() == []


def test_the_commands_of_a_project_without_yaml_name_pytest(
    towers: Callable[..., pytest.RunResult], pytester: pytest.Pytester
) -> None:
    status, check = ((sys.executable, "-P", "-m", "stackdsl", *words) for words in (("golden", "status"), ("check",)))
    pytester.run(*status).stdout.fnmatch_lines(["0 pending; stackdsl check compares with the golden files"])
    pytester.run(*check).stdout.no_fnmatch_line("*pytest*")
    towers('f"tower-{levels}"', "5 mm", "--snapshot-update").assert_outcomes(passed=2)
    pytester.run(*status).stdout.fnmatch_lines(["0 pending; pytest compares with the golden files"])
    pytester.run(*check).stdout.fnmatch_lines(["scenarios:1:1: SD001 *", "*= run pytest, *"])


def test_no_project_file_is_read_for_each_test_at_the_end_of_a_session(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Syrupy asks each extension, one for each golden file, for a folder of each test file."""

    def read(*_: object) -> None:
        raise AssertionError("the project file was read")

    monkeypatch.setattr("stackdsl.pytest_plugin.golden_directory.project_of", read)
    location = PyTestLocation(request.node)
    assert GoldenExtension.discovery_dirname(test_location=location) == ""
    assert not list(GoldenExtension().discover_snapshots(test_location=location))
