"""The published impact model against energies worked out by hand."""

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.model import Vec3
from stability.stabilizers.published.impacts import (
    ImpactEnergy,
    energy_of_flight,
    energy_of_load,
    energy_of_push,
    height_above,
)
from stability.stabilizers.published.leaning import LeaningArea, LeaningBrick
from stability.stabilizers.published.support import (
    ActsAt,
    ContactArea,
    Readings,
    StackedBrick,
    contact_area,
    loads_above,
    main_contact,
)

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # a KAPLA plank [m]
MASS = 557.0 * LENGTH * WIDTH * THICKNESS  # 11.956 g
GRAVITY = 9.81


def face(on: str, x: float, z: float, half: float = LENGTH / 2.0) -> ContactArea:
    """A contact across the width of planks that lie along x."""
    return contact_area(on, [(x + dx, dy, z) for dx in (-half, half) for dy in (-WIDTH / 2.0, WIDTH / 2.0)])


def plank(name: str, com_W: Vec3, *areas: ContactArea, mass: float = MASS) -> StackedBrick:
    return StackedBrick(name, mass, com_W, areas, main_contact(areas))


def column(count: int, bottom: float = 0.0) -> dict[str, StackedBrick]:
    """Flat planks straight above each other; 0 is the lowest."""
    stack = {}
    for k in range(count):
        z = bottom + k * THICKNESS
        on = str(k - 1) if k else "ground"
        stack[str(k)] = plank(str(k), (0.0, 0.0, z + THICKNESS / 2.0), face(on, 0.0, z))
    return stack


def four_stack(levels: int) -> dict[str, StackedBrick]:
    """Two flush planks a level, turned a quarter each level; named as 3- and 3+, levels counted from 1."""
    out, half = (LENGTH - WIDTH) / 2.0, WIDTH / 2.0
    stack: dict[str, StackedBrick] = {}
    for level in range(1, levels + 1):
        z = (level - 1) * THICKNESS
        along_x = level % 2 == 1
        for sign, side in (("-", -out), ("+", out)):
            com = (0.0, side, z + THICKNESS / 2.0) if along_x else (side, 0.0, z + THICKNESS / 2.0)
            areas = []
            for other, below in (("-", -out), ("+", out)):
                x, y = (below, side) if along_x else (side, below)
                on = f"{level - 1}{other}" if level > 1 else f"ground{other}"
                areas.append(contact_area(on, [(x + dx, y + dy, z) for dx in (-half, half) for dy in (-half, half)]))
            stack[f"{level}{sign}"] = StackedBrick(f"{level}{sign}", MASS, com, tuple(areas), main_contact(areas))
    return stack


def potential(brick: str, stack: dict[str, StackedBrick]) -> float:
    return energy_of_load(brick, stack, loads_above(stack), None, GRAVITY)


def limit_speed(brick: str, stack: dict[str, StackedBrick]) -> float:
    """How fast a plank like those of the stack must be to disturb one of them [m/s]."""
    return sqrt(2.0 * potential(brick, stack) / MASS)


@pytest.mark.parametrize(("speed", "disturbed"), [(0.2765, False), (0.2767, True)])
def test_a_lone_plank_is_disturbed_by_its_like_from_the_speed_of_a_fall_by_half_its_thickness(
    speed: float, disturbed: bool
) -> None:
    #   m v^2 / 2 = m g t / 2, so v = sqrt(g t) = 0.2766 m/s
    kinetic = energy_of_flight(MASS, (0.0, -speed, 0.0))
    assert ImpactEnergy(kinetic, potential("0", column(1))).disturbs is disturbed


@pytest.mark.parametrize("carried", [1, 2, 5, 12])
def test_in_a_column_the_limit_of_speed_grows_with_the_number_of_planks_above(carried: int) -> None:
    #   n planks from the hit one up: energy n m g (n t / 2), so v = n sqrt(g t)
    stack = column(13)
    assert limit_speed(str(13 - carried), stack) == pytest.approx(carried * sqrt(GRAVITY * THICKNESS))


@pytest.mark.parametrize(
    ("level", "planks", "height_mm", "speed"),
    [(13, 1.0, 3.9, 0.2766), (12, 1.8949, 7.584, 0.5310), (3, 6.7094, 34.447, 2.1295), (1, 7.2679, 38.976, 2.3575)],
)
def test_the_limits_of_a_tower_of_13_levels_worked_out_by_hand(
    level: int, planks: float, height_mm: float, speed: float
) -> None:
    #   Each support gets hypot(35.4, 11.7) / hypot(82.5, 11.7) = 0.44744 of a load, so with M, H of the level above a
    #   plank has M' = 1 + 0.89489 M planks above, and H' = (t / 2 + 0.89489 M (t + H)) / M' of height.
    stack = four_stack(13)
    loads = loads_above(stack)
    for brick in (f"{level}-", f"{level}+"):
        bottom = (level - 1) * THICKNESS
        assert loads[brick].mass / MASS == pytest.approx(planks, abs=1e-4)
        assert height_above(brick, stack, loads) - bottom == pytest.approx(height_mm / 1000.0, abs=1e-6)
        assert limit_speed(brick, stack) == pytest.approx(speed, abs=1e-4)


def test_read_at_the_height_of_the_contacts_level_3_gives_way_to_less_than_half_the_speed() -> None:
    #   The load passed on acts one thickness above the lower face: (t / 2 + 5.7094 t) / 6.7094 = 7.2187 mm: 0.975 m/s.
    stack = four_stack(13)
    readings = Readings(height_acts_at=ActsAt.CONTACT)
    energy = energy_of_load("3-", stack, loads_above(stack, readings), None, GRAVITY, readings)
    assert energy == pytest.approx(6.7094 * MASS * GRAVITY * 7.2187e-3, rel=1e-4)
    assert sqrt(2.0 * energy / MASS) == pytest.approx(0.9748, abs=1e-4)


@pytest.mark.parametrize("reading", list(ActsAt))
def test_the_energy_of_a_load_on_one_support_is_the_same_in_every_reading_of_merges(reading: ActsAt) -> None:
    stack = column(13)
    readings = Readings(height_acts_at=reading)
    energy = energy_of_load("0", stack, loads_above(stack, readings), None, GRAVITY, readings)
    assert energy == pytest.approx(13.0 * MASS * GRAVITY * 6.5 * THICKNESS)


def test_bricks_on_another_support_do_not_count_in_an_impact() -> None:
    #    |--b--|     com of b lies above a alone, which gets all its weight (merge case 1)
    #   |a|   |c|
    top = plank("b", (0.01, 0.0, 0.06), face("a", 0.0, 0.05, half=0.02), face("c", 0.1, 0.05, half=0.02))
    stack = {
        "a": plank("a", (0.0, 0.0, 0.025), face("ground", 0.0, 0.0, half=0.02)),
        "b": top,
        "c": plank("c", (0.1, 0.0, 0.025), face("ground", 0.1, 0.0, half=0.02)),
    }
    assert potential("a", stack) == pytest.approx(2.0 * MASS * GRAVITY * (0.025 + 0.06) / 2.0)
    assert potential("c", stack) == pytest.approx(MASS * GRAVITY * 0.025)


def test_heavy_bricks_above_raise_the_centre_of_mass_by_their_mass() -> None:
    #   3 m on m: com above of the lower one is at (t / 2 + 3 * 3 t / 2) / 4 = 1.25 t
    stack = column(2)
    stack["1"] = plank("1", stack["1"].com_W, *stack["1"].areas, mass=3.0 * MASS)
    assert potential("0", stack) == pytest.approx(4.0 * MASS * GRAVITY * 1.25 * THICKNESS)


def test_a_leaning_brick_is_measured_from_its_pivot() -> None:
    #   no main contact; com 50 mm up, the foot 10 mm up
    foot = LeaningArea("ground", ((0.0, -0.01, 0.01), (0.0, 0.01, 0.01)), (0.0, 0.0, 1.0), 0.5)
    top = LeaningArea("wall", ((0.05, 0.0, 0.09),), (-1.0, 0.0, 0.0), 0.5)
    stack = {"a": StackedBrick("a", MASS, (0.02, 0.0, 0.05), areas=(), main=())}
    energy = energy_of_load("a", stack, loads_above(stack), LeaningBrick(foot, top), GRAVITY)
    assert energy == pytest.approx(MASS * GRAVITY * 0.04)


def test_the_energy_of_a_push_is_that_of_a_free_brick() -> None:
    #   J = m v, so J^2 / (2 m) = m v^2 / 2
    assert energy_of_push(MASS, (0.0, MASS * 3.0, MASS * 4.0)) == pytest.approx(MASS * 12.5)
    assert energy_of_flight(MASS, (3.0, 4.0, 0.0)) == pytest.approx(MASS * 12.5)


def test_equal_energies_disturb_nothing() -> None:
    assert not ImpactEnergy(1.0, 1.0).disturbs


def test_an_impact_names_both_energies() -> None:
    assert str(ImpactEnergy(0.0053797, 0.0271069)) == "kinetic energy 5.38 mJ, potential energy 27.1 mJ"


@given(st.floats(-10.0, 10.0), st.sampled_from(["0", "3", "6"]))
def test_how_high_the_ground_is_changes_no_energy(bottom: float, brick: str) -> None:
    assert potential(brick, column(7, bottom)) == pytest.approx(potential(brick, column(7)), rel=1e-9)
