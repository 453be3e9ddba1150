"""`stackdsl survive`: what a structure survives by bearing, told as text, CSV, JSON and a picture."""

import csv
import json
import re
from math import atan, degrees
from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# 0.3 x 0.2 x 0.5 m: it tips over its sides at 0.6 g along x and at 0.4 g along y, and slides at 0.5 g.
TALL = """
# One tall carton.
scenario: tall
world: {ground: {friction: 0.5}}
build:
  - bricks: [{name: carton, at: [0 m, 0 m, 0.25 m], brick: {size: [0.3 m, 0.2 m, 0.5 m], mass: 4 kg}}]
expect:
  - stands: all
"""
FALLS = TALL.replace(
    "expect:", "  - bricks: [{at: [0.16 m, 0 m, 0.55 m], brick: {size: [0.3 m, 0.2 m, 0.1 m], mass: 9 kg}}]\nexpect:"
)


def test_survive_finds_tipping_along_y_and_sliding_along_x(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TALL, "tall.yaml")
    told = stackdsl("survive", "tall.yaml")
    assert told.code == ExitCode.OK
    lines = told.out.splitlines()
    assert lines[0] == f"tall survives 0.399 g in every direction, a tilt of {degrees(atan(0.4)):.3g} deg"
    rows = [re.split(r" {2,}", line.strip()) for line in lines[3:6]]
    assert rows[0] == ["90 deg (+y)", "0.399 g", "carton tips over ground"]
    assert [row[2] for row in rows[1:]] == ["as towards 90 deg (+y)", "carton slides on ground"]
    assert rows[2][1] == "0.496 to 0.499 g"  # to within 1 %


def test_survive_prints_a_row_for_each_bearing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TALL, "tall.yaml")
    rows = list(csv.DictReader(stackdsl("survive", "tall.yaml", "--bearings", "8", "--format", "csv").out.splitlines()))
    assert [float(row["bearing_deg"]) for row in rows] == [45.0 * k for k in range(8)]
    # Along the diagonal its side is reached at 0.4 g across it, which is more than 0.5 g along.
    assert [float(row["survives_g"]) for row in rows] == pytest.approx([0.5, 0.5, 0.4, 0.5] * 2, rel=1e-2)
    assert all(float(row["survives_g"]) <= float(row["fails_g"]) for row in rows)
    told = json.loads(stackdsl("survive", "tall.yaml", "--bearings", "8", "--format", "json").out)
    assert told["cases"][0]["survives_g"] == pytest.approx(0.4, rel=1e-6)
    assert len(told["cases"][0]["bearings"]) == 8


def test_survive_of_a_falling_structure_says_that_it_does_not_stand(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, FALLS, "falls.yaml")
    told = stackdsl("survive", "falls.yaml")
    assert (told.code, told.out) == (ExitCode.USAGE, "")
    assert "UNSTABLE" in told.err
    assert "only a stable structure has margins; `stackdsl suggest` searches for repairs" in told.err


def test_survive_plots_the_weakest_direction_at_its_bearing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TALL, "tall.yaml")
    refused = stackdsl("survive", "tall.yaml", "--plot", "tall.txt")
    assert "tall.txt: the file name must end in .svg or .png" in refused.err
    assert stackdsl("survive", "tall.yaml", "--bearings", "8", "--plot", "tall.svg").code == ExitCode.OK
    drawn = (tmp_path / "tall.svg").read_text(encoding="utf-8")
    assert "survives 0.399 g in every direction" in drawn
    assert drawn.count("<polygon") == 1


@pytest.mark.parametrize("margin", ['acceleration: ">= 0.3"', f'tilt: ">= {degrees(atan(0.3))} deg"'])
def test_survive_plots_the_limit_that_the_scenario_expects(stackdsl: Stackdsl, tmp_path: Path, margin: str) -> None:
    write(tmp_path, TALL.replace("- stands: all", f"- margin: {{{margin}}}"), "tall.yaml")
    assert stackdsl("survive", "tall.yaml", "--bearings", "8", "--plot", "tall.svg").code == ExitCode.OK
    assert ">expected: 0.3 g<" in (tmp_path / "tall.svg").read_text(encoding="utf-8")
    write(tmp_path, TALL.replace("- stands: all", '- margin: {tilt: "<= 40 deg"}'), "tall.yaml")
    assert stackdsl("survive", "tall.yaml", "--bearings", "8", "--plot", "tall.svg").code == ExitCode.OK
    assert "expected" not in (tmp_path / "tall.svg").read_text(encoding="utf-8")


IF_NOTHING_SLIDES = "If no brick slides on the one below, tipping begins above"
# Two cartons of 0.4 x 0.3 x 0.5 m on each other: the pair slides at 0.2 g, and tips at g * 0.15 m / 0.5 m = 0.3 g.
PAIR = """
scenario: pair
friction: 0.6
world: {ground: {friction: 0.2}}
build:
  - bricks:
      - {name: low, at: [0 m, 0 m, 0.25 m], brick: {size: [0.4 m, 0.3 m, 0.5 m], mass: 4 kg}}
      - {name: top, at: [0 m, 0 m, 0.75 m], brick: {size: [0.4 m, 0.3 m, 0.5 m], mass: 4 kg}}
expect:
  - margin: {acceleration: ">= 0.25 g"}
"""


def test_a_load_that_slides_as_a_whole_names_its_support_and_what_would_tip(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, PAIR, "pair.yaml")
    lines = stackdsl("survive", "pair.yaml").out.splitlines()
    assert lines[0].startswith("pair survives 0.199 g in every direction")
    assert re.split(r" {2,}", lines[3].strip())[2] == "both bricks slide on ground (coefficient of friction 0.2)"
    tips = re.fullmatch(f"  {IF_NOTHING_SLIDES} (\\S+) g towards (\\d+) deg .*: (.*)\\.", lines[5])
    assert tips is not None
    assert float(tips[1]) == pytest.approx(0.15 / 0.5, rel=1e-3)
    assert int(tips[2]) in {90, 270}
    assert tips[3] == "both bricks tip over ground"
    failed = stackdsl("check", "pair.yaml", "--no-golden").out
    assert "weakest: above 0.2 g" in failed
    assert "both bricks slide on ground (coefficient of friction 0.2)" in failed


def test_a_load_that_slides_in_part_names_the_part(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, PAIR.replace("friction: 0.6", "friction: 0.1"), "pair.yaml")
    told = stackdsl("survive", "pair.yaml").out
    assert "top slides on low" in told
    assert IF_NOTHING_SLIDES not in told


def test_neighbours_that_would_tip_do_not_hold_each_other(stackdsl: Stackdsl, tmp_path: Path) -> None:
    # Beside each other along y, each tips as if it were alone, at g * 0.15 m / 0.25 m = 0.6 g, and not as a pair.
    beside = PAIR.replace("[0 m, 0 m, 0.75 m]", "[0 m, 0.3 m, 0.25 m]").replace("[0.4 m, 0.3 m", "[1 m, 0.3 m")
    write(tmp_path, beside, "pair.yaml")
    (line,) = [line for line in stackdsl("survive", "pair.yaml").out.splitlines() if IF_NOTHING_SLIDES in line]
    tips = re.search(rf"{IF_NOTHING_SLIDES} (\S+) g", line)
    assert tips is not None
    assert float(tips[1]) == pytest.approx(0.15 / 0.25, rel=1e-3)


# Two blocks, 0.2 m thick along x and 0.6 m high, face to face, friction 0.8. Alone each tips at g * 0.1 / 0.3. Pulled
# along +x together, `left` presses with N at the height z on `right`, which is lifted by 0.8 N at this face:
#   left tips: 0.3 a = 0.1 + N z; right tips: 0.3 a + N z = 0.1 + 0.2 * 0.8 N; so z = 0.08
#   right slides: a + N = 0.8 (1 + 0.8 N); so N = (0.8 - a) / 0.36, in weights of a block
BLOCKS = """
scenario: blocks
friction: 0.8
build:
  - bricks:
      - {name: left, at: [-0.1 m, 0 m, 0.3 m], brick: {size: [0.2 m, 0.6 m, 0.6 m], mass: 4 kg}}
      - {name: right, at: [0.1 m, 0 m, 0.3 m], brick: {size: [0.2 m, 0.6 m, 0.6 m], mass: 4 kg}}
expect:
  - stands: all
  - margin: {acceleration: ">= 0.4 g"}
"""
TOUCHING, ALONE = (0.1 + 0.08 * 0.8 / 0.36) / (0.3 + 0.08 / 0.36), 0.1 / 0.3
ADDED = "with friction between neighbours that touch; 0.333 g without it"


def test_friction_between_neighbours_that_touch_is_told_with_the_number_without_it(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, BLOCKS, "blocks.yaml")
    assert re.fullmatch(
        f"  {ADDED}: .*(left|right).* tips? over ground.*", stackdsl("survive", "blocks.yaml").out.splitlines()[1]
    )
    (case,) = json.loads(stackdsl("survive", "blocks.yaml", "--format", "json").out)["cases"]
    assert case["survives_g"] == pytest.approx(TOUCHING, rel=1e-5)
    assert case["without_neighbours_g"] == pytest.approx(ALONE, rel=1e-5)
    assert f"measured acceleration {TOUCHING:.4g} g, {ADDED}" in stackdsl("run", "blocks.yaml").out
    warned = " ".join(stackdsl("check", "blocks.yaml", "--no-golden").out.split())
    assert "the margin is met only with friction between neighbours that touch; without" in warned
    assert "above 0.333 g, " in warned


def test_neighbours_2_mm_apart_do_not_help(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, BLOCKS.replace("[0.1 m, 0 m", "[0.102 m, 0 m"), "blocks.yaml")
    (case,) = json.loads(stackdsl("survive", "blocks.yaml", "--format", "json").out)["cases"]
    assert case["survives_g"] == pytest.approx(ALONE, rel=1e-5)
    assert case["without_neighbours_g"] is None
    assert "neighbours" not in stackdsl("survive", "blocks.yaml").out


# The centre of `plank`, of the weight W, is 0.1 m beyond the edge of `post`. Its end, 0.6 m from this edge and at most
# 0.2 m above it, leans against `tower` with N <= 0.4 W, which friction on `post` balances. Without friction there, the
# moment is at most 0.4 W * 0.2 m < W * 0.1 m, so it falls. With friction, N * (0.2 m + 0.4 * 0.6 m) holds it.
PLANK = """
scenario: plank
friction: 0.4
build:
  - bricks:
      - {name: post, at: [0.2 m, 0 m, 0.1 m], brick: {size: [0.4 m, 0.4 m, 0.2 m], mass: 40 kg}}
      - {name: tower, at: [1.3 m, 0 m, 0.3 m], brick: {size: [0.6 m, 0.4 m, 0.6 m], mass: 80 kg}}
      - {name: plank, at: [0.5 m, 0 m, 0.3 m], brick: {size: [1 m, 0.4 m, 0.2 m], mass: 5 kg}}
expect:
  - stands: all
"""
HELD = "it stands only with friction between neighbours that touch: without it, plank "


def test_a_load_that_only_friction_between_neighbours_holds_is_told_to_fall_without_it(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, PLANK, "plank.yaml")
    checked = stackdsl("check", "plank.yaml", "--no-golden")
    assert checked.code == ExitCode.OK
    assert HELD in " ".join(checked.out.split())
    for command in ("run", "survive", "explain", "suggest"):
        assert HELD in " ".join(stackdsl(command, "plank.yaml").out.split()), command
    (case,) = json.loads(stackdsl("survive", "plank.yaml", "--format", "json").out)["cases"]
    assert case["without_neighbours_g"] == 0.0


def test_an_arch_is_not_told_to_need_friction_between_its_stones(stackdsl: Stackdsl, tmp_path: Path) -> None:
    arch = "arch: {span: 600 mm, rise: 120 mm, thickness: 80 mm, voussoirs: 11, abutment: 600 mm}"
    write(tmp_path, f"scenario: arch\nfriction: 0.7\nbuild:\n  - {arch}\nexpect:\n  - stands: all\n", "arch.yaml")
    checked = stackdsl("check", "arch.yaml", "--no-golden")
    assert checked.code == ExitCode.OK, checked.out
    assert "only with friction" not in checked.out + stackdsl("survive", "arch.yaml").out


def test_suggest_of_a_load_that_stands_tells_which_margin_it_misses(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, PAIR, "pair.yaml")
    lines = stackdsl("suggest", "pair.yaml").out.splitlines()
    assert lines[:2] == ["pair is proven to stand, but misses a margin:", "  measured acceleration 0.2 g"]
    assert lines[3] == "  to slide only above 0.25 g, it needs a coefficient of friction of more than 0.25"
    write(tmp_path, PAIR.replace("0.25 g", "0.35 g"), "pair.yaml")
    lines = stackdsl("suggest", "pair.yaml").out.splitlines()
    assert lines[4].startswith("  tipping begins above 0.3 g, however good the friction is: ")
    assert lines[6].endswith("the centre of what tips must be 14 % lower:")  # 0.3 / 0.35 of its height


# The ground brakes with 0.29 g for 1 s. Friction takes the pair along with 0.2 g, so it falls behind with 0.09 g: it
# slides by 0.09 g * (1 s)^2 / 2 in this time, and then by (0.09 g * 1 s)^2 / (2 * 0.2 g) until it is at rest.
SLIDES = 1000.0 * 9.81 * (0.09 / 2.0 + 0.09**2 / 0.4)  # [mm]
BRAKED = PAIR.replace("world: {", "world: {shake: {bearing: 0 deg, table: [[0 s, 0.29 g], [1 s, 0.29 g]]}, ").replace(
    'margin: {acceleration: ">= 0.25 g"}', "stands: all"
)


def test_a_load_that_slides_as_a_whole_and_stands_is_told_how_far_it_slid(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, BRAKED, "pair.yaml")
    told = stackdsl("check", "pair.yaml", "--no-golden")
    assert told.code == ExitCode.OK
    slid = re.search(r"the whole structure slid by (\d+) mm", " ".join(told.out.split()))
    assert slid is not None
    assert int(slid[1]) == pytest.approx(SLIDES, rel=0.02)
    write(tmp_path, BRAKED + '  - drift: "<= 10 mm"\n', "pair.yaml")
    failed = stackdsl("check", "pair.yaml", "--no-golden").out
    assert "the whole structure slid" not in failed
    assert "statics prove that it stands" not in failed
    assert "none of the bricks fell, and 2 of them shifted" in failed
