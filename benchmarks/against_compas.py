"""Exact statics and compas_cra side by side, in one run, on the same towers and walls of 5 to 100 blocks.

Run it with `python -m benchmarks.against_compas`. It needs the peer: pip install "compas_cra==0.8.0". Both are given
boxes and find contacts and forces from nothing; times are medians. compas_cra has two programmes: `rbe`, which allows
tension at a penalty (so a structure stands if no tension is left), and `cra`, which couples forces to displacements.
Everything runs on one thread: on a shared machine, several make the peer ten times slower, not faster.
"""

# The peer is untyped, and is there only if somebody installs it.
# mypy: disable-error-code="import-not-found,import-untyped,no-any-unimported,no-untyped-call,misc"

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from math import inf, prod
from statistics import median
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.plank_structures import DENSITY, four_stack, stepped_columns, wall
from stability.geometry import body_axes
from stability.statics.assembly import Assembly
from stability.statics.facts import Motion, Placed, Tolerances, Verdict
from stability.statics.proof import check_forces, check_motion

FRICTION = 0.5
COUNTS = (5, 10, 20, 50, 100)
PEER_REPEATS, OWN_REPEATS = 3, 31
INSTALL = 'compas_cra is missing; install it with: pip install "compas_cra==0.8.0"'
# Its defaults find no contact between planks: `amin`, the least area of one, is 0.1 square metres.
LEAST_AREA, FLATNESS, NEIGHBOURS = 1e-6, 1e-6, 20  # [m2], [m], blocks
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
TENSION = 1e-6  # share of all the weight; less is none


@dataclass(frozen=True, slots=True)
class Answer:
    """What a method says, what it took, and by how much its proof is off."""

    verdict: str
    seconds: float
    error: float = 0.0  # residual of the forces, or violation of a contact by the motion


def main() -> None:
    """Measure, and print the table."""
    try:
        import compas_cra  # noqa: F401, PLC0415 -- the peer is optional
    except ImportError:
        sys.exit(INSTALL)
    if not os.environ.items() >= ONE_THREAD.items():  # read when numpy is loaded: start again
        os.execve(sys.executable, [sys.executable, "-m", "benchmarks.against_compas"], os.environ | ONE_THREAD)
    table = Table("structure", "exact", "ms", "error", "rbe", "ms", "times slower", "cra", "ms", "times slower")
    for name, planks in structures():
        exact = repeated(judged_exactly, planks, OWN_REPEATS)
        peers = [repeated(method, planks, PEER_REPEATS) for method in (judged_by_rbe, judged_by_cra)]
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


def judged_by_rbe(planks: Sequence[Placed]) -> Answer:
    """The peer's rigid block equilibrium: stands if the forces that it finds pull nowhere."""
    from compas_cra.equilibrium import rbe_solve  # noqa: PLC0415 -- the peer is optional

    assembly, seconds, status = _solved(planks, rbe_solve)
    if status:
        return Answer("failed", seconds)
    pulled = max((force["c_nn"] for force in _forces(assembly)), default=0.0)
    weight = sum(prod(each.brick.size) for each in planks) * DENSITY
    return Answer("stable" if pulled < TENSION * weight else "unstable", seconds)


def judged_by_cra(planks: Sequence[Placed]) -> Answer:
    """The peer's coupled rigid-block analysis: stands if it is solved. It does not tell failure from falling."""
    from compas_cra.equilibrium import cra_solve  # noqa: PLC0415 -- the peer is optional

    _, seconds, status = _solved(planks, cra_solve)
    return Answer("failed" if status else "stable", seconds)


def _solved(planks: Sequence[Placed], solve: Callable[..., Any]) -> tuple[Any, float, str]:
    """The peer's assembly, the time that contacts and forces took [s], and its complaint, if any."""
    from compas_cra.algorithms import assembly_interfaces_numpy  # noqa: PLC0415 -- the peer is optional

    assembly = _assembled(planks)
    started, complaint = perf_counter(), ""
    assembly_interfaces_numpy(assembly, nmax=NEIGHBOURS, tmax=FLATNESS, amin=LEAST_AREA)
    try:
        with redirect_stdout(StringIO()):
            solve(assembly, mu=FRICTION, density=DENSITY)
    except ValueError as error:
        complaint = str(error)
    return assembly, perf_counter() - started, complaint


def _assembled(planks: Sequence[Placed]) -> Any:  # noqa: ANN401 -- the peer is untyped
    from compas.geometry import Box, Frame  # noqa: PLC0415 -- the peer is optional
    from compas_assembly.datastructures import Block  # noqa: PLC0415
    from compas_cra.datastructures import CRA_Assembly  # noqa: PLC0415

    assembly = CRA_Assembly()
    # A base under each of the lowest planks: the peer looks for contacts only among blocks whose centres are nearest,
    # so it would not find one large floor.
    lowest = [each for each in planks if each.pose.position_W[2] < each.brick.size[2]]
    for number, each in enumerate([*lowest, *planks]):
        along, across, _ = body_axes(each.pose.orientation)
        x, y, z = each.pose.position_W
        base = number < len(lowest)
        centre = (x, y, z - each.brick.size[2]) if base else (x, y, z)
        box = Box(*each.brick.size, frame=Frame(centre, along, across))
        assembly.add_block(Block.from_shape(box), node=number)
    assembly.set_boundary_conditions(list(range(len(lowest))))
    return assembly


def _forces(assembly: Any) -> list[dict[str, float]]:  # noqa: ANN401 -- the peer is untyped
    graph = assembly.graph
    edges = [graph.edge_attribute(edge, "interfaces") for edge in graph.edges()]
    return [force for interfaces in edges for interface in interfaces for force in interface.forces]


if __name__ == "__main__":
    main()
