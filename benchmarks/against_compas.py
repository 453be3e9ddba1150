"""Compares exact statics with compas_cra in one run, on the same towers and walls of 5 to 100 blocks.

Run it with `python -m benchmarks.against_compas`. It needs the peer: pip install "compas_cra==0.8.0". Both get boxes
and compute contacts and forces from them; times are medians of processor time. The peer's set-up and its two programs
are described in benchmarks/systems/compas.py. Everything runs on one thread: on a shared machine, several threads make
the peer ten times slower, not faster.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import inf
from os import times
from statistics import median
from time import process_time

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.plank_structures import four_stack, stepped_columns, wall
from benchmarks.systems.assessment import Scene
from benchmarks.systems.compas import Compas, Programme
from stability.problem import Motion, Placed, Tolerances, Verdict
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stability.statics.proof import check_forces, check_motion

FRICTION = 0.5
SHARES = (0.95, 1.05)  # of the limit of a stepped column
COUNTS = (5, 10, 20, 50, 100)
PEER_REPEATS, OWN_REPEATS = 3, 31
INSTALL = 'compas_cra is missing; install it with: pip install "compas_cra==0.8.0"'
RBE, CRA = Programme.RBE, Programme.CRA


@dataclass(frozen=True, slots=True)
class Answer:
    """Verdict of a method, its time, and the error of its proof."""

    verdict: str
    seconds: float
    error: float = 0.0  # residual of the forces, or violation of a contact by the motion


def main() -> None:
    """Measure and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    if not Compas(CRA).package.installed:
        sys.exit(INSTALL)
    Compas(CRA).load()
    table = Table("structure", "exact", "ms", "error", "rbe", "ms", "times slower", "cra", "ms", "times slower")
    kept: dict[str, Row] = {}
    for name, planks in structures():
        exact = repeated(judged_exactly, planks, OWN_REPEATS)
        peers = [repeated(partial(judged_by, peer), planks, PEER_REPEATS) for peer in (Compas(RBE), Compas(CRA))]
        row = [exact.verdict, f"{1e3 * exact.seconds:.2f}", f"{exact.error:.0e}"]
        for peer in peers:
            row += [peer.verdict, f"{1e3 * peer.seconds:.1f}", f"{peer.seconds / exact.seconds:.0f}"]
        table.add_row(name, *row)
        own: Row = {"exact_ms": 1e3 * exact.seconds, "error": exact.error, "verdict": exact.verdict}
        kept[name] = {**own, **_beside(exact, "rbe", peers[0]), **_beside(exact, "cra", peers[1])}
    Console(width=140).print(table)
    if write:
        record(
            "against-compas",
            "python -m benchmarks.against_compas --write",
            {"structures": kept, "counts": by_count(kept)},
        )


def _beside(exact: Answer, program: str, peer: Answer) -> Row:
    return {f"{program}_verdict": peer.verdict, f"{program}_times_slower": peer.seconds / exact.seconds}


def by_count(rows: Rows) -> Rows:
    """Return one row per number of blocks: the time of each program relative to `exact`, by structure."""
    kinds = {"four-stack of {}": "stack", "wall of {}": "wall"}
    kinds |= {f"column of {{}} at {share:g} of its limit": f"column_{100.0 * share:.0f}" for share in SHARES}
    return {
        f"{count}": {
            f"{program}_{short}": rows[name.format(count)][f"{program}_times_slower"]
            for (name, short), program in product(kinds.items(), ("rbe", "cra"))
        }
        for count in COUNTS
    } | {
        "all": {
            "least_exact_ms": min(float(row["exact_ms"] or 0.0) for row in rows.values()),
            "most_exact_ms": max(float(row["exact_ms"] or 0.0) for row in rows.values()),
            "disagree": sum(
                row["verdict"] != row[f"{program}_verdict"] for row in rows.values() for program in ("rbe", "cra")
            ),
        }
    }


def structures() -> list[tuple[str, list[Placed]]]:
    """Return towers and walls that stand, and columns whose verdict a closed form gives."""
    found: list[tuple[str, list[Placed]]] = []
    for count in COUNTS:
        found.append((f"four-stack of {count}", four_stack(count)))
        found.append((f"wall of {count}", wall(count, across=max(2, count // 10))))
        for share in SHARES:
            planks = stepped_columns(count, high=count, share=share)
            found.append((f"column of {count} at {share:g} of its limit", planks))
    return found


def repeated(method: Callable[[Sequence[Placed]], Answer], planks: Sequence[Placed], repeats: int) -> Answer:
    """Return the answer of the run with the median time."""
    answers = sorted((method(planks) for _ in range(repeats)), key=lambda answer: answer.seconds)
    return Answer(answers[0].verdict, median(answer.seconds for answer in answers), answers[0].error)


def judged_exactly(planks: Sequence[Placed]) -> Answer:
    """Return the answer of exact statics without any cache."""
    assembly = Assembly(friction=FRICTION)
    started = processor_time()
    verdict = assembly.add_all(planks)
    seconds = processor_time() - started
    return Answer(verdict.stability, seconds, _error(assembly, verdict))


def processor_time() -> float:
    """Return the processor time of this process and of its solvers [s]: wall time depends on other processes."""
    spent = times()
    return process_time() + spent.children_user + spent.children_system


def _error(assembly: Assembly, verdict: Verdict) -> float:
    """Return the error of the proof by plain arithmetic; infinite if the proof is wrong."""
    forces, problem = assembly.forces(), assembly.problem()
    if forces is not None:
        balance = check_forces(problem, forces, Tolerances())
        return balance.residual if balance.holds else inf
    fall = check_motion(problem, verdict.motion or Motion({}), Tolerances())
    return fall.violation if fall.holds else inf


def judged_by(assessor: Compas, planks: Sequence[Placed]) -> Answer:
    """Return the answer of one of the peer's programs without any cache."""
    scene = Scene(planks, (LEVEL_GROUND,), FRICTION)
    started = processor_time()
    stands = assessor.stands(scene)
    return Answer("stable" if stands else "unstable", processor_time() - started)


if __name__ == "__main__":
    main()
