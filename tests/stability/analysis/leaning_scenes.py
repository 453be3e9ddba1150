"""Bricks that need friction to rest: on slopes, against walls, between them. Lengths in metres, angles in degrees."""

from math import cos, radians, sin

from stability.geometry.box import Box
from stability.model import Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import LEVEL_GROUND, Assembly

LENGTH, WIDTH, THICKNESS = 1.0, 0.3, 0.06  # of a plank


def box(name: str, size: tuple[float, float, float], x: float, z: float, angle: float = 0.0) -> Placed:
    """A box of 1 kg with its centre in the plane y = 0, turned about y: positive lowers the end on +x."""
    half = radians(angle) / 2.0
    return Placed(Brick(name, Box(size), 1.0), Pose((x, 0.0, z), (0.0, sin(half), 0.0, cos(half))))


def plane(name: str, angle: float, friction: float, x: float = 0.0, z: float = 0.0) -> Plane:
    """A plane through a point, whose normal leans from upright towards +x."""
    return Plane(name, (x, 0.0, z), (sin(radians(angle)), 0.0, cos(radians(angle))), friction)


def standing(*bricks: Placed, planes: tuple[Plane, ...] = (LEVEL_GROUND,), friction: float = 0.5) -> Assembly:
    """An assembly that is proven to stand."""
    made = Assembly(planes, friction)
    assert made.add_all(bricks).stability is Stability.STABLE
    return made


def pile_on_a_slope(count: int, angle: float, friction: float) -> Assembly:
    """Flat bricks on each other on a slope."""
    size, lean = (0.3, 0.2, 0.05), radians(angle)
    heights = [size[2] * (number + 0.5) for number in range(count)]
    bricks = [
        box(f"b{number}", size, height * sin(lean), height * cos(lean), angle) for number, height in enumerate(heights)
    ]
    return standing(*bricks, planes=(plane("ground", angle, friction),), friction=friction)


def ladder(angle: float, floor: float, wall: float) -> Assembly:
    """A plank that leans on a wall at x = 0, both contacts on its lower face."""
    lean = radians(angle)
    x = 0.5 * (LENGTH * cos(lean) + THICKNESS * sin(lean))
    z = 0.5 * (LENGTH * sin(lean) + THICKNESS * cos(lean))
    planes = (plane("ground", 0.0, floor), plane("wall", 90.0, wall))
    return standing(box("plank", (LENGTH, WIDTH, THICKNESS), x, z, angle), planes=planes)


def slope_of_the_diagonal(angle: float) -> float:
    """Of the line between the corners by which a plank at an angle touches two walls: its tangent."""
    lean = radians(angle)
    rise, run = LENGTH * sin(lean) - THICKNESS * cos(lean), LENGTH * cos(lean) + THICKNESS * sin(lean)
    return rise / run


def aslant_between_walls(angle: float, lower: float, upper: float, lift: float = 2.0) -> Assembly:
    """A plank in the air between two walls: its lower end on one, its upper on the other, each with its friction."""
    lean = radians(angle)
    half = 0.5 * (LENGTH * cos(lean) + THICKNESS * sin(lean))
    made = Assembly((plane("left", 90.0, upper, -half), plane("right", -90.0, lower, half)))
    made.add_all([box("plank", (LENGTH, WIDTH, THICKNESS), 0.0, lift, angle)])
    return made


def wedged_between_steep_planes() -> Assembly:
    """A level box, an upper edge of which is below an overhanging plane, and the lower edge opposite on a steep one."""
    size, friction = (1.0, 0.9, 0.6), 1.2
    x, z = 0.5 * size[0], 0.5 * size[2]
    planes = (plane("left", 120.0, friction, -x, z), plane("right", -78.0, friction, x, -z))
    return standing(box("box", size, 0.0, 0.0), planes=planes)
