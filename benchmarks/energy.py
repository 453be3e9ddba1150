"""How much energy do engines add to random heaps: bricks of unlike sizes and masses, slivers among them, some pushed?

Nothing in such a heap adds energy, so every gain is an engine's fault. Bricks are set down flat on what is below them,
in any direction; most heaps give way somewhere. Every second heap has slivers. Run it with `python -m
benchmarks.energy`; 1,000 heaps on `exact` take an hour and a half of one core. `--keep` is a file of rows, which is
gone on with.
"""

import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from math import cos, exp, log, pi, sin
from pathlib import Path
from random import Random
from time import process_time

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.dynamics.contact_points import BrickIndex
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Action, FixedWorld, Placement, PushAction, Timeline
from stackdsl.trace import NOTABLE_GAIN

FRICTION = 0.5
SCENE = FixedWorld(9.81, FRICTION, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),))
FEWEST, MOST = 3, 12  # bricks of a heap
SHORTEST, LONGEST = 0.008, 0.12  # sides of an ordinary brick [m]
THINNEST, THICKEST = 0.00005, 0.0005  # of a sliver [m]
LIGHTEST, HEAVIEST = 300.0, 8000.0  # densities [kg/m3]
SLIVERS = 0.25  # share of bricks that are, in every second heap
ABOUT = 0.06  # [m] from the middle
PUSHED = 0.4  # share of heaps that are
SLOWEST, FASTEST = 0.1, 2.0  # [m/s] that a push gives
PUSH_AT, WATCHED = 0.2, 1.0  # [s]
HIGH = 10.0  # [m] above all
KINDS = ("ordinary sizes", "with slivers")


@dataclass(frozen=True, slots=True)
class Played:
    """What came of one heap on one system."""

    number: int
    system: str
    gain: float  # share of the energy there was
    wrong_normals: int  # contacts of edges that had one
    seconds: float  # of one core

    @property
    def kind(self) -> str:
        """Whether it may have slivers."""
        return KINDS[self.number % 2]


def heap(number: int) -> Timeline:
    """A random heap, set down at once, and perhaps pushed; the same number gives the same one."""
    random, crowd = Random(number), BrickIndex()
    for count in range(random.randint(FEWEST, MOST)):
        brick = _brick(random, f"b{count}", number % 2 == 1 and random.random() < SLIVERS)
        crowd.add(_set_down(brick, random, crowd))
    actions: list[Action] = [Placement(0.0, each.brick, 1, each.pose) for each in crowd.bricks.values()]
    if random.random() < PUSHED:
        actions.append(_push(random, random.choice(list(crowd.bricks.values()))))
    return Timeline(SCENE, tuple(actions), WATCHED)


def _brick(random: Random, name: str, sliver: bool) -> Brick:
    a, b, c = (_spread(random, SHORTEST, LONGEST) for _ in range(3))
    sides = [a, b, _spread(random, THINNEST, THICKEST) if sliver else c]
    random.shuffle(sides)
    density = _spread(random, LIGHTEST, HEAVIEST)
    return Brick(name, Box((sides[0], sides[1], sides[2])), density * sides[0] * sides[1] * sides[2])


def _set_down(brick: Brick, random: Random, crowd: BrickIndex) -> Placed:
    """The brick in a place about the middle, in any direction, on the highest of what is below."""
    x, y = (random.uniform(-ABOUT, ABOUT) for _ in range(2))
    half_turn = 0.5 * random.uniform(0.0, pi)
    above = Placed(brick, Pose((x, y, HIGH), (0.0, 0.0, sin(half_turn), cos(half_turn))))
    height = brick.shape.reach((0.0, 0.0, 1.0))
    depth = min([HIGH - height, *(depth for _, depth in crowd.below(above))])
    return Placed(brick, Pose((x, y, HIGH - depth), above.pose.orientation))


def _push(random: Random, placed: Placed) -> PushAction:
    bearing, impulse = random.uniform(0.0, 2.0 * pi), placed.brick.mass * _spread(random, SLOWEST, FASTEST)
    high = random.uniform(-0.5, 0.5) * placed.brick.shape.reach((0.0, 0.0, 1.0))
    return PushAction(PUSH_AT, placed.brick.id, (impulse * cos(bearing), impulse * sin(bearing), 0.0), (0.0, 0.0, high))


def _spread(random: Random, least: float, most: float) -> float:
    """Alike in every doubling."""
    return exp(random.uniform(log(least), log(most)))


def played(number: int, system: str) -> Played:
    """Play a heap, and see what energy it gained."""
    started = process_time()
    trace = play(heap(number), SYSTEMS[system])
    gain = trace.energy.gain if trace.energy is not None else 0.0
    wrong = trace.wrong_edges.contacts if trace.wrong_edges is not None else 0
    return Played(number, system, gain, wrong, process_time() - started)


def summed_up(found: Sequence[Played]) -> Row:
    """How many heaps gained how much, and which one most."""
    worst = max(found, key=lambda each: each.gain)
    return {
        "heaps": len(found),
        "gained": sum(each.gain > NOTABLE_GAIN for each in found),
        "worst_percent": 100.0 * worst.gain,
        "worst_heap": worst.number,
        "with_wrong_normals": sum(each.wrong_normals > 0 for each in found),
        "seconds": sum(each.seconds for each in found),
    }


def kept(keep: Path | None) -> list[Played]:
    """What a file of rows holds."""
    lines = keep.read_text().splitlines() if keep is not None and keep.exists() else []
    return [Played(**json.loads(line)) for line in lines]


def all_played(numbers: Sequence[int], system: str, keep: Path | None, jobs: int) -> Iterator[Played]:
    """Every heap once on a system; those that a file of rows holds are not played again."""
    done = {each.number: each for each in kept(keep) if each.system == system}
    yield from (done[number] for number in numbers if number in done)
    with ProcessPoolExecutor(jobs) as pool:
        for each in pool.map(partial(played, system=system), (n for n in numbers if n not in done)):
            if keep is not None:
                with keep.open("a") as file:
                    file.write(json.dumps(asdict(each)) + "\n")
            yield each


def main() -> None:
    """Play, print the table, and keep it if asked to."""
    arguments = parser(__doc__)
    arguments.add_argument("--heaps", type=int, default=1000)
    arguments.add_argument("--first", type=int, default=0, help="the number of the first heap")
    arguments.add_argument("--systems", nargs="+", default=["exact", "tuned"])
    arguments.add_argument("--jobs", type=int, default=2)
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    numbers = range(chosen.first, chosen.first + chosen.heaps)
    table = Table("heaps", "number", "over 1 %", "worst %", "heap", "wrong normals", "s")
    rows: dict[str, Row] = {}
    all_kinds: dict[str, Row] = {}
    for system in chosen.systems:
        steps = all_played(numbers, system, chosen.keep, chosen.jobs)
        found = list(track(steps, system, len(numbers), console=Console(stderr=True), transient=True))
        all_kinds[system] = summed_up(found)
        for kind in KINDS:
            name = f"{system}, {kind}"
            rows[name] = row = summed_up([each for each in found if each.kind == kind])
            table.add_row(name, *(f"{value:.3g}" for value in row.values()))
        gained = ", ".join(f"{e.number} ({100.0 * e.gain:.3g} %)" for e in found if e.gain > NOTABLE_GAIN)
        Console(stderr=True).print(f"{system}: {gained or 'none'} over 1 %")
    Console(width=120).print(table)
    if chosen.write:
        of = f"--heaps {chosen.heaps} --first {chosen.first} --systems {' '.join(chosen.systems)}"
        record("energy", f"python -m benchmarks.energy {of} --write", {"heaps": rows, "all": all_kinds})


if __name__ == "__main__":
    main()
