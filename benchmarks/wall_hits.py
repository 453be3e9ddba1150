"""Measures hits in the middle of walls on `exact`: cost, error, and the time of an engine for the same hits.

A plank below n courses carries n weights and passes on n + 1, half to either side. Pushed out of the wall at a speed v
it comes to rest after v^2 / (2 mu g (2 n + 1)). Hit by a plank of equal mass it gets half its speed, and both come to
rest after v^2 / (4 mu g (2 n + 1)). That plank is half as thick as the others, so that it touches no other plank. Run
it with `python -m benchmarks.wall_hits`; a peer steps every plank for a short time, which is scaled up.
"""

from collections.abc import Sequence
from time import perf_counter

from rich.console import Console
from rich.table import Table

from benchmarks.figures.recording import parser, record
from benchmarks.impacts import SHOT, TURNED
from stability.engines.lazy_world import stepped_world
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.language.layouts.wall import WallParams, wall
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.simulation.worlds import settings_for
from stackdsl.timeline import Arrival, FixedWorld, Placement, PushAction, Timeline
from stackdsl.trace import Trace

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)  # [m]
MASS, FRICTION, GRAVITY, DISTANCE = 0.012, 0.5, 9.81, 0.001  # [kg], Coulomb, [m/s2], [m]
HIT_AT, WATCHED = 0.2, 1.0  # [s]
WALLS = ((40, 20, 20), (100, 50, 50), (100, 199, 50))  # courses, planks of a course, the course that is hit


def placed(courses: int, abreast: int) -> list[Placement]:
    """Return a wall that stands from the start."""
    found, numbers = [], dict.fromkeys(range(1, courses + 1), 0)
    for spec in wall(WallParams(levels=courses, bricks=abreast), SIZE):
        size, share = spec.size or SIZE, 1.0 if spec.size is None else spec.size[0] / LENGTH
        numbers[spec.level] += 1
        brick = Brick(f"L{spec.level}.{numbers[spec.level]}", Box(size), share * MASS)
        found.append(Placement(0.0, brick, spec.level, Pose(spec.position)))
    return found


def middle_of(course: int, bricks: Sequence[Placement]) -> Placement:
    """Return the plank of a course nearest to the middle of the wall."""
    whole = [one for one in bricks if one.level == course and one.brick.mass == MASS]
    return min(whole, key=lambda one: abs(one.pose.position_W[0]))


def pushed(bricks: Sequence[Placement], target: Placement, speed: float) -> Timeline:
    """Return the timeline in which the target gets a speed."""
    return _timeline(bricks, PushAction(HIT_AT, target.brick.id, (0.0, -speed * MASS, 0.0)))


def thrown_at(bricks: Sequence[Placement], target: Placement, speed: float) -> Timeline:
    """Return the timeline in which a plank hits the target end-on."""
    x, y, z = target.pose.position_W
    start = Pose((x, y + 0.5 * (WIDTH + LENGTH) + DISTANCE, z), TURNED)
    rise = 0.5 * GRAVITY * DISTANCE / speed  # gravity brings the plank to its height at arrival
    thin = Brick(SHOT, Box((LENGTH, WIDTH, 0.5 * THICKNESS)), MASS)
    return _timeline(bricks, Placement(HIT_AT, thin, 0, start, Arrival.THROWN, (0.0, -speed, rise)))


def _timeline(bricks: Sequence[Placement], hit: PushAction | Placement) -> Timeline:
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION)
    return Timeline(FixedWorld(GRAVITY, FRICTION, (ground,)), (*bricks, hit), hold=WATCHED)


def way_mm(above: int, speed: float, bodies: int) -> float:
    """Return the displacement of bodies of equal mass stopped by the friction of one, below `above` courses [mm]."""
    return 1000.0 * bodies * speed**2 / (2.0 * FRICTION * GRAVITY * (2 * above + 1))


def measured(trace: Trace, target: Placement, truth_mm: float) -> dict[str, float]:
    """Return the figures of a run, and the closed form."""
    hit_mm = 1000.0 * trace.tracks[target.brick.id].shift
    others = [track.shift for name, track in trace.tracks.items() if name not in (SHOT, target.brick.id)]
    return {
        "hit_mm": hit_mm,
        "truth_mm": truth_mm,
        "error_percent": 100.0 * (hit_mm / truth_mm - 1.0),
        "others_mm": 1000.0 * max(others),
        "one_by_one": trace.cost.one_by_one,
        "wall_s": trace.cost.wall_time,
    }


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--walls", type=int, default=len(WALLS), help="how many of the walls, the smallest first")
    arguments.add_argument("--peer", default="sapien", help="the engine that steps every plank")
    arguments.add_argument("--peer-steps", type=int, default=50, help="that it takes; the time is scaled up")
    chosen = arguments.parse_args()
    table = Table(
        "planks", "hit", "mm", "closed form", "others mm", "one by one", "s", f"all awake on {chosen.peer}, s"
    )
    rows: dict[str, dict[str, float]] = {}
    for courses, abreast, course in WALLS[: chosen.walls]:
        bricks = placed(courses, abreast)
        target = middle_of(course, bricks)
        runs = {
            "pushed to 2 m/s": (pushed(bricks, target, 2.0), way_mm(courses - course, 2.0, 1)),
            "hit at 4 m/s": (thrown_at(bricks, target, 4.0), way_mm(courses - course, 2.0, 2)),
        }
        for name, (timeline, truth) in runs.items():
            trace, peer_s = play(timeline, SYSTEMS["exact"]), peer_seconds(timeline, chosen.peer, chosen.peer_steps)
            row = {**measured(trace, target, truth), "peer_s": peer_s, "times_faster": peer_s / trace.cost.wall_time}
            rows[f"{len(bricks)} planks, {name}"] = row
            shown = (row[key] for key in ("hit_mm", "truth_mm", "others_mm", "one_by_one", "wall_s", "peer_s"))
            table.add_row(f"{len(bricks)}", name, *(f"{value:.4g}" for value in shown))
    Console(width=120).print(table)
    if chosen.write:
        worst = {
            "error_percent": max(abs(row["error_percent"]) for row in rows.values()),
            "least_times_faster": min(row["times_faster"] for row in rows.values()),
        }
        record("wall-hits", "python -m benchmarks.wall_hits --write", {"runs": rows, "all": {"worst": worst}})


def peer_seconds(timeline: Timeline, peer: str, steps: int) -> float:
    """Return the time of stepping every plank of a wall for the duration of `exact` [s], scaled up from a few steps."""
    system, scene = system_named(peer), timeline.world
    world = stepped_world(settings_for(timeline, system), scene.gravity, scene.friction, MASS)
    try:
        for plane in scene.planes:
            world.add_plane(plane)
        for one in timeline.placements:
            world.add_brick(one.brick, one.pose, one.velocity_W)
        world.step()  # the first step creates engine data
        started = perf_counter()
        for _ in range(steps):
            world.step()
        return (perf_counter() - started) / steps * (HIT_AT + WATCHED) / world.settings.time_step
    finally:
        world.close()


if __name__ == "__main__":
    main()
