"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot, inf

from stability.geometry.neighbours import Neighbours
from stability.geometry.separation import Block, Separation, block, block_above_plane, blocks_apart
from stability.geometry.touching import LIMIT_ITSELF, reach_between
from stability.model import Plane, Pose, Vec3

# [m] What rounding in a file may cost; far below what a plank is made to. Bodies that are so thin that they would no
# longer touch are forgiven less: see `forgiven`.
OVERLAP = 1e-4
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
    site = _Site(blocks)
    found: list[Fit] = []
    going = sorted((index for index, box in enumerate(boxes) if box.until < inf), key=lambda index: -boxes[index].until)
    gathered = 0
    for index, box in enumerate(boxes):
        while going and boxes[going[-1]].until <= box.time:
            gone = going.pop()
            if gone in site.there:
                site.there.remove(gone)
        while gathered < len(boxes) and boxes[gathered].time <= box.time:
            if boxes[gathered].until > box.time:
                site.there.add(gathered, blocks[gathered].low_W, blocks[gathered].high_W)
            gathered += 1
        found.append(_fit(index, site, planes))
    return found


def _fit(index: int, site: "_Site", planes: Sequence[Plane]) -> Fit:
    own = site.blocks[index]
    on_planes = [block_above_plane(own, plane) for plane in planes]
    for number, apart in enumerate(on_planes):
        if apart.gap < -forgiven(own.thickness):
            return Fit(overlaps_plane=number, depth=-apart.gap)
    on_boxes = site.apart_from(index, reach_between(own.thickness))
    for other, apart in on_boxes:
        if apart.gap < -forgiven(own.thickness, site.blocks[other].thickness) and other < index:
            return Fit(overlaps_box=other, depth=-apart.gap)
    touching = [(other, apart) for other, apart in on_boxes if apart.gap <= site.reach(index, other)]
    at_planes = [(number, apart) for number, apart in enumerate(on_planes) if apart.gap <= reach_between(own.thickness)]
    below = [(apart.gap, reach_between(own.thickness)) for apart in on_planes if _is_below(apart)]
    below += [(apart.gap, site.reach(index, other)) for other, apart in on_boxes if _is_below(apart)]
    if all(gap > reach for gap, reach in below):  # in the air; how far above what is of interest only here
        around = site.apart_from(index, 2.0 * hypot(*own.reach))
        below += [(apart.gap, site.reach(index, other)) for other, apart in around if _is_below(apart)]
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
    return min(LIMIT_ITSELF * OVERLAP, reach_between(thickness, other))


def _is_below(apart: Separation) -> bool:
    return apart.normal_BA_W[2] > LEAST_UPWARD


@dataclass
class _Site:
    """All boxes, and which of them are there by now."""

    blocks: Sequence[Block]
    there: Neighbours[int] = field(default_factory=Neighbours)

    def reach(self, index: int, other: int) -> float:
        """How far apart these two still touch [m]."""
        return reach_between(self.blocks[index].thickness, self.blocks[other].thickness)

    def apart_from(self, index: int, margin: float) -> list[tuple[int, Separation]]:
        """Those whose bounds come as close to a box as a margin [m], by number, and how it is apart from them."""
        own = self.blocks[index]
        around = self.there.around(own.low_W, own.high_W, margin)
        return [(other, blocks_apart(own, self.blocks[other])) for other in around if other != index]
