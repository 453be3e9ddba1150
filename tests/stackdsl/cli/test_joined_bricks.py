"""Scenarios with joints: verdicts, load factors and proven collapses, as the commands print them."""

import json
from pathlib import Path

import pytest

from stability.problem import Stability
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.exits import ExitCode
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.trace import BrickState
from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.scenes import compiled

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# Three blocks of 0.2 kg glued end to end out of a wall: tension w h^2 / (9 W L) = 7.0789 at 0.1 MPa.
CORBEL = """\
scenario: corbel
brick_types:
  block: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
brick: block
world:
  walls: [{bearing: 180 deg, distance: 0 m}]
joints:
  - bond: {tension: 0.1 MPa, cohesion: 2 MPa}
build:
  - bricks:
      - {at: [100 mm, 0 mm, 1 m], name: a}
      - {beside: a, towards: 0 deg, name: b}
      - {beside: b, towards: 0 deg, name: c}
    every: 1 s
expect:
  - stands: all
  - verdict: stable
  - margin: {load_factor: ">= 7.07"}
"""
WEAK = CORBEL.replace("0.1 MPa", "0.01 MPa")
FACTOR = 1e5 * 0.1 * 0.05**2 / (9.0 * 0.2 * 9.81 * 0.2)


def test_joined_bricks_stand_with_a_load_factor_and_the_joint_that_gives_way(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, CORBEL, "corbel.yaml")
    told = stackdsl("run", "corbel.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "measured 3 bricks stand, also under 7.079 times their weight" in told.out
    assert "expected load_factor >= 7.07, measured load_factor 7.079" in told.out
    explained = stackdsl("explain", "corbel.yaml").out
    assert "joint of all bodies: bond of 0.1 MPa tension, 2 MPa cohesion" in explained
    assert "it survives 7.07 times its own weight; a horizontal acceleration of 13.9 g" in explained
    assert "beyond: a, b, c tip over wall1; the joint between wall1 and a gives way" in explained
    survived = json.loads(stackdsl("survive", "corbel.yaml", "--format", "json").out)["cases"][0]
    assert survived["load_factor"] == pytest.approx(FACTOR, rel=1e-5)
    assert survived["gives_way"] == "a, b, c tip over wall1; the joint between wall1 and a gives way"
    assert "corbel bears 7.07 times its own weight" in stackdsl("survive", "corbel.yaml").out


def test_a_missed_load_factor_fails_with_what_gives_way(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, CORBEL.replace(">= 7.07", ">= 7.08"), "corbel.yaml")
    told = stackdsl("check", "corbel.yaml", "--no-golden")
    assert told.code == ExitCode.FAILED
    assert "measured  load_factor 7.079" in told.text
    assert "the joint between wall1 and a gives way" in told.text


def test_a_collapse_of_joined_bricks_is_proven_and_not_played(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, WEAK, "weak.yaml")
    told = stackdsl("run", "weak.yaml")
    assert told.code == ExitCode.FAILED
    assert "a is proven to fall; the motion of bricks with joints is not played" in told.out
    assert "stands: expected all, measured 3 of 3 bricks fell" in told.out
    assert "collapses at level 1 after 2.000 s; 2 s simulated" in told.out
    assert ", 0 steps" in told.out
    falls = WEAK[: WEAK.index("expect:")] + "expect:\n  - collapses: any\n  - verdict: unstable\n"
    write(tmp_path, falls, "falls.yaml")
    assert stackdsl("check", "falls.yaml", "--no-golden").code == ExitCode.OK


def test_a_dry_structure_that_stands_bears_any_multiple_of_its_weight(stackdsl: Stackdsl, tmp_path: Path) -> None:
    dry = "scenario: dry\nbuild: [{column: {levels: 3}}]\nexpect: [{margin: {load_factor: '>= 1e6'}}]\n"
    write(tmp_path, dry, "dry.yaml")
    told = stackdsl("run", "dry.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "measured load_factor inf" in told.out


@pytest.mark.parametrize(
    "command",
    [("suggest", "weak.yaml"), ("sensitivities", "corbel.yaml"), ("find", "corbel.yaml", "--least", "friction")],
)
def test_commands_that_need_dry_bricks_say_so(stackdsl: Stackdsl, tmp_path: Path, command: tuple[str, ...]) -> None:
    write(tmp_path, WEAK, "weak.yaml")
    write(tmp_path, CORBEL, "corbel.yaml")
    told = stackdsl(*command)
    assert "Traceback" not in told.text
    assert "bricks with joints" in told.err


def test_bricks_that_are_neither_proven_to_stand_nor_to_fall_do_not_stand() -> None:
    # A dry block between two walls: only forces that nothing ensures could hold it.
    walls = "[{bearing: 180 deg, distance: 0.1 m}, {bearing: 0 deg, distance: 0.1 m}]"
    build = "[{bricks: [{at: [0 m, 0 m, 1 m], name: a}]}]"
    text = (
        f"{CORBEL[: CORBEL.index('world:')]}world: {{walls: {walls}}}\njoints: [{{between: [a, ground], pull: 1 N}}]\n"
    )
    case = compiled(f"{text}build: {build}\nexpect: [{{stands: all}}]\n")[0][0]
    trace = play_case(case.timeline, "exact")
    assert trace.statics is not None
    assert trace.statics.stability is Stability.UNDECIDED
    assert trace.collapse is None
    assert {track.state for track in trace.tracks.values()} == {BrickState.UNSETTLED}
    assert not judged(case, trace).passed


def test_other_systems_refuse_joints() -> None:
    timeline = compiled(CORBEL)[0][0].timeline
    for system in ("tuned", "thesis", "modified"):
        with pytest.raises(BlockedPlacementError, match=f"the system '{system}' plays no joints"):
            play_case(timeline, system)
