"""Bricks that slip and fall: closed forms at the beginning and on the way, and an integration written apart."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations, product
from math import acos, asin, atan, atan2, cos, degrees, dist, hypot, radians, sin, tan

import numpy as np
import pytest

from benchmarks.leaning_slips import placed, planes
from benchmarks.leaning_structures import LEANING, Structure, askew_v, mirrored, over_an_edge, structure, unlike_v
from benchmarks.slipping import Leaning, centre, gives_way, needed_friction, slides, slip, time_to_slide
from benchmarks.slips import leaning_pose, towards
from stability.dynamics.frictional_motion import FrictionalMotion, frictional_motion_of
from stability.dynamics.onset import as_it_begins
from stability.dynamics.toppling import toppling_of
from stability.geometry.box import Box
from stability.geometry.placed_shape import apart, corners_W
from stability.geometry.vectors import about, scale
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed
from stability.stabilizers.exact.candidates import release_until_stable
from stability.statics.assembly import Assembly
from tests.planks import GRAVITY, LENGTH, MASS, SIZE, THICKNESS

STEP = 1.0 / 960.0  # [s]
KAPLA = (LENGTH, THICKNESS)
UP: Vec3 = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("angle", [45.0, 60.0, 75.0])
def test_a_thin_ladder_without_friction_leaves_the_wall_at_two_thirds_of_its_height(angle: float) -> None:
    down = slip(Leaning(LENGTH, 0.0, radians(angle), floor_friction=0.0))
    assert sin(down.angle(down.ends)) == pytest.approx(2.0 / 3.0 * sin(radians(angle)), rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
@pytest.mark.parametrize("wall", [0.0, 0.05])
def test_energy_of_a_slipping_ladder_is_conserved_up_to_friction(share: float, wall: float) -> None:
    angle = radians(70.0)
    down = slip(Leaning(*KAPLA, angle, share * needed_friction(*KAPLA, angle) - wall / 4.0, wall))
    energies = [down.energy(down.ends * tenth / 10.0) for tenth in range(11)]
    assert energies == pytest.approx([energies[0]] * 11, rel=1e-10)


@pytest.mark.parametrize(("share", "moves"), [(0.9999, True), (1.0001, False)])
@pytest.mark.parametrize("angle", [50.0, 65.0, 80.0])
def test_a_ladder_slips_with_less_friction_than_statics_ask_for(share: float, moves: bool, angle: float) -> None:
    needed = needed_friction(*KAPLA, radians(angle))
    assert gives_way(Leaning(*KAPLA, radians(angle), share * needed)) is moves


def test_a_plank_slides_down_a_slope_by_gravity_minus_friction() -> None:
    way, speed = slides(radians(45.0), friction=0.5, time=0.4, gravity=10.0)
    assert speed == pytest.approx(0.4 * 10.0 * 0.5**0.5 * 0.5)
    assert way == pytest.approx(0.2 * speed)
    assert time_to_slide(way, radians(45.0), friction=0.5, gravity=10.0) == pytest.approx(0.4)


def begun(
    bricks: Sequence[Placed], planes: Sequence[Plane], friction: float, others: Sequence[Placed] = ()
) -> FrictionalMotion | None:
    """Return the motion of bricks that cannot stand; `others` are fixed."""
    assembly = Assembly(tuple(planes), friction, GRAVITY)
    falling = release_until_stable(assembly, assembly.add_all(bricks)).released.keys()
    whole = Assembly(tuple(planes), friction, GRAVITY)
    whole.add_all(bricks)
    return frictional_motion_of(whole.problem(), falling, GRAVITY, others, planes, whole.friction)


def leaning(
    kind: str, of: Leaning, yaw: float, others: tuple[Placed, ...] = ()
) -> tuple[FrictionalMotion, list[Placed]]:
    """Planks that lean like this against a wall, or against each other."""
    planes = [Plane(GROUND, (0.0, 0.0, 0.0), UP, of.floor_friction)]
    if kind == "ladder":
        planes.append(Plane("wall", (0.0, 0.0, 0.0), scale(-1.0, towards(yaw)), of.wall_friction))
    sides = (-1.0, 1.0) if kind == "V" else (-1.0,)
    size = (of.length, SIZE[1], of.thickness)
    bricks = [Placed(Brick(f"{side:+}", Box(size), MASS), leaning_pose(size, of.angle, side, yaw)) for side in sides]
    found = begun(bricks, planes, of.floor_friction, others)
    assert found is not None
    return found, bricks


def angle_of(found: FrictionalMotion, name: str) -> float:
    """Between a plank and the floor [rad]."""
    x, y, z, w = found.states()[name].pose.orientation
    along = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w))
    return abs(atan2(along[2], hypot(along[0], along[1])))


def is_quick(angle: float, share: float, yaw: float) -> bool:
    """Two ends of angles and shares in one direction, and their middle in the other."""
    return (angle, share) in ((50.0, 0.99), (80.0, 0.5)) if yaw else (angle == 65.0 and share == 0.9)


SLIPPING = [
    pytest.param(*one, marks=[] if is_quick(*one) else [pytest.mark.slow])
    for one in product((50.0, 65.0, 80.0), (0.5, 0.9, 0.99), (0.0, 37.0))
]


@pytest.mark.parametrize("kind", ["ladder", "V"])
@pytest.mark.parametrize(("angle", "share", "yaw"), SLIPPING)
def test_planks_that_lean_slip_as_newton_says(kind: str, angle: float, share: float, yaw: float) -> None:
    start = radians(angle)
    of = Leaning(*KAPLA, start, share * needed_friction(*KAPLA, start))
    (found, _), truth = leaning(kind, of, radians(yaw)), slip(of)
    steps = 0
    while (steps + 1) * STEP < truth.ends and found.advance(STEP):
        steps += 1
        turned = start - truth.angle(steps * STEP)
        for name in found.states():
            assert start - angle_of(found, name) == pytest.approx(turned, rel=5e-4, abs=1e-7)
    assert (steps + 1) * STEP == pytest.approx(truth.ends, abs=STEP)  # when it leaves the wall


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_wall_with_friction_holds_a_ladder_back(friction: float) -> None:
    start = radians(60.0)
    of = Leaning(*KAPLA, start, 0.5 * needed_friction(*KAPLA, start), friction)
    (found, _), truth = leaning("ladder", of, 0.4), slip(of)
    assert all(found.advance(STEP) for _ in range(40))
    assert start - angle_of(found, "-1.0") == pytest.approx(start - truth.angle(40 * STEP), rel=2e-4)
    smooth = slip(Leaning(*KAPLA, start, of.floor_friction))
    assert angle_of(found, "-1.0") > smooth.angle(40 * STEP)


def test_half_the_step_leaves_a_quarter_of_the_error() -> None:
    of = Leaning(*KAPLA, radians(60.0), 0.9 * needed_friction(*KAPLA, radians(60.0)))
    truth = centre(of, slip(of).angle(0.15))[1]

    def error(step: float) -> float:
        found, _ = leaning("ladder", of, 0.0)
        assert all(found.advance(step) for _ in range(round(0.15 / step)))
        return abs(found.states()["-1.0"].pose.position_W[2] - truth)

    assert error(1.0 / 960.0) / error(1.0 / 1920.0) == pytest.approx(4.0, abs=0.4)


@pytest.mark.parametrize("slope", [10.0, 35.0])
def test_a_brick_on_a_slope_slides_without_lifting_off(slope: float) -> None:
    angle, share = radians(slope), 0.6
    floor = Plane(GROUND, (0.0, 0.0, 0.0), (sin(angle), 0.0, cos(angle)), share * tan(angle))
    pose = Pose((0.5 * THICKNESS * sin(angle), 0.0, 0.5 * THICKNESS * cos(angle)), about((0.0, 1.0, 0.0), angle))
    found = begun([Placed(Brick("plank", Box(SIZE), MASS), pose)], [floor], 0.5)
    assert found is not None
    assert all(found.advance(STEP) for _ in range(96))
    way, speed = slides(angle, share * tan(angle), 0.1, GRAVITY)
    state = found.states()["plank"]
    x, _, z = (after - before for after, before in zip(state.pose.position_W, pose.position_W, strict=True))
    assert (x, z) == pytest.approx((way * cos(angle), -way * sin(angle)), rel=1e-6)
    assert hypot(*state.velocity_W) == pytest.approx(speed, rel=1e-6)


def accelerations_of_an_unlike_v(found: Structure, friction: float) -> list[float]:
    """Of both feet, away from each other [m/s2]: Newton and Euler of two planks that slide at three places, at rest."""
    a, b = found.bars
    out = np.array([b.centre[0] - a.centre[0], b.centre[1] - a.centre[1], 0.0])
    ex, ez = out / np.linalg.norm(out), np.array([0.0, 0.0, 1.0])
    flat_a, flat_b = (
        np.array([[(corner - bar.centre) @ ex, (corner - bar.centre) @ ez] for corner in bar.corners()])
        for bar in (a, b)
    )
    inertia = [bar.mass * (bar.size[0] ** 2 + bar.size[2] ** 2) / 12.0 for bar in (a, b)]
    foot_a, foot_b = flat_a[flat_a[:, 1].argmin()], flat_b[flat_b[:, 1].argmin()]
    face = min((1.0, -1.0), key=lambda sign: sign * float(b.turn[:, 2] @ ex)) * b.turn[:, 2]
    normal = np.array([face @ ex, face @ ez])  # out of b's lower face, towards a
    offset = np.array([(a.centre - b.centre) @ ex, (a.centre - b.centre) @ ez])
    top_a = flat_a[((flat_a + offset) @ normal).argmin()]
    on_b = top_a + offset
    down = np.array([normal[1], -normal[0]])
    down = down if down[1] < 0.0 else -down
    best: list[float] = []
    for along in (down, -down):  # a slides down the face of b, or up
        # Of x, z and the turn from x to z of a, then of b; then the forces of a's foot, of b's foot, at the top.
        rows, known = np.zeros((9, 9)), np.zeros(9)
        force_a = [(foot_a, np.array([friction, 1.0]), 6), (top_a, normal - friction * along, 8)]
        force_b = [(foot_b, np.array([-friction, 1.0]), 7), (on_b, -(normal - friction * along), 8)]
        for first, bar, moment, forces in ((0, a, inertia[0], force_a), (3, b, inertia[1], force_b)):
            rows[first, first] = rows[first + 1, first + 1] = bar.mass
            rows[first + 2, first + 2] = moment
            known[first + 1] = -bar.mass * GRAVITY
            for arm, force, column in forces:
                rows[first : first + 2, column] -= force
                rows[first + 2, column] -= arm[0] * force[1] - arm[1] * force[0]
        rows[6, 1], rows[6, 2] = 1.0, foot_a[0]
        rows[7, 4], rows[7, 5] = 1.0, foot_b[0]
        for first, arm, sign in ((0, top_a, 1.0), (3, on_b, -1.0)):
            rows[8, first : first + 2] = sign * normal
            rows[8, first + 2] = sign * (normal[1] * arm[0] - normal[0] * arm[1])
        x = np.linalg.solve(rows, known)
        slides_by = np.array(
            [x[0] - x[2] * top_a[1] - x[3] + x[5] * on_b[1], x[1] + x[2] * top_a[0] - x[4] - x[5] * on_b[0]]
        )
        if x[6:].min() > 0.0 and slides_by @ along > 0.0:
            best = [-(x[0] - x[2] * foot_a[1]), x[3] - x[5] * foot_b[1]]
    return best


@pytest.mark.parametrize("number", [0, 1, 2, 3, 4, 5])
def test_an_unlike_v_begins_to_part_as_newton_and_euler_say_of_its_two_planks(number: int) -> None:
    found, friction = structure(unlike_v, number), 0.12
    truth = accelerations_of_an_unlike_v(found, friction)
    motion = begun(placed(found), planes(found, friction), friction)
    assert motion is not None
    velocities = motion.next_velocities(STEP)
    assert velocities is not None
    out = np.array(found.bars[1].centre) - np.array(found.bars[0].centre)
    out[2] = 0.0
    out /= np.linalg.norm(out)
    feet = []
    for i, (bar, sign) in enumerate(zip(found.bars, (-1.0, 1.0), strict=True)):
        arm = bar.corners()[bar.corners()[:, 2].argmin()] - bar.centre
        velocity, spin = velocities[6 * i : 6 * i + 3], velocities[6 * i + 3 : 6 * i + 6]
        feet.append(sign * float((velocity + np.cross(spin, arm)) @ out) / (0.5 * STEP))
    assert truth
    assert min(truth) > 0.0
    assert feet == pytest.approx(truth, rel=1e-5)


def test_a_slip_is_followed_until_a_foot_hits_a_standing_brick() -> None:
    def last(gap: float) -> float:
        foot = LENGTH * cos(radians(60.0))
        block = Placed(Brick("block", Box((0.02, 0.02, 0.02)), MASS), Pose((-foot - 0.01 - gap, 0.0, 0.01)))
        found, _ = leaning("ladder", Leaning(*KAPLA, radians(60.0), 0.1), 0.0, (block,))
        while found.advance(STEP):
            pass
        return LENGTH * (cos(angle_of(found, "-1.0")) - cos(radians(60.0)))

    #   The upper edge of its end comes first, the thickness times the sine of the angle farther out.
    assert last(0.01) == pytest.approx(0.01 - THICKNESS * sin(radians(60.0)), abs=3e-4)
    assert last(0.02) == pytest.approx(0.02 - THICKNESS * sin(radians(53.0)), abs=5e-4)


def stepped(at: float, size: Vec3 = SIZE) -> list[Placed]:
    """A plank that lies on another and hangs over its end."""
    names = (f"{at:g} low", f"{at:g} high")
    middles = ((at, 0.0, 0.5 * THICKNESS), (at + 0.6 * LENGTH, 0.0, 1.5 * THICKNESS))
    return [Placed(Brick(n, Box(size), MASS), Pose(m)) for n, m in zip(names, middles, strict=True)]


def test_two_stacks_that_fall_at_once_each_turn_as_a_pendulum_does() -> None:
    floor = Plane(GROUND, (0.0, 0.0, 0.0), UP, 0.5)
    short: Vec3 = (0.7 * LENGTH, SIZE[1], THICKNESS)
    stacks = [stepped(0.0), [replace_size(one, short) for one in stepped(1.0)]]
    both = begun([*stacks[0], *stacks[1]], [floor], 0.5)
    assert both is not None
    assert all(both.advance(STEP) for _ in range(35))
    for stack in stacks:
        assembly = Assembly((floor,), 0.5, GRAVITY)
        verdict = as_it_begins(assembly, assembly.add_all(stack))
        assert verdict.motion is not None
        alone = toppling_of(assembly.problem(), verdict.motion, GRAVITY, stack[:1], (floor,))
        assert alone is not None
        assert all(alone.advance(STEP) for _ in range(35))
        (name, truth), *_ = alone.states().items()
        state = both.states()[name]
        assert degrees(alone.angle) > 3.0
        assert state.pose.position_W == pytest.approx(truth.pose.position_W, abs=2e-4 * LENGTH * alone.angle)
        assert state.angular_velocity_W == pytest.approx(truth.angular_velocity_W, abs=1e-3 * alone.speed)


def replace_size(one: Placed, size: Vec3) -> Placed:
    x, y, z = one.pose.position_W
    return Placed(Brick(one.brick.id, Box(size), MASS), Pose((1.0 + (x - 1.0) * size[0] / LENGTH, y, z)))


def test_frictional_motion_is_unknown_if_it_would_move_a_standing_brick() -> None:
    floor = Plane(GROUND, (0.0, 0.0, 0.0), UP, 0.5)
    low, high = stepped(0.0)
    on_top = Placed(Brick("rider", Box(SIZE), MASS), Pose((0.6 * LENGTH, 0.0, 2.5 * THICKNESS)))
    assembly = Assembly((floor,), 0.5, GRAVITY)
    verdict = as_it_begins(assembly, assembly.add_all([low, high, on_top]))
    assert verdict.motion is not None
    assert set(verdict.motion.velocity) == {"0 high", "rider"}
    for falling, known in (({"0 high", "rider"}, True), ({"0 high"}, False)):
        found = frictional_motion_of(assembly.problem(), falling, GRAVITY, (), (floor,), assembly.friction)
        assert found is not None
        assert found.advance(STEP) is known


def test_a_v_without_friction_keeps_its_energy() -> None:
    found, bricks = leaning("V", Leaning(*KAPLA, radians(60.0), 0.0), 0.3)
    assert all(found.advance(STEP) for _ in range(70))
    lost = gained = 0.0
    for one in bricks:
        state = found.states()[one.brick.id]
        lost += MASS * GRAVITY * (one.pose.position_W[2] - state.pose.position_W[2])
        spin = hypot(*state.angular_velocity_W)  # about the width
        gained += 0.5 * MASS * (hypot(*state.velocity_W) ** 2 + (LENGTH**2 + THICKNESS**2) / 12.0 * spin**2)
    assert gained == pytest.approx(lost, rel=1e-3)


HEIGHT = 0.1  # of a block that rocks [m]


def rocking(width: float, tilt: float, step: float) -> FrictionalMotion:
    """A block that is let go with one edge on a rough floor, tilted by so much [deg]."""
    floor, start = Plane(GROUND, (0.0, 0.0, 0.0), UP, 1.0), radians(tilt)
    middle = (0.0, 0.0, 0.5 * (HEIGHT * cos(start) + width * sin(start)))
    block = Placed(Brick("block", Box((width, 0.03, HEIGHT)), MASS), Pose(middle, about((0.0, 1.0, 0.0), start)))
    assembly = Assembly((floor,), 1.0, GRAVITY)
    assembly.add_all([block])
    found = frictional_motion_of(assembly.problem(), {"block"}, GRAVITY, (), (floor,), assembly.friction)
    assert found is not None
    assert found.advance(step)
    return found


def peaks(found: FrictionalMotion, count: int, step: float) -> list[float]:
    """How far it rises each time that it has landed [deg]."""
    risen: list[float] = []
    tilts = [0.0, degrees(2.0 * asin(found.states()["block"].pose.orientation[1]))]
    lands = False
    while len(risen) < count:
        assert found.advance(step)
        tilts = [tilts[-1], degrees(2.0 * asin(found.states()["block"].pose.orientation[1]))]
        lands = lands or tilts[0] * tilts[1] < 0.0
        if lands and abs(tilts[1]) < abs(tilts[0]) and tilts[0] * tilts[1] > 0.0:
            risen.append(abs(tilts[0]))
            lands = False
    return risen


def housner(width: float, tilt: float, count: int) -> list[float]:
    """The same, each landing leaving 1 - 1.5 sin^2 of the angular velocity, as about the other edge (Housner, 1963)."""
    slender = atan(width / HEIGHT)
    kept = 1.0 - 1.5 * sin(slender) ** 2
    energy, risen = cos(slender - radians(tilt)) - cos(slender), []
    for _ in range(count):
        energy *= kept**2
        risen.append(degrees(slender - acos(energy + cos(slender))))
    return risen


ROCKING = [(0.03, 4.0, STEP), (0.05, 4.0, STEP)]  # width [m], tilt [deg] and step [s]
FINELY = [
    (width, tilt, 0.5 * STEP) for width in (0.01, 0.02, 0.03, 0.05) for tilt in (1.0, 2.0, 8.0) if tilt < 500 * width
]


@pytest.mark.parametrize(
    ("width", "tilt", "step"), [*ROCKING, *(pytest.param(*each, marks=pytest.mark.slow) for each in FINELY)]
)
def test_a_block_that_rocks_rises_beyond_each_landing_as_housner_says(width: float, tilt: float, step: float) -> None:
    found = rocking(width, tilt, step)
    assert peaks(found, 3, step) == pytest.approx(housner(width, tilt, 3), rel=0.01)


@pytest.mark.slow
def test_how_high_a_block_rocks_does_not_hang_on_when_in_a_step_it_lands() -> None:
    """A landing that was not found in parts was spread over two steps, and took an eighth of the height away."""
    for step in (STEP * share for share in (1.0, 0.93, 0.81, 0.67, 0.5)):
        assert peaks(rocking(0.03, 4.0, step), 2, step) == pytest.approx(housner(0.03, 4.0, 2), rel=0.01)


def test_an_impact_may_move_standing_bricks_by_micrometres() -> None:
    of, friction, step = structure(over_an_edge, 8), 0.65108, 0.25 * STEP
    found = begun(placed(of), planes(of, friction), friction)
    assert found is not None
    assert found.states().keys() == {"plank"}
    assert all(found.advance(step) for _ in range(110))  # its other long edge meets the block after 22 ms


def time_to(way: float, of: Structure, friction: float, step: float) -> float:
    """When a corner of any brick has got so far [s], if all of that is known."""
    found, steps = begun(placed(of), planes(of, friction), friction), 0
    assert found is not None
    starts = {one.brick.id: corners_W(one.brick.shape, one.pose) for one in placed(of)}
    shapes = {one.brick.id: one.brick.shape for one in placed(of)}
    far = before = 0.0
    while far < way:
        assert found.advance(step)
        steps, before = steps + 1, far
        corners = {name: corners_W(shapes[name], state.pose) for name, state in found.states().items()}
        far = max(dist(a, b) for n in corners for a, b in zip(starts[n], corners[n], strict=True))
    return step * (steps - (far - way) / (far - before))


def test_a_slip_on_which_corners_land_does_not_depend_on_the_step() -> None:
    of, friction = structure(askew_v, 3), 0.29294
    assert time_to(0.005, of, friction, STEP) == pytest.approx(time_to(0.005, of, friction, 0.5 * STEP), rel=0.01)


@pytest.mark.parametrize("step", [STEP, pytest.param(0.5 * STEP, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "micrometres", [0.0, 1.0, -10.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (-1.0, 10.0))]
)
def test_a_landing_on_a_block_that_it_makes_rock_goes_on_as_boxes_stepped_apart_do(
    step: float, micrometres: float
) -> None:
    #  Its second long edge lands on the block, which rocks for two milliseconds; its foot lifts off and lands again.
    of, friction = structure(over_an_edge, 8), 0.651083
    plank, block = of.bars
    of = replace(of, bars=[plank.shifted(*(1e-6 * micrometres * block.turn[:, 1])), block])
    # `benchmarks/rigid_steps.py` says 83.9, 83.5 and 83.3 ms with steps of 50, 25 and 12.5 microseconds.
    assert time_to(0.005, of, friction, step) == pytest.approx(83.1e-3, rel=0.02)


@pytest.mark.parametrize("family", LEANING)
def test_random_structures_that_lean_touch_and_are_not_inside_each_other(
    family: Callable[[np.random.Generator], Structure | None],
) -> None:
    for number in range(12):
        bricks = placed(structure(family, number))
        gaps = [
            apart(one.brick.shape, one.pose, other.brick.shape, other.pose).gap
            for one, other in combinations(bricks, 2)
        ]
        assert min(gaps, default=0.0) == pytest.approx(0.0, abs=1e-9)


def test_a_structure_seen_in_a_mirror_rises_the_other_way() -> None:
    bar = structure(unlike_v, 0).bars[0]
    assert mirrored(bar).turn[0, 0] == pytest.approx(-bar.turn[0, 0])
