"""Bricks that were woken and hardly moved go back exactly to where they were."""

from collections.abc import Mapping
from math import cos, sin

import pytest

from stability.model import BodyId, Pose, Vec3
from stability.problem import Placed
from stability.stabilizers.exact.candidates import CREPT, HIT_NOTHING, RestPoses
from tests.planks import LENGTH, THICKNESS, column, plank

THIRD_OF_PI = 1.0471975511965976  # a coordinate that rounds
CREEP, SHIFT = 1e-5, 1e-3  # [m]


def shifted(pose: Pose, by: float) -> Pose:
    x, y, z = pose.position_W
    return Pose((x + by, y, z), pose.orientation)


def put_back(was: Mapping[BodyId, Pose], moves: Mapping[BodyId, float]) -> dict[BodyId, Pose]:
    rest_poses = RestPoses()
    rest_poses.remember(was)
    coming = [Placed(plank(name), shifted(pose, moves.get(name, 0.0))) for name, pose in was.items()]
    return {placed.brick.id: placed.pose for placed in rest_poses.put_back(coming)}


def test_the_limits_are_a_third_and_a_fiftieth_of_a_millimetre_for_a_plank() -> None:
    assert pytest.approx(0.3e-3, rel=0.05) == HIT_NOTHING * THICKNESS
    assert pytest.approx(0.02e-3, rel=0.05) == CREPT * THICKNESS


def test_if_nothing_moved_all_go_back_bit_for_bit() -> None:
    was = {name: shifted(pose, THIRD_OF_PI) for name, pose in column(5).items()}
    assert put_back(was, {"L1": 0.29e-3, "L2": -0.1e-3, "L3": 1e-7}) == was


def test_if_a_brick_moved_only_crept_bricks_return() -> None:
    was = column(3)
    found = put_back(was, {"L1": CREEP, "L2": SHIFT, "L3": 0.1e-3})
    assert found == {"L1": was["L1"], "L2": shifted(was["L2"], SHIFT), "L3": shifted(was["L3"], 0.1e-3)}


@pytest.mark.parametrize(("end_moves", "back"), [(0.29e-3, True), (0.33e-3, False)])
def test_a_rotation_counts_by_the_motion_of_the_end_of_a_plank(end_moves: float, back: bool) -> None:
    half = end_moves / (LENGTH / 2.0) / 2.0
    rest_poses = RestPoses()
    rest_poses.remember({"L1": column(1)["L1"]})
    turned = Pose(column(1)["L1"].position_W, (0.0, 0.0, sin(half), cos(half)))
    (placed,) = rest_poses.put_back([Placed(plank("L1"), turned)])
    assert (placed.pose == column(1)["L1"]) is back


def test_the_rest_pose_of_a_brick_hit_twice_is_its_first_one() -> None:
    home = column(1)["L1"]
    rest_poses = RestPoses()
    rest_poses.remember({"L1": home})
    rest_poses.remember({"L1": shifted(home, 0.2e-3)})
    (placed,) = rest_poses.put_back([Placed(plank("L1"), shifted(home, 0.25e-3))])
    assert placed.pose == home


def test_a_brick_at_rest_elsewhere_has_its_rest_pose_there() -> None:
    rest_poses, there = RestPoses(), shifted(column(1)["L1"], SHIFT)
    rest_poses.remember(column(1))
    rest_poses.frozen(["L1"])
    assert "L1" not in rest_poses
    rest_poses.remember({"L1": there})
    (placed,) = rest_poses.put_back([Placed(plank("L1"), shifted(there, CREEP))])
    assert placed.pose == there


def test_a_brick_without_a_rest_pose_stays_where_it_comes_to_rest() -> None:
    far: Vec3 = (0.5, 0.0, THICKNESS / 2.0)
    rest_poses = RestPoses()
    rest_poses.remember(column(1))
    assert rest_poses.put_back([Placed(plank("shot"), Pose(far))])[0].pose == Pose(far)
