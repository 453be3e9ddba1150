"""Contacts by faces and edges: the same as those of boxes, where both are known, and by themselves."""

from math import pi

import numpy as np
import pytest

from stability.contacts.bodies import Solid, as_hull
from stability.contacts.bodies import convex_solid as solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.geometry.box import Box
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import apart
from stability.geometry.solid_making import prism, solid_of_corners
from stability.geometry.vectors import about, dot, multiply, scale, unit
from stability.model import IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Contact, Placed, Tolerances

ROOF = prism([(-0.05, 0.0), (0.05, 0.0), (0.0, 0.04)], 0.1)
PAIRS = 400


def random_turn(rng: np.random.Generator) -> Quaternion:
    kind = int(rng.integers(4))
    if kind == 0:
        return about((0.0, 0.0, 1.0), float(rng.uniform(0.0, 2.0 * pi)))
    if kind == 1:
        return about((0.0, 1.0, 0.0), float(rng.choice([0.0, pi / 6.0, pi / 4.0, pi / 2.0])))
    if kind == 2:
        return IDENTITY
    x, y, z, w = (float(part) for part in rng.normal(size=4))
    length = (x * x + y * y + z * z + w * w) ** 0.5
    return (x / length, y / length, z / length, w / length)


def pair_apart(rng: np.random.Generator, share: float) -> tuple[Solid, Solid]:
    """Two boxes in any direction from each other, with a gap of a share of the largest gap of a contact."""
    a, b = (Box(_vec(rng.uniform(0.01, 0.1, 3))) for _ in range(2))
    one, turn, way = random_turn(rng), random_turn(rng), rng.normal(size=3)
    way /= np.linalg.norm(way)
    beside = rng.uniform(-0.03, 0.03, 3) if rng.random() < 0.5 else np.zeros(3)
    near, far, gap = 0.0, 0.5, share * reach_between(min(a.size), min(b.size))
    for _ in range(60):
        middle = 0.5 * (near + far)
        clear = apart(a, Pose((0.0, 0.0, 0.0), one), b, Pose(_vec(beside + middle * way), turn)).gap > gap
        near, far = (near, middle) if clear else (middle, far)
    placed = Placed(Brick("b", b, 1.0), Pose(_vec(beside + far * way), turn))
    return solid(Placed(Brick("a", a, 1.0), Pose((0.0, 0.0, 0.0), one))), solid(placed)


def same(one: Contact, other: Contact, tolerance: float) -> bool:
    def close(these: tuple[Vec3, ...], those: tuple[Vec3, ...]) -> bool:
        apart_by = np.linalg.norm(np.array(these)[:, None, :] - np.array(those)[None, :, :], axis=2)
        return len(these) == len(those) and bool(apart_by.min(axis=0).max() < tolerance)

    names = (one.lower, one.upper) == (other.lower, other.upper)
    return names and close(one.points_W, other.points_W) and close(one.normals_W, other.normals_W)


def test_two_boxes_have_the_same_contact_as_boxes_and_as_hulls() -> None:
    rng, kinds = np.random.default_rng(16), set()
    for _ in range(PAIRS):
        a, b = pair_apart(rng, 0.0)
        as_boxes = contact_between(a, b, 0.5, Tolerances())
        as_hulls = contact_between(as_hull(a), as_hull(b), 0.5, Tolerances())
        if as_boxes is None or as_hulls is None:  # they pass each other by
            assert as_boxes is as_hulls
            continue
        assert same(as_boxes, as_hulls, 1e-7), (as_boxes, as_hulls)
        kinds.add((min(len(as_boxes.points_W), 3), len(as_boxes.normals_W)))
    assert {(1, 1), (2, 1), (3, 1)} <= kinds  # corners or crossing edges, edges on faces, faces


@pytest.mark.parametrize("share", [-1.1, -0.9, -0.3, 0.04, 0.3, 0.9, 1.1])
def test_two_boxes_touch_across_the_same_gaps_as_boxes_and_as_hulls(share: float) -> None:
    rng = np.random.default_rng(18)
    for _ in range(PAIRS // 4):
        a, b = pair_apart(rng, share)
        as_boxes = contact_between(a, b, 0.5, Tolerances())
        as_hulls = contact_between(as_hull(a), as_hull(b), 0.5, Tolerances())
        # Within the tolerances, boxes compare their axes to find coinciding edges, and hulls compare their corners.
        assert (as_boxes is None) == (as_hulls is None)
        if as_boxes is not None and as_hulls is not None:
            assert (as_boxes.lower, as_boxes.upper) == (as_hulls.lower, as_hulls.upper)
            assert bool(as_boxes.gaps) == bool(as_hulls.gaps)


def test_a_box_has_the_same_contact_with_a_plane_as_a_box_and_as_a_hull() -> None:
    rng = np.random.default_rng(17)
    for _ in range(PAIRS):
        box, turn, normal = Box(_vec(rng.uniform(0.01, 0.1, 3))), random_turn(rng), rng.normal(size=3)
        plane = Plane("slope", (0.0, 0.0, 0.0), unit(_vec(normal)) if rng.random() < 0.5 else (0.0, 0.0, 1.0), 0.5)
        centred = solid(Placed(Brick("a", box, 1.0), Pose((0.0, 0.0, 0.0), turn)))
        lowest = min(dot(corner, plane.normal_W) for corner in centred.corners_W)
        height = float(rng.uniform(-0.9, 0.9)) * reach_between(min(box.size)) - lowest
        body = solid(Placed(Brick("a", box, 1.0), Pose(scale(height, plane.normal_W), turn)))
        as_box, as_any = (contact_with_plane(each, plane, Tolerances()) for each in (body, as_hull(body)))
        if as_box is None or as_any is None:
            assert as_box is as_any
            continue
        assert same(as_box, as_any, 1e-9), (as_box, as_any)


def test_a_roof_lies_on_its_whole_side() -> None:
    body = solid(Placed(Brick("roof", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    contact = contact_with_plane(body, Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5), Tolerances())
    assert contact is not None
    x, y, z = np.array(contact.points_W).T
    corners = sorted(zip(x.round(9).tolist(), y.round(9).tolist(), strict=True))
    assert corners == [(-0.05, -0.05), (-0.05, 0.05), (0.05, -0.05), (0.05, 0.05)]
    assert abs(z).max() < 1e-15


def test_a_plank_on_the_ridge_of_a_roof_touches_it_along_a_line() -> None:
    roof = solid(Placed(Brick("roof", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    plank = solid(Placed(Brick("plank", Box((0.2, 0.06, 0.01)), 1.0), Pose((0.0, 0.0, 0.045))))
    contact = contact_between(plank, roof, 0.5, Tolerances())
    assert contact is not None
    assert (contact.lower, contact.upper) == ("roof", "plank")
    assert sorted(contact.points_W) == [pytest.approx((0.0, -0.03, 0.04)), pytest.approx((0.0, 0.03, 0.04))]
    assert list(contact.normals_W) == [pytest.approx((0.0, 0.0, 1.0))]


def test_a_plank_askew_to_the_ridge_touches_it_as_far_as_both_reach() -> None:
    roof = solid(Placed(Brick("roof", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    turn = about((0.0, 0.0, 1.0), pi / 6.0)
    plank = solid(Placed(Brick("plank", Box((0.2, 0.06, 0.01)), 1.0), Pose((0.0, 0.0, 0.045), turn)))
    contact = contact_between(plank, roof, 0.5, Tolerances())
    assert contact is not None
    half = 0.03 / np.cos(pi / 6.0)
    assert sorted(y for _, y, _ in contact.points_W) == pytest.approx([-half, half])


def test_ridges_that_cross_touch_in_a_point_with_one_normal() -> None:
    upside_down = multiply(about((0.0, 0.0, 1.0), pi / 2.0), about((0.0, 1.0, 0.0), pi))
    lower = solid(Placed(Brick("lower", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    height = 0.08 - ROOF.centre_of_mass[2]
    upper = solid(Placed(Brick("upper", ROOF.shape, 1.0), Pose((0.0, 0.0, height), upside_down)))
    contact = contact_between(lower, upper, 0.5, Tolerances())
    assert contact is not None
    assert list(contact.points_W) == [pytest.approx((0.0, 0.0, 0.04), abs=1e-12)]
    assert list(contact.normals_W) == [pytest.approx((0.0, 0.0, 1.0), abs=1e-12)]


def test_ridges_along_each_other_admit_every_normal_between_their_sides() -> None:
    upside_down = about((0.0, 1.0, 0.0), pi)
    lower = solid(Placed(Brick("lower", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    upper = solid(Placed(Brick("upper", ROOF.shape, 1.0), Pose((0.0, 0.0, 0.08 - ROOF.centre_of_mass[2]), upside_down)))
    contact = contact_between(lower, upper, 0.5, Tolerances())
    assert contact is not None
    assert len(contact.points_W) == 2
    slope = np.hypot(0.05, 0.04)
    assert sorted(contact.normals_W) == [
        pytest.approx((-0.04 / slope, 0.0, 0.05 / slope)),
        pytest.approx((0.04 / slope, 0.0, 0.05 / slope)),
    ]


def test_the_tip_of_a_pyramid_touches_a_plank_in_a_point() -> None:
    base: list[Vec3] = [(-0.05, -0.05, 0.0), (0.05, -0.05, 0.0), (0.05, 0.05, 0.0), (-0.05, 0.05, 0.0)]
    tip = solid_of_corners([*base, (0.0, 0.0, 0.06)])
    pyramid = solid(Placed(Brick("pyramid", tip.shape, 1.0), Pose(tip.centre_of_mass)))
    plank = solid(Placed(Brick("plank", Box((0.2, 0.06, 0.01)), 1.0), Pose((0.01, 0.0, 0.065))))
    contact = contact_between(pyramid, plank, 0.5, Tolerances())
    assert contact is not None
    assert list(contact.points_W) == [pytest.approx((0.0, 0.0, 0.06), abs=1e-12)]
    assert list(contact.normals_W) == [pytest.approx((0.0, 0.0, 1.0))]


def test_solids_that_are_further_apart_than_touching_have_no_contact() -> None:
    roof = solid(Placed(Brick("roof", ROOF.shape, 1.0), Pose(ROOF.centre_of_mass)))
    plank = solid(Placed(Brick("plank", Box((0.2, 0.06, 0.01)), 1.0), Pose((0.0, 0.0, 0.0453))))
    assert contact_between(plank, roof, 0.5, Tolerances()) is None


def _vec(parts: np.ndarray) -> Vec3:
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
