"""Computes reference values of impacts: a plank thrown at a four-stack of 13 levels, with every plank awake.

It shows to which values the steps converge, from which side, and with or without friction anchors. Run it with `python
-m benchmarks.impacts`; `--steps 960 1920` and the like make it shorter.
"""

import argparse
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from math import dist
from time import perf_counter

from rich.console import Console
from rich.table import Table

from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH, four_stack
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.vectors import norm
from stability.model import GROUND, BodyId, Brick, Plane, Pose
from stability.problem import Placed
from stackdsl.simulation.systems import MOVING

LEVELS = 13
WATCHED = 1.0  # [s] after the throw
NEARLY = 0.001  # [m] between the nose of the thrown plank and its target
NOTABLE = 0.005  # [m] smallest shift that counts
SHOT = "shot"
TURNED = (0.0, 0.0, 0.5**0.5, 0.5**0.5)
FROM_END, FROM_SIDE = 0, 90  # [deg] bearing: onto the end of a plank that lies along x, or onto its long side


@dataclass(frozen=True, slots=True)
class Throw:
    """Plank thrown end-on at a level whose planks lie along x."""

    level: int
    bearing: int  # [deg] direction of origin
    speed: float  # [m/s]

    @property
    def hit(self) -> int:
        """Return the index of the target plank: the second of its level."""
        return 2 * self.level - 1


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a throw."""

    hit: float  # [m] shift of the struck plank
    displaced: int  # number of planks with a shift of more than 5 mm
    largest: float  # [m]
    standing: int  # planks that are still within half a thickness of their height
    drift: float  # [m] largest creep of a plank of an untouched tower in the same time
    wall: float  # [s]


def thrown(throw: Throw) -> Pose:
    """Return the pose of the plank at release: its nose just before the middle of its target, at its height."""
    away, height = 0.5 * LENGTH + NEARLY, (throw.level - 0.5) * THICKNESS
    aside = 0.5 * (LENGTH - WIDTH)
    if throw.bearing == FROM_END:
        return Pose((0.5 * LENGTH + away, aside, height))
    return Pose((0.0, 0.5 * LENGTH + away, height), TURNED)


def played(settings: PyBulletSettings, tower: Iterable[Placed], throw: Throw | None) -> dict[BodyId, Pose]:
    """Return all poses a while after the throw."""
    tower = list(tower)
    world = PyBulletWorld.opened(settings, 9.81, friction=0.5, heaviest=tower[0].brick.mass)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    for placed in tower:
        world.add_brick(placed.brick, placed.pose)
    if throw is not None:
        way = (-throw.speed, 0.0, 0.0) if throw.bearing == FROM_END else (0.0, -throw.speed, 0.0)
        world.add_brick(Brick(SHOT, tower[0].brick.shape, tower[0].brick.mass), thrown(throw), way)
    for _ in range(round(WATCHED / settings.time_step)):
        fastest = max(norm(state.velocity_W) for state in world.states(world.masses()).values())
        world.set_max_speed(fastest)
        world.step()
    poses = {name: state.pose for name, state in world.states(world.masses()).items()}
    world.close()
    return poses


def outcome(settings: PyBulletSettings, throw: Throw, drift: float) -> Outcome:
    """Play a throw and return its result."""
    tower = four_stack(2 * LEVELS)
    began = perf_counter()
    after = played(settings, tower, throw)
    wall = perf_counter() - began
    shifts = [dist(after[placed.brick.id].position_W, placed.pose.position_W) for placed in tower]
    sunk = [placed.pose.position_W[2] - after[placed.brick.id].position_W[2] for placed in tower]
    return Outcome(
        shifts[throw.hit],
        sum(shift > NOTABLE for shift in shifts),
        max(shifts),
        sum(abs(sink) < 0.5 * THICKNESS for sink in sunk),
        drift,
        wall,
    )


def creep(settings: PyBulletSettings) -> float:
    """Return the largest displacement of a plank of the tower without a hit [m]."""
    tower = four_stack(2 * LEVELS)
    after = played(settings, tower, None)
    return max(dist(after[placed.brick.id].position_W, placed.pose.position_W) for placed in tower)


def main() -> None:
    """Play and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, nargs="+", default=[960, 1920, 3840], help="steps a second")
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.0, 2.0, 4.0, 8.0], help="of the plank [m/s]")
    parser.add_argument("--levels", type=int, nargs="+", default=[3, LEVELS], help="that are hit; odd ones")
    parser.add_argument("--anchors", action="store_true", help="also with friction anchors")
    chosen = parser.parse_args()
    table = Table(
        "level", "from", "m/s", "anchor", "1/dt", "hit mm", "> 5 mm", "largest mm", "standing", "creep mm", "s"
    )
    console = Console(width=120)
    for anchor, steps in product([False, True] if chosen.anchors else [False], chosen.steps):
        settings = replace(MOVING, time_step=1.0 / steps, friction_anchor=anchor)
        drift = creep(settings)
        for throw in (Throw(*one) for one in product(chosen.levels, (FROM_END, FROM_SIDE), chosen.speeds)):
            table.add_row(*_row(throw, settings, outcome(settings, throw, drift)))
    console.print(table)


def _row(throw: Throw, settings: PyBulletSettings, outcome: Outcome) -> list[str]:
    return [
        f"{throw.level}",
        f"{throw.bearing}",
        f"{throw.speed:g}",
        "yes" if settings.friction_anchor else "no",
        f"{1.0 / settings.time_step:.0f}",
        f"{1000.0 * outcome.hit:.1f}",
        f"{outcome.displaced}",
        f"{1000.0 * outcome.largest:.0f}",
        f"{outcome.standing}",
        f"{1000.0 * outcome.drift:.2f}",
        f"{outcome.wall:.2f}",
    ]


if __name__ == "__main__":
    main()
