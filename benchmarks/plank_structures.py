"""Structures for benchmarks, as placed bricks in the order of building."""

from math import pi

from stability.geometry.box import Box
from stability.geometry.polygons import Point2
from stability.geometry.vectors import about
from stability.model import Brick, Pose, Quaternion
from stability.problem import Placed

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # a KAPLA plank [m]
DENSITY = 557.0  # [kg/m3]
GAP = 0.0002  # [m] between the ends of planks in a wall


def plank_at(name: str, at: Point2, level: int, yaw: float = 0.0, length: float = LENGTH) -> Placed:
    """Return a flat plank with its centre above `at`, at a level counted from 1."""
    turn: Quaternion = about((0.0, 0.0, 1.0), yaw)
    brick = Brick(name, Box((length, WIDTH, THICKNESS)), DENSITY * length * WIDTH * THICKNESS)
    return Placed(brick, Pose((*at, (level - 0.5) * THICKNESS), turn))


def four_stack(planks: int, spacing: float = LENGTH - WIDTH) -> list[Placed]:
    """Return two parallel planks per level, a `spacing` [m] apart, rotated by 90 degrees at each level."""
    planks_placed = []
    for number in range(planks):
        level, side = number // 2 + 1, (number % 2 - 0.5) * spacing
        x, y, yaw = (0.0, side, 0.0) if level % 2 else (side, 0.0, 0.5 * pi)
        planks_placed.append(plank_at(f"t{number:05}", (x, y), level, yaw))
    return planks_placed


def wall(planks: int, across: int) -> list[Placed]:
    """Return a wall in running bond, `across` planks per level, every other level with half a plank at both ends."""
    placed: list[Placed] = []
    level = 0
    while len(placed) < planks:
        level += 1
        lengths = [LENGTH] * across if level % 2 else [_half(), *[LENGTH] * (across - 1), _half()]
        x = 0.0
        for length in lengths:
            placed.append(plank_at(f"w{len(placed):05}", (x + 0.5 * length, 0.0), level, length=length))
            x += length + GAP
    return placed[:planks]


def _half() -> float:
    return 0.5 * (LENGTH - GAP)


def stepped_columns(planks: int, high: int = 10, share: float = 0.9) -> list[Placed]:
    """Return separate columns, each stepped to a share of its limit: no plank's support is below its load."""
    step = share * LENGTH / high
    placed = []
    for number in range(planks):
        column, level = divmod(number, high)
        x, y = divmod(column, 32)
        placed.append(plank_at(f"c{number:05}", (0.4 * x + level * step, 0.05 * y), level + 1))
    return placed
