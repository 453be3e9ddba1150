"""Proves the least and the greatest load of each box of the 522 pallets of the package `pallet-sim`.

Each pallet is placed at once, with gaps up to 5 mm as contact, at a friction of 0.4. A pallet that is not proven to
stand has no loads. Bounds are computed to three accuracies. Each bound is checked again by plain arithmetic, with
nothing but its motion; a fault is planted in one bound of each pallet, and must be found. It needs
`pip install --no-deps pallet-sim`.

Run: python -m benchmarks.load_bounds [--every N] [--write]
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from multiprocessing import get_context
from time import perf_counter, process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.pallet_orders import orders
from benchmarks.pallets import placed_boxes, read, site
from stability.analysis.load_bounds import Bound, SumBounds
from stability.geometry.rows import Array
from stability.problem import Placed, Problem, Stability, Tolerances
from stability.process_settings import one_thread
from stability.statics.certificate import lies_on
from stability.statics.proof import greatest_sum
from stackdsl.importers.settling import settled
from stackdsl.language.imports import Import

PROCESSES: Final = 2
WAY: Final = "within 5 mm"
ACCURACIES: Final = {"1 %": 1e-2, "0.1 %": 1e-3, "0.0001 %": 1e-6}  # shares of the greatest load of a box
FAULT: Final = 1e-3  # share by which a bound is made too narrow
SAME: Final = 1e-9  # share by which a bound may differ from its motion


@dataclass(frozen=True, slots=True)
class Proven:
    """Bounds of one box."""

    weights: Array
    least: Bound
    greatest: Bound


@dataclass(frozen=True, slots=True)
class Judged:
    """Result of one pallet."""

    boxes: int
    stands: bool
    widths: Sequence[float]  # of each bound, beyond what forces reach, as a share of the greatest load
    unproven: int  # bounds without a motion, or without forces that nearly reach them
    false: int
    planted: int
    found: int
    seconds: float  # of processor time, without the verdict


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--every", type=int, default=1, help="take each Nth pallet only")
    chosen = arguments.parse_args()
    errors = Console(stderr=True)
    every = list(orders())
    loads = [load for order in track(every, "reading", console=errors) for load, _ in read(order)][:: chosen.every]
    settle = Import.model_validate({"file": "-", "settle": WAY}).settle
    pallets = [placed_boxes(settled(load, settle).load) for load in track(loads, "settling", console=errors)]
    rows: dict[str, Row] = {}
    for name, accuracy in ACCURACIES.items():
        began = perf_counter()
        with ProcessPoolExecutor(PROCESSES, get_context("spawn")) as pool:
            proven = pool.map(partial(judged, accuracy=accuracy), pallets)
            results = list(track(proven, f"proving to {name}", len(pallets), console=errors))
        rows[name] = _row(results, perf_counter() - began)
    table = Table("accuracy", *rows["1 %"])
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.4g}" for value in row.values()))
    Console().print(table)
    if chosen.write:
        record("load-bounds", "python -m benchmarks.load_bounds --write", {"pallets": rows})


@one_thread()
def judged(bricks: Sequence[Placed], accuracy: float) -> Judged:
    """Prove and check the loads of all boxes of a pallet, and measure the time."""
    assembly = site()
    if assembly.add_all(bricks).stability is not Stability.STABLE:
        return Judged(len(bricks), False, (), 0, 0, 0, 0, 0.0)
    problem = assembly.problem()
    began = process_time()
    bounds = SumBounds(problem, Tolerances())
    above: dict[str, list[int]] = {}
    for number, contact in enumerate(problem.contacts):
        if lies_on(contact):
            above.setdefault(contact.lower, []).append(number)
    weights = [bounds.weights_of(above.get(name, ())) for name in sorted(problem.bricks)]
    found = bounds.of(weights, accuracy)
    assert found is not None, "a pallet that stands has forces that balance it"
    proven = [Proven(each, *both) for each, both in zip(weights, found, strict=True)]
    seconds = process_time() - began
    widths = [width for each in proven for width in _widths(each)]
    planted = [replace(each, greatest=_too_narrow(each.greatest)) for each in proven if each.weights.any()][:1]
    return Judged(
        len(bricks),
        True,
        widths,
        2 * len(proven) - sum(width <= accuracy for width in widths),
        sum(_is_false(problem, each) for each in proven),
        len(planted),
        sum(_is_false(problem, each) for each in planted),
        seconds,
    )


def _widths(proven: Proven) -> Sequence[float]:
    scale = max(1.0, abs(proven.greatest.force))
    return [
        sign * (bound.force - bound.reached) / scale
        for bound, sign in ((proven.greatest, 1.0), (proven.least, -1.0))
        if bound.reached is not None and isfinite(bound.force)
    ]


def _too_narrow(bound: Bound) -> Bound:
    return replace(bound, force=(1.0 - FAULT) * bound.force)


def _is_false(problem: Problem, proven: Proven) -> bool:
    """Return whether a bound is narrower than its motion proves."""
    upper = greatest_sum(problem, proven.weights, proven.greatest.motion) if proven.greatest.motion else 0.0
    lower = -greatest_sum(problem, -proven.weights, proven.least.motion) if proven.least.motion else 0.0
    slack = SAME * max(1.0, abs(proven.greatest.force))
    return proven.greatest.force < upper - slack or proven.least.force > lower + slack


def _row(results: Sequence[Judged], seconds: float) -> Row:
    standing = [each for each in results if each.stands]
    boxes = sum(each.boxes for each in standing)
    spent = sum(each.seconds for each in standing)
    return {
        "pallets": len(results),
        "boxes": sum(each.boxes for each in results),
        "stable": len(standing),
        "bounded": boxes,
        "unproven": sum(each.unproven for each in standing),
        "widest": max(width for each in standing for width in each.widths),
        "false": sum(each.false for each in standing),
        "planted": sum(each.planted for each in standing),
        "found": sum(each.found for each in standing),
        "ms_a_box": 1000.0 * spent / boxes,
        "processor_s": spent,
        "wall_s": seconds,
    }


if __name__ == "__main__":
    main()
