"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import floor, hypot, inf
from statistics import median

from stability.geometry.separation import Block, Separation, block, block_above_plane, blocks_apart
from stability.geometry.touching import TOUCHING, reach_between
from stability.model import Plane, Pose, Vec3

# [m] What rounding in a file may cost; far below what a plank is made to. Bodies that are so thin that they would no
# longer touch are forgiven less: see `forgiven`.
OVERLAP = 1e-4
MOST_CELLS = 256  # that a box of usual size can reach; a plank on end amid flat ones reaches some sixty
TWO_SIDES = 2
LEAST_UPWARD = 0.05  # z of a contact normal that carries something; less is a touch of two upright faces


@dataclass(frozen=True, slots=True)
class Sited:
    """A box, where and when it is put."""

    time: float  # [s], or any number that orders what happens
    size: Vec3  # [m]
    pose: Pose
    until: float = inf  # when it is taken away again


@dataclass(frozen=True, slots=True)
class Fit:
    """How one box sits among those put before it or with it. Boxes are meant by number, planes by their number too."""

    overlaps_box: int | None = None
    overlaps_plane: int | None = None
    depth: float = 0.0  # of the overlap [m]
    on_boxes: tuple[int, ...] = ()
    on_planes: tuple[int, ...] = ()
    beside_boxes: tuple[int, ...] = ()  # those that touch it from the side or from above
    beside_planes: tuple[int, ...] = ()
    clearance: float = inf  # [m] to the nearest body below; infinite if none is near
    reach: float = 0.0  # from which it would still touch that body [m]

    @property
    def overlaps(self) -> bool:
        """Whether it is inside another body."""
        return self.overlaps_box is not None or self.overlaps_plane is not None

    @property
    def in_the_air(self) -> bool:
        """Whether nothing is under it, nor on two sides of it, where it may be wedged."""
        return not self.on_boxes and not self.on_planes and len(self.beside_boxes) + len(self.beside_planes) < TWO_SIDES


def fits(boxes: Sequence[Sited], planes: Sequence[Plane]) -> list[Fit]:
    """The fit of every box; `boxes` are in order of time. One that is taken away makes room for those put then.

    Those put at the same time may rest on one another. Of two that overlap, the later one in the order is blamed.
    """
    blocks = [block(box.size, box.pose) for box in boxes]
    grid = _Grid.suiting(blocks)
    found: list[Fit] = []
    going = sorted((index for index, box in enumerate(boxes) if box.until < inf), key=lambda index: -boxes[index].until)
    gathered = 0
    for index, box in enumerate(boxes):
        while going and boxes[going[-1]].until <= box.time:
            grid.gone.add(going.pop())
        while gathered < len(boxes) and boxes[gathered].time <= box.time:
            grid.add(gathered)
            gathered += 1
        found.append(_fit(index, grid, planes))
    return found


def _fit(index: int, grid: "_Grid", planes: Sequence[Plane]) -> Fit:
    own = grid.blocks[index]
    on_planes = [block_above_plane(own, plane) for plane in planes]
    for number, apart in enumerate(on_planes):
        if apart.gap < -forgiven(own.thickness):
            return Fit(overlaps_plane=number, depth=-apart.gap)
    on_boxes = grid.apart_from(index, reach_between(own.thickness))
    for other, apart in on_boxes:
        if apart.gap < -forgiven(own.thickness, grid.blocks[other].thickness) and other < index:
            return Fit(overlaps_box=other, depth=-apart.gap)
    touching = [(other, apart) for other, apart in on_boxes if apart.gap <= grid.reach(index, other)]
    at_planes = [(number, apart) for number, apart in enumerate(on_planes) if apart.gap <= reach_between(own.thickness)]
    below = [(apart.gap, reach_between(own.thickness)) for apart in on_planes if _is_below(apart)]
    below += [(apart.gap, grid.reach(index, other)) for other, apart in on_boxes if _is_below(apart)]
    if all(gap > reach for gap, reach in below):  # in the air; how far above what is of interest only here
        around = grid.apart_from(index, hypot(*grid.cell))
        below += [(apart.gap, grid.reach(index, other)) for other, apart in around if _is_below(apart)]
    clearance, reach = min(below, default=(inf, 0.0))
    return Fit(
        on_boxes=tuple(other for other, apart in touching if _is_below(apart)),
        on_planes=tuple(number for number, apart in at_planes if _is_below(apart)),
        beside_boxes=tuple(other for other, apart in touching if not _is_below(apart)),
        beside_planes=tuple(number for number, apart in at_planes if not _is_below(apart)),
        clearance=clearance,
        reach=reach,
    )


def forgiven(thickness: float, other: float = inf) -> float:
    """How deep a body may be in another [m]: what rounding costs, and never so much that they do not touch."""
    return min(OVERLAP, reach_between(thickness, other))


def _is_below(apart: Separation) -> bool:
    return apart.normal_BA_W[2] > LEAST_UPWARD


@dataclass
class _Grid:
    """Boxes by the cells that the upright boxes around them reach, so that only near ones are compared.

    The cell suits the usual box, in each direction; the few that are much larger are near everything.
    """

    blocks: Sequence[Block]
    cell: Vec3  # [m]
    cells: dict[tuple[int, ...], list[int]] = field(default_factory=lambda: defaultdict(list))
    large: list[int] = field(default_factory=list)
    gone: set[int] = field(default_factory=set)  # taken away by now
    count: int = 0

    @classmethod
    def suiting(cls, blocks: Sequence[Block]) -> "_Grid":
        """An empty grid with cells as wide as the usual box is, along each axis of the world."""
        reaches = [each.reach for each in blocks] or [(1.0, 1.0, 1.0)]
        x, y, z = (2.0 * (1.0 + TOUCHING) * median(along) for along in zip(*reaches, strict=True))
        return cls(blocks, (x, y, z))

    def add(self, index: int) -> None:
        """Let a box be found."""
        self.count = index + 1
        ranges = self._reached(index, 0.0)
        if _cells_in(ranges) > MOST_CELLS:
            self.large.append(index)
            return
        for cell in product(*ranges):
            self.cells[cell].append(index)

    def reach(self, index: int, other: int) -> float:
        """How far apart these two still touch [m]."""
        return reach_between(self.blocks[index].thickness, self.blocks[other].thickness)

    def apart_from(self, index: int, margin: float) -> list[tuple[int, Separation]]:
        """Those whose bounds come as close to a box as a margin [m], by number, and how it is apart from them."""
        own, blocks = self.blocks[index], self.blocks
        others = [other for other in self._near(index, margin) if other != index and other not in self.gone]
        near = sorted(other for other in others if own.is_within(margin, blocks[other]))
        return [(other, blocks_apart(own, blocks[other])) for other in near]

    def _near(self, index: int, margin: float) -> Iterable[int]:
        ranges = self._reached(index, margin)
        if _cells_in(ranges) > self.count:  # then looking at all boxes is less work
            return range(self.count)
        return {*self.large, *(other for cell in product(*ranges) for other in self.cells.get(cell, ()))}

    def _reached(self, index: int, margin: float) -> tuple[range, range, range]:
        own = self.blocks[index]
        x, y, z = (
            range(floor((at - reach - margin) / cell), floor((at + reach + margin) / cell) + 1)
            for at, reach, cell in zip(own.p_WC, own.reach, self.cell, strict=True)
        )
        return x, y, z


def _cells_in(ranges: tuple[range, range, range]) -> int:
    return len(ranges[0]) * len(ranges[1]) * len(ranges[2])
