"""Angle up to which a falling part turns as one body: closed forms of slips within it, and of hits."""

from collections.abc import Callable, Sequence
from math import atan, cos, degrees, radians, sin

import pytest

from stability.dynamics.toppling import (
    FallingPart,
    falling_part,
    holds_together,
    is_clear,
    part_in_motion,
    turn_of,
    turned_part,
)
from stability.geometry.box import Box
from stability.geometry.vectors import add, norm, scale, subtract, turn_between
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Motion, Placed
from stability.statics.assembly import Assembly

LENGTH, WIDTH, THICKNESS = 0.12, 0.024, 0.008  # of a plank [m]
G = 9.81  # [m/s2]
ANGLES = [radians(angle) for angle in range(61)]


def leaning_column(step: float, count: int, friction: float) -> tuple[FallingPart, Assembly]:
    """A column of planks that tips over its lowest one, on ground far below that does not stop it."""
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)
    assembly = Assembly([ground], friction, G)
    first = assembly.add_all(
        Placed(Brick(f"p{n:02}", Box((LENGTH, WIDTH, THICKNESS)), 0.012), Pose((step * n, 0.0, THICKNESS * (n + 0.5))))
        for n in range(count)
    )
    assert first.motion is not None
    problem = assembly.problem(first.moving)
    part = falling_part(problem, first.motion, G)
    assert part is not None
    return part, assembly


def holds_until(part: FallingPart) -> float:
    """The last whole degree at which friction holds the part together."""
    return last_of(lambda angle: holds_together(part, angle))


def clear_until(part: FallingPart, others: Sequence[Placed], planes: Sequence[Plane]) -> float:
    """The last whole degree at which it has hit nothing."""
    return last_of(lambda angle: is_clear(part, angle, others, planes))


def last_of(holds: Callable[[float], bool]) -> float:
    first_not = next((n for n, angle in enumerate(ANGLES) if not holds(angle)), len(ANGLES))
    assert first_not > 0
    return round(degrees(ANGLES[first_not - 1]))


def slides_at(part: FallingPart, friction: float) -> float:
    """The angle [deg] at which it slides on its edge, or in its lowest joint, for a pendulum in the plane of x and z.

    Along and across the layers that part is pressed with m (g sin - alpha z) and m (g cos - omega^2 z), and x counts in
    the same way, where x and z are those of its centre from the edge, turned with the part.
    """
    edge = part.turn.point_W
    bodies = sorted(
        (p.pose.position_W[2] - edge[2], p.pose.position_W[0] - edge[0]) for p in part.problem.bricks.values()
    )
    own = (LENGTH**2 + THICKNESS**2) / 12.0
    inertia = sum(x * x + z * z + own for z, x in bodies) / len(bodies)
    cx, cz = sum(x for _, x in bodies) / len(bodies), sum(z for z, _ in bodies) / len(bodies)
    slides = [bodies, bodies[1:]]
    centres = [(sum(x for _, x in above) / len(above), sum(z for z, _ in above) / len(above)) for above in slides]
    for tenth in range(1, 900):
        angle = radians(0.1 * tenth)
        squared = 2.0 * G * (cz * (1.0 - cos(angle)) + cx * sin(angle)) / inertia
        alpha = G * (cx * cos(angle) + cz * sin(angle)) / inertia
        for ux, uz in centres:
            along = G * sin(angle) - alpha * uz + squared * ux
            across = G * cos(angle) - alpha * ux - squared * uz
            if abs(along) > friction * across:
                return 0.1 * tenth
    raise AssertionError


@pytest.mark.parametrize("friction", [0.05, 0.1, 0.2])
def test_a_column_that_tips_slides_on_its_edge_or_in_its_lowest_joint_when_friction_is_used_up(friction: float) -> None:
    part, _ = leaning_column(0.011, 12, friction)
    expected = slides_at(part, friction)
    assert holds_until(part) == pytest.approx(expected, abs=1.0)
    # Were it at rest, it would slide at the angle of friction: falling with the layers, it holds for longer.
    assert expected > degrees(atan(friction))


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.5])
@pytest.mark.parametrize("wide", [LENGTH, 0.5 * LENGTH])
def test_one_plank_that_tips_slides_on_its_edge_as_on_the_slope_that_its_face_is(friction: float, wide: float) -> None:
    # It hangs by 1 mm over the end of a post that is as wide as it, or half as wide: an edge on its face, which turns.
    post = Placed(Brick("post", Box((wide, WIDTH, 0.1)), 0.1), Pose((-0.5 * wide, 0.0, 0.05)))
    plank = Placed(Brick("plank", Box((LENGTH, WIDTH, THICKNESS)), 0.012), Pose((0.001, 0.0, 0.1 + 0.5 * THICKNESS)))
    assembly = Assembly([Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)], friction, G)
    first = assembly.add_all([post, plank])
    assert first.motion is not None
    part = falling_part(assembly.problem(["plank", "post"]), first.motion, G)
    assert part is not None
    x, z = 0.001, 0.5 * THICKNESS
    inertia = (LENGTH**2 + THICKNESS**2) / 12.0 + x * x + z * z

    def slides(angle: float) -> bool:
        squared = 2.0 * G * (z * (1.0 - cos(angle)) + x * sin(angle)) / inertia
        alpha = G * (x * cos(angle) + z * sin(angle)) / inertia
        along = G * sin(angle) - alpha * z + squared * x
        return along > friction * (G * cos(angle) - alpha * x - squared * z)

    assert holds_until(part) == next(n for n, angle in enumerate(ANGLES) if slides(angle)) - 1


def test_a_block_that_tips_on_its_own_edge_slides_as_on_the_ground_that_it_stands_on() -> None:
    # A tall block, set down at 20 deg on its edge beyond its balance; level ground bears it, and does not turn.
    tall, thin, leans, friction = 0.1, 0.02, radians(20.0), 0.25
    x, z = (0.5 * (tall * sin(leans) - thin * cos(leans)), 0.5 * (tall * cos(leans) + thin * sin(leans)))
    turn = (0.0, sin(0.5 * leans), 0.0, cos(0.5 * leans))
    block = Placed(Brick("block", Box((thin, WIDTH, tall)), 0.1), Pose((x, 0.0, z), turn))
    assembly = Assembly([Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)], friction, G)
    first = assembly.add_all([block])
    assert first.motion is not None
    part = falling_part(assembly.problem(["block"]), first.motion, G)
    assert part is not None
    inertia = (tall**2 + thin**2) / 12.0 + x * x + z * z

    def slides(angle: float) -> bool:
        across, high = x * cos(angle) + z * sin(angle), z * cos(angle) - x * sin(angle)
        squared, alpha = 2.0 * G * (z - high) / inertia, G * across / inertia
        return abs(alpha * high - squared * across) > friction * (G - alpha * across - squared * high)

    assert holds_until(part) == next(n for n, angle in enumerate(ANGLES) if slides(angle)) - 1


def test_more_friction_holds_a_part_together_for_longer() -> None:
    held = [holds_until(leaning_column(0.011, 12, friction)[0]) for friction in (0.05, 0.1, 0.2, 0.4)]
    assert held == sorted(set(held))


def test_a_part_is_one_body_only_until_its_lowest_corner_strikes_the_ground() -> None:
    # The far lower end of the top plank is at (x, z) from the edge over which all turns, at the height h above ground;
    # it is there at the angle with x sin - z cos = h.
    part, assembly = leaning_column(0.032, 4, 0.5)
    edge = part.turn.point_W
    top: Vec3 = part.problem.bricks["p03"].pose.position_W
    x, z = top[0] + LENGTH / 2.0 - edge[0], top[2] - THICKNESS / 2.0 - edge[2]
    touches = next(a for a in ANGLES if x * sin(a) - z * cos(a) > edge[2])
    assert clear_until(part, [], assembly.planes) == pytest.approx(degrees(touches), abs=1.0)


def test_a_part_is_one_body_only_until_it_strikes_a_brick() -> None:
    part, _ = leaning_column(0.032, 4, 0.5)
    post = Placed(Brick("post", Box((0.02, 0.02, 0.012)), 0.01), Pose((0.14, 0.0, 0.006)))
    # The face that the top plank has below is at the height h from the edge; turned, it is h above all points with
    # x sin + z cos = h, where x and z are from the edge. The far upper corner of the post is the first of its.
    edge = part.turn.point_W
    x, z = 0.15 - edge[0], 0.012 - edge[2]
    h = part.problem.bricks["p03"].pose.position_W[2] - THICKNESS / 2.0 - edge[2]
    touches = next(a for a in ANGLES if x * sin(a) + z * cos(a) > h)
    assert clear_until(part, [post], []) == pytest.approx(degrees(touches), abs=1.0)


def test_a_sliding_or_freely_falling_part_does_not_rotate() -> None:
    assembly = Assembly()
    loose = Placed(Brick("loose", Box((LENGTH, WIDTH, THICKNESS)), 0.012), Pose((1.0, 0.0, 0.5)))
    first = assembly.add_all([loose])
    assert first.motion is not None
    assert turn_of(assembly.problem(["loose"]), first.motion) is None
    screw = Motion({"loose": ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))})
    assert turn_of(assembly.problem(["loose"]), screw) is None


def test_a_rotation_is_recognised_despite_solver_errors_near_the_axis() -> None:
    part, _ = leaning_column(0.011, 12, 0.5)
    motion = velocities(part)
    slowest, fastest = (by(motion, key=lambda name: norm(motion[name][0])) for by in (min, max))
    velocity, spin = motion[slowest]
    off = add(velocity, (0.0, 6e-7 * norm(motion[fastest][0]), 0.0))
    assert norm(subtract(off, velocity)) > 1e-6 * norm(velocity)
    assert turn_of(part.problem, Motion({**motion, slowest: (off, spin)})) is not None
    # A brick that slides along is no part of the turn, however slow the others are.
    off = add(velocity, (0.0, 1e-5 * norm(motion[fastest][0]), 0.0))
    assert turn_of(part.problem, Motion({**motion, slowest: (off, spin)})) is None


def test_a_part_is_one_body_only_while_its_support_stands() -> None:
    # Planks stepped by d hang over the end of the one below them all if there are more than L / d - 1, here 9.9. With
    # ten above p01 they tip over its end; but with p01 that makes eleven above p00, over whose end all tip by more.
    part, assembly = leaning_column(0.011, 12, 0.5)
    assert min(part.moving) == "p02"
    assert holds_together(part, 0.0)
    among_all = falling_part(assembly.problem(sorted(assembly.bricks)), Motion(velocities(part)), G)
    assert among_all is not None
    assert not holds_together(among_all, 0.0)
    # One plank less, and p00 stands, whatever turns on its end.
    shorter, others = leaning_column(0.011, 11, 0.5)
    among_all = falling_part(others.problem(sorted(others.bricks)), Motion(velocities(shorter)), G)
    assert among_all is not None
    assert holds_until(among_all) == holds_until(shorter)


def velocities(part: FallingPart) -> dict[str, tuple[Vec3, Vec3]]:
    return {
        name: (state.velocity_W, state.angular_velocity_W) for name, state in part_in_motion(part, 0.0, 1.0).items()
    }


def test_a_part_in_motion_moves_as_its_places_change() -> None:
    part, _ = leaning_column(0.011, 12, 0.5)
    before, after = (turned_part(part, angle) for angle in (0.3 - 1e-6, 0.3 + 1e-6))
    for name, state in part_in_motion(part, 0.3, 2.0).items():
        moved = subtract(after[name].pose.position_W, before[name].pose.position_W)
        assert scale(1e6, moved) == pytest.approx(state.velocity_W, abs=1e-9)
        turn = turn_between(before[name].pose, after[name].pose)
        assert 1e6 * turn == pytest.approx(norm(state.angular_velocity_W), rel=1e-6)
