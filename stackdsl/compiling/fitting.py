"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import hypot, inf

from stability.geometry.neighbours import Neighbours
from stability.geometry.separation import Separation
from stability.geometry.touching import LIMIT_ITSELF, reach_between
from stability.model import ConvexShape, Plane, Pose
from stability.shapes.apart import InPlace, above_plane, bodies_apart, in_place

# [m] What rounding in a file may cost; far below what a plank is made to. Of bodies so thin that they would no longer
# touch, less is forgiven.
OVERLAP = 1e-4
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
    blocks = [in_place(box.shape, box.pose) for box in boxes]
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


@dataclass(frozen=True, slots=True)
class _Near:
    """Another body, by number, and how a box is apart from it."""

    number: int
    apart: Separation
    reach: float  # from which they still touch [m]

    @property
    def touches(self) -> bool:
        return self.apart.gap <= self.reach

    @property
    def is_below(self) -> bool:
        return self.apart.normal_BA_W[2] > LEAST_UPWARD

    @property
    def overlaps(self) -> bool:
        """Whether it is deeper in the box than rounding costs, or so deep that statics would not let them touch."""
        return -self.apart.gap > min(LIMIT_ITSELF * OVERLAP, self.reach)


def _fit(index: int, site: "_Site", planes: Sequence[Plane]) -> Fit:
    own = site.blocks[index]
    reach = reach_between(own.thickness)
    on_planes = [_Near(n, above_plane(own, plane), reach) for n, plane in enumerate(planes)]
    for near in on_planes:
        if near.overlaps:
            return Fit(overlaps_plane=near.number, depth=-near.apart.gap)
    on_boxes = []
    for near in site.near(index, reach):  # one by one: where many lie in one place, the first says it all
        if near.overlaps and near.number < index:
            return Fit(overlaps_box=near.number, depth=-near.apart.gap)
        on_boxes.append(near)
    below = [near for near in (*on_planes, *on_boxes) if near.is_below]
    if not any(near.touches for near in below):  # in the air; how far above what is of interest only here
        below += [near for near in site.near(index, 2.0 * hypot(*own.reach)) if near.is_below]
    nearest = min(below, key=lambda near: near.apart.gap, default=None)
    return Fit(
        on_boxes=tuple(near.number for near in on_boxes if near.touches and near.is_below),
        on_planes=tuple(near.number for near in on_planes if near.touches and near.is_below),
        beside_boxes=tuple(near.number for near in on_boxes if near.touches and not near.is_below),
        beside_planes=tuple(near.number for near in on_planes if near.touches and not near.is_below),
        clearance=nearest.apart.gap if nearest is not None else inf,
        reach=nearest.reach if nearest is not None else 0.0,
    )


@dataclass
class _Site:
    """All boxes, and which of them are there by now."""

    blocks: Sequence[InPlace]
    there: Neighbours[int] = field(default_factory=Neighbours)

    def near(self, index: int, margin: float) -> Iterator[_Near]:
        """Those whose bounds come as close to a box as a margin [m], in order."""
        own, blocks = self.blocks[index], self.blocks
        for other in self.there.around(own.low_W, own.high_W, margin):
            if other != index:
                between = reach_between(own.thickness, blocks[other].thickness)
                yield _Near(other, bodies_apart(own, blocks[other]), between)
