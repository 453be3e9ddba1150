"""Compares exact statics with LMGC90 in one run, on the same towers and walls of 5 to 50 blocks.

LMGC90 moves the blocks for half a second, with the settings in benchmarks/systems/lmgc90.py; blocks that hardly moved
stand. Times are processor times, medians of 31 runs of `exact` and of one run of the peer.

Run: python -m benchmarks.against_lmgc90 [--write]. It needs the peer: pip install --no-deps compas_lmgc90==0.1.11, and
compas.
"""

import sys
from functools import partial

from rich.console import Console

from benchmarks.against_compas import OWN_REPEATS, Answer, judged_exactly, processor_time, repeated, structures
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.systems.assessment import Scene
from benchmarks.systems.compas import bases
from benchmarks.systems.lmgc90 import Lmgc90, block_of
from stability.statics.assembly import LEVEL_GROUND

FRICTION = 0.5
MOST_BLOCKS = 50  # of a structure: LMGC90 takes more than a minute for 100


def main() -> None:
    """Measure and print; write on request."""
    write = parser(__doc__).parse_args().write
    solver = Lmgc90()
    if not solver.package.installed:
        sys.exit(f"LMGC90 is missing; install it with: {solver.package.remedy}, and compas")
    solver.load()
    rows: dict[str, Row] = {}
    for name, planks in structures():
        if len(planks) > MOST_BLOCKS:
            continue
        scene = Scene(planks, (LEVEL_GROUND,), FRICTION)
        exact = repeated(judged_exactly, planks, OWN_REPEATS)
        blocks = [*map(block_of, planks), *map(partial(block_of, fixed=True), bases(scene))]
        started = processor_time()
        move = solver.largest_move(blocks, FRICTION)
        peer = Answer("stable" if move <= solver.moved else "unstable", processor_time() - started)
        rows[name] = {
            "exact": exact.verdict,
            "exact_ms": 1e3 * exact.seconds,
            "lmgc90": peer.verdict,
            "moved_percent": 100.0 * move,
            "lmgc90_s": peer.seconds,
            "times_slower": peer.seconds / exact.seconds,
        }
        Console().print(name, *rows[name].values())
    if write:
        record("against-lmgc90", "python -m benchmarks.against_lmgc90 --write", {"structures": rows})


if __name__ == "__main__":
    main()
