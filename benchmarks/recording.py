"""What recording costs a run: time of the processor with and without a recorder, and what is kept.

Runs with and without take turns, so that whatever else the machine does weighs on both; each time is the least of
several, which is the one that the machine disturbed least.

Run: python -m benchmarks.recording [--write]
"""

from pathlib import Path
from time import process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.gathering import Case, gather
from stackdsl.checking.one_case import play_case
from stackdsl.recording.recorder import Recorder

SCENARIOS: Final = Path(__file__).parent.parent / "scenarios"
RUNS: Final = (
    ("slant-tower.yaml", "slant-tower[exact]"),
    ("slant-tower.yaml", "slant-tower[thesis]"),
    ("capabilities/impact-top.yaml", "[exact]"),
    ("insert-remove.yaml", "[tuned]"),
    ("wall.yaml", "[exact]"),
)
TURNS: Final = 5


def main() -> None:
    """Measure, and print a table."""
    arguments = parser(__doc__).parse_args()
    console = Console()
    cases = [_case(file, name) for file, name in RUNS]
    rows = {case.name: measured(case) for case in track(cases, description="recording", console=Console(stderr=True))}
    table = Table("run", "bricks", "without [s]", "with [s]", "overhead [%]", "kept poses")
    for name, row in rows.items():
        table.add_row(
            name, *(f"{row[key]:.4g}" for key in ("bricks", "without_s", "with_s", "overhead_percent", "keys"))
        )
    console.print(table)
    if arguments.write:
        record("recording", "python -m benchmarks.recording --write", {"runs": rows})


def _case(file: str, name: str) -> Case:
    return next(case for case in gather([SCENARIOS / file]).cases if name in case.name)


def measured(case: Case) -> Row:
    """What a run took with a recorder and without one, and what was kept."""
    plain: list[float] = []
    recorded: list[float] = []
    recorder = Recorder()
    for turn in range(2 * TURNS):
        began = process_time()
        if turn % 2:
            recorder = Recorder()
            play_case(case.timeline, case.system, recorder=recorder)
            recorder.recording()
        else:
            play_case(case.timeline, case.system)
        (recorded if turn % 2 else plain).append(process_time() - began)
    recording = recorder.recording()
    return {
        "bricks": len(recording.bricks),
        "without_s": min(plain),
        "with_s": min(recorded),
        "overhead_percent": 100.0 * (min(recorded) / min(plain) - 1.0),
        "keys": len(recording.keys),
    }


if __name__ == "__main__":
    main()
