"""Orders of the support graph."""

from stability.graph import carried_by, from_the_top, with_all_above

#      d
#     / \        d rests on b and c, both on a, which stands on the ground; e stands beside them.
#    b   c
#     \ /
#      a    e
DIAMOND = {"a": ["ground"], "b": ["a"], "c": ["a"], "d": ["b", "c"], "e": ["ground"]}


def test_every_brick_comes_after_all_that_it_carries() -> None:
    order = from_the_top(DIAMOND)
    assert sorted(order) == sorted(DIAMOND)
    assert all(
        order.index(upper) < order.index(lower) for upper in DIAMOND for lower in DIAMOND[upper] if lower != "ground"
    )


def test_the_order_does_not_depend_on_how_the_graph_was_written() -> None:
    assert from_the_top(dict(reversed(DIAMOND.items()))) == from_the_top(DIAMOND) == ["d", "b", "c", "a", "e"]


def test_above_a_brick_are_all_bricks_that_it_carries_directly_or_indirectly() -> None:
    assert with_all_above(DIAMOND, ["b"]) == {"b", "d"}
    assert with_all_above(DIAMOND, ["a"]) == {"a", "b", "c", "d"}
    assert with_all_above(DIAMOND, []) == set()


def test_only_bricks_are_listed_as_carriers() -> None:
    assert carried_by(DIAMOND) == {"a": ["b", "c"], "b": ["d"], "c": ["d"], "d": [], "e": []}
