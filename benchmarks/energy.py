"""Measures the energy that engines add to random heaps of bricks, which only their errors can add.

The bricks differ in size and mass; some are slivers, and some are pushed. Bricks are placed flat on the bricks below,
in any direction; most heaps give way somewhere. Every second heap has slivers. Run it with `python -m
benchmarks.energy`; 1,000 heaps on `exact` take an hour and a half of one core. `--keep` names a file of rows; finished
rows are not run again.
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
from stability.dynamics.brick_index import BrickIndex
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.timeline import Action, FixedWorld, Placement, PushAction, Timeline

FRICTION = 0.5
SCENE = FixedWorld(9.81, FRICTION, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),))
FEWEST, MOST = 3, 12  # bricks of a heap
SHORTEST, LONGEST = 0.008, 0.12  # sides of an ordinary brick [m]
THINNEST, THICKEST = 0.00005, 0.0005  # of a sliver [m]
LIGHTEST, HEAVIEST = 300.0, 8000.0  # densities [kg/m3]
SLIVERS = 0.25  # share of slivers among the bricks, in every second heap
ABOUT = 0.06  # [m] largest distance from the middle
PUSHED = 0.4  # share of heaps with a push
SLOWEST, FASTEST = 0.1, 2.0  # [m/s] speed caused by a push
PUSH_AT, WATCHED = 0.2, 1.0  # [s]
HIGH = 10.0  # [m] above all bricks
GAINED = 0.001  # share of the energy: a larger gain is an error of the engine
KINDS = ("ordinary sizes", "with slivers")


@dataclass(frozen=True, slots=True)
class Played:
    """Result of one heap on one system."""

    number: int
    system: str
    gain: float  # share of the initial energy
    wrong_normals: int  # edge contacts with a wrong normal
    seconds: float  # of one core

    @property
    def kind(self) -> str:
        """Return whether the heap may have slivers."""
        return KINDS[self.number % 2]


def heap(number: int) -> Timeline:
    """Return a random heap, placed at once, possibly with a push; a number always gives the same heap."""
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
    """Place the brick near the middle, in any direction, on the highest brick below."""
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
    """Return a random value with a log-uniform distribution."""
    return exp(random.uniform(log(least), log(most)))


def played(number: int, system: str) -> Played:
    """Play a heap and return its energy gain."""
    started = process_time()
    trace = play(heap(number), system_named(system))
    gain = trace.energy.gain if trace.energy is not None else 0.0
    wrong = trace.wrong_edges.contacts if trace.wrong_edges is not None else 0
    return Played(number, system, gain, wrong, process_time() - started)


def summed_up(results: Sequence[Played]) -> Row:
    """Return the numbers of heaps by energy gain, and the heap with the largest gain."""
    worst = max(results, key=lambda each: each.gain)
    return {
        "heaps": len(results),
        "gained": sum(each.gain > GAINED for each in results),
        "worst_percent": 100.0 * worst.gain,
        "worst_heap": worst.number,
        "with_wrong_normals": sum(each.wrong_normals > 0 for each in results),
        "seconds": sum(each.seconds for each in results),
    }


def kept(keep: Path | None) -> list[Played]:
    """Return the results in a file of rows."""
    lines = keep.read_text().splitlines() if keep is not None and keep.exists() else []
    return [Played(**json.loads(line)) for line in lines]


def all_played(numbers: Sequence[int], system: str, keep: Path | None, jobs: int) -> Iterator[Played]:
    """Yield the result of every heap on a system; results in the file of rows are not computed again."""
    done = {each.number: each for each in kept(keep) if each.system == system}
    yield from (done[number] for number in numbers if number in done)
    with ProcessPoolExecutor(jobs) as pool:
        for each in pool.map(partial(played, system=system), (n for n in numbers if n not in done)):
            if keep is not None:
                with keep.open("a") as file:
                    file.write(json.dumps(asdict(each)) + "\n")
            yield each


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--heaps", type=int, default=1000)
    arguments.add_argument("--first", type=int, default=0, help="the number of the first heap")
    arguments.add_argument("--systems", nargs="+", default=["exact", "tuned"])
    arguments.add_argument("--jobs", type=int, default=2)
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    numbers = range(chosen.first, chosen.first + chosen.heaps)
    table = Table("heaps", "number", "over 0.1 %", "worst %", "heap", "wrong normals", "s")
    rows: dict[str, Row] = {}
    all_kinds: dict[str, Row] = {}
    for system in chosen.systems:
        steps = all_played(numbers, system, chosen.keep, chosen.jobs)
        results = list(track(steps, system, len(numbers), console=Console(stderr=True), transient=True))
        all_kinds[system] = summed_up(results)
        for kind in KINDS:
            name = f"{system}, {kind}"
            rows[name] = row = summed_up([each for each in results if each.kind == kind])
            table.add_row(name, *(f"{value:.3g}" for value in row.values()))
        gained = ", ".join(f"{e.number} ({100.0 * e.gain:.3g} %)" for e in results if e.gain > GAINED)
        Console(stderr=True).print(f"{system}: {gained or 'none'} over 0.1 %")
    Console(width=120).print(table)
    if chosen.write:
        of = f"--heaps {chosen.heaps} --first {chosen.first} --systems {' '.join(chosen.systems)}"
        record("energy", f"python -m benchmarks.energy {of} --write", {"heaps": rows, "all": all_kinds})


if __name__ == "__main__":
    main()
