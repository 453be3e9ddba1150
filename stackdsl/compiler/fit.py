"""Does every brick fit where it is placed: not inside another body, and not in the air?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import hypot, inf

from stability.geometry.box_distance import LIMIT_ITSELF, Separation, gap_bridged, reach_between
from stability.geometry.placed_shape import InPlace, above_plane, bodies_apart, in_place
from stability.geometry.spatial_grid import Neighbours
from stability.model import ConvexShape, Plane, Pose

# [m] What rounding in a file may cost; far below what a plank is made to. Of bodies so thin that they would no longer
# touch, less is forgiven.
OVERLAP = 1e-4
TWO_SIDES = 2
LEAST_UPWARD = 0.05  # z of a contact normal that carries something; less is a touch of two upright faces

# Pairs that are held against each other, in all and on average; in what is tidy, a brick has some ten near it.
MAX_PAIRS, MAX_PAIRS_EACH = 100_000, 20
MOST_INSIDE = 200  # boxes inside others that are kept; more mistakes than anybody is told


class CrowdedError(Exception):
    """Boxes lie so close together that it takes too long to say how they fit."""

    def __init__(self, index: int) -> None:
        super().__init__(index)
        self.index = index  # of the box that was too much


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
    Raises CrowdedError.
    """
    site = PlacementIndex([in_place(box.shape, box.pose) for box in boxes], planes)
    found: list[Fit] = []
    going = sorted((index for index, box in enumerate(boxes) if box.until < inf), key=lambda index: -boxes[index].until)
    gathered = 0
    for index, box in enumerate(boxes):
        while going and boxes[going[-1]].until <= box.time:
            site.take_away(going.pop())
        while gathered < len(boxes) and boxes[gathered].time <= box.time:
            site.put(gathered)
            if boxes[gathered].until <= box.time:
                site.take_away(gathered)
            gathered += 1
        found.append(site.fit(index))
    return found


@dataclass(frozen=True, slots=True)
class _Near:
    """Another body, by number, and how a box is apart from it."""

    number: int
    apart: Separation
    reach: float  # from which they still touch [m]

    @property
    def touches(self) -> bool:
        return self.apart.gap <= gap_bridged(self.reach, self.apart.normal_BA_W[2])

    @property
    def is_below(self) -> bool:
        return self.apart.normal_BA_W[2] > LEAST_UPWARD

    @property
    def overlaps(self) -> bool:
        """Whether it is deeper in the box than rounding costs, or so deep that statics would not let them touch."""
        return -self.apart.gap > min(LIMIT_ITSELF * OVERLAP, self.reach)


@dataclass
class PlacementIndex:
    """Boxes and planes, and which of the boxes are there by now.

    Of those that are inside others, only the first are kept: however many lie in one place, none is held against all.
    """

    blocks: list[InPlace]
    planes: Sequence[Plane]
    _there: Neighbours[int] = field(default_factory=Neighbours)
    _overlaps: dict[int, Fit] = field(default_factory=dict)
    _pairs: int = 0  # that were held against each other

    def put(self, index: int) -> None:
        """Let a box be there, after all with a lower number that come at its time. Raises CrowdedError."""
        overlap = self._overlap(index)
        if overlap is not None:
            self._overlaps[index] = overlap
        if overlap is None or len(self._overlaps) <= MOST_INSIDE:
            self._there.add(index, self.blocks[index].low_W, self.blocks[index].high_W)

    def take_away(self, index: int) -> None:
        """Let a box be gone, if it was there."""
        if index in self._there:
            self._there.remove(index)

    def fit(self, index: int) -> Fit:
        """How a box that is there sits among the others. Raises CrowdedError."""
        if index in self._overlaps:
            return self._overlaps[index]
        reach, on_planes = reach_between(self.blocks[index].thickness), list(self._planes_near(index))
        on_boxes = list(self._near(index, reach))
        return self._fit_among(index, on_planes, on_boxes)

    def touching(self, index: int) -> list[int]:
        """The boxes that touch one that is there."""
        near = self._near(index, reach_between(self.blocks[index].thickness))
        return [each.number for each in near if each.touches]

    def _overlap(self, index: int) -> Fit | None:
        """The fit of a box that is inside a plane or a box before it; None of one that is not."""
        for near in self._planes_near(index):
            if near.overlaps:
                return Fit(overlaps_plane=near.number, depth=-near.apart.gap)
        for near in self._near(index, reach_between(self.blocks[index].thickness)):
            if near.overlaps and near.number < index:
                return Fit(overlaps_box=near.number, depth=-near.apart.gap)
        return None

    def _planes_near(self, index: int) -> Iterator[_Near]:
        own = self.blocks[index]
        reach = reach_between(own.thickness)
        return (_Near(n, above_plane(own, plane), reach) for n, plane in enumerate(self.planes))

    def _fit_among(self, index: int, on_planes: Sequence[_Near], on_boxes: Sequence[_Near]) -> Fit:
        below = [near for near in (*on_planes, *on_boxes) if near.is_below]
        if not any(near.touches for near in below):  # in the air; how far above what is of interest only here
            below += [near for near in self._under(index) if near.is_below]
        nearest = min(below, key=lambda near: near.apart.gap, default=None)
        return Fit(
            on_boxes=tuple(near.number for near in on_boxes if near.touches and near.is_below),
            on_planes=tuple(near.number for near in on_planes if near.touches and near.is_below),
            beside_boxes=tuple(near.number for near in on_boxes if near.touches and not near.is_below),
            beside_planes=tuple(near.number for near in on_planes if near.touches and not near.is_below),
            clearance=nearest.apart.gap if nearest is not None else inf,
            reach=nearest.reach if nearest is not None else 0.0,
        )

    def _under(self, index: int) -> Iterator[_Near]:
        """Those that a box would come upon within twice its size, if it sank. Raises CrowdedError."""
        own = self.blocks[index]
        x, y, z = own.low_W
        return self._held_against(index, self._there.around((x, y, z - 2.0 * hypot(*own.reach)), own.high_W, 0.0))

    def _near(self, index: int, margin: float) -> Iterator[_Near]:
        """Those whose bounds come as close to a box as a margin [m], in order. Raises CrowdedError."""
        own = self.blocks[index]
        return self._held_against(index, self._there.around(own.low_W, own.high_W, margin))

    def _held_against(self, index: int, others: Sequence[int]) -> Iterator[_Near]:
        own, blocks = self.blocks[index], self.blocks
        for other in others:
            if other != index:
                self._pairs += 1
                if self._pairs > MAX_PAIRS + MAX_PAIRS_EACH * len(blocks):
                    raise CrowdedError(index)
                between = reach_between(own.thickness, blocks[other].thickness)
                yield _Near(other, bodies_apart(own, blocks[other]), between)
