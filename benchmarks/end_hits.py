"""Compares hits onto the ends of planks on `exact` with rigid boxes under Moreau's impact law, and with SAPIEN.

A plank is thrown onto the end of a plank of level 3 of a tower of 13, from 10 mm away: also with an eccentric aim,
askew, and so high or low that it hits the plank below or above as well. The reference (`benchmarks.moreau`) is
independent code. Each hit is also played with the aim moved up and down by 50 micrometres: if that changes the shift by
more than 10 %, the hit is sensitive, and no value is right. The steps of the reference are halved until two successive
results agree to 3 %, which gentle hits need. Run it with `python -m benchmarks.end_hits`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, inf, pi, sin
from random import Random

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.hits import GRAVITY, THROWN_AT, WATCHED, shifts
from benchmarks.impacts import LEVELS, SHOT
from benchmarks.moreau.motion import Boxes, shifts_by_throw
from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH, four_stack
from stability.geometry.vectors import about
from stability.model import GROUND, Plane, Pose, Vec3
from stability.problem import Placed
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS, System
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline

LEVEL, STRUCK, DISTANCE, FRICTION = 3, 5, 0.01, 0.5
AIM_MOVED = 5e-5  # [m] up and down, to detect sensitive hits
SENSITIVE = 0.1  # share of a shift
WANTED = 10.0  # [%] accepted error of `exact`
AGREED, FINEST = 0.03, 32000  # share of a shift, and largest number of steps per second of the reference
PEER_STEP = 1.0 / 7680.0  # [s]


def fine_peer() -> System:
    """Return SAPIEN, from plugins/stackdsl-sapien, with every plank awake."""
    peer = system_named("sapien")
    return replace(peer, engine=replace(peer.engine, time_step=PEER_STEP))


@dataclass(frozen=True, slots=True)
class EndHit:
    """Plank thrown at the end of a plank."""

    speed: float  # [m/s]
    aside: float = 0.0  # [m] horizontal distance of the aim from the middle of the end
    above: float = 0.0  # [m] vertical distance likewise
    askew: float = 0.0  # [rad] rotation about the vertical, of the plank and of its velocity

    def thrown(self) -> tuple[Placed, Vec3]:
        """Return the plank and its velocity, which rises so that gravity brings the plank to its height at arrival."""
        one = four_stack(1)[0].brick
        way = (-cos(self.askew), -sin(self.askew))
        aim = (0.5 * LENGTH, 0.5 * (LENGTH - WIDTH) + self.aside)
        back = DISTANCE + 0.5 * LENGTH + 0.5 * WIDTH * abs(sin(self.askew))
        at = (aim[0] - back * way[0], aim[1] - back * way[1], (LEVEL - 0.5) * THICKNESS + self.above)
        rise = 0.5 * GRAVITY * DISTANCE / (self.speed * cos(self.askew))
        pose = Pose(at, about((0.0, 0.0, 1.0), self.askew))
        return Placed(replace(one, id=SHOT), pose), (self.speed * way[0], self.speed * way[1], rise)


def cases(random: int) -> Iterator[tuple[str, EndHit]]:
    """Yield almost level hits, exactly level ones, and random ones."""
    for speed in (1.0, 2.0, 4.0):
        yield f"level, {speed:g} m per s", EndHit(speed)
        for above in (-2e-3, -2e-4, 2e-4, 2e-3):
            yield f"{1000.0 * above:+g} mm, {speed:g} m per s", EndHit(speed, above=above)
    chance = Random(13)
    for number in range(1, random + 1):
        above = chance.choice((-1.0, 1.0)) * chance.uniform(0.2e-3, 3e-3)
        speed = 0.2 * 20.0 ** chance.random()
        aside, askew = chance.uniform(-8e-3, 8e-3), chance.uniform(-10.0, 10.0) * pi / 180.0
        yield f"random {number}", EndHit(speed, aside, above, askew)


def timeline(hit: EndHit) -> Timeline:
    """Return the timeline of the tower and the throw."""
    tower = four_stack(2 * LEVELS)
    placed = [Placement(0.0, one.brick, number // 2 + 1, one.pose) for number, one in enumerate(tower)]
    thrown, velocity_W = hit.thrown()
    shot = Placement(THROWN_AT, thrown.brick, 0, thrown.pose, velocity_W=velocity_W, arrival=Arrival.THROWN)
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION)
    return Timeline(FixedWorld(GRAVITY, FRICTION, (ground,)), (*placed, shot), hold=WATCHED)


def referred(hit: EndHit, steps: int) -> float:
    """Return the shift of the struck plank by the reference [m], at a number of steps per second."""
    thrown, velocity_W = hit.thrown()
    boxes = Boxes([*four_stack(2 * LEVELS), thrown], GRAVITY, FRICTION)
    return float(shifts_by_throw(boxes, velocity_W, DISTANCE / hit.speed, steps)[STRUCK])


def compared(hit: EndHit, steps: int, peer: bool) -> Row:
    """Return one hit: `exact`, the reference at two or more step sizes, two nearby aims, and the peer."""
    coarse, fine = referred(hit, steps // 2), referred(hit, steps)
    while abs(coarse - fine) > AGREED * fine and steps < FINEST:
        steps *= 2
        coarse, fine = fine, referred(hit, steps)
    beside = [referred(replace(hit, above=hit.above + by), steps // 2) for by in (-AIM_MOVED, AIM_MOVED)]
    spread = max(abs(one / coarse - 1.0) for one in beside) if coarse > 0.0 else inf
    exact = shifts(play(timeline(hit), SYSTEMS["exact"]))[STRUCK]
    other = shifts(play(timeline(hit), fine_peer()))[STRUCK] if peer else None
    return {
        "speed": hit.speed,
        "aside_mm": 1000.0 * hit.aside,
        "above_mm": 1000.0 * hit.above,
        "askew_deg": hit.askew * 180.0 / pi,
        "steps": steps,
        "coarse_mm": 1000.0 * coarse,
        "reference_mm": 1000.0 * fine,
        "lower_mm": 1000.0 * beside[0],
        "higher_mm": 1000.0 * beside[1],
        "sensitive": spread > SENSITIVE,
        "sapien_mm": None if other is None else 1000.0 * other,
        "exact_mm": 1000.0 * exact,
        "error_percent": 100.0 * (exact / fine - 1.0),
    }


def summed(rows: Rows) -> Row:
    """Return the number of sensitive hits, and the errors of the others."""
    firm = [row for row in rows.values() if not row["sensitive"]]
    return {
        "hits": len(rows),
        "sensitive": len(rows) - len(firm),
        "firm": len(firm),
        "within_10_percent": sum(abs(_of(row, "error_percent")) <= WANTED for row in firm),
        "worst_percent": max((abs(_of(row, "error_percent")) for row in firm), default=None),
        "steps_percent": _worst(firm, "coarse_mm"),
        "sapien_percent": _worst([row for row in firm if row["sapien_mm"] is not None], "sapien_mm"),
    }


def _worst(rows: Sequence[Mapping[str, object]], key: str) -> float | None:
    """Return the largest difference from the reference [%]."""
    return max((100.0 * abs(_of(row, key) / _of(row, "reference_mm") - 1.0) for row in rows), default=None)


def _of(row: Mapping[str, object], key: str) -> float:
    return float(row[key] or 0.0)  # type: ignore[arg-type]


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--steps", type=int, default=8000, help="of the reference, a second; and half as many")
    arguments.add_argument("--random", type=int, default=10, help="random hits")
    arguments.add_argument("--no-peer", action="store_true", help="leave SAPIEN out")
    chosen = arguments.parse_args()
    found: dict[str, Row] = {}
    progress = Console(stderr=True, width=150)
    for name, hit in track(list(cases(chosen.random)), "hits", console=progress):
        found[name] = row = compared(hit, chosen.steps, not chosen.no_peer)
        progress.print(f"{name}: {row['exact_mm']:.3g} of {row['reference_mm']:.3g} mm, {row['error_percent']:+.1f} %")
    table = Table("hit", *next(iter(found.values())))
    for name, row in found.items():
        table.add_row(name, *(f"{cell:.3g}" if isinstance(cell, float) else f"{cell}" for cell in row.values()))
    console = Console(width=150)
    console.print(table)
    console.print(summed(found))
    if chosen.write:
        record("end-hits", "python -m benchmarks.end_hits --write", {"hits": found, "all": {"all": summed(found)}})


if __name__ == "__main__":
    main()
