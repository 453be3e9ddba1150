"""What a report says to people, and with which exit code."""

import json
import subprocess
import sys
from dataclasses import replace
from math import inf, nan, radians

import pytest

from stability.engines.protocol import WrongFriction
from stackdsl.exits import ExitCode
from stackdsl.report.blocks import TextStyle
from stackdsl.report.check_text import report_text
from stackdsl.report.formats import report_csv, report_github, report_json, report_junit, report_markdown
from stackdsl.report.outline import nearest
from stackdsl.report.text import outcome_text
from stackdsl.report.warnings import wrong_edges_text
from stackdsl.results import (
    EarlyEndSummary,
    FallenCounts,
    GoldenDifference,
    GoldenStatus,
    Report,
    RunStatus,
    VariantResult,
    exit_code,
)
from stackdsl.trace import Collapse, Cost, Measure, PassedThrough, WrongEdges
from tests.paths import ROOT
from tests.stackdsl.report.reports import (
    CRASHED,
    FAILED,
    FULL,
    HELD,
    LATE,
    MISSED,
    MISTAKE,
    MOVED,
    NOT_RUN,
    PASSED,
    TUNED,
    UNRELIABLE,
    report,
    with_golden,
)

EXIT_CODES = {
    "all as expected": (report(PASSED, TUNED), 0),
    "nothing was selected": (report(), 4),
    "golden written": (report(with_golden(GoldenStatus.WRITTEN)), 0),
    "no golden asked for": (report(replace(PASSED, golden=None)), 0),
    "an answer from outside is missed": (report(replace(PASSED, truths=(MISSED,))), 0),
    "an expectation failed": (report(PASSED, FAILED), 1),
    "a run is unreliable": (report(PASSED, UNRELIABLE), 1),
    "a scenario is invalid": (report(PASSED, diagnostics=(MISTAKE,)), 2),
    "golden missing": (report(with_golden(GoldenStatus.MISSING)), 3),
    "golden different": (report(with_golden(GoldenStatus.DIFFERENT)), 3),
    "golden unreadable": (report(with_golden(GoldenStatus.UNREADABLE)), 3),
    "golden obsolete": (report(PASSED, obsolete=("golden/gone/x.json",)), 3),
    "golden removed": (report(PASSED, removed=("golden/gone/x.json",)), 0),
    "blocked": (report(replace(CRASHED, status=RunStatus.BLOCKED, mistake=MISTAKE)), 2),
    "crashed": (report(CRASHED), 5),
    "timed out": (report(LATE), 5),
    "interrupted": (report(NOT_RUN, interrupted=True), 130),
    "failed before different": (report(FAILED, with_golden(GoldenStatus.DIFFERENT)), 1),
    "crashed before failed": (report(FAILED, CRASHED), 5),
    "invalid before crashed": (report(CRASHED, diagnostics=(MISTAKE,)), 2),
    "interrupted before invalid": (report(diagnostics=(MISTAKE,), interrupted=True), 130),
}


@pytest.mark.parametrize(("seen", "code"), EXIT_CODES.values(), ids=EXIT_CODES)
def test_the_exit_code_names_the_gravest_reason(seen: Report, code: int) -> None:
    assert exit_code(seen) == code
    assert exit_code(seen) in list(ExitCode)


TABLE, VERBOSE = TextStyle(table=True), TextStyle(verbosity=1)
SUMS = {
    "2 variants pass": (report(PASSED, TUNED), "1 scenario, 2 cases: 2 passed in 12.3 s"),
    "two scenarios": (report(PASSED, replace(PASSED, scenario="arch")), "2 scenarios, 2 cases: 2 passed in 12.3 s"),
    "one of each": (
        report(PASSED, FAILED, CRASHED, LATE, with_golden(GoldenStatus.DIFFERENT), with_golden(GoldenStatus.MISSING)),
        "1 scenario, 6 cases: 1 passed, 1 crashed, 1 failed, 1 golden different, 1 golden missing, 1 timed out in",
    ),
    "files": (
        report(PASSED, obsolete=("a", "b"), removed=("c",)),
        "1 case: 1 passed, 2 obsolete golden files, 1 removed golden file in 12.3 s",
    ),
    "mistakes": (report(diagnostics=(MISTAKE, MISTAKE)), "2 mistakes, so nothing was run"),
    "interrupted": (report(PASSED, NOT_RUN, interrupted=True), "1 passed, 1 not run, interrupted in 12.3 s"),
    "nothing": (report(), "0 scenarios, 0 cases: no cases run in 12.3 s"),
}


@pytest.mark.parametrize(("seen", "line"), SUMS.values(), ids=SUMS)
def test_the_last_line_sums_up(seen: Report, line: str) -> None:
    assert line in report_text(seen).splitlines()[-1]


def row(seen: Report, index: int = 0) -> dict[str, str]:
    """The cells of one variant in the summary, by column; cells are two blanks apart or more."""
    lines = report_text(seen, width=200, style=TABLE).splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("scenario"))
    split = [[cell.strip() for cell in lines[i].split("  ") if cell.strip()] for i in (head, head + 1 + index)]
    return dict(zip(*split, strict=True))


def test_a_variant_is_one_row() -> None:
    assert row(report(replace(PASSED, truths=(HELD,)), TUNED)) == {
        "scenario": "slant",
        "variant": "step=11mm,thesis",
        "verdict": "collapses",
        "level": "9",
        "drift mm": "123",
        "met": "2/2",
        "truth": "agrees",
        "golden": "same",
        "wall s": "2.00",
        "sim. s": "10.0",
        "steps": "9600",
        "vs tuned": "3x",
    }


def test_speed_up_is_per_simulated_second_and_within_one_case() -> None:
    # 2 s for 10 s against 3 s for 5 s.
    seen = report(PASSED, TUNED, replace(PASSED, variant="step=12mm,thesis"), CRASHED)
    assert [seen.speed_up(result) for result in seen.results] == [pytest.approx(3.0), 1.0, None, None]


def test_a_run_that_took_no_steps_and_no_time_has_no_speed_up() -> None:
    still = replace(PASSED, cost=Cost(wall_time=0.0, simulated_time=0.0, steps=0, judgements=1))
    assert report(still, TUNED).speed_up(still) is None


@pytest.mark.parametrize(
    ("drift", "shown"),
    [(0.0, "0"), (1.23456, "1230"), (0.0123456, "12.3"), (1.23456e-6, "0.00123"), (1.2e-7, "0.00012"), (nan, "nan")],
)
def test_drift_has_three_significant_digits(drift: float, shown: str) -> None:
    assert row(report(replace(PASSED, drift=drift)))["drift mm"] == shown


@pytest.mark.parametrize(("result", "verdict"), [(CRASHED, "crashed"), (LATE, "timed out"), (NOT_RUN, "not run")])
def test_a_variant_that_did_not_finish_says_so_in_place_of_a_verdict(result: VariantResult, verdict: str) -> None:
    cells = row(report(PASSED, result), index=1)
    assert cells["verdict"] == verdict
    assert {cells[name] for name in ("level", "drift mm", "met", "golden", "wall s", "steps")} == {"-"}


def test_columns_that_no_row_fills_are_left_out() -> None:
    plain = replace(PASSED, collapse=None, golden=None)
    assert not {"level", "truth", "golden", "vs tuned"} & row(report(plain)).keys()


LINES = {
    "mistake": (
        report(diagnostics=(MISTAKE,)),
        "scenarios/slant.yaml:14:5: SD204 unknown brick 'tpo'",
    ),
    "missing": (report(with_golden(GoldenStatus.MISSING)), "  golden/slant/thesis.json: missing"),
    "unreadable": (
        report(with_golden(GoldenStatus.UNREADABLE, "it is not UTF-8")),
        "  golden/slant/thesis.json: unreadable: it is not UTF-8",
    ),
    "written": (report(with_golden(GoldenStatus.WRITTEN)), "  golden/slant/thesis.json: written"),
    "to accept": (
        replace(report(with_golden(GoldenStatus.DIFFERENT)), accept="stackdsl check scenarios --golden g --update"),
        "  accept with: stackdsl check scenarios --golden g --update",
    ),
    "to accept and to remove": (
        replace(report(obsolete=("golden/gone/x.json",)), accept="stackdsl check --update"),
        "  accept, and remove obsolete files, with: stackdsl check --update",
    ),
    "obsolete": (
        report(obsolete=("golden/gone/x.json",)),
        "  golden/gone/x.json: obsolete, no variant uses this file",
    ),
    "removed": (report(removed=("golden/gone/x.json",)), "  golden/gone/x.json: removed"),
}


@pytest.mark.parametrize(("seen", "line"), LINES.values(), ids=LINES)
@pytest.mark.parametrize("width", [10, 120])
def test_a_finding_is_one_whole_line_at_any_width(seen: Report, line: str, width: int) -> None:
    assert line in report_text(seen, width=width).splitlines()


def block(seen: Report, width: int = 100) -> list[str]:
    """The lines of the first block."""
    return report_text(seen, width).split("\n\n")[0].splitlines()


def test_a_failure_is_a_block_that_says_where_expected_and_measured() -> None:
    head, expected, measured, *_, see = block(report(FAILED))
    assert head.startswith("✗ FAILED  slant[step=11mm,thesis] ")
    assert head.endswith(" scenarios/slant.yaml:14:5")
    assert expected == "  expected  collapses: level 9 ± 1"
    assert measured == "  measured  level 11 (misses by 1 level)"
    assert see.startswith("  see it    stackdsl run scenarios/slant.yaml -k 'slant[step=11mm,thesis]' --html")


def test_systems_that_fail_alike_share_a_block() -> None:
    other = replace(FAILED, system="tuned", variant="step=11mm,tuned")
    text = report_text(report(FAILED, other))
    assert text.count("FAILED") == 1
    assert "slant[step=11mm,thesis, tuned]" in text


@pytest.mark.parametrize(("result", "said"), [(CRASHED, "crashed: the worker was killed"), (LATE, "timed out: took")])
def test_a_run_that_did_not_finish_is_a_failure_that_says_why(result: VariantResult, said: str) -> None:
    assert f"  measured  {said}" in report_text(report(PASSED, result))


def test_no_line_is_wider_than_the_terminal_and_no_word_is_broken() -> None:
    text = report_text(report(FAILED, with_golden(GoldenStatus.DIFFERENT, "", MOVED)), width=80)
    assert max(len(line) for line in text.splitlines() if "--html" not in line) <= 80
    assert "slant[step=11mm,thesis]" in text


def test_a_green_report_is_one_line_a_file_and_one_of_sums() -> None:
    lines = report_text(report(PASSED, TUNED, replace(PASSED, file="b.yaml"))).splitlines()
    assert [line.split()[0] for line in lines if line and not line.startswith(("!", "lists"))] == [
        *("b.yaml", "scenarios/slant.yaml", "✓")
    ]


def test_many_files_are_told_by_folder() -> None:
    files = [replace(PASSED, file=f"scenarios/{'ab'[n % 2]}/{n}.yaml") for n in range(40)]
    lines = report_text(report(*files)).splitlines()
    assert [line.split()[:3] for line in lines[:2]] == [["scenarios/a/", "✓", "20"], ["scenarios/b/", "✓", "20"]]


def test_the_claim_nearest_to_failing_is_told_of_a_green_file() -> None:
    near = replace(HELD, margin=0.1, unit="mm", numbers=(Measure(9.9, None, 10.0, "mm"),))
    text = report_text(report(replace(PASSED, outcomes=(near,))))
    assert f"nearest: slant[step=11mm,thesis], {HELD.name} 0.1 mm from its limit" in text


def test_a_claim_that_rests_on_unclear_bricks_says_so_beside_its_margin_and_is_a_note() -> None:
    near = replace(HELD, margin=1.0, unit="bricks", numbers=(Measure(9.0, None, 10.0, "bricks"),), unclear=3)
    seen = report(replace(PASSED, outcomes=(near,)))
    assert f"{HELD.name} 1 bricks from its limit, with 3 unclear" in report_text(seen, width=160)
    assert "! 1 with claims that rest on bricks whose fate is unclear; -v lists them" in report_text(seen)
    assert f"`{HELD.name}` rests on 3 bricks whose fate is unclear" in report_text(seen, style=VERBOSE)


def test_the_number_of_fallen_bricks_is_told_beside_a_golden_difference() -> None:
    result = with_golden(GoldenStatus.DIFFERENT, "", GoldenDifference("L1.1", "state", "fallen", "frozen", "exact"))
    assert result.golden is not None
    counted = replace(result, golden=replace(result.golden, fallen=FallenCounts(38, 0, 6, first="1.2 s -> 1.1 s")))
    assert block(report(counted))[1:3] == ["  fallen      38 -> 6 bricks", "  first fall  1.2 s -> 1.1 s"]
    assert "fallen 38 -> 6 bricks" in repr(counted.golden)
    assert "fallen 38 -&gt; 6 bricks" in report_junit(report(counted))


def test_disagreement_with_truth_is_a_count_and_a_list_with_v() -> None:
    seen = report(replace(PASSED, truths=(HELD, MISSED)))
    assert "! 1 disagree with the reference; -v lists them" in report_text(seen)
    assert "measured level 11" not in report_text(seen)
    assert "expected level 9 ± 1, measured level 11 (misses by 1 level)" in report_text(seen, style=VERBOSE)


def test_of_ten_thousand_golden_differences_each_observation_is_one_line() -> None:
    differences = [GoldenDifference(f"L{number}.1", "state", "frozen", "fallen", "exact") for number in range(10_000)]
    lines = block(Report((with_golden(GoldenStatus.DIFFERENT, "", *differences),)))
    assert lines[1] == "  state  10000 bricks from L0.1 to L9999.1: stands, proven -> fell"
    assert len(lines) == 3


def test_a_golden_difference_names_each_brick_once_with_the_largest_change() -> None:
    moved = [
        GoldenDifference(
            f"L{n:.0f}.1", "x", f"{n} mm", f"{n + 0.1 * n:g} mm", "± 0.5 mm", numbers=(n, n + 0.1 * n), unit="mm"
        )
        for n in (2.0, 5.0, 7.0, 9.0)
    ]
    head, change, decide = block(report(with_golden(GoldenStatus.DIFFERENT, "", *moved)))
    assert head.startswith("≠ GOLDEN DIFFERS  slant[step=11mm,thesis] ")
    assert change == "  x  L2.1, L5.1, L7.1, L9.1: by up to 0.9 mm (L9.1: 9.0 mm -> 9.9 mm)"
    assert decide == "  decide    stackdsl golden review"


def test_golden_differences_begin_with_the_bricks_that_fell_and_end_with_those_that_stand_in_both() -> None:
    def moved(name: str, by: float) -> GoldenDifference:
        return GoldenDifference(name, "y", "0 mm", f"{by} mm", "± 0.5 mm", numbers=(0.0, by), unit="mm")

    stand = [GoldenDifference(f"L1.{number}", "state", "standing", "frozen", "exact") for number in (1, 2)]
    fell = GoldenDifference("L9.3", "state", "displaced", "fallen", "exact")
    shown = [*stand, moved("L2.1", 1.0), fell, moved("L8.1", 7.0)]
    lines = block(report(with_golden(GoldenStatus.DIFFERENT, "", *shown)))[1:-1]
    assert [line.split() for line in lines[:1]] == [["state", "L9.3:", "stands,", "displaced", "->", "fell"]]
    assert lines[-1].split() == ["state", "L1.1,", "L1.2:", "stands,", "not", "proven", "->", "stands,", "proven"]
    assert not {"frozen", "standing"} & set(" ".join(lines).split())


def test_the_limit_of_a_fall_is_told_of_bricks_that_stand_and_is_no_margin() -> None:
    moved = "largest shift 0 mm of 39 mm allowed"
    fallen = replace(
        MISSED, name="stands", measured="1 of 85 bricks fell: L10.3", margin=-543.0, unit="mm", moved=moved
    )
    assert outcome_text(fallen).endswith("fell: L10.3")
    stand = replace(HELD, name="stands", measured="52 bricks stand", margin=39.0, unit="mm", moved=moved)
    assert outcome_text(stand).endswith("52 bricks stand (largest shift 0 mm of 39 mm allowed)")
    assert [*nearest([replace(PASSED, outcomes=(stand,))])] == []
    drift = replace(MISSED, name="drift", measured="4538 mm (L6.4)", margin=-4533.0, unit="mm")
    assert outcome_text(drift).endswith("4538 mm (L6.4) (misses by 4530 mm)")


def test_a_narrow_table_breaks_between_words_and_never_within() -> None:
    lines = report_text(report(PASSED, TUNED), width=10, style=TABLE).splitlines()
    assert {"slant", "step=11mm,thesis", "collapses", "9600"} <= set(" ".join(lines).split())


def test_wrong_edge_normals_are_told_with_the_worst_of_them() -> None:
    wrong = WrongEdges(contacts=3, upper="L3.1", lower="L2.2", angle=radians(28.0), time=12.34, first=0.5)
    seen = report(replace(PASSED, wrong_edges=wrong), PASSED)
    told = (
        "wrong edge normals in 3 contacts (worst: L3.1 on L2.2, wrong by 28 deg at 12.3 s); "
        "the verdict on these bricks cannot be trusted unless it is proven"
    )
    assert report_text(seen, style=VERBOSE).count(told) == 1
    assert "; -v lists them" in report_text(seen)
    assert [result["wrong_edges"] for result in json.loads(report_json(seen))["results"]] == [
        {"contacts": 3, "upper": "L3.1", "lower": "L2.2", "angle_rad": wrong.angle, "time_s": 12.34, "first_s": 0.5},
        None,
    ]


def test_a_friction_that_an_engine_could_not_have_is_told() -> None:
    seen = report(replace(PASSED, wrong_friction=WrongFriction("top", "left", 0.1, 0.167, 1.26)), PASSED)
    told = (
        "the engine has one coefficient per body, which cannot match all contacts: "
        "top and left had 0.167 instead of 0.1 at 1.3 s; proofs are not affected"
    )
    assert report_text(seen, style=VERBOSE).count(told) == 1
    assert "; -v lists them" in report_text(seen)
    assert [result["wrong_friction"] for result in json.loads(report_json(seen))["results"]] == [
        {"between": ["top", "left"], "asked": 0.1, "had": 0.167, "time_s": 1.26},
        None,
    ]


def test_a_verdict_that_counts_on_gaps_says_so() -> None:
    seen = report(replace(PASSED, touching_within=5e-5), PASSED)
    assert report_text(seen, style=VERBOSE).count("stable, if gaps up to 0.05 mm count as contact") == 1
    assert [result["touching_within_m"] for result in json.loads(report_json(seen))["results"]] == [5e-5, None]


def test_a_thrown_brick_that_passed_through_another_is_told_on_every_run() -> None:
    passed = PassedThrough("shot", "L3.2", 6.0167, 0.0596)
    seen = report(replace(PASSED, passed_through=passed, outcomes=(), truths=()), PASSED)  # nothing is claimed of it
    told = (
        "shot passed through L3.2 before 6.017 s, moving 59.6 mm between two observations: "
        "the time step of the engine is too long for that speed"
    )
    assert report_text(seen, style=VERBOSE).count(told) == 1
    assert "1 with a thrown brick that passed through another" in report_text(seen)
    assert [result["passed_through"] for result in json.loads(report_json(seen))["results"]] == [
        {"brick": "shot", "through": "L3.2", "time_s": 6.0167, "travel_m": 0.0596},
        None,
    ]


def test_energy_that_an_engine_added_is_told_on_every_run() -> None:
    seen = report(replace(PASSED, energy_gained=0.046, outcomes=(), truths=()), PASSED)  # nothing is claimed of it
    told = "the engine added 4.6 % to the total energy, so the motion of the bricks cannot be trusted"
    assert report_text(seen, style=VERBOSE).count(told) == 1
    assert "; -v lists them" in report_text(seen)
    assert [result["energy_gained"] for result in json.loads(report_json(seen))["results"]] == [0.046, None]


def test_an_unreliable_run_is_counted_apart_and_told_in_every_format() -> None:
    seen = report(UNRELIABLE, PASSED)
    assert report_text(seen).splitlines()[-1].startswith("✗ 1 scenario, 2 cases: 1 passed, 1 unreliable in ")
    result = json.loads(report_json(seen))["results"][0]
    assert (result["verdict"], result["conclusion"]) == ("unreliable", "unreliable")
    for text in (report_text(seen), report_junit(seen), report_markdown(seen), report_github(seen), report_csv(seen)):
        assert "unreliable" in text


def test_a_scene_that_was_played_with_other_constants_is_told_with_them() -> None:
    seen = report(replace(PASSED, modified="gravity 1 m/s2"), PASSED)
    told = "played with gravity 1 m/s2, so the result is that of a changed scene; lengths refer to the original"
    assert report_text(seen, style=VERBOSE).count(told) == 1
    assert "; -v lists them" in report_text(seen)
    assert [result["modified"] for result in json.loads(report_json(seen))["results"]] == ["gravity 1 m/s2", None]


def test_a_run_that_ended_before_its_time_says_why_and_what_it_left_out() -> None:
    early = EarlyEndSummary(9.25, 14.0, 1)
    seen = report(replace(PASSED, early_end=early), PASSED)
    told = "ended at 9.250 s of 14.000 s, as every claim is decided; 1 later action left out"
    assert told not in report_text(seen)  # nothing hangs on it
    assert report_text(seen, style=VERBOSE).count(f"slant[step=11mm,thesis]: {told}") == 1
    ends = [result["early_end"] for result in json.loads(report_json(seen))["results"]]
    assert ends == [{"time_s": 9.25, "planned_s": 14.0, "actions_left_out": 1}, None]


def test_bricks_still_moving_are_counted_in_the_table_and_named_in_json() -> None:
    seen = report(replace(PASSED, moving=("d61", "d62")), PASSED)
    header, moving, still = report_text(seen, style=TABLE).splitlines()[:3]
    at = header.index("still moving")
    assert [row[at : at + len("still moving")].strip() for row in (moving, still)] == ["2", "-"]
    assert [result["still_moving"] for result in json.loads(report_json(seen))["results"]] == [["d61", "d62"], []]
    assert "still moving" not in report_text(report(PASSED), style=TABLE)


def test_wrong_edge_normals_after_a_collapse_put_only_its_debris_in_doubt() -> None:
    wrong = WrongEdges(contacts=1, upper="L3.1", lower="L2.2", angle=radians(28.0), time=3.0, first=2.0)
    assert wrong_edges_text(wrong, Collapse(1.0, 3, "L3.1")) == (
        "wrong edge normals in 1 contact (L3.1 on L2.2, wrong by 28 deg at 3.0 s); "
        "the final place of this debris cannot be trusted"
    )
    assert "the verdict on these bricks cannot be trusted" in wrong_edges_text(wrong, Collapse(2.5, 3, "L3.1"))


def test_names_of_others_do_not_steer_the_terminal() -> None:
    hostile = replace(PASSED, scenario="\x1b[31mslant[bold]:boom:", status=RunStatus.CRASHED, message="a\x07b")
    text = report_text(report(hostile))
    assert "\ufffd[31mslant[bold]:boom:" in text
    assert "\x1b" not in text
    assert "\x07" not in text


def test_colour_is_only_there_when_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "\x1b[" not in report_text(report(PASSED), colour=False)
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[32msame" in report_text(report(PASSED), colour=True, style=TABLE)


TO_ACCEPT = replace(report(with_golden(GoldenStatus.DIFFERENT)), accept="stackdsl check --update")


def test_a_report_with_nothing_to_accept_names_no_command() -> None:
    assert " with: " not in report_text(FULL)
    assert [json.loads(report_json(seen))["accept"] for seen in (FULL, TO_ACCEPT)] == [None, TO_ACCEPT.accept]


def test_a_margin_without_a_limit_is_left_out() -> None:
    assert outcome_text(MISSED).endswith("measured level 11 (misses by 1 level)")
    assert outcome_text(replace(MISSED, margin=inf, unit="")).endswith("measured level 11")


def test_a_margin_of_nothing_has_no_sign() -> None:
    assert outcome_text(replace(HELD, margin=-0.0)).endswith("(margin 0 levels)")


@pytest.mark.parametrize("seed", ["0", "1"])
def test_another_process_renders_the_same_bytes(seed: str) -> None:
    program = """
from stackdsl.report.formats import report_github
from stackdsl.report.formats import report_json
from stackdsl.report.formats import report_junit
from stackdsl.report.formats import report_markdown
from stackdsl.report.check_text import report_text
from tests.stackdsl.report.reports import FULL
print(report_text(FULL), report_json(FULL))
"""
    environment = {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, check=True)
    assert done.stdout.decode("utf-8") == f"{report_text(FULL)} {report_json(FULL)}\n"


def test_a_crash_beside_failures_of_its_scenario_has_a_block_with_the_command_for_its_traceback() -> None:
    other = replace(FAILED, variant="step=12mm,thesis")
    text = report_text(report(FAILED, other, replace(CRASHED, scenario=FAILED.scenario, file=FAILED.file)))
    assert "\n  traceback STACKDSL_DEBUG=1 stackdsl run " in text
    assert "2 of 3 cases" in text
