"""Compares falls in several parts on `exact` with rigid boxes in an independent time stepper, for the first 5 degrees.

The cases are two stacks at once, a V that opens, and a bridge without a pier. Errors are those of the time until a body
has rotated by 5 deg, of the directions of displacement until then, and of the distances, relative to the largest one.
Run it with `python -m benchmarks.falls_in_parts`.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import acos, degrees, radians

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.leaning_slips import boxes, needed_friction, placed, seen
from benchmarks.leaning_structures import GROUND, Array, Bar, Rng, Structure, askew_v, plank, structure, unlike_v
from benchmarks.rigid_steps import course
from stability.geometry.vectors import turn_between
from stackdsl.simulation.systems import SYSTEMS, System

BEGUN = radians(5.0)
STEPS = (5e-5, 2.5e-5)  # [s] of the reference: longer steps have not converged if a body lands on the way
LONGEST = 1.0  # [s]
WOOD, TOO_LITTLE = 0.5, 0.8  # friction, and the share of the required friction that a leaning structure has
GOES = 0.05  # share of the largest displacement: smaller ones have no direction


def lying(rng: Rng, name: str, size: Sequence[float], x: float, bottom: float) -> Bar:
    """Return a level box with its middle at x."""
    bar = replace(plank(rng, name, 0.0), size=np.array(size))
    mass = float(np.prod(bar.size) * rng.uniform(400.0, 900.0))
    return replace(bar, mass=mass, centre=np.array([x, 0.0, bottom + 0.5 * size[2]]))


def stack(rng: Rng, name: str, x: float, along: float) -> list[Bar]:
    """Return three planks of which the upper two tip over the end of the lowest."""
    size = [float(rng.uniform(0.08, 0.13)), float(rng.uniform(0.02, 0.03)), float(rng.uniform(0.012, 0.018))]
    steps = [0.0, rng.uniform(0.35, 0.45) * size[0], rng.uniform(0.7, 0.8) * size[0]]
    return [lying(rng, f"{name}{n}", size, x + along * step, n * size[2]) for n, step in enumerate(steps)]


def two_stacks(rng: Rng) -> Structure | None:
    """Return two stacks, far apart, that tip in opposite directions."""
    bars = [*stack(rng, "west", -1.0, -1.0), *stack(rng, "east", 1.0, 1.0)]
    return Structure("two stacks at once", 0, bars, [GROUND])


def bridge(rng: Rng) -> Structure | None:
    """Return a deck of two loaded spans on the remaining piers; the pier in the middle is missing."""
    bars = []
    for name, side in (("west", -1.0), ("east", 1.0)):
        high, span = float(rng.uniform(0.05, 0.08)), float(rng.uniform(0.10, 0.13))
        pier = float(rng.uniform(0.03, 0.035))
        bars.append(lying(rng, f"{name} pier", [pier, 0.03, high], side * span, 0.0))
        bars.append(lying(rng, f"{name} span", [span, 0.024, 0.008], side * 0.51 * span, high))
        bars.append(lying(rng, f"{name} load", [0.02, 0.02, 0.02], side * 0.3 * span, high + 0.008))
    return Structure("bridge without its pier", 0, bars, [GROUND])


FAMILIES: Sequence[Callable[[Rng], Structure | None]] = (two_stacks, bridge, unlike_v, askew_v)


def ways(positions: Array, starts: Array) -> Array:
    """Return (n, 3) displacements [m]."""
    return positions - starts


def compared(now: Array, due: Array) -> tuple[float, float]:
    """Return the largest error of a direction [rad], and of a distance as a share of the longest."""
    far = np.linalg.norm(due, axis=1)
    near = np.linalg.norm(now, axis=1)
    first = int(np.argmax(far))
    apart = [
        acos(max(-1.0, min(1.0, float(a @ b) / (x * y))))
        for a, b, x, y in zip(now, due, near, far, strict=True)
        if y > GOES * far[first] and x > 0.0
    ]
    return max(apart), float(np.abs(near / near[first] - far / far[first]).max())


def at_begun(time: Array, turned: Array, position: Array) -> tuple[float, Array]:
    """Return the time at which a body has rotated by 5 deg [s], and the positions at this time."""
    most = np.maximum.accumulate(turned.max(axis=1))
    moment = float(np.interp(BEGUN, most, time))
    where = [[np.interp(moment, time, position[:, i, k]) for k in range(3)] for i in range(position.shape[1])]
    return moment, np.array(where)


def errors(falling: Structure, friction: float, system: System) -> Row | None:
    """Return the errors of one fall; None if no body rotates by 5 deg."""
    starts = np.array([bar.centre for bar in falling.bars])
    runs = [course(boxes(falling, friction), step, LONGEST, turned=1.05 * BEGUN) for step in STEPS]
    if any(run.turned.max() < BEGUN for run in runs):
        return None
    coarse, fine = (at_begun(run.time, run.turned, run.position) for run in runs)
    due, due_ways = 2.0 * fine[0] - coarse[0], ways(fine[1], starts)
    time, turned, position = [0.0], [np.zeros(len(starts))], [starts]
    before = {one.brick.id: one.pose for one in placed(falling)}
    for now, states in seen(falling, friction, system):
        time.append(now)
        turned.append(np.array([turn_between(pose, states[name].pose) for name, pose in before.items()]))
        position.append(np.array([states[name].pose.position_W for name in before]))
        if turned[-1].max() > BEGUN or now > 3.0 * due:
            break
    moment, where = at_begun(np.array(time), np.array(turned), np.array(position))
    direction, share = compared(ways(where, starts), due_ways)
    return {
        "due_ms": 1e3 * due,
        "late_percent": 100.0 * (moment / due - 1.0),
        "direction_deg": degrees(direction),
        "proportions_percent": 100.0 * share,
        "reference_apart_percent": 100.0 * abs(due / fine[0] - 1.0),
    }


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--each", type=int, default=5, help="how many of each family")
    chosen = arguments.parse_args()
    table = Table("", "5 deg after ms", "late %", "direction deg", "proportions %", "reference apart %")
    rows: dict[str, Row] = {}
    for family in FAMILIES:
        for number in range(chosen.each):
            falling = structure(family, number)
            needed = needed_friction(falling)
            friction = WOOD if needed is None else TOO_LITTLE * needed
            row = errors(falling, friction, SYSTEMS["exact"])
            if row is None:
                continue
            rows[f"{falling.family}, {number}"] = row
            table.add_row(f"{falling.family}, {number}", *(f"{value:.3g}" for value in row.values()))
    Console(width=140).print(table)
    if chosen.write:
        record("falls-in-parts", "python -m benchmarks.falls_in_parts --write", {"falls": rows})


if __name__ == "__main__":
    main()
