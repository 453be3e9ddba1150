"""Bounds by bearing that few directions give: against each direction solved by itself, of piles drawn at random."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import cos, inf, pi, sin

import numpy as np
import pytest

from stability.analysis import bearings
from stability.analysis import bearings as rough_headings_module
from stability.analysis.acceleration_cut import AcceleratedProblem, Heading, heading, program_along, shaken
from stability.analysis.bearings import (
    RoughHeadings,
    Survived,
    along_bearing,
    by_bearing,
    rough_headings,
)
from stability.analysis.symmetry import Symmetry, proven_cut, symmetries
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Motion, Placed, Problem, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.cone_rows import ConeRows
from stability.statics.conic_program import QuickSeries, quick_solve
from stability.statics.proof import check_motion
from tests.stability.statics.random_piles import random_pile

COUNT, TOLERANCE = 12, 0.01
PILES = (2, 7, 11, 17, 22, 46)  # numbers of piles that stand
BEYOND = 1.0 + 1e-5  # times a bound: what it must bring down


def problem_of(boxes: Sequence[Placed], friction: float) -> Problem:
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction),), friction, overlap=inf)
    assert assembly.add_all(boxes).stability is Stability.STABLE
    return assembly.problem()


def grid(counts: tuple[int, int, int], size: tuple[float, float, float], heavy: float = 1.0) -> list[Placed]:
    """Boxes flush beside and on each other; the first weighs so many times what the others do."""
    places = [(i, j, k) for k in range(counts[2]) for j in range(counts[1]) for i in range(counts[0])]
    return [
        Placed(
            Brick(f"b{i}{j}{k}", Box(size), heavy if i == j == k == 0 else 1.0),
            Pose((i * size[0], j * size[1], (k + 0.5) * size[2])),
        )
        for i, j, k in places
    ]


@cache
def shaken_grid(heavy: float = 1.0, length: float = 0.3) -> AcceleratedProblem:
    case = shaken(problem_of(grid((2, 2, 3), (length, 0.2, 0.25), heavy), 0.5), None, Tolerances())
    assert case is not None
    return case


@pytest.mark.parametrize("number", PILES)
def test_the_bounds_hold_what_each_direction_is_solved_for_and_are_as_near_to_it_as_was_asked(number: int) -> None:
    problem = problem_of(random_pile(np.random.default_rng([7, number]), number), (0.2, 0.5, 1.2)[number % 3])
    found = by_bearing(problem, COUNT, TOLERANCE)
    assert found is not None
    for each in found:
        alone = along_bearing(problem, each.bearing)
        assert alone is not None
        assert each.value <= alone.upper
        assert each.upper >= alone.value
        assert each.value >= (1.0 - TOLERANCE) * each.upper
    assert_fall(problem, found)


def assert_fall(problem: Problem, found: Sequence[Survived]) -> None:
    """Each motion is proven to lower what is pulled a little harder."""
    case = shaken(problem, None, Tolerances())
    assert case is not None
    for each in found:
        assert each.motion is not None
        harder = case.loaded(*(BEYOND * each.upper * part for part in (cos(each.bearing), sin(each.bearing))))
        assert check_motion(harder, each.motion, Tolerances()).holds


@pytest.mark.parametrize("angle", [0.3, 2.0, 4.4])
@pytest.mark.parametrize("tolerance", [0.01, 1e-4])
def test_a_direction_that_is_solved_roughly_is_proven_all_the_same(angle: float, tolerance: float) -> None:
    case = shaken_grid()
    exact, rough = heading(case, angle), rough_headings(case, tolerance).solve(angle)
    assert (1.0 - tolerance) * exact.reach <= rough.reach <= exact.reach * (1.0 + 1e-6)
    assert case.holds(*rough.point, rough.rows)
    assert rough.cut is not None
    x, y = rough.cut.normal
    assert case.falls(rough.cut.distance * x, rough.cut.distance * y, rough.cut.motion).holds


def test_a_direction_that_is_solved_after_others_reaches_as_far_as_alone() -> None:
    case = shaken_grid()
    series = QuickSeries(1e-9)
    for angle in (0.0, 0.3, pi / 2.0, 3.9):  # along an axis nothing pulls across it
        program = program_along(case, angle)
        assert series.solve(program).dual[0] == pytest.approx(quick_solve(program, 1e-9).dual[0], rel=1e-7)


@pytest.mark.parametrize(
    ("force", "share"),
    [
        ((0.0, 1.0, 0.0), 0.5),  # |1 - s| = s
        ((-1.0, 0.0, 0.0), 0.5),  # s = 1 - s
        ((-1.0, 0.0, 0.5), 0.6),  # 0.5 (1 - s) = 2 s - 1; it leaves the cone upside down before, at 0.2
        ((0.0, 3.0, 4.0), 5.0 / 6.0),  # 5 (1 - s) = s
        ((1.0, 0.6, 0.8), 0.0),
    ],
)
def test_a_force_is_brought_into_its_cone_by_no_more_of_one_on_its_axis_than_it_takes(
    force: tuple[float, float, float], share: float
) -> None:
    rows, deep = np.array([*force, 0.1]), np.array([1.0, 0.0, 0.0, 1.0])
    assert ConeRows(1, 1).least_share(rows, deep) == pytest.approx(share, rel=1e-12)


def test_the_least_share_presses_a_frictionless_row_no_more_than_needed() -> None:
    rows, deep = np.array([1.0, 0.0, 0.0, -3.0]), np.array([1.0, 0.0, 0.0, 1.0])
    assert ConeRows(1, 1).least_share(rows, deep) == pytest.approx(0.75)


def test_a_grid_needs_no_direction_solved_finely(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rough_headings_module, "heading", None)  # calling it is an error
    headings = rough_headings(shaken_grid(), TOLERANCE)
    assert all(headings.solve(angle).reach > 0.0 for angle in (0.0, 0.7, 1.5))


def test_motions_that_a_poor_solution_closes_are_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rough_headings_module, "heading", None)  # calling it is an error
    monkeypatch.setattr(rough_headings_module, "ROUGHEST", 1e-4)
    headings = rough_headings(shaken_grid(), 1.0)
    for angle in (0.0, 0.7, 1.5):
        one, exact = headings.solve(angle), heading(shaken_grid(), angle)
        assert one.cut is not None
        share = one.cut.normal[0] * cos(angle) + one.cut.normal[1] * sin(angle)
        assert exact.reach <= one.cut.distance / share <= 1.1 * exact.reach


@pytest.mark.parametrize("rise", [0.49, 0.51, 0.8])
def test_a_rising_motion_rules_out_accelerations_only_beyond_the_friction(rise: float) -> None:
    case = shaken_grid()
    cut = proven_cut(case, Motion(dict.fromkeys(case.system.names, ((1.0, 0.0, rise), (0.0, 0.0, 0.0)))))
    if rise < 0.5:
        assert cut is None
    else:
        assert cut is not None
        assert cut.normal == (1.0, 0.0)
        assert cut.distance == pytest.approx(rise, rel=1e-8)


def solved_for(monkeypatch: pytest.MonkeyPatch, problem: Problem, count: int) -> tuple[int, tuple[Survived, ...]]:
    """How many directions the solver is asked for, and what is found."""
    asked: list[float] = []

    def solve(self: RoughHeadings, angles: Sequence[float]) -> list[Heading]:
        asked.extend(angles)
        return SOLVE(self, angles)

    monkeypatch.setattr(RoughHeadings, "solve_all", solve)
    found = by_bearing(problem, count, TOLERANCE)
    assert found is not None
    return len(asked), found


SOLVE = RoughHeadings.solve_all


def test_of_a_grid_a_quarter_tells_of_all_four(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(grid((2, 2, 3), (0.3, 0.2, 0.25)), 0.5)
    few, by_images = solved_for(monkeypatch, problem, 24)
    monkeypatch.setattr(bearings, "symmetries", lambda _: ())
    many, one_by_one = solved_for(monkeypatch, problem, 24)
    assert few <= many / 4 + 3  # two of the four directions that come first lie on a mirror
    for image, solved in zip(by_images, one_by_one, strict=True):
        assert image.value <= solved.upper
        assert solved.value <= image.upper
        assert image.value >= (1.0 - TOLERANCE) * image.upper
    assert_fall(problem, by_images)


def test_a_grid_is_its_own_image_in_three_ways_one_of_squares_in_seven_and_one_that_is_uneven_in_one() -> None:
    assert len(symmetries(shaken_grid())) == 3
    assert len(symmetries(shaken_grid(length=0.2))) == 7
    assert len(symmetries(shaken_grid(heavy=1.00001))) == 0
    assert len(symmetries(shaken_grid(heavy=1.00001, length=0.2))) == 1  # about the diagonal through the heavy box


def test_an_image_that_is_none_proves_nothing() -> None:
    even, uneven = shaken_grid(), shaken_grid(heavy=3.0)
    mirrors = [one for one in symmetries(even) if np.linalg.det(one.matrix) < 0.0]
    angle = 0.9
    one = heading(uneven, angle)
    assert mirrors
    for mirror in mirrors:
        assert mirror.image(uneven, one, mirror.angle(angle)) is None
        assert mirror.image(even, heading(even, angle), mirror.angle(angle)) is not None
        assert swapped(mirror).image(even, heading(even, angle), mirror.angle(angle)) is None


def swapped(symmetry: Symmetry) -> Symmetry:
    """With the images of two cones exchanged."""
    cones = symmetry.cones.copy()
    cones[[0, -1]] = cones[[-1, 0]]
    return replace(symmetry, cones=cones)


def test_the_acceleration_margin_of_isotropic_sliding_is_the_friction_at_each_bearing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = problem_of(grid((1, 1, 2), (0.5, 0.5, 0.1)), 0.3)
    few, found = solved_for(monkeypatch, problem, 72)
    assert few == 24  # arcs of 15 deg leave 0.86 % between chord and arc, arcs of 20 deg 1.5 %
    for each in found:
        assert each.upper == pytest.approx(0.3, rel=1e-6)
        assert each.motion is not None
        assert set(each.motion.velocity) == {"b000", "b001"}
        assert {velocity for velocity, _ in each.motion.velocity.values()} == {
            (cos(each.bearing), sin(each.bearing), 0.3)
        }
    assert_fall(problem, found)


def test_bearings_may_be_told_in_any_turn() -> None:
    problem = problem_of([Placed(Brick("one", Box((0.3, 0.2, 0.5)), 1.0), Pose((0.0, 0.0, 0.25)))], 2.0)
    asked = [-0.4, 0.2, 2.0 * pi + 1.0, -7.0]
    found = bearings.along_bearings(problem, asked)
    again = bearings.along_bearings(problem, [angle % (2.0 * pi) for angle in asked])
    assert found is not None
    assert again is not None
    assert [each.bearing for each in found] == asked
    for one, other in zip(found, again, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-9)
