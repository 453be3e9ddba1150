"""Why a run failed, as people and programs read it."""

import json
from dataclasses import replace

from stackdsl.report.check_text import report_text
from stackdsl.report.formats import ranked_failures, report_json
from stackdsl.report.text import why_lines
from stackdsl.results import FailureCause, Report
from tests.stackdsl.report.reports import FAILED

WHY = FailureCause(
    cause="L2.1 and L3.1 tip over L1.1",
    moving=("L2.1", "L3.1"),
    bearing=3.141592653589793,
    overhang=0.0012,
    before="impact 7, remove at slant.yaml:9:5: L8.1 pulled out at 12 s",
    first="L2.1 had sunk 4.1 mm at 12.167 s",
    see="stackdsl explain slant.yaml -k 'slant[exact]'",
)


def test_a_failure_tells_cause_action_first_and_how_to_see_it() -> None:
    assert list(why_lines(WHY)) == [
        "  why       L2.1 and L3.1 tip over L1.1, towards -x, its weight 1.2 mm beyond the edge",
        "  after     impact 7, remove at slant.yaml:9:5: L8.1 pulled out at 12 s",
        "  first     L2.1 had sunk 4.1 mm at 12.167 s",
        "  see it    stackdsl explain slant.yaml -k 'slant[exact]'",
    ]


def test_an_unknown_cause_has_no_line() -> None:
    assert list(why_lines(FailureCause(first="a had sunk 5 mm at 1 s"))) == ["  first     a had sunk 5 mm at 1 s"]


def test_a_side_along_no_axis_is_told_in_degrees() -> None:
    assert list(why_lines(FailureCause(cause="a slides on ground", bearing=0.6))) == [
        "  why       a slides on ground, towards 34.4 deg"
    ]


def test_the_cause_stands_once_below_all_failures_of_a_run() -> None:
    twice = replace(FAILED, why=WHY, outcomes=(*FAILED.outcomes, *FAILED.outcomes))
    labels = [line.split()[0] for line in report_text(Report((twice,))).splitlines() if line.startswith("  ")]
    assert labels == ["expected", "measured", "also", "why", "after", "first", "see"]


def test_programs_are_told_numbers_and_every_name() -> None:
    (result,) = json.loads(report_json(Report((replace(FAILED, why=WHY),))))["results"]
    assert result["why"] == {
        "cause": "L2.1 and L3.1 tip over L1.1",
        "moving": ["L2.1", "L3.1"],
        "bearing_rad": 3.141592653589793,
        "overhang_m": 0.0012,
        "action_before": "impact 7, remove at slant.yaml:9:5: L8.1 pulled out at 12 s",
        "moved_first": "L2.1 had sunk 4.1 mm at 12.167 s",
        "see": "stackdsl explain slant.yaml -k 'slant[exact]'",
    }


def test_outputs_of_one_line_a_failure_tell_the_cause_in_it() -> None:
    (found,) = ranked_failures(Report((replace(FAILED, why=WHY),)))
    assert found.text.endswith(
        "(misses by 1 level); L2.1 and L3.1 tip over L1.1, towards -x, its weight 1.2 mm beyond the edge"
    )
