"""Margins of round bricks: closed forms, which polygons inside round contacts come up to from below."""

from collections.abc import Sequence
from math import atan, cos, pi, sin, sqrt, tan

import pytest

from stability.contact_law import Coulomb
from stability.geometry.box import Box
from stability.geometry.round_solid import cylinder
from stability.geometry.vectors import about
from stability.joints import Bond, JointRule, Joints
from stability.loads import Load, Loads
from stability.model import IDENTITY, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed
from stability.statics.assembly import Assembly
from stackdsl.checking.cases import cases_of
from stackdsl.judging.proofs import margins_of_assembly, survival_of
from stackdsl.language.yaml.source import parse
from stackdsl.trace import VerdictMargins

RADIUS, HEIGHT = 0.03, 0.1
CAN, LOG = cylinder(RADIUS, HEIGHT), cylinder(0.05, 0.4)
LYING: Quaternion = about((1.0, 0.0, 0.0), 0.5 * pi)  # its axis along y
SHORT = 2e-3  # largest share by which a margin of round borders falls short of the closed form
EXACT = 1e-5  # the same of straight ones


def placed(name: str, shape: ConvexShape, at: Vec3, turn: Quaternion = IDENTITY) -> Placed:
    return Placed(Brick(name, shape, 1.0), Pose(at, turn))


def ground(friction: float, normal: Vec3 = (0.0, 0.0, 1.0), name: str = "ground") -> Plane:
    return Plane(name, (0.0, 0.0, 0.0), normal, friction)


def margins(bricks: Sequence[Placed], planes: Sequence[Plane], loads: Sequence[Load] = ()) -> VerdictMargins:
    assembly = Assembly(planes=planes, friction=0.5, loads=Loads(tuple(loads)))
    assembly.add_all(bricks)
    return margins_of_assembly(assembly, ("acceleration", "tilt", "friction", "load_factor"))


def short_of(found: float | None, closed_form: float, share: float) -> bool:
    """Return whether a margin is at most its closed form, and less by a share of it at most."""
    assert found is not None
    return (1.0 - share) * closed_form <= found <= (1.0 + 1e-9) * closed_form


@pytest.mark.parametrize("friction", [0.55, 0.65])
def test_a_can_slides_or_tips_at_the_lesser_of_friction_and_its_diameter_over_its_height(friction: float) -> None:
    found = margins([placed("can", CAN, (0.0, 0.0, 0.05))], [ground(friction)])
    tips = 2.0 * RADIUS / HEIGHT
    assert short_of(found.acceleration, min(friction, tips), SHORT if tips < friction else EXACT)
    assert short_of(found.tilt, atan(min(friction, tips)), SHORT)
    assert found.weakest is not None
    assert found.weakest.gives_way == f"can {'tips over' if tips < friction else 'slides on'} ground"


def test_a_can_survives_the_same_acceleration_along_every_bearing() -> None:
    assembly = Assembly(planes=[ground(0.9)], friction=0.5)
    assembly.add_all([placed("can", CAN, (0.0, 0.0, 0.5 * HEIGHT))])
    found = survival_of(assembly, 5, 1e-3)
    assert found is not None
    for each in found.along:
        assert short_of(each.survived, 2.0 * RADIUS / HEIGHT, SHORT)


def test_a_can_glued_to_the_ground_survives_by_its_glue_on_the_whole_disc() -> None:
    """As it tips over a point of its rim, the glue yields everywhere: its moment is the strength times pi r^3."""
    tension = 2e3  # [Pa]
    glued = Joints((JointRule(Bond(tension, 10.0 * tension), (frozenset({"can"}), frozenset({"ground"}))),))
    assembly = Assembly(planes=[ground(0.9)], friction=0.5, joints=glued)
    assembly.add_all([placed("can", CAN, (0.0, 0.0, 0.5 * HEIGHT))])
    found = survival_of(assembly, 4, 1e-2)
    assert found is not None
    weight = assembly.gravity * 1.0
    for each in found.along:
        borne = (tension * pi * RADIUS**3 + weight * RADIUS) / (weight * 0.5 * HEIGHT)
        assert short_of(each.survived, borne, 1e-2)


@pytest.mark.parametrize("bearing", [0.1])
def test_two_cans_tip_over_the_rim_that_their_centre_is_nearest_to(bearing: float) -> None:
    aside = 0.002
    upper = placed("upper", CAN, (aside * cos(bearing), aside * sin(bearing), 1.5 * HEIGHT))
    found = margins([placed("can", CAN, (0.0, 0.0, 0.5 * HEIGHT)), upper], [ground(2.0)])
    assert short_of(found.acceleration, (RADIUS - 0.5 * aside) / HEIGHT, 4e-4)
    assert found.bearing == pytest.approx(bearing, abs=0.06)


def test_a_can_on_a_slope_needs_friction_of_the_tangent_of_its_angle() -> None:
    angle = 0.3
    normal, turn = (sin(angle), 0.0, cos(angle)), about((0.0, 1.0, 0.0), angle)
    at = (0.05 * sin(angle), 0.0, 0.05 * cos(angle))
    found = margins([placed("can", CAN, at, turn)], [ground(0.9, normal)])
    assert found.friction == pytest.approx(tan(angle), rel=1e-6)


@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_a_log_in_a_wedge_rolls_over_a_side_or_slides_along_both(friction: float) -> None:
    """Friction presses the log into the wedge as well: along it, the limit is f / sqrt(cos^2 - f^2 sin^2)."""
    slope = pi / 6.0
    sides = [ground(friction, (sign * sin(slope), 0.0, cos(slope)), f"side{sign}") for sign in (-1, 1)]
    found = margins([placed("log", LOG, (0.0, 0.0, 0.05 / cos(slope)), LYING)], sides)
    along = friction / sqrt(cos(slope) ** 2 - (friction * sin(slope)) ** 2)
    assert short_of(found.acceleration, min(along, tan(slope)), EXACT)
    assert found.friction == 0.0


def test_a_push_on_a_can_may_grow_until_it_tips() -> None:
    push, high = 0.5, 0.08
    load = Load("can", (push * cos(1.0), push * sin(1.0), 0.0), (0.0, 0.0, high - 0.5 * HEIGHT))
    found = margins([placed("can", CAN, (0.0, 0.0, 0.5 * HEIGHT))], [ground(0.9)], [load])
    assert short_of(found.load_factor, 9.81 * RADIUS / (push * high), 4e-4)


@pytest.mark.slow
def test_a_box_on_two_lying_logs_between_blocks_has_the_margins_of_its_friction() -> None:
    """Blocks that do not touch the plank hold the logs, so the plank slides on them or the whole on the ground."""
    logs = [placed(f"l{sign}", LOG, (0.2 * sign, 0.0, 0.05), LYING) for sign in (-1, 1)]
    blocks = [placed(f"k{x}", Box((0.1, 0.4, 0.08)), (0.1 * x, 0.0, 0.04)) for x in (-3, -1, 1, 3)]
    plank = placed("plank", Box((0.6, 0.3, 0.02)), (0.0, 0.0, 0.11))
    assembly = Assembly(planes=[ground(2.0)], friction=Coulomb(0.2).friction)
    assembly.add_all([*logs, *blocks, plank])
    found = margins_of_assembly(assembly, ("acceleration",))
    assert short_of(found.acceleration, 0.2, EXACT)


@pytest.mark.parametrize("aside", [0.0, 0.004])
def test_a_can_on_another_may_be_displaced_by_half_of_what_is_left_of_the_radius(aside: float) -> None:
    """Both are displaced, against each other; the load of the upper one passes the rim of the lower one then."""
    cans = [placed("lower", CAN, (0.0, 0.0, 0.5 * HEIGHT)), placed("upper", CAN, (aside, 0.0, 1.5 * HEIGHT))]
    assembly = Assembly(planes=[ground(0.9)], friction=0.5)
    assembly.add_all(cans)
    assert short_of(margins_of_assembly(assembly, ("placement",)).placement, 0.5 * (RADIUS - aside), 4e-4)


def test_a_log_has_no_margin_of_placement() -> None:
    sides = [ground(0.5, (sign * 0.5, 0.0, sqrt(0.75)), f"side{sign}") for sign in (-1, 1)]
    assembly = Assembly(planes=sides, friction=0.5)
    assembly.add_all([placed("log", LOG, (0.0, 0.0, 0.05 / sqrt(0.75)), LYING)])
    assert margins_of_assembly(assembly, ("placement",)).placement is None


@pytest.mark.parametrize(
    ("claim", "allowed"),
    [
        ("margin: {acceleration: '>= 0.59 g', placement: '>= 1 mm'}", True),
        ("verdict: guaranteed", False),
        ("load: {is: '<= 20 N', bricks: [L1.1]}", True),
    ],
)
def test_some_margins_may_be_claimed_of_round_bricks_and_others_are_refused(claim: str, allowed: bool) -> None:
    text = (
        "scenario: can\nbrick: {cylinder: {diameter: 60 mm, height: 100 mm}, mass: 1 kg}\nfriction: 0.9\n"
        f"build: [{{bricks: [{{on: ground}}]}}]\nexpect: [{{{claim}}}]\n"
    )
    cases, mistakes = cases_of(parse(text, "can.yaml"))
    assert bool(cases) is allowed
    assert [mistake.code for mistake in mistakes] == ([] if allowed else ["SD212"])


@pytest.mark.parametrize(
    ("system", "turned", "allowed"), [("tuned", 90, False), ("exact", 90, True), ("tuned", 10, True)]
)
def test_a_cone_on_its_side_is_left_to_exact(system: str, turned: int, allowed: bool) -> None:
    text = (
        "scenario: cone\nbrick: {cone: {bottom: 60 mm, top: 20 mm, height: 80 mm}, mass: 1 kg}\n"
        f"build: [{{bricks: [{{at: [0 m, 0 m, 90 mm], rotate: [{turned} deg, 0 deg, 0 deg]}}]}}]\n"
        f"systems: [{system}]\nexpect: [{{stands: all}}]\n"
    )
    _, mistakes = cases_of(parse(text, "cone.yaml"))
    assert ("SD212" in [mistake.code for mistake in mistakes]) is not allowed


@pytest.mark.parametrize(
    ("joint", "claim", "allowed"),
    [
        ("bond: {tension: 1 kPa, cohesion: 1 kPa}", "verdict: stable", True),
        ("bond: {tension: 1 kPa, cohesion: 1 kPa}", "stands: all", False),
        ("pull: 2 N", "verdict: stable", False),
    ],
)
def test_joined_round_bricks_are_judged_at_rest_and_have_no_corners_to_pull(
    joint: str, claim: str, allowed: bool
) -> None:
    text = (
        "scenario: cans\nbrick: {cylinder: {diameter: 60 mm, height: 100 mm}, mass: 1 kg}\n"
        f"joints: [{{{joint}}}]\nbuild: [{{column: {{levels: 2}}}}]\nexpect: [{{{claim}}}]\n"
    )
    _, mistakes = cases_of(parse(text, "cans.yaml"))
    assert [mistake.code for mistake in mistakes] == ([] if allowed else ["SD212"])
