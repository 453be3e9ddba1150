"""Compares the rigid-body engine with closed forms, and the cost of its steps with that of a bare PyBullet world.

Run it with `python -m benchmarks.rigid_engine`; the first run compiles the engine for half a minute.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from random import Random
from time import process_time
from typing import Final, TypeAlias

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import EngineSettings, World
from stability.engines.rigid.settings import Solving
from stability.geometry.box import Box
from stability.model import AT_REST, GROUND, Brick, Plane, Pose, Vec3
from stackdsl.simulation.systems import MOVING, RIGID

SIZE: Final = (0.1176, 0.0234, 0.0078)  # [m] of a plank: length, width, thickness
LENGTH, WIDTH, THICKNESS = SIZE
MASS, GRAVITY = 0.012, 9.81  # [kg], [m/s2]
BARE: Final = replace(  # PyBullet without the corrections of `exact`
    MOVING,
    fresh_edges=False,
    edge_rounding=0.0,
    sliding_cones=False,
    first_steps=0,
    lively_parts=1,
    lively_iterations=50,
)
FINE: Final = replace(RIGID, falling=Solving(32, 200, 1e-7), struck=Solving(32, 200, 1e-6))
SLIPS, TURNED = 1e-3, 30.0  # [m] by which planks that slip have sunk; [deg] of rotation to measure
Poses: TypeAlias = Sequence[Pose]


def main() -> None:
    """Compute and print the tables; write them on request."""
    write = parser(__doc__).parse_args().write
    known = {str(row["case"]): row for row in _known()}
    costs = {str(row["scene"]): row for row in _costs()}
    for title, rows in (("closed forms", known), ("cost", costs)):
        table = Table(*next(iter(rows.values())), title=title)
        for row in rows.values():
            table.add_row(*(f"{value:.4g}" if isinstance(value, float) else str(value) for value in row.values()))
        Console(width=110).print(table)
    if write:
        command = "python -m benchmarks.rigid_engine --write"
        record("rigid-engine", command, {"known": known, "costs": costs})


def _known() -> Iterator[Row]:
    """Yield the results with a closed form, or with a converged reference."""

    def row(case: str, reference: float, engine: float) -> Row:
        return {
            "case": case,
            "reference": reference,
            "engine": engine,
            "error_percent": 100.0 * (engine / reference - 1.0),
        }

    for direction in (0.0, 30.0, 77.0):
        yield row(
            f"way of a plank that slides at 1 m/s towards {direction:g} deg, m", 1.0 / (0.6 * GRAVITY), slide(direction)
        )
    for angle in (60.0, 70.0, 75.0):
        needed = 0.5 * (1.0 / tan(radians(angle)) - THICKNESS / LENGTH)
        yield row(f"friction that two planks leaning at {angle:g} deg need", needed, needed_friction(angle, needed))
    reference = time_to_turn(FINE)
    yield row(
        "time in which 12 planks stepped by 12 mm turn by 30 deg, s (32 sub-steps)", reference, time_to_turn(RIGID)
    )


def opened(settings: EngineSettings, friction: float, poses: Poses, velocity_W: Vec3 = AT_REST) -> World:
    """Return a world of planks on the ground."""
    world = stepped_world(settings, GRAVITY, friction, MASS)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction))
    for number, pose in enumerate(poses):
        world.add_brick(Brick(f"b{number:04}", Box(SIZE), MASS), pose, velocity_W)
    return world


def slide(direction: float) -> float:
    """Return the way of a plank that slides on the ground [m]."""
    angle = radians(direction)
    world = opened(RIGID, 0.3, [Pose((0.0, 0.0, 0.5 * THICKNESS))], (cos(angle), sin(angle), 0.0))
    _play(world, lambda: world.time() > 1.0)
    x, y, _ = world.states(["b0000"])["b0000"].pose.position_W
    return hypot(x, y)


def needed_friction(angle: float, about: float) -> float:
    """Return the least friction with which two leaning planks stay for a second, to 0.1 %."""
    least, most = 0.8 * about, 1.3 * about
    while most - least > 1e-3 * about:
        middle = 0.5 * (least + most)
        least, most = (middle, most) if _slips(radians(angle), middle) else (least, middle)
    return most


def _slips(angle: float, friction: float) -> bool:
    along, across = (cos(angle), sin(angle)), (-sin(angle), cos(angle))
    # The upper inner edges touch; the lower ones stand on the ground.
    reach = 0.5 * (LENGTH * along[0] - THICKNESS * across[0])
    height = 0.5 * (LENGTH * along[1] + THICKNESS * across[1])
    turned = [(0.0, sign * sin(0.5 * angle), 0.0, cos(0.5 * angle)) for sign in (-1.0, 1.0)]
    world = opened(RIGID, friction, [Pose((-reach, 0.0, height), turned[0]), Pose((reach, 0.0, height), turned[1])])
    _play(world, lambda: world.time() > 1.0)
    return height - world.states(["b0000"])["b0000"].pose.position_W[2] > SLIPS


def time_to_turn(settings: EngineSettings) -> float:
    """Return the time in which the top plank of a leaning column turns by 30 deg [s]."""
    world = opened(settings, 0.5, column(12, 0.012))
    turned = [0.0]

    def done() -> bool:
        x, y, z, w = world.states(["b0011"])["b0011"].pose.orientation
        turned.append(2.0 * degrees(atan2(hypot(x, y, z), w)))
        return turned[-1] > TURNED

    _play(world, done)
    over = (turned[-1] - TURNED) / (turned[-1] - turned[-2])
    return world.time() - over * settings.time_step


def _play(world: World, done: Callable[[], bool]) -> None:
    while not done():
        world.step()


def column(count: int, step: float) -> Poses:
    """Return planks on each other, each shifted by a step [m]."""
    return [Pose((step * number, 0.0, THICKNESS * (number + 0.5))) for number in range(count)]


def four_stack(levels: int) -> Poses:
    """Return two parallel planks a level, turned from level to level."""
    apart, turned = 0.5 * (LENGTH - WIDTH), (0.0, 0.0, sqrt(0.5), sqrt(0.5))
    return [
        Pose((0.0, side * apart, THICKNESS * (level + 0.5)))
        if level % 2 == 0
        else Pose((side * apart, 0.0, THICKNESS * (level + 0.5)), turned)
        for level in range(levels)
        for side in (-1.0, 1.0)
    ]


def heap(count: int) -> Poses:
    """Return planks in layers of 25 askew, which fall on each other."""
    random, poses = Random(3), []
    for number in range(count):
        half = 0.5 * random.uniform(0.0, pi)
        x, y = number % 5 * 0.13 + random.uniform(-0.01, 0.01), number // 5 % 5 * 0.05 + random.uniform(-0.01, 0.01)
        poses.append(Pose((x, y, 0.01 + 0.02 * (number // 25)), (0.0, 0.0, sin(half), cos(half))))
    return poses


def _costs() -> Iterator[Row]:
    """Yield the cost of a millisecond of motion with every brick awake, in both engines."""
    for scene, poses, before, steps in (
        ("12 planks that fall", column(12, 0.012), 10, 150),
        ("tower of 26 planks", four_stack(13), 20, 150),
        ("tower of 100 planks", four_stack(50), 20, 80),
        ("heap of 250 planks", heap(250), 300, 60),
    ):
        own, bare = (_cost(opened(settings, 0.5, poses), before, steps) for settings in (RIGID, BARE))
        yield {"scene": scene, "engine_ms": own, "pybullet_ms": bare, "ratio": own / bare}


def _cost(world: World, before: int, steps: int) -> float:
    for _ in range(before):
        world.step()
    began, at = process_time(), world.time()
    for _ in range(steps):
        world.step()
    return (process_time() - began) / (world.time() - at)  # [ms] of processor for a millisecond of the scene


if __name__ == "__main__":
    main()
