"""What needs friction to rest may be unable to do anything else; or it may let go, and then how is told."""

from math import cos, radians, sin, tan

import pytest

from stability import outcome
from stability.analysis.uniqueness import RestOutcome
from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.model import EARTH, Brick, Pose
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stability.statics.initial_motion import check_start, find_start
from tests.stability.analysis.leaning_scenes import (
    aslant_between_walls,
    box,
    ladder,
    pile_on_a_slope,
    plane,
    slope_of_the_diagonal,
    standing,
)

ASLANT = 20.0  # [deg]


def of(assembly: Assembly) -> RestOutcome:
    return outcome(assembly.problem(), assembly.forces())


def test_the_outcome_of_a_structure_held_by_self_stress_names_its_fall_without_it() -> None:
    made = Assembly((plane("left", 90.0, 0.8), plane("right", -90.0, 0.8, x=0.3)), 0.8)
    verdict = made.add(Brick("bar", Box((0.3, 0.2, 0.05)), 1.0), Pose((0.15, 0.0, 1.0)))
    assert verdict.stability is Stability.UNDECIDED
    assert "only self-stress" in verdict.reason
    assert verdict.reason.endswith("without these forces, bar slides down along left, right: nothing is under it")


@pytest.mark.parametrize("friction", [0.5, 1.0])
@pytest.mark.parametrize("count", [1, 2, 3, 5, 8, 20, 50])
def test_a_row_between_upright_walls_is_not_proven_to_stand_and_falls_freely_if_nothing_has_squeezed_it(
    count: int, friction: float
) -> None:
    # Thrown up into an arch it would hold. But as it falls it presses nothing, and so no load brings such forces forth.
    walls = (plane("west", 90.0, friction), plane("east", -90.0, friction, x=0.1 * count))
    made = Assembly(walls, friction)
    verdict = made.add_all([box(f"b{i}", (0.1, 0.1, 0.1), 0.1 * (i + 0.5), 1.0) for i in range(count)])
    assert verdict.stability is Stability.UNDECIDED
    start = find_start(made.problem(), Tolerances())
    assert start is not None
    assert [velocity for velocity, _ in start.acceleration.velocity.values()] == [
        pytest.approx((0.0, 0.0, -EARTH), rel=1e-12)
    ] * count


def test_of_more_bricks_than_are_told_apart_by_cases_a_start_is_shown() -> None:
    # A lid on a post reaches over a wedge on a slope that is steeper than its friction. The lid can press it tight, as
    # half of 50 deg is less than the angle of friction, or rest on the post alone: then the wedge slides.
    slope, friction, top = 50.0, 0.9, 0.55
    low, high = 0.3 * tan(radians(slope)), 0.4 * tan(radians(slope))
    made_of = prism([(-0.4, high), (-0.3, low), (-0.3, top), (-0.4, top)], 0.2)
    post = box("post", (0.2, 0.2, top), 0.3, 0.5 * top)
    lid = box("lid", (1.3, 0.2, 0.05), 0.2, top + 0.025)
    pile = [box(f"b{i}", (0.2, 0.2, 0.05), 0.35, top + 0.05 * (i + 1.5)) for i in range(4)]
    wedge = Placed(Brick("wedge", made_of.shape, 0.5), Pose(made_of.centre_of_mass))
    made = standing(post, wedge, lid, *pile, planes=(LEVEL_GROUND, plane("slope", slope, friction)), friction=friction)
    found = of(made)
    assert not found.guaranteed
    assert found.reason == "the bricks could also start to move: wedge slides on slope"


@pytest.mark.parametrize("share", [0.5, 0.99, 1.0 - 1e-6])
@pytest.mark.parametrize("angle", [3.0, 30.0])
def test_a_block_on_a_slope_below_its_friction_angle_can_only_rest(angle: float, share: float) -> None:
    # To slide it would need m a = m g sin - mu m g cos > 0, and so tan > mu.
    found = of(pile_on_a_slope(1, angle, tan(radians(angle)) / share))
    assert found.guaranteed
    assert found.normal is None
    assert all(group.holds() for group in found.braced)


def test_a_pile_on_a_slope_can_only_rest() -> None:
    found = of(pile_on_a_slope(3, 10.0, 0.5))
    assert found.guaranteed
    assert found.reason == "friction is needed, and no motion is possible"


@pytest.mark.parametrize("wall", [0.0, 0.3])
def test_a_ladder_that_the_floor_holds_can_only_rest(wall: float) -> None:
    found = of(ladder(60.0, 0.5, wall))
    assert found.guaranteed
    assert all(group.holds() for group in found.braced)


def test_a_plank_on_level_ground_needs_no_friction() -> None:
    found = of(standing(box("a", (1.0, 0.3, 0.06), 0.0, 0.03)))
    assert found.guaranteed
    assert found.normal is not None
    assert found.reason == ""


def test_a_plank_aslant_between_walls_holds_if_their_mean_friction_is_the_slope_of_its_diagonal() -> None:
    # N presses at both ends; the upper end carries W / 2 - N s, the lower W / 2 + N s, with s the slope.
    slope, lower = slope_of_the_diagonal(ASLANT), 0.5
    upper = 2.0 * slope - lower
    assert 0.0 < upper < slope < lower
    assert aslant_between_walls(ASLANT, lower, upper + 1e-6).verdict().stability is Stability.STABLE
    assert aslant_between_walls(ASLANT, lower, upper - 1e-6).verdict().stability is Stability.UNSTABLE


def test_a_plank_aslant_between_walls_can_fall_freely_as_well_as_rest() -> None:
    # Where nothing presses, nothing rubs: free fall along both walls obeys every law.
    made = aslant_between_walls(ASLANT, 0.6, 0.1)
    found = of(made)
    assert not found.guaranteed
    assert found.start is not None
    velocity, spin = found.start.acceleration.velocity["plank"]
    assert velocity == pytest.approx((0.0, 0.0, -EARTH))
    assert spin == pytest.approx((0.0, 0.0, 0.0))
    assert max(abs(part) for contact in found.start.forces.of_contacts for (f,) in contact for part in f) < 1e-12
    assert found.reason == (
        "the bricks could also start to move: plank slides down along left, right: nothing is under it"
    )
    assert check_start(made.problem(), found.start, Tolerances()).holds


def test_whatever_could_let_go_takes_the_guarantee_from_all() -> None:
    made = aslant_between_walls(ASLANT, 0.6, 0.1)
    below = pile_on_a_slope(1, 10.0, 0.5)
    both = standing(*made.bricks.values(), *below.bricks.values(), planes=(*made.planes, *below.planes))
    found = of(both)
    assert of(below).guaranteed
    assert not found.guaranteed
    assert found.lets_go == "plank slides down along left, right: nothing is under it"


def test_bricks_that_need_friction_apart_are_proven_apart() -> None:
    angle = radians(10.0)
    apart = [
        Placed(
            Brick(name, Box((0.1, 0.1, 0.1)), 1.0),
            Pose((0.05 * sin(angle), y, 0.05 * cos(angle)), (0.0, sin(angle / 2.0), 0.0, cos(angle / 2.0))),
        )
        for name, y in (("a", 0.0), ("b", 1.0))
    ]
    found = of(standing(*apart, planes=(plane("ground", 10.0, 0.5),)))
    assert found.guaranteed
    assert [list(group.problem.bricks) for group in found.braced] == [["a"], ["b"]]


def test_a_large_group_that_needs_friction_is_not_decided() -> None:
    found = of(pile_on_a_slope(6, 10.0, 0.5))
    assert not found.guaranteed
    assert found.start is None
    assert "undecided whether b0 to b5 (6 bricks)" in found.reason


def test_a_thousandth_of_the_size_and_a_kilometre_away_changes_nothing() -> None:
    angle, small = radians(20.0), 1e-4
    half = 0.5 * small
    brick = Brick("a", Box((small, small, small)), 1e-9)
    pose = Pose((1000.0 + half * sin(angle), 0.0, half * cos(angle)), (0.0, sin(angle / 2.0), 0.0, cos(angle / 2.0)))
    assert of(standing(Placed(brick, pose), planes=(plane("ground", 20.0, 0.5, 1000.0),))).guaranteed


def test_an_invalid_problem_is_refused_with_a_message() -> None:
    with pytest.raises(TypeError, match=r"assembly\.problem\(\)"):
        outcome(standing(box("a", (1.0, 0.3, 0.06), 0.0, 0.03)))  # type: ignore[arg-type]
