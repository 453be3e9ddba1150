"""Gaps between boxes and planes."""

from math import cos, pi, sin, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.box_distance import Block, block, box_above_plane, boxes_apart, meeting
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import multiply, rotate
from stability.model import Plane, Pose, Quaternion, Vec3

CUBE = (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("position", "gap", "normal"),
    [
        ((0.0, 0.0, 1.0), 0.0, (0.0, 0.0, 1.0)),
        ((0.2, 0.1, 1.25), 0.25, (0.0, 0.0, 1.0)),
        ((0.2, 0.1, -1.25), 0.25, (0.0, 0.0, -1.0)),
        ((0.9, 0.0, 0.0), -0.1, (1.0, 0.0, 0.0)),
        ((1.5, 0.0, 0.2), 0.5, (1.0, 0.0, 0.0)),
    ],
)
def test_cubes_side_by_side_are_apart_by_the_gap_between_their_faces(position: Vec3, gap: float, normal: Vec3) -> None:
    found = boxes_apart(CUBE, Pose(position), CUBE, Pose((0.0, 0.0, 0.0)))
    assert found.gap == pytest.approx(gap)
    assert found.normal_BA_W == pytest.approx(normal)


def test_a_cube_on_its_edge_touches_with_half_its_diagonal() -> None:
    on_edge = Pose((0.0, 0.0, 0.5 + sqrt(0.5)), (0.0, sin(pi / 8.0), 0.0, cos(pi / 8.0)))
    found = boxes_apart(CUBE, on_edge, CUBE, Pose((0.0, 0.0, 0.0)))
    assert found.gap == pytest.approx(0.0, abs=1e-12)
    assert found.normal_BA_W == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)


def test_crossed_edges_meet_along_the_product_of_their_directions() -> None:
    #  Two cubes on edge, crosswise: their centres are apart by twice half a diagonal and the gap.
    half = pi / 8.0
    upper = Pose((0.0, 0.0, 2.0 * sqrt(0.5) + 0.1), (sin(half), 0.0, 0.0, cos(half)))
    lower = Pose((0.0, 0.0, 0.0), (0.0, sin(half), 0.0, cos(half)))
    found = boxes_apart(CUBE, upper, CUBE, lower)
    assert found.gap == pytest.approx(0.1)
    assert found.normal_BA_W == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)


def test_a_box_above_a_plane_is_measured_from_its_lowest_corner() -> None:
    slope = Plane("ground", (0.0, 0.0, 0.0), (-sin(0.3), 0.0, cos(0.3)), 0.5)
    found = box_above_plane(CUBE, Pose((0.0, 0.0, 2.0)), slope)
    assert found.gap == pytest.approx(2.0 * cos(0.3) - 0.5 * (sin(0.3) + cos(0.3)))


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(-pi, pi), st.floats(-pi, pi))
def test_separation_is_the_same_seen_from_either_box(position: Vec3, yaw: float, pitch: float) -> None:
    a = Pose(position, (0.0, sin(pitch / 2.0), 0.0, cos(pitch / 2.0)))
    b = Pose((0.0, 0.0, 0.0), (0.0, 0.0, sin(yaw / 2.0), cos(yaw / 2.0)))
    one = boxes_apart((1.0, 2.0, 0.5), a, CUBE, b)
    other = boxes_apart(CUBE, b, (1.0, 2.0, 0.5), a)
    assert one.gap == pytest.approx(other.gap, abs=1e-9)


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(-pi, pi), st.floats(-pi, pi))
def test_two_boxes_that_lie_flat_are_as_far_apart_as_when_they_are_turned_together(
    position: Vec3, yaw: float, other_yaw: float
) -> None:
    #   Flat ones are compared along fewer directions than those of any pose.
    on_end: Quaternion = (sin(0.4), 0.0, 0.0, cos(0.4))
    a, b = Pose(position, about_z(yaw)), Pose((0.0, 0.0, 0.0), about_z(other_yaw))
    turned_a, turned_b = (Pose(rotate(on_end, p.position_W), multiply(on_end, p.orientation)) for p in (a, b))
    flat = boxes_apart((1.0, 2.0, 0.5), a, CUBE, b)
    assert boxes_apart((1.0, 2.0, 0.5), turned_a, CUBE, turned_b).gap == pytest.approx(flat.gap, abs=1e-9)


def about_z(angle: float) -> Quaternion:
    return (0.0, 0.0, sin(angle / 2.0), cos(angle / 2.0))


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(-pi, pi), st.floats(-pi, pi), st.floats(0.0, 1.0))
def test_what_overlaps_or_touches_is_within_any_margin(position: Vec3, yaw: float, pitch: float, margin: float) -> None:
    a = Pose(position, (0.0, sin(pitch / 2.0), 0.0, cos(pitch / 2.0)))
    b = Pose((0.0, 0.0, 0.0), about_z(yaw))
    near = is_within(margin, block((1.0, 2.0, 0.5), a), block(CUBE, b))
    assert near or boxes_apart((1.0, 2.0, 0.5), a, CUBE, b).gap > 0.0


def test_upright_boxes_are_within_a_margin_as_wide_as_their_gap() -> None:
    one, other = block(CUBE, Pose((0.0, 0.0, 0.0))), block(CUBE, Pose((0.0, 1.25, 0.0)))
    assert is_within(0.25, one, other)
    assert not is_within(0.249, one, other)


def is_within(margin: float, one: Block, other: Block) -> bool:
    neighbours: Neighbours[int] = Neighbours()
    neighbours.add(1, other.low_W, other.high_W)
    return neighbours.around(one.low_W, one.high_W, margin) == [1]


def test_a_cube_that_moves_meets_another_with_its_face_and_leaves_it_behind() -> None:
    one, other = block(CUBE, Pose((0.0, 0.0, 0.0))), block(CUBE, Pose((3.0, 0.4, 0.0)))
    assert meeting(one, other, (1.0, 0.0, 0.0), graze=0.0) == pytest.approx((2.0, 4.0))
    assert meeting(one, other, (-1.0, 0.0, 0.0), graze=0.0) == pytest.approx((-4.0, -2.0))
    assert meeting(one, other, (0.0, 1.0, 0.0), graze=0.0) is None


@pytest.mark.parametrize(("beside", "meets"), [(0.9998, True), (0.9999001, False), (1.0, False), (1.2, False)])
def test_a_grazing_motion_meets_nothing(beside: float, meets: bool) -> None:
    one, other = block(CUBE, Pose((0.0, 0.0, 0.0))), block(CUBE, Pose((3.0, beside, 0.0)))
    assert (meeting(one, other, (1.0, 0.0, 0.0), graze=1e-4) is not None) is meets


def test_edges_meet_edges_on_the_way() -> None:
    #  <>  <>   two cubes on their upright edges, half a diagonal each
    on_edge = (0.0, 0.0, sin(pi / 8.0), cos(pi / 8.0))
    one, other = block(CUBE, Pose((0.0, 0.0, 0.0), on_edge)), block(CUBE, Pose((5.0, 0.0, 0.0), on_edge))
    found = meeting(one, other, (1.0, 0.0, 0.0), graze=0.0)
    assert found is not None
    assert found[0] == pytest.approx(5.0 - sqrt(2.0))


def turns() -> st.SearchStrategy[Quaternion]:
    parts = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(part * part for part in q) > 0.01)
    return parts.map(lambda q: tuple(part / sqrt(sum(p * p for p in q)) for part in q))


@given(turns(), turns(), st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))
def test_where_boxes_meet_they_touch_and_just_before_they_are_apart(
    one: Quaternion, other: Quaternion, beside: float, above: float
) -> None:
    size, pose = (1.0, 0.4, 0.2), Pose((4.0, beside, above), other)
    way = meeting(block(size, Pose((0.0, 0.0, 0.0), one)), block(size, pose), (1.0, 0.0, 0.0), graze=0.0)
    if way is None:
        return

    def gap(along: float) -> float:
        return boxes_apart(size, Pose((along, 0.0, 0.0), one), size, pose).gap

    assert gap(way[0]) == pytest.approx(0.0, abs=1e-6)  # a gap that is smaller on a near-parallel axis counts as none
    assert gap(way[0] - 0.01) > 0.0
    assert gap((way[0] + way[1]) / 2) < 1e-9
