"""Planks that slip: from the ladder's closed forms and an integration that was written apart, for walls and for Vs."""

from math import cos, radians, sin

import pytest

from benchmarks.slipping import Leaning, gives_way, needed_friction, slides, slip, time_to_slide
from benchmarks.slips import leaning_pose, towards
from stability.geometry.vectors import scale
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.motion.onset import as_it_begins
from stability.motion.slipping import Slip, slip_of
from stability.shapes.box import Box
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed
from tests.planks import GRAVITY, LENGTH, MASS, SIZE, THICKNESS

STEP = 1.0 / 960.0  # [s]
STEPPED = 5e-9  # [rad] what steps of this length may cost in half a second
KAPLA = (LENGTH, THICKNESS)


@pytest.mark.parametrize("angle", [45.0, 60.0, 75.0])
def test_a_thin_ladder_without_friction_leaves_the_wall_at_two_thirds_of_its_height(angle: float) -> None:
    down = slip(Leaning(LENGTH, 0.0, radians(angle), floor_friction=0.0))
    assert sin(down.angle(down.ends)) == pytest.approx(2.0 / 3.0 * sin(radians(angle)), rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
@pytest.mark.parametrize("wall", [0.0, 0.05])
def test_what_a_ladder_loses_in_height_goes_into_motion_and_friction(share: float, wall: float) -> None:
    angle = radians(70.0)
    down = slip(Leaning(*KAPLA, angle, share * needed_friction(*KAPLA, angle) - wall / 4.0, wall))
    energies = [down.energy(down.ends * tenth / 10.0) for tenth in range(11)]
    assert energies == pytest.approx([energies[0]] * 11, rel=1e-10)


@pytest.mark.parametrize(("share", "moves"), [(0.9999, True), (1.0001, False)])
@pytest.mark.parametrize("angle", [50.0, 65.0, 80.0])
def test_a_ladder_slips_with_less_friction_than_statics_ask_for(share: float, moves: bool, angle: float) -> None:
    needed = needed_friction(*KAPLA, radians(angle))
    assert gives_way(Leaning(*KAPLA, radians(angle), share * needed)) is moves


def test_a_plank_slides_down_a_slope_by_what_friction_leaves_of_gravity() -> None:
    way, speed = slides(radians(45.0), friction=0.5, time=0.4, gravity=10.0)
    assert speed == pytest.approx(0.4 * 10.0 * 0.5**0.5 * 0.5)
    assert way == pytest.approx(0.2 * speed)
    assert time_to_slide(way, radians(45.0), friction=0.5, gravity=10.0) == pytest.approx(0.4)


def begun(kind: str, leaning: Leaning, yaw: float, others: tuple[Placed, ...] = ()) -> Slip | None:
    """What is said of planks that lean like this against a wall, or against each other."""
    planes = [Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), leaning.floor_friction)]
    if kind == "ladder":
        planes.append(Plane("wall", (0.0, 0.0, 0.0), scale(-1.0, towards(yaw)), leaning.wall_friction))
    sides = (-1.0, 1.0) if kind == "V" else (-1.0,)
    size = (leaning.length, SIZE[1], leaning.thickness)
    bricks = [
        Placed(Brick(f"{side:+}", Box(size), MASS), leaning_pose(size, leaning.angle, side, yaw)) for side in sides
    ]
    assembly = Assembly(tuple(planes), leaning.floor_friction, leaning.gravity)
    verdict = as_it_begins(assembly, assembly.add_all(bricks))
    assert verdict.motion is not None
    return slip_of(assembly.problem(verdict.moving), verdict.motion, leaning.gravity, others, planes)


@pytest.mark.parametrize("kind", ["ladder", "V"])
@pytest.mark.parametrize("angle", [50.0, 65.0, 80.0])
@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
@pytest.mark.parametrize("yaw", [0.0, 37.0])
def test_planks_that_lean_slip_as_newton_says(kind: str, angle: float, share: float, yaw: float) -> None:
    start = radians(angle)
    leaning = Leaning(*KAPLA, start, share * needed_friction(*KAPLA, start))
    found, truth = begun(kind, leaning, radians(yaw)), slip(leaning)
    assert found is not None
    steps = 0
    while found.goes_on(STEP):
        steps += 1
        assert start - found.turn == pytest.approx(truth.angle(steps * STEP), abs=STEPPED)
    assert steps * STEP == pytest.approx(truth.ends, abs=STEP)  # when it leaves the wall


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_wall_with_friction_holds_a_ladder_back(friction: float) -> None:
    start = radians(60.0)
    leaning = Leaning(*KAPLA, start, 0.5 * needed_friction(*KAPLA, start), friction)
    found, truth = begun("ladder", leaning, 0.4), slip(leaning)
    assert found is not None
    for step in range(1, 40):
        assert found.goes_on(STEP)
        assert start - found.turn == pytest.approx(truth.angle(step * STEP), abs=STEPPED)
    smooth = slip(Leaning(*KAPLA, start, leaning.floor_friction))
    assert found.turn < start - smooth.angle(39 * STEP)


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_both_ends_go_on_touching(yaw: float) -> None:
    leaning = Leaning(*KAPLA, radians(60.0), 0.1)
    found = begun("V", leaning, yaw)
    assert found is not None
    while found.goes_on(STEP):
        pass
    for side, state in zip((1.0, -1.0), (found.states()["+1.0"], found.states()["-1.0"]), strict=True):
        expected = leaning_pose((LENGTH, SIZE[1], THICKNESS), radians(60.0) - found.turn, side, yaw)
        assert state.pose.position_W == pytest.approx(expected.position_W, abs=1e-12)
        turn = [abs(a) for a in state.pose.orientation]
        assert turn == pytest.approx([abs(a) for a in expected.orientation], abs=1e-12)


def test_a_slip_is_followed_only_as_far_as_there_is_room() -> None:
    def last(gap: float) -> float:
        block = Placed(Brick("block", Box((0.02, 0.02, 0.02)), MASS), Pose((-0.0588 - 0.01 - gap, 0.0, 0.01)))
        found = begun("ladder", Leaning(*KAPLA, radians(60.0), 0.1), 0.0, (block,))
        assert found is not None
        while found.goes_on(STEP):
            pass
        return LENGTH * (cos(radians(60.0) - found.turn) - cos(radians(60.0)))

    assert 0.002 < last(0.01) < 0.01
    assert last(0.02) > last(0.01)


def test_what_is_no_mirror_image_is_left_to_an_engine() -> None:
    heavy: Vec3 = (LENGTH, 2.0 * SIZE[1], THICKNESS)
    friction = 0.9 * needed_friction(*KAPLA, radians(60.0))
    floor = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)
    bricks = [
        Placed(Brick("left", Box(SIZE), MASS), leaning_pose(SIZE, radians(60.0), -1.0, 0.0)),
        Placed(Brick("right", Box(heavy), 2.0 * MASS), leaning_pose(heavy, radians(60.0), 1.0, 0.0)),
    ]
    assembly = Assembly((floor,), friction, GRAVITY)
    verdict = as_it_begins(assembly, assembly.add_all(bricks))
    assert verdict.motion is not None
    assert slip_of(assembly.problem(verdict.moving), verdict.motion, GRAVITY, (), (floor,)) is None
