"""The least and greatest load of bricks and contacts against closed forms, with proofs that tolerate no fault."""

from dataclasses import replace
from math import cos, inf, pi, sin

import numpy as np
import pytest

from stability.analysis.load_bounds import Bound, Carried, SumBounds, loads_between, loads_on
from stability.geometry.box import Box
from stability.geometry.round_solid import cylinder
from stability.geometry.vectors import about, rotate
from stability.joints import DRY, Bond, JointRule, Joints
from stability.loads import Load, Loads
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Motion, Placed, Problem, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.proof import check_pressed, greatest_sum, proof_cones, proof_loads
from stability.statics.shared_forces import Greatest, SharedForces
from stability.statics.wrench_matrix import wrench_matrix

G = 9.81  # [m/s2]
CLOSE = 1e-6
UPWARDS: Vec3 = (0.0, 0.0, 1.0)
SUPPORT = (0.1, 0.2, 0.1)  # [m]


def box(name: str, size: Vec3, weight: float, at: Vec3) -> Placed:
    return Placed(Brick(name, Box(size), weight / G), Pose(at))


def problem_of(*bricks: Placed, friction: float = 0.5, loads: Loads = Loads(), joints: Joints = DRY) -> Problem:  # noqa: B008 -- frozen
    ground = Plane(GROUND, (0.0, 0.0, 0.0), UPWARDS, friction)
    assembly = Assembly((ground,), friction, G, joints=joints, loads=loads)
    assembly.add_all(bricks)
    return assembly.problem()


def on_two_supports(at: float = 0.05, weight: float = 30.0) -> Problem:
    """A plank whose weight acts at `at` between supports from 0.15 to 0.25 m on either side."""
    supports = [box(name, SUPPORT, 10.0, (x, 0.0, 0.05)) for name, x in (("left", -0.2), ("right", 0.2))]
    return problem_of(*supports, box("plank", (0.8, 0.1, 0.02), weight, (at, 0.0, 0.11)))


def running_bond(friction: float) -> Problem:
    """Four courses of planks of 10 N, each on the joint below it."""
    planks = [
        box(f"p{level}{i}", (0.2, 0.1, 0.05), 10.0, (0.2 * i + 0.1 * level, 0.0, 0.025 + 0.05 * level))
        for level in range(4)
        for i in range(6 - level)
    ]
    return problem_of(*planks, friction=friction)


def between(problem: Problem, lower: str, upper: str) -> Carried:
    found = loads_between(problem, [(lower, upper)])
    assert found is not None
    return found[lower, upper]


def on(problem: Problem, body: str) -> Carried:
    found = loads_on(problem, [body])
    assert found is not None
    return found[body]


def limits(carried: Carried) -> tuple[float, float]:
    """The proven least and greatest force, each of which forces reach."""
    for bound, outer in ((carried.least, -1.0), (carried.greatest, 1.0)):
        assert bound.reached is not None
        assert outer * (bound.force - bound.reached) >= -1e-9 * (1.0 + abs(bound.force))
        assert bound.force == pytest.approx(bound.reached, abs=1e-5 * (1.0 + abs(bound.force)))
    return carried.least.force, carried.greatest.force


def test_a_column_hands_down_the_weight_above_each_brick() -> None:
    problem = problem_of(*(box(f"b{i}", (0.2, 0.1, 0.1), 10.0, (0.01 * i, 0.0, 0.05 + 0.1 * i)) for i in range(6)))
    for i in range(6):
        assert limits(on(problem, f"b{i}")) == pytest.approx((10.0 * (5 - i),) * 2, abs=50.0 * CLOSE)
    assert limits(on(problem, GROUND)) == pytest.approx((60.0, 60.0), abs=60.0 * CLOSE)


def test_the_mean_pressure_is_the_force_over_the_shared_area() -> None:
    carried = between(
        problem_of(
            box("lower", (0.2, 0.1, 0.1), 10.0, (0.0, 0.0, 0.05)),
            box("upper", (0.2, 0.1, 0.1), 40.0, (0.05, 0.02, 0.15)),
        ),
        "lower",
        "upper",
    )
    assert carried.area == pytest.approx(0.15 * 0.08)
    assert carried.pressure == pytest.approx((40.0 / (0.15 * 0.08),) * 2, rel=CLOSE)


def test_nothing_lies_on_the_top_brick() -> None:
    carried = on(on_two_supports(), "plank")
    assert limits(carried) == (0.0, 0.0)
    assert carried.pressure is None


def test_a_plank_presses_its_two_supports_at_their_inner_and_outer_edges() -> None:
    problem = on_two_supports(at=0.05, weight=30.0)
    # Levers about the edges between which each support can push: 0.15 to 0.25 m.
    least, greatest = 30.0 * (0.15 - 0.05) / (0.15 + 0.25), 30.0 * (0.25 - 0.05) / (0.25 + 0.15)
    assert limits(between(problem, "left", "plank")) == pytest.approx((least, greatest), rel=CLOSE)
    assert limits(between(problem, "right", "plank")) == pytest.approx((30.0 - greatest, 30.0 - least), rel=CLOSE)


def test_a_plank_may_lie_on_any_two_of_three_supports() -> None:
    supports = [box(name, SUPPORT, 10.0, (x, 0.0, 0.05)) for name, x in (("l", -0.3), ("m", 0.0), ("r", 0.3))]
    problem = problem_of(*supports, box("plank", (0.8, 0.1, 0.02), 30.0, (0.0, 0.0, 0.11)))
    assert limits(between(problem, "m", "plank")) == pytest.approx((0.0, 30.0), abs=30.0 * CLOSE)
    assert limits(between(problem, "l", "plank")) == pytest.approx((0.0, 30.0 * 0.35 / 0.6), abs=30.0 * CLOSE)


def test_a_weight_on_a_plank_loads_the_nearer_support() -> None:
    loads = Loads((Load("plank", (0.0, 0.0, -8.0), (0.15, 0.0, 0.01)),))
    supports = [box(name, SUPPORT, 10.0, (x, 0.0, 0.05)) for name, x in (("left", -0.2), ("right", 0.2))]
    plank = box("plank", (0.8, 0.1, 0.02), 30.0, (0.0, 0.0, 0.11))
    moment = 30.0 * 0.15 + 8.0 * (0.15 - 0.15)  # of both loads about the inner edge of the right support
    least = limits(between(problem_of(*supports, plank, loads=loads), "left", "plank"))[0]
    assert least == pytest.approx(moment / (0.25 + 0.15), rel=CLOSE)


def test_a_brick_whose_weight_is_held_up_presses_nothing() -> None:
    held = Loads((Load("b", (0.0, 0.0, 10.0), (0.0, 0.0, 0.05)),))
    problem = problem_of(
        box("a", SUPPORT, 10.0, (0.0, 0.0, 0.05)), box("b", SUPPORT, 10.0, (0.0, 0.0, 0.15)), loads=held
    )
    assert limits(on(problem, "a")) == pytest.approx((0.0, 0.0), abs=10.0 * CLOSE)


def test_friction_of_a_neighbour_takes_part_of_a_load() -> None:
    """A pushed box slides up or down a wall: the wall bears up to friction times the push, and so does the ground."""
    push, weight, friction = 6.0, 20.0, 0.5
    wall = Plane("wall", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), friction)
    ground = Plane(GROUND, (0.0, 0.0, 0.0), UPWARDS, 0.0)
    assembly = Assembly((ground, wall), friction, G, loads=Loads((Load("b", (-push, 0.0, 0.0), (0.1, 0.0, 0.0)),)))
    assembly.add_all([box("b", (0.2, 0.2, 0.2), weight, (0.1, 0.0, 0.1))])
    problem = assembly.problem()
    assert limits(between(problem, "wall", "b")) == pytest.approx((push, push), rel=CLOSE)
    up = friction * push
    assert limits(between(problem, GROUND, "b")) == pytest.approx((weight - up, weight + up), rel=CLOSE)
    assert limits(on(problem, "wall")) == (0.0, 0.0)  # it stands beside the box


def test_a_box_wedged_between_walls_may_press_the_ground_by_nothing_or_by_anything() -> None:
    """Friction of two walls that press against each other bears the box, or pushes it down, without limit."""
    walls = [
        Plane(name, (x, 0.0, 0.0), (side, 0.0, 0.0), 0.5) for name, x, side in (("l", -0.1, 1.0), ("r", 0.1, -1.0))
    ]
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), UPWARDS, 0.5), *walls), 0.5, G)
    assembly.add_all([box("b", (0.2, 0.2, 0.2), 20.0, (0.0, 0.0, 0.1))])
    carried = between(assembly.problem(), GROUND, "b")
    assert carried.least.force == 0.0
    assert carried.least.motion is not None
    assert carried.greatest.force == inf


def test_glue_pulls_a_support_towards_the_plank_up_to_its_strength() -> None:
    """A glued plank overhangs: glue over the far support holds it down, and the near one bears the more."""
    strength, weight = 500.0, 30.0  # [Pa] of tension, [N]
    support = box("s", SUPPORT, 10.0, (0.0, 0.0, 0.05))
    joints = Joints((JointRule(Bond(strength, 0.0), (frozenset({"s"}), frozenset({"plank"}))),))
    problem = problem_of(support, box("plank", (0.4, 0.1, 0.02), weight, (0.03, 0.0, 0.11)), joints=joints)
    assert limits(between(problem, "s", "plank")) == pytest.approx((weight, weight), rel=CLOSE)
    assert on(problem, "s").area == pytest.approx(0.1 * 0.1)


def test_a_board_presses_two_cans_at_their_nearest_and_farthest_points() -> None:
    radius, apart, at, weight = 0.033, 0.2, 0.05, 30.0
    cans = [
        Placed(Brick(name, cylinder(radius, 0.115), 0.4), Pose((x, 0.0, 0.0575)))
        for name, x in (("left", -apart), ("right", apart))
    ]
    problem = problem_of(*cans, box("board", (0.6, 0.1, 0.02), weight, (at, 0.0, 0.125)))
    carried = between(problem, "left", "board")
    least, greatest = weight * (apart - radius - at) / (2.0 * apart), weight * (apart + radius - at) / (2.0 * apart)
    # Polygons around the discs have their corners at most 0.03 % outside.
    slack = 3e-4 * radius / (2.0 * apart) * weight
    assert carried.least.force == pytest.approx(least, abs=slack)
    assert carried.greatest.force == pytest.approx(greatest, abs=slack)
    assert carried.least.force <= least * (1.0 + CLOSE) <= (carried.least.reached or 0.0) + slack
    assert carried.greatest.force >= greatest * (1.0 - CLOSE) >= (carried.greatest.reached or 0.0) - slack
    assert carried.area == pytest.approx(pi * radius**2, rel=1e-12)
    assert limits(on(problem, GROUND)) == pytest.approx((weight + 0.8 * G,) * 2, rel=CLOSE)


def test_a_log_in_a_wedge_presses_both_sides_by_half_its_weight_over_the_cosine() -> None:
    slope, weight = 0.6, 12.0
    normals = [(sign * sin(slope), 0.0, cos(slope)) for sign in (1.0, -1.0)]
    sides = [Plane(name, (0.0, 0.0, 0.0), normal, 0.0) for name, normal in zip("lr", normals, strict=True)]
    assembly = Assembly(sides, 0.0, G)
    turn = about((1.0, 0.0, 0.0), pi / 2.0)
    assembly.add_all([Placed(Brick("log", cylinder(0.05, 0.4), weight / G), Pose((0.0, 0.0, 0.05 / cos(slope)), turn))])
    pushed = 0.5 * weight / cos(slope)
    assert limits(between(assembly.problem(), "l", "log")) == pytest.approx((pushed, pushed), rel=CLOSE)


def test_bricks_that_cannot_stand_carry_nothing_that_is_known() -> None:
    problem = problem_of(
        box("base", (0.1, 0.1, 0.1), 10.0, (0.0, 0.0, 0.05)), box("top", (0.2, 0.1, 0.1), 10.0, (0.06, 0.0, 0.15))
    )
    assert loads_on(problem) is None
    assert loads_between(problem) is None


def test_turned_mirrored_and_larger_structures_carry_alike() -> None:
    usual = limits(between(on_two_supports(), "left", "plank"))
    mirrored = limits(between(on_two_supports(at=-0.05), "right", "plank"))
    assert mirrored == pytest.approx(usual, rel=CLOSE)
    turn = about(UPWARDS, 0.3 * pi)
    bricks = [
        Placed(
            Brick(f"x{name}", Box(tuple(7.0 * side for side in p.brick.shape.size)), 2.0 * p.brick.mass),  # type: ignore[attr-defined]
            Pose(tuple(7.0 * part for part in rotate(turn, p.pose.position_W)), turn),  # type: ignore[arg-type]
        )
        for name, p in on_two_supports().bricks.items()
    ]
    turned = limits(between(problem_of(*reversed(bricks)), "xleft", "xplank"))
    assert turned == pytest.approx([2.0 * each for each in usual], rel=CLOSE)


def test_forces_that_reach_a_bound_balance_every_brick() -> None:
    problem = on_two_supports()
    carried = between(problem, "left", "plank")
    for bound in (carried.least, carried.greatest):
        assert bound.forces_W is not None
        cones = proof_cones(problem)
        assert cones is not None
        assert check_pressed(cones, proof_loads(problem), bound.forces_W, Tolerances()).holds


# --- faults -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slower", [0.9, 0.999999])
def test_a_motion_that_opens_the_contact_too_slowly_proves_nothing(slower: float) -> None:
    problem = on_two_supports()
    weights, proof = weights_of(problem, ("left", "plank")), between(problem, "left", "plank").greatest
    assert proof.motion is not None
    assert greatest_sum(problem, weights, proof.motion) == proof.force
    slow = {name: _scaled(each, slower) for name, each in proof.motion.velocity.items()}
    assert greatest_sum(problem, weights, Motion(slow)) == inf


def _scaled(each: tuple[Vec3, Vec3], factor: float) -> tuple[Vec3, Vec3]:
    velocity, spin = (tuple(factor * part for part in vector) for vector in each)
    return velocity, spin  # type: ignore[return-value]


@pytest.mark.parametrize("error", [1e-6, 1e-3, 0.1])
def test_no_wrong_point_of_a_solver_is_taken_as_a_bound(error: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A solver that is wrong by some share yields looser bounds, or none, but never one that forces exceed."""
    problem = on_two_supports()
    exact = limits(between(problem, "left", "plank"))
    random = np.random.default_rng(35)
    honest = SharedForces.greatest

    def wrong(self: SharedForces, sums: np.ndarray, accuracy: float, least: float) -> Greatest:
        points = honest(self, sums, accuracy, least)
        rows, columns = (
            each * (1.0 + error * random.uniform(-1.0, 1.0, each.shape)) for each in (points.rows, points.columns)
        )
        return Greatest(rows, columns)

    monkeypatch.setattr(SharedForces, "greatest", wrong)
    # The other ways to a bound.
    monkeypatch.setattr("stability.analysis.load_bounds.least_forces", lambda *_: "none")
    monkeypatch.setattr("stability.analysis.load_bounds.separating_motion", lambda *_: None)
    for _ in range(5):
        found = loads_between(problem, [("left", "plank")])
        if found is None:
            continue
        carried = found["left", "plank"]
        assert carried.least.force <= exact[0] + CLOSE * exact[0]
        assert carried.greatest.force >= exact[1] - CLOSE * exact[1]
        assert (carried.least.force, carried.greatest.force) != pytest.approx(exact, rel=1e-3 * error)


@pytest.mark.parametrize("accuracy", [1e-1, 1e-3, 1e-6])
def test_a_coarser_bound_is_wider_by_at_most_its_accuracy(accuracy: float) -> None:
    problem = on_two_supports(at=0.05, weight=30.0)
    least, greatest = 30.0 * (0.15 - 0.05) / (0.15 + 0.25), 30.0 * (0.25 - 0.05) / (0.25 + 0.15)
    found = loads_between(problem, [("left", "plank")], accuracy=accuracy)
    assert found is not None
    carried = found["left", "plank"]
    assert least - accuracy * greatest <= carried.least.force <= least * (1.0 + 1e-9)
    assert greatest * (1.0 - 1e-9) <= carried.greatest.force <= greatest * (1.0 + accuracy)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_sums_that_are_solved_together_are_those_that_a_general_solver_finds(friction: float) -> None:
    """A wall in running bond, of which every load is also bounded by programs of Clarabel alone."""
    problem = running_bond(friction=friction)
    together = loads_on(problem)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(SharedForces, "of", lambda _: None)
        alone = loads_on(problem)
    assert together is not None
    assert alone is not None
    assert together.keys() == alone.keys()
    for name, carried in together.items():
        assert limits(carried) == pytest.approx(limits(alone[name]), abs=1e-6 * 100.0)


def test_a_load_is_bounded_at_once_if_equilibrium_alone_decides_it() -> None:
    """The contacts of a column carry exactly the weight above them, at any accuracy."""
    column = problem_of(*(box(f"b{i}", (0.2, 0.1, 0.1), 10.0, (0.0, 0.0, 0.05 + 0.1 * i)) for i in range(6)))
    found = loads_on(column, accuracy=1e-3)
    assert found is not None
    for i in range(6):
        assert limits(found[f"b{i}"]) == pytest.approx((10.0 * (5 - i),) * 2, abs=50.0 * CLOSE)


def test_what_two_supports_share_is_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a plank on two supports, one bears the more, the less the other one does."""
    solved = []
    honest = SharedForces._optimized

    def counted(self: SharedForces, sums: np.ndarray, *others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        solved.append(sums.shape[-1])
        return honest(self, sums, *others)

    monkeypatch.setattr(SharedForces, "_optimized", counted)
    found = loads_on(on_two_supports(at=0.05, weight=30.0), ["left", "right"])
    assert found is not None
    assert sum(solved) == 2
    assert limits(found["left"]) == pytest.approx((7.5, 15.0), rel=CLOSE)
    assert limits(found["right"]) == pytest.approx((15.0, 22.5), rel=CLOSE)


def test_forces_without_room_are_left_to_the_general_solver() -> None:
    """A plank that is about to tip presses only the edge: no forces lie within all cones."""
    problem = problem_of(box("s", SUPPORT, 10.0, (0.0, 0.0, 0.05)), box("p", (0.4, 0.1, 0.02), 30.0, (0.05, 0.0, 0.11)))
    assert SharedForces.of(wrench_matrix(problem, any_law=True)) is None
    assert limits(on(problem, "s")) == pytest.approx((30.0, 30.0), rel=CLOSE)


def test_a_bound_that_is_planted_below_the_forces_is_found() -> None:
    bound = between(on_two_supports(), "left", "plank").greatest
    planted = replace(bound, force=0.99 * bound.force)
    assert is_sound(on_two_supports(), ("left", "plank"), bound)
    assert not is_sound(on_two_supports(), ("left", "plank"), planted)


def weights_of(problem: Problem, pair: tuple[str, str]) -> np.ndarray:
    numbers = [number for number, each in enumerate(problem.contacts) if (each.lower, each.upper) == pair]
    return SumBounds(problem, Tolerances()).weights_of(numbers)


def is_sound(problem: Problem, pair: tuple[str, str], bound: Bound) -> bool:
    """Check that a greatest force is the one that its motion proves, by arithmetic alone."""
    return bound.motion is not None and greatest_sum(problem, weights_of(problem, pair), bound.motion) <= bound.force


def test_a_wrong_name_is_an_error() -> None:
    with pytest.raises(LookupError, match="no body 'nobody'"):
        loads_on(on_two_supports(), ["nobody"])
    with pytest.raises(LookupError, match="'left' has no contact on 'right'"):
        loads_between(on_two_supports(), [("right", "left")])
