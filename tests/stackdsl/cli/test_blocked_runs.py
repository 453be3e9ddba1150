"""What cannot be done when its time comes, as something has moved there, is told like a mistake in the file."""

import json
from pathlib import Path

import pytest

from stability.geometry.box import Box
from stability.model import BodyState, Brick, Pose
from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case, play_refined, played_or_blocked
from stackdsl.checking.results import blocked_result
from stackdsl.exits import ExitCode
from stackdsl.report.check_text import report_text
from stackdsl.results import Report, RunStatus, exit_code
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError, BrickTracker, require_clearance
from stackdsl.timeline import Arrival, Placement
from stackdsl.trace import Trace
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write
from tests.engines_at_hand import needs_pybullet
from tests.scenes import compiled

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# Of two planks end to end on a slope of 40 deg, one slides to where the other was: after 45 ms it is about 2 mm there.
SLIDES = """\
scenario: slides
world: {tilt: 40 deg}
build:
  - bricks: [{name: upper, at: [0 mm, 0 mm, 3.9 mm]}, {name: lower, at: [117.6 mm, 0 mm, 3.9 mm]}]
impacts:
  - at: 0 s
    remove: {brick: lower}
  - at: 0.045 s
    insert: {name: late, at: [117.6 mm, 0 mm, 3.9 mm]}
systems: [tuned]
expect:
  - stands: {bricks: [late]}
"""
# 8 mN*s on a plank of 11.9 g are 0.67 m/s, with which it slides 45 mm towards who throws from 10 mm away.
PUSHED = """\
scenario: pushed
build:
  - bricks: [{name: near, at: [0 mm, 0 mm, 3.9 mm]}]
impacts:
  - push: {brick: near, impulse: [8 mN*s, 0 N*s, 0 N*s]}
  - after: impact 1 + 1 s
    throw: {at: near, from: {bearing: 0 deg, distance: 10 mm}, speed: 2 m/s}
systems: [tuned, exact]
"""
# Where a plank comes to lie that falls is not known when the scenario is written.
BUILT = """\
scenario: built-late
build:
  - bricks: [{name: first, at: [0 mm, 0 mm, 20 mm], drop: true}]
  - bricks: [{name: second, at: [0 mm, 0 mm, 3.9 mm]}]
    at: 2 s
"""


def blocked(text: str) -> tuple[Case, Blocked]:
    case = compiled(text)[0][0]
    played = played_or_blocked(play_case, case.timeline, case.system)
    assert isinstance(played, Blocked)
    return case, played


@pytest.mark.parametrize(
    ("text", "place", "told", "remedy"),
    [
        (SLIDES, (9, 13), ("'late' cannot be placed at 0.045 s", "'upper' has moved"), "pull out 'upper' before"),
        (PUSHED, (7, 5), ("'thrown-2' cannot be placed at 1 s", "'near' has moved"), "throw it from elsewhere"),
        (BUILT, (4, 14), ("'second' cannot be placed at 2 s", "'first' has moved"), "place it elsewhere"),
    ],
)
def test_a_blocking_brick_is_named_at_the_blocked_action(
    text: str, place: tuple[int, int], told: tuple[str, str], remedy: str
) -> None:
    case, found = blocked(text)
    mistake = blocked_result(case, found).mistake
    assert mistake is not None
    assert (mistake.code, mistake.span.file, mistake.span.line, mistake.span.column) == ("SD208", "scene.yaml", *place)
    assert [words for words in told if words not in mistake.message] == []
    assert remedy in mistake.hint


def test_the_depth_is_that_of_the_slide() -> None:
    #   g (sin 40 deg - 0.5 cos 40 deg) t^2 / 2 = 2.5 mm after 45 ms
    _, found = blocked(SLIDES)
    assert found.depth == pytest.approx(0.0025, rel=0.15)


def test_the_deepest_blocking_brick_is_named() -> None:
    #   Two dropped planks lie 6 mm above and 2 mm below the place of a third, 7.8 mm thick: 1.8 and 5.8 mm into it.
    watch = BrickTracker()
    for name, height in (("above", 0.006), ("below", -0.002), ("beyond", 0.1)):
        watch.add(placed(name, height, Arrival.LET_GO))
    with pytest.raises(BlockedPlacementError) as raised:
        require_clearance(placed("late", 0.0), watch)
    assert raised.value.blocked.by == "below"
    assert raised.value.blocked.depth == pytest.approx(0.0058)


@pytest.mark.parametrize(("lift", "told"), [(0.005, True), (0.003, False)])
def test_a_tipped_brick_blocks_an_action(lift: float, told: bool) -> None:
    #   A plank on the ground comes up by 5 mm, which is more than half of the 7.8 mm that the next one is thick.
    watch = BrickTracker()
    watch.add(placed("first", 0.0039))
    pose = Pose((0.0, 0.0, 0.0039 + lift), (0.0, 0.0, 0.0, 1.0))
    watch.see(1.0, {"first": BodyState(pose, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))})
    second = placed("second", 0.0117)
    if not told:
        require_clearance(second, watch)
        return
    with pytest.raises(BlockedPlacementError) as raised:
        require_clearance(second, watch)
    assert raised.value.blocked.by == "first"
    assert raised.value.blocked.depth == pytest.approx(lift)


def placed(name: str, height: float, arrival: Arrival = Arrival.SET_DOWN) -> Placement:
    brick = Brick(name, Box((0.1176, 0.0234, 0.0078)), 0.0119)
    return Placement(0.0, brick, 1, Pose((0.0, 0.0, height), (0.0, 0.0, 0.0, 1.0)), arrival)


def test_a_run_that_only_a_finer_step_blocks_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    case = compiled(PUSHED)[0][0]
    coarse = play_case(compiled(PUSHED.replace("1 s", "0 s").replace("0 deg", "180 deg"))[0][0].timeline, "tuned")
    monkeypatch.setattr("stackdsl.checking.play_case.play_case", lambda timeline, name, may_stop: coarse)
    found = played_or_blocked(play_refined, case.timeline, case.system)
    assert isinstance(found, Blocked)
    assert "at half the step and twice the iterations" in blocked_result(case, found).message


def test_a_run_with_room_is_played() -> None:
    case = compiled(SLIDES.replace("0.045 s", "0.001 s"))[0][0]
    assert isinstance(played_or_blocked(play_case, case.timeline, case.system), Trace)
    with pytest.raises(BlockedPlacementError):
        play_case(compiled(SLIDES)[0][0].timeline, "tuned")


def test_a_blocked_run_makes_a_scenario_invalid_and_runs_alike_are_told_once() -> None:
    case, found = blocked(PUSHED)
    one = blocked_result(case, found)
    report = Report((one, one))
    assert (one.status, one.passed, exit_code(report)) == (RunStatus.BLOCKED, False, ExitCode.INVALID)
    text = report_text(report)
    assert text.count("SD208") == 1
    assert f"= in {one.name}, {one.name}" in text
    assert "2 blocked" in text


@needs_pybullet
def test_check_tells_what_is_blocked_and_goes_on_with_the_rest(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{SLIDES}---\n{GOOD}")
    result = stackdsl("check", "scene.yaml", "--format", "json")
    seen = {case["scenario"]: case for case in json.loads(result.out)["results"]}
    assert result.code == 2
    assert (seen["slides"]["status"], seen["good"]["verdict"]) == ("blocked", "stands")
    assert seen["slides"]["mistake"]["code"] == "SD208"
    assert seen["slides"]["mistake"]["span"]["line"] == 9
    assert seen["good"]["mistake"] is None
    assert "BlockedPlacementError" not in result.text


@needs_pybullet
def test_run_tells_what_is_blocked_and_goes_on_with_the_rest(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{SLIDES}---\n{GOOD}")
    result = stackdsl("run", "scene.yaml")
    assert result.code == 2
    assert "scene.yaml:9:13: SD208" in result.err
    assert "✓ passed  stands: " in result.out
