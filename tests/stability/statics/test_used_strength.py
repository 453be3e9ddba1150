"""The strength that stacks use against closed forms, proven on both sides: stress blocks, stacks that crush."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

from stability.contact_law import OtherLawError
from stability.geometry.box import Box
from stability.geometry.vectors import about, rotate
from stability.joints import DRY, Bond, JointRule, Joints
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Problem
from stability.statics.assembly import Assembly
from stability.statics.conic_program import ConicProgram, SolverPoint, clarabel_solve
from stability.statics.used_strength import UsedStrength, used_strength
from stability.strength import Strength

G = 10.0  # [m/s2]
CLOSE = 1e-6
B, L = 0.4, 0.2  # sides of a block [m]
WEAK = 1e4  # [Pa]


def box(name: str, size: Vec3, weight: float, at: Vec3, turn: float = 0.0) -> Placed:
    about_z = about((0.0, 0.0, 1.0), turn)
    return Placed(Brick(name, Box(size), weight / G), Pose(rotate(about_z, at), about_z))


def problem_of(*bricks: Placed, joints: Joints = DRY) -> Problem:
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5),), 0.5, G, joints=joints)
    assembly.add_all(bricks)
    return assembly.problem()


def cartons(count: int) -> Problem:
    """A column of cartons of 120 N."""
    return problem_of(*(box(f"c{i}", (0.4, 0.3, 0.25), 120.0, (0.0, 0.0, 0.125 + 0.25 * i)) for i in range(count)))


def share(problem: Problem, strengths: Mapping[str, Strength]) -> float:
    """The used share, proven from both sides."""
    used = used_strength(problem, strengths)
    assert used.least == pytest.approx(used.enough, rel=CLOSE)
    return used.enough


def loaded_off_centre(off_x: float, off_y: float = 0.0, turn: float = 0.0) -> Problem:
    """A light plate on a light block, and 100 N on a small spot of the plate, off the centre of both."""
    return problem_of(
        box("block", (B, L, 0.1), 1e-7, (0.0, 0.0, 0.05), turn),
        box("plate", (B, L, 0.1), 1e-7, (0.0, 0.0, 0.15), turn),
        box("load", (1e-3, 1e-3, 0.1), 100.0, (off_x, off_y, 0.25), turn),
    )


@pytest.mark.parametrize(("count", "bears"), [(10, True), (11, True), (12, False)])
def test_a_stack_crushes_beyond_the_number_of_cartons_that_the_lowest_one_bears(count: int, bears: bool) -> None:
    strengths = {f"c{i}": Strength(stack=1200.0) for i in range(count)}
    used = used_strength(cartons(count), strengths, decide=True)
    assert (used.bears, used.crushes) == (bears, not bears)
    assert share(cartons(count), strengths) == pytest.approx(120.0 * (count - 1) / 1200.0, rel=CLOSE)
    assert used.crushes is False or used.brick == "c0"


@pytest.mark.parametrize("weight", [100.0, 150.0, 170.0])
def test_a_lighter_column_beside_a_heavy_one_relieves_it_by_what_its_friction_can_take(weight: float) -> None:
    #   Friction F on the side faces of the upper four light cartons, weight V, presses them onto the lowest one. They
    #   are pushed outwards by F / mu <= mu (V + F), so F = mu^2 V / (1 - mu^2). The heavy column is the left one.
    def column(name: str, own: float, x: float) -> list[Placed]:
        return [box(f"{name}{i}", (0.3, 0.4, 0.25), own, (x, 0.0, 0.125 + 0.25 * i)) for i in range(5)]

    problem = problem_of(*column("a", weight, 0.0), *column("b", 20.0, 0.3))
    strengths = dict.fromkeys(problem.bricks, Strength(stack=600.0))
    relief = 0.25 * 80.0 / 0.75
    assert share(problem, strengths) == pytest.approx((4.0 * weight - relief) / 600.0, rel=CLOSE)


def test_a_uniform_pressure_is_the_weight_over_the_area() -> None:
    strengths = {f"c{i}": Strength(pressure=WEAK) for i in range(6)}
    assert share(cartons(6), strengths) == pytest.approx(6 * 120.0 / (0.4 * 0.3) / WEAK, rel=CLOSE)


@pytest.mark.parametrize("off", [0.0, 0.02, B / 6.0, 0.1, 0.15])
def test_an_eccentric_load_needs_the_stress_block_about_its_line(off: float) -> None:
    """In and beyond the middle third: the width of the block is twice the distance of the load from the edge."""
    pressed = 100.0 / (L * (B - 2.0 * off))
    assert share(loaded_off_centre(off), {"block": Strength(pressure=WEAK)}) == pytest.approx(pressed / WEAK, rel=CLOSE)


def test_a_load_near_a_corner_needs_a_triangle_with_its_centroid_there() -> None:
    near = 0.05  # [m] from both edges: the legs of the triangle are three times as long
    pressed = 100.0 / (0.5 * (3.0 * near) ** 2)
    problem = loaded_off_centre(B / 2.0 - near, L / 2.0 - near)
    assert share(problem, {"block": Strength(pressure=WEAK)}) == pytest.approx(pressed / WEAK, rel=CLOSE)


def test_a_plank_shares_its_weight_so_that_the_weaker_support_bears_as_little_as_it_can() -> None:
    supports = [box(name, (0.1, 0.1, 0.1), 10.0, (x, 0.0, 0.05)) for name, x in (("left", -0.2), ("right", 0.2))]
    problem = problem_of(*supports, box("plank", (0.8, 0.1, 0.02), 30.0, (0.05, 0.0, 0.11)))
    least = 30.0 * (0.05 + 0.15) / (0.15 + 0.25)  # on the right: levers to the edges nearest to the left end
    assert share(problem, {"right": Strength(stack=10.0)}) == pytest.approx(1.5, rel=CLOSE)
    assert share(problem, {"left": Strength(stack=1e3), "right": Strength(stack=10.0)}) == pytest.approx(
        least / 10.0, rel=CLOSE
    )


def test_turned_blocks_of_twice_the_strength_use_half_the_share() -> None:
    strengths = {"block": Strength(pressure=2.0 * WEAK)}
    pressed = 100.0 / (L * (B - 0.2))
    assert share(loaded_off_centre(-0.1, 0.0, 0.3 * pi), strengths) == pytest.approx(0.5 * pressed / WEAK, rel=CLOSE)


def test_bricks_without_a_strength_use_none() -> None:
    assert used_strength(cartons(3), {}) == UsedStrength(0.0, 0.0, None)
    assert share(cartons(3), {"c2": Strength(stack=1.0)}) == 0.0


def test_a_structure_that_falls_is_borne_by_no_strength() -> None:
    problem = problem_of(
        box("base", (0.1, 0.1, 0.1), 10.0, (0.0, 0.0, 0.05)), box("top", (0.2, 0.1, 0.1), 10.0, (0.06, 0.0, 0.15))
    )
    used = used_strength(problem, {"base": Strength(pressure=1e9)})
    assert used.enough == inf
    assert not used.bears


@pytest.mark.parametrize("error", [1e-3, 0.1])
def test_no_wrong_point_of_a_solver_proves_too_large_a_share(error: float, monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(35)

    def wrong(program: ConicProgram, accuracy: float) -> SolverPoint:
        point = clarabel_solve(program, accuracy)
        return replace(point, x=point.x * (1.0 + error * random.uniform(-1.0, 1.0, point.x.shape)))

    monkeypatch.setattr("stability.statics.used_strength.clarabel_solve", wrong)
    used = used_strength(loaded_off_centre(0.1), {"block": Strength(pressure=WEAK)}, decide=True)
    assert used.least <= 100.0 / (L * (B - 0.2)) / WEAK * (1.0 + 1e-9)


def test_joints_and_strengths_that_are_none_are_refused() -> None:
    joints = Joints((JointRule(Bond(1e3, 1e3), (frozenset({"c0"}), frozenset({"c1"}))),))
    glued = [box(f"c{i}", (0.4, 0.3, 0.25), 120.0, (0.0, 0.0, 0.125 + 0.25 * i)) for i in range(2)]
    with pytest.raises(OtherLawError, match="not supported for bricks with joints"):
        used_strength(problem_of(*glued, joints=joints), {"c0": Strength(stack=1.0)})
    with pytest.raises(ValueError, match="the stack that 'c0' bears is 0"):
        used_strength(cartons(2), {"c0": Strength(stack=0.0)})
    with pytest.raises(TypeError, match="write Strength"):
        used_strength(cartons(2), {"c0": 5.0})  # type: ignore[dict-item]
