"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import floor, hypot, inf
from statistics import median

from stability.engines.protocol import TOUCHING
from stability.geometry.separation import Block, Separation, block_above_plane, blocks_apart
from stability.model import ConvexShape, Plane, Pose, Vec3
from stability.shapes.apart import solid_block

OVERLAP = 1e-4  # [m] what rounding in a file may cost; far below what a plank is made to
MOST_CELLS = 256  # that a box of usual size can reach; a plank on end amid flat ones reaches some sixty
TWO_SIDES = 2
LEAST_UPWARD = 0.05  # z of a contact normal that carries something; less is a touch of two upright faces


@dataclass(frozen=True, slots=True)
class Sited:
    """A shape, where and when it is put."""

    time: float  # [s], or any number that orders what happens
    shape: ConvexShape
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
    blocks = [solid_block(box.shape, box.pose) for box in boxes]
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
        if apart.gap < -OVERLAP:
            return Fit(overlaps_plane=number, depth=-apart.gap)
    on_boxes = grid.apart_from(index, TOUCHING)
    for other, apart in on_boxes:
        if apart.gap < -OVERLAP and other < index:
            return Fit(overlaps_box=other, depth=-apart.gap)
    below = [apart.gap for apart in (*on_planes, *(apart for _, apart in on_boxes)) if _is_below(apart)]
    if min(below, default=inf) > TOUCHING:  # in the air; how far above what is of interest only here
        below += [apart.gap for _, apart in grid.apart_from(index, hypot(*grid.cell)) if _is_below(apart)]
    touching = [(other, apart) for other, apart in on_boxes if apart.gap <= TOUCHING]
    at_planes = [(number, apart) for number, apart in enumerate(on_planes) if apart.gap <= TOUCHING]
    return Fit(
        on_boxes=tuple(other for other, apart in touching if _is_below(apart)),
        on_planes=tuple(number for number, apart in at_planes if _is_below(apart)),
        beside_boxes=tuple(other for other, apart in touching if not _is_below(apart)),
        beside_planes=tuple(number for number, apart in at_planes if not _is_below(apart)),
        clearance=min(below, default=inf),
    )


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
        x, y, z = (2.0 * (median(along) + TOUCHING) for along in zip(*reaches, strict=True))
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
