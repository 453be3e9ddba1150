"""Nothing falls unnoticed: what nothing is expected of is no pass, and what falls before an impact is a failure."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.command_line import Stackdsl, write

# Of four planks the upper three lie 30 mm further out each, and the edge is at 58.8 mm: their weight is 1.2 mm beyond.
FALLS = "scenario: falls\nbuild:\n  - column: {levels: 4, step: 30 mm}\n    every: 1 s\n"
STANDS = "scenario: stands\nbuild:\n  - column: {levels: 2}\n"
OWN = "expect:\n  - stands: all\n"


def test_a_tower_that_falls_and_of_which_nothing_is_expected_is_no_pass(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, FALLS, "falls.yaml")
    for told in (stackdsl("check", "falls.yaml"), stackdsl("check", "falls.yaml")):  # played, and remembered
        assert told.code == 0
        assert "1 scenario, 1 case: 1 unchecked in" in told.out
        assert "falls.yaml: falls[exact]: it fell at level 4 (L4.1" in told.out
        assert (
            "why       L2.1 to L4.1 (3 bricks) tip over L1.1, towards +x, its weight 1.2 mm beyond the edge" in told.out
        )
    assert "it fell at level 4" in stackdsl("check", "falls.yaml", "-q").out


@pytest.mark.parametrize(("text", "name"), [(FALLS, "falls"), (STANDS, "stands")])
def test_strict_lets_fail_what_nothing_is_expected_of(text: str, name: str, stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, text, "a.yaml")
    stackdsl("check", "a.yaml")  # and the golden file of a pass would be remembered
    strict = stackdsl("check", "a.yaml", "--strict")
    assert strict.code == 1
    assert "1 scenario, 1 case: 1 unchecked in" in strict.out
    assert f"FAILED  {name}[exact]" in strict.out
    assert "expectations" in strict.out


def test_strict_lets_pass_what_meets_what_is_expected(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{STANDS}{OWN}", "a.yaml")
    assert "1 passed" in stackdsl("check", "a.yaml", "--strict").out


def test_a_claim_about_another_system_checks_nothing_on_this_one(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{STANDS}systems: [exact, thesis]\nexpect:\n  - {{stands: all, system: exact}}\n", "a.yaml")
    assert "1 passed, 1 unchecked" in stackdsl("check", "a.yaml").out
    assert stackdsl("check", "a.yaml", "--strict").code == 1


def test_every_report_counts_what_is_unchecked_apart(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{FALLS}---\n{STANDS}{OWN}", "a.yaml")
    reports = ("json=a.json", "junit=a.xml", "markdown=a.md", "csv=a.csv", "github=a.txt")
    stackdsl("check", "a.yaml", *(word for name in reports for word in ("--format", name)), "--html", "pages")
    told = json.loads((tmp_path / "a.json").read_text())
    assert told["conclusions"] == {"passed": 1, "unchecked": 1}
    assert {one["scenario"]: one["unchecked"] for one in told["results"]} == {"falls": True, "stands": False}
    suite = ET.parse(tmp_path / "a.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("skipped"), suite.get("failures")) == ("2", "1", "0")
    assert [one.get("value") for one in suite.iterfind("properties/property[@name='unchecked']")] == ["1"]
    assert "1 passed, 1 unchecked" in (tmp_path / "a.md").read_text()
    assert "falls,exact,exact,unchecked,collapses" in (tmp_path / "a.csv").read_text().replace("a.yaml,", "")
    assert (tmp_path / "a.txt").read_text().startswith("::warning file=a.yaml,line=1,col=1,title=falls[exact]::it fell")
    assert 'data-status="unchecked"' in (tmp_path / "pages" / "index.html").read_text()


def test_strict_is_an_error_beside_the_line_and_a_failed_test(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, STANDS, "a.yaml")
    stackdsl("check", "a.yaml", "--strict", "--format", "junit=a.xml", "--format", "github=a.txt")
    assert ET.parse(tmp_path / "a.xml").getroot().get("failures") == "1"
    assert (tmp_path / "a.txt").read_text().startswith("::error file=a.yaml,")


def test_a_wall_that_falls_before_the_throw_fails_with_its_cause(stackdsl: Stackdsl, tmp_path: Path) -> None:
    throw = "{throw: {at: level 1, from: {bearing: 90 deg, distance: 100 mm}, speed: 1 m/s}, after: built + 3 s}"
    write(tmp_path, f"{FALLS}impacts: [{throw}]\nexpect:\n  - falls: {{count: <= 5}}\n", "a.yaml")
    told = stackdsl("check", "a.yaml")
    assert told.code == 1
    assert "expected  until impact 1 (throw): that it stands" in told.out
    assert "it gave way at level 4 at 3.000 s, before impact 1 (throw) at 6 s" in told.out
    assert "why       L2.1 to L4.1 (3 bricks) tip over L1.1, towards +x" in told.out
