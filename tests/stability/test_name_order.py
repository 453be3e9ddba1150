"""Names in the order in which people count."""

from stability.name_order import in_order


def test_numbers_count_as_numbers() -> None:
    assert in_order(["L10.1", "L2.10", "L2.9", "L1.1"]) == ["L1.1", "L2.9", "L2.10", "L10.1"]


def test_a_name_comes_before_those_that_go_on_from_it() -> None:
    assert in_order(["L2", "L1.1", "L", "L1"]) == ["L", "L1", "L1.1", "L2"]


def test_letters_come_by_the_alphabet_and_zeros_in_front_change_no_number() -> None:
    assert in_order(["wall2", "ground", "wall10", "7", "wall02"]) == ["7", "ground", "wall02", "wall2", "wall10"]
