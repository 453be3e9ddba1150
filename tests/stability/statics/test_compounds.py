"""Statics of rigid bodies of several parts: closed forms on both sides of their limits, and what must not matter."""

from collections.abc import Sequence
from math import atan, cos, pi, sin

import numpy as np
import pytest

from stability.geometry.box import Box
from stability.geometry.compound import Compound
from stability.geometry.compound_making import compound
from stability.geometry.placed_shape import scaled
from stability.geometry.solid_making import prism
from stability.geometry.vectors import about, add, multiply, rotate, scale
from stability.model import Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces, check_motion
from tests.stability.statics.compounds import boxes, ground, joined_verdict, put, random_assembly
from tests.stability.statics.independent import Answer

BESIDE = 1e-7  # of the limit, a tenth of what is promised
OPPOSITE: dict[Stability, Answer] = {Stability.STABLE: "unstable", Stability.UNSTABLE: "stable"}
both_sides = pytest.mark.parametrize(("share", "stands"), [(1.0 - BESIDE, True), (1.0 + BESIDE, False)])

ANGLE = boxes(((0.1, 0.1, 0.02), (0.0, 0.0, 0.01)), ((0.02, 0.1, 0.08), (-0.04, 0.0, 0.06)))
TABLE = boxes(
    ((0.6, 0.4, 0.02), (0.0, 0.0, 0.49)),
    *(((0.04, 0.04, 0.48), (x, y, 0.24)) for x in (-0.28, 0.28) for y in (-0.18, 0.18)),
)
HOLLOW = boxes(
    *(((0.4, 0.03, 0.2), (0.0, y, 0.1)) for y in (-0.085, 0.085)),
    *(((0.03, 0.14, 0.2), (x, 0.0, 0.1)) for x in (-0.185, 0.0, 0.185)),
)
SADDLE = boxes(((0.1, 0.05, 0.02), (0.0, 0.0, 0.01)), *(((0.02, 0.05, 0.08), (x, 0.0, -0.04)) for x in (-0.04, 0.04)))
SHELF = Placed(Brick("shelf", Box((0.2, 0.2, 0.1)), 5.0), Pose((0.0, 0.0, 0.05)))


def stands(bricks: Sequence[Placed], friction: float = 0.5, plane: Plane | None = None) -> bool:
    verdict = Assembly([plane or ground(friction)], friction).add_all(bricks)
    assert verdict.stability is not Stability.UNDECIDED, verdict.reason
    return verdict.stability is Stability.STABLE


def slope(angle: float, friction: float) -> tuple[Plane, Quaternion]:
    return Plane("ground", (0.0, 0.0, 0.0), (sin(angle), 0.0, cos(angle)), friction), about((0.0, 1.0, 0.0), angle)


@both_sides
def test_an_angle_tips_off_a_shelf_as_its_centre_of_mass_passes_the_edge(share: float, stands: bool) -> None:
    # The foot of 0.1 x 0.02 and the upright of 0.02 x 0.08 have the common centre (0.2 * 0 - 0.16 * 0.04) / 0.36.
    centre = -0.0016 * 0.04 / 0.0036
    origin = 0.1 * share - centre
    verdict = Assembly([ground(0.5)]).add_all([SHELF, put("angle", ANGLE, (origin, 0.0, 0.1))])
    assert (verdict.stability is Stability.STABLE) is stands


@both_sides
@pytest.mark.parametrize("friction", [0.2, 0.35])
def test_a_saddle_slides_along_a_beam_that_is_steeper_than_its_friction(
    friction: float, share: float, stands: bool
) -> None:
    # With 5 mm of room on both sides. Where it fits exactly, friction may press a cheek, which then holds it as well.
    angle = atan(friction * share)
    turn = about((0.0, 1.0, 0.0), angle)
    beam = Placed(Brick("beam", Box((0.4, 0.05, 0.3)), 9.0), Pose(rotate(turn, (0.0, 0.0, 0.15)), turn))
    along = multiply(turn, about((0.0, 0.0, 1.0), 0.5 * pi))
    table = Plane("ground", (0.0, 0.0, 0.0), (sin(angle), 0.0, cos(angle)), 0.9)
    saddle = put("saddle", SADDLE, rotate(turn, (0.0, 0.0, 0.3)), along)
    assembly = Assembly([table], friction)
    assert (assembly.add_all([beam, saddle]).stability is Stability.STABLE) is stands


@pytest.mark.parametrize(("half", "stands"), [(0.03, True), (0.025, False)])
def test_a_cheek_holds_a_saddle_without_friction_on_a_beam_that_leans_sideways(half: float, stands: bool) -> None:
    turn = about((0.0, 1.0, 0.0), 0.3)
    beam = Placed(Brick("beam", Box((2.0 * half, 0.4, 0.1)), 9.0), Pose(rotate(turn, (0.0, 0.0, 0.05)), turn))
    assembly = Assembly([], 0.0, tables=[beam])
    verdict = assembly.add_all([put("saddle", SADDLE, rotate(turn, (0.0, 0.0, 0.1)), turn)])
    assert (verdict.stability is Stability.STABLE) is stands
    assert len(assembly.contacts("saddle")) == (3 if stands else 1)  # the bridge and both cheeks


@both_sides
@pytest.mark.parametrize("across", [False, True])
def test_a_table_on_a_slope_tips_over_the_outer_edge_of_its_legs(across: bool, share: float, stands: bool) -> None:
    top, legs = 0.6 * 0.4 * 0.02, 4.0 * 0.04 * 0.04 * 0.48
    height = (top * 0.49 + legs * 0.24) / (top + legs)
    half = 0.2 if across else 0.3
    table, turn = slope(atan(half / height * share), 5.0)
    turn = multiply(turn, about((0.0, 0.0, 1.0), 0.5 * pi)) if across else turn
    verdict = Assembly([table]).add_all([put("table", TABLE, (0.0, 0.0, 0.0), turn)])
    assert (verdict.stability is Stability.STABLE) is stands


@both_sides
def test_a_hollow_block_slides_on_a_slope_as_a_solid_one(share: float, stands: bool) -> None:
    table, turn = slope(atan(0.4 * share), 0.4)
    verdict = Assembly([table]).add_all([put("block", HOLLOW, (0.0, 0.0, 0.0), turn)])
    assert (verdict.stability is Stability.STABLE) is stands


@both_sides
def test_a_box_over_the_cell_of_a_hollow_block_stands_up_to_the_middle_of_the_wall_beyond(
    share: float, stands: bool
) -> None:
    # The walls at x = 0.185 +- 0.015 are the last that carry: a box whose centre passes x = 0.2 tips.
    box = Placed(Brick("box", Box((0.2, 0.1, 0.05)), 1.0), Pose((0.2 * share, 0.0, 0.225)))
    verdict = Assembly([ground(0.5)]).add_all([put("block", HOLLOW, (0.0, 0.0, 0.0)), box])
    assert (verdict.stability is Stability.STABLE) is stands


def test_a_box_narrower_than_the_cell_of_a_hollow_block_stands_on_the_ground_in_it() -> None:
    box = Placed(Brick("box", Box((0.1, 0.1, 0.3)), 1.0), Pose((0.0925, 0.0, 0.15)))
    assembly = Assembly([ground(0.5)])
    assert assembly.add_all([put("block", HOLLOW, (0.0, 0.0, 0.0)), box]).stability is Stability.STABLE
    assert {contact.lower for contact in assembly.contacts("box")} == {"ground"}


@both_sides
def test_a_counterweight_holds_the_long_arm_of_a_tee_on_a_knife_edge(share: float, stands: bool) -> None:
    """A lever on a post: weights W1 a1 = W2 a2 balance about the edges of the post."""
    tee = boxes(((0.5, 0.04, 0.02), (0.05, 0.0, 0.01)), ((0.04, 0.04, 0.1), (0.0, 0.0, -0.05)))
    # The stem stands on the ground; its own weight acts at x = 0.05 * 0.4 / (0.4 + 0.16) from its middle.
    own, centre = 1.0, 0.05 * 0.5 * 0.04 * 0.02 / (0.5 * 0.04 * 0.02 + 0.04 * 0.04 * 0.1)
    # Tips over x = 0.02 when own (centre - 0.02) = weight (0.02 + 0.15), with the weight at x = -0.15.
    weight = own * (centre - 0.02) / 0.17 / share
    load = Placed(Brick("load", Box((0.02, 0.02, 0.02)), weight), Pose((-0.15, 0.0, 0.13)))
    verdict = Assembly([ground(0.5)]).add_all([put("tee", tee, (0.0, 0.0, 0.1)), load])
    assert (verdict.stability is Stability.STABLE) is stands


# --- seams ------------------------------------------------------------------------------------------------------------


def test_an_edge_on_the_seam_of_two_parts_is_pressed_along_the_common_face_only() -> None:
    slab = boxes(((0.1, 0.1, 0.05), (-0.05, 0.0, 0.025)), ((0.1, 0.1, 0.05), (0.05, 0.0, 0.025)))
    ridge = prism([(0.0, 0.0), (0.03, 0.04), (-0.03, 0.04)], 0.06)
    roof = Placed(Brick("roof", ridge.shape, 1.0), Pose(add((0.0, 0.0, 0.05), ridge.centre_of_mass)))
    assembly = Assembly([ground(0.5)])
    assembly.add_all([put("slab", slab, (0.0, 0.0, 0.0)), roof])
    normals = {normal for contact in assembly.contacts("roof") for normal in contact.normals_W}
    assert [tuple(round(part, 9) for part in normal) for normal in normals] == [(0.0, 0.0, 1.0)]


def test_a_ridge_between_two_parts_admits_the_normals_of_both_slopes() -> None:
    left = prism([(0.0, 0.0), (0.0, 0.04), (-0.06, 0.0)], 0.1)
    right = prism([(0.0, 0.0), (0.06, 0.0), (0.0, 0.04)], 0.1)
    roof = compound([(left.shape, Pose(left.centre_of_mass)), (right.shape, Pose(right.centre_of_mass))])
    plank = Placed(Brick("plank", Box((0.2, 0.1, 0.01)), 1.0), Pose((0.0, 0.0, 0.045)))
    assembly = Assembly([ground(0.5)], 0.5)
    assembly.add_all([put("roof", roof, (0.0, 0.0, 0.0)), plank])
    assert assembly.contacts("plank")
    assert {tuple(round(part, 9) for part in n) for c in assembly.contacts("plank") for n in c.normals_W} == {
        (0.0, 0.0, 1.0)
    }


@pytest.mark.parametrize("offset", [0.0, 1e-4, -1e-4, 0.02])
def test_a_box_on_two_parts_slides_over_their_seam_as_over_one(offset: float) -> None:
    """No friction and a slight slope: it slides, wherever the seam of the slab under it is."""
    table, turn = slope(0.02, 2.0)
    slab = boxes(((0.1, 0.1, 0.05), (-0.05, 0.0, 0.025)), ((0.1, 0.1, 0.05), (0.05, 0.0, 0.025)))
    box = Placed(Brick("box", Box((0.04, 0.04, 0.04)), 1.0), Pose(rotate(turn, (0.02 + offset, 0.0, 0.07)), turn))
    assert not stands([put("slab", slab, (0.0, 0.0, 0.0), turn), box], 0.0, table)


# --- random assemblies ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seeds", [range(30), pytest.param(range(30, 2000), marks=pytest.mark.slow)])
def test_no_linear_program_on_the_contacts_of_the_parts_contradicts_a_random_assembly(seeds: range) -> None:
    verdicts = []
    for seed in seeds:
        scene = random_assembly(seed)
        assembly = Assembly([ground(scene.friction)], scene.friction)
        verdict = assembly.add_all(scene.bricks)
        verdicts.append(verdict.stability)
        if verdict.stability is Stability.STABLE:
            forces = assembly.forces()
            assert forces is not None
            assert check_forces(assembly.problem(), forces, Tolerances()).holds
        elif verdict.motion is not None:
            assert check_motion(assembly.problem(), verdict.motion, Tolerances()).holds
        answer = joined_verdict(scene.bricks, scene.friction)
        assert answer is None or answer != OPPOSITE.get(verdict.stability), seed
    assert verdicts.count(Stability.UNDECIDED) <= 0.01 * len(seeds)
    assert 0.1 * len(seeds) < verdicts.count(Stability.STABLE) < 0.9 * len(seeds)


def _moved(placed: Placed, turn: Quaternion, way: Vec3, factor: float) -> Placed:
    pose = Pose(add(way, scale(factor, rotate(turn, placed.pose.position_W))), multiply(turn, placed.pose.orientation))
    return Placed(Brick(placed.brick.id, scaled(placed.brick.shape, factor), factor**3 * placed.brick.mass), pose)


def test_verdicts_do_not_depend_on_place_direction_scale_or_order() -> None:
    rng = np.random.default_rng(1)
    for seed in range(12):
        scene = random_assembly(seed)
        expected = Assembly([ground(scene.friction)], scene.friction).add_all(scene.bricks).stability
        turn, factor = about((0.0, 0.0, 1.0), float(rng.uniform(0.0, 6.0))), float(rng.choice([0.1, 10.0]))
        moved = [_moved(placed, turn, (3.0, -2.0, 0.0), factor) for placed in scene.bricks]
        rng.shuffle(moved)
        assert Assembly([ground(scene.friction)], scene.friction).add_all(moved).stability is expected, seed


def test_the_order_of_the_parts_does_not_matter() -> None:
    for seed in range(12):
        scene = random_assembly(seed)
        bricks = []
        for placed in scene.bricks:
            shape = placed.brick.shape
            assert isinstance(shape, Compound)
            again = compound([(part.shape, part.place) for part in reversed(shape.parts)], (0.0, 0.0, 0.0))
            bricks.append(Placed(Brick(placed.brick.id, again.shape, placed.brick.mass), placed.pose))
        of_both = [Assembly([ground(scene.friction)], scene.friction).add_all(each) for each in (scene.bricks, bricks)]
        assert of_both[0].stability is of_both[1].stability, seed
        assert of_both[0].moving == of_both[1].moving


def test_a_box_cut_into_parts_stands_as_the_whole_box() -> None:
    rng = np.random.default_rng(2)
    for _ in range(12):
        size, share = tuple(rng.uniform(0.05, 0.2, 3).tolist()), float(rng.uniform(0.2, 0.8))
        a, b, c = size
        cut = boxes(
            ((share * a, b, c), (0.5 * (share - 1.0) * a, 0.0, 0.0)),
            (((1.0 - share) * a, b, c), (0.5 * share * a, 0.0, 0.0)),
        )
        x, yaw = float(rng.uniform(0.0, 0.2)), about((0.0, 0.0, 1.0), float(rng.uniform(0.0, 3.0)))
        whole = Placed(Brick("box", Box((a, b, c)), 1.0), Pose((x, 0.0, 0.1 + 0.5 * c), yaw))
        parts = put("box", cut, (x, 0.0, 0.1 + 0.5 * c), yaw)
        assert stands([SHELF, whole]) is stands([SHELF, parts])
