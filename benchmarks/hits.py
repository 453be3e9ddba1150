"""Compares hits on `exact` with the same tower with every plank awake at a converged step: error and cost.

The throws are those of `benchmarks.impacts`, from 10 mm away at a standing tower, followed for a second. Run it with
`python -m benchmarks.hits`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.impacts import FROM_SIDE, LEVELS, NOTABLE, SHOT, TURNED, Throw
from benchmarks.plank_structures import LENGTH, THICKNESS, four_stack
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, SYSTEMS, System
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline
from stackdsl.trace import Trace

GRAVITY, DISTANCE, THROWN_AT, WATCHED = 9.81, 0.01, 0.2, 1.0  # [m/s2], [m], [s], [s]


def timeline(throw: Throw) -> Timeline:
    """Return the timeline of a standing tower and a plank thrown at the long side of one of its planks."""
    tower = four_stack(2 * LEVELS)
    placed = [Placement(0.0, one.brick, number // 2 + 1, one.pose) for number, one in enumerate(tower)]
    pose = Pose((0.0, LENGTH + DISTANCE, (throw.level - 0.5) * THICKNESS), TURNED)
    rise = 0.5 * GRAVITY * DISTANCE / throw.speed  # gravity brings the plank to its height at arrival
    shot = Placement(
        THROWN_AT,
        Brick(SHOT, tower[0].brick.shape, tower[0].brick.mass),
        0,
        pose,
        velocity_W=(0.0, -throw.speed, rise),
        arrival=Arrival.THROWN,
    )
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    return Timeline(FixedWorld(GRAVITY, 0.5, (ground,)), (*placed, shot), hold=WATCHED)


def shifts(trace: Trace) -> list[float]:
    """Return the shift of each plank of the tower [m], in the order of building."""
    return [track.shift for name, track in trace.tracks.items() if name != SHOT]


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--steps", type=int, nargs="+", default=[1920, 3840], help="of the reference, a second")
    arguments.add_argument("--speeds", type=float, nargs="+", default=[1.0, 2.0, 4.0], help="of the plank [m/s]")
    arguments.add_argument("--levels", type=int, nargs="+", default=[3, LEVELS], help="that are hit; odd ones")
    chosen = arguments.parse_args()
    awake = [
        System(f"awake 1/{steps} s", "every plank awake", replace(MOVING, time_step=1.0 / steps, first_steps=0), None)
        for steps in chosen.steps
    ]
    play(timeline(Throw(LEVELS, FROM_SIDE, 1.0)), SYSTEMS["exact"])  # so that imports count for no row
    table = Table("level", "m/s", "steps a second", "hit mm", "> 5 mm", "largest mm", "one by one", "steps", "s")
    found: dict[str, Row] = {}
    for level, speed in product(chosen.levels, chosen.speeds):
        throw = Throw(level, FROM_SIDE, speed)
        rows = [measured(throw, play(timeline(throw), system)) for system in (SYSTEMS["exact"], *awake)]
        for system, row in zip(("exact", *chosen.steps), rows, strict=True):
            found[f"level {level}, {speed:g} m per s, {system}"] = row
            table.add_row(f"{level}", f"{speed:g}", f"{system}", *(f"{value:.4g}" for value in row.values()))
        found[f"level {level}, {speed:g} m per s"] = compared(level, speed, rows)
    Console(width=110).print(table)
    if chosen.write:
        record("hits", "python -m benchmarks.hits --write", {"runs": found, "all": {"worst": worst(found)}})


def measured(throw: Throw, trace: Trace) -> dict[str, float]:
    """Return the figures of one run."""
    moved = shifts(trace)
    return {
        "hit_mm": 1000.0 * moved[throw.hit],
        "notable": sum(shift > NOTABLE for shift in moved),
        "largest_mm": 1000.0 * max(moved),
        "one_by_one": trace.cost.one_by_one,
        "steps": trace.cost.steps,
        "wall_s": trace.cost.wall_time,
    }


def compared(level: int, speed: float, runs: Sequence[Mapping[str, float]]) -> Row:
    """Compare `exact`, the first run, with the finest run, which is the last."""
    own, reference = runs[0], runs[-1]
    return {
        "level": level,
        "speed": speed,
        "exact_mm": own["hit_mm"],
        "coarse_mm": runs[1]["hit_mm"],
        "fine_mm": reference["hit_mm"],
        "exact_notable": own["notable"],
        "fine_notable": reference["notable"],
        "one_by_one": own["one_by_one"],
        "error_percent": 100.0 * (own["hit_mm"] / reference["hit_mm"] - 1.0),
        "coarse_times_dearer": runs[1]["wall_s"] / own["wall_s"],
        "fine_times_dearer": reference["wall_s"] / own["wall_s"],
    }


def worst(rows: Rows) -> Row:
    """Return the largest error of all hits, and the range of the cost ratio of the finest runs."""
    found = [row for row in rows.values() if "error_percent" in row]
    dearer = [float(row["fine_times_dearer"] or 0.0) for row in found]
    return {
        "error_percent": max(abs(float(row["error_percent"] or 0.0)) for row in found),
        "least_times_dearer": min(dearer),
        "most_times_dearer": max(dearer),
        "same_planks": all(row["exact_notable"] == row["fine_notable"] for row in found),
    }


if __name__ == "__main__":
    main()
