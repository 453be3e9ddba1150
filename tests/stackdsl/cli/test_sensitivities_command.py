"""`stackdsl sensitivities`: on what the margin of a structure depends most."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from stackdsl.cli.statics import sensitivities_command
from stackdsl.exits import ExitCode
from stackdsl.studies import sensitivities
from stackdsl.studies.sensitivities import Effect
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# A block 0.1 m high, 40 mm from the end of what it lies on, turns about that end at 0.8 g, and slides at 2 g.
TWO = """
scenario: shelf
matrix: {out: [60 mm, 110 mm]}
friction: 2
build:
  - bricks:
      - {name: shelf, at: [0 mm, 0 mm, 10 mm], brick: {size: [200 mm, 300 mm, 20 mm], mass: 9 kg}}
      - {name: block, at: ["${out}", 0 mm, 70 mm], brick: {size: [100 mm, 120 mm, 100 mm], mass: 1 kg}}
"""


def test_an_interrupted_study_shows_the_numbers_that_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_self: object, _number: object, _effect: object) -> Effect:
        raise KeyboardInterrupt

    monkeypatch.setattr(sensitivities._Margins, "checked", interrupted)  # the first check
    found = CliRunner().invoke(sensitivities_command, [str(write(tmp_path, TWO.replace(", 110 mm", "")))])
    assert found.exit_code == ExitCode.INTERRUPTED
    assert "-0.02 g/mm" in found.output
    assert "interrupted: 0 numbers left out, 10 checks not made" in found.output


def test_the_place_that_matters_is_told_and_why_what_falls_has_none(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TWO, "shelf.yaml")
    told = stackdsl("sensitivities", "shelf.yaml", "--check", "1", "--format", "json")
    assert told.code == ExitCode.OK
    assert "shelf[out=110 mm]: UNSTABLE: block tips over shelf; only a stable structure has margins" in told.err
    (case,) = json.loads(told.out)["cases"]
    assert case["case"] == "shelf[out=60 mm]"
    assert case["margin"] == pytest.approx(40.0 / 50.0, rel=1e-6)
    shelf, out, block = case["effects"][:3]
    assert {out["what"], block["what"]} == {"out", "x of block"}
    assert shelf["what"] == "x of shelf"  # which is the longest
    assert (shelf["source"], shelf["kink"]) == ("checked", False)
    assert [shelf["more"], out["more"], block["more"]] == pytest.approx([0.02, -0.02, -0.02], rel=1e-4)  # g by a mm
