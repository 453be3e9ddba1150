"""Judges the 522 pallets of the package `pallet-sim` by statics and measures the time.

Each pallet is read by `stackdsl.importers`, compared with the result of the package's own reader, and placed at once,
without caches, with a friction of 0.4: once with each box lowered until it touches, once with gaps up to 5 mm as
contact. The same is repeated box by box, for the time of one placement. Times are processor times. It needs `pip
install --no-deps pallet-sim`.

Run: python -m benchmarks.pallets [--write]
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from statistics import quantiles
from time import process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.pallet_orders import DECK, Order, orders, read_by_package
from stability.analysis.margins import guarantee
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad
from stackdsl.importers.settling import settled
from stackdsl.language.imports import Import

FRICTION: Final = 0.4
WAYS: Final = ("down", "within 5 mm")
SAME: Final = 1e-9  # [m, kg] rounding of the other reader
COUNTS: Final = ("pallets", "boxes", "stable", "guaranteed", "possible", "unstable", "undecided")
KEYS: Final = (*COUNTS, "seconds", "worst_s", "named_most", "placement_99_ms")


@dataclass(frozen=True, slots=True)
class Judged:
    """Result of one pallet."""

    boxes: int
    stability: str
    seconds: float
    named: int  # number of moving boxes named by the verdict
    guaranteed: bool
    guarantee_s: float  # time of the guarantee of a stable pallet
    placements: Sequence[float]  # [s] of each box, up to the first fall


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    console = Console()
    every = list(orders())
    loads = [
        each for order in track(every, description="reading", console=Console(stderr=True)) for each in read(order)
    ]
    whole: Row = {"boxes": sum(len(load.boxes) for load, _ in loads), "other": sum(other for _, other in loads)}
    rows: dict[str, Row] = {}
    for way in WAYS:
        settle = Import.model_validate({"file": "-", "settle": way}).settle
        results = [
            judged(settled(load, settle).load)
            for load, _ in track(loads, description=way, console=Console(stderr=True))
        ]
        rows[way] = _row(results)
    table = Table("settled", *KEYS)
    for name, row in rows.items():
        table.add_row(name, *(f"{row[key]:.4g}" for key in KEYS))
    console.print(table)
    console.print(f"{whole['other']} of {whole['boxes']} boxes are other ones to the package's own reader")
    if arguments.write:
        record("pallets", "python -m benchmarks.pallets --write", {"settled": rows, "read": {"all": whole}})


def read(order: Order) -> Iterator[tuple[ImportedLoad, int]]:
    """Yield each pallet of an order, and the number of boxes that differ in the package's own reader."""
    for (number, data), (_, *theirs) in zip(order.pallets(), read_by_package(order), strict=True):
        options = Import.model_validate({"file": order.name, "format": "pallet-sim", "load": number})
        load = read_load(data, order.name, options)
        pairs = zip(load.boxes, theirs, strict=True)
        yield load, sum(not _is_same(box.centre, box.size, box.mass, other) for box, other in pairs)


def _is_same(centre: Sequence[object], size: Sequence[object], mass: object, other: dict[str, list[float]]) -> bool:
    x, y, z = other["basePosition"]
    theirs = [x, y, z - DECK, *(2.0 * half for half in other["halfExtents"]), float(str(other["baseMass"])) / 1000.0]
    ours = [float(str(float(part))) for part in (*centre, *size, mass)]  # type: ignore[arg-type]  # fractions
    return all(abs(one - another) <= SAME for one, another in zip(ours, theirs, strict=True))


def judged(load: ImportedLoad) -> Judged:
    """Judge a load placed at once, and measure each placement box by box."""
    bricks = placed_boxes(load)
    assembly = site()
    began = process_time()
    verdict = assembly.add_all(bricks)
    seconds = process_time() - began
    began = process_time()
    guaranteed = verdict.stability is Stability.STABLE and is_guaranteed(assembly)
    guarantee_s = process_time() - began
    placements, one_by_one = [], site()
    for placed in sorted(bricks, key=lambda placed: (placed.pose.position_W[2], placed.brick.id)):
        began = process_time()
        each = one_by_one.add(placed.brick, placed.pose)
        placements.append(process_time() - began)
        if each.stability.value != "stable":
            break
    stability, moving = verdict.stability.value, len(verdict.moving)
    return Judged(len(bricks), stability, seconds, moving, guaranteed, guarantee_s, placements)


def is_guaranteed(assembly: Assembly) -> bool:
    """Return whether rest is the only possible motion of a stable assembly."""
    return guarantee(assembly.problem(), assembly.forces()) is not None


def site() -> Assembly:
    """Return the ground without boxes."""
    return Assembly(
        (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=FRICTION),), friction=FRICTION, overlap=inf
    )


def placed_boxes(load: ImportedLoad) -> list[Placed]:
    """Return all boxes of a load as bricks with their poses."""
    return [_placed(load, number) for number in range(len(load.boxes))]


def _placed(load: ImportedLoad, number: int) -> Placed:
    box = load.boxes[number]
    x, y, z = map(float, box.centre)
    length, width, height = map(float, box.size)
    return Placed(Brick(f"box-{number + 1:03}", Box((length, width, height)), float(box.mass)), Pose((x, y, z)))


def _row(results: Sequence[Judged]) -> Row:
    count = Counter(each.stability for each in results)
    seconds = [each.seconds for each in results]
    placements = [1000.0 * time for each in results for time in each.placements]
    return {
        "pallets": len(results),
        "boxes": sum(each.boxes for each in results),
        **{word: count[word] for word in ("stable", "unstable", "undecided")},
        "guaranteed": sum(each.guaranteed for each in results),
        "possible": count["stable"] - sum(each.guaranteed for each in results),
        "guarantee_s": sum(each.guarantee_s for each in results),
        "seconds": sum(seconds),
        "worst_s": max(seconds),
        "named_most": max(each.named for each in results),
        "named": sum(each.named for each in results),
        "placements": len(placements),
        "placement_99_ms": quantiles(placements, n=100)[-1],
    }


if __name__ == "__main__":
    main()
