"""The published leaning model against its own equations, worked out by hand."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, radians, sin, sqrt, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.vectors import norm
from stability.model import Vec3
from stability.stabilizers.published.leaning import (
    RISE,
    LeaningArea,
    LeaningBrick,
    LeaningForces,
    failing_leaning,
    holds,
    leaning_brick,
    leaning_forces,
)
from stability.stabilizers.published.support import CarriedLoad

LENGTH, WIDTH, THICKNESS, MASS = 0.1176, 0.0234, 0.0078, 0.012  # a KAPLA plank [m, kg]
Change = Callable[[Vec3], Vec3]


def across(x: float, z: float) -> tuple[Vec3, Vec3]:
    """A line over the width of a plank."""
    return ((x, -WIDTH / 2.0, z), (x, WIDTH / 2.0, z))


def plank(angle: float) -> CarriedLoad:
    """A plank whose lower face begins at the origin and rises towards +x."""
    return CarriedLoad(MASS, ((LENGTH * cos(angle) - THICKNESS * sin(angle)) / 2.0, 0.0))


def ladder(angle: float, floor: float, wall: float) -> LeaningBrick:
    """A plank on the ground and against a wall, with these coefficients of friction."""
    #          |
    #        / |   both contacts on the lower face
    #      /   |
    # ___/_____|
    foot = LeaningArea("ground", across(0.0, 0.0), (0.0, 0.0, 1.0), floor)
    top = LeaningArea("wall", across(LENGTH * cos(angle), LENGTH * sin(angle)), (-1.0, 0.0, 0.0), wall)
    return LeaningBrick(foot, top)


def over_an_edge(angle: float, reach: float, floor: float, edge: float, slant: float) -> LeaningBrick:
    """A plank on the ground that lies on the edge of a body, this far up its lower face."""
    foot = LeaningArea("ground", across(0.0, 0.0), (0.0, 0.0, 1.0), floor)
    normal_W = (-sin(angle + slant), 0.0, cos(angle + slant))
    upper = LeaningArea("body", across(reach * cos(angle), reach * sin(angle)), normal_W, edge)
    return LeaningBrick(foot, upper)


def forces(brick: LeaningBrick, load: CarriedLoad) -> LeaningForces:
    found = leaning_forces(brick, load)
    assert found is not None
    return found


@pytest.mark.parametrize("degrees", [20.0, 45.0, 60.0, 75.0])
@pytest.mark.parametrize("wall", [0.0, 0.1, 0.2])
@pytest.mark.parametrize(("share", "stands"), [(1.0 + 1e-9, True), (1.0 - 1e-9, False)])
def test_a_ladder_stands_from_the_friction_that_equations_12_and_13_ask_for(
    degrees: float, wall: float, share: float, stands: bool
) -> None:
    #   Torque W (L cos - t sin) / 2 over the lever L, square to it: F. On the wall N = F sin, friction w N, less than
    #   F cos; on the floor W - w N, and N slides it: stable if f (W - w N) > N.
    angle = radians(degrees)
    pressing = (cos(angle) - THICKNESS / LENGTH * sin(angle)) / 2.0
    normal = pressing * sin(angle)
    assert wall * normal < pressing * cos(angle)
    assert holds(ladder(angle, share * normal / (1.0 - wall * normal), wall), plank(angle)) is stands


def test_the_forces_of_a_ladder_are_those_of_equation_13() -> None:
    angle = radians(60.0)
    found = forces(ladder(angle, 0.3, 0.2), plank(angle))
    normal = MASS * (cos(angle) - THICKNESS / LENGTH * sin(angle)) / 2.0 * sin(angle)
    assert found.normal_at_contact == pytest.approx((normal, 0.0, 0.0))  # of the plank on the wall
    assert found.friction_at_contact == pytest.approx((0.0, 0.0, -0.2 * normal))  # so the wall holds it up
    assert found.on_pivot == pytest.approx((-normal, 0.0, -MASS + 0.2 * normal))
    assert found.friction_at_pivot == pytest.approx(0.3 * (MASS - 0.2 * normal))


def test_flat_ladders_stand_with_far_less_friction_than_statics_ask_for() -> None:
    #   The published fault: the force on the wall comes out sin^2 too small. Statics: f >= (cot - t / L) / 2.
    angle = radians(20.0)
    asked = (1.0 / tan(angle) - THICKNESS / LENGTH) / 2.0
    assert holds(ladder(angle, 0.12 * asked, 0.0), plank(angle))
    assert not holds(ladder(angle, 0.11 * asked, 0.0), plank(angle))  # sin(20 deg)^2 = 0.117


@pytest.mark.parametrize("edge", [0.0, 0.5, 5.0])
def test_friction_on_an_edge_under_a_plank_does_nothing_because_nothing_slides_there(edge: float) -> None:
    #   The press is square to the lower face, so all of it is normal: F = W x / s, and on the floor F sin slides
    #   against f (W - F cos). A billionth of slant, as rounding leaves it, must not let friction act.
    angle, reach = radians(30.0), 0.08
    load = plank(angle)
    pressing = load.com[0] / reach
    limit = pressing * sin(angle) / (1.0 - pressing * cos(angle))
    for slant in (-1e-9, 0.0, 1e-9):
        assert holds(over_an_edge(angle, reach, limit + 1e-6, edge, slant), load)
        assert not holds(over_an_edge(angle, reach, limit - 1e-6, edge, slant), load)


def test_a_plank_that_falls_away_from_its_contact_is_held_as_if_it_pushed() -> None:
    #   The published fault behind its Fig. 14: the sign of the normal force is looked at nowhere.
    angle = radians(80.0)
    brick = ladder(angle, 0.3, 0.3)
    away = replace(brick, contact=replace(brick.contact, normal_W=(1.0, 0.0, 0.0)))
    assert holds(brick, plank(angle))
    assert holds(away, plank(angle))


def test_a_load_at_the_top_slides_a_leaning_plank_away() -> None:
    #   With m more at the top, the torque is W x + m L cos, and half a plank is too much at this friction.
    angle = radians(60.0)
    brick, alone = ladder(angle, 0.25, 0.0), plank(angle)
    assert holds(brick, alone)
    loaded = alone.plus(MASS / 2.0, (LENGTH * cos(angle), 0.0))
    assert not holds(brick, loaded)
    assert failing_leaning({"b": brick, "a": brick}, {"a": alone, "b": loaded}) == ("b",)


def test_one_contact_or_three_are_not_leaning() -> None:
    brick = ladder(radians(60.0), 1.0, 1.0)
    assert leaning_brick([brick.pivot, brick.contact], THICKNESS) == brick
    assert leaning_brick([brick.contact], THICKNESS) is None
    third = replace(brick.contact, on="other")
    assert leaning_brick([brick.pivot, brick.contact, third], THICKNESS) is None


@pytest.mark.parametrize(("rise", "leans"), [(1.01 * RISE * THICKNESS, True), (0.99 * RISE * THICKNESS, False)])
def test_contacts_at_nearly_one_height_are_not_leaning(rise: float, leans: bool) -> None:
    brick = ladder(radians(60.0), 1.0, 1.0)
    upper = replace(brick.contact, points_W=across(0.05, rise))
    assert (leaning_brick([brick.pivot, upper], THICKNESS) is not None) is leans


def test_the_lower_contact_is_the_pivot_whichever_comes_first() -> None:
    brick = ladder(radians(60.0), 0.3, 0.2)
    assert leaning_brick([brick.contact, brick.pivot], THICKNESS) == brick


def test_a_contact_on_the_axis_of_the_torque_holds_nothing() -> None:
    #   The centre of mass is out along x, so the weight turns the brick about y, and the contact lies along y.
    foot = LeaningArea("ground", ((0.0, 0.0, 0.0),), (0.0, 0.0, 1.0), 1.0)
    beside = LeaningArea("block", ((0.0, 0.05, 0.0),), (0.0, 0.0, 1.0), 1.0)
    assert leaning_forces(LeaningBrick(foot, beside), CarriedLoad(MASS, (0.02, 0.0))) is None


def test_the_centre_of_a_patch_is_that_of_its_area() -> None:
    #   The mean of the corners is not: it moves when a corner is given twice.
    brick = ladder(radians(60.0), 0.3, 0.2)
    (ax, ay, az), (_, by, _) = brick.contact.points_W
    square = ((ax, ay, az), (ax, by, az), (ax, by, az + 0.01), (ax, ay, az + 0.01))
    doubled = (*square, square[-1])
    one, other = (
        forces(replace(brick, contact=replace(brick.contact, points_W=points)), plank(radians(60.0)))
        for points in (square, doubled)
    )
    assert one.on_pivot == pytest.approx(other.on_pivot)


def changed(brick: LeaningBrick, load: CarriedLoad, change: Change, lengths: float = 1.0) -> LeaningForces:
    """Return the forces after a linear map of space that scales lengths."""

    def area(old: LeaningArea) -> LeaningArea:
        x, y, z = (part / lengths for part in change(old.normal_W))
        return replace(old, points_W=tuple(change(point) for point in old.points_W), normal_W=(x, y, z))

    x, y, _ = change((*load.com, 0.0))
    return forces(LeaningBrick(area(brick.pivot), area(brick.contact)), CarriedLoad(load.mass, (x, y)))


def skewed() -> tuple[LeaningBrick, CarriedLoad]:
    """A plank with its contacts off the middle."""
    brick = ladder(radians(65.0), 0.4, 0.3)
    top = ((0.05, 0.002, 0.1066), (0.05, 0.0117, 0.1066))
    return replace(brick, contact=replace(brick.contact, points_W=top)), plank(radians(65.0))


@given(st.floats(-pi, pi), st.booleans(), st.floats(0.01, 100.0))
def test_turning_about_the_vertical_mirroring_and_scaling_change_nothing(
    turn: float, mirror: bool, scale: float
) -> None:
    def change(point: Vec3) -> Vec3:
        x, y, z = point
        y = -y if mirror else y
        return (scale * (x * cos(turn) - y * sin(turn)), scale * (x * sin(turn) + y * cos(turn)), scale * z)

    brick, load = skewed()
    here, there = forces(brick, load), changed(brick, load, change, scale)
    assert there.friction_at_pivot == pytest.approx(here.friction_at_pivot)
    assert norm(there.sliding_at_pivot) == pytest.approx(norm(here.sliding_at_pivot))


@given(st.floats(1e-3, 1e3))
def test_heavier_planks_lean_alike(factor: float) -> None:
    brick, load = skewed()
    here, there = forces(brick, load), forces(brick, replace(load, mass=factor * load.mass))
    assert there.friction_at_pivot == pytest.approx(factor * here.friction_at_pivot)
    assert norm(there.sliding_at_pivot) == pytest.approx(factor * norm(here.sliding_at_pivot))


def test_an_inverted_v_needs_less_friction_than_statics_ask_for() -> None:
    #   At 70 deg: mu (1 - mu k) > k with k = sin (cos - t/L sin) / 2 = 0.1314, so mu > 0.1338; statics: 0.1488.
    angle = radians(70.0)
    k = sin(angle) * (cos(angle) - THICKNESS / LENGTH * sin(angle)) / 2.0
    limit = (1.0 - sqrt(1.0 - 4.0 * k * k)) / (2.0 * k)
    assert limit == pytest.approx(0.13376, abs=1e-5)
    assert holds(ladder(angle, 1.000001 * limit, 1.000001 * limit), plank(angle))
    assert not holds(ladder(angle, 0.999999 * limit, 0.999999 * limit), plank(angle))
