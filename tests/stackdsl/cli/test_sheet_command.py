"""`stackdsl sheet`: the page of a load that a person signs has its verdict, limits, layers and order of placing."""

import re
from html import unescape
from pathlib import Path

from stackdsl.exits import ExitCode
from stackdsl.viewing.packing_sheet import _by_direction, _permitted
from tests.command_line import Stackdsl, write

HEAD = "name,length_mm,width_mm,height_mm,mass_kg,x_mm,y_mm,z_mm"
ROWS = "a,598,400,300,12,0,0,0\nb,598,400,300,12,602,0,0\nc,600,400,200.5,7.5,300,100,300\n"
SCENARIO = """\
scenario: load
description: Three <cartons> & a pallet.
friction: 0.4
build:
  - import: {file: load.csv, point: corner, deck: {size: EUR, surface: boards}}
    every: 1 s
expect:
  - stands: all
  - weight: <= LIMIT
"""


def sheet(stackdsl: Stackdsl, folder: Path, rows: str = ROWS, limit: str = "100 kg") -> tuple[int, str]:
    """The exit code and the page."""
    write(folder, f"{HEAD}\n{rows}", "load.csv")
    write(folder, SCENARIO.replace("LIMIT", limit), "load.yaml")
    told = stackdsl("sheet", "load.yaml", "-o", "load.html")
    assert "Traceback" not in told.text
    return told.code, (folder / "load.html").read_text("utf-8")


def words(page: str) -> str:
    """The text of a page without its markup."""
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]*>", " ", page.partition("</style>")[2])))


def test_a_sheet_has_all_that_a_person_signs(stackdsl: Stackdsl, tmp_path: Path) -> None:
    code, page = sheet(stackdsl, tmp_path)
    told = words(page)
    assert code == ExitCode.OK
    assert "3 cartons proven to stand; all 2 limits are met." in told
    assert "Cartons 3 in 2 layers, 31.5 kg" in told
    assert "Gross 56.5 kg, 644.5 mm high" in told
    assert "weight <= 100 kg 56.5 kg met" in told
    assert "Layer 1: 2 cartons, 24 kg" in told
    assert "3 c 2 300 100 300 600 x 400 x 200.5 7.5" in told  # number, layer, corner, size, mass
    # One end is pressed 2 mm from the middle, the other one 300 mm: 7.5 kg * 300 / 302.
    assert re.search(r"Carries most [ab]: at most 7\.45 kg", told)
    assert re.search(r"Weakest .* above [0-9.]+ g towards", told)
    assert re.search(r"load.csv \(SHA-256 [0-9a-f]{12}", told)
    assert "Checked by" in told
    assert page.count("<figure>") == 2
    assert "Three &lt;cartons&gt; &amp; a pallet." in page
    assert "http" not in page
    assert "<script" not in page


def test_a_limit_that_is_not_met_and_a_load_that_falls_are_told_first(stackdsl: Stackdsl, tmp_path: Path) -> None:
    code, page = sheet(stackdsl, tmp_path, limit="50 kg")
    assert code == ExitCode.FAILED
    assert "3 cartons proven to stand; 1 of 2 limits are not met." in words(page)
    code, page = sheet(stackdsl, tmp_path, rows=ROWS.replace("b,598,400,300,12,602", "b,598,400,300,12,925"))
    assert code == ExitCode.FAILED
    assert "Not proven to stand: b tips over deck" in words(page)
    assert '<p class="verdict failed">' in page


def test_a_sheet_is_a_page(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "scenario: s\nbuild:\n  - column: {levels: 2}\nexpect:\n  - stands: all\n", "s.yaml")
    told = stackdsl("sheet", "s.yaml", "-o", "s.pdf")
    assert told.code == ExitCode.USAGE
    assert "must end in .html" in told.err
    assert stackdsl("sheet", "s.yaml", "-o", "s.html").code == ExitCode.OK  # a load without a pallet


def test_a_sheet_of_cartons_with_a_strength_tells_how_much_of_it_they_need(stackdsl: Stackdsl, tmp_path: Path) -> None:
    strength = (
        SCENARIO.partition("build:")[0]
        + """\
brick: {size: [400 mm, 300 mm, 250 mm], mass: 12 kg, strength: {stack: 60 kg}}
build:
  - column: {levels: 5}
expect:
  - stands: all
"""
    )
    write(tmp_path, strength, "strong.yaml")
    told = stackdsl("sheet", "strong.yaml", "-o", "strong.html")
    assert told.code == ExitCode.OK
    page = words((tmp_path / "strong.html").read_text("utf-8"))
    assert "Strength the cartons need 80 % of their strength" in page  # 4 cartons of 12 kg on 60 kg
    assert "Carries most L1.1: at most 48 kg" in page


def test_limits_of_a_sheet_are_short_with_a_line_for_each_direction() -> None:
    assert _permitted("is <= 60 kg, bricks K001 K002 K003 K004 K005") == "<= 60 kg, for 5 cartons"
    assert _permitted("used_strength <= 90 %") == "used_strength <= 90 %"
    directions = [
        "forwards 0.8 g is not borne: up to 0.4 g, then a, b slide",
        "to the left 0.5 g proven",
        "backwards 0.5 g proven",
    ]
    assert _by_direction(", ".join(directions)).splitlines() == directions
