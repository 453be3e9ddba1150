"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import floor, hypot, inf
from statistics import median

from stability.contact import TOUCHING
from stability.model import Plane, Pose, Vec3
from stability.separation import Separation, box_above_plane, boxes_apart

OVERLAP = 1e-4  # [m] what rounding in a file may cost; far below what a plank is made to
LARGE = 3.0  # times the usual size
LEAST_UPWARD = 0.05  # z of a contact normal that carries something; less is a touch of two upright faces


@dataclass(frozen=True, slots=True)
class Sited:
    """A box, where and when it is put."""

    time: float  # [s]
    size: Vec3  # [m]
    pose: Pose


@dataclass(frozen=True, slots=True)
class Fit:
    """How one box sits among those put before it or with it. Boxes are meant by number, planes by their number too."""

    overlaps_box: int | None = None
    overlaps_plane: int | None = None
    depth: float = 0.0  # of the overlap [m]
    on_boxes: tuple[int, ...] = ()
    on_plane: bool = False
    clearance: float = inf  # [m] to the nearest body below; infinite if none is near

    @property
    def overlaps(self) -> bool:
        """Whether it is inside another body."""
        return self.overlaps_box is not None or self.overlaps_plane is not None

    @property
    def in_the_air(self) -> bool:
        """Whether nothing is under it."""
        return not self.on_boxes and not self.on_plane


def fits(boxes: Sequence[Sited], planes: Sequence[Plane]) -> list[Fit]:
    """The fit of every box; `boxes` are in order of time.

    Those put at the same time may rest on one another. Of two that overlap, the later one in the order is blamed.
    """
    grid = _Grid(median([hypot(*box.size) for box in boxes] or [1.0]) + 2.0 * TOUCHING)
    found: list[Fit] = []
    gathered = 0
    for index, box in enumerate(boxes):
        while gathered < len(boxes) and boxes[gathered].time <= box.time:
            grid.add(gathered, boxes[gathered])
            gathered += 1
        near = [(other, boxes[other]) for other in grid.near(box) if other != index]
        found.append(_fit(index, box, near, planes))
    return found


def _fit(index: int, box: Sited, near: Sequence[tuple[int, Sited]], planes: Sequence[Plane]) -> Fit:
    on_planes = [box_above_plane(box.size, box.pose, plane) for plane in planes]
    for number, apart in enumerate(on_planes):
        if apart.gap < -OVERLAP:
            return Fit(overlaps_plane=number, depth=-apart.gap)
    on_boxes = [(other, boxes_apart(box.size, box.pose, at.size, at.pose)) for other, at in near]
    for other, apart in on_boxes:
        if apart.gap < -OVERLAP and other < index:
            return Fit(overlaps_box=other, depth=-apart.gap)
    below = [apart.gap for apart in (*on_planes, *(apart for _, apart in on_boxes)) if _is_below(apart)]
    return Fit(
        on_boxes=tuple(other for other, apart in on_boxes if _is_below(apart) and apart.gap <= TOUCHING),
        on_plane=any(_is_below(apart) and apart.gap <= TOUCHING for apart in on_planes),
        clearance=min(below, default=inf),
    )


def _is_below(apart: Separation) -> bool:
    return apart.normal_BA_W[2] > LEAST_UPWARD


@dataclass
class _Grid:
    """Boxes by the cells that their bounding spheres reach, so that only near ones are compared.

    The cell suits the usual box; the few that are much larger are near everything.
    """

    cell: float  # [m]
    cells: dict[tuple[int, ...], list[int]] = field(default_factory=lambda: defaultdict(list))
    large: list[int] = field(default_factory=list)
    count: int = 0

    def add(self, index: int, box: Sited) -> None:
        self.count = index + 1
        if self._is_large(box):
            self.large.append(index)
            return
        for cell in self._reached(box):
            self.cells[cell].append(index)

    def near(self, box: Sited) -> list[int]:
        if self._is_large(box):
            return list(range(self.count))
        return sorted({*self.large, *(other for cell in self._reached(box) for other in self.cells.get(cell, ()))})

    def _is_large(self, box: Sited) -> bool:
        return hypot(*box.size) > LARGE * self.cell

    def _reached(self, box: Sited) -> Iterator[tuple[int, ...]]:
        reach = 0.5 * hypot(*box.size) + TOUCHING
        ranges = [
            range(floor((centre - reach) / self.cell), floor((centre + reach) / self.cell) + 1)
            for centre in box.pose.position_W
        ]
        return product(*ranges)
