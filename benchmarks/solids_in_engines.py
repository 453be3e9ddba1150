"""Compares engines with exact statics on random assemblies of random convex solids, as convex hulls.

The solids are those of the tests (`tests.stability.statics.random_solids`): prisms, off-centre boxes, polyhedra and
bridges, one to seven of them, placed at once. Assemblies within 3 % of their limit do not test an engine and are left
out: there a horizontal acceleration of 0.03 g, in one of eight directions, changes the verdict.

Run it with `python -m benchmarks.solids_in_engines`; MuJoCo is optional: pip install "stackdsl[mujoco]".
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import cos, dist, pi, sin
from time import process_time

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.model import GROUND, Plane
from stability.problem import Placed, Problem, Stability, Wrench
from stability.statics.assembly import Assembly
from stability.statics.equilibrium import balance
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import System
from stackdsl.timeline import FixedWorld, Placement, Timeline
from tests.stability.statics.random_solids import random_assembly

NEAR = 0.03  # [g] of an acceleration that changes the verdict of an assembly near its limit
DIRECTIONS = 8
WATCHED = 2.0  # [s]
MOVED = 0.01  # share of the size of a solid: some tip onto the next face and rest again, which is no collapse
SYSTEMS = ("exact", "tuned", "mujoco", "sapien")


@dataclass(frozen=True, slots=True)
class Case:
    """Assembly with its proven verdict."""

    seed: int
    friction: float
    bricks: Sequence[Placed]
    stands: bool


@dataclass(frozen=True, slots=True)
class Played:
    """Result of an engine on one assembly."""

    case: Case
    stands: bool
    seconds: float  # of the processor
    gain: float  # of energy, as a share


def cases(seeds: Sequence[int]) -> Iterator[Case | None]:
    """Yield assemblies with a proven verdict that are not near their limit; None for each of the others."""
    for seed in seeds:
        scene = random_assembly(seed)
        made = Assembly(friction=scene.friction)
        stability = made.add_all(scene.bricks).stability
        stands = stability is Stability.STABLE
        decided = stability is not Stability.UNDECIDED and all(
            (balance(each).forces is not None) is stands for each in shaken(made.problem())
        )
        yield Case(seed, scene.friction, scene.bricks, stands) if decided else None


def shaken(problem: Problem) -> Iterator[Problem]:
    """Yield a problem with a small acceleration in each direction."""
    for number in range(DIRECTIONS):
        angle = 2.0 * pi * number / DIRECTIONS
        x, y = NEAR * cos(angle), NEAR * sin(angle)
        loads = {
            name: Wrench((x * -load.force_W[2], y * -load.force_W[2], load.force_W[2]), load.torque_W)
            for name, load in problem.loads.items()
        }
        yield replace(problem, loads=loads)


def played(case: Case, system: System) -> Played:
    """Place all solids at once, and play."""
    world = FixedWorld(9.81, case.friction, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), case.friction),))
    placements = tuple(Placement(0.0, each.brick, 1, each.pose) for each in case.bricks)
    started = process_time()
    trace = play(Timeline(world, placements, WATCHED), system)
    seconds = process_time() - started
    places = {each.brick.id: each for each in case.bricks}
    moved = any(
        dist(track.final.position_W, places[name].pose.position_W) > MOVED * places[name].brick.shape.bounding_radius
        for name, track in trace.tracks.items()
    )
    gain = trace.energy.gain if trace.energy is not None else 0.0
    return Played(case, trace.collapse is None and not moved, seconds, gain)


def summed_up(results: Sequence[Played]) -> Row:
    """Return how often an engine agrees with statics."""
    wrong = [each for each in results if each.stands != each.case.stands]
    return {
        "assemblies": len(results),
        "stand": sum(each.case.stands for each in results),
        "falls_though_stable": sum(each.case.stands for each in wrong),
        "stands_though_unstable": sum(not each.case.stands for each in wrong),
        "seeds": " ".join(str(each.case.seed) for each in wrong) or "none",
        "ms": 1e3 * sum(each.seconds for each in results) / max(len(results), 1),
    }


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--assemblies", type=int, default=500)
    chosen = arguments.parse_args()
    console, asked = Console(stderr=True), range(chosen.assemblies)
    judged = list(track(cases(asked), "statics", len(asked), console=console, transient=True))
    clear = [case for case in judged if case is not None]
    rows: dict[str, Row] = {}
    table = Table("system", "assemblies", "stand", "falls though stable", "stands though unstable", "seeds", "ms")
    for system in (name for name in SYSTEMS if system_named(name).engine.package.installed):
        runs = (played(case, system_named(system)) for case in clear)
        steps = track(runs, system, len(clear), console=console, transient=True)
        rows[system] = row = summed_up(list(steps))
        table.add_row(system, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()))
    Console(width=140).print(table)
    if chosen.write:
        all_of_them: Row = {"asked": len(asked), "near": len(asked) - len(clear)}
        tables = {"systems": rows, "all": {"all": all_of_them}}
        record("solids-in-engines", f"python -m benchmarks.solids_in_engines --assemblies {len(asked)} --write", tables)


if __name__ == "__main__":
    main()
