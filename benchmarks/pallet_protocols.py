"""Judges the 522 pallets of the package `pallet-sim` by the protocols of transport, by proof alone.

Each pallet is placed at once, with gaps up to 5 mm as contact, at several coefficients of friction of all contacts. A
pallet that statics proves to stand is tested in four directions, each with proven bounds from below and above. It needs
`pip install --no-deps pallet-sim`.

Run: python -m benchmarks.pallet_protocols [--write]
"""

from collections import Counter
from collections.abc import Sequence
from math import inf, pi, tan
from statistics import median
from time import process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.pallet_orders import orders
from benchmarks.pallets import placed_boxes, read
from stability.analysis.bearings import along_bearing
from stability.model import GROUND, Plane
from stability.problem import Stability
from stability.statics.assembly import Assembly
from stackdsl.importers.load import ImportedLoad
from stackdsl.importers.settling import settled
from stackdsl.language.claims.protocol import FORWARD, OTHERWISE, USUAL
from stackdsl.language.imports import Import

FRICTIONS: Final = (0.4, 0.6, 0.85)  # cardboard, anti-slip mats in all joints, and the best of these
GRAVITY: Final = 9.81
ANGLE: Final = 20.0  # [deg] of the tilting table
BEARINGS: Final = (0.0, 0.5 * pi, pi, 1.5 * pi)
# Accelerations along the bearings, which protocols need [g].
PROTOCOLS: Final = {
    "tilting-table": (tan(ANGLE * pi / 180.0),) * 4,
    "eumos-40509": (USUAL,) * 4,
    "en-12195-1": (FORWARD, OTHERWISE, OTHERWISE, OTHERWISE),
}
OUTCOMES: Final = ("borne", "not_borne", "undecided")


def main() -> None:
    """Judge all pallets and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    console = Console(stderr=True)
    loads = [load for order in track(list(orders()), description="reading", console=console) for load, _ in read(order)]
    settle = Import.model_validate({"file": "-", "settle": "within 5 mm"}).settle
    ready = [settled(load, settle).load for load in loads]
    rows = {
        f"{friction:g}": row_of(
            [tested(load, friction) for load in track(ready, description=f"{friction}", console=console)]
        )
        for friction in FRICTIONS
    }
    table = Table("friction", *next(iter(rows.values())))
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.4g}" for value in row.values()))
    Console().print(table)
    if arguments.write:
        record("pallet-protocols", "python -m benchmarks.pallet_protocols --write", {"friction": rows})


def tested(load: ImportedLoad, friction: float) -> tuple[dict[str, str], float | None, float]:
    """Return the outcome of each protocol, the least acceleration of the four directions [g], and the time [s].

    No outcomes if the pallet is not proven to stand at rest, and no acceleration if one is not proven.
    """
    began = process_time()
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=friction)
    assembly = Assembly((ground,), friction=friction, overlap=inf)
    verdict = assembly.add_all(placed_boxes(load))
    if verdict.stability is not Stability.STABLE:
        return {}, None, process_time() - began
    problem = assembly.problem()
    found = [along_bearing(problem, bearing, GRAVITY) for bearing in BEARINGS]
    sides = [(one.value, one.upper) for one in found if one is not None]
    if len(sides) < len(BEARINGS):
        return dict.fromkeys(PROTOCOLS, "undecided"), None, process_time() - began
    outcomes = {name: _outcome(sides, needed) for name, needed in PROTOCOLS.items()}
    return outcomes, min(value for value, _ in sides), process_time() - began


def _outcome(sides: Sequence[tuple[float, float]], needed: Sequence[float]) -> str:
    """Return the outcome for bounds of what is borne along each bearing, from below and above."""
    if all(value >= wanted for (value, _), wanted in zip(sides, needed, strict=True)):
        return "borne"
    fails = any(upper <= wanted for (_, upper), wanted in zip(sides, needed, strict=True))
    return "not_borne" if fails else "undecided"


def row_of(results: Sequence[tuple[dict[str, str], float | None, float]]) -> Row:
    """Return the counts of all outcomes."""
    standing = [(outcomes, least) for outcomes, least, _ in results if outcomes]
    accelerations = [least for _, least in standing if least is not None]
    counts = {name: Counter(outcomes[name] for outcomes, _ in standing) for name in PROTOCOLS}
    return {
        "pallets": len(results),
        "stable": len(standing),
        **{f"{name.replace('-', '_')}_{word}": counts[name][word] for name in PROTOCOLS for word in OUTCOMES},
        "undecided": sum(count["undecided"] for count in counts.values()),
        "least_g": min(accelerations),
        "median_g": median(accelerations),
        "seconds": sum(seconds for *_, seconds in results),
    }


if __name__ == "__main__":
    main()
