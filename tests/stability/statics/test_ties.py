"""Ties against closed forms: straps that press, bands that clamp, rods that hold the thrust of arches."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, inf, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.tied import contradictions, tied_case, verdict_on
from stability.analysis.bearings import by_bearing
from stability.analysis.load_factor import load_factor
from stability.analysis.margins import least_friction
from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.geometry.vectors import about, rotate
from stability.loads import Load, Loads
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Forces, Placed, Stability
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces, check_motion
from stability.ties import Cable, Tie, length_of, loop_around, pulls_of, straight_between

G = 10.0  # [m/s2]
MU = 0.5
CLOSE = 1e-6
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
STABLE, UNSTABLE, UNDECIDED = Stability.STABLE, Stability.UNSTABLE, Stability.UNDECIDED


def box(name: str, size: Vec3, weight: float, at: Vec3) -> Placed:
    return Placed(Brick(name, Box(size), weight / G), Pose(at))


def tie_of(
    cable: Cable, bricks: Sequence[Placed], tension: float, strength: float | None = None, name: str = "tie"
) -> Tie:
    names = frozenset(placed.brick.id for placed in bricks)
    return Tie(name, names, pulls_of(cable, bricks), tension, strength or tension, cable.course_W)


def assembly_of(
    bricks: Sequence[Placed], *ties: Tie, friction: float = MU, ground: float = MU, loads: Sequence[Load] = ()
) -> Assembly:
    plane = Plane(GROUND, (0.0, 0.0, 0.0), Z, ground)
    assembly = Assembly((plane,), friction, G, loads=Loads(tuple(loads)), ties=ties)
    assembly.add_all(bricks)
    return assembly


def verdict(bricks: Sequence[Placed], *ties: Tie, **rest: object) -> Stability:
    return assembly_of(bricks, *ties, **rest).verdict().stability  # type: ignore[arg-type]


# A block on a heavy pallet that does not slide on the ground; a strap goes over the one and below the other.
#
#      +--block--+
#   +--+--pallet-+--+

PALLET = box("pallet", (0.4, 0.4, 0.1), 5000.0, (0.0, 0.0, 0.05))
BLOCK = box("block", (0.4, 0.4, 0.4), 100.0, (0.0, 0.0, 0.3))


def strap(tension: float, strength: float | None = None) -> Tie:
    return tie_of(loop_around([PALLET, BLOCK], Y, 0.0), [PALLET, BLOCK], tension, strength)


@pytest.mark.parametrize("tension", [0.0, 30.0, 400.0])
def test_a_strap_adds_twice_its_tension_to_the_pressure_against_sliding(tension: float) -> None:
    limit = 0.25 * (100.0 + 2.0 * tension)  # of a force at the foot of the block, which does not tip it
    for share, stands in ((1.0 - CLOSE, STABLE), (1.0 + CLOSE, UNSTABLE)):
        load = Load("block", (0.0, share * limit, 0.0), (0.0, 0.0, -0.2))
        assembly = assembly_of([PALLET, BLOCK], strap(tension), friction=0.25, loads=[load])
        assert assembly.verdict().stability is stands


@pytest.mark.parametrize("tension", [0.0, 30.0, 400.0])
def test_the_load_factor_of_a_push_on_a_strapped_block(tension: float) -> None:
    load = Load("block", (0.0, 1.0, 0.0), (0.0, 0.0, -0.2))
    problem = assembly_of([PALLET, BLOCK], strap(tension), friction=0.25, loads=[load]).problem()
    found = load_factor(problem.unloaded, problem.applied)
    assert found is not None
    assert found.factor == pytest.approx(0.25 * (100.0 + 2.0 * tension), rel=CLOSE)
    assert found.too_large == pytest.approx(found.factor, rel=CLOSE)


@pytest.mark.parametrize(("count", "tension"), [(1, 0.0), (1, 50.0), (3, 50.0), (5, 200.0)])
def test_a_strapped_stack_tips_about_its_foot_where_it_would_without_a_strap_to_the_ground(
    count: int, tension: float
) -> None:
    """The loop is closed below the lowest carton, so it does not hold the whole stack: width over height."""
    stack = [box(f"c{i}", (0.4, 0.4, 0.2), 100.0, (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(count)]
    tie = tie_of(loop_around(stack, Y, 0.0), stack, tension)
    problem = assembly_of(stack, tie, friction=5.0, ground=5.0).problem()
    along = by_bearing(problem, 4, 1e-7, G)
    assert along is not None
    assert [each.value for each in along] == pytest.approx([0.4 / (0.2 * count)] * 4, rel=1e-5)


@pytest.mark.parametrize(("count", "tension"), [(2, 0.0), (2, 50.0), (4, 50.0), (4, 200.0)])
def test_a_stack_on_a_pallet_that_is_strapped_to_it_tips_at_a_larger_acceleration(count: int, tension: float) -> None:
    """Of n cartons of weight W: a n W h n / 2 = (n W + 2 T) b / 2, with the pallet held by its weight."""
    side, height, weight = 0.4, 0.2, 100.0
    stack = [box(f"c{i}", (side, side, height), weight, (0.0, 0.0, 0.1 + height * (i + 0.5))) for i in range(count)]
    bricks = [replace(PALLET, brick=replace(PALLET.brick, mass=1e6)), *stack]
    ties = tie_of(loop_around(bricks, Y, 0.0), bricks, tension)
    problem = assembly_of(bricks, ties, friction=9.0, ground=9.0).problem()
    along = by_bearing(problem, 4, 1e-7, G)
    assert along is not None
    tips = (count * weight + 2.0 * tension) * side / (count * weight * count * height)
    assert [each.value for each in along] == pytest.approx([tips] * 4, rel=1e-5)


# A band around three blocks on smooth ground, of which the middle one hangs between the others.
#
#   +--+ +--+ +--+
#   |  |=|  |=|  |
#   |  | +--+ |  |
#   +--+      +--+

POSTS = [box(name, (0.4, 0.2, 0.6), 200.0, (x, 0.0, 0.3)) for name, x in (("left", -0.4), ("right", 0.4))]
MIDDLE = box("middle", (0.4, 0.2, 0.2), 60.0, (0.0, 0.0, 0.5))
CLAMPED = [*POSTS, MIDDLE]


def band(tension: float, strength: float | None = None) -> Tie:
    return tie_of(loop_around(CLAMPED, Z, 0.5), CLAMPED, tension, strength)


@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_band_holds_a_block_by_friction_on_both_sides(friction: float) -> None:
    needed = 60.0 / (4.0 * friction)  # two faces, each under the tension of both halves of the band
    assert verdict(CLAMPED, band((1.0 + CLOSE) * needed), friction=friction, ground=0.0) is STABLE
    assert verdict(CLAMPED, band((1.0 - CLOSE) * needed), friction=friction, ground=0.0) is UNSTABLE


def test_the_friction_that_a_clamped_block_needs() -> None:
    problem = assembly_of(CLAMPED, band(50.0), ground=0.0).problem()
    assert least_friction(problem).coefficient == pytest.approx(60.0 / (4.0 * 50.0), rel=1e-4)


def test_strength_alone_clamps_nothing_as_nothing_tightens_the_band() -> None:
    assembly = assembly_of(CLAMPED, band(10.0, strength=1000.0), ground=0.0)
    assert assembly.verdict().stability is UNDECIDED
    assert assembly.verdict().reason.startswith("it needs a tension of 30 N in the tie 'tie'")
    assert verdict(CLAMPED, band(0.0, strength=29.9), ground=0.0) is UNSTABLE


# Two stones of an arch on smooth ground, which a rod between them holds.
#
#        /|\
#      /  |  \
#    /----+----\   rod
#   |    / \    |
#   +---+   +---+

HALF = ((-1.0, 0.0), (-0.8, 0.0), (0.0, 0.8), (0.0, 1.0), (-0.2, 1.0), (-1.0, 0.3))


def arch(rod_at: float = 0.1, turn: float = 0.0) -> tuple[list[Placed], Cable, float]:
    """Return both stones, a rod between them, and the tension that it needs at least [N]."""
    left = prism(HALF, 0.2)
    right = prism([(-x, z) for x, z in HALF], 0.2)
    yaw = about(Z, turn)
    stones = [
        Placed(Brick(name, made.shape, 30.0), Pose(rotate(yaw, made.centre_of_mass), yaw))
        for name, made in (("left", left), ("right", right))
    ]
    ends = [rotate(yaw, (x, 0.0, rod_at)) for x in (-0.9, 0.9)]
    # The thrust acts at the top of the crown, and the ground at the inner edge of the foot.
    needed = 300.0 * (left.centre_of_mass[0] + 0.8) / (1.0 - rod_at)
    return stones, straight_between("left", ends[0], "right", ends[1]), needed


@pytest.mark.parametrize("rod_at", [0.05, 0.3])
def test_a_rod_holds_the_thrust_of_an_arch_up_to_its_strength(rod_at: float) -> None:
    stones, rod, needed = arch(rod_at)
    assert needed > 0.0
    for share, stands in ((1.0 + CLOSE, STABLE), (1.0 - CLOSE, UNSTABLE)):
        assembly = assembly_of(stones, tie_of(rod, stones, 0.0, share * needed), ground=0.0)
        assert assembly.verdict().stability is stands
    assert verdict(stones, ground=0.0) is UNSTABLE


def test_the_tension_of_a_rod_is_in_the_forces_that_prove_rest() -> None:
    stones, rod, needed = arch()
    assembly = assembly_of(stones, tie_of(rod, stones, 0.0, 2.0 * needed), ground=0.0)
    forces = assembly.forces()
    assert forces is not None
    (tension,) = forces.more_tension
    assert (1.0 - CLOSE) * needed <= tension <= 2.0 * needed
    problem = assembly.problem()
    assert check_forces(problem, forces, assembly.tolerances).holds
    for wrong in ((), (0.9 * needed,), (3.0 * needed,), (-1.0,), (float("nan"),)):
        assert not check_forces(problem, Forces(forces.of_contacts, wrong), assembly.tolerances).holds


def test_the_load_factor_of_an_arch_is_the_strength_of_its_rod_over_the_thrust() -> None:
    stones, rod, needed = arch()
    problem = assembly_of(stones, tie_of(rod, stones, 0.0, 3.0 * needed), ground=0.0).problem()
    found = load_factor(problem)
    assert found is not None
    assert found.factor == pytest.approx(3.0, rel=CLOSE)
    assert found.too_large == pytest.approx(3.0, rel=CLOSE)


def test_the_load_factor_counts_the_tension_of_a_rod_as_constant() -> None:
    stones, rod, needed = arch()
    problem = assembly_of(stones, tie_of(rod, stones, 0.5 * needed, 3.0 * needed), ground=0.0).problem()
    weights = problem.weights
    found = load_factor(problem.without(weights), weights)
    assert found is not None
    assert found.factor == pytest.approx(3.0, rel=CLOSE)


def test_a_motion_that_lengthens_a_tie_proves_a_fall_only_beyond_its_strength() -> None:
    stones, rod, needed = arch()
    falling = assembly_of(stones, tie_of(rod, stones, 0.0, 0.9 * needed), ground=0.0)
    motion = falling.verdict().motion
    assert motion is not None
    assert check_motion(falling.problem(), motion, falling.tolerances).holds
    (tie,) = falling.problem().ties
    stronger = replace(falling.problem(), ties=(replace(tie, most=1.1 * needed),))
    assert not check_motion(stronger, motion, falling.tolerances).holds


def test_a_tie_without_tension_and_strength_changes_nothing() -> None:
    stones, rod, _ = arch()
    slack = tie_of(rod, stones, 0.0, 0.0)
    assert verdict(stones, slack, ground=0.0) is UNSTABLE
    assert verdict(stones, slack, ground=5.0) is verdict(stones, ground=5.0) is STABLE
    assert verdict(CLAMPED, band(0.0), ground=0.0) is UNSTABLE


def test_ties_hold_from_their_last_brick_on_and_come_off_with_the_first() -> None:
    stones, rod, needed = arch()
    tie = tie_of(rod, stones, 0.0, 2.0 * needed)
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), Z, 0.0),), MU, G, ties=[tie])
    assert assembly.add_all(stones).stability is STABLE
    before = assembly.state()
    assert assembly.copied().verdict() == assembly.verdict()
    assert assembly.remove(["left"]).stability is UNSTABLE
    assert assembly.add(stones[0].brick, stones[0].pose).stability is UNSTABLE  # nobody has tied it again
    assembly.restore(before)
    assert assembly.would_without(["left"]).stability is UNSTABLE
    assert assembly.verdict().stability is STABLE
    assembly.remove(["left", "right"])
    assert assembly.verdict().stability is STABLE


def test_a_strap_pulls_bricks_that_were_placed_before() -> None:
    load = Load("block", (0.0, 60.0, 0.0), (0.0, 0.0, -0.2))
    plane = Plane(GROUND, (0.0, 0.0, 0.0), Z, MU)
    assembly = Assembly((plane,), 0.25, G, loads=Loads((load,)), ties=[strap(100.0)])
    assert assembly.add(PALLET.brick, PALLET.pose).stability is STABLE
    assert assembly.add(BLOCK.brick, BLOCK.pose).stability is STABLE
    lid = box("lid", (0.4, 0.4, 0.1), 1.0, (0.0, 0.0, 0.55))
    assert assembly.add(lid.brick, lid.pose).stability is STABLE
    assert assembly.remove(["pallet", "lid"]).stability is UNSTABLE


# Cables.


def test_a_loop_around_a_box_is_as_long_as_its_outline_and_pulls_its_corners_inwards() -> None:
    cable = loop_around([BLOCK], Z, 0.2)
    assert length_of(cable.course_W) == pytest.approx(1.6)
    assert len(cable.points) == 4
    for each in cable.points:
        assert each.pull_W == pytest.approx((-np.sign(each.point_W[0]), -np.sign(each.point_W[1]), 0.0))


def test_a_loop_passes_corners_that_are_flush_without_a_force() -> None:
    cable = loop_around([PALLET, BLOCK], Y, 0.1)
    assert {each.body for each in cable.points} == {"pallet", "block"}
    assert length_of(cable.course_W) == pytest.approx(2.0 * (0.4 + 0.5))
    for name, pull in (("pallet", 2.0), ("block", -2.0)):
        assert sum(each.pull_W[2] for each in cable.points if each.body == name) == pytest.approx(pull)


def test_anchors_bear_the_pull_of_a_lashing() -> None:
    cable = loop_around([BLOCK], Y, 0.0, [(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    assert {each.body for each in cable.points} == {"block"}
    pull = sum(each.pull_W[2] for each in cable.points)
    assert pull == pytest.approx(-2.0 * 0.5 / np.hypot(0.8, 0.5))


def test_a_loop_that_meets_no_brick_has_no_course() -> None:
    assert loop_around([BLOCK], Z, 5.0) == Cable((), ())


@pytest.mark.parametrize(
    ("tension", "strength", "message"),
    [(-1.0, 1.0, "at least 0"), (2.0, 1.0, "at least 0"), (0.0, inf, "1e\\+60"), (float("nan"), 1.0, "at least 0")],
)
def test_a_tie_with_a_wrong_tension_is_refused(tension: float, strength: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Assembly(ties=[Tie("tie", frozenset("a"), (), tension, strength)])


# Invariances.


@settings(max_examples=15)
@given(st.floats(-pi, pi), st.booleans(), st.permutations(range(2)), st.sampled_from([0.97, 1.03]))
def test_the_verdict_on_a_tied_arch_does_not_depend_on_turns_mirrors_names_and_order(
    turn: float, renamed: bool, order: list[int], share: float
) -> None:
    stones, rod, needed = arch(turn=turn)
    tie = tie_of(rod, stones, 0.0, share * needed)
    if renamed:
        names = {"left": "b", "right": "a"}
        stones = [replace(each, brick=replace(each.brick, id=names[each.brick.id])) for each in stones]
        tie = replace(
            tie,
            around=frozenset(names.values()),
            pulls=tuple(replace(pull, brick=names[pull.brick]) for pull in tie.pulls),
        )
    assert verdict([stones[i] for i in order], tie, ground=0.0) is (STABLE if share > 1.0 else UNSTABLE)


@settings(max_examples=25)
@given(st.floats(-pi, pi), st.floats(0.0, 100.0))
def test_a_slack_strap_never_makes_a_stable_block_unstable(turn: float, push: float) -> None:
    load = Load("block", (push * cos(turn), push * sin(turn), 0.0), (0.0, 0.0, 0.1))
    if verdict([PALLET, BLOCK], loads=[load]) is STABLE:
        assert verdict([PALLET, BLOCK], strap(0.0), loads=[load]) is STABLE
        assert verdict([PALLET, BLOCK], strap(0.0, 500.0), loads=[load]) is STABLE


# Linear programs that share no code with the statics.


@pytest.mark.parametrize("seed", range(1000, 1012))
def test_verdicts_on_random_tied_boxes_agree_with_linear_programs(seed: int) -> None:
    case = tied_case(seed)
    assert list(contradictions(case, verdict_on(case))) == []


def test_the_programs_contradict_verdicts_on_boxes_whose_ties_are_left_out() -> None:
    wrong = sum(any(contradictions(case, verdict_on(replace(case, loops=())))) for case in map(tied_case, range(6)))
    assert wrong > 0
