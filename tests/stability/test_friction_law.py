"""Friction of two surfaces by body, by kind and by pair."""

from itertools import product

import pytest

from stability.contact_law import Friction, Rule, admit_friction
from stability.model import GROUND, Plane

GROUND_PLANE = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.6)


def test_of_two_surfaces_the_smoother_one_decides() -> None:
    law = Friction(0.5, own={"sheet": 0.1, "rubber": 0.9})
    assert law.of("sheet", "rubber") == law.of("rubber", "sheet") == 0.1
    assert law.of("rubber", "carton") == 0.5
    assert law.of("carton", "box") == 0.5


def test_a_brick_without_a_friction_of_its_own_has_that_of_the_plane_it_is_on() -> None:
    law = Friction(0.5, own={"sheet": 0.1, "rubber": 0.9})
    assert [law.on(brick, GROUND_PLANE) for brick in ("carton", "sheet", "rubber")] == [0.6, 0.1, 0.6]


@pytest.mark.parametrize(
    ("rule", "expected"), [(Rule.LOWER, 0.2), (Rule.HIGHER, 0.8), (Rule.MEAN, 0.5), (Rule.GEOMETRIC, 0.4)]
)
def test_another_rule_makes_another_number_of_two(rule: Rule, expected: float) -> None:
    assert Friction(0.5, own={"a": 0.2, "b": 0.8}, rule=rule).of("a", "b") == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(("rule", "coefficient"), list(product(Rule, (0.0, 0.1, 1.0 / 3.0, 1e-300, 1e300))))
def test_two_equal_surfaces_have_the_coefficient_of_each(rule: Rule, coefficient: float) -> None:
    assert Friction(0.5, own={"a": coefficient, "b": coefficient}, rule=rule).of("a", "b") == coefficient


def test_the_coefficient_of_a_pair_precedes_those_of_its_bricks() -> None:
    law = Friction(0.5, own={"sheet": 0.1}, between={("sheet", "carton"): 0.3, ("ground", "sheet"): 0.7})
    assert law.of("carton", "sheet") == 0.3
    assert law.of("sheet", "box") == 0.1
    assert law.on("sheet", GROUND_PLANE) == 0.7


def test_the_more_is_said_of_a_pair_by_name_the_more_it_counts() -> None:
    kinds = {"s1": "sheet", "s2": "sheet", "c1": "carton", "c2": "carton"}
    pairs = {("sheet", "carton"): 0.1, ("s1", "carton"): 0.2, ("c1", "s1"): 0.3, ("sheet", "sheet"): 0.4}
    law = Friction(0.5, between=pairs, kinds=kinds)
    assert [law.of("s2", "c2"), law.of("c2", "s1"), law.of("s1", "c1")] == [0.1, 0.2, 0.3]
    assert [law.of("s1", "s2"), law.of("c1", "c2")] == [0.4, 0.5]


def test_the_coefficient_of_a_brick_precedes_that_of_its_kind() -> None:
    law = Friction(0.5, own={"sheet": 0.1, "worn": 0.4}, kinds={"worn": "sheet", "new": "sheet"})
    assert [law.of("worn", "box"), law.of("new", "box"), law.of("worn", "new")] == [0.4, 0.1, 0.1]


def test_a_factor_scales_every_coefficient_and_those_of_pairs() -> None:
    law = Friction(0.5, own={"a": 0.2}, between={("b", "c"): 0.8}, rule=Rule.GEOMETRIC)
    for one, other in (("a", "b"), ("b", "c"), ("c", "d")):
        assert law.times(3.0).of(one, other) == pytest.approx(3.0 * law.of(one, other), rel=1e-12)


def test_bricks_of_one_surface_rub_alike_on_all_others() -> None:
    kinds = {"s1": "sheet", "s2": "sheet", "c1": "carton", "c2": "carton"}
    law = Friction(0.5, own={"sheet": 0.1, "c2": 0.3}, between={("sheet", "c1"): 0.2}, kinds=kinds)
    for one, other, third in product([*kinds, "x"], repeat=3):
        if one != other and third not in (one, other) and law.surface_of(one) == law.surface_of(other):
            assert law.of(one, third) == law.of(other, third)
    assert law.surface_of("s1") == law.surface_of("s2")
    assert len({law.surface_of(brick) for brick in (*kinds, "x")}) == 4


@pytest.mark.parametrize(
    ("friction", "words"),
    [
        (-0.1, "the friction is -0.1"),
        (float("nan"), "the friction is nan"),
        (Friction(float("inf")), "the friction is inf"),
        (Friction(0.5, own={"sheet": -1.0}), "the friction of 'sheet' is -1.0"),
        (Friction(0.5, between={("a", "b"): float("inf")}), "the friction between 'a' and 'b' is inf"),
        (Friction(0.5, between={("a", "b"): 0.1, ("b", "a"): 0.2}), "two friction coefficients between"),
    ],
)
def test_coefficients_that_mean_nothing_are_refused_by_name(friction: float | Friction, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        admit_friction(friction)


@pytest.mark.parametrize(
    "friction",
    ["0.5", True, Friction(0.5, own={"a": "0.1"}), Friction(0.5, between={"ab": 0.1}), Friction(0.5, rule="lower")],  # type: ignore[dict-item, arg-type]
)
def test_an_invalid_friction_coefficient_is_refused(friction: object) -> None:
    with pytest.raises(TypeError):
        admit_friction(friction)  # type: ignore[arg-type]
