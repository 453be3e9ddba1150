"""Measures speed against error on the four-stack of 25 levels, one plank a second, held 5 s.

Every system plays it in one run. The exact solution is rest, so the error is the largest drift. The time of one update
of an extension is recorded as well. Run it with `make bench-stack`; quote the ratios, since machines differ and are
shared.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.systems.timing import usual_updates
from stackdsl.checking.cases import gather
from stackdsl.checking.play_case import play_case
from stackdsl.trace import Trace

SCENARIO = Path(__file__).parent.parent / "scenarios" / "four-stack.yaml"
RUNS = {
    "exact": 25,
    "thesis": 5,
    "tuned": 1,
    "stock": 3,
}  # the long run is played once: its minute of stepping is an average by itself
COMPARED_WITH = "tuned"


def main() -> None:
    """Play and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    timeline = gather([SCENARIO]).cases[0].timeline
    jobs = [system for system in RUNS for _ in range(RUNS[system])]
    traces: dict[str, list[Trace]] = {system: [] for system in RUNS}
    for system in track(jobs, "four-stack of 25 levels", console=Console(stderr=True), transient=True):
        traces[system].append(play_case(timeline, system))
    rows = measured(traces)
    Console().print(printed(rows))
    if write:
        record("four-stack", "python -m benchmarks.four_stack --write", {"systems": rows})


def measured(traces: Mapping[str, Sequence[Trace]]) -> Rows:
    """Return one row per system."""
    paces = {system: pace(runs) for system, runs in traces.items()}
    return {system: _row(runs, paces[COMPARED_WITH] / paces[system]) for system, runs in traces.items()}


def pace(runs: Sequence[Trace]) -> float:
    """Return the median wall time per simulated second."""
    return median(trace.cost.wall_time for trace in runs) / runs[0].cost.simulated_time


def _row(runs: Sequence[Trace], faster: float) -> Row:
    first = runs[0]
    updates = usual_updates([trace.cost for trace in runs])
    return {
        "verdict": "stands" if first.collapse is None else f"falls at level {first.collapse.level}",
        "drift_mm": 1000.0 * (first.drift if first.collapse is None else first.shift_before),
        "drift": drift_text(first),
        "steps": first.cost.steps,
        "wall_s": median(trace.cost.wall_time for trace in runs),
        "times_faster": faster,
        "update_median_ms": 1000.0 * updates.median if updates is not None else None,
        "update_worst_ms": 1000.0 * updates.worst if updates is not None else None,
    }


def drift_text(trace: Trace) -> str:
    """Return the largest drift; for a fall the one before the brick at which it fell."""
    if trace.collapse is None:
        return f"{1000.0 * trace.drift:.2f} mm" if trace.drift > 0.0 else "0"
    return f"{1000.0 * trace.shift_before:.1f} mm, then it falls"


def printed(rows: Rows) -> Table:
    """Return the table for the terminal."""
    table = Table("system", "verdict", "drift", "steps", "wall s", f"times faster than {COMPARED_WITH}")
    for system, row in rows.items():
        shown = (row["verdict"], row["drift"], row["steps"], f"{row['wall_s']:.3f}", f"{row['times_faster']:.3g}")
        table.add_row(system, *(str(each) for each in shown))
    return table


if __name__ == "__main__":
    main()
