"""Hits under `exact` against the same tower with every plank awake at a converged step: how far off, and at what cost.

The same throws as in `benchmarks.impacts`, from 10 mm away at a tower that stands, followed for a second. Run it with
`python -m benchmarks.hits`.
"""

import argparse
from dataclasses import replace
from itertools import product

from rich.console import Console
from rich.table import Table

from benchmarks.impacts import FROM_SIDE, LEVELS, NOTABLE, SHOT, TURNED, Throw
from benchmarks.plank_structures import LENGTH, THICKNESS, four_stack
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.playing.runner import play
from stackdsl.systems.systems import MOVING, SYSTEMS, System
from stackdsl.timeline import Placement, Timeline, World
from stackdsl.trace import Trace

GRAVITY, DISTANCE, THROWN_AT, WATCHED = 9.81, 0.01, 0.2, 1.0  # [m/s2], [m], [s], [s]


def timeline(throw: Throw) -> Timeline:
    """A tower that stands, and the plank that comes onto the long side of one of its planks."""
    tower = four_stack(2 * LEVELS)
    placed = [Placement(0.0, one.brick, number // 2 + 1, one.pose) for number, one in enumerate(tower)]
    pose = Pose((0.0, LENGTH + DISTANCE, (throw.level - 0.5) * THICKNESS), TURNED)
    rise = 0.5 * GRAVITY * DISTANCE / throw.speed  # brings it back to its height when it arrives
    shot = Placement(
        THROWN_AT,
        Brick(SHOT, tower[0].brick.shape, tower[0].brick.mass),
        0,
        pose,
        velocity_W=(0.0, -throw.speed, rise),
        thrown=True,
    )
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    return Timeline(World(GRAVITY, 0.5, (ground,)), (*placed, shot), hold=WATCHED)


def shifts(trace: Trace) -> list[float]:
    """How far each plank of the tower has moved [m], in order of building."""
    return [track.shift for name, track in trace.tracks.items() if name != SHOT]


def main() -> None:
    """Play, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, nargs="+", default=[1920, 3840], help="of the reference, a second")
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.0, 2.0, 4.0], help="of the plank [m/s]")
    parser.add_argument("--levels", type=int, nargs="+", default=[3, LEVELS], help="that are hit; odd ones")
    chosen = parser.parse_args()
    awake = [
        System(f"awake 1/{steps} s", "every plank awake", replace(MOVING, time_step=1.0 / steps, first_steps=0), None)
        for steps in chosen.steps
    ]
    play(timeline(Throw(LEVELS, FROM_SIDE, 1.0)), SYSTEMS["exact"])  # so that no row pays for what the first one loads
    table = Table("level", "m/s", "system", "hit mm", "> 5 mm", "largest mm", "one by one", "steps", "s")
    for level, speed in product(chosen.levels, chosen.speeds):
        throw = Throw(level, FROM_SIDE, speed)
        for system in (SYSTEMS["exact"], *awake):
            table.add_row(*_row(throw, system, play(timeline(throw), system)))
    Console(width=110).print(table)


def _row(throw: Throw, system: System, trace: Trace) -> list[str]:
    moved = shifts(trace)
    return [
        f"{throw.level}",
        f"{throw.speed:g}",
        system.name,
        f"{1000.0 * moved[throw.hit]:.2f}",
        f"{sum(shift > NOTABLE for shift in moved)}",
        f"{1000.0 * max(moved):.1f}",
        f"{trace.cost.one_by_one}",
        f"{trace.cost.steps}",
        f"{trace.cost.wall_time:.2f}",
    ]


if __name__ == "__main__":
    main()
