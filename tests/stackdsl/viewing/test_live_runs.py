"""The data of a live page: first the preview by statics, which the played run confirms."""

import json
from textwrap import dedent
from typing import Any

import pytest

from stackdsl.checking.cases import Case, cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.viewing.live import margined, played, preview

COLUMN = """
    scenario: leaning
    build:
      - column: {{levels: {levels}, step: 12 mm}}
        every: 1 s
    systems: [exact]
    expect: [{{stands: all}}]
"""
PUSHED = """
    scenario: pushed
    build:
      - column: {levels: 2}
    impacts:
      - {after: built + 1 s, push: {brick: L2.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}}
    systems: [exact]
    expect: [{stands: all}]
"""


@pytest.fixture(autouse=True)
def no_manners(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests are no workers, and would stay behind others for good."""
    monkeypatch.setattr("os.nice", lambda more: more)


def case_of(text: str) -> Case:
    (case,), mistakes = cases_of(parse(dedent(text), "scene.yaml"))
    assert mistakes == []
    return case


def told(case: Case) -> dict[str, Any]:
    found = json.loads(preview(case))
    assert isinstance(found, dict)
    return found


def test_five_planks_are_proven_to_stand_at_once_and_the_one_with_least_room_is_named() -> None:
    run = told(case_of(COLUMN.format(levels=5)))
    assert "proven to stand" in run["verdict"]
    assert len(run["bricks"]["name"]) == 5
    # The centre of L5.1 is 4 x 12 mm beside that of L1.1, whose end is 58.8 mm away; its sides are nearer, 11.7 mm.
    assert run["bricks"]["name"][run["room"]["brick"]] == "L5.1"
    assert run["room"]["depth"] == pytest.approx(58.8 - 48.0, abs=0.1)


def test_the_tenth_plank_is_proven_to_bring_it_down_without_an_engine() -> None:
    case = case_of(COLUMN.format(levels=12))
    run = told(case)
    assert "proven to fall" in run["verdict"]
    assert run["fall"]["time"] == 9.0
    assert len(run["bricks"]["name"]) == 10
    assert run["room"] is None
    result = played(case)
    assert result.result.collapse is not None
    assert result.result.collapse.level == 10
    assert json.loads(result.json)["fall"]["bricks"]


def test_what_is_pushed_has_to_be_played() -> None:
    run = told(case_of(PUSHED))
    assert [event["kind"] for event in run["events"]] == ["placed", "frozen"]
    assert "proven to stand" in run["verdict"]


def test_margins_come_in_words() -> None:
    found = margined(case_of(COLUMN.format(levels=3)))
    assert any("it survives" in line for line in found.lines)
    assert found.weakest is not None
    assert found.weakest["text"] in found.lines
    assert any("limiting contacts of the placement error" in line for line in found.lines)


def test_a_fall_comes_with_remedies_that_were_tried_and_the_lines_they_change() -> None:
    helps = margined(case_of(COLUMN.format(levels=12))).helps
    assert [(help["text"], help["now"], help["line"]) for help in helps][:1] == [("step ≤ 9.8 mm", "now 12 mm", 4)]
    assert json.loads(preview(case_of(COLUMN.format(levels=9))))["fall"] is None
    assert margined(case_of(COLUMN.format(levels=9))).helps == []
