"""What would take hours, or all the memory, is refused by counts before it begins, with its place in the file."""

import resource
import sys
from pathlib import Path

import pytest

from stackdsl import work
from stackdsl.work import WorkError, allowed
from tests.command_line import Stackdsl

WALL = "scenario: it\nbuild:\n  - wall: {{bricks: {0}, levels: {0}}}\n{1}"
PLACEMENT = "expect:\n  - margin: {placement: '>= 1 mm'}\n"
SHAKEN = "world: {shake: {acceleration: 6 m/s2, frequency: 5 Hz, for: 1000 s}}\n"


@pytest.mark.parametrize("margin", ["placement: '>= 1 mm'", "acceleration: '>= 0.1'", "tilt: '>= 1 deg'"])
def test_a_margin_of_1640_bricks_is_refused_where_it_is_claimed(
    stackdsl: Stackdsl, tmp_path: Path, margin: str
) -> None:
    (tmp_path / "it.yaml").write_text(WALL.format(40, f"expect:\n  - margin: {{{margin}}}\n"), encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    name = margin.split(":", maxsplit=1)[0]
    assert done.code == 2
    assert f"it.yaml:5:5: SD206 the margin `{name}` of up to 1640 bricks takes too much, and" in done.text
    assert "build less, or allow more by STACKDSL_WORK" in done.text


def test_what_falls_for_longer_than_is_allowed_is_refused_where_they_are_built(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    text = "scenario: it\nbuild:\n  - column: {levels: 8, step: 20 mm}\nexpect:\n  - falls: {count: '>= 1'}\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml", STACKDSL_WORK="0.01")
    assert done.code != 0
    assert "it.yaml:3:13: SD206" in done.text
    assert "for 1 s and more" in done.text
    assert "4e+03 are allowed" in done.text


def test_a_thousand_seconds_of_shaking_are_refused_before_they_begin(stackdsl: Stackdsl, tmp_path: Path) -> None:
    text = f"scenario: it\nbuild:\n  - column: {{levels: 5}}\n{SHAKEN}expect:\n  - stands: all\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    assert "SD206 5 bricks move at" in done.text
    assert "for 1e+03 s and more" in done.text


@pytest.mark.parametrize("said", ["many", "0", "-1", "nan", "inf", "٣", ""])
def test_how_much_is_allowed_is_a_number(monkeypatch: pytest.MonkeyPatch, said: str) -> None:
    monkeypatch.setenv(work.VARIABLE, said)
    with pytest.raises(WorkError, match="STACKDSL_WORK is"):
        allowed()


def test_who_allows_sixteen_times_as_much_may_ask_for_margins_of_four_times_the_bricks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    usual = work.MOST_BRICKS["placement"]
    monkeypatch.setenv(work.VARIABLE, "16")
    assert (work.most_bricks("placement"), work.most_bricks("friction")) == (4 * usual, None)


ISSUE = {
    "placement of 40 x 40": WALL.format(40, PLACEMENT),
    "placement of 20 x 20": WALL.format(20, PLACEMENT),
    "column of 1000": "scenario: it\nbuild:\n  - column: {levels: 1000, step: 20 mm}\n",
    "leaning 1000": "scenario: it\nbuild:\n  - leaning_structure: {levels: 1000}\n",
    "throw at 30 x 30": WALL.format(30, "impacts:\n  - throw: {at: L15.15, from: {bearing: 90 deg}, speed: 5 m/s}\n"),
    "shaken 1000 s": f"scenario: it\nbuild:\n  - column: {{levels: 5}}\n{SHAKEN}",
    "acceleration of 40 x 40": WALL.format(40, "expect:\n  - margin: {acceleration: '>= 0.1'}\n"),
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is told in kB on Linux")
@pytest.mark.parametrize("name", ISSUE)
def test_inputs_of_a_few_lines_cost_seconds_and_little_memory(stackdsl: Stackdsl, tmp_path: Path, name: str) -> None:
    (tmp_path / "it.yaml").write_text(ISSUE[name], encoding="utf-8")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    stackdsl("check", "it.yaml")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 60.0  # 20 s on a machine of its own
    assert after.ru_maxrss < 500_000
