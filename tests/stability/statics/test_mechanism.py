"""The smallest part that falls, and how: known answers."""

from dataclasses import replace
from math import radians
from typing import Any

import pytest

from stability.contact_law import Coulomb
from stability.model import GROUND, BodyId
from stability.problem import UP, Contact, Motion, Problem, Tolerances
from stability.statics import mechanism
from stability.statics.conic_program import ConicProgram, SolverPoint
from stability.statics.equilibrium import balance, falling_motion
from stability.statics.fall_description import described
from stability.statics.mechanism import smallest_mechanism
from stability.statics.proof import check_motion
from tests.stability.statics.hand_built import (
    LENGTH,
    THICKNESS,
    column,
    harmonic,
    inverted_v,
    ladder,
    level_patch,
    on_a_slope,
    plank,
    side_by_side,
    stepped,
    weighed,
)

EXACT = Tolerances()


def fall_of(problem: Problem) -> tuple[tuple[BodyId, ...], str]:
    motion = balance(problem).motion
    assert motion is not None
    least = smallest_mechanism(problem, motion, EXACT)
    assert check_motion(problem, least, EXACT).holds
    return tuple(sorted(least.velocity)), described(problem, least)


def names(first: int, last: int, letter: str = "p") -> tuple[BodyId, ...]:
    return tuple(f"{letter}{i:02}" for i in range(first, last + 1))


@pytest.mark.parametrize(
    ("step", "lowest"),
    # The k planks on top have their centre (k + 1) / 2 steps from that of the plank below: the fewest that reach L / 2.
    [(0.0121, 2), (0.0135, 3), (0.018, 5), (0.025, 7), (0.05, 9), (0.061, 10)],
)
def test_a_stepped_column_tips_at_the_highest_joint_that_fails(step: float, lowest: int) -> None:
    moving, words = fall_of(stepped(10, step))
    assert moving == names(lowest, 10)
    assert words.endswith(f"over p{lowest - 1:02}")


def test_a_column_at_its_limit_tips_as_one() -> None:
    moving, words = fall_of(stepped(5, 0.2 * LENGTH * (1.0 + 1e-6)))
    assert moving == names(2, 5)
    assert words == "p02 to p05 (4 bricks) tip over p01"


def test_solver_noise_on_standing_bricks_is_no_part_of_the_mechanism() -> None:
    problem = stepped(4, 0.0303)
    motion = balance(problem).motion
    assert motion is not None
    least = smallest_mechanism(problem, motion, EXACT)
    remainder = dict.fromkeys(names(1, 1), ((1e-9, 3e-9, 4e-9), (2e-9, 0.0, 1e-9)))
    assert described(problem, Motion({**least.velocity, **remainder})) == described(problem, least)


def test_of_two_stacks_only_the_one_that_falls_moves() -> None:
    standing, falling = stepped(4, 0.0299), stepped(4, 0.0303)
    assert fall_of(side_by_side(standing, falling, 1.0))[0] == names(2, 4, "q")
    assert fall_of(side_by_side(falling, standing, 1.0))[0] == names(2, 4)


def test_of_two_stacks_that_fall_the_smaller_fall_is_told() -> None:
    large, small = stepped(10, 0.0135), column([0.0, 0.061])
    both = side_by_side(large, small, 1.0)
    motions = [balance(problem).motion for problem in (large, small)]
    assert motions[0] is not None
    assert motions[1] is not None
    renamed = {f"q{name[1:]}": twist for name, twist in motions[1].velocity.items()}
    least = smallest_mechanism(both, Motion({**motions[0].velocity, **renamed}), EXACT)
    assert tuple(least.velocity) == ("q02",)


def test_in_a_harmonic_stack_that_is_spread_too_far_the_top_plank_tips_first() -> None:
    assert fall_of(harmonic(30, 1.01)) == (("p30",), "p30 tips over p29")


def test_a_block_slides_on_a_slope_and_a_tall_one_tips() -> None:
    assert fall_of(on_a_slope(radians(30.0), 0.5)) == (("block",), "block slides on slope")
    assert fall_of(on_a_slope(radians(30.0), 1.0, size=(0.01, 0.02, 0.03)))[1] == "block tips over slope"


def test_a_ladder_slides_on_ground_and_wall() -> None:
    assert fall_of(ladder(radians(35.0), 0.4)) == (("ladder",), "ladder slides on ground, wall")


def test_an_inverted_v_falls_by_both_if_each_could_lean_on_the_other_were_it_fixed() -> None:
    # Against a wall as rough as the ground a plank slips below tan = (1 - mu^2) / (2 mu), 42 degrees if it is thin.
    moving, words = fall_of(inverted_v(radians(45.0), 0.45))
    assert moving == ("left", "right")
    assert words == "left, right slide on ground"


def test_of_an_inverted_v_one_is_enough_if_it_would_slip_even_off_a_fixed_one() -> None:
    moving, words = fall_of(inverted_v(radians(30.0), 0.3))
    assert len(moving) == 1
    assert words.startswith(f"{moving[0]} slides on ground, ")


def test_the_mechanism_of_a_brick_without_contacts_is_a_fall() -> None:
    assert fall_of(weighed([plank("p", (0.0, 0.0, 1.0))], [])) == (("p",), "p falls: nothing is under it")


def test_of_a_stack_in_the_air_the_lowest_falls_whatever_becomes_of_the_rest() -> None:
    problem = column([0.0, 0.0, 0.0])
    in_the_air = replace(problem, contacts=[c for c in problem.contacts if c.lower != GROUND])
    assert fall_of(in_the_air) == (("p01",), "p01 falls: nothing is under it")


def test_bricks_that_fall_as_one_are_told_as_one() -> None:
    problem = column([0.0, 0.0, 0.0])
    in_the_air = replace(problem, contacts=[c for c in problem.contacts if c.lower != GROUND])
    down = Motion(dict.fromkeys(problem.bricks, ((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))))
    assert described(in_the_air, down) == "p01 to p03 (3 bricks) fall: nothing is under them"


def test_bricks_that_move_alike_are_told_together() -> None:
    problem = column([0.0] * 6)
    bricks = {name: problem.bricks[name] for name in names(1, 6)}
    #   Three blocks on the ground, each with another one that moves along with it, and the push on each is different.
    touching = [c for c in problem.contacts if c.lower in {GROUND, "p01", "p03", "p05"}]
    on_ground = [replace(touching[0], upper=name) for name in ("p01", "p03", "p05")]
    apart = replace(problem, bricks=bricks, contacts=[*on_ground, *(c for c in touching if c.lower != GROUND)])
    speeds = {name: 1.0 + (n // 2) for n, name in enumerate(names(1, 6))}
    slide = Motion({name: ((speed, 0.0, 0.0), (0.0, 0.0, 0.0)) for name, speed in speeds.items()})
    assert described(apart, slide) == "p01 to p06 (6 bricks) slide on ground"
    rise = Motion({name: ((0.0, 0.0, speed), (0.0, 0.0, 0.0)) for name, speed in speeds.items()})
    assert described(apart, rise) == "[p01, p02], [p03, p04] and [p05, p06] each lift off ground"


def test_a_brick_on_the_ground_never_falls_for_want_of_something_below() -> None:
    #   Faster off the ground than sliding opens a contact, as in motions that a solver finds.
    problem = column([0.0])
    loosened = Motion({"p01": ((1.0, 0.0, 0.6), (0.0, 0.0, 0.0))})
    assert described(problem, loosened) == "p01 slides on ground"


def test_a_fall_begins_with_its_cause() -> None:
    problem = column([0.0, 0.0])
    motion = Motion({"p01": ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "p02": ((0.0, 2.0, 0.0), (0.0, 0.0, 0.0))})
    assert described(problem, motion) == "p01 slides on ground; p02 slides on p01"
    assert described(problem, motion, ("p02",)) == "p02 slides on p01; p01 slides on ground"


def test_the_smoother_of_two_blocks_on_a_slope_slides_alone() -> None:
    rough, smooth = on_a_slope(radians(20.0), 0.5), on_a_slope(radians(20.0), 0.3)
    block = smooth.bricks["block"]
    other = replace(block, brick=replace(block.brick, id="smooth"))
    problem = Problem(
        {**rough.bricks, "smooth": other},
        [*rough.contacts, replace(smooth.contacts[0], upper="smooth")],
        {**rough.loads, "smooth": smooth.loads["block"]},
    )
    assert fall_of(problem) == (("smooth",), "smooth slides on slope")


def test_a_heavy_brick_that_stands_does_not_move_with_a_light_one_that_falls() -> None:
    problem = column([0.0, 0.0, 0.061], masses=[1e6, 1e6, 1.0])
    assert fall_of(problem) == (("p03",), "p03 tips over p02")


def test_the_mechanism_includes_what_the_counterweight_held() -> None:
    # The light counterweight is lifted by the plank that tips: both move.
    base = plank("p", (0.02, 0.0, 0.004))
    weight = plank("w", (-0.02, 0.0, 0.012), mass=0.001, size=(0.02, 0.024, 0.008))
    table = Contact("table", "p", level_patch((-0.04, 0.0), 0.0), (UP,), Coulomb(0.5))
    on_top = Contact("p", "w", level_patch((-0.03, -0.01), THICKNESS), (UP,), Coulomb(0.5))
    moving, words = fall_of(weighed([base, weight], [table, on_top]))
    assert moving == ("p", "w")
    assert words == "p, w tip over table"


def test_long_lists_of_bricks_become_ranges() -> None:
    assert fall_of(stepped(12, 0.0105))[1] == "p02 to p12 (11 bricks) tip over p01"


def test_a_motion_that_proves_nothing_is_handed_back() -> None:
    problem = stepped(3, 0.0)
    rising = Motion({"p03": ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))})
    assert smallest_mechanism(problem, rising, EXACT) is rising


def test_the_search_for_a_mechanism_skips_bricks_proven_to_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    standing: list[set[BodyId]] = []

    def asked(problem: Problem, *how: Any) -> Motion | None:  # noqa: ANN401 -- handed on
        bricks = set(problem.bricks)
        assert not any(bricks <= others for others in standing)
        motion = falling_motion(problem, *how)
        standing.extend([bricks] if motion is None else [])
        return motion

    monkeypatch.setattr(mechanism, "falling_motion", asked)
    for step in (0.0135, 0.018, 0.025):
        standing.clear()
        fall_of(stepped(10, step))
        assert standing


def test_without_a_solver_the_motion_stays_proven() -> None:
    def dies(_: ConicProgram, __: float) -> SolverPoint:
        raise RuntimeError

    problem = side_by_side(stepped(4, 0.0299), stepped(4, 0.0303), 1.0)
    motion = balance(problem).motion
    assert motion is not None
    least = smallest_mechanism(problem, motion, EXACT, dies, dies)
    assert check_motion(problem, least, EXACT).holds
    assert set(least.velocity) <= set(names(1, 4, "q"))
