"""The published base model against its own equations, worked out by hand."""

from dataclasses import replace
from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.stabilizers.published.support import (
    CarriedLoad,
    ContactArea,
    StackedBrick,
    contact_area,
    failing,
    lies_above,
    loads_above,
    main_contact,
    shares,
    tipping_margin,
)

LENGTH, WIDTH, MASS = 0.1176, 0.0234, 0.012  # a KAPLA plank [m, kg]


def strip(on: str, x: float, half: float = 0.01, z: float = 0.0) -> ContactArea:
    """A contact across a plank's width, centred at x."""
    return contact_area(on, [(x + dx, dy, z) for dx in (-half, half) for dy in (-WIDTH / 2.0, WIDTH / 2.0)])


def plank(name: str, x: float, *areas: ContactArea) -> StackedBrick:
    return StackedBrick(name, MASS, (x, 0.0, 0.0), areas, main_contact(areas))


def stepped_column(count: int, step: float) -> dict[str, StackedBrick]:
    """Flat planks, each shifted by `step` from the one below; each rests on the overlap."""
    names = [f"{k:03}" for k in range(count)]
    stack = {names[0]: plank(names[0], 0.0, strip("ground", 0.0, LENGTH / 2.0))}
    for k in range(1, count):
        overlap = strip(names[k - 1], (k - 0.5) * step, (LENGTH - step) / 2.0)
        stack[names[k]] = plank(names[k], k * step, overlap)
    return stack


@pytest.mark.parametrize(("x", "stands"), [(0.0099, True), (0.01, True), (0.0101, False)])
def test_a_brick_stands_while_its_centre_is_above_its_contact(x: float, stands: bool) -> None:
    assert lies_above((x, 0.0), strip("below", 0.0).polygon) is stands


def test_masses_add_and_centres_average_by_mass_up_a_single_branch() -> None:  # Eq. 1 and 2
    loads = loads_above(stepped_column(3, 0.01))
    assert loads["000"].mass == pytest.approx(3.0 * MASS)
    assert loads["000"].com == pytest.approx((0.01, 0.0))
    assert loads["001"].com == pytest.approx((0.015, 0.0))


@pytest.mark.parametrize("step", [0.010, 0.012, 0.0135, 0.018])
def test_a_stepped_column_stands_while_count_times_step_is_within_a_length(step: float) -> None:
    limit = int(LENGTH / step)
    standing, falling = stepped_column(limit, step), stepped_column(limit + 1, step)
    assert failing(standing, loads_above(standing)) == ()
    assert failing(falling, loads_above(falling)) == ("001",)


def test_a_split_branch_carries_both_bricks_above_it() -> None:
    stack = {
        "base": plank("base", 0.0, strip("ground", 0.0, LENGTH / 2.0)),
        "left": plank("left", -0.05, strip("base", -0.04)),
        "right": plank("right", 0.03, strip("base", 0.03)),
    }
    load = loads_above(stack)["base"]
    assert load.mass == pytest.approx(3.0 * MASS)
    assert load.com == pytest.approx((-0.02 / 3.0, 0.0))


def test_merge_case_1_gives_all_the_weight_to_the_support_that_could_bear_it_alone() -> None:
    given_away = shares(CarriedLoad(2.0, (0.005, 0.0)), (strip("a", 0.0), strip("b", 0.05)))
    assert [(share.on, share.mass, share.at) for share in given_away] == [("a", 2.0, (0.005, 0.0))]


def test_merge_case_2_shares_equally_over_more_than_two_supports() -> None:
    areas = (strip("a", -0.05), strip("b", 0.02), strip("c", 0.05))
    given_away = shares(CarriedLoad(3.0, (-0.02, 0.0)), areas)
    assert [(share.on, share.mass) for share in given_away] == [("a", 1.0), ("b", 1.0), ("c", 1.0)]
    assert {share.at for share in given_away} == {(-0.02, 0.0)}  # "similar to the single branch case"


@pytest.mark.parametrize(("names", "beside"), [("ab", 0.0), ("ba", 0.0), ("ab", 5e-10), ("ba", -5e-10)])
def test_over_the_joint_of_two_supports_neither_name_bears_it_all(names: str, beside: float) -> None:
    #   |  com  |   Each touches over 20 mm, and either could bear it: by Eq. 3 to 9 each gets b / hypot(10, b).
    #   | a | b |
    areas = (strip(names[0], -0.01), strip(names[1], 0.01))
    expected = (WIDTH / 2.0) / hypot(0.01, WIDTH / 2.0)
    for share in shares(CarriedLoad(1.0, (beside, 0.0)), areas):
        assert share.mass == pytest.approx(expected, rel=1e-6)


def test_a_thousandth_of_a_millimetre_beside_the_joint_one_support_bears_it_all() -> None:
    areas = (strip("a", -0.01), strip("b", 0.01))
    assert [(share.on, share.mass) for share in shares(CarriedLoad(1.0, (1e-6, 0.0)), areas)] == [("b", 1.0)]


def test_over_the_joint_of_two_of_three_supports_the_third_gets_nothing() -> None:
    areas = (strip("a", -0.01), strip("b", 0.01), strip("c", 0.05))
    assert {share.on for share in shares(CarriedLoad(1.0, (0.0, 0.0)), areas)} == {"a", "b"}


def running_bond(courses: int, bricks: int, names: list[int]) -> dict[tuple[int, float], StackedBrick]:
    """Courses of abutting planks, each course half a plank in and one plank shorter, by course and place along it.

    Every plank has its centre over the joint of the two that it lies on.
    """
    spots = [(k, (0.5 * k + i) * LENGTH) for k in range(courses) for i in range(bricks - k)]
    name = {spot: f"{names[number]:03}" for number, spot in enumerate(spots)}

    def below(k: int, x: float) -> list[ContactArea]:
        if k == 0:
            return [strip("ground", x, LENGTH / 2.0)]
        near = {y: other for (j, y), other in name.items() if j == k - 1 and abs(y - x) < 0.75 * LENGTH}
        return sorted((strip(on, (x + y) / 2.0, LENGTH / 4.0) for y, on in near.items()), key=lambda area: area.on)

    return {(k, x): plank(name[k, x], x, *below(k, x)) for k, x in spots}


@given(st.permutations(range(15)))
def test_names_decide_nothing_in_a_running_bond(names: list[int]) -> None:
    wall, other = running_bond(5, 5, list(range(15))), running_bond(5, 5, names)
    loads, renamed = (loads_above({brick.id: brick for brick in each.values()}) for each in (wall, other))
    for spot, brick in wall.items():
        assert renamed[other[spot].id].mass == pytest.approx(loads[brick.id].mass)
        assert renamed[other[spot].id].com == pytest.approx(loads[brick.id].com, abs=1e-12)


def test_a_running_bond_that_is_mirrored_carries_mirrored_loads() -> None:
    wall = running_bond(5, 5, list(range(15)))
    loads = loads_above({brick.id: brick for brick in wall.values()})
    for (course, x), brick in wall.items():
        (opposite,) = (each.id for (k, y), each in wall.items() if k == course and abs(x + y - 4 * LENGTH) < 1e-9)
        mirrored = loads[opposite]
        assert mirrored.mass == pytest.approx(loads[brick.id].mass)
        assert mirrored.com[0] == pytest.approx(4 * LENGTH - loads[brick.id].com[0])


def test_merge_case_3_takes_the_torque_about_the_other_supports_nearest_contact_point() -> None:  # Eq. 3 to 9
    #   com at 0      pivot of a's share: the corner of b at (40 - 10, 11.7) mm, the nearest to com
    #   a at -40, b at +40; each 20 mm long; so Eq. 7 gives |com - pivot| / |centre of a - pivot| in plan
    expected = hypot(0.030, WIDTH / 2.0) / hypot(0.070, WIDTH / 2.0)
    for share in shares(CarriedLoad(1.0, (0.0, 0.0)), (strip("a", -0.04), strip("b", 0.04))):
        assert share.mass == pytest.approx(expected)
        assert abs(share.at[0]) == pytest.approx(0.04)


def handed_on(apart: float, half: float, centre: float) -> tuple[float, float]:
    """Return the shares of a load of 1 at `centre` on two supports: weight, and moment about their middle [m].

    With the supports at -a and +a, their edges h from there, half a width b across, and the load at c, Eq. 7 to 9 give
    the two hypot(a - h - c, b) and hypot(a - h + c, b), both over hypot(2 a - h, b), at -a and +a.
    """
    one, other = shares(
        CarriedLoad(1.0, (centre, 0.0)), (strip("a", -apart / 2.0, half), strip("b", apart / 2.0, half))
    )
    return one.mass + other.mass, one.mass * one.at[0] + other.mass * other.at[0]


FLUSH, SQUARE = LENGTH - WIDTH, WIDTH / 2.0  # two planks under the ends of a third, as in a four-stack


def test_far_apart_supports_are_given_less_than_the_weight() -> None:
    assert handed_on(FLUSH, SQUARE, 0.0)[0] == pytest.approx(0.895, abs=0.001)


def test_supports_close_together_are_given_more_than_the_weight() -> None:
    on_edge = 0.0078 / 2.0  # two planks on their long edges, 12 mm from middle to middle
    assert handed_on(0.012, on_edge, 0.0)[0] == pytest.approx(1.67, abs=0.01)


@pytest.mark.parametrize(("apart", "half", "kept"), [(FLUSH, SQUARE, 1.07), (0.012, 0.0039, 0.15)])
def test_the_moment_about_the_middle_of_the_supports_is_not_kept_either(apart: float, half: float, kept: float) -> None:
    assert handed_on(apart, half, 0.002)[1] / 0.002 == pytest.approx(kept, abs=0.01)


@pytest.mark.parametrize("behind", [0.03, 0.06, 0.12])
def test_a_stack_that_leans_out_loses_moment_about_an_edge_far_below(behind: float) -> None:
    weight, moment = handed_on(2.0 / 3.0 * LENGTH, SQUARE, 0.01)
    assert weight * behind + moment < behind + 0.01


@pytest.mark.parametrize("centre", [-0.02, -0.005, 0.0, 0.005, 0.02])
def test_the_support_nearer_to_the_load_takes_the_larger_share(centre: float) -> None:
    one, other = shares(CarriedLoad(1.0, (centre, 0.0)), (strip("a", -0.04), strip("b", 0.04)))
    assert (one.mass > other.mass) is (centre < 0.0)


@pytest.mark.parametrize("levels", [2, 5, 25])
def test_a_straight_four_stack_stands_with_the_equivalent_mass_at_the_contact_centre(levels: int) -> None:
    stack = four_stack(levels)
    loads = loads_above(stack)
    assert failing(stack, loads) == ()
    assert min(tipping_margin(stack[name], loads[name]) for name in stack) > 0.005


def four_stack(levels: int) -> dict[str, StackedBrick]:
    """Two flush planks a level, turned a quarter each level."""
    out = (LENGTH - WIDTH) / 2.0
    stack: dict[str, StackedBrick] = {}
    for level in range(levels):
        for side in (-1.0, 1.0):
            name = f"{level:02}{'-+'[side > 0.0]}"
            com = (0.0, side * out, 0.0) if level % 2 == 0 else (side * out, 0.0, 0.0)
            if level == 0:
                corners = [(dx * LENGTH / 2.0, com[1] + dy * WIDTH / 2.0, 0.0) for dx in (-1, 1) for dy in (-1, 1)]
                areas: tuple[ContactArea, ...] = (contact_area("ground", corners),)
            else:
                areas = tuple(
                    crossing(f"{level - 1:02}{'-+'[below > 0.0]}", level, side, below) for below in (-1.0, 1.0)
                )
            stack[name] = StackedBrick(name, MASS, com, areas, main_contact(areas))
    return stack


def crossing(on: str, level: int, side: float, below: float) -> ContactArea:
    out = (LENGTH - WIDTH) / 2.0
    x, y = (below * out, side * out) if level % 2 == 0 else (side * out, below * out)
    return contact_area(on, [(x + dx * WIDTH / 2.0, y + dy * WIDTH / 2.0, 0.0) for dx in (-1, 1) for dy in (-1, 1)])


@given(st.floats(-10.0, 10.0), st.floats(0.001, 1000.0))
def test_moving_the_stack_and_scaling_its_mass_changes_no_verdict(shift: float, factor: float) -> None:
    def moved(area: ContactArea) -> ContactArea:
        return contact_area(area.on, [(x + shift, y, z) for x, y, z in area.points_W])

    for count in (8, 9):
        stack = stepped_column(count, 0.0135)
        other = {
            name: StackedBrick(
                name, brick.mass * factor, (brick.com_W[0] + shift, 0.0, 0.0), areas, main_contact(areas)
            )
            for name, brick in stack.items()
            for areas in [tuple(moved(area) for area in brick.areas)]
        }
        assert failing(other, loads_above(other)) == failing(stack, loads_above(stack))


@given(st.permutations(range(9)), st.permutations(range(9)))
def test_renaming_and_reordering_bricks_changes_no_verdict(names: list[int], order: list[int]) -> None:
    stack = stepped_column(9, 0.0135)
    new = {name: f"{names[index]:03}" for index, name in enumerate(stack)} | {"ground": "ground"}
    bricks = [
        replace(
            brick,
            id=new[name],
            areas=tuple(replace(area, on=new[area.on]) for area in brick.areas),
        )
        for name, brick in stack.items()
    ]
    renamed = {bricks[index].id: bricks[index] for index in order}
    loads = loads_above(renamed)
    assert failing(renamed, loads) == (new["001"],)
    for name, load in loads_above(stack).items():
        assert loads[new[name]].com == pytest.approx(load.com)
