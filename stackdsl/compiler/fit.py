"""Checks that every brick fits where it is placed: outside other bodies, and on a support."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import hypot, inf

from stability.geometry.box_distance import LIMIT_ITSELF, Block, Separation, gap_bridged, reach_between
from stability.geometry.placed_shape import (
    InPlace,
    PlacedParts,
    above_plane,
    bodies_apart,
    convex_parts,
    in_place,
    is_round,
)
from stability.geometry.spatial_grid import Neighbours
from stability.model import ConvexShape, Plane, Pose, Vec3

# [m] Allowance for rounding in a file, far below the manufacturing tolerance of a plank. It is smaller for bodies so
# thin that they would no longer touch.
OVERLAP = 1e-4
TWO_SIDES = 2
LEAST_UPWARD = 0.05  # z of the contact normal of a support; smaller values belong to contacts of two upright faces

# Compared pairs in total, and per brick on average; a brick of a tidy structure has about ten neighbours.
MAX_PAIRS, MAX_PAIRS_EACH = 100_000, 20
# Cost of a comparison, in that of two boxes, which takes 20 us; and the most in total.
HULLS, EDGES = 4.0, 0.02  # of two hulls, and besides for each edge of one with each edge of the other
BOX_EDGES = 12
MAX_COST = 700_000.0
MOST_INSIDE = 200  # overlapping boxes that stay in the index; more than are ever reported


class CrowdedError(Exception):
    """Boxes lie so close together that comparing all neighbours takes too long."""

    def __init__(self, index: int) -> None:
        super().__init__(index)
        self.index = index  # of the box at which the limit was reached


@dataclass(frozen=True, slots=True)
class TimedShape:
    """A shape with its pose, and the times at which it is placed and removed."""

    time: float  # [s], or any other increasing number
    shape: ConvexShape
    pose: Pose
    until: float = inf  # time of its removal


@dataclass(frozen=True, slots=True)
class Fit:
    """The contacts and overlaps of one box with boxes placed before it or with it; indices of boxes and of planes."""

    overlaps_box: int | None = None
    overlaps_plane: int | None = None
    depth: float = 0.0  # of the overlap [m]
    way_out_W: Vec3 = (0.0, 0.0, 0.0)  # unit vector along which moving the box by `depth` ends the overlap
    on_boxes: tuple[int, ...] = ()
    on_planes: tuple[int, ...] = ()
    beside_boxes: tuple[int, ...] = ()  # in contact from the side or from above
    beside_planes: tuple[int, ...] = ()
    clearance: float = inf  # gap to the nearest body below [m]; infinite if none is near
    reach: float = 0.0  # largest gap at which the two still count as in contact [m]

    @property
    def overlaps(self) -> bool:
        """Whether the box is inside another body."""
        return self.overlaps_box is not None or self.overlaps_plane is not None

    @property
    def in_the_air(self) -> bool:
        """Whether the box has neither a support nor contacts on two sides, between which it may be wedged."""
        return not self.on_boxes and not self.on_planes and len(self.beside_boxes) + len(self.beside_planes) < TWO_SIDES


def fits(boxes: Sequence[TimedShape], planes: Sequence[Plane]) -> list[Fit]:
    """Return the fit of every box; `boxes` are in order of time.

    Boxes placed at the same time may rest on one another. A box that is removed makes room for those placed at that
    time. Of two overlapping boxes, the later one gets the overlap. Raises CrowdedError.
    """
    site = PlacementIndex([in_place(box.shape, box.pose) for box in boxes], planes)
    results: list[Fit] = []
    removals = sorted(
        (index for index, box in enumerate(boxes) if box.until < inf), key=lambda index: -boxes[index].until
    )
    added = 0
    for index, box in enumerate(boxes):
        while removals and boxes[removals[-1]].until <= box.time:
            site.take_away(removals.pop())
        while added < len(boxes) and boxes[added].time <= box.time:
            site.put(added)
            if boxes[added].until <= box.time:
                site.take_away(added)
            added += 1
        results.append(site.fit(index))
    return results


@dataclass(frozen=True, slots=True)
class _Near:
    """The separation of a box from another body."""

    number: int  # index of the other body
    apart: Separation
    reach: float  # largest gap that counts as contact [m]

    @property
    def touches(self) -> bool:
        return self.apart.gap <= gap_bridged(self.reach, self.apart.normal_BA_W[2])

    @property
    def is_below(self) -> bool:
        return self.apart.normal_BA_W[2] > LEAST_UPWARD

    @property
    def overlaps(self) -> bool:
        """Whether the overlap exceeds rounding, or the depth to which statics accepts a contact."""
        return -self.apart.gap > min(LIMIT_ITSELF * OVERLAP, self.reach)


@dataclass
class PlacementIndex:
    """A spatial index of planes and of the boxes that are present.

    Only the first of overlapping boxes stay in the index, so that no box is compared with all of many in one place.
    """

    blocks: list[InPlace]
    planes: Sequence[Plane]
    _present: Neighbours[int] = field(default_factory=Neighbours)
    _overlaps: dict[int, Fit] = field(default_factory=dict)
    _pairs: int = 0  # compared so far
    _cost: float = 0.0  # of these comparisons

    def put(self, index: int) -> None:
        """Add a box, after all boxes of its time with a lower index. Raises CrowdedError."""
        overlap = self._overlap(index)
        if overlap is not None:
            self._overlaps[index] = overlap
        if overlap is None or len(self._overlaps) <= MOST_INSIDE:
            self._present.add(index, self.blocks[index].low_W, self.blocks[index].high_W)

    def take_away(self, index: int) -> None:
        """Remove a box, if it is present."""
        if index in self._present:
            self._present.remove(index)

    def fit(self, index: int) -> Fit:
        """Return the fit of a box that is present. Raises CrowdedError."""
        if index in self._overlaps:
            return self._overlaps[index]
        reach, on_planes = reach_between(self.blocks[index].thickness), list(self._planes_near(index))
        on_boxes = list(self._near(index, reach))
        return self._fit_among(index, on_planes, on_boxes)

    def touching(self, index: int) -> list[int]:
        """Return the indices of the boxes in contact with a box that is present."""
        near = self._near(index, reach_between(self.blocks[index].thickness))
        return [neighbour.number for neighbour in near if neighbour.touches]

    def _overlap(self, index: int) -> Fit | None:
        """Return the fit of a box inside a plane or an earlier box; None without an overlap."""
        for near in self._planes_near(index):
            if near.overlaps:
                return Fit(overlaps_plane=near.number, depth=-near.apart.gap, way_out_W=near.apart.normal_BA_W)
        for near in self._near(index, reach_between(self.blocks[index].thickness)):
            if near.overlaps and near.number < index:
                return Fit(overlaps_box=near.number, depth=-near.apart.gap, way_out_W=near.apart.normal_BA_W)
        return None

    def _planes_near(self, index: int) -> Iterator[_Near]:
        own = self.blocks[index]
        reach = reach_between(own.thickness)
        return (_Near(n, above_plane(own, plane), reach) for n, plane in enumerate(self.planes))

    def _fit_among(self, index: int, on_planes: Sequence[_Near], on_boxes: Sequence[_Near]) -> Fit:
        below = [near for near in (*on_planes, *on_boxes) if near.is_below]
        if not any(near.touches for near in below):  # in the air: find the nearest body below
            below += [near for near in self._under(index) if near.is_below]
        nearest = min(below, key=lambda near: near.apart.gap, default=None)
        return Fit(
            on_boxes=_each_once(near.number for near in on_boxes if near.touches and near.is_below),
            on_planes=_each_once(near.number for near in on_planes if near.touches and near.is_below),
            beside_boxes=_each_once(near.number for near in on_boxes if near.touches and not near.is_below),
            beside_planes=_each_once(near.number for near in on_planes if near.touches and not near.is_below),
            clearance=nearest.apart.gap if nearest is not None else inf,
            reach=nearest.reach if nearest is not None else 0.0,
        )

    def _under(self, index: int) -> Iterator[_Near]:
        """Yield the boxes below a box, down to twice its size. Raises CrowdedError."""
        own = self.blocks[index]
        x, y, z = own.low_W
        return self._compared(index, self._present.around((x, y, z - 2.0 * hypot(*own.reach)), own.high_W, 0.0))

    def _near(self, index: int, margin: float) -> Iterator[_Near]:
        """Yield the boxes whose bounding boxes are within a margin of that of a box [m]. Raises CrowdedError."""
        own = self.blocks[index]
        return self._compared(index, self._present.around(own.low_W, own.high_W, margin))

    def _compared(self, index: int, others: Sequence[int]) -> Iterator[_Near]:
        own, blocks = self.blocks[index], self.blocks
        for other in others:
            if other != index:
                self._pairs += 1
                self._cost += _cost(own, blocks[other])
                if self._pairs > MAX_PAIRS + MAX_PAIRS_EACH * len(blocks) or self._cost > MAX_COST:
                    raise CrowdedError(index)
                between = reach_between(own.thickness, blocks[other].thickness)
                for one, part in product(convex_parts(own), convex_parts(blocks[other])):
                    yield _Near(other, bodies_apart(one, part), between)


def _each_once(numbers: Iterable[int]) -> tuple[int, ...]:
    """Return numbers without repetitions, since several parts of two bodies may touch."""
    return tuple(dict.fromkeys(numbers))


def _cost(one: InPlace, other: InPlace) -> float:
    """Return the cost of the separation of two bodies, in that of two boxes."""
    if isinstance(one, PlacedParts) or isinstance(other, PlacedParts):
        return sum(_cost(part, against) for part, against in product(convex_parts(one), convex_parts(other)))
    if isinstance(one, Block) and isinstance(other, Block):
        return 1.0
    edges = [BOX_EDGES if isinstance(each, Block) or is_round(each) else len(each.directions) for each in (one, other)]
    return HULLS + EDGES * edges[0] * edges[1]
