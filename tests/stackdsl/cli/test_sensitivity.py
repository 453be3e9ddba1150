"""`stackdsl check --sensitivity`: whether a micrometre decides a result."""

import json
from pathlib import Path

from stackdsl.checking.micrometre import MICROMETRE, either_side
from stackdsl.report.text import decided_text
from stackdsl.results import Change
from stackdsl.timeline import PushAction
from tests.command_line import GOOD, Stackdsl, write
from tests.scenes import timeline_of

PUSH = "impacts: [{push: {brick: L3.1, impulse: [0.6 mN*s, 0 N*s, 0 N*s]}}]\n"
PUSHED = f"{GOOD}{PUSH}systems: [exact]\n"
EDGE = GOOD.replace("column: {levels: 3}", "column: {levels: 2, step: 58.8 mm}") + "systems: [exact]\n"


def test_a_push_whose_result_is_the_same_beside_it_is_not_decided_by_a_micrometre(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    path = write(tmp_path, PUSHED)
    assert "a micrometre decides nothing" in stackdsl("check", str(path), "--sensitivity").out
    report = json.loads(stackdsl("check", str(path), "--sensitivity", "--format", "json").out)
    assert len(report["results"][0]["sensitivity"]) > 0


def test_of_a_plank_on_its_edge_a_micrometre_decides_whether_it_tips(stackdsl: Stackdsl, tmp_path: Path) -> None:
    told = stackdsl("check", str(write(tmp_path, EDGE)), "--sensitivity", "--no-golden").out
    assert "a micrometre decides: drift of what stands: 0 mm or " in told


def test_pushes_move_to_either_side_and_nothing_else_does() -> None:
    scene = timeline_of("[{column: {levels: 3}}]", PUSH)
    for beside, way in zip(either_side(scene), (1.0, -1.0), strict=True):
        moved = [pair for pair in zip(scene.actions, beside.actions, strict=True) if pair[0] != pair[1]]
        ((before, after),) = moved
        assert isinstance(before, PushAction)
        assert isinstance(after, PushAction)
        assert after.offset_W == tuple(way * part for part in MICROMETRE)


def test_the_numbers_of_fallen_bricks_are_told_without_the_drift_of_the_others() -> None:
    fallen = [Change("fallen", ("a",), each) for each in (("a", "b"), ("a",))]
    drift = Change("drift of what stands", 1.0, 2.0)
    assert decided_text([*fallen, drift]) == "1 or 2 fallen"


def test_refinement_and_sensitivity_are_not_asked_for_at_once(stackdsl: Stackdsl, tmp_path: Path) -> None:
    told = stackdsl("check", str(write(tmp_path, GOOD)), "--refine", "--sensitivity")
    assert told.code == 4
    assert "remove one of them" in told.err
