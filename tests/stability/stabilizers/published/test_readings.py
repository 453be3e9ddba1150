"""The other readings of the published equations, and the rule that keeps moments, worked out by hand."""

from math import cos, hypot, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.vectors import add, norm
from stability.model import Vec3
from stability.stabilizers.published.leaning import LeaningArea, LeaningBrick, LeaningForces, leaning_forces
from stability.stabilizers.published.support import (
    AS_READ,
    ActsAt,
    CarriedLoad,
    Closest,
    ContactArea,
    Merge,
    Readings,
    Square,
    StackedBrick,
    contact_area,
    failing,
    loads_above,
    main_contact,
    shares,
)

LENGTH, WIDTH, THICKNESS, MASS = 0.1176, 0.0234, 0.0078, 0.012  # a KAPLA plank [m, kg]
HALF = WIDTH / 2.0
LEVER_RULE = Readings(merge=Merge.LEVER_RULE)
TO_THE_LETTER = Readings(acts_at=ActsAt.COM_ABOVE)


def strip(on: str, x: float, half: float = 0.01) -> ContactArea:
    """A contact across a plank's width, centred at x."""
    return contact_area(on, [(x + dx, dy, 0.0) for dx in (-half, half) for dy in (-HALF, HALF)])


APART = (strip("a", -0.04), strip("b", 0.04))


# --- two supports -----------------------------------------------------------------------------------------------------


def test_the_closest_point_of_a_contact_is_no_farther_than_its_closest_corner() -> None:
    #   com at 0      straight ahead on the edge of b, at 30 mm; so Eq. 7 gives 30 / 70 to each
    found = shares(CarriedLoad(1.0, (0.0, 0.0)), APART, Readings(pivot=Closest.POINT))
    assert [share.mass for share in found] == pytest.approx([3.0 / 7.0] * 2)
    assert [share.at[0] for share in found] == pytest.approx([-0.04, 0.04])


def test_equation_10_to_the_letter_puts_the_equivalent_mass_at_com_above() -> None:
    load = CarriedLoad(1.0, (0.005, 0.002))
    assert [share.at for share in shares(load, APART, TO_THE_LETTER)] == [load.com] * 2
    usual = [share.mass for share in shares(load, APART)]
    assert [share.mass for share in shares(load, APART, TO_THE_LETTER)] == usual


@pytest.mark.parametrize("equal_acts_at", list(ActsAt))
@pytest.mark.parametrize("acts_at", list(ActsAt))
def test_where_parts_act_on_two_supports_and_on_more_is_read_apart(acts_at: ActsAt, equal_acts_at: ActsAt) -> None:
    readings = Readings(acts_at=acts_at, equal_acts_at=equal_acts_at)
    com, two, three = (-0.02, 0.0), (-0.05, 0.02), (-0.05, 0.02, 0.05)
    for places, reading in ((two, acts_at), (three, equal_acts_at)):
        areas = tuple(strip(f"{x}", x) for x in places)
        found = [share.at[0] for share in shares(CarriedLoad(3.0, com), areas, readings)]
        assert found == pytest.approx(places if reading is ActsAt.CONTACT else [com[0]] * len(places))


def merged(readings: Readings) -> tuple[str, ...]:
    """Return the failing bricks of two parallel planks on the ground with one across their ends."""
    out = (LENGTH - WIDTH) / 2.0

    def lies_on(on: str, x: float, y: float, half: tuple[float, float]) -> ContactArea:
        return contact_area(on, [(x + a, y + b, 0.0) for a in (-half[0], half[0]) for b in (-half[1], half[1])])

    ground = {name: lies_on("ground", 0.0, y, (LENGTH / 2.0, HALF)) for name, y in (("a", -out), ("b", out))}
    stack = {
        name: StackedBrick(name, MASS, (0.0, y, 0.0), (ground[name],), ground[name].polygon)
        for name, y in (("a", -out), ("b", out))
    }
    ends = tuple(lies_on(name, out, y, (HALF, HALF)) for name, y in (("a", -out), ("b", out)))
    stack["c"] = StackedBrick("c", MASS, (out, 0.0, 0.0), ends, main_contact(ends))
    return failing(stack, loads_above(stack, readings))


def test_to_the_letter_the_first_plank_on_two_brings_both_of_them_down() -> None:
    #   Each is given 0.447 of a plank at the middle between them: its com above is 47.1 / 1.447 = 32.5 mm from there,
    #   and its contact begins at 35.4.
    assert merged(AS_READ) == ()
    assert merged(TO_THE_LETTER) == ("a", "b")
    assert merged(LEVER_RULE) == ()


@pytest.mark.parametrize(("x", "to_b"), [(0.0, 0.5), (0.01, 0.625), (-0.02, 0.25)])
def test_by_the_lever_rule_a_support_carries_as_the_other_is_far(x: float, to_b: float) -> None:
    #   a at -40 mm, b at +40 mm
    found = {share.on: share.mass for share in shares(CarriedLoad(2.0, (x, 0.0)), APART, LEVER_RULE)}
    assert found == pytest.approx({"a": 2.0 * (1.0 - to_b), "b": 2.0 * to_b})


@given(
    com=st.tuples(st.floats(-0.06, 0.06), st.floats(-0.02, 0.02)),
    places=st.tuples(st.floats(-0.1, -0.015), st.floats(0.015, 0.1)),
)
def test_the_lever_rule_keeps_load_and_moment_wherever_the_load_is(
    com: tuple[float, float], places: tuple[float, float]
) -> None:
    found = shares(CarriedLoad(3.0, com), (strip("a", places[0]), strip("b", places[1])), LEVER_RULE)
    assert sum(share.mass for share in found) == pytest.approx(3.0)
    for axis in (0, 1):
        assert sum(share.mass * share.at[axis] for share in found) == pytest.approx(3.0 * com[axis], abs=1e-12)
    assert all(share.mass >= 0.0 for share in found)


def test_the_published_shares_would_not_have_passed_that() -> None:
    found = shares(CarriedLoad(3.0, (0.0, 0.0)), APART)
    assert sum(share.mass for share in found) != pytest.approx(3.0, rel=0.05)


# --- leaning bricks ---------------------------------------------------------------------------------------------------


def across(x: float, z: float) -> tuple[Vec3, Vec3]:
    return ((x, -HALF, z), (x, HALF, z))


def ladder(angle: float, wall: float = 0.0) -> LeaningBrick:
    """A plank on the ground and against a wall, both contacts on its lower face."""
    foot = LeaningArea("ground", across(0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    top = LeaningArea("wall", across(LENGTH * cos(angle), LENGTH * sin(angle)), (-1.0, 0.0, 0.0), wall)
    return LeaningBrick(foot, top)


def middle(angle: float) -> float:
    """How far the centre of mass of that plank is from its foot, in plan [m]."""
    return (LENGTH * cos(angle) - THICKNESS * sin(angle)) / 2.0


def forces(angle: float, readings: Readings, wall: float = 0.0) -> LeaningForces:
    found = leaning_forces(ladder(angle, wall), CarriedLoad(MASS, (middle(angle), 0.0)), readings)
    assert found is not None
    return found


@pytest.mark.parametrize("degrees", [20.0, 45.0, 70.0])
def test_the_press_on_a_wall_is_the_torque_over_the_lever_and_the_sine_of_the_angle_that_is_read(
    degrees: float,
) -> None:
    #   Torque W x; lever L; angle of the lever to the force 90 deg, to gravity 90 deg - angle, to the normal the angle.
    #   The force perpendicular to the lever is projected onto the normal by the sine of the angle.
    angle = radians(degrees)
    square = MASS * middle(angle) / LENGTH * sin(angle)
    for read, sine in ((Square.FORCE, 1.0), (Square.GRAVITY, cos(angle)), (Square.NORMAL, sin(angle))):
        normal = forces(angle, Readings(leaning_angle=read)).normal_at_contact
        assert normal == pytest.approx((square / sine, 0.0, 0.0)), read


def test_a_contact_straight_above_the_pivot_has_no_lever_against_gravity() -> None:
    foot = LeaningArea("ground", across(0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    top = LeaningArea("wall", across(0.0, LENGTH), (-1.0, 0.0, 0.0), 0.0)
    load = CarriedLoad(MASS, (0.01, 0.0))
    assert leaning_forces(LeaningBrick(foot, top), load) is not None
    assert leaning_forces(LeaningBrick(foot, top), load, Readings(leaning_angle=Square.GRAVITY)) is None


def test_about_a_corner_the_torque_has_the_longer_arm_and_the_longer_lever() -> None:
    #   From a corner of the foot, b aside: arm hypot(x, b), lever hypot(L, b). Friction on the wall holds all.
    angle = radians(60.0)
    x = middle(angle)
    for closest, aside in ((Closest.POINT, 0.0), (Closest.CORNER, HALF)):
        found = forces(angle, Readings(leaning_pivot=closest), wall=100.0)
        pressing = norm(add(found.normal_at_contact, found.friction_at_contact))
        assert pressing == pytest.approx(MASS * hypot(x, aside) / hypot(LENGTH, aside))
