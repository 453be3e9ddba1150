"""Building orders, and the props without which there are none."""

from contextlib import suppress

import pytest

from stability.analysis.building_order import OrderSearch, building_order, least_props
from stability.analysis.subset_search import Subsets, props_of
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from tests.planks import FLOOR, GRAVITY, WOOD, lying, plank


def box(name: str, size: tuple[float, float, float], x: float, z: float, mass: float = 1.0) -> Placed:
    return Placed(Brick(name, Box(size), mass), Pose((x, 0.0, z)))


def cantilever() -> Assembly:
    """A plank whose centre is 50 mm beyond the base, and a weight on its inner end."""
    design = Assembly()
    design.add_all(
        [
            box("base", (0.2, 0.1, 0.1), 0.0, 0.05),
            box("plank", (0.4, 0.1, 0.02), 0.15, 0.11),
            box("weight", (0.1, 0.1, 0.1), 0.0, 0.17, mass=2.0),
        ]
    )
    assert design.verdict().stability is Stability.STABLE
    return design


def test_a_leaning_column_is_built_from_below_without_props() -> None:
    design = Assembly((FLOOR,), WOOD, GRAVITY)
    design.add_all([Placed(plank(f"L{level}"), lying(level, 0.01 * level)) for level in range(1, 9)])
    found = building_order(Subsets(design, props_of(design)), most=100)
    assert [step.brick for step in found.steps] == [f"L{level}" for level in range(1, 9)]
    assert (found.props, found.props_at_least) == ((), 0)


def test_a_plank_that_only_a_weight_holds_needs_one_prop_until_the_weight_is_there() -> None:
    design = cantilever()
    found = building_order(Subsets(design, props_of(design)), most=100)
    assert found.without is not None
    assert found.without.impossible
    assert (found.props, found.props_at_least, found.props_at_once) == (("plank",), 1, 1)
    told = {step.brick: step for step in found.steps}
    assert [step.brick for step in found.steps] == ["base", "plank", "weight"]
    assert told["weight"].struck == ("plank",)


def test_without_props_it_is_proven_that_there_is_no_order() -> None:
    found = building_order(Subsets(cantilever()), most=100)
    assert (found.steps, found.impossible) == ((), True)


def test_a_prop_stands_only_where_the_underside_is_free() -> None:
    props = props_of(cantilever())
    assert set(props) == {"plank"}  # base and weight lie on all of theirs
    xs = [point[0] for contact in props["plank"].contacts for point in contact.points_W]
    assert min(xs) > 0.1 - 1e-9  # the base ends there


def test_a_brick_on_a_plank_blocks_no_room_under_it() -> None:
    # The middle of the plank and of the weight flush on all of it is 50 mm beyond the base.
    design = Assembly()
    size = (0.4, 0.1, 0.02)
    design.add_all(
        [box("base", (0.2, 0.1, 0.1), 0.0, 0.05), box("plank", size, 0.15, 0.11), box("on", size, 0.15, 0.13)]
    )
    assert design.verdict().stability is Stability.UNSTABLE
    props = props_of(design)
    xs = [point[0] for contact in props["plank"].contacts for point in contact.points_W]
    assert (min(xs), max(xs)) == pytest.approx((0.1, 0.35))
    parts = Subsets(design, props)
    assert least_props(parts, [parts.whole]) == ("plank",)


def test_beyond_its_verdicts_it_finds_an_order_whose_props_are_not_said_to_be_the_fewest() -> None:
    design = cantilever()
    found = building_order(Subsets(design, props_of(design)), most=1)
    assert found.props == ("plank",)
    assert found.props_at_least < len(found.props)


def test_a_search_that_is_interrupted_keeps_an_order_and_what_is_proven() -> None:
    # Two planks that only weights hold: each needs a prop.
    design = Assembly()
    for name, x in (("a", 0.0), ("b", 2.0)):
        sizes = (("base", (0.2, 0.1, 0.1), 0.0, 0.05, 1.0), ("plank", (0.4, 0.1, 0.02), 0.15, 0.11, 1.0))
        design.add_all([box(f"{what} {name}", size, x + dx, z, mass) for what, size, dx, z, mass in sizes])
        design.add_all([box(f"weight {name}", (0.1, 0.1, 0.1), x, 0.17, 2.0)])
    assert building_order(Subsets(design, props_of(design)), most=100).props == ("plank a", "plank b")
    for at in range(1, 30):
        parts = Subsets(design, props_of(design))

        def press(asked: int, at: int = at) -> None:
            if asked >= at:
                raise KeyboardInterrupt

        search = OrderSearch(parts, 100, press)
        with suppress(KeyboardInterrupt):
            search.run()
        if search.best.steps:
            break
    assert not search.best.impossible
    assert search.best.props == ("plank a", "plank b")
    assert search.best.steps[-1].struck == ("plank a", "plank b")


def test_a_falling_structure_gets_the_fewest_props() -> None:
    falling = Assembly()
    falling.add_all([box("base", (0.2, 0.1, 0.1), 0.0, 0.05), box("plank", (0.4, 0.1, 0.02), 0.15, 0.11)])
    parts = Subsets(falling, props_of(falling))
    assert least_props(parts, [parts.whole]) == ("plank",)
