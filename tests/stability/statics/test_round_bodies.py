"""Round bodies: closed forms within a millionth of each limit, and the bodies that may roll."""

from collections.abc import Sequence
from math import asin, atan, cos, hypot, nextafter, pi, sin, sqrt, tan

import pytest

from stability.contact_law import Coulomb
from stability.geometry.box import Box
from stability.geometry.placed_shape import scaled
from stability.geometry.round_solid import RoundSolid, cylinder, frustum, pipe, sphere
from stability.geometry.vectors import about, add, multiply, rotate, scale, unit
from stability.loads import Load, Loads
from stability.model import IDENTITY, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.problem import Contact, Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces, check_motion
from stability.statics.tipping import tipping

RADIUS, HEIGHT = 0.03, 0.1
CAN = cylinder(RADIUS, HEIGHT)
LOG, BALL = cylinder(0.05, 0.4), sphere(0.05)
LYING: Quaternion = about((1.0, 0.0, 0.0), 0.5 * pi)  # its axis along y
ASIDE: Quaternion = about((0.0, 1.0, 0.0), 0.5 * pi)  # its axis along x
WEIGHT = 9.81  # [N] of a body of 1 kg
LESS, MORE = 1.0 - 1e-6, 1.0 + 1e-6
BEARINGS = (0.0, 0.123, 1.0)  # of loads; corners of a polygon fit the first at most


def placed(name: str, shape: ConvexShape, at: Vec3, turn: Quaternion = IDENTITY, mass: float = 1.0) -> Placed:
    return Placed(Brick(name, shape, mass), Pose(at, turn))


def ground(friction: float, normal: Vec3 = (0.0, 0.0, 1.0), name: str = "ground") -> Plane:
    return Plane(name, (0.0, 0.0, 0.0), normal, friction)


def verdict(
    bricks: Sequence[Placed], planes: Sequence[Plane], friction: float = 0.5, loads: Sequence[Load] = ()
) -> Verdict:
    """Return the verdict on bricks, after a check of its proof by arithmetic alone."""
    assembly = Assembly(planes=planes, friction=friction, loads=Loads(tuple(loads)))
    found = assembly.add_all(bricks)
    if found.stability is Stability.STABLE:
        forces = assembly.forces()
        assert forces is not None
        assert check_forces(assembly.problem(), forces, assembly.tolerances).holds
    if found.motion is not None:
        assert check_motion(assembly.problem(), found.motion, assembly.tolerances).holds
    return found


def stands(
    *bricks: Placed, planes: Sequence[Plane] = (ground(0.5),), friction: float = 0.5, loads: Sequence[Load] = ()
) -> bool:
    found = verdict(bricks, planes, friction, loads)
    assert found.stability is not Stability.UNDECIDED, found.reason
    return found.stability is Stability.STABLE


# Discs under moments.


@pytest.mark.parametrize("bearing", BEARINGS)
@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_pushed_can_tips_at_its_weight_times_radius_over_height(bearing: float, share: float, holds: bool) -> None:
    push, high = share * WEIGHT * RADIUS / 0.08, 0.08
    load = Load("can", (push * cos(bearing), push * sin(bearing), 0.0), (0.0, 0.0, high - 0.5 * HEIGHT))
    assert stands(placed("can", CAN, (0.0, 0.0, 0.5 * HEIGHT)), loads=[load]) is holds


@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_can_slides_at_friction_times_weight(share: float, holds: bool) -> None:
    push = share * 0.3 * WEIGHT
    load = Load("can", (push * cos(1.0), push * sin(1.0), 0.0), (0.0, 0.0, -0.5 * HEIGHT))
    assert stands(placed("can", CAN, (0.0, 0.0, 0.05)), planes=[ground(0.3)], loads=[load]) is holds


@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_moment_tips_a_can_at_weight_times_radius(share: float, holds: bool) -> None:
    moment = share * WEIGHT * RADIUS
    load = Load("can", (0.0, 0.0, 0.0), moment=(moment * cos(0.4), moment * sin(0.4), 0.0))
    assert stands(placed("can", CAN, (0.0, 0.0, 0.05)), loads=[load]) is holds


@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_can_resists_a_twist_up_to_friction_times_weight_times_radius(share: float, holds: bool) -> None:
    """The most that forces on the disc can do: all of them act at its rim."""
    load = Load("can", (0.0, 0.0, 0.0), moment=(0.0, 0.0, share * 0.3 * WEIGHT * RADIUS))
    assert stands(placed("can", CAN, (0.0, 0.0, 0.05)), planes=[ground(0.3)], loads=[load]) is holds


@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_can_on_a_slope_tips_where_its_centre_passes_the_rim(share: float, holds: bool) -> None:
    angle = atan(share * RADIUS / (0.5 * HEIGHT))
    normal = (sin(angle) * cos(0.3), sin(angle) * sin(0.3), cos(angle))
    turn = about((-sin(0.3), cos(0.3), 0.0), angle)
    x, y, z = normal
    can = placed("can", CAN, (0.05 * x, 0.05 * y, 0.05 * z), turn)
    assert stands(can, planes=[ground(0.9, normal)]) is holds


@pytest.mark.parametrize("bearing", BEARINGS)
@pytest.mark.parametrize(("share", "holds"), [(0.7, True), (LESS, True), (MORE, False), (1.7, False)])
def test_a_can_on_another_tips_where_its_centre_passes_the_rim_below(bearing: float, share: float, holds: bool) -> None:
    offset = share * RADIUS
    upper = placed("upper", CAN, (offset * cos(bearing), offset * sin(bearing), 0.15))
    assert stands(placed("lower", CAN, (0.0, 0.0, 0.05)), upper) is holds


@pytest.mark.parametrize(("offset", "holds"), [(LESS * RADIUS, True), (MORE * RADIUS, False)])
def test_a_can_tips_over_the_edge_of_a_box(offset: float, holds: bool) -> None:
    """Its disc ends at the edge, so the centre may be over the edge at most: from the rim by its radius."""
    can = placed("can", CAN, (0.05 - RADIUS + offset, 0.0, 0.15))
    assert stands(placed("box", Box((0.1, 0.1, 0.1)), (0.0, 0.0, 0.05)), can) is holds


def test_a_pipe_stands_on_the_disc_around_its_end_and_a_cone_on_either_end() -> None:
    assert stands(placed("pipe", pipe(0.1, 0.01, 0.3), (0.0, 0.0, 0.15)))
    for bottom, top in ((0.1, 0.04), (0.04, 0.1)):
        cone = frustum(bottom, top, 0.3)
        assert stands(placed("cone", cone, (0.0, 0.0, 0.15 + cone.centre_of_mass[2])))


@pytest.mark.parametrize(("share", "holds"), [(LESS, True), (MORE, False)])
def test_a_barrel_on_two_tips_where_its_centre_passes_their_common_border(share: float, holds: bool) -> None:
    """Its disc overlaps two discs in two lenses. The support ends at the line through the far ends of both.

    The lower barrels are at y = -0.31 and 0.31, the upper one at x > 0. A lens ends towards +x where both circles
    cross: at the middle between both centres, off their line by half the chord.
    """
    barrel = cylinder(0.3, 0.9)
    lower = [placed(f"l{sign}", barrel, (0.0, 0.31 * sign, 0.45), mass=200.0) for sign in (-1, 1)]
    low, high = 0.0, 0.3
    for _ in range(60):
        middle = 0.5 * (low + high)
        apart = hypot(middle, 0.31)
        half = sqrt(0.3**2 - 0.25 * apart**2)
        corner = 0.5 * middle + half * 0.31 / apart
        low, high = (middle, high) if corner > middle else (low, middle)
    upper = placed("upper", barrel, (share * low, 0.0, 1.35), mass=200.0)
    assert stands(*lower, upper) is holds


# Bodies that roll.


def rolls(*bricks: Placed, planes: Sequence[Plane] = (ground(0.5),), friction: float = 0.5) -> bool:
    """Return whether forces balance bodies, but nothing holds them in their places."""
    found = verdict(bricks, planes, friction)
    return found.stability is Stability.UNDECIDED and "may roll" in found.reason


def test_a_ball_and_a_log_on_level_ground_may_roll() -> None:
    assert rolls(placed("ball", BALL, (0.0, 0.0, 0.05)))
    assert rolls(placed("log", LOG, (0.0, 0.0, 0.05), LYING))
    assert rolls(placed("pipe", pipe(0.05, 0.01, 0.4), (0.0, 0.0, 0.05), LYING))


@pytest.mark.parametrize("angle", [1e-6, 0.1])
def test_a_ball_and_a_log_roll_down_any_slope(angle: float) -> None:
    normal = (sin(angle), 0.0, cos(angle))
    at = (0.05 * normal[0], 0.0, 0.05 * normal[2])
    for shape in (BALL, LOG):
        found = verdict([placed("it", shape, at, LYING)], [ground(0.5, normal)])
        assert found.stability is Stability.UNSTABLE
        assert found.reason == "it rolls on ground"


def test_a_log_lies_across_a_slope_along_its_line_of_fall() -> None:
    """Down its own axis it can only slide, at the friction angle, and aside it can roll on level lines."""
    for share, word in ((LESS, Stability.UNDECIDED), (MORE, Stability.UNSTABLE)):
        angle = atan(share * 0.5)
        normal = (sin(angle), 0.0, cos(angle))
        at = (0.05 * normal[0], 0.0, 0.05 * normal[2])
        turn = about((0.0, 1.0, 0.0), 0.5 * pi + angle)
        assert verdict([placed("log", LOG, at, turn)], [ground(0.5, normal)]).stability is word


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_log_is_held_in_a_wedge_with_or_without_friction(friction: float) -> None:
    sides = [ground(friction, (sign * 0.5, 0.0, sqrt(0.75)), f"side{sign}") for sign in (-1, 1)]
    assert stands(placed("log", LOG, (0.0, 0.0, 0.05 / sqrt(0.75)), LYING), planes=sides)
    assert rolls(placed("ball", BALL, (0.0, 0.0, 0.05 / sqrt(0.75))), planes=sides)  # along the wedge


@pytest.mark.parametrize(("lean", "holds"), [(-1e-6, True), (1e-6, False)])
def test_a_log_rests_against_a_smooth_wall_if_the_floor_falls_towards_it(lean: float, holds: bool) -> None:
    """The weight must lie between the normals of both planes; the wall is vertical at x = 0."""
    floor, wall = ground(0.0, unit((lean, 0.0, 1.0)), "floor"), ground(0.0, (1.0, 0.0, 0.0), "wall")
    at = (0.05, 0.0, 0.05 * sqrt(1.0 + lean * lean) - lean * 0.05)
    assert stands(placed("log", LOG, at, LYING), planes=[floor, wall], friction=0.0) is holds


@pytest.mark.parametrize(("share", "falls"), [(LESS, True), (MORE, False)])
def test_three_logs_need_friction_of_tan_15_degrees_and_a_third_of_it_below(share: float, falls: bool) -> None:
    """Friction about the axis of a lower log balances: N sin a = F (1 + cos a), so F / N = tan(a / 2), a = 30 degrees.

    The ground carries half of the upper log and the lower one, 3/2 of a weight, with the same F.
    """
    high = 0.05 * (1.0 + sqrt(3.0))
    pile = [
        placed("a", LOG, (-0.05, 0.0, 0.05), LYING),
        placed("b", LOG, (0.05, 0.0, 0.05), LYING),
        placed("c", LOG, (0.0, 0.0, high), LYING),
    ]
    needed = tan(pi / 12.0)
    for planes, friction in (([ground(1.0)], share * needed), ([ground(share * needed / 3.0)], 1.0)):
        found = verdict(pile, planes, friction)
        assert (found.stability is Stability.UNSTABLE) is falls
        assert falls or "may roll" in found.reason


@pytest.mark.parametrize(("share", "falls"), [(LESS, True), (MORE, False)])
def test_a_ball_on_three_needs_friction_of_the_tangent_of_half_its_angle(share: float, falls: bool) -> None:
    """The line of two centres leans by a, with sin a = 1 / sqrt(3); the ground needs a quarter of the friction."""
    across = 0.1 / sqrt(3.0)
    lower = [
        placed(f"b{i}", BALL, (across * cos(2 * pi * i / 3), across * sin(2 * pi * i / 3), 0.05)) for i in range(3)
    ]
    pile = [*lower, placed("top", BALL, (0.0, 0.0, 0.05 + 0.1 * sqrt(2.0 / 3.0)))]
    needed = tan(0.5 * asin(1.0 / sqrt(3.0)))
    for planes, friction in (([ground(1.0)], share * needed), ([ground(share * needed / 4.0)], 1.0)):
        found = verdict(pile, planes, friction)
        assert (found.stability is Stability.UNSTABLE) is falls


def chocked() -> list[Placed]:
    blocks = [placed(f"k{sign}", Box((0.1, 0.4, 0.1)), (sign * 0.15, 0.0, 0.05)) for sign in (-1, 1)]
    logs = [placed(f"l{sign}", LOG, (sign * 0.05, 0.0, 0.05), LYING) for sign in (-1, 1)]
    return [*blocks, *logs, placed("top", LOG, (0.0, 0.0, 0.05 * (1.0 + sqrt(3.0))), LYING)]


def test_blocks_on_both_sides_hold_a_pile_of_logs() -> None:
    assert stands(*chocked())


def test_balls_in_a_box_hold_one_another() -> None:
    """Four balls fill the floor of a box, and one lies on them: smooth walls hold all but its spin."""
    half = 0.1
    walls = [ground(0.0, normal, name) for name, normal in (("w", (1.0, 0.0, 0.0)), ("s", (0.0, 1.0, 0.0)))]
    walls += [
        Plane("e", (2 * half, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.0),
        Plane("n", (0.0, 2 * half, 0.0), (0.0, -1.0, 0.0), 0.0),
    ]
    balls = [placed(f"b{x}{y}", BALL, (0.05 + 0.1 * x, 0.05 + 0.1 * y, 0.05)) for x in (0, 1) for y in (0, 1)]
    top = placed("top", BALL, (0.1, 0.1, 0.05 + 0.1 * sqrt(0.5)))
    assert stands(*balls, top, planes=[ground(0.0), *walls], friction=0.0)


def test_crossed_logs_and_a_ball_on_a_box_may_roll() -> None:
    assert rolls(placed("a", LOG, (0.0, 0.0, 0.05), LYING), placed("b", LOG, (0.0, 0.0, 0.15), ASIDE))
    assert rolls(placed("box", Box((0.2, 0.2, 0.2)), (0.0, 0.0, 0.1)), placed("ball", BALL, (0.02, 0.0, 0.25)))


def test_a_plank_on_two_logs_rolls_unless_blocks_hold_the_logs() -> None:
    logs = [placed(f"l{sign}", LOG, (0.2 * sign, 0.0, 0.05), LYING) for sign in (-1, 1)]
    plank = placed("plank", Box((0.6, 0.3, 0.02)), (0.0, 0.0, 0.11))
    blocks = [placed(f"k{x}", Box((0.1, 0.4, 0.1)), (0.1 * x, 0.0, 0.05)) for x in (-3, -1, 1, 3)]
    assert rolls(*logs, plank)
    assert stands(*blocks, *logs, plank)


# Invariances.


def leaning_row(shape: RoundSolid, turn: Quaternion, shift: Vec3, size: float, names: str) -> list[Placed]:
    places = [(0.0, 0.0, 0.05), (0.02, 0.01, 0.15), (0.005, -0.01, 0.25)]
    return [
        Placed(
            Brick(name, scaled(shape, size), size**3),
            Pose(add(shift, rotate(turn, scale(size, place))), multiply(turn, about((0.0, 0.0, 1.0), 0.3 * number))),
        )
        for number, (name, place) in enumerate(zip(names, places, strict=True))
    ]


@pytest.mark.parametrize("names", ["abc", "cba"])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
@pytest.mark.parametrize("size", [1.0, 40.0])
def test_a_stack_of_cans_stands_wherever_it_is(names: str, angle: float, size: float) -> None:
    turn = about((0.0, 0.0, 1.0), angle)
    assert stands(*leaning_row(CAN, turn, (3.0, -2.0, 0.0), size, names))


def test_a_ball_above_its_contact_up_to_rounding_has_no_edge_to_tip_over() -> None:
    """The shift of the last digit is lost in the coordinates of a second point of the edge."""
    ball = placed("ball", BALL, (0.3, 1.5, 0.05))
    contact = Contact("ground", "ball", ((nextafter(0.3, 1.0), 1.5, 0.0),), ((0.0, 0.0, 1.0),), Coulomb(0.5))
    assert tipping({"ball": ball}, [contact]) is None
