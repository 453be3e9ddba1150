"""Contacts of many boxes at once, with the digits of `contact_between`: level boxes with parallel sides by arrays.

Each number is the result of the same operations as for one pair (`level_patch`, `side_patch`), in the same order.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from stability.contact_law import Coulomb
from stability.contacts.bodies import BoxSolid
from stability.contacts.box_contacts import FLUSH, PARALLEL
from stability.contacts.detection import contact_between
from stability.geometry.box_distance import BESIDE, LIMIT_ITSELF, NO_GAP, TOUCHING
from stability.geometry.rows import Array, Indices
from stability.model import BodyId, Plane, Vec3
from stability.problem import UP, Contact, Tolerances

Pairs: TypeAlias = tuple[Indices, Indices]  # (pairs,) the bodies with the smaller and with the larger index
FrictionOf: TypeAlias = Callable[[BodyId, BodyId], float]


@dataclass(frozen=True, slots=True, eq=False)
class BoxArrays:
    """Boxes by index."""

    names: Sequence[BodyId]
    low_W: Array  # (boxes, 3) lowest corners of their bounding boxes [m]
    high_W: Array  # (boxes, 3) highest corners [m]
    position_W: Array  # (boxes, 3) [m]
    plan: Array  # (boxes, 4) see `PlanRectangle`; NaN for a box that is not level
    rise: Array  # (boxes,) [m]
    shortest: Array  # (boxes,) [m]

    @classmethod
    def of(cls, boxes: Sequence[BoxSolid]) -> "BoxArrays":
        """Return the arrays of boxes."""
        rows = np.array(
            [
                (*box.low_W, *box.high_W, *box.pose.position_W, *(box.plan or NOT_LEVEL), box.rise, box.shortest)
                for box in boxes
            ],
            dtype=float,
        ).reshape(-1, 15)
        low_W, high_W, position_W, plan, rise, shortest = np.split(rows, (3, 6, 9, 13, 14), axis=1)
        return cls([box.id for box in boxes], low_W, high_W, position_W, plan, rise[:, 0], shortest[:, 0])

    def reach(self, pairs: Pairs, share: float) -> Array:
        """Return the largest gap of a contact of each pair [m]; see `reach_between`."""
        return LIMIT_ITSELF * share * np.minimum(self.shortest[pairs[0]], self.shortest[pairs[1]])

    def near(self, share: float) -> Pairs:
        """Return the pairs whose bounding boxes are within the reach of contact."""
        widest = LIMIT_ITSELF * share * float(self.shortest.max(initial=0.0))
        # Sort along the longest side of the whole; each box is compared with those that begin before it ends.
        axis = int(np.argmax(np.ptp(self.low_W, axis=0))) if len(self.names) else 0
        order = np.argsort(self.low_W[:, axis], kind="stable")
        begins = self.low_W[order, axis]
        count = np.searchsorted(begins, self.high_W[order, axis] + widest, side="right") - np.arange(len(order)) - 1
        first = np.repeat(np.arange(len(order)), count)
        second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
        one, other = order[first], order[second]
        one, other = np.minimum(one, other), np.maximum(one, other)
        apart = np.maximum(self.low_W[one] - self.high_W[other], self.low_W[other] - self.high_W[one])
        touching = np.flatnonzero((apart <= self.reach((one, other), share)[:, None]).all(axis=1))
        return one[touching], other[touching]


NOT_LEVEL = (np.nan, np.nan, np.nan, np.nan)
# Indices of the lower and the upper body, points, normal, gaps; None where no forces pass.
Patch: TypeAlias = tuple[int, int, tuple[Vec3, ...], Vec3, tuple[float, ...]] | None


def are_clear(boxes: Sequence[BoxSolid], fixed: int, planes: Sequence[Plane], overlap: float) -> bool:
    """Return whether boxes overlap nothing by more than `overlap` [m] or the reach of contact; the first are fixed.

    False if their bounding boxes do not decide it.
    """
    arrays = BoxArrays.of(boxes)
    one, other = pairs = arrays.near(TOUCHING)
    apart = np.maximum(arrays.low_W[one] - arrays.high_W[other], arrays.low_W[other] - arrays.high_W[one])
    if (apart.max(axis=1, initial=-np.inf) < -np.minimum(overlap, arrays.reach(pairs, TOUCHING))).any():
        return False
    forgiven = np.minimum(overlap, TOUCHING * arrays.shortest[fixed:])
    return all((_height(arrays, plane)[fixed:] >= -forgiven).all() for plane in planes)


def _height(boxes: BoxArrays, plane: Plane) -> Array:
    """Return the height of the lowest point of each bounding box above a plane [m]."""
    normal_W = np.array(plane.normal_W)
    lowest = np.where(normal_W > 0.0, boxes.low_W, boxes.high_W)
    height: Array = (lowest - np.array(plane.point_W)) @ normal_W
    return height


def contacts_of_pairs(
    solids: Sequence[BoxSolid],
    boxes: BoxArrays,
    pairs: Sequence[tuple[int, int]],
    friction: FrictionOf,
    tolerances: Tolerances,
) -> Iterator[tuple[int, Contact]]:
    """Yield contacts in the order of the pairs, each with the number of its pair: those of `contact_between`."""
    names = boxes.names
    ordered = [(i, j) if names[i] < names[j] else (j, i) for i, j in pairs]
    first, second = np.array(ordered, dtype=np.int64).reshape(-1, 2).T
    patches = _patches(boxes, first, second, tolerances)
    laws: dict[float, Coulomb] = {}
    for number, (a, b) in enumerate(ordered):
        if number not in patches:
            contact = contact_between(solids[a], solids[b], friction(names[a], names[b]), tolerances)
            if contact is not None:
                yield number, contact
        elif (patch := patches[number]) is not None:
            lower, upper, points, normal, gaps = patch
            mu = friction(names[a], names[b])
            law = laws.get(mu) or laws.setdefault(mu, Coulomb(mu))
            yield number, Contact(names[lower], names[upper], points, (normal,), law, gaps)


def _patches(boxes: BoxArrays, a: Indices, b: Indices, tolerances: Tolerances) -> dict[int, Patch]:
    """Return the patches of those pairs of boxes that `level_patch` and `side_patch` decide, if they are parallel."""
    reach, within = boxes.reach((a, b), tolerances.gap), tolerances.within
    bridged, beside = (
        np.minimum(reach * share, within * share + NO_GAP * reach) for share in (1.0, BESIDE)
    )  # as `gap_bridged`
    is_lower = boxes.position_W[a, 2] <= boxes.position_W[b, 2]
    lower, upper = np.where(is_lower, a, b), np.where(is_lower, b, a)
    patches: dict[int, Patch] = {}

    # as `level_patch`
    x, y, cosine, sine = _place(boxes, lower, upper)
    half_x, half_y, c, d = *boxes.plan[lower, 2:].T, *boxes.plan[upper, 2:].T
    along, across = np.abs(cosine), np.abs(sine)
    is_parallel = (across <= PARALLEL) | (along <= PARALLEL)  # false for boxes that are not level
    overlap = np.minimum(half_x + c * along + d * across - np.abs(x), half_y + c * across + d * along - np.abs(y))
    height = boxes.position_W[upper, 2] - boxes.position_W[lower, 2] - boxes.rise[lower] - boxes.rise[upper]
    is_apart = (overlap < -reach) | (
        (overlap > reach) & ((height > reach) | (height < -reach) | ((height > within) & (height > bridged)))
    )
    _without_contact(patches, is_parallel & is_apart)
    on_top = np.flatnonzero(is_parallel & (overlap > reach) & ~is_apart)
    c, d = np.where(along <= PARALLEL, d, c), np.where(along <= PARALLEL, c, d)
    left, right = np.maximum(-half_x, x - c), np.minimum(half_x, x + c)
    near, far = np.maximum(-half_y, y - d), np.minimum(half_y, y + d)
    (ux, uy), (px, py, pz) = boxes.plan[lower, :2].T, boxes.position_W[lower].T
    top = pz + boxes.rise[lower]
    corners = [
        (px + u * ux - v * uy, py + u * uy + v * ux, top)
        for u, v in ((left, near), (right, near), (right, far), (left, far))
    ]
    _with_contact(patches, on_top, (lower, upper), corners, None, height, reach)

    # as `side_patch`
    asked = is_parallel & (-reach <= overlap) & (overlap <= reach)
    x, y, cosine, sine = _place(boxes, a, b)
    half_u, half_v, c, d = *boxes.plan[a, 2:].T, *boxes.plan[b, 2:].T
    is_unturned = np.abs(sine) <= PARALLEL
    other_u, other_v = np.where(is_unturned, c, d), np.where(is_unturned, d, c)
    (ux, uy), (px, py, pz) = boxes.plan[a, :2].T, boxes.position_W[a].T
    dz, rise_a, rise_b = boxes.position_W[b, 2] - pz, boxes.rise[a], boxes.rise[b]
    turns = half_u + other_u - np.abs(x) > half_v + other_v - np.abs(y)
    ux, uy, x, y = np.where(turns, -uy, ux), np.where(turns, ux, uy), np.where(turns, y, x), np.where(turns, -x, y)
    half_u, half_v = np.where(turns, half_v, half_u), np.where(turns, half_u, half_v)
    other_u, other_v = np.where(turns, other_v, other_u), np.where(turns, other_u, other_v)
    gap, flush = np.abs(x) - half_u - other_u, -FLUSH * reach
    beyond = (np.abs(y) - half_v - other_v >= flush) | (np.abs(dz) - rise_a - rise_b >= flush)
    is_edge = asked & (gap >= flush) & beyond
    faces = (gap >= -reach) & (half_v + other_v - np.abs(y) > reach) & (rise_a + rise_b - np.abs(dz) > reach)
    decided = asked & ~is_edge & faces
    _without_contact(patches, is_edge | (decided & (gap > beside)))
    sign = np.where(x > 0.0, 1.0, -1.0)
    left, right = np.maximum(-half_v, sign * y - other_v), np.minimum(half_v, sign * y + other_v)
    low, high = np.maximum(-rise_a, dz - rise_b), np.minimum(rise_a, dz + rise_b)
    ux, uy = sign * ux, sign * uy
    corners = [
        (px + half_u * ux - v * uy, py + half_u * uy + v * ux, pz + w)
        for v, w in ((left, low), (right, low), (right, high), (left, high))
    ]
    _with_contact(patches, np.flatnonzero(decided & ~(gap > beside)), (a, b), corners, (ux, uy), gap, reach)
    return patches


def _place(boxes: BoxArrays, one: Indices, other: Indices) -> tuple[Array, Array, Array, Array]:
    """Return the centre of the other rectangle in the frame of one, and cosine and sine of its rotation."""
    (ux, uy), (vx, vy) = boxes.plan[one, :2].T, boxes.plan[other, :2].T
    dx, dy = (boxes.position_W[other, :2] - boxes.position_W[one, :2]).T
    return dx * ux + dy * uy, dy * ux - dx * uy, ux * vx + uy * vy, ux * vy - uy * vx


def _without_contact(patches: dict[int, Patch], which: Array) -> None:
    patches.update(dict.fromkeys(np.flatnonzero(which).tolist()))


def _with_contact(  # noqa: PLR0913, PLR0917 -- the parts of a patch
    patches: dict[int, Patch],
    which: Indices,
    bodies: Pairs,
    corners: Sequence[tuple[Array, Array, Array]],
    normal_W: tuple[Array, Array] | None,
    gap: Array,
    reach: Array,
) -> None:
    """Store the patches of some pairs; the normal is given in plan, None for that upwards."""
    points = np.stack([np.stack(corner, axis=1)[which] for corner in corners], axis=1).tolist()
    level = np.stack(normal_W, axis=1)[which].tolist() if normal_W is not None else None
    gaps = np.where(gap > NO_GAP * reach, gap, 0.0)[which].tolist()
    lower, upper = (body[which].tolist() for body in bodies)
    for place, number in enumerate(which.tolist()):
        normal: Vec3 = UP if level is None else (level[place][0], level[place][1], 0.0)
        own = (gaps[place],) * len(points[place]) if gaps[place] else ()
        patches[number] = (lower[place], upper[place], tuple(map(tuple, points[place])), normal, own)
