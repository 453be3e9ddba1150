"""`stackdsl find`: with which number a scenario just stands, told as text, CSV and JSON."""

import csv
import json
import re
from math import atan, degrees
from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# A column of N planks of 117.6 mm, each shifted by d, stands while N d is at most that.
COLUMN = """
scenario: leaning
matrix: {step: [12 mm, 14 mm], kind: [kapla]}
let: {count: 12, half: "${step / 2}", wait: 1 s}
brick: ${kind}
build:
  - column: {levels: "${count}", step: "${2 * half}"}
    every: ${wait}
expect:
  - collapses: any
"""
# What is thrown is no part of what is asked: the column by itself stands however far it is thrown from.
THROWN = """
scenario: thrown-at
let: {far: 300 mm}
build:
  - column: {levels: 2}
impacts:
  - throw: {at: L2.1, from: {bearing: 90 deg, distance: "${far}"}, speed: 1 m/s}
expect:
  - stands: {levels: 1}
"""


def sides(text: str, pattern: str) -> list[float]:
    """The numbers of a line."""
    found = re.search(pattern, text)
    assert found is not None, text
    return [float(each) for each in found.groups()]


def test_find_prints_both_sides_of_the_limit(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, COLUMN, "leaning.yaml")
    told = stackdsl("find", "leaning.yaml", "--largest", "step", "--most", "count", "-k", "step=14mm")
    assert told.code == ExitCode.OK
    lines = [line.strip() for line in told.out.splitlines()]
    # The step is no part of the name. A shown side of a limit lies on that side.
    assert lines[0] == (
        "leaning[kind=kapla]: largest step 9.799 mm stands, 9.801 mm falls; leaning.yaml:3:16 has 14 mm"
    )
    assert lines[1] == "falls      L2.1 to L12.1 (11 bricks) tip over L1.1"
    assert "; the limit is 9.800000 mm to 7 digits" in lines[3]
    assert any("most count 8 stands, 9 falls" in line for line in lines)  # 117.6 mm / 14 mm


def test_a_variable_that_is_worked_out_is_set_apart_from_the_others(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, COLUMN, "leaning.yaml")
    told = json.loads(stackdsl("find", "leaning.yaml", "--largest", "half", "--format", "json", "-k", "step=12mm").out)
    (found,) = told["found"]
    assert found["stands"] == pytest.approx(4.9, rel=1e-6)
    assert found["stands_si"] == pytest.approx(0.0049, rel=1e-6)
    assert (found["end"], found["unit"], found["contradicting"]) == ("limit", "mm", [])


def test_a_limit_is_a_row_of_a_table(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, COLUMN.replace("step: [12 mm, 14 mm]", "step: [3 mm]"), "leaning.yaml")
    out = stackdsl("find", "leaning.yaml", "--largest", "step", "--largest", "tilt", "--format", "csv").out
    step, tilt = csv.DictReader(out.splitlines())
    assert float(step["stands"]) == pytest.approx(9.8, rel=1e-6)
    # Twelve planks of 7.8 mm are 93.6 mm high, and tip over their long side, 23.4 mm wide.
    assert float(tilt["stands"]) == pytest.approx(degrees(atan(23.4 / 93.6)), rel=1e-6)
    assert float(tilt["stands_si"]) == pytest.approx(atan(0.25), rel=1e-6)
    assert (step["by_program"], tilt["by_program"]) == ("False", "True")


def test_along_a_bearing_it_tips_over_its_other_side(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, COLUMN.replace("step: [12 mm, 14 mm]", "step: [0 mm]"), "leaning.yaml")
    told = stackdsl("find", "leaning.yaml", "--largest", "acceleration", "--bearing", "180 deg").out
    assert sides(told, "acceleration (.+) g stands, (.+) g falls") == [0.4999, 0.5001]  # it slides before


def test_find_refuses_a_name_of_no_number_with_the_reason(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, COLUMN, "leaning.yaml")
    refused = stackdsl("find", "leaning.yaml", "--largest", "stepp", "--largest", "kind")
    assert refused.code == ExitCode.USAGE
    assert "leaning[step=12 mm,kind=kapla]: unknown number 'stepp'; did you mean 'step'?" in refused.err
    assert "'kind' is the word 'kapla'; only a number has a limit" in refused.err
    assert "no number to find; add, for example, --largest step" in stackdsl("find", "leaning.yaml").err


def test_nothing_is_asked_of_what_is_thrown(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, THROWN, "thrown.yaml")
    told = stackdsl("find", "thrown.yaml", "--largest", "far")
    assert told.code == ExitCode.USAGE
    assert "`far` changes nothing before the first action that needs an engine" in told.err
    assert "`matrix: {far: [1, 2, 3]}`" in told.err


@pytest.mark.parametrize(
    "asked",
    [
        ("find", "--largest", "step", "--within"),
        ("survive", "--accuracy"),
        ("picture", "-o", "a.svg", "--at"),
        ("picture", "-o", "a.gif", "--slower"),
        ("import", "--friction"),
    ],
)
def test_find_refuses_a_range_that_is_no_number(stackdsl: Stackdsl, tmp_path: Path, asked: tuple[str, ...]) -> None:
    write(tmp_path, COLUMN, "leaning.yaml")
    command, *options = asked
    refused = stackdsl(command, "leaning.yaml", *options, "nan")
    assert refused.code == ExitCode.USAGE
    assert "'nan' is not a finite number" in refused.err
