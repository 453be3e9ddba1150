"""`pytest scenarios`: every variant on every system is a test, with the golden files of `stackdsl check`."""

from pathlib import Path

import pytest

from stackdsl.goldens.golden import PendingStore

COLUMN = """\
# A column that leans out by 44 mm a level stands as long as count times step is within a length.
scenario: column
tags: [hard]
matrix: {levels: [2, 3]}
build:
  - column: {levels: "${levels}", step: 44 mm}
expect:
  - stands: all
---
scenario: other
systems: [exact]
build:
  - column: {levels: 2}
"""


@pytest.fixture
def scenarios(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The directory of scenarios of a project, with one file."""
    monkeypatch.delenv("CI", raising=False)
    pytester.makeconftest('pytest_plugins = ["stackdsl.pytest_plugin"]')
    folder = pytester.path / "scenarios"
    folder.mkdir()
    (folder / "columns.yaml").write_text(COLUMN, encoding="utf-8")
    return folder


def test_every_variant_is_a_test_of_its_own_name(scenarios: Path, pytester: pytest.Pytester) -> None:
    result = pytester.runpytest("--collect-only", "-q", "scenarios")
    result.stdout.fnmatch_lines(
        [
            "scenarios/columns.yaml::column[[]levels=2,exact[]]",
            "scenarios/columns.yaml::column[[]levels=3,exact[]]",
            "scenarios/columns.yaml::other[[]exact[]]",
        ]
    )


def test_a_standing_scenario_passes_and_a_falling_one_fails_with_place_and_measure(
    scenarios: Path, pytester: pytest.Pytester
) -> None:
    result = pytester.runpytest("--no-golden", "scenarios")
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*FAILED  column[[]levels=3,exact[]]*columns.yaml:8:5",
            "*expected  stands: all",
            "*measured  1 of 3 bricks fell*",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.parametrize(("chosen", "count"), [(["-m", "hard"], 2), (["-k", "other"], 1), (["-m", "not hard"], 1)])
def test_tags_are_marks(chosen: list[str], count: int, scenarios: Path, pytester: pytest.Pytester) -> None:
    result = pytester.runpytest("--collect-only", "--strict-markers", "-q", *chosen, "scenarios")
    result.stdout.re_match_lines([rf"{count}/3 tests collected.*"])


def test_a_new_golden_file_is_written_at_home_and_refused_in_ci_as_by_check(
    scenarios: Path, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    locked = pytester.path / "golden" / "other" / "exact.json"
    monkeypatch.setenv("CI", "true")
    result = pytester.runpytest("-k", "other", "scenarios")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*accept with: pytest outside of CI*", "FAILED *- has no golden file"])
    assert not locked.exists()
    monkeypatch.delenv("CI")
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)
    assert locked.exists()
    monkeypatch.setenv("CI", "true")
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)


def test_a_failing_scenario_is_locked_only_with_accept_failing(scenarios: Path, pytester: pytest.Pytester) -> None:
    locked = pytester.path / "golden" / "column" / "levels-3.exact.json"
    for options in ([], ["--snapshot-update"]):
        result = pytester.runpytest(*options, "-k", "column and 3", "scenarios")
        result.assert_outcomes(failed=1)
        result.stdout.fnmatch_lines(
            ["*1 of these results fails expectations; only pytest --snapshot-update --accept-failing would accept it*"]
        )
        assert not locked.exists()
    pytester.runpytest("--snapshot-update", "--accept-failing", "-k", "column and 3", "scenarios")
    assert locked.exists()


def test_golden_files_are_held_against(scenarios: Path, pytester: pytest.Pytester) -> None:
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)
    moved = COLUMN.replace("column: {levels: 2}", "column: {levels: 2, step: 1 mm}")
    (scenarios / "columns.yaml").write_text(moved, encoding="utf-8")
    result = pytester.runpytest("-k", "other", "scenarios")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["  x *L2.1*: 0.00 mm -> 1.00 mm*"])


def test_a_scenario_that_only_has_another_name_is_told_as_renamed(scenarios: Path, pytester: pytest.Pytester) -> None:
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)
    (scenarios / "columns.yaml").write_text(COLUMN.replace("scenario: other", "scenario: short"), encoding="utf-8")
    result = pytester.runpytest("-k", "short", "scenarios")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*/golden/short/exact.json: renamed: it was */golden/other/exact.json"])
    result.stdout.no_fnmatch_line("*snapshot-update*")
    assert not (pytester.path / "golden" / "short").exists()


def test_a_mistake_is_told_with_its_place_and_the_rest_of_the_tests_is_not_run(
    scenarios: Path, pytester: pytest.Pytester
) -> None:
    (scenarios / "columns.yaml").write_text(COLUMN.replace("levels: 2}", "level: 2}"), encoding="utf-8")
    result = pytester.runpytest("scenarios")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*columns.yaml:13:14: SD101 unknown key 'level'*"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_two_scenarios_of_one_name_are_told(scenarios: Path, pytester: pytest.Pytester) -> None:
    (scenarios / "more.yaml").write_text(COLUMN, encoding="utf-8")
    result = pytester.runpytest("--no-golden", "scenarios")
    result.assert_outcomes(passed=2, failed=3)  # one of them falls
    result.stdout.fnmatch_lines(
        [
            "scenarios/more.yaml:2:11: SD203 two scenarios are called 'column'; *at scenarios/columns.yaml:2:11",
            "*= rename this one, since -k and golden files identify scenarios by name",
        ]
    )


def test_a_failed_comparison_of_a_verdict_has_expected_measured_and_why(pytester: pytest.Pytester) -> None:
    pytester.makeconftest('pytest_plugins = ["stackdsl.pytest_plugin"]')
    pytester.makepyfile(
        """
        from stackdsl import Scenario, claims, layouts

        RUN = Scenario("high", build=[layouts.column(levels=3, step="44 mm")]).play()

        def test_verdict():
            verdict = RUN.verdict
            assert verdict == "stands"

        def test_claim():
            assert RUN.judge(claims.stands("all")).passed
        """
    )
    result = pytester.runpytest()
    result.assert_outcomes(failed=2)
    why = "L2.1, L3.1 tip over L1.1, towards +x, its weight 7.2 mm beyond the edge"
    result.stdout.fnmatch_lines(
        [
            "E * assert 'collapses' == 'stands'",
            "E * high[[]exact[]]",
            "E * expected  stands",
            "E * measured  collapses at level 3",
            f"E * why       {why}",
            "E * assert <* failed: stands>",
            f"E * why       {why}",
        ]
    )


def test_an_asserted_result_is_told_whole_and_in_the_summary(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CI", "true")  # elsewhere, pytest shortens its summary
    pytester.makeconftest('pytest_plugins = ["stackdsl.pytest_plugin"]')
    pytester.makepyfile(
        """
        from stackdsl import Scenario, claims, layouts

        HIGH = [layouts.column(levels=3, step="44 mm")]
        RUN = Scenario("high", build=HIGH, expect=[claims.stands("all"), claims.height("23.4 mm ± 0.1 mm")]).play()

        def test_run():
            assert RUN

        def test_claim():
            assert RUN.judge(claims.falls(count=0))

        def test_passed():
            assert RUN.passed, "of the high one"

        def test_golden():
            assert RUN.golden("golden")

        def test_other():
            assert not RUN and RUN.trace.margins is None
        """
    )
    result = pytester.runpytest("-W", "error")
    result.assert_outcomes(failed=5)
    why = "E  *why       L2.1, L3.1 tip over L1.1, towards +x, its weight 7.2 mm beyond the edge"
    block = [
        "E  *expected  stands: all",
        "E  *measured  1 of 3 bricks fell: L3.1",
        "E  *also *height: expected 23.4 mm*",
        why,
        "E  *first     L3.1*",
    ]
    result.stdout.fnmatch_lines(
        [
            *["E * assert <* failed: high[[]exact[]]>", *block],
            *["E * assert <* failed: falls>", "E  *expected  count 0", "E  *measured  1 brick fell", why],
            *["E * of the high one", "E * assert <* failed: high[[]exact[]]>", *block],
            *["E * assert <golden file missing: golden/high/exact.json>", "E  *helps  golden(directory, update=True)*"],
            "FAILED *::test_run - expected stands: all*",
            "FAILED *::test_claim - expected count 0, *",
            "FAILED *::test_passed - of the high one",
        ]
    )


def test_a_difference_that_pytest_found_is_reviewed_with_the_command(
    scenarios: Path, pytester: pytest.Pytester
) -> None:
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)
    moved = COLUMN.replace("column: {levels: 2}", "column: {levels: 2, step: 1 mm}")
    (scenarios / "columns.yaml").write_text(moved, encoding="utf-8")
    pytester.runpytest("-k", "other", "scenarios").stdout.fnmatch_lines(["*decide *stackdsl golden review"])
    (pending,) = PendingStore(pytester.path / ".stackdsl").all()
    assert (pending.case, pending.golden) == ("other[exact]", "golden/other/exact.json")
    (scenarios / "columns.yaml").write_text(COLUMN, encoding="utf-8")
    pytester.runpytest("-k", "other", "scenarios").assert_outcomes(passed=1)
    assert not list(PendingStore(pytester.path / ".stackdsl").all())


def test_yaml_elsewhere_is_no_test_unless_it_is_named(scenarios: Path, pytester: pytest.Pytester) -> None:
    (pytester.path / "compose.yaml").write_text("services: {}\n", encoding="utf-8")
    moved = scenarios.rename(pytester.path / "scenes") / "columns.yaml"
    assert pytester.runpytest("--collect-only").ret == pytest.ExitCode.NO_TESTS_COLLECTED
    pytester.runpytest("--no-golden", "-k", "other", str(moved)).assert_outcomes(passed=1)
    pytester.makeini("[pytest]\nscenario_directories = scenes")
    pytester.runpytest("--no-golden", "-k", "other").assert_outcomes(passed=1)


def test_scenarios_need_no_syrupy(scenarios: Path, pytester: pytest.Pytester) -> None:
    pytester.runpytest("-p", "no:syrupy", "--no-golden", "-k", "other", "scenarios").assert_outcomes(passed=1)
    pytester.makepyfile("def test_tower(golden): pass")
    result = pytester.runpytest("-p", "no:syrupy")
    result.stdout.fnmatch_lines(["*the fixture `golden` needs syrupy*pip install*"])


@pytest.mark.slow
def test_processes_share_the_work(scenarios: Path, pytester: pytest.Pytester) -> None:
    pytester.runpytest("-n", "2", "--no-golden", "-k", "other or 2", "scenarios").assert_outcomes(passed=2)


def test_pytest_knows_of_scenarios_by_itself(scenarios: Path, pytester: pytest.Pytester) -> None:
    (pytester.path / "conftest.py").unlink()
    result = pytester.runpytest_subprocess("--no-golden", "-k", "other", "scenarios")
    result.assert_outcomes(passed=1)


def test_golden_files_are_where_the_project_has_them(scenarios: Path, pytester: pytest.Pytester) -> None:
    pytester.makefile(".toml", stackdsl='golden = "locked"')
    pytester.runpytest("--snapshot-update", "-k", "other", "scenarios").assert_outcomes(passed=1)
    assert (pytester.path / "locked" / "other" / "exact.json").exists()


def test_a_falling_scenario_without_expectations_is_a_warning(scenarios: Path, pytester: pytest.Pytester) -> None:
    (scenarios / "columns.yaml").write_text(COLUMN.replace("expect:\n  - stands: all\n", ""), encoding="utf-8")
    result = pytester.runpytest("-W", "default", "--no-golden", "scenarios")
    result.assert_outcomes(passed=3, warnings=1)
    result.stdout.fnmatch_lines(["*ScenarioWarning: column[[]levels=3,exact[]]: it fell at level 3 (*"])
