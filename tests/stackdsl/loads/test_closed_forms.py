"""Loads against closed forms: each limit is proven from both sides, to a millionth."""

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.optimize import linprog

from stability import Stability, load_factor
from stackdsl.judging.proofs import finished_structure_of
from tests.scenes import timeline_of

ACCURACY = 1e-6
BLOCK = "\nbrick: {size: [0.3 m, 0.4 m, 0.9 m], density: 200 kg/m3}\nfriction: 0.5"
ON_THE_GROUND = "- bricks: [{name: block, at: [0 m, 0 m, 0.45 m]}]"
W, B, D, H, MU = 200.0 * 0.3 * 0.4 * 0.9 * 9.81, 0.3, 0.4, 0.9, 0.5  # of this block


def loaded(scene: str, *loads: str) -> str:
    return f"{scene}\nloads: [{', '.join(f'{{{load}}}' for load in loads)}]"


def factor_of(build: str, scene: str, *loads: str) -> float:
    """Return the factor on the loads at which a structure fails; the proofs on both sides and two verdicts agree."""
    problem = finished_structure_of(timeline_of(build, loaded(scene, *loads))).assembly.problem()
    found = load_factor(problem.unloaded, problem.applied)
    assert found is not None
    assert found.too_large == pytest.approx(found.factor, rel=ACCURACY)
    return found.factor


def verdict_of(build: str, scene: str, *loads: str) -> Stability:
    return finished_structure_of(timeline_of(build, loaded(scene, *loads))).assembly.verdict().stability


@pytest.mark.parametrize(
    ("load", "limit"),
    [
        # a push at a height h tips the block at F h = W b / 2, and slides it at F = mu W
        ("force: {} N, towards: 0 deg, point: [0 m, 0 m, 0.35 m]", W * B / 2 / 0.8),
        ("force: {} N, towards: 90 deg, point: [0 m, 0 m, 0.35 m]", W * D / 2 / 0.8),
        ("force: {} N, towards: 180 deg, point: [0 m, 0 m, -0.4 m]", MU * W),
        ("force: {} N, towards: up", W),
        ("force: {} N, towards: up, point: [0.15 m, 0 m, 0.45 m]", W / 2),
        ("moment: {} N*m, about: 90 deg", W * B / 2),
        ("moment: {} N*m, about: 180 deg", W * D / 2),
        # wind on a face, and suction on it, tip at p A H / 2 = W b / 2
        ("pressure: {} Pa, face: 180 deg", W * B / (D * H * H)),
        ("pressure: -{} Pa, face: 0 deg", W * B / (D * H * H)),
        ("pressure: -{} Pa, face: top", W / (B * D)),
        # a line load along an upper edge, of length D
        ("line: {} N/m, towards: 0 deg, from: [0 m, -0.2 m, 0.45 m], to: [0 m, 0.2 m, 0.45 m]", W * B / 2 / H / D),
    ],
)
def test_a_block_tips_slides_or_lifts_at_the_closed_form(load: str, limit: float) -> None:
    below, above = (f"{load.format(limit * (1.0 + share))}, brick: block" for share in (-ACCURACY, ACCURACY))
    assert factor_of(ON_THE_GROUND, BLOCK, f"{load.format(limit / 2)}, brick: block") == pytest.approx(2, rel=ACCURACY)
    assert verdict_of(ON_THE_GROUND, BLOCK, below) is Stability.STABLE
    assert verdict_of(ON_THE_GROUND, BLOCK, above) is Stability.UNSTABLE


SHELF = """- bricks:
    - {name: base, at: [0 m, 0 m, 0.45 m]}
    - {name: plank, brick: {size: [1 m, 0.3 m, 0.02 m], mass: 3 kg}, at: [0.3 m, 0 m, 0.91 m]}
    - {name: ballast, brick: {size: [0.1 m, 0.1 m, 0.1 m], mass: 8 kg}, at: [-0.1 m, 0 m, 0.97 m]}"""


@pytest.mark.parametrize(
    ("load", "arm"),
    [
        ("weight: {} N, point: [0.5 m, 0 m, 0.01 m]", 0.65),
        ("weight: {} N, face: 0 deg", 0.65),
        ("line: {} N/m, towards: down, from: [0.4 m, 0 m, 0.01 m], to: [0.5 m, 0 m, 0.01 m]", 0.6 * 0.1),
    ],
)
def test_a_weight_at_the_end_of_a_plank_lifts_its_ballast(load: str, arm: float) -> None:
    # The plank turns about the edge of the base at x = 0.15 m; a 0.25 m long ballast arm and its own weight hold it.
    limit = (8 * 9.81 * 0.25 - 3 * 9.81 * 0.15) / arm
    for share, stability in ((-ACCURACY, Stability.STABLE), (ACCURACY, Stability.UNSTABLE)):
        written = f"{load.format(limit * (1.0 + share))}, brick: plank"
        assert verdict_of(SHELF, BLOCK, written) is stability
    assert factor_of(SHELF, BLOCK, f"{load.format(limit)}, brick: plank") == pytest.approx(1, rel=ACCURACY)


def test_a_mass_weighs_by_the_gravity_of_the_scene_and_a_level_shares_its_load() -> None:
    scene = BLOCK + "\nworld: {gravity: 1.62 m/s2}"
    two = "- bricks: [{name: a, at: [0 m, 0 m, 0.45 m]}, {name: b, at: [2 m, 0 m, 0.45 m]}]"
    timeline = timeline_of(two, loaded(scene, "weight: 10 kg, level: 1", "weight: 7 N, bricks: [a]"))
    applied = finished_structure_of(timeline).assembly.problem().applied
    assert applied["a"].force_W == pytest.approx((0.0, 0.0, -5 * 1.62 - 7))
    assert applied["b"].force_W == pytest.approx((0.0, 0.0, -5 * 1.62))


# --- an arch under a load at a point, against a linear program written apart ------------------------------------------

STONES, INNER, OUTER, DEPTH, RUBBING = 11, 1.0, 1.3, 0.5, 0.6
ARCH = f"- arch: {{span: {2 * INNER} m, thickness: {OUTER - INNER} m, voussoirs: {STONES}, depth: {DEPTH} m}}"
STONE = f"\nbrick: {{size: [1 m, 1 m, 1 m], density: 2000 kg/m3}}\nfriction: {RUBBING}"


def limit_of_arch(stone: int, towards: tuple[float, float]) -> float:
    """Return the greatest force [N] at the centre of a stone: forces at two points of each joint, in the plane."""
    angles = [pi - pi * number / STONES for number in range(STONES + 1)]
    ends = [[np.array([r * cos(angle), r * sin(angle)]) for r in (INNER, OUTER)] for angle in angles]
    rows, right = np.zeros((3 * STONES, 4 * (STONES + 1) + 1)), np.zeros(3 * STONES)
    for number in range(STONES):
        corners = [*ends[number], *ends[number + 1][::-1]]
        area, centre = _polygon(corners)
        for joint, side in ((number, 1.0), (number + 1, -1.0)):
            # The force of the stone to the left on the one to the right: along the normal, and along the joint.
            along = np.array([cos(angles[joint]), sin(angles[joint])])
            normal = np.array([along[1], -along[0]])
            for end in (0, 1):
                for part, direction in enumerate((normal, along)):
                    column = 4 * joint + 2 * end + part
                    force, arm = side * direction, ends[joint][end] - centre
                    rows[3 * number : 3 * number + 3, column] = (*force, arm[0] * force[1] - arm[1] * force[0])
        right[3 * number + 1] = 2000.0 * 9.81 * DEPTH * area
        if number == stone - 1:
            rows[3 * number : 3 * number + 2, -1] = towards
    bounds, cones = [(0, None), (None, None)] * (2 * (STONES + 1)) + [(0, None)], []
    for point in range(2 * (STONES + 1)):
        for sign in (1.0, -1.0):
            cone = np.zeros(rows.shape[1])
            cone[2 * point], cone[2 * point + 1] = -RUBBING, sign
            cones.append(cone)
    cost = np.zeros(rows.shape[1])
    cost[-1] = -1.0
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    found = linprog(cost, np.array(cones), np.zeros(len(cones)), rows, right, bounds, options=tight)
    assert found.success
    return -float(found.fun)


def _polygon(corners: list[np.ndarray]) -> tuple[float, np.ndarray]:
    total, centre = 0.0, np.zeros(2)
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        cross = a[0] * b[1] - a[1] * b[0]
        total, centre = total + cross / 2, centre + cross * (a + b) / 6
    return abs(total), centre / total


@pytest.mark.parametrize(
    ("stone", "towards", "direction"),
    [(6, "down", (0, -1)), (4, "down", (0, -1)), (3, "0 deg", (1, 0)), (6, "up", (0, 1))],
)
def test_an_arch_bears_a_load_up_to_the_limit_of_another_program(
    stone: int, towards: str, direction: tuple[float, float]
) -> None:
    limit = limit_of_arch(stone, direction)
    load = f"force: {limit / 2:.12g} N, towards: {towards}, brick: L1.{stone}"
    assert factor_of(ARCH, STONE, load) == pytest.approx(2, rel=ACCURACY)


# --- what does not change a limit -------------------------------------------------------------------------------------


def stack(turn: float = 0.0, size: float = 1.0, names: str = "abc", load: float = 7.0, flip: bool = False) -> float:
    """Return the factor of three stacked blocks, two of which are pushed; lengths are times `size`."""
    places = [(0.0, 0.1), (0.05, 0.3), (-0.02, 0.5)]
    bricks = [
        f"{{name: {name}, at: [{size * x * cos(turn)} m, {size * x * sin(turn)} m, {size * z} m], "
        f"rotate: [0 deg, 0 deg, {turn} rad]}}"
        for name, (x, z) in zip(names, places, strict=True)
    ]
    built = f"- bricks: [{', '.join(bricks)}]"
    scene = f"\nbrick: {{size: [{0.3 * size} m, {0.4 * size} m, {0.2 * size} m], density: {500 / size**3} kg/m3}}"
    arm = 0.05 * size
    loads = [
        f"force: {load} N, towards: {turn} rad, brick: {names[2]}, "
        f"point: [{-arm * sin(turn)} m, {arm * cos(turn)} m, {arm} m]",
        f"pressure: {load / size**2} Pa, face: {turn + pi / 2} rad, brick: {names[1]}",
    ]
    return load * factor_of(built, scene, *(reversed(loads) if flip else loads))


def test_a_limit_does_not_depend_on_names_order_turn_or_scale() -> None:
    plain = stack()
    assert plain > 1.0
    assert stack(names="rqp") == pytest.approx(plain, rel=ACCURACY)
    assert stack(flip=True) == plain
    assert stack(turn=0.7) == pytest.approx(plain, rel=ACCURACY)
    assert stack(size=12.0) == pytest.approx(plain, rel=ACCURACY)
    assert stack(load=20.0) == pytest.approx(plain, rel=ACCURACY)
