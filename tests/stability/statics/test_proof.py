"""The checkers: right proofs hold, and every way to spoil one is seen."""

from collections.abc import Callable
from dataclasses import replace
from math import hypot, inf, nan, pi

import pytest

from stability.contact_law import Coulomb
from stability.model import GROUND, Vec3
from stability.problem import UP, ConeForces, Contact, Forces, Motion, Problem, Tolerances, Wrench
from stability.statics.equilibrium import balance
from stability.statics.proof import check_forces, check_motion, least_separating_speed, power
from tests.stability.statics.hand_built import (
    GRAVITY,
    LENGTH,
    THICKNESS,
    column,
    inverted_v,
    ladder,
    on_a_slope,
    stepped,
)

EXACT = Tolerances()
HEAVY = 1e6


def forces_of(problem: Problem) -> Forces:
    forces = balance(problem).forces
    assert forces is not None
    assert check_forces(problem, forces, EXACT).holds
    return forces


def motion_of(problem: Problem) -> Motion:
    motion = balance(problem).motion
    assert motion is not None
    assert check_motion(problem, motion, EXACT).holds
    return motion


def with_contact(forces: Forces, index: int, change: Callable[[Vec3], Vec3]) -> Forces:
    of_contacts = list(forces.of_contacts)
    of_contacts[index] = tuple(tuple(change(f) for f in at_point) for at_point in of_contacts[index])
    return Forces(tuple(of_contacts))


def times(factor: float) -> Callable[[Vec3], Vec3]:
    return lambda f: (factor * f[0], factor * f[1], factor * f[2])


def test_forces_that_are_scaled_on_one_brick_no_longer_balance_it() -> None:
    problem = stepped(4, 0.02)
    found = check_forces(problem, with_contact(forces_of(problem), 3, times(1.001)), EXACT)
    assert not found.holds
    assert found.residual == pytest.approx(1e-3, rel=0.2)
    assert found.brick == "p04"


def test_forces_swapped_between_two_corners_turn_the_brick() -> None:
    problem = stepped(4, 0.02)
    forces = forces_of(problem)
    first, second, *rest = forces.of_contacts[2]
    swapped: ConeForces = (second, first, *rest)
    of_contacts = (*forces.of_contacts[:2], swapped, forces.of_contacts[3])
    assert not check_forces(problem, Forces(of_contacts), EXACT).holds


def test_a_force_outside_its_cone_is_seen_though_it_balances() -> None:
    slope = on_a_slope(0.1 * pi, friction=1.0)
    slippery = replace(slope, contacts=[replace(slope.contacts[0], law=Coulomb(0.1))])
    found = check_forces(slippery, forces_of(slope), EXACT)
    assert not found.holds
    assert found.residual < EXACT.residual
    assert found.cone > 0.01


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_contact_does_not_pull(friction: float) -> None:
    # The lower brick is pulled down by the one above, which a load lifts: all balanced, were contacts glued.
    problem = column([0.0, 0.0], friction=friction)
    weight = 0.012 * GRAVITY
    pull: ConeForces = tuple(((0.0, 0.0, -0.25 * weight),) for _ in range(4))
    push: ConeForces = tuple(((0.0, 0.0, 0.5 * weight),) for _ in range(4))
    upper_falls = replace(problem, loads={"p01": Wrench((0.0, 0.0, -3.0 * weight)), "p02": Wrench((0.0, 0.0, weight))})
    found = check_forces(upper_falls, Forces((push, pull)), EXACT)
    assert found.residual < EXACT.residual
    assert not found.holds


def test_a_light_plank_that_overhangs_a_heavy_one_is_not_proven_by_forces_that_do_for_the_heavy_one() -> None:
    # The plank on top is short of balance by a thousandth of its own weight, a thousand millionth of the whole.
    stands = column([0.0, 0.0, 0.06 * (1.0 - 1e-3)], masses=[HEAVY, HEAVY, 1.0])
    falls = column([0.0, 0.0, 0.06 * (1.0 + 1e-3)], masses=[HEAVY, HEAVY, 1.0])
    found = check_forces(falls, forces_of(stands), EXACT)
    assert not found.holds
    assert found.brick == "p03"


def test_a_cone_violated_counts_relative_to_the_lighter_of_its_bricks() -> None:
    problem = column([0.0, 0.0], masses=[HEAVY, 1e-6])
    pull: ConeForces = tuple(((0.0, 0.0, -1e-9),) for _ in range(4))
    press: ConeForces = tuple(((0.0, 0.0, 0.25 * HEAVY * GRAVITY),) for _ in range(4))
    assert check_forces(problem, Forces((press, pull)), EXACT).cone > 1e-6


@pytest.mark.parametrize("spoilt", [nan, inf, -inf])
def test_a_number_that_is_none_proves_nothing(spoilt: float) -> None:
    stands, falls = stepped(3, 0.01), stepped(3, 0.05)
    forces = with_contact(forces_of(stands), 1, lambda f: (f[0], f[1], spoilt))
    assert not check_forces(stands, forces, EXACT).holds
    motion = Motion({**motion_of(falls).velocity, "p03": ((spoilt, 0.0, 0.0), (0.0, 0.0, 0.0))})
    assert not check_motion(falls, motion, EXACT).holds
    loads = {**stands.loads, "p02": Wrench((0.0, 0.0, spoilt))}
    assert not check_forces(replace(stands, loads=loads), forces_of(stands), EXACT).holds
    assert not check_motion(replace(falls, loads=loads), motion_of(falls), EXACT).holds


def test_forces_must_be_as_many_as_cones() -> None:
    problem = stepped(3, 0.01)
    forces = forces_of(problem)
    assert not check_forces(problem, Forces(forces.of_contacts[:2]), EXACT).holds
    assert not check_forces(problem, Forces((*forces.of_contacts[:2], forces.of_contacts[2][:3])), EXACT).holds
    doubled = tuple(point * 2 for point in forces.of_contacts[2])
    assert not check_forces(problem, Forces((*forces.of_contacts[:2], doubled)), EXACT).holds


def test_nothing_to_carry_is_balanced_by_no_forces() -> None:
    empty = Problem({}, [], {})
    assert check_forces(empty, Forces(()), EXACT).holds
    weightless = replace(stepped(1, 0.0), loads={})
    nothing = Forces(((((0.0, 0.0, 0.0),),) * 4,))
    assert check_forces(weightless, nothing, EXACT).holds
    assert not check_forces(stepped(1, 0.0), nothing, EXACT).holds


def test_sinking_into_the_ground_gains_but_proves_nothing() -> None:
    problem = stepped(2, 0.01)
    sinking = Motion(dict.fromkeys(problem.bricks, ((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))))
    assert not check_motion(problem, sinking, EXACT).holds
    rising = Motion(dict.fromkeys(problem.bricks, ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))))
    found = check_motion(problem, rising, EXACT)
    assert found.violation == 0.0
    assert not found.holds


def test_a_motion_that_drives_one_brick_into_the_next_is_rejected() -> None:
    # Planks 3 to 10 tip as one body over the end of plank 2.
    problem = stepped(10, 0.0135)
    edge = (0.0135 + 0.5 * LENGTH, 2.0 * THICKNESS)
    motion = Motion({name: _turning(problem, name, edge) for name in sorted(problem.bricks)[2:]})
    assert check_motion(problem, motion, EXACT).holds
    velocity, spin = motion.velocity["p06"]
    faster = (velocity[0], velocity[1], velocity[2] - 1e-6)
    spoilt = Motion({**motion.velocity, "p06": (faster, spin)})
    assert not check_motion(problem, spoilt, EXACT).holds
    held = Motion({name: twist for name, twist in motion.velocity.items() if name != "p06"})
    assert not check_motion(problem, held, EXACT).holds


def _turning(problem: Problem, name: str, edge: tuple[float, float]) -> tuple[Vec3, Vec3]:
    """Velocity and spin of a brick that turns about an edge along y, at this x and z, its x axis dipping."""
    x, _, z = problem.bricks[name].pose.position_W
    return (z - edge[1], 0.0, edge[0] - x), (0.0, 1.0, 0.0)


def test_sliding_must_open_as_much_as_friction_asks() -> None:
    # A block slides down a slope; against friction mu the motion must open by mu for each unit of sliding.
    slope = on_a_slope(0.25 * pi, friction=0.5)
    c = 0.5**0.5

    def sliding(opening: float) -> Motion:
        return Motion({"block": ((c + opening * c, 0.0, -c + opening * c), (0.0, 0.0, 0.0))})

    assert check_motion(slope, sliding(0.5 + 1e-9), EXACT).holds
    assert not check_motion(slope, sliding(0.49), EXACT).holds
    assert not check_motion(slope, sliding(0.5 - 1e-6), EXACT).holds


def test_every_normal_of_an_edge_counts() -> None:
    # An edge that lies in a groove: away from one of its two sides is into the other.
    side, other = (0.6, 0.0, 0.8), (-0.6, 0.0, 0.8)
    groove = Contact("groove", "p01", ((0.0, -0.01, 0.0), (0.0, 0.01, 0.0)), (side, other), Coulomb(0.0))
    problem = replace(column([0.0]), contacts=[groove])
    along = Motion({"p01": ((0.8, 0.0, -0.6), (0.0, 0.0, 0.0))})
    assert not check_motion(problem, along, EXACT).holds
    one_sided = replace(problem, contacts=[replace(groove, normals_W=(side,))])
    assert check_motion(one_sided, along, EXACT).holds


def test_a_fast_light_brick_does_not_hide_that_heavy_ones_close_in() -> None:
    # Heavy planks sink by a thousand millionth of the speed at which a light one flies off: a large gain, and false.
    problem = column([0.0, 0.0, 0.0], masses=[HEAVY, HEAVY, 1e-6])
    sinking = ((0.0, 0.0, -1e-9), (0.0, 0.0, 0.0))
    flying = ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    assert not check_motion(problem, Motion({"p01": sinking, "p02": sinking, "p03": flying}), EXACT).holds


def test_violations_within_rounding_do_not_add_up_to_a_gain() -> None:
    # Every plank of a column sinks a hair more than the one below, each within the tolerance of a single contact.
    count = 400
    problem = column([0.0] * count)
    speeds = {f"p{i + 1:02}": ((1.0, 0.0, -0.9e-9 * (i + 1)), (0.0, 0.0, 0.0)) for i in range(count)}
    smooth = replace(problem, contacts=[replace(c, law=Coulomb(0.0)) for c in problem.contacts])
    loose = Tolerances(gain=1e-8)
    weight_times_speed = sum(-smooth.loads[name].force_W[2] * hypot(*v) for name, (v, _) in speeds.items())
    assert power(smooth.loads, Motion(speeds)) > loose.gain * weight_times_speed
    assert check_motion(smooth, Motion(speeds), loose).violation <= loose.violation
    assert not check_motion(smooth, Motion(speeds), loose).holds


def test_a_body_that_is_none_of_the_bricks_does_not_move() -> None:
    problem = stepped(10, 0.0135)
    motion = Motion({**motion_of(problem).velocity, GROUND: ((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))})
    assert not check_motion(problem, motion, EXACT).holds


def test_the_order_of_bricks_and_contacts_is_nothing_to_a_check() -> None:
    problem = inverted_v(1.2, 0.5)
    forces = forces_of(problem)
    turned = Problem(dict(sorted(problem.bricks.items(), reverse=True)), problem.contacts[::-1], problem.loads)
    assert check_forces(turned, Forces(forces.of_contacts[::-1]), EXACT).holds


def test_normals_are_unit_and_friction_is_not_negative() -> None:
    stands, falls = stepped(2, 0.01), stepped(10, 0.0135)
    for spoilt in ({"normals_W": ((0.0, 0.0, 2.0),)}, {"law": Coulomb(-0.1)}, {"law": Coulomb(nan)}):
        for problem in (stands, falls):
            bad = replace(problem, contacts=[replace(c, **spoilt) for c in problem.contacts])
            if problem is stands:
                assert not check_forces(bad, forces_of(stands), EXACT).holds
            else:
                assert not check_motion(bad, motion_of(falls), EXACT).holds


def test_lifting_opens_a_stack_and_not_a_ladder() -> None:
    stack = stepped(3, 0.01)
    rising = Motion({name: ((0.0, 0.0, float(i + 1)), (0.0, 0.0, 0.0)) for i, name in enumerate(sorted(stack.bricks))})
    assert least_separating_speed(stack, rising) == pytest.approx(
        1.0 / 5.0
    )  # the third against the second: 3 - 2 of 3 + 2
    lifted = Motion({"ladder": (UP, (0.0, 0.0, 0.0))})
    assert least_separating_speed(ladder(1.0, 0.5), lifted) == 0.0
    assert least_separating_speed(ladder(1.0, 0.5, 0.5), lifted) < 0.0


def test_power_is_force_times_velocity_and_torque_times_spin() -> None:
    loads = {"a": Wrench((0.0, 0.0, -2.0), (0.0, 3.0, 0.0)), "still": Wrench((0.0, 0.0, -5.0))}
    motion = Motion({"a": ((1.0, 0.0, 0.5), (0.0, 2.0, 0.0))})
    assert power(loads, motion) == pytest.approx(-1.0 + 6.0)
