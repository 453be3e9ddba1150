"""Compares the fall of the slant tower: as a rigid body, in engines with every brick awake, on `exact` and `thesis`.

Run it with `python -m benchmarks.collapse`. Each tower is built to the height at which it falls. It lands when the
kinetic energy of the falling part is largest; reach is the horizontal displacement of its centre of mass until then.
Directions and proportions are compared with the motion of the proof when the tower has rotated by 5 deg.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import asin, cos, degrees, radians, sin, sqrt
from pathlib import Path
from statistics import median
from time import perf_counter

from rich.console import Console
from rich.table import Table

from benchmarks.figures.recording import parser, record
from stability.dynamics.onset import as_it_begins
from stability.dynamics.toppling import Turn, turn_of
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import World
from stability.geometry.box import as_box
from stability.geometry.vectors import cross, dot, norm, subtract, turn_between
from stability.model import BodyId, BodyState
from stability.problem import Motion, Placed, Problem
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer
from stability.statics.assembly import Assembly
from stackdsl.checking.cases import gather
from stackdsl.language.claims.onset_motion import largest_difference, seen_displacements, widest_angle
from stackdsl.simulation.measurements import kinetic_energy
from stackdsl.simulation.systems import HELD, MOVING, SYSTEMS, System
from stackdsl.simulation.worlds import extension_for
from stackdsl.timeline import Timeline
from stackdsl.trace import Onset

SCENARIO = Path(__file__).parent.parent / "scenarios" / "slant-tower.yaml"
# The brick at which each tower falls.
LAST = {
    "slant-tower": {"exact": "L7.2", "thesis": "L8.1"},
    "slant-tower-flush": {"exact": "L10.2", "thesis": "L11.1"},
}
STEPS = (960, 1920, 3840, 7680)  # per second
FOLLOWED, LOOK = 0.6, 1.0 / 960.0  # [s]; the latter is about the interval between samples
KEYS = ("slow_ms", "lands_ms", "reach_mm", "direction_deg", "proportions_percent", "energy_percent", "wall_s")
HALF, BEGUN = radians(15.0), radians(5.0)


@dataclass(frozen=True, slots=True)
class Fall:
    """Result of one run."""

    slow: float  # [s] until it had rotated by 15 deg
    reach: float  # [m]
    landed: float  # [s]
    direction: float  # largest error [rad]
    proportion: float  # largest error, of the brick with the largest displacement
    gain: float  # of energy, as a share of the initial energy
    cost: float  # [s of wall time]


def main() -> None:
    """Play and print the tables; write them on request."""
    write = parser(__doc__).parse_args().write
    tables: dict[str, dict[str, dict[str, float]]] = {}
    for case in gather([SCENARIO]).cases:
        if case.system != "exact":
            continue
        name, last = case.identity.scenario, LAST[case.identity.scenario]
        tower, taller = (up_to(case.timeline, last[system]) for system in ("exact", "thesis"))
        table = Table(name, "15 deg ms", "lands ms", "reach mm", "direction deg", "proportions %", "energy %", "wall s")
        due = rigid_time(tower, HALF)
        table.add_row("rigid body (closed form)", f"{1000.0 * due:.1f}", *[""] * 6)
        rows = tables[name] = {"rigid body": {"slow_ms": 1000.0 * due}}
        for settings, edges in ((HELD, "sharp"), (replace(MOVING, first_steps=0), "rounded")):
            for rate in STEPS:
                system = System("", "", replace(settings, time_step=1.0 / rate), method=None)
                rows[f"all awake, {edges} edges, {rate} steps a second"] = _values(fall(tower, system))
        rows["exact"] = _values(fall(tower, SYSTEMS["exact"]))
        rows["thesis"] = _values(fall(taller, SYSTEMS["thesis"]))
        reference = rows[f"all awake, sharp edges, {STEPS[-1]} steps a second"]
        rows["exact"] |= _beside(rows["exact"], due, reference)
        for each, row in list(rows.items())[1:]:
            table.add_row(each, *(f"{row[key]:.3g}" for key in KEYS))
        Console(width=140).print(table)
    if write:
        record("collapse", "python -m benchmarks.collapse --write", tables)


def _values(fall: Fall) -> dict[str, float]:
    """Return the values in the order of KEYS."""
    lengths = (1000.0 * fall.slow, 1000.0 * fall.landed, 1000.0 * fall.reach)
    shares = (degrees(fall.direction), 100.0 * fall.proportion, 100.0 * fall.gain, fall.cost)
    return dict(zip(KEYS, (*lengths, *shares), strict=True))


def _beside(own: Mapping[str, float], due: float, reference: Mapping[str, float]) -> dict[str, float]:
    """Return the error of `exact`: in time from the closed form, in reach from the finest run with all bricks awake."""
    return {
        "late_ms": own["slow_ms"] - 1000.0 * due,
        "reach_error_percent": 100.0 * abs(own["reach_mm"] / reference["reach_mm"] - 1.0),
    }


def up_to(timeline: Timeline, last: BodyId) -> Timeline:
    """Return the tower as high as it is when it falls, placed at once."""
    names = [placed.brick.id for placed in timeline.placements]
    kept = timeline.placements[: names.index(last) + 1]
    return replace(timeline, actions=tuple(replace(placed, time=0.0) for placed in kept))


def motion_of(timeline: Timeline) -> tuple[Problem, Motion]:
    """Return the problem of the tower and the motion with which it falls by statics."""
    scene = timeline.world
    assembly = Assembly(scene.planes, scene.friction, scene.gravity)
    verdict = as_it_begins(assembly, assembly.add_all(Placed(p.brick, p.pose) for p in timeline.placements))
    if verdict.motion is None:
        raise ValueError("this tower does not fall")
    return assembly.problem(verdict.moving), verdict.motion


def fall(timeline: Timeline, system: System) -> Fall:
    """Play the fall of a tower on a system."""
    started = perf_counter()
    interval, seen = seen_falling(timeline, system)
    return _summed_up(timeline, interval, seen, perf_counter() - started)


def seen_falling(
    timeline: Timeline, system: System, followed: float = FOLLOWED
) -> tuple[float, Sequence[Mapping[BodyId, BodyState]]]:
    """Return the states of all bricks of a tower that is placed at once, and the interval between them [s]."""
    scene = timeline.world
    world = stepped_world(system.engine, scene.gravity, scene.friction, timeline.placements[0].brick.mass)
    for plane in scene.planes:
        world.add_plane(plane)
    for placed in timeline.placements:
        world.add_brick(placed.brick, placed.pose)
    extension = extension_for(timeline, system, world)
    falling = FallingParts(world, scene.planes, scene.friction, scene.gravity)
    if extension is not None:
        _set_down(extension, falling, [placed.brick.id for placed in timeline.placements])
    every = max(1, round(LOOK / world.settings.time_step))
    seen = _stepped(world, extension, falling, followed, every)
    world.close()
    return every * world.settings.time_step, seen


def _set_down(extension: Stabilizer, falling: FallingParts, bricks: Sequence[BodyId]) -> None:
    extension.set_down(bricks)
    while (update := extension.update()).frozen or update.woken:
        verdict = extension.verdict()
        if update.failed and verdict is not None:
            falling.woken(extension.awake(), verdict.motion)


def _stepped(
    world: World, extension: Stabilizer | None, falling: FallingParts, followed: float, every: int
) -> list[Mapping[BodyId, BodyState]]:
    bricks = sorted(world.masses())
    seen = [world.states(bricks)]
    for step in range(round(followed / world.settings.time_step)):
        if not falling.advance(1):
            world.step()
            if extension is not None:
                extension.update()
        if (step + 1) % every == 0:
            seen.append(world.states(bricks))
            world.set_max_speed(max(norm(state.velocity_W) for state in seen[-1].values()))
    return seen


def _summed_up(timeline: Timeline, interval: float, seen: Sequence[Mapping[BodyId, BodyState]], cost: float) -> Fall:
    problem, motion = motion_of(timeline)
    bricks = {placed.brick.id: placed.brick for placed in timeline.placements}
    first = {name: placed.pose for name, placed in problem.bricks.items()}
    turns = [median(turn_between(first[name], states[name].pose) for name in first) for states in seen]
    kinetic = [sum(kinetic_energy(bricks[name], states[name]) for name in first) for states in seen]
    landed = max(range(len(seen)), key=kinetic.__getitem__)
    begun = next(n for n, turn in enumerate(turns) if turn >= BEGUN)
    onset = Onset(motion, {name: (pose, seen[begun][name].pose) for name, pose in first.items()}, ())
    pairs = seen_displacements(onset) or []
    mass = sum(bricks[name].mass for name in first)
    reach = sum(
        bricks[name].mass * (seen[landed][name].pose.position_W[0] - first[name].position_W[0]) for name in first
    )
    heights = [
        sum(brick.mass * timeline.world.gravity * states[name].pose.position_W[2] for name, brick in bricks.items())
        for states in seen
    ]
    moving = [sum(kinetic_energy(brick, states[name]) for name, brick in bricks.items()) for states in seen]
    most = max(height + energy for height, energy in zip(heights, moving, strict=True))
    return Fall(
        slow=interval * next(n for n, turn in enumerate(turns) if turn >= HALF),
        reach=reach / mass,
        landed=interval * landed,
        direction=widest_angle(pairs),
        proportion=largest_difference(pairs),
        gain=(most - heights[0]) / heights[0],
        cost=cost,
    )


def rigid_time(timeline: Timeline, angle: float) -> float:
    """Return the time the tower takes to rotate by an angle [rad] as one body: the integral of a pendulum [s]."""
    problem, motion = motion_of(timeline)
    turn = turn_of(problem, motion)
    if turn is None:
        raise ValueError("it does not turn as one body")
    inertia = sum(_about(turn, placed) for placed in problem.bricks.values())
    mass = sum(placed.brick.mass for placed in problem.bricks.values())
    levers = [(placed.brick.mass, subtract(placed.pose.position_W, turn.point_W)) for placed in problem.bricks.values()]
    x, z = (sum(m * lever[axis] for m, lever in levers) / mass for axis in (0, 2))
    parts = 20_000
    step = sqrt(angle) / parts
    time = 0.0
    for k in range(parts):
        u = (k + 0.5) * step  # with the rotation u^2 the integrand has no pole at the start
        lost = x * sin(u * u) + z * (1.0 - cos(u * u))
        time += 2.0 * u * step / sqrt(2.0 * timeline.world.gravity * mass * lost / inertia)
    return time


def _about(turn: Turn, placed: Placed) -> float:
    """Return the moment of inertia of a level plank about an axis parallel to one of its sides [kg m2]."""
    a, b, c = as_box(placed.brick.shape, "the converged fall").size
    across = b if abs(2.0 * asin(placed.pose.orientation[2])) > 1.0 else a  # its side across the axis, along x
    arm = cross(turn.axis_W, subtract(placed.pose.position_W, turn.point_W))
    return placed.brick.mass * ((across * across + c * c) / 12.0 + dot(arm, arm))


if __name__ == "__main__":
    main()
