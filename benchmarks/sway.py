"""Measures the sway of a four-stack and the overlap of its planks on every system.

Standing rigid bodies have neither. The publication saw its engine's four-stack sway from the second level on, and more
with every level. Run it with `python -m benchmarks.sway`; half a minute.
"""

from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.published_falls import game
from stackdsl.checking.cases import gather
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import System
from stackdsl.timeline import Placement, Timeline

SCENARIO = Path(__file__).parent.parent / "scenarios" / "sway.yaml"
HEIGHTS = (2, 4, 6)  # levels
SYSTEMS: dict[str, System] = {
    **{
        f"`{name}`": system_named(name)
        for name in ("exact", "thesis", "tuned", "stock", "modified", "mujoco", "sapien")
    },
    "PhysX with the settings of games, at 1/50 s": game(50, None),
}


def main() -> None:
    """Play and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    scene = gather([SCENARIO]).cases[0].timeline
    console = Console(stderr=True)
    rows = {
        name: row(scene, system) for name, system in track(SYSTEMS.items(), "sway", console=console, transient=True)
    }
    table = Table("system", *next(iter(rows.values())))
    for name, values in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in values.values()))
    Console(width=160).print(table)
    if write:
        record("sway", "python -m benchmarks.sway --write", {"systems": rows})


def row(scene: Timeline, system: System) -> Row:
    """Return the largest swing for each height, and for the highest tower the number of swings and the overlap."""
    traces = {levels: play(up_to(scene, levels), system) for levels in HEIGHTS}
    swings = {f"levels_{n}_mm": 1000.0 * trace.sway.amplitude if trace.sway else 0.0 for n, trace in traces.items()}
    last = traces[HEIGHTS[-1]]
    return {
        **swings,
        "frequency_hz": last.sway.frequency if last.sway is not None else None,
        "depth_mm": 1000.0 * last.penetration.depth if last.penetration is not None else None,
    }


def up_to(scene: Timeline, levels: int) -> Timeline:
    """Return the tower up to this level."""
    kept = tuple(each for each in scene.actions if isinstance(each, Placement) and each.level <= levels)
    return replace(scene, actions=kept)


if __name__ == "__main__":
    main()
