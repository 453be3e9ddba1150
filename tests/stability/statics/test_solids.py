"""Statics of convex solids: closed forms on both sides of their limits, and what must not matter."""

from collections.abc import Callable, Sequence
from functools import cache
from math import atan, cos, pi, radians, sin, tan

import numpy as np
import pytest

from stability.geometry.box import Box, OffCentreBox
from stability.geometry.placed_shape import scaled
from stability.geometry.solid_making import FramedSolid, prism
from stability.geometry.vectors import about, add, multiply, rotate, scale
from stability.model import GROUND, IDENTITY, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces, check_motion
from tests.stability.statics.independent import Answer, verdict_of
from tests.stability.statics.random_solids import Scene, random_assembly

BESIDE = 1e-7  # of the limit, a tenth of what is promised
LEVEL = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
OPPOSITE: dict[Stability, Answer] = {Stability.STABLE: "unstable", Stability.UNSTABLE: "stable"}
both_sides = pytest.mark.parametrize(("share", "stands"), [(1.0 - BESIDE, True), (1.0 + BESIDE, False)])


def put(name: str, made: FramedSolid, origin: Vec3, turn: Quaternion = IDENTITY) -> Placed:
    """A solid with the origin in which it was written in a place."""
    return Placed(Brick(name, made.shape, 1.0), Pose(add(origin, rotate(turn, made.centre_of_mass)), turn))


def stands(bricks: Sequence[Placed], friction: float = 0.5, planes: Sequence[Plane] = (LEVEL,)) -> bool:
    verdict = Assembly(planes, friction).add_all(bricks)
    assert verdict.stability is not Stability.UNDECIDED
    return verdict.stability is Stability.STABLE


# --- closed forms -----------------------------------------------------------------------------------------------------


@both_sides
@pytest.mark.parametrize("friction", [0.2, 0.4, 0.9])
def test_a_wedge_slides_down_a_slope_that_is_steeper_than_its_friction(
    friction: float, share: float, stands: bool
) -> None:
    angle = atan(friction * share)
    slope = Plane(GROUND, (0.0, 0.0, 0.0), (sin(angle), 0.0, cos(angle)), friction)
    flat = prism([(0.0, 0.0), (0.3, 0.0), (0.02, 0.05), (0.0, 0.03)], 0.1)
    verdict = Assembly([slope]).add_all([put("wedge", flat, (0.0, 0.0, 0.0), about((0.0, 1.0, 0.0), angle))])
    assert (verdict.stability is Stability.STABLE) is stands


@both_sides
def test_a_box_on_the_slope_of_a_wedge_slides_where_the_slope_is_steeper_than_friction(
    share: float, stands: bool
) -> None:
    #    __
    #  _/ /|   the wedge itself stands on level ground
    # /__/_|
    angle = atan(0.3 * share)
    wedge = prism([(0.0, 0.0), (0.4, 0.0), (0.4, 0.4 * tan(angle))], 0.2)
    turn = about((0.0, 1.0, 0.0), -angle)
    on_slope = add((0.2, 0.0, 0.2 * tan(angle)), rotate(turn, (0.0, 0.0, 0.02)))
    box = Placed(Brick("box", Box((0.08, 0.06, 0.04)), 1.0), Pose(on_slope, turn))
    assert _stands([put("wedge", wedge, (0.0, 0.0, 0.0)), box], friction=0.3) is stands


def _stands(bricks: Sequence[Placed], friction: float) -> bool:
    return stands(bricks, friction)


OUTLINES = {
    "triangle": ([(0.0, 0.0), (0.12, 0.0), (0.0, 0.06)], 0.12 / 3.0),
    "upside down": ([(0.04, 0.0), (0.08, 0.0), (0.12, 0.05), (0.0, 0.05)], 0.06),
    # A trapezoid with sides a and b that stand at right angles to the base h: (a + 2 b) h / (3 (a + b)).
    "trapezoid": ([(0.0, 0.0), (0.12, 0.0), (0.12, 0.08), (0.0, 0.02)], 0.12 * (0.02 + 2.0 * 0.08) / (3.0 * 0.1)),
}


@both_sides
@pytest.mark.parametrize("outline", OUTLINES)
def test_a_prism_tips_off_an_edge_as_its_centre_of_mass_passes_it(outline: str, share: float, stands: bool) -> None:
    corners, centre = OUTLINES[outline]
    table = Placed(Brick("table", Box((0.4, 0.2, 0.1)), 1.0), Pose((-0.2, 0.0, 0.05)))
    #  |\
    #  |_\__   the centre of mass is so far beyond the edge of the table, which is at x = 0
    # ___|
    beyond = (share - 1.0) * 0.12
    assert _stands([table, put("prism", prism(corners, 0.05), (beyond - centre, 0.0, 0.1))], 0.5) is stands


@both_sides
@pytest.mark.parametrize("turned", [0.0, 0.3, 2.0])
def test_a_carton_tips_where_its_mass_is_beyond_the_edge_wherever_its_middle_is(
    turned: float, share: float, stands: bool
) -> None:
    carton = OffCentreBox((0.4, 0.3, 0.2), (0.1, 0.05, -0.03))
    pallet = Placed(Brick("pallet", Box((1.0, 1.0, 0.1)), 10.0), Pose((-0.5, 0.0, 0.05)))
    beyond, turn = (share - 1.0) * 0.4, about((0.0, 0.0, 1.0), turned)
    placed = Placed(Brick("carton", carton, 5.0), Pose((beyond, 0.0, 0.1 + 0.1 - 0.03), turn))
    assert _stands([pallet, placed], 0.5) is stands


@both_sides
def test_a_pyramid_upon_a_pole_stands_by_its_middle_alone(share: float, stands: bool) -> None:
    # Half a pole's width to the side of the middle of its base, a pyramid falls.
    pole = prism([(-0.01, 0.0), (0.01, 0.0), (0.01, 0.2), (-0.01, 0.2)], 0.02)
    pyramid = prism([(-0.1, 0.0), (0.1, 0.0), (0.0, 0.15)], 0.1)
    assert _stands([put("pole", pole, (0.0, 0.0, 0.0)), put("roof", pyramid, (0.01 * share, 0.0, 0.2))], 0.5) is stands


# --- what must not matter ---------------------------------------------------------------------------------------------


def pile(length: float) -> list[tuple[ConvexShape, Vec3, Quaternion]]:
    """A wedge on a table, its slope up, with a prism on the slope, near both limits: sliding and tipping."""
    angle = radians(20.0)
    wedge, rider = (
        prism([(0.0, 0.0), (0.4, 0.0), (0.4, 0.4 * tan(angle))], 0.2),
        prism([(-0.03, 0.0), (0.03, 0.0), (0.03, 0.05), (-0.02, 0.06)], 0.05),
    )
    turn = about((0.0, 1.0, 0.0), -angle)
    on_slope = add((0.2, 0.0, 0.2 * tan(angle)), rotate(turn, rider.centre_of_mass))
    placed = [(wedge.shape, wedge.centre_of_mass, IDENTITY), (rider.shape, on_slope, turn)]
    return [(scaled(shape, length), scale(length, at), q) for shape, at, q in placed]


CHANGES: dict[str, Callable[[float], tuple[float, float, float, Vec3]]] = {
    "size": lambda n: (10.0 ** (n - 2.0), 1.0, 0.0, (0.0, 0.0, 0.0)),
    "density": lambda n: (1.0, 10.0 ** (2.0 * n - 4.0), 0.0, (0.0, 0.0, 0.0)),
    "yaw": lambda n: (1.0, 1.0, 0.7 * n + 0.01, (0.0, 0.0, 0.0)),
    "far away": lambda n: (1.0, 1.0, 0.0, (10.0**n, -(7.0**n), 0.0)),
}


@pytest.mark.parametrize(("friction", "stands"), [(tan(radians(20.0)) * (1 + 1e-6), True), (0.3639702, False)])
@pytest.mark.parametrize("change", CHANGES)
def test_a_verdict_is_the_same_whatever_the_size_the_density_the_yaw_and_the_place(
    change: str, friction: float, stands: bool
) -> None:
    for number in range(5):
        length, density, yaw, shift = CHANGES[change](float(number))
        turn = about((0.0, 0.0, 1.0), yaw)
        bricks = [
            Placed(
                Brick(f"b{index}", shape, density * shape.volume),
                Pose(add(shift, rotate(turn, at)), multiply(turn, own)),
            )
            for index, (shape, at, own) in enumerate(pile(length))
        ]
        assert _stands(bricks, friction) is stands, f"{change} {number}"


def test_names_and_the_order_of_coming_do_not_matter() -> None:
    for seed in range(12):
        bricks = random_assembly(seed).bricks
        renamed = [Placed(Brick(f"z{99 - n}", p.brick.shape, p.brick.mass), p.pose) for n, p in enumerate(bricks)]
        friction = random_assembly(seed).friction
        planes = (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction),)
        assert stands(bricks, friction, planes) is stands(renamed[::-1], friction, planes)


# --- random assemblies against another method -------------------------------------------------------------------------


# Each random assembly is judged once for all tests of this part, which so stay in one process.
ONE_PROCESS = pytest.mark.xdist_group("random solids")


@cache
def judged(seed: int) -> tuple[Scene, Assembly]:
    scene = random_assembly(seed)
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), scene.friction),), scene.friction)
    assembly.add_all(scene.bricks)
    return scene, assembly


@ONE_PROCESS
@pytest.mark.parametrize("seeds", [range(50), pytest.param(range(50, 1000), marks=pytest.mark.slow)])
def test_random_assemblies_touch_as_they_were_put_and_no_linear_programme_contradicts_a_verdict(seeds: range) -> None:
    undecided = unstable = 0
    for seed in seeds:
        scene, assembly = judged(seed)
        known = {(touch.lower, touch.upper) for touch in scene.touches}
        assert {(contact.lower, contact.upper) for contact in assembly.all_contacts()} == known, seed
        verdict = assembly.verdict()
        undecided += verdict.stability is Stability.UNDECIDED
        unstable += verdict.stability is Stability.UNSTABLE
        answer = verdict_of({placed.brick.id: placed for placed in scene.bricks}, scene.touches)
        assert answer is None or answer != OPPOSITE.get(verdict.stability), seed
    assert undecided <= 0.01 * len(seeds)
    assert 0.3 * len(seeds) < unstable < 0.9 * len(seeds)


@ONE_PROCESS
def test_random_assemblies_have_proofs_that_hold_by_plain_arithmetic() -> None:
    for seed in range(50):
        _, assembly = judged(seed)
        verdict = assembly.verdict()
        if verdict.stability is Stability.STABLE:
            forces = assembly.forces()
            assert forces is not None
            assert check_forces(assembly.problem(), forces, Tolerances()).holds
        elif verdict.motion is not None:
            assert check_motion(assembly.problem(), verdict.motion, Tolerances()).holds


@ONE_PROCESS
def test_patches_are_where_two_other_faces_overlap() -> None:
    for seed in range(50):
        scene, assembly = judged(seed)
        found = {(contact.lower, contact.upper): contact for contact in assembly.all_contacts()}
        for touch in scene.touches:
            contact = found[touch.lower, touch.upper]
            wanted, there = np.array(touch.points), np.array(contact.points_W)
            apart = np.linalg.norm(wanted[:, None, :] - there[None, :, :], axis=2)
            assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-9, (seed, touch)
            assert contact.normals_W[0] == pytest.approx(touch.normal, abs=1e-9)


def test_a_whole_turn_of_a_prism_about_the_vertical_leaves_it_standing() -> None:
    hexagon = prism([(0.05 * cos(pi * n / 3.0), 0.05 * sin(pi * n / 3.0)) for n in range(6)], 0.05)
    upright = multiply(about((0.0, 0.0, 1.0), 0.1), about((1.0, 0.0, 0.0), 0.5 * pi))
    for number in range(12):
        turn = multiply(about((0.0, 0.0, 1.0), number * pi / 6.0), upright)
        lower, upper = (
            put("lower", hexagon, (0.0, 0.0, 0.025), turn),
            put("upper", hexagon, (0.01, 0.0, 0.075), upright),
        )
        assert _stands([lower, upper], 0.5)
