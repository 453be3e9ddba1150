"""What a report says to programs."""

import json
from dataclasses import replace
from math import inf, nan

import pytest

from stackdsl.report.formats import report_json
from tests.stackdsl.report.reports import FULL, HELD, PASSED, report


def test_the_json_report_holds_all_that_the_report_holds() -> None:
    whole = json.loads(report_json(FULL))
    assert (whole["format"], whole["exit_code"], whole["interrupted"], whole["wall_time_s"]) == (1, 130, True, 12.34)
    assert whole["conclusions"] == {"passed": 2, "failed": 1, "crashed": 1, "golden different": 1}
    assert (whole["obsolete"], whole["removed"]) == (["golden/gone/x.json"], ["golden/old/x.json"])
    assert whole["diagnostics"][0]["span"] == {
        "file": "scenarios/slant.yaml",
        "line": 14,
        "column": 5,
        "end_column": 14,
    }
    first = whole["results"][0]
    assert (first["scenario"], first["system"], first["status"]) == ("slant", "thesis", "done")
    assert first["speed_up"] == pytest.approx(3.0)
    assert first["collapse"] == {
        "time_s": 8.25,
        "level": 9,
        "brick": "L9.1",
        "gave_way": "L1.1",
        "step": None,
        "broke_at_level": None,
    }
    assert first["cost"] == {
        "wall_time_s": 2.0,
        "simulated_time_s": 10.0,
        "steps": 9600,
        "judgements": 120,
        "proofs": {"load core": 8},
        "one_by_one": 0,
        "update_median_s": 0.002,
        "update_worst_s": 0.25,
    }
    assert (first["truths"][0]["passed"], first["truths"][0]["margin_unit"]) == (False, "levels")
    assert whole["results"][3]["message"] == "the worker was killed by SIGSEGV"
    assert whole["results"][4]["golden"]["differences"][0]["tolerance"] == "± 0.5 mm"


def test_the_json_report_has_sorted_keys_and_no_number_that_json_lacks() -> None:
    odd = replace(PASSED, drift=nan, outcomes=(replace(HELD, margin=inf),))
    text = report_json(report(odd))
    whole = json.loads(text, parse_constant=pytest.fail)
    assert (whole["results"][0]["drift_m"], whole["results"][0]["expectations"][0]["margin"]) == (None, None)
    assert text == json.dumps(whole, indent=2, sort_keys=True) + "\n"
