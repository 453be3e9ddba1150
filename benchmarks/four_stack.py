"""Speed against error on the four-stack of 25 levels, one plank a second, held 5 s: every system in one run.

The truth is that nothing moves, so the error is the largest drift. Run it with `make bench-stack`; quote the ratios,
since machines differ and are shared.
"""

from pathlib import Path
from statistics import median

from rich.console import Console
from rich.progress import track
from rich.table import Table

from stackdsl.checking.check import play_case
from stackdsl.checking.gathering import gather
from stackdsl.systems.systems import SYSTEMS
from stackdsl.trace import Trace

SCENARIO = Path(__file__).parent.parent / "scenarios" / "four-stack.yaml"
RUNS = {
    "exact": 25,
    "thesis": 5,
    "tuned": 1,
    "stock": 3,
}  # the long one once: its minute of stepping averages by itself


def main() -> None:
    """Play, and print the table."""
    timeline = gather([SCENARIO]).cases[0].timeline
    jobs = [system for system in SYSTEMS for _ in range(RUNS[system])]
    traces: dict[str, list[Trace]] = {system: [] for system in SYSTEMS}
    for system in track(jobs, "four-stack of 25 levels", console=Console(stderr=True), transient=True):
        traces[system].append(play_case(timeline, system))
    walls = {system: median(trace.cost.wall_time for trace in runs) for system, runs in traces.items()}
    table = Table("system", "verdict", "drift mm", "steps", "wall s", "times faster than tuned")
    for system, runs in traces.items():
        fell = runs[0].collapse
        verdict = "stands" if fell is None else f"falls at level {fell.level}"
        per_second = walls[system] / runs[0].cost.simulated_time
        faster = walls["tuned"] / traces["tuned"][0].cost.simulated_time / per_second
        table.add_row(
            system,
            verdict,
            f"{1000.0 * runs[0].drift:.3g}",
            f"{runs[0].cost.steps}",
            f"{walls[system]:.3f}",
            f"{faster:.3g}",
        )
    Console().print(table)


if __name__ == "__main__":
    main()
