"""Compares the fall of slant towers under the published method on several engines, to find the cause of its direction.

The publication saw a slant tower fall at the right level but straight down, while real ones rotate about their lowest
level and stay whole. Here the two leaning towers fall under the published method on three engines at fine steps, on one
of them at coarser steps up to those of games, and without the method. Each tower is placed as high as it is when it
falls under the method; the horizontal displacement of its moving part after sinking by 5 mm describes the fall: zero is
straight down.

Run it with `python -m benchmarks.published_falls`; two minutes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import sqrt
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table
from stackdsl_sapien import SETTINGS

from benchmarks.collapse import FOLLOWED, motion_of, seen_falling, up_to
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.dynamics.toppling import turn_of
from stability.engines.protocol import EngineSettings
from stability.model import BodyId, BodyState, Brick
from stackdsl.checking.cases import gather
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import AS_WRITTEN, MODIFIED, Method, Modification, System, as_played
from stackdsl.timeline import Timeline

SCENARIOS = Path(__file__).parent.parent / "scenarios"
SCENES = {
    "slant": (SCENARIOS / "capabilities" / "slant-tower.yaml", "capabilities-slant-tower", "L9.1"),
    "leaning": (SCENARIOS / "user_test" / "leaning-structure.yaml", "user-test-leaning-structure", "L11.1"),
}  # the file, the scenario, and the plank at which it falls under the method
SUNK = 0.005  # [m] before any body has reached the ground
LONGER = 4.0  # factor on the duration if gravity is a tenth
# As in the manual of Unity: 1/50 s, 7 iterations, contacts from 10 mm on.
GAME = replace(SETTINGS, time_step=1.0 / 50.0, iterations=7, contact_offset=0.01, most_travel=None)


def game(rate: int, method: Method | None, modification: Modification = AS_WRITTEN) -> System:
    """Return PhysX with the settings of games, at another number of steps per second."""
    return System("game", "PhysX as games step it", replace(GAME, time_step=1.0 / rate), method, modification)


def published(engine: EngineSettings) -> System:
    """Return the published method on an engine."""
    return System("published", "the published stack-stability method", engine, Method.PUBLISHED)


RUNS: dict[str, System] = {
    "`exact`": system_named("exact"),
    **{f"`{name}`": system_named(name) for name in ("thesis", "mujoco-thesis", "sapien-thesis")},
    "the method on `stock`": published(system_named("stock").engine),
    **{
        f"the method on PhysX with the settings of games, at 1/{rate} s": game(rate, Method.PUBLISHED)
        for rate in (240, 120, 50)
    },
    **{f"no method, `{name}`": system_named(name) for name in ("tuned", "mujoco", "sapien")},
    "no method, PhysX with the settings of games, at 1/50 s": game(50, None),
    "the same at 1 m/s2 with friction 1.5": game(50, None, MODIFIED),
}


def main() -> None:
    """Play and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    scenes = {key: (timeline(path, name), last) for key, (path, name, last) in SCENES.items()}
    console = Console(stderr=True)
    rows = {name: row(system, scenes) for name, system in track(RUNS.items(), "falls", console=console, transient=True)}
    rows = {"rigid body (closed form)": turned(scenes), **rows}
    table = Table("run", *rows["`exact`"])
    for name, values in rows.items():
        shown = (values.get(key) for key in rows["`exact`"])
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in shown))
    Console(width=160).print(table)
    if write:
        record("published-falls", "python -m benchmarks.published_falls --write", {"runs": rows})


def timeline(path: Path, scenario: str) -> Timeline:
    """Return the timeline of a scene of the publication."""
    return next(case.timeline for case in gather([path]).cases if case.scenario.scenario == scenario)


def row(system: System, scenes: Mapping[str, tuple[Timeline, BodyId]]) -> Row:
    """Return the level at which each tower falls while it is built, and the direction of its fall once it is placed."""
    found: dict[str, float | int | None] = {}
    for name, (scene, last) in scenes.items():
        collapse = play(scene, system).collapse
        found[f"{name}_level"] = collapse.level if collapse is not None else None
        aside = sideways(up_to(scene, last), system)
        found[f"{name}_sideways_mm"] = 1000.0 * aside if aside is not None else None
    return found


def turned(scenes: Mapping[str, tuple[Timeline, BodyId]]) -> Row:
    """Return the displacement of a rotation as one body about the edge named by statics: independent of dynamics."""
    return {
        **{f"{name}_level": None for name in scenes},
        **{f"{name}_sideways_mm": 1000.0 * _aside(up_to(*scene)) for name, scene in scenes.items()},
    }


def _aside(tower: Timeline) -> float:
    problem, motion = motion_of(tower)
    turn = turn_of(problem, motion)
    if turn is None:
        raise ValueError("it does not turn as one body")
    placed = problem.bricks.values()
    mass = sum(each.brick.mass for each in placed)
    x, z = (
        sum(each.brick.mass * (each.pose.position_W[axis] - turn.point_W[axis]) for each in placed) / mass
        for axis in (0, 2)
    )
    return sqrt(x * x + z * z - (z - SUNK) ** 2) - x  # the radius is constant


def sideways(tower: Timeline, system: System) -> float | None:
    """Return the displacement along x of the part that falls by statics after it sank by SUNK [m]; or None."""
    bricks = {name: placed.brick for name, placed in motion_of(tower)[0].bricks.items()}
    longer = 1.0 if system.modification == AS_WRITTEN else LONGER
    _, seen = seen_falling(as_played(tower, system.modification), system, longer * FOLLOWED)
    path = [_centre(bricks, states) for states in seen]
    begin_x, begin_z = path[0]
    for (x, z), (next_x, next_z) in pairwise(path):
        if begin_z - next_z >= SUNK:
            return x - begin_x + (next_x - x) * (z - begin_z + SUNK) / (z - next_z)
    return None


def _centre(bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> Sequence[float]:
    """Return the common centre of mass, along x and z [m]."""
    mass = sum(brick.mass for brick in bricks.values())
    return [
        sum(brick.mass * states[name].pose.position_W[axis] for name, brick in bricks.items()) / mass for axis in (0, 2)
    ]


if __name__ == "__main__":
    main()
