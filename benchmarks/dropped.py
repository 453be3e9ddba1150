"""Measures the cost of dropping planks at once, in layers of 25 askew, with and without the extension's known motions.

They fall onto each other from two centimetres, tumble, and are followed for two seconds. Nothing adds energy to them,
so the energy gain is shown next to the seconds of one core. Run it with `python -m benchmarks.dropped`; 1,000 planks
take some minutes on each system. `--keep` names a file of rows; finished rows are not run again.
"""

import json
from math import cos, pi, sin
from pathlib import Path
from random import Random
from time import process_time
from typing import Any

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Quaternion
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline

FRICTION = 0.5
SCENE = FixedWorld(9.81, FRICTION, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),))
PLANK, MASS = Box((0.1176, 0.0234, 0.0078)), 0.012  # [m], [kg]
SIDE = 5  # planks along each side of a layer
APART, ABOVE = 0.125, 0.015  # distance of planks, and of layers [m]
LOWEST = 0.026  # [m] of centres
ASIDE = 0.002  # [m] largest displacement of a plank
ROLL = 0.05  # [rad] at most
WATCHED = 2.0  # [s]
COUNTS = (250, 500, 1000)


def let_go(count: int) -> Timeline:
    """Return planks in the air, each rotated about the vertical and slightly about itself."""
    random = Random(7)
    planks = [_plank(random, number) for number in range(count)]
    return Timeline(SCENE, tuple(planks), WATCHED)


def _plank(random: Random, number: int) -> Placement:
    layer, place = divmod(number, SIDE * SIDE)
    row, column = divmod(place, SIDE)
    half_turn, half_roll = 0.5 * random.uniform(0.0, pi), 0.5 * random.uniform(-ROLL, ROLL)
    x, y = (APART * (at - (SIDE - 1) / 2.0) + random.uniform(-ASIDE, ASIDE) for at in (row, column))
    # About its own long side first, then about the vertical.
    turned: Quaternion = (
        sin(half_roll) * cos(half_turn),
        sin(half_roll) * sin(half_turn),
        cos(half_roll) * sin(half_turn),
        cos(half_roll) * cos(half_turn),
    )
    brick = Brick(f"L{layer + 1}.{place}", PLANK, MASS)
    return Placement(0.0, brick, layer + 1, Pose((x, y, LOWEST + layer * ABOVE), turned), Arrival.DROPPED)


def measured(system: str, count: int) -> Row:
    """Play one drop."""
    timeline = let_go(count)
    started = process_time()
    trace = play(timeline, SYSTEMS[system])
    return {
        "planks": count,
        "seconds": process_time() - started,
        "steps": trace.cost.steps,
        "gain_percent": 100.0 * trace.energy.gain if trace.energy is not None else 0.0,
    }


def kept(keep: Path | None) -> dict[str, Row]:
    """Return the rows of a file, by name."""
    lines = keep.read_text().splitlines() if keep is not None and keep.exists() else []
    rows: list[tuple[str, Row]] = [json.loads(line) for line in lines]
    return dict(rows)


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--planks", nargs="+", type=int, default=list(COUNTS))
    arguments.add_argument("--systems", nargs="+", default=["exact", "tuned"])
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    found = kept(chosen.keep)
    asked = {f"{system}, {count}": (system, count) for count in chosen.planks for system in chosen.systems}
    for name in track([name for name in asked if name not in found], "dropped", console=Console(stderr=True)):
        play(let_go(1), SYSTEMS[asked[name][0]])  # so that the time of imports counts for no run
        found[name] = measured(*asked[name])
        if chosen.keep is not None:
            with chosen.keep.open("a") as file:
                file.write(json.dumps([name, found[name]]) + "\n")
    rows: dict[str, Any] = {name: found[name] for name in asked}
    table = Table("", "planks", "s of one core", "steps", "energy gained %")
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.3g}" for value in row.values()))
    Console().print(table)
    if chosen.write:
        record("dropped", "python -m benchmarks.dropped --write", {"heaps": rows})


if __name__ == "__main__":
    main()
