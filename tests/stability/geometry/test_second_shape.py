"""A foreign shape works in all code that uses only the protocol of shapes."""

from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest

from stability.analysis.margins import least_friction
from stability.contact_law import Coulomb
from stability.dynamics.rigid_body import pushed
from stability.dynamics.rigid_group import common_motion, grouped, surfaces
from stability.dynamics.toppling import FallingPart, falling_part, holds_together, reach
from stability.engines.lazy_world import EngineFactory, RestingWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.geometry.placed_shape import corners_W, inertia_times
from stability.geometry.vectors import add, cross, dot, multiply, rotate, scale, subtract
from stability.model import GROUND, IDENTITY, BodyState, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.problem import Contact, Motion, Placed, Problem, Stability, Wrench
from stability.statics.assembly import Assembly
from stability.statics.equilibrium import balance
from stackdsl.simulation.systems import RIGID
from tests.stability.geometry.polyhedra import LOWER_HALF, PLANK, SAME_PLANK, SIZE, TETRAHEDRON, UPPER_HALF, polyhedron

LENGTH, WIDTH, THICKNESS = SIZE
MASS, GRAVITY = 0.012, 9.81
AWRY: Quaternion = (0.1, 0.5, -0.3, sqrt(1.0 - 0.01 - 0.25 - 0.09))
SETTINGS = PyBulletSettings(time_step=1.0 / 240.0, iterations=10, contact_erp=0.2, breaking_threshold=0.02)
UP: Vec3 = (0.0, 0.0, 1.0)
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), UP, 0.5)
OWN_WEIGHT = Wrench((0.0, 0.0, -MASS * GRAVITY))
# From the middle of the plank to the centre of mass of each half.
TO_LOWER: Vec3 = (-LENGTH / 6.0, 0.0, -THICKNESS / 6.0)
TO_UPPER: Vec3 = (LENGTH / 6.0, 0.0, THICKNESS / 6.0)


def test_an_impulse_gives_a_tilted_brick_its_angular_momentum() -> None:
    brick, state = Brick("t", TETRAHEDRON, MASS), BodyState(Pose((1.0, 2.0, 3.0), AWRY))
    impulse, at = (0.01, -0.02, 0.03), (1.01, 2.02, 2.99)
    after = pushed(state, brick, impulse, at)
    arm = subtract(at, state.pose.position_W)
    assert inertia_times(brick, AWRY, after.angular_velocity_W) == pytest.approx(cross(arm, impulse), abs=1e-15)
    assert after.velocity_W == pytest.approx(scale(1.0 / MASS, impulse))


def test_two_halves_of_a_plank_that_move_as_one_are_the_plank() -> None:
    whole = Pose((0.3, 0.2, 0.1), AWRY)
    halves = [
        (Brick(name, shape, 0.5 * MASS), Pose(add(whole.position_W, rotate(AWRY, to)), AWRY))
        for name, shape, to in (("lower", LOWER_HALF, TO_LOWER), ("upper", UPPER_HALF, TO_UPPER))
    ]
    group = grouped(halves)
    assert group.pose.position_W == pytest.approx(whole.position_W)
    assert sorted(group.moments) == pytest.approx(sorted(PLANK.moments(MASS)), rel=1e-9)
    spin = (1.0, -2.0, 3.0)
    states = {
        brick.id: BodyState(pose, cross(spin, subtract(pose.position_W, whole.position_W)), spin)
        for brick, pose in halves
    }
    velocity, turning = common_motion(group, states)
    assert velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert turning == pytest.approx(spin)


def test_a_group_knows_which_of_two_halves_a_point_belongs_to() -> None:
    halves = [(Brick("lower", LOWER_HALF, 1.0), Pose(TO_LOWER)), (Brick("upper", UPPER_HALF, 1.0), Pose(TO_UPPER))]
    group = grouped(halves)
    found, (x, y, z, w) = surfaces(group), group.pose.orientation
    for point, half in (((-0.05, 0.0, -0.004), "lower"), ((0.05, 0.0, 0.004), "upper"), ((0.0, 0.0, -0.004), "lower")):
        assert found.brick_at(rotate((-x, -y, -z, w), subtract(point, group.pose.position_W))) == half


def test_a_wedge_loads_the_supports_of_its_ends_by_its_centre_of_mass() -> None:
    #   Held at its ends, it gives the thick one two thirds of its weight.
    wedge = Placed(Brick("wedge", LOWER_HALF, MASS), Pose((0.0, 0.0, 0.0)))
    ends = {"thick": -LENGTH / 3.0, "thin": 2.0 * LENGTH / 3.0}
    contacts = [
        Contact(name, "wedge", ((x, -0.01, -0.0027), (x, 0.01, -0.0027)), (UP,), Coulomb(0.5))
        for name, x in ends.items()
    ]
    forces = balance(Problem({"wedge": wedge}, contacts, {"wedge": OWN_WEIGHT})).forces
    assert forces is not None
    thick, thin = (sum(force[2] for point in each for force in point) for each in forces.of_contacts)
    assert (thick, thin) == pytest.approx((2.0 / 3.0 * MASS * GRAVITY, MASS * GRAVITY / 3.0), rel=1e-6)


def test_margins_of_a_wedge_on_a_slope_are_those_of_the_slope() -> None:
    angle = radians(20.0)
    slope = Contact(
        GROUND, "wedge", foot(LOWER_HALF), ((sin(angle), 0.0, cos(angle)),), Coulomb(0.9)
    )  # it lies on the slope as on the level
    problem = Problem({"wedge": Placed(Brick("wedge", LOWER_HALF, MASS), AT_HOME)}, [slope], {"wedge": OWN_WEIGHT})
    assert 0.9 * least_friction(problem).factor == pytest.approx(sin(angle) / cos(angle), rel=1e-3)


AT_HOME = Pose((0.0, 0.0, 0.0))


def foot(shape: ConvexShape) -> tuple[Vec3, ...]:
    down = next(face for face in shape.faces if face.normal == pytest.approx((0.0, 0.0, -1.0)))
    return tuple(shape.corners[number] for number in down.corners[::-1])


def tipping(shape: ConvexShape, coefficient: float) -> FallingPart:
    """A solid with its foot on the ground that begins to tip about the edge at its -x side, pushed over it."""
    corners = corners_W(shape, AT_HOME)
    west = min(x for x, _, _ in corners)
    edge = tuple(sorted(corner for corner in corners if corner[0] < west + 1e-9 and corner[2] < 0.0))
    ground = Contact(GROUND, "solid", edge, (UP,), Coulomb(coefficient))
    spin = (0.0, -1.0, 0.0)
    motion = Motion({"solid": (cross(spin, scale(-1.0, edge[0])), spin)})
    problem = Problem({"solid": Placed(Brick("solid", shape, MASS), AT_HOME)}, [ground], {"solid": OWN_WEIGHT})
    part = falling_part(problem, motion, GRAVITY)
    assert part is not None
    return part


def test_a_wedge_turns_about_an_edge_with_the_inertia_that_steiner_gives_it() -> None:
    part = tipping(LOWER_HALF, 0.5)
    #   About its thick end, which is a third of its length and of its thickness from its centre: m (L^2 + t^2) / 6.
    assert part.pendulum.inertia == pytest.approx(MASS * (LENGTH**2 + THICKNESS**2) / 6.0)
    assert abs(part.pendulum.torque) == pytest.approx(MASS * GRAVITY * LENGTH / 3.0)
    assert reach(part) == pytest.approx(LENGTH)


@pytest.mark.parametrize("coefficient", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("angle", [0.0, 0.05, 0.3, 0.8])
def test_a_box_given_by_corners_balances_on_its_edge_like_a_box(coefficient: float, angle: float) -> None:
    box, same = (holds_together(tipping(shape, coefficient), angle) for shape in (PLANK, SAME_PLANK))
    assert box is same


PRISM = [(0.0, 0.0), (-0.02, 0.1), (0.02, 0.1)]
ON_EDGE = polyhedron((x, y, z) for x, z in PRISM for y in (-0.01, 0.01))
BEARINGS = [0.4 + quarter * pi / 2.0 for quarter in range(4)]  # so that no edge lies along the axis
ON_APEX = polyhedron([(0.0, 0.0, 0.0), *((0.02 * cos(bearing), 0.02 * sin(bearing), 0.1) for bearing in BEARINGS)])


@pytest.mark.parametrize(("shape", "touching"), [(ON_EDGE, (-0.005, 0.005)), (ON_APEX, (0.0,))], ids=["edge", "apex"])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_what_falls_over_its_own_edge_or_corner_slips_when_the_ground_under_it_no_longer_holds_it(
    shape: ConvexShape, touching: tuple[float, ...], share: float
) -> None:
    #   A pendulum on its head: r from its foot to its centre, at rest at 0.3 from upright, now at 0.6.
    start, now = 0.3, 0.6
    r = shape.reach((0.0, 0.0, -1.0))
    inertia = inertia_times(Brick("", shape, MASS), IDENTITY, (0.0, 1.0, 0.0))[1] + MASS * r * r
    faster = MASS * GRAVITY * r * sin(now) / inertia
    square = 2.0 * MASS * GRAVITY * r * (cos(start) - cos(now)) / inertia
    sideways, up = r * (faster * cos(now) - square * sin(now)), GRAVITY - r * (faster * sin(now) + square * cos(now))
    leans = Pose((r * sin(start), 0.0, r * cos(start)), (0.0, sin(0.5 * start), 0.0, cos(0.5 * start)))
    ground = Contact(
        GROUND, "solid", tuple((0.0, y, 0.0) for y in touching), (UP,), Coulomb(share * abs(sideways) / up)
    )
    spin = (0.0, 1.0, 0.0)
    problem = Problem({"solid": Placed(Brick("solid", shape, MASS), leans)}, [ground], {"solid": OWN_WEIGHT})
    part = falling_part(problem, Motion({"solid": (cross(spin, leans.position_W), spin)}), GRAVITY)
    assert part is not None
    assert holds_together(part, now - start) is (share > 1.0)


def test_a_box_given_by_corners_in_any_axes_spins_and_is_pushed_like_a_box() -> None:
    same_plank = polyhedron(rotate(AWRY, corner) for corner in PLANK.corners)
    x, y, z, w = AWRY
    turn: Quaternion = (0.0, 0.6, 0.0, 0.8)
    after = []
    for shape, own in ((PLANK, IDENTITY), (same_plank, (-x, -y, -z, w))):
        world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
        world.add_brick(Brick("plank", shape, MASS), start := Pose((0.1, 0.2, 0.3), multiply(turn, own)))
        world.set_state("plank", BodyState(start, (0.1, -0.2, 0.3), (3.0, -2.0, 1.0)))
        world.push("plank", (0.001, 0.002, -0.003), (0.12, 0.2, 0.31))
        for _ in range(50):
            world.step()
        state = world.states(["plank"])["plank"]
        after.append((*state.pose.position_W, *state.velocity_W, *state.angular_velocity_W))
    assert after[0] == pytest.approx(after[1], rel=1e-9)


def test_a_world_that_needs_no_engine_keeps_any_shape() -> None:
    world = RestingWorld(EngineFactory(SETTINGS, lambda _: SETTINGS, lambda *_: pytest.fail("nothing moves")))
    world.add_plane(FLOOR)
    world.add_brick(Brick("wedge", LOWER_HALF, MASS), Pose((0.0, 0.0, THICKNESS / 3.0)))
    assert world.shape("wedge") is LOWER_HALF


def test_a_foreign_wedge_stands_on_its_side() -> None:
    verdict = Assembly().add(Brick("wedge", LOWER_HALF, MASS), Pose((0.0, 0.0, THICKNESS / 3.0)))
    assert verdict.stability is Stability.STABLE


def test_a_shape_that_is_thinner_than_numbers_can_tell_is_refused() -> None:
    sliver = polyhedron([(0.0, 0.0, 0.0), (1e-3, 0.0, 0.0), (0.0, 1e-3, 0.0), (0.0, 0.0, 5e-10)])
    with pytest.raises(ValueError, match=r"brick 'sliver' measures .* each dimension must be from 1e-09"):
        Assembly().add(Brick("sliver", sliver, MASS), AT_HOME)


def test_a_shape_that_is_larger_than_numbers_can_tell_is_refused() -> None:
    world = polyhedron(Box((2e9, 1e8, 1e8)).corners)
    with pytest.raises(ValueError, match=r"brick 'world' measures .* each dimension must be from 1e-09 to 1e\+09 m"):
        Assembly().add(Brick("world", world, MASS), AT_HOME)


def test_moments_do_not_depend_on_how_its_axes_were_written() -> None:
    turned = polyhedron(rotate(AWRY, corner) for corner in TETRAHEDRON.corners)
    assert turned.moments(MASS) == pytest.approx(TETRAHEDRON.moments(MASS))
    one, other = Brick("t", TETRAHEDRON, MASS), Brick("t", turned, MASS)
    x, y, z, w = AWRY
    spin = (1.0, 2.0, 3.0)
    assert inertia_times(other, (-x, -y, -z, w), spin) == pytest.approx(inertia_times(one, (0.0, 0.0, 0.0, 1.0), spin))
    assert dot(spin, inertia_times(one, AWRY, spin)) > 0.0
    assert np.linalg.norm(TETRAHEDRON.principal_axes) == pytest.approx(1.0)
