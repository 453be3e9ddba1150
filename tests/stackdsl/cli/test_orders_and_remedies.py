"""`stackdsl pull`, `order` and `suggest`: what a user reads of a tower, a leaning column and what needs a prop."""

import csv
import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

from stability.analysis import building_order
from stability.analysis.subset_search import Clause, SmallestSet, smallest
from stackdsl.cli.statics import order_command, suggest_command
from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

TOWER = """
scenario: tower
build:
  - jenga: {levels: 3}
expect:
  - stands: all
"""
LEANING = """
scenario: leaning
brick: kapla
build:
  - column: {levels: 3, step: 45 mm}
    every: 1 s
expect:
  - collapses: {at: level 3}
"""
PULLED = """
scenario: pulled
build:
  - every: 1 s
    bricks:
      - {name: left, at: [0 mm, 0 mm, 3.9 mm], rotate: [0, 0, 90 deg]}
      - {name: right, at: [60 mm, 0 mm, 3.9 mm], rotate: [0, 0, 90 deg]}
      - {name: lintel, on: [left, right]}
impacts:
  - remove: {brick: right}
"""
SEE_SAW = """
scenario: see-saw
brick_types:
  post: {size: [40 mm, 40 mm, 40 mm], mass: 1 kg}
  beam: {size: [300 mm, 40 mm, 20 mm], mass: 300 g}
  weight: {size: [40 mm, 40 mm, 40 mm], mass: 150 g}
build:
  - bricks:
      - {name: post, brick: post, at: [0 mm, 0 mm, 20 mm]}
      - {name: beam, brick: beam, at: [70 mm, 0 mm, 50 mm]}
      - {name: weight, brick: weight, at: [-30 mm, 0 mm, 80 mm]}
"""
SLOPE = """
scenario: slope
world: {tilt: 26.565051177077988 deg}
brick: {size: [100 mm, 100 mm, 40 mm], mass: 200 g}
friction: 0.2
build:
  - bricks: [{name: a, at: [0 mm, 0 mm, 20 mm]}]
"""


def test_a_tower_of_three_levels_gives_four_blocks(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TOWER, "tower.yaml")
    told = stackdsl("pull", "tower.yaml")
    assert told.code == ExitCode.OK
    assert "tower: 9 of 9 bricks can be pulled out, one at a time\n" in told.out
    assert "stands without  L1.1 to L2.3 (6 bricks)" in told.out
    assert "carry nothing   L3.1 to L3.3 (3 bricks)" in told.out
    assert "longest order   4 pulls after which the rest stands; proven that none is longer" in told.out
    assert "shortest fall   2 pulls (" in told.out
    found = json.loads(stackdsl("pull", "tower.yaml", "--format", "json").out)["cases"][0]
    assert (found["at_most"], found["proven"], len(found["rows"])) == (4, True, 9)


def test_a_tower_is_built_block_by_block(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TOWER, "tower.yaml")
    told = stackdsl("order", "tower.yaml")
    assert told.code == ExitCode.OK
    assert "all 9 bricks can be set down one at a time, without props" in told.out
    rows = list(csv.DictReader(stackdsl("order", "tower.yaml", "--format", "csv").out.splitlines()))
    assert [row["brick"].split(".")[0] for row in rows] == ["L1"] * 3 + ["L2"] * 3 + ["L3"] * 3


def test_check_of_a_fall_names_the_command_suggest(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, LEANING, "leaning.yaml")
    for command in ("pull", "order"):
        told = stackdsl(command, "leaning.yaml")
        assert (told.code, told.out) == (ExitCode.USAGE, "")
        assert "stackdsl suggest" in told.err


def test_a_leaning_column_is_mended_by_the_least_shift(stackdsl: Stackdsl, tmp_path: Path) -> None:
    # The two upper planks are 67.5 mm out on average, and may be 58.8 mm: 8.7 mm for both, or 17.4 mm for the top one.
    write(tmp_path, LEANING, "leaning.yaml")
    told = stackdsl("suggest", "leaning.yaml")
    assert told.code == ExitCode.OK
    assert "move L2.1 by 8.701 mm towards -x, with all bricks on it; it then just stands\n" in told.out
    assert "move L3.1 by 17.41 mm towards -x" in told.out
    assert "shift further, and measure the margin with `stackdsl survive` on the changed file\n" in told.out
    rows = json.loads(stackdsl("suggest", "leaning.yaml", "--format", "json").out)["cases"][0]["rows"]
    assert [row["kind"] for row in rows] == ["counterweight", "props", "shift", "shift"]
    assert all(row["fails_with"] <= row["amount"] for row in rows[2:])


def test_nothing_is_mended_that_stands(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TOWER, "tower.yaml")
    told = stackdsl("suggest", "tower.yaml")
    assert (told.code, told.out) == (ExitCode.OK, "")
    assert "nothing to repair" in told.err


def test_an_order_that_is_interrupted_is_told_with_what_is_proven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def asked_again(bits: int, clauses: Sequence[Clause]) -> SmallestSet:
        if clauses:
            raise KeyboardInterrupt
        return smallest(bits, clauses)

    monkeypatch.setattr(building_order, "smallest", asked_again)
    file = str(write(tmp_path, "scenario: vee\nbuild:\n  - card_house: {levels: 1, angle: 70 deg}\n"))
    found = CliRunner().invoke(order_command, [file])
    assert found.exit_code == ExitCode.INTERRUPTED
    assert "interrupted; the best result so far: 2 props so far" in found.output
    assert "no order without props exists, proven" in found.output
    told = json.loads(CliRunner().invoke(order_command, [file, "--format", "json"]).stdout)["cases"][0]
    assert (told["interrupted"], told["props"], len(told["rows"])) == (True, ["L1.2", "L1.1"], 2)


def test_suggest_mends_a_fall_after_a_removal(tmp_path: Path) -> None:
    # The middle of the lintel is 30 mm beyond that of the post that stays, and may be 11.7 mm: half a width.
    told = CliRunner().invoke(suggest_command, [str(write(tmp_path, PULLED, "pulled.yaml"))])
    assert told.exit_code == ExitCode.OK
    assert "move lintel by 18.31 mm towards -x" in told.output
    assert "permanent prop under lintel" in told.output


def test_a_limit_that_is_a_round_number_is_suggested_as_such(tmp_path: Path) -> None:
    # The middle of the beam, 300 g, is 50 mm beyond the edge of the post, that of the weight, 150 g, 50 mm before it:
    # 150 g more balance them. On a slope of 1 in 2 a brick stays from a friction of 0.5 on.
    for scenario, least in ((SEE_SAW, "    150 g on weight, at its centre\n"), (SLOPE, "    friction >= 0.5\n")):
        told = CliRunner().invoke(suggest_command, [str(write(tmp_path, scenario, "limit.yaml"))])
        assert told.exit_code == ExitCode.OK
        assert least in told.output
