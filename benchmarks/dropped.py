"""What it costs to let planks go at once, in layers of 25 askew: with what the extension knows, and without.

They fall onto each other from two centimetres, tumble, and are watched for two seconds. Nothing there adds energy, so
that beside the seconds of one core is what was gained. Run it with `python -m benchmarks.dropped`; 1,000 planks take
some minutes on each system. `--keep` is a file of rows, which is gone on with.
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
SIDE = 5  # planks of a layer along each side of it
APART, ABOVE = 0.125, 0.015  # from plank to plank, and from layer to layer [m]
LOWEST = 0.026  # [m] of centres
ASIDE = 0.002  # [m] at most, of a plank from its place
ROLL = 0.05  # [rad] at most
WATCHED = 2.0  # [s]
COUNTS = (250, 500, 1000)


def let_go(count: int) -> Timeline:
    """So many planks in the air, each turned about the vertical as it may be, and a little about itself."""
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
    """Let them fall, once."""
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
    """What a file of rows holds, by name."""
    lines = keep.read_text().splitlines() if keep is not None and keep.exists() else []
    rows: list[tuple[str, Row]] = [json.loads(line) for line in lines]
    return dict(rows)


def main() -> None:
    """Let them fall, print the table, and keep it if asked to."""
    arguments = parser(__doc__)
    arguments.add_argument("--planks", nargs="+", type=int, default=list(COUNTS))
    arguments.add_argument("--systems", nargs="+", default=["exact", "tuned"])
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    found = kept(chosen.keep)
    asked = {f"{system}, {count}": (system, count) for count in chosen.planks for system in chosen.systems}
    for name in track([name for name in asked if name not in found], "dropped", console=Console(stderr=True)):
        play(let_go(1), SYSTEMS[asked[name][0]])  # so that no run is charged for what it is the first to import
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
