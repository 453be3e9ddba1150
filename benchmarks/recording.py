"""Measures the processor time of a recorder, relative to the run without one.

A recorder gets values that the runner has already, so it can be measured alone: the calls of a run are stored and
repeated without the run. The difference of two runs would measure the same, but on a shared machine mostly the noise.
Each time is the least of several, which is disturbed least.

Run: python -m benchmarks.recording [--write]
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.model import BodyId, BodyState, Brick
from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.simulation.recording import Recorder, Recording

SCENARIOS: Final = Path(__file__).parent.parent / "scenarios"
RUNS: Final = (
    ("slant-tower.yaml", "slant-tower[exact]"),
    ("slant-tower.yaml", "slant-tower[thesis]"),
    ("capabilities/impact-top.yaml", "[exact]"),
    ("insert-remove.yaml", "[tuned]"),
    ("wall.yaml", "[exact]"),
)
TURNS: Final = 5
AGAIN: Final = 15


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    console = Console()
    cases = [_case(file, name) for file, name in RUNS]
    rows = {case.name: measured(case) for case in track(cases, description="recording", console=Console(stderr=True))}
    table = Table("run", "bricks", "run [s]", "recorder [ms]", "overhead [%]", "kept poses")
    for name, row in rows.items():
        table.add_row(
            name, *(f"{row[key]:.4g}" for key in ("bricks", "without_s", "recorder_ms", "overhead_percent", "keys"))
        )
    console.print(table)
    if arguments.write:
        record("recording", "python -m benchmarks.recording --write", {"runs": rows})


def _case(file: str, name: str) -> Case:
    return next(case for case in gather([SCENARIOS / file]).cases if name in case.name)


def measured(case: Case) -> Row:
    """Return the time of a run without a recorder, the time of a recorder, and the size of its recording."""
    without = min(_taken(lambda: play_case(case.timeline, case.system)) for _ in range(TURNS))
    heard = Heard()
    play_case(case.timeline, case.system, recorder=heard)
    recorder = min(_taken(heard.again) for _ in range(AGAIN))
    recording = heard.again()
    return {
        "bricks": len(recording.bricks),
        "without_s": without,
        "recorder_ms": 1000.0 * recorder,
        "overhead_percent": 100.0 * recorder / without,
        "keys": len(recording.keys),
    }


def _taken(what: Callable[[], object]) -> float:
    began = process_time()
    what()
    return process_time() - began


@dataclass
class Heard(Recorder):
    """Stores the calls of a recorder."""

    calls: list[Callable[[Recorder], None]] = field(default_factory=list, init=False)

    def add(self, time: float, brick: Brick, state: BodyState) -> None:
        self.calls.append(lambda recorder: recorder.add(time, brick, state))

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        told = dict(states)
        self.calls.append(lambda recorder: recorder.see(time, told))

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        gone = tuple(bricks)
        self.calls.append(lambda recorder: recorder.remove(time, gone))

    def again(self) -> Recording:
        """Repeat all calls on another recorder, and return its recording."""
        recorder = Recorder()
        for call in self.calls:
            call(recorder)
        return recorder.recording()


if __name__ == "__main__":
    main()
