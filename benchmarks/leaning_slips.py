"""Compares slips of random leaning structures on `exact` with rigid boxes in an independent time stepper.

Each structure has a random share of the friction that it needs by statics, and starts at rest. Errors are those of the
time until a corner of any plank has moved by 5, 10, 20 mm. Run it with `python -m benchmarks.leaning_slips`; it stores
finished cases in a file, and continues from there.
"""

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from math import inf, isfinite
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.leaning_structures import LEANING, Array, Structure, quaternion, structure
from benchmarks.rigid_steps import Boxes, Course, course
from benchmarks.slips import _step
from stability.engines.protocol import World
from stability.geometry.box import Box
from stability.geometry.placed_shape import corners_W
from stability.geometry.vectors import norm, subtract
from stability.model import BodyId, BodyState, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Stability
from stability.stabilizers.known_motion import FallingParts
from stability.statics.assembly import Assembly
from stackdsl.simulation.systems import SYSTEMS, System
from stackdsl.simulation.worlds import extension_for, opened_world
from stackdsl.timeline import FixedWorld, Placement, Timeline

WAYS = (0.005, 0.010, 0.020)  # [m]
# [s] of the reference: steps are halved until two successive results agree to this share, at every distance.
STEPS, AGREE = (4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5), 0.002
GRAVITY = 9.81  # [m/s2]
LONGEST = 0.8  # [s] a structure with less displacement by then does not count
# [s] duration of the check that a structure with slightly more friction stays; its largest displacement in it [mm].
STAYS, STIRS_MM = 0.02, 0.001
MOST_FRICTION, CLOSE = 3.0, 1e-4  # a structure that needs more does not count; accuracy of the required friction
WANTED = 3.0  # [%] of a time
SHARES = (0.5, 0.99)  # of the required friction


def vec(values: Array) -> Vec3:
    """Return an array as a vector of the package."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def placed(leaning: Structure) -> list[Placed]:
    """Return the bricks of a structure."""
    return [
        Placed(Brick(bar.name, Box(vec(bar.size)), bar.mass), Pose(vec(bar.centre), quaternion(bar.turn)))
        for bar in leaning.bars
    ]


def planes(leaning: Structure, friction: float) -> tuple[Plane, ...]:
    """Return the planes that a structure stands on and leans against."""
    return tuple(
        Plane(wall.name, vec(wall.point), vec(wall.normal), friction if wall.friction is None else wall.friction)
        for wall in leaning.walls
    )


def stands(leaning: Structure, friction: float) -> Stability:
    """Return the verdict of statics."""
    return Assembly(planes(leaning, friction), friction, GRAVITY).add_all(placed(leaning)).stability


def needed_friction(leaning: Structure) -> float | None:
    """Return the least friction with which a structure stands; None if it never or always does."""
    low, high = 0.0, MOST_FRICTION
    if stands(leaning, high) is not Stability.STABLE or stands(leaning, low) is Stability.STABLE:
        return None
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(leaning, middle) is Stability.STABLE else (middle, high)
    return high


def boxes(leaning: Structure, friction: float) -> Boxes:
    """Return the structure for the reference."""
    walls = leaning.walls
    return Boxes(
        0.5 * np.array([bar.size for bar in leaning.bars]),
        np.array([bar.mass for bar in leaning.bars]),
        np.array([bar.centre for bar in leaning.bars]),
        np.array([bar.turn for bar in leaning.bars]),
        np.array([wall.point for wall in walls]),
        np.array([wall.normal for wall in walls]),
        np.array([friction if wall.friction is None else wall.friction for wall in walls]),
        friction,
        GRAVITY,
    )


def reached(time: Array, moved: Array) -> list[float]:
    """Return the time of each displacement [s]; infinite if it is not reached."""
    farthest = np.maximum.accumulate(moved.max(axis=1))
    return [float(np.interp(way, farthest, time)) if farthest[-1] >= way else inf for way in WAYS]


class Truth(NamedTuple):
    """Result of the reference."""

    due: list[float]  # times of the displacements, extrapolated from the last two steps [s]; infinite if not reached
    # relative differences of the last two steps; infinite if only one of them reaches the displacement
    apart: list[float]
    step: float  # the last one [s]
    unsettled: int  # steps whose impulses did not converge


def reference(leaning: Structure, friction: float) -> Truth:
    """Return the times of the displacements, with steps halved until they converge."""
    coarse, unsettled = [inf] * len(WAYS), 0
    for step in STEPS:
        run: Course = course(boxes(leaning, friction), step, LONGEST, 1.02 * WAYS[-1])
        fine, unsettled = reached(run.time, run.moved), unsettled + run.unsettled
        both = list(zip(coarse, fine, strict=True))
        apart = [0.0 if a == b else abs(1.0 - a / b) if isfinite(a) and isfinite(b) else inf for a, b in both]
        if step != STEPS[0] and max(apart) <= AGREE:
            break
        coarse = fine
    due = [2.0 * b - a if isfinite(a) and isfinite(b) else b for a, b in both]
    return Truth(due, apart, step, unsettled)


def timeline(leaning: Structure, friction: float) -> Timeline:
    """Return the timeline of a structure."""
    placements = (Placement(0.0, one.brick, 1, one.pose) for one in placed(leaning))
    return Timeline(FixedWorld(GRAVITY, friction, planes(leaning, friction)), tuple(placements), hold=1.0)


def seen(leaning: Structure, friction: float, system: System) -> Iterator[tuple[float, Mapping[BodyId, BodyState]]]:
    """Yield time [s] and all states after every step on a system."""
    scene = timeline(leaning, friction)
    world: World = opened_world(scene, system)
    try:
        for one in scene.placements:
            world.add_brick(one.brick, one.pose)
        extension = extension_for(scene, system, world)
        falling = FallingParts(world, scene.world.planes, friction, GRAVITY)
        if extension is not None:
            extension.set_down([one.brick.id for one in scene.placements])
            extension.update()
            verdict = extension.verdict()
            if not extension.awake():
                return
            falling.woken(extension.awake(), verdict.motion if verdict else None)
        names = [one.brick.id for one in scene.placements]
        while True:
            _step(world, extension, falling)
            yield world.time(), world.states(names)
    finally:
        world.close()


def played(leaning: Structure, friction: float, system: System, until: float) -> list[float]:
    """Return the times of the displacements [s]."""
    starts = {one.brick.id: (one, corners_W(one.brick.shape, one.pose)) for one in placed(leaning)}
    time, moved = [0.0], [[0.0]]
    for now, states in seen(leaning, friction, system):
        far = max(
            norm(subtract(after, before))
            for name, (one, corners) in starts.items()
            for before, after in zip(corners, corners_W(one.brick.shape, states[name].pose), strict=True)
        )
        time.append(now)
        moved.append([far])
        if far > WAYS[-1] or now > until:
            break
    return reached(np.array(time), np.array(moved))


def case(leaning: Structure, system: System) -> dict[str, Any] | None:
    """Return the figures of a structure; None if it does not slip for lack of friction."""
    needed = needed_friction(leaning)
    if needed is None:
        return None
    share = float(np.random.default_rng([leaning.number, *leaning.family.encode()]).uniform(*SHARES))
    friction = share * needed
    started = process_time()
    truth = reference(leaning, friction)
    stays = course(boxes(leaning, 1.01 * needed), STEPS[0], STAYS)
    referred = process_time() - started
    if not isfinite(truth.due[0]):
        return None
    times = played(leaning, friction, system, LONGEST)
    certain = [apart <= 0.01 * WANTED for apart in truth.apart]
    return {
        "family": leaning.family,
        "number": leaning.number,
        "share": share,
        "needed": needed,
        "due": truth.due,
        "apart": truth.apart,
        "step": truth.step,
        "unsettled": truth.unsettled,
        "stays_mm": 1e3 * float(stays.moved.max()),
        "times": times,
        "errors": [_error(*pair) if sure else None for *pair, sure in zip(times, truth.due, certain, strict=True)],
        "reference_s": referred,
        "played_s": process_time() - started - referred,
    }


def _error(time: float, due: float) -> float | None:
    """Return the relative error of a time; infinite if only one of both exists, None if neither does."""
    if isfinite(time) and isfinite(due):
        return time / due - 1.0
    return None if time == due else inf


def cases(numbers: Sequence[int], system: System, keep: Path | None) -> Iterator[dict[str, Any]]:
    """Yield the cases of all families in turn; those in a file are not computed again."""
    rows = [json.loads(line) for line in keep.read_text().splitlines()] if keep and keep.exists() else []
    done = {(row["family"], row["number"]) for row in rows}
    yield from rows
    for number in numbers:
        for family in LEANING:
            leaning, tried = structure(family, number), number
            if (leaning.family, number) in done:
                continue
            while (row := case(leaning, system)) is None:
                tried += 1000
                leaning = structure(family, tried)
            row |= {"number": number, "tried": tried}
            if keep:
                with keep.open("a") as file:
                    file.write(json.dumps(row) + "\n")
            yield row


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--each", type=int, default=25, help="how many of each family")
    arguments.add_argument("--system", default="exact")
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    steps = cases(range(chosen.each), SYSTEMS[chosen.system], chosen.keep)
    rows = list(track(steps, "slips", len(LEANING) * chosen.each, console=Console(stderr=True), transient=True))
    by_family = defaultdict(list)
    for row in rows:
        by_family[row["family"]].append(row)
    by_family["all"] = rows
    heads = ("", "cases", "times judged", "without truth", "median %", "worst %", "over 3 %")
    table = Table(*heads)
    figures: dict[str, Row] = {}
    for family, rows in by_family.items():
        figures[family] = values(rows)
        table.add_row(family, *(f"{value:.3g}" for value in list(figures[family].values())[: len(heads) - 1]))
    Console(width=140).print(table)
    if chosen.write:
        record("leaning-slips", "python -m benchmarks.leaning_slips --write", {chosen.system: figures})


def values(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the figures of some cases for the table."""
    errors = [[100.0 * abs(error) for error in row["errors"] if error is not None] for row in rows]
    times = [error for each in errors for error in each]
    return {
        "cases": len(rows),
        "times": len(times),
        "without_truth": sum(apart > 0.01 * WANTED for row in rows for apart in row["apart"]),
        "median_percent": median(times),
        "worst_percent": max(times),
        "over_3_percent": sum(max(each, default=0.0) > WANTED for each in errors),
        "reference_apart_percent": max(100.0 * a for row in rows for a in row["apart"] if a <= 0.01 * WANTED),
        "reference_step_us": 1e6 * min(row["step"] for row in rows),
        "moves_with_more": sum(row["stays_mm"] > STIRS_MM for row in rows),
    }


if __name__ == "__main__":
    main()
