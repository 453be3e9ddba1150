"""Measures the time of the survived acceleration of 144 boxes along 72 bearings, to 1 %, and the number of directions.

Cartons of 400 x 300 x 200 mm and 8 kg with a friction of 0.4: in columns with gaps between them, flush on all sides, in
crossed layers, and flush with different masses, so that nothing is symmetric. Times are processor times, and the wall
time on two cores, each the least of three, with the libraries loaded. The largest share without a proof is shown as
well.

Run: python -m benchmarks.survived [--write]
"""

from collections.abc import Iterator, Mapping, Sequence
from random import Random
from time import perf_counter, process_time
from typing import Final
from unittest.mock import patch

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.analysis.acceleration_cut import groups_apart
from stability.analysis.bearings import RoughHeadings, by_bearing
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed
from stability.statics.assembly import Assembly

FRICTION: Final = 0.4
BEARINGS: Final = 72
ACCURACY: Final = 0.01
RUNS: Final = 3
MASS: Final = 8.0  # [kg]
GAP: Final = 0.01  # [m]
CARTON: Final[Vec3] = (0.4, 0.3, 0.2)  # [m]
CROSSING: Final[Vec3] = (0.3, 0.2, 0.2)  # [m] twelve of them cover 1.2 m x 0.6 m lengthwise and across
KEYS: Final = ("boxes", "contacts", "groups", "directions", "seconds", "waited_s", "unproven_percent", "worst_g")


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    rows = {name: measured(boxes) for name, boxes in loads().items()}
    table = Table("load", *KEYS)
    for name, row in rows.items():
        table.add_row(name, *(f"{row[key]:.4g}" for key in KEYS))
    Console().print(table)
    if arguments.write:
        record("survived", "python -m benchmarks.survived --write", {"loads": rows})


def loads() -> Mapping[str, Sequence[Placed]]:
    """Return the loads by name."""
    even, draws = [MASS] * 144, Random(1)
    uneven = [MASS * draws.uniform(0.5, 1.5) for _ in even]
    return {
        "columns, 10 mm apart": [*_columns(GAP, even)],
        "columns, flush": [*_columns(0.0, even)],
        "columns, flush, masses differ": [*_columns(0.0, uneven)],
        "layers that cross, 10 mm apart": [*_layers(GAP)],
        "layers that cross, flush": [*_layers(0.0)],
    }


def _columns(gap: float, masses: Sequence[float]) -> Iterator[Placed]:
    length, width, height = CARTON
    places = [(i * (length + gap), j * (width + gap), k) for k in range(12) for i in range(4) for j in range(3)]
    for number, ((x, y, k), mass) in enumerate(zip(places, masses, strict=True)):
        yield Placed(Brick(f"c{number:03}", Box(CARTON), mass), Pose((x, y, (k + 0.5) * height)))


def _layers(gap: float) -> Iterator[Placed]:
    for k in range(12):
        length, width, height = CROSSING if k % 2 == 0 else (CROSSING[1], CROSSING[0], CROSSING[2])
        for i in range(round(1.2 / length)):
            for j in range(round(0.6 / width)):
                box = Box((length - gap, width - gap, height))
                at = ((i + 0.5) * length, (j + 0.5) * width, (k + 0.5) * height)
                yield Placed(Brick(f"c{k:02}.{i}.{j}", box, MASS), Pose(at))


def measured(boxes: Sequence[Placed]) -> Row:
    """Return the accelerations that one load survives, and the cost."""
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=FRICTION),), friction=FRICTION)
    assembly.add_all(boxes)
    problem, seconds, waited, solved = assembly.problem(), list[float](), list[float](), 0
    for _ in range(RUNS):
        with patch.object(RoughHeadings, "solve_all", autospec=True, side_effect=RoughHeadings.solve_all) as counted:
            began, waited_since = process_time(), perf_counter()
            found = by_bearing(problem, BEARINGS, ACCURACY, assembly.gravity)
            seconds.append(process_time() - began)
            waited.append(perf_counter() - waited_since)
            solved = sum(len(call.args[1]) for call in counted.call_args_list)
    assert found is not None, "it stands"
    return {
        "boxes": len(boxes),
        "contacts": len(problem.contacts),
        "groups": len(groups_apart(problem)),
        "directions": solved,
        "seconds": min(seconds),
        "waited_s": min(waited),
        "unproven_percent": 100.0 * max(1.0 - each.value / each.upper for each in found),
        "worst_g": min(each.value for each in found),
    }


if __name__ == "__main__":
    main()
