"""Scenes whose margins are known: boxes on each other, planks that lean, a cube on an incline."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, radians, sin
from typing import TypeAlias

from stability.contact_law import Coulomb
from stability.geometry.box import Box, as_box
from stability.model import GROUND, BodyId, Brick, Pose, Vec3
from stability.problem import UP, Contact, Placed, Problem, Wrench
from tests.stability.statics.hand_built import inverted_v, ladder, on_a_slope, plank, rectangle, weighed

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # of a KAPLA plank [m]
PLANK: Vec3 = (LENGTH, WIDTH, THICKNESS)
STEEP = radians(60.0)

Upright: TypeAlias = tuple[BodyId, float, float, float, Vec3]  # name, centre in plan, height of the underside, size [m]


def upright_boxes(boxes: Sequence[Upright], friction: float = 0.5) -> Problem:
    """Boxes along the axes of W, of the density of water, on level ground and on each other."""
    bricks = [
        plank(name, (x, y, z + size[2] / 2.0), 1000.0 * size[0] * size[1] * size[2], size)
        for name, x, y, z, size in boxes
    ]
    contacts = [Contact(GROUND, box[0], overlap(box, box), (UP,), Coulomb(friction)) for box in boxes if box[3] == 0.0]
    for lower in boxes:
        for upper in boxes:
            corners = overlap(lower, upper) if abs(lower[3] + lower[4][2] - upper[3]) < 1e-9 else ()
            if corners:
                contacts.append(Contact(lower[0], upper[0], corners, (UP,), Coulomb(friction)))
    return weighed(bricks, contacts)


def overlap(lower: Upright, upper: Upright) -> tuple[Vec3, ...]:
    """The corners of what two boxes share in plan, at the underside of the upper one; nothing if they are apart."""
    _, x, y, z, (length, width, _) = upper
    _, u, v, _, (other_length, other_width, _) = lower
    left, right = max(x - length / 2.0, u - other_length / 2.0), min(x + length / 2.0, u + other_length / 2.0)
    front, back = max(y - width / 2.0, v - other_width / 2.0), min(y + width / 2.0, v + other_width / 2.0)
    if right - left < 1e-9 or back - front < 1e-9:
        return ()
    return rectangle((left, right), (front, back), z)


def block(length: float, width: float, height: float, friction: float) -> Problem:
    return upright_boxes([("block", 0.0, 0.0, 0.0, (length, width, height))], friction)


def column(count: int, step: float = 0.0, friction: float = 0.5) -> Problem:
    return upright_boxes([(f"b{i:03}", i * step, 0.0, i * THICKNESS, PLANK) for i in range(count)], friction)


def four_stack(levels: int) -> list[Upright]:
    """Two planks a level, crosswise."""
    aside = (LENGTH - WIDTH) / 2.0
    boxes: list[Upright] = []
    for level in range(levels):
        for side in (-1, 1):
            name, z = f"L{level:03}.{side}", level * THICKNESS
            if level % 2 == 0:
                boxes.append((name, 0.0, side * aside, z, PLANK))
            else:
                boxes.append((name, side * aside, 0.0, z, (WIDTH, LENGTH, THICKNESS)))
    return boxes


def leaning(friction: float, mirrored: bool) -> Problem:
    """A plank that leans steeply against a smooth wall; or, mirrored, against another that leans against it."""
    return inverted_v(STEEP, friction, PLANK) if mirrored else ladder(STEEP, friction, size=PLANK)


def on_incline(slope: float, friction: float) -> Problem:
    """A cube of 0.1 m on a slope that falls off towards x."""
    return on_a_slope(slope, friction, (0.1, 0.1, 0.1))


def changed(problem: Problem, size: float, weight: float, yaw: float) -> Problem:
    """The same scene of another size and weight, turned about the vertical, all in reverse order."""
    c, s = cos(yaw), sin(yaw)

    def turned(v: Vec3) -> Vec3:
        return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])

    def at(v: Vec3) -> Vec3:
        x, y, z = turned(v)
        return (size * x, size * y, size * z)

    bricks = {}
    for name, placed in reversed(list(problem.bricks.items())):
        x, y, z, w = placed.pose.orientation
        a, b = sin(yaw / 2.0), cos(yaw / 2.0)
        turn = (b * x - a * y, b * y + a * x, b * z + a * w, b * w - a * z)
        length, width, height = as_box(placed.brick.shape, "a scaled scene").size
        brick = Brick(name, Box((size * length, size * width, size * height)), placed.brick.mass)
        bricks[name] = Placed(brick, Pose(at(placed.pose.position_W), turn))
    contacts = [
        replace(one, points_W=tuple(map(at, one.points_W)), normals_W=tuple(map(turned, one.normals_W)))
        for one in reversed(list(problem.contacts))
    ]
    loads = {name: Wrench((0.0, 0.0, weight * load.force_W[2])) for name, load in problem.loads.items()}
    return Problem(bricks, contacts, loads)
