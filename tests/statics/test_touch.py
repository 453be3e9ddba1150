"""Contacts from poses and sizes alone. L, W and T are the sides of a plank; gaps in shares of T."""

from collections.abc import Sequence
from math import asin, cos, degrees, dist, pi, radians, sin, sqrt

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from stability.geometry import composed, turned
from stability.model import IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stability.separation import boxes_apart
from stability.statics.contacts.touch import Solid, contact_between, contact_with_plane, solid
from stability.statics.facts import Contact, Placed, Tolerances

L, W, T = PLANK = (0.1176, 0.0234, 0.0078)
CUBE = (1.0, 1.0, 1.0)
UP = (0.0, 0.0, 1.0)
GROUND = Plane("ground", (0.0, 0.0, 0.0), UP, 0.5)
TOLERANCES = Tolerances()
REACH = TOLERANCES.gap * T
ON_EDGE = pi / 4.0


def about(axis: Vec3, angle: float) -> Quaternion:
    s = sin(0.5 * angle)
    return (s * axis[0], s * axis[1], s * axis[2], cos(0.5 * angle))


def yawed(angle: float) -> Quaternion:
    return about(UP, angle)


def pitched(angle: float) -> Quaternion:
    """A turn that lifts the end at +x."""
    return about((0.0, -1.0, 0.0), angle)


def brick(name: str, size: Vec3, position: Vec3, orientation: Quaternion = IDENTITY) -> Solid:
    return solid(Placed(Brick(name, size, 1.0), Pose(position, orientation)))


def plank(name: str, position: Vec3, orientation: Quaternion = IDENTITY) -> Solid:
    return brick(name, PLANK, position, orientation)


def touch(a: Solid, b: Solid) -> Contact | None:
    """The contact of two bricks, which must be the same seen from either."""
    found = contact_between(a, b, 0.5, TOLERANCES)
    assert found == contact_between(b, a, 0.5, TOLERANCES)
    return found


def contact(a: Solid, b: Solid) -> Contact:
    found = touch(a, b)
    assert found is not None
    return found


def same_points(found: Sequence[Vec3], expected: Sequence[Vec3], within: float) -> bool:
    """Whether the two are the same points, in whatever order."""
    return len(found) == len(expected) and all(min(dist(p, q) for q in found) <= within for p in expected)


def area(points: Sequence[Vec3]) -> float:
    """Of a level polygon, positive if it runs counter-clockwise seen from above [m2]."""
    pairs = zip(points, [*points[1:], points[0]], strict=True)
    return 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)


def elevations(found: Contact) -> list[float]:
    """Of the normals, from the horizontal [deg]."""
    return sorted(degrees(asin(max(-1.0, min(1.0, normal[2])))) for normal in found.normals_W)


# --- face on face ---------------------------------------------------------------------------------------------------


def test_crossed_planks_share_a_square_of_their_width() -> None:
    found = contact(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, T), yawed(pi / 2.0)))
    assert (found.lower, found.upper, found.friction) == ("a", "b", 0.5)
    assert found.normals_W == (UP,)
    h = W / 2.0
    assert same_points(found.points_W, [(-h, -h, T / 2), (h, -h, T / 2), (h, h, T / 2), (-h, h, T / 2)], 1e-16)
    assert area(found.points_W) == pytest.approx(W * W)


def test_a_shifted_plank_rests_on_what_is_left_below_it() -> None:
    found = contact(plank("z", (0.0, 0.0, 0.0)), plank("b", (0.08, -0.005, T)))
    assert found.lower == "z"
    corners = [(x, y, T / 2) for x in (0.08 - L / 2, L / 2) for y in (-W / 2, W / 2 - 0.005)]
    assert same_points(found.points_W, corners, 1e-16)


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 150.0])
def test_planks_crossed_askew_share_a_rhomb(angle: float) -> None:
    # Two strips of width W that cross at an angle share W^2 / sin(angle).
    found = contact(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, T), yawed(radians(angle))))
    assert len(found.points_W) == 4
    assert area(found.points_W) == pytest.approx(W * W / sin(radians(angle)), rel=1e-12)


def test_a_turned_square_on_a_square_shares_an_octagon() -> None:
    found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (0.0, 0.0, 1.0), yawed(pi / 4.0)))
    assert len(found.points_W) == 8
    assert area(found.points_W) == pytest.approx(2.0 * sqrt(2.0) - 2.0, rel=1e-12)


@pytest.mark.parametrize("orientation", [about((1.0, 0.0, 0.0), pi / 2.0), pitched(pi / 2.0), pitched(-pi / 2.0)])
def test_any_side_of_a_brick_may_be_the_level_one(orientation: Quaternion) -> None:
    extents = [abs(each) for each in turned(orientation, PLANK)]
    upper = plank("b", (0.0, 0.0, 0.5 * T + 0.5 * extents[2]), orientation)
    assert upper.flat
    found = contact(plank("a", (0.0, 0.0, 0.0)), upper)
    assert area(found.points_W) == pytest.approx(min(extents[0], L) * min(extents[1], W), rel=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.4])
@pytest.mark.parametrize("sliver", [1e-3, 1e-6, 1e-9])
def test_a_sliver_is_a_patch_with_its_true_corners(sliver: float, yaw: float) -> None:
    shift = L * (1.0 - sliver)
    upper = plank("b", (shift * cos(yaw), shift * sin(yaw), T), yawed(yaw))
    found = contact(plank("a", (0.0, 0.0, 0.0), yawed(yaw)), upper)
    assert len(found.normals_W) == 1
    assert found.normals_W[0] == pytest.approx(UP)
    assert area(found.points_W) == pytest.approx(L * sliver * W, rel=2e-16 / sliver + 1e-12)


def test_neighbours_that_stand_side_by_side_touch_with_their_sides() -> None:
    found = contact(plank("b", (0.0, 0.0, 0.0)), plank("a", (0.01, -W, 0.001)))
    assert (found.lower, found.upper) == ("a", "b")
    assert found.normals_W == ((0.0, 1.0, 0.0),)
    x, y, z = L / 2, -W / 2, T / 2
    assert same_points(
        found.points_W, [(0.01 - x, y, z), (x, y, z), (0.01 - x, y, 0.001 - z), (x, y, 0.001 - z)], 1e-16
    )


def test_bricks_on_a_common_slope_touch_with_their_faces() -> None:
    slope = pitched(0.3)
    found = contact(plank("a", (0.0, 0.0, 0.0), slope), plank("b", turned(slope, (0.05, 0.0, T)), slope))
    corners = [(x, y, T / 2) for x in (0.05 - L / 2, L / 2) for y in (-W / 2, W / 2)]
    assert same_points(found.points_W, [turned(slope, corner) for corner in corners], 1e-15)
    assert found.normals_W[0] == pytest.approx(turned(slope, UP), abs=1e-15)


def test_a_pebble_on_a_slab_rests_on_its_whole_base() -> None:
    found = contact(
        brick("slab", (1e3, 1e3, 1.0), (0.0, 0.0, -0.5)), brick("p", (1e-3, 2e-3, 1e-3), (321.0, 5.0, 5e-4))
    )
    assert area(found.points_W) == pytest.approx(2e-6, rel=1e-9)


# --- edges and corners ----------------------------------------------------------------------------------------------


def ladder(theta: float) -> Solid:
    """A plank whose lower face's edges touch the floor z = 0 and the wall x = L cos(theta)."""
    centre = turned(pitched(theta), (L / 2, 0.0, T / 2))
    return plank("ladder", centre, pitched(theta))


def test_a_ladder_stands_on_one_edge_and_leans_on_another() -> None:
    theta = radians(63.0)
    leaning = ladder(theta)
    on_floor = contact_with_plane(leaning, GROUND, TOLERANCES)
    assert on_floor is not None
    assert (on_floor.lower, on_floor.upper) == ("ground", "ladder")
    assert same_points(on_floor.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-16)
    wall = Plane("wall", (L * cos(theta), 0.0, 0.0), (-1.0, 0.0, 0.0), 0.0)
    on_wall = contact_with_plane(leaning, wall, TOLERANCES)
    assert on_wall is not None
    assert on_wall.normals_W == ((-1.0, 0.0, 0.0),)
    top = (L * cos(theta), L * sin(theta))
    assert same_points(on_wall.points_W, [(top[0], -W / 2, top[1]), (top[0], W / 2, top[1])], 1e-16)


def test_a_ladder_on_bricks_touches_them_as_it_touches_planes() -> None:
    theta = radians(50.0)
    leaning = ladder(theta)
    floor = brick("floor", (1.0, 0.01, 0.1), (0.0, 0.0, -0.05))
    found = contact(leaning, floor)
    assert found.lower == "floor"
    assert same_points(found.points_W, [(0.0, -0.005, 0.0), (0.0, 0.005, 0.0)], 1e-15)
    wall = brick("wall", (0.2, 1.0, 1.0), (L * cos(theta) + 0.1, 0.0, 0.5))
    on_wall = contact(leaning, wall)
    assert on_wall.normals_W[0] == pytest.approx((1.0, 0.0, 0.0), abs=1e-15)
    assert same_points(on_wall.points_W, [(L * cos(theta), y, L * sin(theta)) for y in (-W / 2, W / 2)], 1e-15)


def leaning_pair(theta: float) -> tuple[Solid, Solid]:
    """An inverted V whose upper edges meet at the origin."""
    x, z = L / 2 * cos(theta) + T / 2 * sin(theta), L / 2 * sin(theta) - T / 2 * cos(theta)
    return plank("a", (-x, 0.0, -z), pitched(theta)), plank("b", (x, 0.0, -z), pitched(pi - theta))


def disturbed(body: Solid, shift: Vec3, turn: Vec3) -> Solid:
    (x, y, z), turning = body.pose.position_W, IDENTITY
    for axis, angle in zip(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP), turn, strict=True):
        turning = composed(about(axis, angle), turning)
    pose = Pose((x + shift[0], y + shift[1], z + shift[2]), composed(turning, body.pose.orientation))
    return solid(Placed(Brick(body.id, body.size, 1.0), pose))


@pytest.mark.parametrize("theta", [20.0, 45.0, 60.0, 75.0])
def test_leaning_planks_admit_every_normal_of_both_edges(theta: float) -> None:
    # Face and end of one plank are the bounds for one, those of the other for the other: least of theta and 90 - theta.
    found = contact(*leaning_pair(radians(theta)))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-15)
    widest = min(theta, 90.0 - theta)
    assert elevations(found) == pytest.approx([-widest, widest])
    assert all(normal[0] > 0.0 for normal in found.normals_W)
    assert (found.lower, found.upper) == ("a", "b")


NOISE = st.tuples(*[st.floats(-1e-5, 1e-5)] * 3)
TILT = st.tuples(*[st.floats(-1e-4, 1e-4)] * 3)


@given(st.sampled_from([20.0, 45.0, 60.0, 75.0]), NOISE, TILT, NOISE, TILT)
def test_noise_of_settling_takes_no_normal_from_leaning_planks(
    theta: float, shift_a: Vec3, turn_a: Vec3, shift_b: Vec3, turn_b: Vec3
) -> None:
    # A scene without noise in all but one number is one that was meant so, not one that an engine left.
    assume(sum(abs(each) > 1e-5 for each in (*turn_a, *turn_b)) > 3 and max(map(abs, shift_a)) > 1e-6)
    a, b = leaning_pair(radians(theta))
    found = contact(disturbed(a, shift_a, turn_a), disturbed(b, shift_b, turn_b))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 8e-5)
    widest = min(theta, 90.0 - theta)
    assert elevations(found) == pytest.approx([-widest, widest], abs=0.05)


def test_crossing_edges_touch_in_a_point_with_the_normal_across_both() -> None:
    # Two cubes on edge, crosswise.
    lower = brick("a", CUBE, (0.0, 0.0, 0.0), pitched(ON_EDGE))
    upper = brick("b", CUBE, (0.3, 0.2, sqrt(2.0)), about((1.0, 0.0, 0.0), ON_EDGE))
    found = contact(lower, upper)
    assert found.normals_W[0] == pytest.approx(UP, abs=1e-15)
    assert same_points(found.points_W, [(0.0, 0.2, sqrt(0.5))], 1e-15)


def test_an_upright_corner_touches_a_face_in_a_point() -> None:
    # A cube that stands on a corner is as high as its diagonal.
    standing = composed(about((sqrt(0.5), -sqrt(0.5), 0.0), -asin(sqrt(2 / 3))), IDENTITY)
    height = max(-corner[2] for corner in brick("b", CUBE, (0.0, 0.0, 0.0), standing).corners_W)
    assert height == pytest.approx(sqrt(3.0) / 2.0)
    found = contact(brick("a", (4.0, 4.0, 1.0), (0.0, 0.0, 0.0)), brick("b", CUBE, (0.4, 0.3, 0.5 + height), standing))
    assert found.normals_W == (UP,)
    assert same_points(found.points_W, [(0.4, 0.3, 0.5)], 1e-15)


def test_stairs_that_touch_along_an_edge_press_upwards_and_sideways() -> None:
    found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (1.0, 0.25, 1.0)))
    assert same_points(found.points_W, [(0.5, -0.25, 0.5), (0.5, 0.5, 0.5)], 1e-15)
    assert sorted(found.normals_W) == [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]


def test_corners_that_meet_press_along_all_three_axes() -> None:
    found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (1.0, 1.0, 1.0)))
    assert same_points(found.points_W, [(0.5, 0.5, 0.5)], 1e-15)
    assert sorted(found.normals_W) == [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]


def test_a_corner_on_an_edge_admits_what_is_normal_to_the_edge_within_the_cone_of_the_corner() -> None:
    # A cube turned by 45 deg on the edge of another: its sides take away nothing from below, all from beside.
    found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (0.5 + sqrt(0.5), 0.1, 1.0), yawed(pi / 4.0)))
    assert same_points(found.points_W, [(0.5, 0.1, 0.5)], 1e-15)
    assert elevations(found) == pytest.approx([0.0, 90.0], abs=1e-6)


def test_a_brick_that_just_misses_an_edge_does_not_rest_on_it() -> None:
    # Within the tolerance the sides still touch, but their edge carries nothing.
    for miss in (1e-6, 1e-3):
        found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (1.0 + miss, 0.0, 1.0)))
        assert found.normals_W == ((1.0, 0.0, 0.0),)


def test_a_plank_across_the_edge_of_another_touches_it_at_that_edge() -> None:
    # Tilted by 10 deg about the far edge of the lower brick, with its own under side on that edge.
    tilt = pitched(-radians(10.0))
    x, _, z = turned(tilt, (0.02, 0.0, T / 2))
    found = contact(brick("a", CUBE, (-0.5, 0.0, -0.5)), plank("b", (x, 0.0, z), tilt))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-15)
    assert found.normals_W[0] == pytest.approx(turned(tilt, UP), abs=1e-15)


# --- planes ---------------------------------------------------------------------------------------------------------


def test_a_plank_on_tilted_ground_touches_it_with_its_face() -> None:
    tilt = pitched(0.4)
    slope = Plane("slope", (0.0, 0.0, 0.0), turned(tilt, UP), 0.3)
    found = contact_with_plane(plank("b", turned(tilt, (1.0, 0.0, T / 2)), tilt), slope, TOLERANCES)
    assert found is not None
    assert found.friction == 0.3
    corners = [turned(tilt, (1.0 + x, y, 0.0)) for x in (-L / 2, L / 2) for y in (-W / 2, W / 2)]
    assert same_points(found.points_W, corners, 1e-15)
    assert area(found.points_W) > 0.0


def test_a_ceiling_is_the_lower_body_by_definition() -> None:
    ceiling = Plane("ceiling", (0.0, 0.0, T / 2), (0.0, 0.0, -1.0), 0.5)
    found = contact_with_plane(plank("b", (0.0, 0.0, 0.0)), ceiling, TOLERANCES)
    assert found is not None
    assert (found.lower, found.normals_W) == ("ceiling", ((0.0, 0.0, -1.0),))
    assert len(found.points_W) == 4


# --- the tolerance --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gap", "touches"), [(0.99, True), (1.01, False), (-0.99, True), (-1.01, False)])
def test_bodies_touch_up_to_the_tolerance_apart_or_in_each_other(gap: float, touches: bool) -> None:
    height = T + gap * REACH
    for orientation in (yawed(pi / 2.0), yawed(0.5), composed(yawed(0.5), about((1.0, 0.0, 0.0), 1e-9))):
        assert (touch(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, height), orientation)) is not None) is touches
    assert (contact_with_plane(plank("b", (0.0, 0.0, height - T / 2)), GROUND, TOLERANCES) is not None) is touches


def test_the_smaller_of_two_bricks_sets_the_tolerance() -> None:
    slab = brick("slab", CUBE, (0.0, 0.0, -0.5))
    assert touch(slab, plank("b", (0.0, 0.0, T / 2 + 1.01 * REACH))) is None
    assert touch(slab, plank("b", (0.0, 0.0, T / 2 + 0.99 * REACH))) is not None


@given(NOISE, TILT, NOISE, TILT)
def test_noise_of_settling_moves_patch_corners_by_no_more_than_itself(
    shift_a: Vec3, turn_a: Vec3, shift_b: Vec3, turn_b: Vec3
) -> None:
    a, b = plank("a", (0.0, 0.0, 0.0)), plank("b", (0.03, 0.0, T), yawed(pi / 2.0))
    found = contact(disturbed(a, shift_a, turn_a), disturbed(b, shift_b, turn_b))
    assert len(found.normals_W) == 1
    assert same_points(found.points_W, contact(a, b).points_W, 5e-5)


@given(st.tuples(st.floats(-5e-4, 5e-4), st.floats(-5e-4, 5e-4)), st.floats(-0.3, 0.3))
def test_tilts_within_the_tolerance_leave_a_face_contact_one(tilt: tuple[float, float], gap: float) -> None:
    a, b = plank("a", (0.0, 0.0, 0.0)), plank("b", (0.05, 0.004, T + gap * REACH), yawed(0.3))
    found = contact(a, disturbed(b, (0.0, 0.0, 0.0), (tilt[0], tilt[1], 0.0)))
    assert len(found.points_W) == len(contact(a, b).points_W)
    assert same_points(
        [(x, y, 0.0) for x, y, _ in found.points_W], [(x, y, 0.0) for x, y, _ in contact(a, b).points_W], 1e-5
    )


# --- invariance -----------------------------------------------------------------------------------------------------


def scenes() -> list[tuple[Solid, Solid]]:
    v = leaning_pair(radians(60.0))
    return [
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (0.01, 0.003, T), yawed(0.5))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, W, 0.0))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (L, 0.0, T))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (L * (1.0 - 1e-6), 0.0, T))),
        (ladder(1.1), brick("floor", (1.0, 0.01, 0.1), (0.0, 0.0, -0.05))),
        v,
    ]


@given(
    st.integers(0, 5),
    st.sampled_from([1e-3, 1.0, 1e3]),
    st.floats(-pi, pi),
    st.sampled_from([(0.0, 0.0, 0.0), (1000.0, -1000.0, 50.0)]),
)
@example(2, 1e-3, 0.7, (1000.0, -1000.0, 50.0))
def test_size_place_and_yaw_change_nothing(scene: int, scale: float, yaw: float, shift: Vec3) -> None:
    pair = scenes()[scene]
    plain = contact(*pair)

    def placed(point: Vec3) -> Vec3:
        x, y, z = turned(yawed(yaw), point)
        return (scale * x + shift[0], scale * y + shift[1], scale * z + shift[2])

    def remade(body: Solid) -> Solid:
        size = (scale * body.size[0], scale * body.size[1], scale * body.size[2])
        return brick(body.id, size, placed(body.pose.position_W), composed(yawed(yaw), body.pose.orientation))

    found = contact(remade(pair[0]), remade(pair[1]))
    rounding = 1e-12 * scale + 1e-15 * 3e3 * (shift[0] != 0.0)
    assert same_points(found.points_W, [placed(point) for point in plain.points_W], rounding)
    sign = 1.0 if found.lower == plain.lower else -1.0
    expected = [turned(yawed(yaw), normal) for normal in plain.normals_W]
    assert same_points([(sign * x, sign * y, sign * z) for x, y, z in found.normals_W], expected, 1e-11)


def normalised(q: Quaternion) -> Quaternion:
    length = sqrt(sum(x * x for x in q))
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


ORIENTATIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(x * x for x in q) > 0.1).map(normalised)
SIZES = st.tuples(*[st.floats(0.3, 2.0)] * 3)


@given(SIZES, SIZES, ORIENTATIONS, st.floats(-pi, pi), st.floats(0.2, pi - 0.2))
def test_every_normal_parts_the_bodies_at_every_point(
    size_a: Vec3, size_b: Vec3, orientation: Quaternion, azimuth: float, polar: float
) -> None:
    # b comes in along a line until it touches; a plane through the contact then has a on one side and b on the other.
    away = (sin(polar) * cos(azimuth), sin(polar) * sin(azimuth), cos(polar))
    a = brick("a", size_a, (0.0, 0.0, 0.0))
    near, far = 0.0, 10.0
    for _ in range(50):
        middle = 0.5 * (near + far)
        b = brick("b", size_b, (middle * away[0], middle * away[1], middle * away[2]), orientation)
        near, far = (middle, far) if _deepest(a, b) > 0.0 else (near, middle)
    found = contact(a, brick("b", size_b, (far * away[0], far * away[1], far * away[2]), orientation))
    sign = 1.0 if found.lower == "a" else -1.0
    # Faces that are parallel to a degree may be taken as parallel: the tolerance, and no more, is their error.
    within = TOLERANCES.gap * min(*size_a, *size_b)
    for n, p in ((n, p) for n in found.normals_W for p in found.points_W):
        heights_a = [sign * sum(c * (v - q) for c, v, q in zip(n, corner, p, strict=True)) for corner in a.corners_W]
        heights_b = [sign * sum(c * (v - q) for c, v, q in zip(n, corner, p, strict=True)) for corner in b.corners_W]
        assert max(heights_a) <= within
        assert min(heights_b) >= -within


def _deepest(a: Solid, b: Solid) -> float:
    return -boxes_apart(a.size, a.pose, b.size, b.pose).gap
