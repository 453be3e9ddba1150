"""Frozen bricks pressed harder than they can take: sideways beyond friction, or down outside their load core."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt

import pytest

from stability.geometry.box import Box
from stability.model import GROUND, BodyId, Brick, ContactPoint, Pose, Vec3
from stability.problem import Placed
from stability.stabilizers.exact.overload import MOVED, Overloads
from stability.statics.assembly import Assembly
from tests.planks import FLOOR, GRAVITY, LENGTH, MASS, THICKNESS, WIDTH, WOOD, column, lying, standing

STEP = 1e-4  # [s]
TIPS_AFTER = 0.002  # [s]
LONG = 0.2  # [s]
WEIGHT = MASS * GRAVITY
NO_FRICTION: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class Pressing:
    """An engine in which one thing presses on one frozen brick with a force that stays."""

    brick: BodyId
    normal_W: Vec3  # from the frozen brick towards the pressing one
    force: float  # [N]
    at_W: Vec3 = (0.0, 0.0, 0.0)
    friction_W: Vec3 = NO_FRICTION  # on the pressing brick

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        point = ContactPoint("pusher", self.brick, self.at_W, self.normal_W, 0.0, self.force, self.friction_W)
        return [point] if brick in (self.brick, "pusher") else []


def gives_way_after(assembly: Assembly, pressing: Pressing) -> float:
    """When it is found first [s]."""
    overloads = Overloads(pressing, dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # no other engine method is used
    for steps in range(1, round(LONG / STEP) + 1):
        if overloads.overloaded(assembly, ["pusher"], STEP) == [pressing.brick]:
            return steps * STEP
    return inf


def pushed_aside(brick: BodyId, force: float) -> Pressing:
    return Pressing(brick, (0.0, 1.0, 0.0), force)


@pytest.mark.parametrize("times_friction", [2.0, 3.0, 10.0])
def test_a_plank_gives_way_when_it_would_slide_by_a_twentieth_of_a_millimetre(times_friction: float) -> None:
    #   A force F beyond friction mu w for a time t, J = (F - mu w) t, moves it by J^2 / (2 m mu w).
    friction = WOOD * WEIGHT
    distance = MOVED * THICKNESS
    assert distance == pytest.approx(5e-5, rel=0.01)
    expected = sqrt(2.0 * MASS * friction * distance) / ((times_friction - 1.0) * friction)
    found = gives_way_after(standing(column(1)), pushed_aside("L1", times_friction * friction))
    assert found == pytest.approx(expected, abs=STEP)


def test_friction_holds_a_plank_against_any_lesser_push_for_ever() -> None:
    assert gives_way_after(standing(column(1)), pushed_aside("L1", 0.99 * WOOD * WEIGHT)) == inf


@pytest.mark.parametrize(("weights", "holds"), [(8.9, True), (9.5, False)])
def test_friction_holds_a_loaded_plank_from_above_and_below(weights: float, holds: bool) -> None:
    #   The lowest of five: 4 w press from above, and 5 w on the floor.
    pressing = pushed_aside("L1", weights * WOOD * WEIGHT)
    assert (gives_way_after(standing(column(5)), pressing) == inf) is holds


@pytest.mark.parametrize(("share", "holds"), [(0.9, True), (1.1, False)])
def test_overload_counts_the_weight_of_the_pressing_brick(share: float, holds: bool) -> None:
    #   Down with 10 w, sideways by friction: mu (10 w + w) holds.
    dragging = (0.0, -share * WOOD * 11.0 * WEIGHT, 0.0)
    pressing = Pressing("L1", (0.0, 0.0, 1.0), 10.0 * WEIGHT, (0.0, 0.0, THICKNESS), dragging)
    assert (gives_way_after(standing(column(1)), pressing) == inf) is holds


#   |----b----|        b lies on a from its left end, at -18.8 mm, to the right end of a at 58.8 mm: its load core
# |----a----|
OVERHANG = 0.04
EDGE = LENGTH / 2.0


def pressed_down(x: float, weights: float) -> float:
    beam = standing({"a": lying(1), "b": lying(2, OVERHANG)})
    top = (x, 0.0, 2.0 * THICKNESS)
    return gives_way_after(beam, Pressing("b", (0.0, 0.0, 1.0), weights * WEIGHT, top))


@pytest.mark.parametrize("weights", [0.1, 1.0, 100.0])
def test_a_beam_takes_any_load_inside_its_load_core(weights: float) -> None:
    assert pressed_down(EDGE - 0.001, weights) == inf
    assert pressed_down(OVERHANG - EDGE + 0.001, weights) == inf


@pytest.mark.parametrize("beyond", [0.001, 0.01])
def test_a_load_outside_its_core_tips_it_when_it_outweighs_the_beam_and_stays_there(beyond: float) -> None:
    #   The beam's own weight is EDGE - OVERHANG inside of the edge over which it tips.
    enough = (EDGE - OVERHANG) / beyond
    assert pressed_down(EDGE + beyond, 0.98 * enough) == inf
    assert pressed_down(EDGE + beyond, 1.02 * enough) == pytest.approx(TIPS_AFTER, abs=1.1 * STEP)


def test_a_touch_outside_its_core_does_not() -> None:
    assert pressed_down(EDGE + 0.001, 0.04) == inf


def test_a_load_that_lifts_now_and_then_starts_again() -> None:
    beam = standing({"a": lying(1), "b": lying(2, OVERHANG)})
    pressing = Pressing("b", (0.0, 0.0, 1.0), WEIGHT, (EDGE + 0.04, 0.0, 2.0 * THICKNESS))
    overloads = Overloads(pressing, dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # no other engine method is used
    found = []
    for step in range(round(LONG / STEP)):
        pressing.force = 0.0 if step % 10 == 0 else WEIGHT  # enough to tip it
        found += overloads.overloaded(beam, ["pusher"], STEP)
    assert found == []


def given_way_after_half(assembly: Assembly, meanwhile: Callable[[Overloads], None]) -> bool:
    """Whether the lowest of a column gives way just when it should, if something happens half-way."""
    friction = WOOD * WEIGHT * (2 * len([brick for brick in assembly.bricks if brick.startswith("L")]) - 1)
    overloads = Overloads(pushed_aside("L1", 2.0 * friction), dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # likewise
    steps = int(sqrt(2.0 * MASS * friction * MOVED * THICKNESS) / friction / STEP) + 1
    for step in range(steps):
        if step == steps // 2:
            meanwhile(overloads)
        if overloads.overloaded(assembly, ["pusher"], STEP):
            return step == steps - 1
    return False


def test_bricks_elsewhere_do_not_change_an_overload() -> None:
    assembly = standing({**column(3), "far": Pose((10.0, 0.0, THICKNESS / 2.0))})

    def something_happens_far_away(overloads: Overloads) -> None:
        overloads.frozen(["far"])
        assembly.remove(["far"])
        overloads.woken(["far"])
        overloads.removed(["elsewhere"])

    assert given_way_after_half(assembly, something_happens_far_away)


def test_an_overload_is_computed_anew_after_a_new_contact() -> None:
    assembly = standing(column(3))

    def another_is_set_down_beside_it(overloads: Overloads) -> None:
        assembly.add(Brick("beside", Box((LENGTH, WIDTH, THICKNESS)), MASS), Pose((0.0, WIDTH, THICKNESS / 2.0)))
        overloads.frozen(["beside"])

    assert not given_way_after_half(assembly, another_is_set_down_beside_it)


def test_a_push_that_is_over_is_forgotten_as_fast_as_friction_takes_it_up() -> None:
    friction = WOOD * WEIGHT
    pressing = pushed_aside("L1", 2.0 * friction)
    assembly = standing({**column(1), "L0": Pose((1.0, 0.0, THICKNESS / 2.0))})
    overloads = Overloads(pressing, dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # no other engine method is used
    steps = int(sqrt(2.0 * MASS * friction * MOVED * THICKNESS) / friction / STEP)
    for _ in range(10):
        for brick in ["L1"] * steps + ["away"] * steps:  # the push lasts for a while, and is gone for as long
            pressing.brick = brick
            assert overloads.overloaded(assembly, ["pusher"], STEP) == []


@pytest.mark.parametrize("moving", [["pusher"], ["pusher", "another", "a third", "a fourth"]], ids=["few", "many"])
def test_contacts_are_read_from_the_frozen_brick_in_any_crowd(moving: list[str]) -> None:
    #   The rounding of a contact may depend on the body that is queried; here the pressing body has a wrong position.
    class Turned(Pressing):
        def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
            right = super().contacts(brick)
            return right if brick == self.brick else [replace(point, normal_force=0.0) for point in right]

    pressed = Turned("L1", (0.0, 1.0, 0.0), 10.0 * WOOD * WEIGHT)
    overloads = Overloads(pressed, dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # no other engine method is used
    assert overloads.overloaded(standing(column(2)), moving, LONG) == ["L1"]


def test_pressing_on_the_ground_is_no_overload() -> None:
    assert gives_way_after(standing(column(1)), Pressing(GROUND, (0.0, 0.0, 1.0), 100.0)) == inf


# A post of 20 x 20 x 120 mm, which tips over its foot's edge long before it slides.
HIGH, WIDE = 0.12, 0.02
POST_WEIGHT = 0.02 * GRAVITY


def post_pushed(sideways: float, weights: float) -> float:
    """By forces at the middle of its top, sideways and down, in units of its weight."""
    post = Assembly((FLOOR,), WOOD, GRAVITY)
    post.add_all([Placed(Brick("post", Box((WIDE, WIDE, HIGH)), 0.02), Pose((0.0, 0.0, HIGH / 2.0)))])
    aside = Pressing("post", (0.0, -1.0, 0.0), sideways * POST_WEIGHT, (0.0, 0.0, HIGH))
    if weights == 0.0:
        return gives_way_after(post, aside)
    dragging = (0.0, -sideways * POST_WEIGHT, 0.0)
    down = Pressing("post", (0.0, 0.0, 1.0), weights * POST_WEIGHT, (0.0, 0.0, HIGH), dragging)
    return gives_way_after(post, down)


@pytest.mark.parametrize("weights", [0.0, 1.0, 15.0])
def test_a_tall_post_is_tipped_by_a_push_at_its_top_that_friction_below_would_bear(weights: float) -> None:
    #   About the edge of its foot: F h = (N + w) b / 2.
    limit = (weights + 1.0) * WIDE / (2.0 * HIGH)
    assert limit < WOOD * (weights + 1.0)
    assert post_pushed(0.98 * limit, weights) == inf
    assert post_pushed(1.02 * limit, weights) == pytest.approx(TIPS_AFTER, abs=1.1 * STEP)


def test_forces_between_two_frozen_bricks_are_no_overload() -> None:
    pressed = Pressing("L1", (0.0, 1.0, 0.0), 10.0 * WOOD * WEIGHT)
    overloads = Overloads(pressed, dict, lambda _: TIPS_AFTER)  # type: ignore[arg-type]  # no other engine method is used
    for moving in (["elsewhere"], ["elsewhere", "far", "away"]):  # fewer than are frozen, and more
        assert overloads.overloaded(standing(column(2)), moving, LONG) == []
    assert overloads.overloaded(standing(column(2)), ["pusher"], LONG) == ["L1"]
