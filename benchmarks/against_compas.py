"""Exact statics and compas_cra side by side, in one run, on the same towers and walls of 5 to 100 blocks.

Run it with `python -m benchmarks.against_compas`. It needs the peer: pip install "compas_cra==0.8.0". Both are given
boxes and find contacts and forces from nothing; times are medians. How the peer is asked, and what its two programs
mean, is told in stackdsl/bench/assessors/compas.py. Everything runs on one thread: on a shared machine, several make
the peer ten times slower, not faster.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from statistics import median
from time import perf_counter

from rich.console import Console
from rich.table import Table

from benchmarks.plank_structures import four_stack, stepped_columns, wall
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stability.statics.facts import Motion, Placed, Tolerances, Verdict
from stability.statics.proof import check_forces, check_motion
from stackdsl.bench.assessors.assessment import Scene
from stackdsl.bench.assessors.compas import Compas, Programme

FRICTION = 0.5
COUNTS = (5, 10, 20, 50, 100)
PEER_REPEATS, OWN_REPEATS = 3, 31
INSTALL = 'compas_cra is missing; install it with: pip install "compas_cra==0.8.0"'
RBE, CRA = Programme.RBE, Programme.CRA


@dataclass(frozen=True, slots=True)
class Answer:
    """What a method says, what it took, and by how much its proof is off."""

    verdict: str
    seconds: float
    error: float = 0.0  # residual of the forces, or violation of a contact by the motion


def main() -> None:
    """Measure, and print the table."""
    if not Compas(CRA).package.installed:
        sys.exit(INSTALL)
    Compas(CRA).load()
    table = Table("structure", "exact", "ms", "error", "rbe", "ms", "times slower", "cra", "ms", "times slower")
    for name, planks in structures():
        exact = repeated(judged_exactly, planks, OWN_REPEATS)
        peers = [repeated(partial(judged_by, peer), planks, PEER_REPEATS) for peer in (Compas(RBE), Compas(CRA))]
        row = [exact.verdict, f"{1e3 * exact.seconds:.2f}", f"{exact.error:.0e}"]
        for peer in peers:
            row += [peer.verdict, f"{1e3 * peer.seconds:.1f}", f"{peer.seconds / exact.seconds:.0f}"]
        table.add_row(name, *row)
    Console(width=140).print(table)


def structures() -> list[tuple[str, list[Placed]]]:
    """Towers and walls that stand, and columns that a closed form says stand or fall."""
    found: list[tuple[str, list[Placed]]] = []
    for count in COUNTS:
        found.append((f"four-stack of {count}", four_stack(count)))
        found.append((f"wall of {count}", wall(count, across=max(2, count // 10))))
        for share in (0.95, 1.05):
            planks = stepped_columns(count, high=count, share=share)
            found.append((f"column of {count} at {share:g} of its limit", planks))
    return found


def repeated(method: Callable[[Sequence[Placed]], Answer], planks: Sequence[Placed], repeats: int) -> Answer:
    """The answer of the run whose time is the median."""
    answers = sorted((method(planks) for _ in range(repeats)), key=lambda answer: answer.seconds)
    return Answer(answers[0].verdict, median(answer.seconds for answer in answers), answers[0].error)


def judged_exactly(planks: Sequence[Placed]) -> Answer:
    """The answer of exact statics, cold."""
    assembly = Assembly(friction=FRICTION)
    started = perf_counter()
    verdict = assembly.add_all(planks)
    seconds = perf_counter() - started
    return Answer(verdict.stability, seconds, _error(assembly, verdict))


def _error(assembly: Assembly, verdict: Verdict) -> float:
    """Of the proof, by plain arithmetic; infinite if it does not hold."""
    forces, problem = assembly.forces(), assembly.problem()
    if forces is not None:
        balance = check_forces(problem, forces, Tolerances())
        return balance.residual if balance.holds else inf
    fall = check_motion(problem, verdict.motion or Motion({}), Tolerances())
    return fall.violation if fall.holds else inf


def judged_by(assessor: Compas, planks: Sequence[Placed]) -> Answer:
    """The answer of one of the peer's programs, cold."""
    scene = Scene(planks, (LEVEL_GROUND,), FRICTION)
    started = perf_counter()
    stands = assessor.stands(scene)
    return Answer("stable" if stands else "unstable", perf_counter() - started)


if __name__ == "__main__":
    main()
