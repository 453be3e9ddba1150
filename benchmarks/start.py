"""Measures the start time of `stackdsl --help` and of `check` of one standing scenario, in units of `import click`.

The commands run in turn, so that other load on the machine affects all of them equally; each row is the median.
Processor time includes the worker's and depends less on other load than wall time.

Run: python -m benchmarks.start [rounds]
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from time import perf_counter
from typing import Final

from rich.console import Console
from rich.table import Table

ROUNDS: Final = 15
UNIT: Final = "python -c 'import click'"
MOST: Final[Mapping[str, float]] = {"stackdsl --help": 3.0, "stackdsl check one.yaml": 8.0}  # times the unit


@dataclass(frozen=True, slots=True)
class Took:
    """Time of one call."""

    wall: float  # [s]
    processor: float  # [s] of user and system, with all descendants


def main() -> None:
    """Measure and print the table."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    with tempfile.TemporaryDirectory() as folder:
        took = measured(Path(folder), rounds)
    unit = _medians(took[UNIT])
    table = Table("command", "processor ms", "wall ms", "processor", "wall", "at most")
    for name, calls in took.items():
        own = _medians(calls)
        ratios = f"{own.processor / unit.processor:.1f} x", f"{own.wall / unit.wall:.1f} x"
        limit = f"{MOST[name]:g} x" if name in MOST else ""
        table.add_row(name, f"{1e3 * own.processor:.0f}", f"{1e3 * own.wall:.0f}", *ratios, limit)
    Console().print(table)


def measured(folder: Path, rounds: int) -> dict[str, list[Took]]:
    """Return the times of all calls of all commands, in turn; the first round fills the caches and does not count."""
    template = files("stackdsl").joinpath("template.yaml").read_text(encoding="utf-8").replace("NAME", "one")
    (folder / "one.yaml").write_text(template, encoding="utf-8")
    python = [sys.executable, "-m", "stackdsl"]
    commands: dict[str, Sequence[str]] = {
        UNIT: [sys.executable, "-c", "import click"],
        "stackdsl --help": [*python, "--help"],
        "stackdsl check one.yaml": [*python, "check", "one.yaml", "--no-cache"],
        "stackdsl check one.yaml, remembered": [*python, "check", "one.yaml"],
    }
    timed([*python, "check", "one.yaml", "--update"], folder)
    timed([*python, "check", "one.yaml"], folder)
    took: dict[str, list[Took]] = {name: [] for name in commands}
    for turn in range(rounds + 1):
        for name, command in commands.items():
            call = timed(command, folder)
            if turn:
                took[name].append(call)
    return took


def timed(command: Sequence[str], folder: Path) -> Took:
    """Time one call of a command."""
    before, began = getrusage(RUSAGE_CHILDREN), perf_counter()
    subprocess.run(command, cwd=folder, env=_clean(), capture_output=True, check=True)
    wall, after = perf_counter() - began, getrusage(RUSAGE_CHILDREN)
    return Took(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def _clean() -> dict[str, str]:
    """Return the environment of a usual user, whose Python stores compiled files."""
    return {name: value for name, value in os.environ.items() if name not in ("CI", "PYTHONDONTWRITEBYTECODE")}


def _medians(calls: Sequence[Took]) -> Took:
    return Took(median(call.wall for call in calls), median(call.processor for call in calls))


if __name__ == "__main__":
    main()
