"""Damages files of every format of loads, and counts how they are read.

Each of 500 files a format is cut, or a part of it is lost, doubled, exchanged or overwritten. A file that is read must
give the bricks that a reader written apart finds in it; any other file must be refused with cause, place and remedy.

Run: python -m benchmarks.mutated_files [--write]; about three minutes.
"""

from collections.abc import Callable
from functools import partial
from time import process_time
from typing import Any, Final

from rich.console import Console

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from tests.stackdsl.importers.loads import BINARIES, TEXTS
from tests.stackdsl.importers.test_mutated_loads import binary_is_told, nothing_is_lost

FILES: Final = 500  # of each format


def main() -> None:
    """Print the counts, and store them with `--write`."""
    asked = parser(__doc__).parse_args()
    cases: dict[str, Callable[[int], bool]] = {
        **{name: partial(nothing_is_lost, name) for name in TEXTS},
        **{name: partial(binary_is_told, name) for name in BINARIES},
    }
    console = Console()
    rows: dict[str, Row] = {}
    for name in sorted(cases):
        rows[name] = counted(cases[name])
        console.print(name, rows[name])
    if asked.write:
        record("mutated-files", "python -m benchmarks.mutated_files --write", {"files": rows})


def counted(is_read: Callable[[int], bool]) -> Row:
    """Return how many damaged files are read, refused, read differently and answered with an internal error."""
    counts: dict[str, Any] = {"files": FILES, "read": 0, "refused": 0, "otherwise": 0, "crashed": 0}
    slowest = 0.0
    for seed in range(FILES):
        start = process_time()
        try:
            outcome = "read" if is_read(seed) else "refused"
        except AssertionError:
            outcome = "otherwise"
        except Exception:
            outcome = "crashed"
        counts[outcome] += 1
        slowest = max(slowest, process_time() - start)
    return {**counts, "slowest_ms": 1000.0 * slowest}


if __name__ == "__main__":
    main()
