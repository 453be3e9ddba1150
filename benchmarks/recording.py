"""What recording costs a run: time of the processor that a recorder takes, beside that of the run without one.

A recorder gets the values that the runner has at hand and asks nothing, so what it takes can be measured by itself: the
calls of a run are kept and done again, alone. The difference of two runs says the same, and where something else runs,
mostly what that was. Each time is the least of several, which is the one that was disturbed least.

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
    """Measure, and print a table."""
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
    """What a run took without a recorder, what a recorder takes, and what it keeps."""
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
    """Keeps what a recorder is told."""

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
        """Tell all of it to another recorder, and ask for what it has recorded."""
        recorder = Recorder()
        for call in self.calls:
            call(recorder)
        return recorder.recording()


if __name__ == "__main__":
    main()
