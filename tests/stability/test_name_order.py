"""Names in the order in which people count, and lists of names with ranges."""

from stability.name_order import in_order, names_text


def test_numbers_count_as_numbers() -> None:
    assert in_order(["L10.1", "L2.10", "L2.9", "L1.1"]) == ["L1.1", "L2.9", "L2.10", "L10.1"]


def test_a_name_comes_before_those_that_go_on_from_it() -> None:
    assert in_order(["L2", "L1.1", "L", "L1"]) == ["L", "L1", "L1.1", "L2"]


def test_letters_come_by_the_alphabet_and_zeros_in_front_change_no_number() -> None:
    assert in_order(["wall2", "ground", "wall10", "7", "wall02"]) == ["7", "ground", "wall02", "wall2", "wall10"]


JENGA = [f"L{level}.{place}" for level in range(1, 11) for place in (1, 2, 3)]


def test_a_range_stands_for_every_brick_between_its_ends() -> None:
    without_one = [name for name in JENGA if name != "L5.1"]  # pulled out before
    assert names_text(without_one[9:], among=without_one) == "L4.1 to L10.3 (20 bricks)"


def test_a_range_does_not_include_a_brick_that_is_not_meant() -> None:
    pairs = ["L5.1", "L5.2", "L6.1", "L6.2", "L7.1", "L7.2", "L7.3"]  # L5.3 and L6.3 are not meant
    assert names_text(pairs, among=JENGA) == "L5.1, L5.2, L6.1, L6.2, L7.1 to L7.3"
    column = ["L1.1", "L2.1", "L3.1", "L4.1"]
    assert names_text(column, among=column) == "L1.1 to L4.1 (4 bricks)"
    assert names_text(column, among=JENGA) == "L1.1, L2.1, L3.1, L4.1"


def test_names_alone_do_not_tell_where_a_level_ends() -> None:
    assert names_text(["L5.1", "L5.2", "L5.3", "L6.1"]) == "L5.1 to L5.3, L6.1"


def test_names_of_two_groups_or_without_a_level_are_not_joined() -> None:
    mixed = ["a.L1.1", "a.L1.2", "a.L1.3", "b.L1.4", "mid", "top"]
    assert names_text(mixed, among=mixed) == "a.L1.1 to a.L1.3, b.L1.4, mid, top"


def test_names_that_count_up_are_ranges_too() -> None:
    cartons = [f"C{number:03}" for number in range(1, 41)]
    assert names_text(cartons, among=cartons) == "C001 to C040 (40 bricks)"
    assert names_text([*cartons[:4], cartons[9]], among=cartons) == "C001 to C004, C010"
    assert names_text(["C009", "C010", "C011", "D1"]) == "C009 to C011, D1"


def test_a_range_tells_how_many_names_it_has_where_some_numbers_are_missing() -> None:
    sold = ["C1", "C2", "C5", "C6", "D1"]
    assert names_text(sold, among=sold) == "C1 to C6 (4 bricks), D1"


def test_a_long_list_tells_how_many_names_it_leaves_out() -> None:
    odd = JENGA[::2]
    assert names_text(odd, among=JENGA) == "L1.1, L1.3, L2.2, L3.1, L3.3, L4.2 and 9 more"
