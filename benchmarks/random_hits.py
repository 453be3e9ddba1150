"""Compares random hits at random towers on `exact` with references at small steps: shifts, and how many bricks fall.

A plank is thrown at the long side of a plank: at a random turn of the scene and of the plank, height, aim and speed.
The references are the engine of this project at small steps with every brick awake, and Moreau's impact law
(`benchmarks.moreau`), which is independent code. Where both shifts of the hit plank agree within 3 %, that of `exact`
must do so too. Run it with `python -m benchmarks.random_hits`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import radians
from random import Random

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks import turned_hits
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.hits import DISTANCE, GRAVITY
from benchmarks.moreau.motion import Boxes, shifts_by_throw
from benchmarks.movers import AGREE, CONVERGED, sooner
from benchmarks.plank_structures import THICKNESS
from benchmarks.turned_hits import FRICTION, UP, TurnedHit
from stability.geometry.vectors import about, add, rotate
from stability.model import Vec3
from stability.problem import Placed
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS, System
from stackdsl.trace import BrickState

SEEDS = range(4100, 4130)
LONGEST = 0.6  # [s] of the impact law


@dataclass(frozen=True, slots=True)
class RandomHit(TurnedHit):
    """Plank thrown at the long side of a plank of any odd level, also beside its middle."""

    level: int = 1
    aside: float = 0.0  # [m]

    @property
    def struck(self) -> int:
        return 2 * self.level - 1

    def thrown(self) -> tuple[Placed, Vec3]:
        shot, velocity_W = TurnedHit.thrown(self)
        moved = rotate(about(UP, radians(self.scene)), (self.aside, 0.0, (self.level - self.levels) * THICKNESS))
        return replace(shot, pose=replace(shot.pose, position_W=add(shot.pose.position_W, moved))), velocity_W


def hit(seed: int) -> RandomHit:
    """Return a random hit."""
    chance = Random(seed)
    levels = chance.choice((5, 7, 9, 11))
    return RandomHit(
        turn=chance.uniform(-90.0, 90.0),
        speed=0.5 * 8.0 ** chance.random(),
        above=chance.choice((-1.0, 1.0)) * chance.uniform(2e-4, 3e-3),
        levels=levels,
        scene=chance.uniform(0.0, 360.0),
        level=chance.choice(range(3, levels + 1, 2)),
        aside=chance.uniform(-0.04, 0.04),
    )


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a hit."""

    shift: float  # of the hit plank [m]
    fallen: int


def played(one: RandomHit, system: System) -> Outcome:
    """Play a hit on a system."""
    tracks = list(play(sooner(turned_hits.timeline(one)), system).tracks.values())
    return Outcome(tracks[one.struck].shift, sum(each.state is BrickState.FALLEN for each in tracks))


def by_impact_law(one: RandomHit, steps: int) -> Outcome:
    """Return the result of Moreau's impact law at a number of steps per second."""
    tower, (shot, velocity_W) = one.tower(), one.thrown()
    boxes = Boxes([*tower, shot], GRAVITY, FRICTION)
    began = boxes.places[:-1, 2].copy()
    shifts = shifts_by_throw(boxes, velocity_W, DISTANCE / one.speed, steps, LONGEST)
    return Outcome(float(shifts[one.struck]), int(np.count_nonzero(began - boxes.places[:-1, 2] > 0.5 * THICKNESS)))


def compared(one: RandomHit, steps: int) -> Row:
    """Compare one hit."""
    exact, fine = played(one, SYSTEMS["exact"]), played(one, CONVERGED["rigid"])
    law = by_impact_law(one, steps)
    pair = sorted((fine.shift, law.shift))
    converges = pair[1] <= (1.0 + AGREE) * pair[0]
    middle = 0.5 * sum(pair)
    return {
        "turn": one.turn,
        "speed": one.speed,
        "level": one.level,
        "levels": one.levels,
        "exact_mm": 1000.0 * exact.shift,
        "fine_mm": 1000.0 * fine.shift,
        "law_mm": 1000.0 * law.shift,
        "converges": converges,
        "error_percent": 100.0 * (exact.shift / middle - 1.0) if converges else None,
        "exact_fallen": exact.fallen,
        "fine_fallen": fine.fallen,
        "law_fallen": law.fallen,
    }


def summary(rows: Mapping[str, Row]) -> Row:
    """Return how many hits agree."""
    errors = [abs(float(row["error_percent"])) for row in rows.values() if row["error_percent"] is not None]
    return {
        "hits": len(rows),
        "converge": len(errors),
        "within": sum(error <= 100.0 * AGREE for error in errors),
        "worst_percent": max(errors, default=None),
        "same_fallen": sum(row["exact_fallen"] == row["fine_fallen"] for row in rows.values()),
    }


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--steps", type=int, default=4000, help="of the impact law, a second")
    chosen = arguments.parse_args()
    progress = Console(stderr=True, width=150)
    rows: dict[str, Row] = {}
    for seed in track(SEEDS, "hits", console=progress):
        rows[f"{seed}"] = row = compared(hit(seed), chosen.steps)
        progress.print(seed, " ".join(f"{key} {value:.4g}" if value is not None else key for key, value in row.items()))
    table = Table(*next(iter(rows.values())))
    for row in rows.values():
        table.add_row(*("-" if cell is None else f"{cell:.4g}" for cell in row.values()))
    found = summary(rows)
    Console(width=150).print(table, found)
    if chosen.write:
        record("random-hits", "python -m benchmarks.random_hits --write", {"hits": rows, "all": {"all": found}})


if __name__ == "__main__":
    main()
