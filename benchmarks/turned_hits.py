"""Compares thrown planks rotated about the vertical, from end-on to broadside, on `exact` and under Moreau's law.

The aim is the middle of the long side of the second plank of the top level of a four-stack, which is flush with the
ends of the planks below. So a level throw hits these as well, or misses them narrowly; 0.5 mm higher it misses them for
certain. Run it with `python -m benchmarks.turned_hits`.
"""

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.hits import DISTANCE, GRAVITY, THROWN_AT, WATCHED
from benchmarks.impacts import SHOT
from benchmarks.moreau.motion import Boxes, shifts_by_throw
from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH, four_stack
from stability.geometry.vectors import about, multiply, rotate
from stability.model import GROUND, Plane, Pose, Vec3
from stability.problem import Placed
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline

FRICTION, CLEAR = 0.5, 5e-4  # [m] above level
UP = (0.0, 0.0, 1.0)
TURNS, SPEEDS = (90.0, 85.0, 60.0, 45.0, 0.0), (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)  # [deg], [m/s]


@dataclass(frozen=True, slots=True)
class TurnedHit:
    """Plank thrown at the long side of the plank of the top level that lies at y > 0."""

    turn: float  # [deg] about the vertical: 0 comes end-on, 90 broadside
    speed: float  # [m/s]
    above: float = CLEAR  # [m] height above the middle of its target
    levels: int = 7  # odd, so that the planks of the top level lie along x
    scene: float = 0.0  # [deg] rotation of the whole scene about the vertical

    @property
    def struck(self) -> int:
        """Return the index of the struck plank."""
        return 2 * self.levels - 1

    def tower(self) -> list[Placed]:
        """Return the standing planks."""
        return [replace(one, pose=self._in_scene(one.pose)) for one in four_stack(2 * self.levels)]

    def thrown(self) -> tuple[Placed, Vec3]:
        """Return the plank and its velocity, which rises so that gravity brings the plank to its height at arrival."""
        yaw = 0.5 * pi + radians(self.turn)
        nose = 0.5 * LENGTH * abs(sin(yaw)) + 0.5 * WIDTH * abs(cos(yaw))
        at = (0.0, 0.5 * LENGTH + DISTANCE + nose, (self.levels - 0.5) * THICKNESS + self.above)
        one = replace(four_stack(1)[0].brick, id=SHOT)
        way = (0.0, -self.speed, 0.5 * GRAVITY * DISTANCE / self.speed)
        return Placed(one, self._in_scene(Pose(at, about(UP, yaw)))), rotate(self._turned, way)

    @property
    def _turned(self) -> tuple[float, float, float, float]:
        return about(UP, radians(self.scene))

    def _in_scene(self, pose: Pose) -> Pose:
        return Pose(rotate(self._turned, pose.position_W), multiply(self._turned, pose.orientation))


def timeline(hit: TurnedHit) -> Timeline:
    """Return the timeline of a standing tower and the throw."""
    placed = [Placement(0.0, one.brick, number // 2 + 1, one.pose) for number, one in enumerate(hit.tower())]
    shot, velocity_W = hit.thrown()
    thrown = Placement(THROWN_AT, shot.brick, 0, shot.pose, velocity_W=velocity_W, arrival=Arrival.THROWN)
    ground = Plane(GROUND, (0.0, 0.0, 0.0), UP, FRICTION)
    return Timeline(FixedWorld(GRAVITY, FRICTION, (ground,)), (*placed, thrown), hold=WATCHED)


def of_exact(hit: TurnedHit) -> float:
    """Return the shift of the struck plank on `exact` [m]."""
    tracks = list(play(timeline(hit), SYSTEMS["exact"]).tracks.values())
    return tracks[hit.struck].shift


def by_impact_law(hit: TurnedHit, steps: int) -> float:
    """Return the shift of the struck plank by Moreau's impact law [m], at a number of steps per second."""
    shot, velocity_W = hit.thrown()
    boxes = Boxes([*hit.tower(), shot], GRAVITY, FRICTION)
    return float(shifts_by_throw(boxes, velocity_W, DISTANCE / hit.speed, steps)[hit.struck])


def compared(hit: TurnedHit, steps: int) -> Row:
    """Compare one hit."""
    exact, fine = of_exact(hit), by_impact_law(hit, steps)
    return {
        "turn": hit.turn,
        "speed": hit.speed,
        "reference_mm": 1000.0 * fine,
        "exact_mm": 1000.0 * exact,
        "error_percent": 100.0 * (exact / fine - 1.0),
    }


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--steps", type=int, default=16000, help="of the reference, a second")
    chosen = arguments.parse_args()
    hits = [TurnedHit(turn, speed) for turn in TURNS for speed in SPEEDS]
    found = {
        f"turn {hit.turn:g}, {hit.speed:g} m per s": compared(hit, chosen.steps)
        for hit in track(hits, "hits", console=Console(stderr=True))
    }
    table = Table(*next(iter(found.values())))
    for row in found.values():
        table.add_row(*(f"{cell:.4g}" for cell in row.values()))
    Console(width=110).print(table)
    if chosen.write:
        worst = {"worst_percent": max(abs(float(row["error_percent"] or 0.0)) for row in found.values())}
        record("turned-hits", "python -m benchmarks.turned_hits --write", {"hits": found, "all": {"all": worst}})


if __name__ == "__main__":
    main()
