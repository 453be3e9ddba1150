"""Work limits: scenes that would take hours or all the memory are refused by counts, with their place in the file."""

import json
import os
import resource
import sys
from pathlib import Path

import click
import pytest

from stackdsl import work
from stackdsl.cli.options import ON_JOBS
from stackdsl.exits import ExitCode
from stackdsl.work import WorkError, work_factor
from tests.command_line import Stackdsl

WALL = "scenario: it\nbuild:\n  - wall: {{bricks: {0}, levels: {0}}}\n{1}"
PLACEMENT = "expect:\n  - margin: {placement: '>= 1 mm'}\n"
LATTICE = (
    "scenario: it\nbrick: {{size: [{1} mm, 90 mm, 30 mm], density: 500 kg/m3}}\nbuild:\n"
    "  - jenga: {{levels: {0}, bricks: {0}}}\nexpect:\n  - margin: {{{2}}}\n"
)
HAND = "scenario: it\nbuild:\n  - column: {levels: 1}\n    place: {speed: 0.5 mm/s}\n"
FOIL = """\
scenario: it
brick_types: {foil: {size: [100 mm, 20 mm, 0.01 mm], density: 500 kg/m3}}
brick: {size: [400 mm, 400 mm, 100 mm], density: 500 kg/m3}
build:
  - bricks: [{name: base, on: ground}, {name: foil, brick: foil, on: base}]
impacts:
  - push: {brick: base, impulse: [5 N*s, 0 N*s, 0 N*s]}
watch: 0.3 s
"""
DROPS = """\
scenario: it
build:
  - bricks:
    - repeat: {k: 1 .. 40}
      at: [0 mm, 0 mm, "${k * 20 mm}"]
      drop: true
"""
SHAKEN = "world: {shake: {acceleration: 6 m/s2, frequency: 5 Hz, for: 1000 s}}\n"


@pytest.mark.parametrize("margin", ["placement: '>= 1 mm'", "acceleration: '>= 0.1'", "tilt: '>= 1 deg'"])
def test_a_margin_of_1640_bricks_is_refused_where_it_is_claimed(
    stackdsl: Stackdsl, tmp_path: Path, margin: str
) -> None:
    (tmp_path / "it.yaml").write_text(WALL.format(40, f"expect:\n  - margin: {{{margin}}}\n"), encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    name = margin.split(":", maxsplit=1)[0]
    assert done.code == 2
    assert (
        f"it.yaml:5:5: SD206 the computation of the margin `{name}` for up to 1640 bricks takes too long; the maximum"
        in done.text
    )
    assert "use fewer bricks, or allow more work, for example with STACKDSL_WORK=4" in done.text


def test_what_falls_for_longer_than_is_allowed_is_refused_where_they_are_built(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    text = "scenario: it\nbuild:\n  - column: {levels: 8, step: 20 mm}\nexpect:\n  - falls: {count: '>= 1'}\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml", STACKDSL_WORK="0.002")
    assert done.code != 0
    assert "it.yaml:3:13: SD206" in done.text
    assert "for at least 1 s" in done.text
    assert "exceeds the limit of 4e+03" in done.text


def test_a_thousand_seconds_of_shaking_are_refused_before_they_begin(stackdsl: Stackdsl, tmp_path: Path) -> None:
    text = f"scenario: it\nbuild:\n  - column: {{levels: 5}}\n{SHAKEN}expect:\n  - stands: all\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    assert "SD206 5 bricks move at" in done.text
    assert "for at least 1e+03 s" in done.text


def test_a_margin_of_a_lattice_is_refused_by_at_how_many_points_its_bricks_touch(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    (tmp_path / "it.yaml").write_text(LATTICE.format(14, 1400, "placement: '>= 1 mm'"), encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    assert done.code == 2
    # Each of 14 bars lies on each of the 14 below, 13 times, at four points.
    assert (
        "it.yaml:6:5: SD206 the computation of the margin `placement` for up to 10192 contact points takes too long"
        in done.text
    )


@pytest.mark.parametrize("margin", ["acceleration: '>= 0.1'", "tilt: '>= 1 deg'"])
def test_a_margin_of_what_has_few_bricks_and_many_joints_is_refused(
    stackdsl: Stackdsl, tmp_path: Path, margin: str
) -> None:
    text = f"scenario: it\nbuild:\n  - tower: {{levels: 24, bricks: 24}}\nexpect:\n  - margin: {{{margin}}}\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml")
    assert done.code == ExitCode.INVALID
    name = margin.split(":", maxsplit=1)[0]
    assert f"it.yaml:5:5: SD206 the computation of the margin `{name}` for up to " in done.text
    assert "contact points takes too long; the maximum is 5000" in done.text


COUNTED = {
    "a hand on its way for minutes": (HAND, 0.01, "a hand moves a brick at 0 s, for at least 75 s"),
    "a foil on what is pushed, on an engine that needs fine steps for it": (FOIL, 0.01, "SD206 2 bricks move"),
    "a landing proven on all that landed before": (DROPS, 0.002, "SD206 "),
}


@pytest.mark.parametrize("name", COUNTED)
def test_what_no_step_of_an_engine_shows_is_counted_as_well(stackdsl: Stackdsl, tmp_path: Path, name: str) -> None:
    text, allowed_times, told = COUNTED[name]
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    system = ("--system", "pybullet-exact") if text == FOIL else ()
    done = stackdsl("check", "it.yaml", *system, STACKDSL_WORK=str(allowed_times))
    assert done.code == 2
    assert told in done.text
    assert "or allow more work, for example with STACKDSL_WORK=4" in done.text


@pytest.mark.parametrize("said", ["many", "0", "-1", "nan", "inf", "٣", ""])
def test_how_much_is_allowed_is_a_number(monkeypatch: pytest.MonkeyPatch, said: str) -> None:
    monkeypatch.setenv(work.VARIABLE, said)
    with pytest.raises(WorkError, match="STACKDSL_WORK is"):
        work_factor()


def test_sixteen_times_the_work_limit_allows_margins_of_four_times_the_bricks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    usual = work.MOST_BRICKS["placement"]
    monkeypatch.setenv(work.VARIABLE, "16")
    assert (work.most_bricks("placement"), work.most_bricks("friction")) == (4 * usual, None)


ASKED = {
    "survive": ["survive"],
    "find a tilt": ["find", "--largest", "tilt"],
    "find a number": ["find", "--least", "friction"],
    "sensitivities": ["sensitivities"],
    "order": ["order"],
    "pull": ["pull"],
    "explain": ["explain", "--margins"],
}


@pytest.mark.parametrize("asked", ASKED.values(), ids=ASKED)
def test_what_asks_statics_has_a_limit_whatever_the_command(
    stackdsl: Stackdsl, tmp_path: Path, asked: list[str]
) -> None:
    (tmp_path / "it.yaml").write_text(WALL.format(3, ""), encoding="utf-8")
    done = stackdsl(asked[0], "it.yaml", *asked[1:], STACKDSL_WORK="1e-6")
    assert done.code == ExitCode.INVALID
    (line,) = done.err.splitlines()
    assert line.startswith(f"it: `{asked[0]}` takes too much work: ")
    assert "permitted 40 units of work; " in line
    assert line.endswith("or allow more work, for example with STACKDSL_WORK=4")


def test_what_falls_and_takes_too_long_to_mend_is_refused(stackdsl: Stackdsl, tmp_path: Path) -> None:
    text = "scenario: it\nbuild:\n  - column: {levels: 30, step: 20 mm}\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("suggest", "it.yaml", "--format", "csv", STACKDSL_WORK="0.005")
    assert done.code == ExitCode.INVALID
    assert "it: `suggest` takes too much work" in done.err


def test_what_is_known_before_a_limit_is_written(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "it.yaml").write_text(WALL.format(3, ""), encoding="utf-8")
    done = stackdsl("pull", "it.yaml", "--format", "json", STACKDSL_WORK="1e-4")
    assert done.code == ExitCode.INVALID
    (case,) = json.loads(done.out)["cases"]
    assert case["case"] == "it"
    assert 0 < len(case["rows"]) < 12


def test_statics_alone_say_of_what_takes_too_much_that_it_is_not_proven(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "it.yaml").write_text(WALL.format(3, ""), encoding="utf-8")
    done = stackdsl("check", "it.yaml", "--statics", STACKDSL_WORK="1e-6")
    assert "it: not proven: the proof takes too much work" in done.out


@pytest.mark.parametrize("system", ["exact", "thesis"])
def test_what_a_run_proves_counts_as_well_as_its_steps(stackdsl: Stackdsl, tmp_path: Path, system: str) -> None:
    text = f"scenario: it\nbuild:\n  - column: {{levels: 30}}\n    every: 1 s\nsystems: [{system}]\n"
    (tmp_path / "it.yaml").write_text(text, encoding="utf-8")
    done = stackdsl("check", "it.yaml", STACKDSL_WORK="1e-5")
    assert done.code == ExitCode.INVALID
    assert "it.yaml:3:13: SD206 the proofs of 30 bricks take too much work" in done.text


def test_a_picture_of_too_many_bricks_that_cover_each_other_is_refused(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "it.yaml").write_text("scenario: it\nbuild:\n  - four_stack: {levels: 20}\n", encoding="utf-8")
    done = stackdsl("picture", "it.yaml", "-o", "it.svg", "--view", "plan", STACKDSL_WORK="0.001")
    assert done.code == ExitCode.INVALID
    assert "it[exact]: the picture takes too much work" in done.text
    assert not (tmp_path / "it.svg").exists()
    assert stackdsl("picture", "it.yaml", "-o", "it.svg", "--view", "plan").code == ExitCode.OK


def test_no_more_processes_than_two_a_core_are_started() -> None:
    (jobs,) = click.command()(ON_JOBS(lambda: None)).params
    assert jobs.type.convert(10**6, jobs, None) == 2 * (os.cpu_count() or 1)


ISSUE = {
    "placement of 40 x 40": WALL.format(40, PLACEMENT),
    "placement of 20 x 20": WALL.format(20, PLACEMENT),
    "column of 1000": "scenario: it\nbuild:\n  - column: {levels: 1000, step: 20 mm}\n",
    "leaning 1000": "scenario: it\nbuild:\n  - leaning_structure: {levels: 1000}\n",
    "throw at 30 x 30": WALL.format(30, "impacts:\n  - throw: {at: L15.15, from: {bearing: 90 deg}, speed: 5 m/s}\n"),
    "shaken 1000 s": f"scenario: it\nbuild:\n  - column: {{levels: 5}}\n{SHAKEN}",
    "500 drops": DROPS.replace("40", "500"),
    "a hand at 0.01 mm/s": HAND.replace("0.5 mm", "0.01 mm"),
    "a move at 1 mm/s": (
        "scenario: it\nbuild:\n  - column: {levels: 5}\n"
        "impacts:\n  - move: {brick: L5.1, by: [200 mm, 0 mm, 0 mm], speed: 1 mm/s, slid: true}\n"
    ),
    "a day on tuned": "scenario: it\nbuild:\n  - column: {levels: 5}\nwatch: 86400 s\nsystems: [tuned]\n",
    "a foil": FOIL,
    "a lattice": LATTICE.format(11, 1100, "placement: '>= 1 mm'"),
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
