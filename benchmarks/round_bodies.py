"""Compares the round bodies of each engine with closed forms: balls and logs that roll, cans that tip and slide.

Run it with `python -m benchmarks.round_bodies`; engines that are not installed are left out.
"""

from collections.abc import Callable, Iterator
from contextlib import closing
from math import acos, atan, atan2, cos, dist, pi, radians, sin, sqrt
from typing import Final

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import EngineSettings, World
from stability.geometry.box import Box
from stability.geometry.round_solid import RoundSolid, cylinder, pipe, sphere
from stability.geometry.vectors import about, dot, multiply, rotate, scale
from stability.model import GROUND, IDENTITY, BodyState, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.systems import PEERS, SYSTEMS

GRAVITY: Final = 9.81  # [m/s2]
RADIUS: Final = 0.05  # [m] of bodies that roll
ROLLING: Final = {"ball": sphere(RADIUS), "log": cylinder(RADIUS, 0.4), "pipe": pipe(RADIUS, 0.01, 0.4)}
LYING: Final[Quaternion] = about((1.0, 0.0, 0.0), 0.5 * pi)  # its axis along y
SLOPE: Final = radians(10.0)
ROUGH: Final = 0.9
CAN: Final = cylinder(0.033, 0.115)
YAWS: Final = (0.1, 0.5, 1.3)  # [rad] of a can: an engine may have no contact point where its rim is lowest
EARLY: Final = tuple(0.1 * number for number in range(60, 0, -1))  # [deg] below the slope on which a can tips
TILTED: Final = radians(15.0)  # a can at a larger angle to its slope has tipped
SLID: Final = 0.01  # [m]
ENGINES: Final = ("stock", "thesis", "tuned", "pybullet-exact", "mujoco", "mujoco-stiff", "rigid")


def main() -> None:
    """Measure and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    rows = {name: measured(name) for name in ENGINES if engine_of(name).package.installed}
    table = Table("engine of", *next(iter(rows.values())), title="errors")
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()))
    Console(width=140).print(table)
    if write:
        record("round-bodies", "python -m benchmarks.round_bodies --write", {"engines": rows})


def engine_of(name: str) -> EngineSettings:
    """Return the engine settings of a system."""
    return (SYSTEMS | PEERS)[name].engine


def measured(name: str) -> Row:
    """Return the errors of the engine of a system, without the method of the system."""
    settings = engine_of(name)
    slides = atan(0.3)
    return {
        "system": f"`{name}`",
        **{f"{body}_percent": 100.0 * rolling_error(settings, shape) for body, shape in ROLLING.items()},
        "early_deg": tips_early(settings),
        "slide_percent": 100.0 * (least_slope(slides, lambda slope: slides_off(settings, slope, 0.3)) / slides - 1.0),
        **{f"{pile}_mm": 1e3 * shift for pile, shift in _shifts(settings)},
    }


def world_on(settings: EngineSettings, slope: float, friction: float) -> World:
    """Return an empty world on ground that slopes down towards x."""
    world = stepped_world(settings, GRAVITY, friction, 1.0)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (sin(slope), 0.0, cos(slope)), friction))
    return world


def played(world: World, name: str, duration: float) -> BodyState:
    """Return the state of a brick after a duration [s]."""
    for _ in range(round(duration / world.settings.time_step)):
        world.step()
    return world.states([name])[name]


# Rolling: a body on a slope gains g sin(slope) / (1 + I / (m r^2)), from rest, and a half of this times t^2.


def rolling_error(settings: EngineSettings, shape: RoundSolid, slope: float = SLOPE, friction: float = ROUGH) -> float:
    """Return the relative error of the way in half a second; friction is enough for rolling, or too little."""
    inertia = shape.moments(1.0)[2] / shape.widest**2
    gained = sin(slope) / (1.0 + inertia)
    needed = gained * inertia / cos(slope)  # friction of a body that rolls
    expected = GRAVITY * (gained if friction > needed else sin(slope) - friction * cos(slope))
    with closing(world_on(settings, slope, friction)) as world:
        normal = (sin(slope), 0.0, cos(slope))
        turn = LYING if shape.height else IDENTITY
        world.add_brick(Brick("body", shape, 1.0), Pose(scale(shape.widest, normal), turn))
        at = played(world, "body", 0.5).pose.position_W
        return 2.0 * dot(at, (cos(slope), 0.0, -sin(slope))) / world.time() ** 2 / expected - 1.0


# A can on a slope tips where its centre is beyond its rim, and slides where the slope exceeds its friction.


def tips_early(settings: EngineSettings) -> float:
    """Return by how much the least slope on which a can tips is below that of the closed form [deg]."""
    limit = atan2(CAN.widest, 0.5 * CAN.height)
    return next((by for by in EARLY if any(falls(settings, limit - radians(by), yaw=yaw) for yaw in YAWS)), 0.0)


def falls(settings: EngineSettings, slope: float, shape: RoundSolid = CAN, yaw: float = YAWS[0]) -> bool:
    """Return whether a standing body, turned about its axis, tips on a slope within 2 s."""
    end, _ = _stood(settings, slope, 2.0, shape, yaw)
    normal = (sin(slope), 0.0, cos(slope))
    return acos(min(1.0, dot(rotate(end.orientation, (0.0, 0.0, 1.0)), normal))) > TILTED


def slides_off(settings: EngineSettings, slope: float, friction: float, shape: RoundSolid = CAN) -> bool:
    """Return whether a standing body slides on a slope within 2 s."""
    return dist(*(pose.position_W for pose in _stood(settings, slope, friction, shape))) > SLID


def _stood(
    settings: EngineSettings, slope: float, friction: float, shape: RoundSolid, yaw: float = YAWS[0]
) -> tuple[Pose, Pose]:
    """Return the poses of a body that stands on a slope after 2 s and at the start."""
    with closing(world_on(settings, slope, friction)) as world:
        normal = (sin(slope), 0.0, cos(slope))
        turn = multiply(about((0.0, 1.0, 0.0), slope), about((0.0, 0.0, 1.0), yaw))
        start = Pose(scale(shape.reach((0.0, 0.0, -1.0)), normal), turn)
        world.add_brick(Brick("can", shape, 0.35), start)
        return played(world, "can", 2.0).pose, start


def least_slope(about_slope: float, gives_way: Callable[[float], bool]) -> float:
    """Return the least slope, to 0.2 %, on which a body gives way [rad]."""
    low, high = 0.7 * about_slope, 1.3 * about_slope
    while high - low > 2e-3 * about_slope:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if gives_way(middle) else (middle, high)
    return 0.5 * (low + high)


# Piles that stand: their largest shift in 2 s.


def _shifts(settings: EngineSettings) -> Iterator[tuple[str, float]]:
    yield "cans", shift(settings, PYRAMID)
    yield "logs", shift(settings, LOGS)
    yield "wedge", shift(settings, WEDGE)


Pile = dict[str, tuple[RoundSolid | Box, Pose]]
_LOG, _BLOCK = cylinder(0.1, 1.0), Box((0.2, 1.0, 0.15))
PYRAMID: Final[Pile] = {
    f"can {row}{place}": (CAN, Pose((0.067 * (place + 0.5 * row), 0.0, 0.115 * (row + 0.5))))
    for row in range(3)
    for place in range(3 - row)
}
LOGS: Final[Pile] = {
    "left": (_BLOCK, Pose((-0.3, 0.0, 0.075))),
    "right": (_BLOCK, Pose((0.3, 0.0, 0.075))),
    "log a": (_LOG, Pose((-0.1, 0.0, 0.1), LYING)),
    "log b": (_LOG, Pose((0.1, 0.0, 0.1), LYING)),
    "log c": (_LOG, Pose((0.0, 0.0, 0.1 + 0.1 * sqrt(3.0)), LYING)),
}
# Two boxes on edge, whose upper faces fall at 45 deg towards each other.
WEDGE: Final[Pile] = {
    "left": (Box((0.4, 1.0, 0.4)), Pose((-0.2 * sqrt(2.0), 0.0, 0.0), about((0.0, 1.0, 0.0), 0.25 * pi))),
    "right": (Box((0.4, 1.0, 0.4)), Pose((0.2 * sqrt(2.0), 0.0, 0.0), about((0.0, 1.0, 0.0), 0.25 * pi))),
    "log": (_LOG, Pose((0.0, 0.0, 0.1 * sqrt(2.0)), LYING)),
}


def shift(settings: EngineSettings, pile: Pile) -> float:
    """Return the largest shift of the round bodies of a pile in 2 s, without those of its start [m].

    Blocks are fixed. Engines whose contacts are springs let a pile sink in its first quarter of a second.
    """
    with closing(stepped_world(settings, GRAVITY, 0.5, 22.0)) as world:
        world.add_plane(Plane(GROUND, (0.0, 0.0, -9.0 if pile is WEDGE else 0.0), (0.0, 0.0, 1.0), 0.5))
        for name, (shape, pose) in pile.items():
            world.add_brick(Brick(name, shape, 22.0 if shape is _LOG else 0.35), pose)
            if isinstance(shape, Box):
                world.freeze(name)
        names = [name for name, (shape, _) in pile.items() if not isinstance(shape, Box)]
        played(world, names[0], 0.25)
        before = _places(world, names)
        played(world, names[0], 2.0)
        return max(dist(a, b) for a, b in zip(before, _places(world, names), strict=True))


def _places(world: World, names: list[str]) -> list[Vec3]:
    return [state.pose.position_W for state in world.states(names).values()]


if __name__ == "__main__":
    main()
