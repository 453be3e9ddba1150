"""`stackdsl settle` and `stackdsl pushover`: told as text, CSV, JSON, plots and pictures."""

import csv
import json
import re
from math import atan, degrees
from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# 0.3 m wide and 0.9 m high: it tips at atan(1/3), and at 1/3 g.
PIER = """
scenario: pier
brick: {size: [0.3 m, 0.4 m, 0.9 m], density: 2000 kg/m3}
friction: 0.7
build:
  - bricks: [{name: pier, on: ground}]
"""
TILTED = PIER + "supports: [{under: pier, turn: 2 deg, about: 90 deg}]\n"
SHAKEN = PIER + "loads: [{acceleration: 0.1 g, towards: 0 deg, all: true}]\n"


def test_a_block_that_slides_is_not_said_to_bear_nothing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, SHAKEN.replace("0.7", "0.2"), "pier.yaml")  # it slides at 0.2 g, twice its load, however far it is
    first_line = stackdsl("pushover", "pier.yaml").out.splitlines()[0]
    told = re.fullmatch(
        r"pier: bears (\S+) times its loads at first, and (\S+) times at a displacement of \S+ mm, "
        r"where it still slides",
        first_line,
    )
    assert told is not None, first_line
    first, last = map(float, told.groups())
    assert first == pytest.approx(0.2 * 9.81 / (0.1 * 9.80665), abs=1e-4)  # `g` is the standard one
    assert last == pytest.approx(first, rel=2e-3)  # after 4.5 m it has turned slightly


def test_settle_tells_the_tilt_at_which_a_pier_falls(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TILTED, "pier.yaml")
    told = stackdsl("settle", "pier.yaml", "--format", "json", "--plot", "plot.svg", "--picture", "pier.svg")
    assert told.code == ExitCode.OK
    (case,) = json.loads(told.out)["cases"]
    assert case["holds"] == pytest.approx(degrees(atan(1 / 3)), rel=1e-6)
    assert case["falls"] == pytest.approx(case["holds"], rel=1e-6)
    assert case["unit"] == "deg"
    assert case["why"] == "pier tips over ground"
    assert "falls when its supports have moved by more than 18.435 deg" in (tmp_path / "plot.svg").read_text("utf-8")
    picture = (tmp_path / "pier.svg").read_text("utf-8")
    assert picture.count("<title>pier</title>") == 2
    text = stackdsl("settle", "pier.yaml", "--until", "3").out
    assert text.startswith("pier: stands when its supports have moved by 6 deg")


def test_pushover_gives_the_load_factor_by_displacement(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, SHAKEN, "pier.yaml")
    told = stackdsl("pushover", "pier.yaml", "--format", "csv", "--plot", "curve.svg")
    assert told.code == ExitCode.OK
    rows = [(float(row["movement"]), float(row["load_factor"])) for row in csv.DictReader(told.out.splitlines())]
    # The centre of mass, 0.15 m beside the edge and 0.45 m above it, turns about the edge until it stands over it.
    assert rows[0][1] == pytest.approx(9.81 / 9.80665 / 3 / 0.1, rel=1e-4)
    assert rows[-1][0] == pytest.approx(150.0, rel=1e-6)
    assert rows[-1][1] == pytest.approx(0.0, abs=1e-6)
    assert "bears 3.3" in (tmp_path / "curve.svg").read_text("utf-8")


@pytest.mark.parametrize(
    ("command", "text", "words"),
    [
        ("settle", PIER, "no `supports` that move; write, for example, `supports:"),
        ("pushover", PIER, "no `loads` that are forces; write, for example, `loads:"),
        ("settle", TILTED.replace("friction: 0.7", "friction: 0.7\nworld: {tilt: 30 deg}"), "not proven to stand"),
    ],
)
def test_a_scenario_without_an_answer_is_told_why(
    stackdsl: Stackdsl, tmp_path: Path, command: str, text: str, words: str
) -> None:
    write(tmp_path, text, "pier.yaml")
    told = stackdsl(command, "pier.yaml")
    assert (told.code, told.out) == (ExitCode.USAGE, "")
    assert words in told.err
