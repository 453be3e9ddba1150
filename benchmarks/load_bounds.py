"""Measures the time in which the least and the greatest load of each box of real pallets are proven.

Ten pallets of the package `pallet-sim` that stand are taken at equal distances, and some boxes of each. The same bounds
are computed twice: with forces that are corrected by one factorization of each pallet, and with a factorization for
each correction, as before. Each bound is checked again by plain arithmetic, with nothing but its motion; a fault is
planted in one bound of each pallet, and must be found. Times are processor times, with a share of the set-up of the
pallet. It needs `pip install --no-deps pallet-sim`.

Run: python -m benchmarks.load_bounds [--write]
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import process_time
from typing import Final

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.pallet_orders import orders
from benchmarks.pallets import placed_boxes, read, site
from stability.analysis.load_bounds import Bound, SumBounds
from stability.geometry.rows import Array
from stability.problem import Problem, Stability, Tolerances
from stability.statics.certificate import lies_on
from stability.statics.proof import greatest_sum
from stackdsl.importers.settling import settled
from stackdsl.language.imports import Import

PALLETS: Final = 10
BOXES: Final = 6  # of each pallet, at equal distances in their order
WAY: Final = "within 5 mm"
FAULT: Final = 1e-3  # share by which a bound is made too narrow
SAME: Final = 1e-9  # share by which a bound may differ from its motion
NAMES: Final = {"one factorization": True, "one for each correction": False}


@dataclass(frozen=True, slots=True)
class Proven:
    """Bounds of one box."""

    weights: Array
    least: Bound
    greatest: Bound


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    problems = standing()
    rows = {name: _row([_of_pallet(problem, shared) for problem in problems]) for name, shared in NAMES.items()}
    table = Table("correction", *next(iter(rows.values())))
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.4g}" for value in row.values()))
    Console().print(table)
    if arguments.write:
        record("load-bounds", "python -m benchmarks.load_bounds --write", {"correction": rows})


def standing() -> list[Problem]:
    """Return the problems of pallets that stand, at equal distances in the order of the package."""
    settle = Import.model_validate({"file": "-", "settle": WAY}).settle
    every = list(orders())
    found: list[Problem] = []
    for order in every[:: max(1, len(every) // (3 * PALLETS))]:
        load, _ = next(read(order))
        assembly = site()
        if assembly.add_all(placed_boxes(settled(load, settle).load)).stability is Stability.STABLE:
            found.append(assembly.problem())
        if len(found) == PALLETS:
            break
    return found


def _of_pallet(problem: Problem, shared: bool) -> tuple[list[Proven], float, int, int]:
    """Return bounds of some boxes, the time of each [s], how many are false, and how many planted faults are found."""
    began = process_time()
    bounds = SumBounds(problem, Tolerances(), shared=shared)
    names = sorted(problem.bricks)
    found = []
    for name in names[:: max(1, len(names) // BOXES)][:BOXES]:
        weights = bounds.weights_of([n for n, c in enumerate(problem.contacts) if c.lower == name and lies_on(c)])
        if (both := bounds.of(weights)) is not None and weights.any():
            found.append(Proven(weights, *both))
    seconds = (process_time() - began) / max(1, len(found))
    planted = [_is_false(problem, replace(each, greatest=_too_narrow(each.greatest))) for each in found[:1]]
    return found, seconds, sum(_is_false(problem, each) for each in found), sum(planted)


def _too_narrow(bound: Bound) -> Bound:
    return replace(bound, force=(1.0 - FAULT) * bound.force)


def _is_false(problem: Problem, proven: Proven) -> bool:
    """Return whether a bound is narrower than its motion proves."""
    upper = greatest_sum(problem, proven.weights, proven.greatest.motion) if proven.greatest.motion else 0.0
    lower = -greatest_sum(problem, -proven.weights, proven.least.motion) if proven.least.motion else 0.0
    slack = SAME * max(1.0, abs(proven.greatest.force))
    return proven.greatest.force < upper - slack or proven.least.force > lower + slack


def _row(results: Sequence[tuple[list[Proven], float, int, int]]) -> Row:
    every = [each for found, *_ in results for each in found]
    wide = [
        (bound.force - bound.reached) / max(1.0, bound.force) * sign
        for each in every
        for bound, sign in ((each.greatest, 1.0), (each.least, -1.0))
        if bound.reached is not None
    ]
    times = [1000.0 * seconds for _, seconds, *_ in results]
    return {
        "pallets": len(results),
        "boxes": len(every),
        "median_ms": median(times),
        "slowest_ms": max(times),
        "widest": max(wide),
        "reached": len(wide) / (2 * len(every)),
        "false": sum(false for _, _, false, _ in results),
        "planted": len(results),
        "found": sum(found for *_, found in results),
    }


if __name__ == "__main__":
    main()
