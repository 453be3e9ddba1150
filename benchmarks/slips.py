"""Compares slipping and sliding planks with the equations of motion: time, speed and cost.

A plank that leans on a smooth wall, two that lean on each other, and one on a slope have slightly less friction than
they need, and start at rest. Errors are those of the time at which the foot has moved by 5, 10, 20 mm, and of its speed
then. Run it with `python -m benchmarks.slips`.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from math import cos, hypot, inf, radians, sin, tan
from statistics import median
from time import perf_counter

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.slipping import Leaning, needed_friction, slides, slip, time_to_slide
from stability.engines.protocol import World
from stability.geometry.box import Box
from stability.geometry.vectors import about, add, cross, dot, multiply, rotate, scale, subtract
from stability.model import GROUND, BodyState, Brick, Plane, Pose, Vec3
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer
from stackdsl.simulation.systems import MOVING, SYSTEMS, System
from stackdsl.simulation.worlds import extension_for, opened_world
from stackdsl.timeline import FixedWorld, Placement, Timeline

KAPLA: Vec3 = (0.1176, 0.0234, 0.0078)  # [m]
MASS, GRAVITY = 0.012, 9.81  # [kg], [m/s2]
WAYS = (0.005, 0.010, 0.020)  # [m]
SHARES = (0.99, 0.97, 0.90, 0.50)  # of the required friction
SHARE_KEYS = tuple(f"missing_{100.0 * (1.0 - share):.0f}_percent" for share in SHARES)
ANGLES = {"ladder": (50.0, 60.0, 70.0), "V": (50.0, 60.0, 70.0), "slope": (26.6, 45.0)}  # to the floor [deg]
YAWS = (0.0, 10.0, 30.0, 45.0, 75.0)  # of the whole scene about the vertical [deg]
PARTS = (1.0, 0.5, 0.25)  # of a system's own step
FINE = System("all awake, 1/7680 s", "", replace(MOVING, time_step=1.0 / 7680.0, first_steps=0), method=None)
PATIENCE = 3.0  # times the correct time: a foot that has not arrived by then is stuck
LOOK = 0.01  # [s] as the runner samples moving bricks, for the speed that determines the steps


@dataclass(frozen=True, slots=True)
class Case:
    """Slipping or sliding scene."""

    kind: str  # ladder, V, slope
    angle: float  # to the floor [deg]
    share: float  # of the friction that would hold it
    yaw: float = 0.0  # [deg]
    size: Vec3 = KAPLA  # of a plank [m]

    @property
    def friction(self) -> float:
        angle, (length, _, thickness) = radians(self.angle), self.size
        needed = tan(angle) if self.kind == "slope" else needed_friction(length, thickness, angle)
        return self.share * needed

    def truth(self, way: float) -> tuple[float, float]:
        """Return the time [s] and the speed [m/s] at a displacement [m]."""
        return _truth(self.kind, radians(self.angle), self.friction, self.size, way)


@lru_cache(maxsize=4096)  # shared by rotations and systems
def _truth(kind: str, angle: float, friction: float, size: Vec3, way: float) -> tuple[float, float]:
    if kind == "slope":
        time = time_to_slide(way, angle, friction, GRAVITY)
        return time, slides(angle, friction, time, GRAVITY)[1]
    down = slip(Leaning(size[0], size[2], angle, friction, gravity=GRAVITY))
    time = down.time_to(way)
    return time, down.speed(time) if time < inf else inf


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of a run."""

    case: Case
    time: float  # the largest, as a share; infinite if it got stuck
    speed: float
    cost: float  # [s of wall time]


def towards(yaw: float) -> Vec3:
    """Return the horizontal direction in which a case slips or leans, for a rotation [rad]."""
    return (cos(yaw), sin(yaw), 0.0)


def leaning_pose(size: Vec3, angle: float, side: float, yaw: float) -> Pose:
    """Return the pose of a plank that leans over the origin [rad] with an edge on the ground.

    It leans from behind for a `side` of -1, and from the front for 1.
    """
    length, _, thickness = size
    out = 0.5 * side * (length * cos(angle) + thickness * sin(angle))
    up = 0.5 * (length * sin(angle) + thickness * cos(angle))
    turn = multiply(about((0.0, 0.0, 1.0), yaw), about((0.0, 1.0, 0.0), side * angle))
    return Pose((out * cos(yaw), out * sin(yaw), up), turn)


def timeline(case: Case) -> Timeline:
    """Return the scene of a case."""
    angle, yaw = radians(case.angle), radians(case.yaw)
    if case.kind == "slope":
        ux, uy, _ = towards(yaw)
        normal_W = (sin(angle) * ux, sin(angle) * uy, cos(angle))
        planes = [Plane(GROUND, (0.0, 0.0, 0.0), normal_W, case.friction)]
        poses = {"left": Pose(scale(0.5 * case.size[2], normal_W), about((-uy, ux, 0.0), angle))}
    else:
        planes = [Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), case.friction)]
        poses = {"left": leaning_pose(case.size, angle, -1.0, yaw)}
        if case.kind == "V":
            poses["right"] = leaning_pose(case.size, angle, 1.0, yaw)
        else:
            planes.append(Plane("wall", (0.0, 0.0, 0.0), scale(-1.0, towards(yaw)), 0.0))
    placed = (Placement(0.0, Brick(name, Box(case.size), MASS), 1, pose) for name, pose in poses.items())
    return Timeline(FixedWorld(GRAVITY, case.friction, tuple(planes)), tuple(placed), hold=1.0)


def seen_motion(case: Case, system: System) -> Iterator[tuple[float, float, float]]:
    """Yield time [s], displacement [m] and speed [m/s] of the foot after every step on a system."""
    scene = timeline(case)
    world = opened_world(scene, system)
    try:
        for placed in scene.placements:
            world.add_brick(placed.brick, placed.pose)
        extension = extension_for(scene, system, world)
        falling = FallingParts(world, scene.world.planes, scene.world.friction, scene.world.gravity)
        if extension is not None:
            _set_down(extension, falling, [placed.brick.id for placed in scene.placements])
        foot = _Foot(case, world.states(["left"])["left"])
        while True:
            _step(world, extension, falling)
            yield world.time(), *foot.seen(world.states(["left"])["left"])
    finally:
        world.close()


def _set_down(extension: Stabilizer, falling: FallingParts, bricks: Sequence[str]) -> None:
    extension.set_down(bricks)
    update, verdict = extension.update(), extension.verdict()
    if not update.failed or verdict is None:
        raise ValueError("this stands")
    falling.woken(extension.awake(), verdict.motion)


def _step(world: World, extension: Stabilizer | None, falling: FallingParts) -> None:
    states: Mapping[str, BodyState] = world.states(sorted(world.masses()))
    fastest = max(hypot(*state.velocity_W) for state in states.values())
    world.set_max_speed(fastest + LOOK * GRAVITY)
    if extension is not None and falling.advance(1):
        return
    world.step()
    if extension is not None:
        extension.update()


class _Foot:
    """Edge on the ground of the plank that comes from behind, or the middle of one on a slope."""

    def __init__(self, case: Case, start: BodyState) -> None:
        length, _, thickness = case.size
        yaw, angle = radians(case.yaw), radians(case.angle)
        self.point_B: Vec3 = (-0.5 * length, 0.0, -0.5 * thickness)
        self.way_W = scale(-1.0, towards(yaw))
        if case.kind == "slope":
            self.point_B = (0.0, 0.0, 0.0)
            self.way_W = (cos(angle) * cos(yaw), cos(angle) * sin(yaw), -sin(angle))
        self.start_W = self._at(start)

    def _arm(self, state: BodyState) -> Vec3:
        return rotate(state.pose.orientation, self.point_B)

    def _at(self, state: BodyState) -> Vec3:
        return add(state.pose.position_W, self._arm(state))

    def seen(self, state: BodyState) -> tuple[float, float]:
        """Return the displacement [m] and the speed [m/s]."""
        velocity_W = add(state.velocity_W, cross(state.angular_velocity_W, self._arm(state)))
        return dot(subtract(self._at(state), self.start_W), self.way_W), dot(velocity_W, self.way_W)


def passed(case: Case, system: System, ways: Iterable[float] = WAYS) -> Iterator[tuple[float, float]]:
    """Yield the time [s] and the speed [m/s] at each of these displacements [m] that is reached."""
    left = [way for way in ways if case.truth(way)[0] < inf]
    latest = PATIENCE * case.truth(left[-1])[0]
    last = (0.0, 0.0, 0.0)
    for now in seen_motion(case, system):
        while left and now[1] >= left[0]:
            share = (left.pop(0) - last[1]) / (now[1] - last[1])
            yield last[0] + share * (now[0] - last[0]), last[2] + share * (now[2] - last[2])
        if not left or now[0] > latest:
            return
        last = now


def errors(case: Case, system: System) -> Errors:
    """Return the errors of a case on a system."""
    due = [truth for truth in map(case.truth, WAYS) if truth[0] < inf]
    started = perf_counter()
    arrivals = list(passed(case, system))
    cost = perf_counter() - started
    if len(arrivals) < len(due):
        return Errors(case, inf, inf, cost)
    late, fast = (
        max((now[which] / then[which] - 1.0 for now, then in zip(arrivals, due, strict=True)), key=abs)
        for which in (0, 1)
    )
    return Errors(case, late, fast, cost)


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--parts", type=float, nargs="+", default=PARTS, help="of a system's own step")
    arguments.add_argument("--kinds", nargs="+", default=list(ANGLES), choices=list(ANGLES))
    chosen = arguments.parse_args()
    errors(Case("V", 60.0, 0.5), SYSTEMS["exact"])  # so that imports count for no row
    rows = list(product(chosen.kinds, ("exact", "tuned"), chosen.parts))
    fine = {kind: _cost([errors(case, FINE) for case in _cases(kind) if case.yaw == 0.0]) for kind in chosen.kinds}
    headings = (f"{100.0 * (1.0 - share):.0f} % too little" for share in SHARES)
    table = Table("", "system", "step", *headings, "median", "speed", "stuck", "cost of 1/7680 s")
    errors_by_case: dict[str, Row] = {}
    for kind, name, part in track(rows, "slips", console=Console(stderr=True), transient=True):
        system = SYSTEMS[name].at_step(part)
        results = [errors(case, system) for case in _cases(kind)]
        cost = _cost([one for one in results if one.case.yaw == 0.0])
        row = {**_values(results), "times_dearer": fine[kind] / cost}
        errors_by_case[f"{kind}, {name}, step x {part:g}"] = row
        shown = (row["stuck"], f"{row['times_dearer']:.1f}")
        percents = [_percent(row[key]) for key in (*SHARE_KEYS, "median_percent", "speed_percent")]
        table.add_row(kind, name, f"1/{1.0 / system.engine.time_step:.0f} s", *percents, *(str(one) for one in shown))
    Console(width=140).print("Largest errors of time, of speed, over all angles and yaws; cost: times as dear.", table)
    if chosen.write:
        record("slips", "python -m benchmarks.slips --write", {"errors": errors_by_case})


def _cases(kind: str) -> list[Case]:
    return [Case(kind, *which) for which in product(ANGLES[kind], SHARES, YAWS)]


def _cost(results: Sequence[Errors]) -> float:
    return sum(one.cost for one in results)


def _values(results: Sequence[Errors]) -> dict[str, float | None]:
    """Return the largest errors [%] by the lack of friction, and over all; None if nothing arrived."""
    arrived = [one for one in results if one.time < inf]
    by_share = [[one.time for one in arrived if one.case.share == share] for share in SHARES]
    return {
        **{key: _largest(times) for key, times in zip(SHARE_KEYS, by_share, strict=True)},
        "median_percent": 100.0 * median(abs(one.time) for one in arrived) if arrived else None,
        "speed_percent": _largest([one.speed for one in arrived]),
        "largest_percent": _largest([abs(one.time) for one in arrived]),
        "stuck": len(results) - len(arrived),
        "cases": len(results),
    }


def _largest(shares: Sequence[float]) -> float | None:
    return 100.0 * max(shares, key=abs) if shares else None


def _percent(value: float | None) -> str:
    return "" if value is None else f"{value:+.2f} %"


if __name__ == "__main__":
    main()
