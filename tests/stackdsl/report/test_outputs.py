"""Reports for other programs: each can be read by what reads such files, and names what failed, worst first."""

import csv
import json
import re
from dataclasses import replace
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import pytest

from stackdsl.cli.options import REPORT_FORMATS
from stackdsl.report.blocks import TextStyle
from stackdsl.report.formats import report_csv, report_github, report_json, report_junit, report_markdown
from stackdsl.results import GoldenStatus, RunStatus
from stackdsl.shown_text import data_without_commands
from stackdsl.viewing.check_report.page import index_page
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write
from tests.paths import ROOT
from tests.stackdsl.report.reports import CRASHED, FAILED, FULL, MISTAKE, PASSED, TUNED, report, with_golden

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

SCHEMA = json.loads((ROOT / "stackdsl" / "report.schema.json").read_text(encoding="utf-8"))
VARIED = replace(PASSED, parameters=(("step", "10 mm"), ("speed", "2 m/s"), ("share", "0.5"), ("kind", "kapla")))


def test_the_json_report_is_as_its_schema_says() -> None:
    validator = jsonschema.Draft202012Validator(SCHEMA)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    for seen in (FULL, report(VARIED), report(replace(PASSED, refinement=()))):
        assert list(validator.iter_errors(json.loads(report_json(seen)))) == []
    wrong = json.loads(report_json(FULL)) | {"format": 2}
    assert list(validator.iter_errors(wrong)) != []


def test_the_schema_names_every_key_of_a_result() -> None:
    (result,) = json.loads(report_json(report(VARIED)))["results"]
    assert set(SCHEMA["$defs"]["result"]["properties"]) == set(result)
    assert set(SCHEMA["properties"]) == set(json.loads(report_json(FULL)))


def test_variables_are_numbers_with_their_units() -> None:
    (result,) = json.loads(report_json(report(VARIED)))["results"]
    assert result["variables"] == {
        "step": {"written": "10 mm", "number": 10.0, "unit": "mm", "si": 0.01},
        "speed": {"written": "2 m/s", "number": 2.0, "unit": "m/s", "si": 2.0},
        "share": {"written": "0.5", "number": 0.5, "unit": "", "si": 0.5},
        "kind": {"written": "kapla", "number": None, "unit": None, "si": None},
    }


def test_a_measured_value_is_a_number_beside_its_limits(stackdsl: Stackdsl, tmp_path: Path) -> None:
    #   Two planks of 7.8 mm are 15.6 mm high.
    text = """\
scenario: two
build: [column: {levels: 2}]
expect:
  - height: 15.6 mm ± 0.2 mm
  - drift: <= 0.5 mm
  - stands: all
"""
    write(tmp_path, text)
    told = stackdsl("check", "scene.yaml", "--format", "json")
    whole = json.loads(told.out)
    assert list(jsonschema.Draft202012Validator(SCHEMA).iter_errors(whole)) == []
    height, drift, stands = (each["numbers"] for each in whole["results"][0]["expectations"])
    assert height == [
        {"value": pytest.approx(15.6), "least": pytest.approx(15.4), "most": pytest.approx(15.8), "unit": "mm"}
    ]
    assert drift == [{"value": 0.0, "least": None, "most": 0.5, "unit": "mm"}]
    assert stands == []
    again = json.loads(stackdsl("check", "scene.yaml", "--format", "json").out)
    assert again["results"][0]["expectations"] == whole["results"][0]["expectations"]


def test_a_table_of_values_has_a_column_a_variable_in_si() -> None:
    rows = list(csv.DictReader(StringIO(report_csv(report(VARIED, TUNED)))))
    assert [row["variable_step"] for row in rows] == ["0.01", ""]
    assert (rows[0]["variable_kind"], rows[0]["verdict"], rows[0]["collapse_level"]) == ("kapla", "collapses", "9")


def test_no_file_name_is_a_formula_of_a_spreadsheet() -> None:
    (row,) = csv.DictReader(StringIO(report_csv(report(replace(PASSED, file="=1+1.yaml")))))
    assert row["file"] == "./=1+1.yaml"


def test_no_text_of_an_author_is_a_command_of_github() -> None:
    told = replace(MISTAKE, message="unknown key 'a\n::stop-commands::b'")
    lines = report_github(report(diagnostics=(told,) * 12)).splitlines()
    assert not [line for line in lines if line.lstrip().startswith("::") and not line.startswith("::error")]


@pytest.mark.parametrize("reason", ["::add-mask::e", "later\\n ::add-mask::e", "##[add-mask]e"])
def test_no_text_of_an_author_is_a_command_in_what_people_read(stackdsl: Stackdsl, tmp_path: Path, reason: str) -> None:
    text = GOOD.replace("scenario: good", f'scenario: good\ndescription: "{reason}"\nskip: "{reason}"')
    write(tmp_path, text, "::add-mask::e.yaml")
    write(tmp_path, "scenario: [", "::add-mask::f.yaml")
    for command in (
        ("check", "."),
        ("check", "::add-mask::f.yaml"),
        ("explain", "::add-mask::e.yaml"),
        ("run", "::add-mask::e.yaml"),
        ("sweep", "::add-mask::e.yaml", "--out", "add-mask.jsonl"),
        ("check", "no\n::add-mask::file.yaml"),
        ("find", "no\n::add-mask::file.yaml", "--most", "levels"),
    ):
        said = stackdsl(*command).text
        assert "add-mask" in said
        assert commands_in(said) == []


def test_no_data_on_the_output_are_a_command_and_they_are_what_they_were(stackdsl: Stackdsl, tmp_path: Path) -> None:
    name = "::##[add-mask]e.yaml"
    write(tmp_path, GOOD.replace("levels: 3", "levels: ${x}"), name)
    junit, read = (stackdsl("check", name, "--format", form).out for form in ("junit", "json"))
    assert commands_in(junit) == commands_in(read) == []
    assert [case.get("name") for case in ET.fromstring(junit).iter("testcase")] == [f"{name}:3:22"]
    assert json.loads(read)["diagnostics"][0]["span"]["file"] == name
    write(tmp_path, GOOD, "::e.yaml")
    table = stackdsl("check", "::e.yaml", "--format", "csv").out
    assert commands_in(table) == []
    assert [row["file"] for row in csv.DictReader(StringIO(table))] == ["./::e.yaml"]


def test_the_later_lines_of_a_failure_in_junit_are_no_commands() -> None:
    failed = report(replace(FAILED, file="::e.yaml"))
    text = "\n".join(["<a>x", "  ::add-mask::e", "</a>"])
    assert ET.fromstring(data_without_commands(text, "junit")).text == "x\n  ::add-mask::e\n"
    shown = data_without_commands(report_junit(failed), "junit")
    assert commands_in(shown) == []
    assert ET.tostring(ET.fromstring(shown)) == ET.tostring(ET.fromstring(report_junit(failed)))


def test_the_reason_of_a_mark_is_told_in_one_line(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD + 'skip: "for now,\\nas it is"\n')
    assert "skipped: for now, as it is\n" in stackdsl("run", "scene.yaml").out
    write(tmp_path, GOOD.replace("stands: all", "height: 1 mm ± 0.1 mm") + 'xfail: "for now,\\nas it is"\n')
    (told,) = json.loads(stackdsl("check", "scene.yaml", "--format", "json").out)["results"]
    assert told["xfail"]["reason"] == "for now, as it is"


def commands_in(text: str) -> list[str]:
    """The lines that GitHub would take for workflow commands."""
    return [line for line in text.splitlines() if line.strip().startswith("::") or "##[" in line]


@pytest.mark.parametrize("form", sorted(REPORT_FORMATS))
def test_no_report_turns_its_text_or_commands_a_terminal_or_lacks_utf_8(form: str) -> None:
    odd = "".join(map(chr, (*range(9), *range(11, 32), *range(127, 160), 0x61C, 0x200B, 0x200E, 0x200F, 0x2028)))
    odd += "".join(map(chr, (0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A), 0xFEFF, 0xDFFF, 0xD800)))
    golden = replace(with_golden(GoldenStatus.DIFFERENT), file=odd)
    mistake = replace(MISTAKE, message=odd, hint=odd)
    whole = report(replace(CRASHED, message=odd, file=odd, parameters=((odd, odd),)), golden, diagnostics=(mistake,))
    shown = REPORT_FORMATS[form].render(whole, TextStyle()).replace("\r\n", "\n")
    shown.encode()
    assert sorted(set(shown) & set(odd)) == []
    if form == "json":
        assert odd in json.loads(shown)["diagnostics"][0]["message"]


HOSTILE = "\x1b[2Jgone\nok\n::error::forged\u202e"


def test_no_report_prints_a_control_character_or_command_of_a_golden_file(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "s/good.yaml")
    assert stackdsl("check", "s").code == 0
    golden = tmp_path / "golden" / "good" / "exact.json"
    for key in ('"stands"', '"L1.1"', '"stackdsl": '):
        assert key in golden.read_text()
    text = golden.read_text().replace('"stands"', json.dumps(HOSTILE)).replace('"L1.1"', json.dumps(HOSTILE))
    golden.write_text(re.sub(r'"stackdsl": "[^"]*"', lambda _: f'"stackdsl": {json.dumps(HOSTILE)}', text))
    write(tmp_path, '{"format": 1}', "golden/x\x1b[2J\n::error::y/exact.json")
    reports = {form: stackdsl("check", "s", "--format", form).out for form in REPORT_FORMATS}
    for form, told in (*reports.items(), ("review", stackdsl("golden", "review").out)):
        assert "gone" in told or form == "csv"  # rows of numbers, without the differences of golden files
        assert "\x1b[2J" not in told
        assert "\u202e" not in told
        assert not any(line.startswith(("ok", "::error::forged", "::error::y")) for line in told.splitlines())
    stackdsl("check", "s", "--html", "pages")
    page = (tmp_path / "pages" / "index.html").read_text()
    assert "gone" in page
    assert not {"\x1b", "\u202e"} & set(page)


def test_the_page_of_a_report_turns_no_text_and_has_utf_8() -> None:
    page = index_page(report(replace(CRASHED, message="a\u202eb\ud800c\x1bd")), {}, {})
    assert r"a\u202eb\ud800c\x1bd" in page
    page.encode()


def test_junit_counts_what_failed_what_crashed_and_what_is_wrong() -> None:
    root = ET.fromstring(report_junit(FULL))
    (suite,) = [suite for suite in root if suite.get("name") == "scenarios/slant.yaml"]
    counts = [suite.get(name) for name in ("tests", "failures", "errors", "skipped")]
    assert counts == ["5", "2", "1", "0"]
    assert [suite.get("name") for suite in root][-2:] == ["mistakes", "golden files"]
    failure = next(suite.iter("failure"))
    assert (failure.text or "").startswith("scenarios/slant.yaml:14:5: collapses: expected level 9")


def test_junit_is_xml_whatever_names_hold() -> None:
    hostile = replace(CRASHED, scenario="a\x00<b>&", message="\x1b[31m \ud800")
    ET.fromstring(report_junit(report(hostile)))


def test_annotations_come_worst_first_and_the_tenth_says_what_is_left() -> None:
    many = [replace(FAILED, variant=f"n={number},thesis") for number in range(12)]
    different = with_golden(GoldenStatus.DIFFERENT)
    text = report_github(report(different, *many, CRASHED, diagnostics=(MISTAKE,)))
    shown = [line for line in text.splitlines() if line.startswith("::error")]
    assert len(shown) == 10
    assert f"title={MISTAKE.code}" in shown[0]
    assert "crashed" in shown[1]
    assert "6 more findings" in shown[-1]
    assert "golden/slant/thesis.json: different" in text.splitlines()[-2]
    assert len([line for line in report_github(report(*many[:10])).splitlines() if line.startswith("::error")]) == 10


def test_a_workflow_command_holds_no_line_break_and_no_colon_in_its_properties() -> None:
    crashed = replace(CRASHED, message="two\nlines: 100 %", file="a:b,c.yaml")
    (line, _) = report_github(report(crashed)).splitlines()
    assert line.startswith("::error file=a%3Ab%2Cc.yaml,line=1,col=1,title=slant[step=11mm%2Cthesis]::")
    assert line.partition("::crashed: ")[2].startswith("two%0Alines: 100 %25; for the traceback: STACKDSL_DEBUG=1 ")


def test_a_page_of_markdown_names_failures_before_the_folded_table() -> None:
    page = report_markdown(FULL)
    assert page.index("measured level 11") < page.index("<details>")
    assert "slant\\[step=11mm,thesis\\]" in page
    assert report_markdown(report(PASSED)).count("| where |") == 0


def test_several_formats_are_written_at_once(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    asked = ["json=out/a.json", "junit=b.xml", "csv=c.csv", "markdown=d.md", "github=e.txt"]
    result = stackdsl("check", "scene.yaml", *(word for form in asked for word in ("--format", form)))
    assert (result.code, "1 passed" in result.out) == (0, True)
    assert json.loads((tmp_path / "out" / "a.json").read_text())["exit_code"] == 0
    assert ET.parse(tmp_path / "b.xml").getroot().get("tests") == "1"
    assert {"c.csv", "d.md", "e.txt"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize(
    ("formats", "told"),
    [
        (["json", "text"], "cannot both go to the standard output"),
        (["jsno"], "'jsno' is not one of 'text', 'json'"),
        (["json="], "has no file name"),
    ],
)
def test_formats_that_cannot_be_had_are_wrong_usage(
    stackdsl: Stackdsl, tmp_path: Path, formats: list[str], told: str
) -> None:
    write(tmp_path, GOOD)
    result = stackdsl("check", "scene.yaml", *(word for form in formats for word in ("--format", form)))
    assert (result.code, told in result.err) == (4, True)


def test_a_skipped_case_is_skipped_in_junit() -> None:
    skipped = replace(PASSED, status=RunStatus.SKIPPED, outcomes=(), message="not installed")
    assert ET.fromstring(report_junit(report(skipped))).get("skipped") == "1"
