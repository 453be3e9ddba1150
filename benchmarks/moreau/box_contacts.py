"""Contacts of two boxes with sharp edges, present or imminent: points, normals and gaps.

The normal is that of the largest gap among the fifteen axes of two boxes; faces win ties to a tenth of a micrometre. A
face touches the part of the other box's nearest face that lies over it; two edges touch in a point.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

TIE = 1e-7  # [m] an edge axis must be better than a face axis by more than this
PARALLEL = 1e-6  # sine of the angle below which edges define no normal
SLIVER = 1e-9  # [m] faces with a smaller overlap do not touch
MOST = 8  # points of one pair: the overlap of two rectangles is an octagon at most


@njit(cache=True)
def touching(
    p_a: Array, turn_a: Array, half_a: Array, p_b: Array, turn_b: Array, half_b: Array, reach: float, found: Array
) -> int:
    """Fill rows (point, normal from a to b, gap) and return how many; no point whose gap is larger than `reach` [m]."""
    apart = p_b - p_a
    between = turn_a.T @ turn_b
    best, which = -1e9, -1
    for axis in range(6):
        own = turn_a[:, axis] if axis < 3 else turn_b[:, axis - 3]
        far = 0.0
        for k in range(3):
            far += half_b[k] * abs(between[axis, k]) if axis < 3 else half_a[k] * abs(between[k, axis - 3])
        gap = abs(dot(apart, own)) - far - (half_a[axis] if axis < 3 else half_b[axis - 3])
        if gap > reach:
            return 0
        if gap > best:
            best, which = gap, axis
    edge = -1
    normal = np.zeros(3)
    for i in range(3):
        for j in range(3):
            own = np.cross(turn_a[:, i], turn_b[:, j])
            size = np.sqrt(dot(own, own))
            if size < PARALLEL:
                continue
            own = own / size
            away = dot(apart, own)
            if away < 0.0:
                own, away = -own, -away
            gap = away
            for k in range(3):
                gap -= half_a[k] * abs(dot(turn_a[:, k], own)) + half_b[k] * abs(dot(turn_b[:, k], own))
            if gap > reach:
                return 0
            if gap > best + TIE:
                best, edge, normal = gap - TIE, 3 * i + j, own
    if edge >= 0:
        return _edges(p_a, turn_a, half_a, p_b, turn_b, half_b, edge, normal, best + TIE, found)
    if which < 3:
        return _faces(p_a, turn_a, half_a, p_b, turn_b, half_b, which, 1.0, reach, found)
    return _faces(p_b, turn_b, half_b, p_a, turn_a, half_a, which - 3, -1.0, reach, found)


@njit(cache=True)
def _edges(
    p_a: Array, turn_a: Array, half_a: Array, p_b: Array, turn_b: Array, half_b: Array, edge: int, normal: Array,
    gap: float, found: Array,
) -> int:  # fmt: skip
    """Add the point between the edge of a that lies farthest towards b and that of b farthest towards a."""
    i, j = edge // 3, edge % 3
    on_a, on_b = p_a.copy(), p_b.copy()
    for k in range(3):
        if k != i:
            on_a += turn_a[:, k] * (half_a[k] if dot(turn_a[:, k], normal) > 0.0 else -half_a[k])
        if k != j:
            on_b -= turn_b[:, k] * (half_b[k] if dot(turn_b[:, k], normal) > 0.0 else -half_b[k])
    along_a, along_b = turn_a[:, i], turn_b[:, j]
    cosine = dot(along_a, along_b)
    off = on_b - on_a
    reached = (dot(off, along_a) - cosine * dot(off, along_b)) / (1.0 - cosine * cosine)
    found[0, 0:3] = on_a + reached * along_a + 0.5 * gap * normal
    found[0, 3:6] = normal
    found[0, 6] = gap
    return 1


@njit(cache=True)
def _faces(
    p_r: Array, turn_r: Array, half_r: Array, p_i: Array, turn_i: Array, half_i: Array, axis: int, sign: float,
    reach: float, found: Array,
) -> int:  # fmt: skip
    """Add the part of the nearest face of box i that lies over the face of box r with the normal `axis`."""
    away = p_i - p_r
    outwards = 1.0 if dot(away, turn_r[:, axis]) > 0.0 else -1.0
    normal = outwards * turn_r[:, axis]
    facing, least = 0, 2.0
    for k in range(3):
        cosine = dot(turn_i[:, k], normal)
        if -abs(cosine) < least:
            least, facing = -abs(cosine), k
    side = -1.0 if dot(turn_i[:, facing], normal) > 0.0 else 1.0
    u, v = (facing + 1) % 3, (facing + 2) % 3
    middle = p_i + side * half_i[facing] * turn_i[:, facing]
    first, second = (axis + 1) % 3, (axis + 2) % 3
    corners, clipped = np.zeros((16, 3)), np.zeros((16, 3))
    for k in range(4):
        a, b = (1.0 if k in (0, 3) else -1.0), (1.0 if k < 2 else -1.0)
        corner = middle + a * half_i[u] * turn_i[:, u] + b * half_i[v] * turn_i[:, v] - p_r
        corners[k, 0] = dot(corner, turn_r[:, first])
        corners[k, 1] = dot(corner, turn_r[:, second])
        corners[k, 2] = dot(corner, normal) - half_r[axis]
    count = 4
    for k in range(4):
        along, limit, way = k // 2, half_r[first if k < 2 else second], 1.0 if k % 2 else -1.0
        kept = 0
        for n in range(count):
            here, there = corners[n], corners[(n + 1) % count]
            depth, after = limit - way * here[along], limit - way * there[along]
            if depth >= 0.0:
                clipped[kept] = here
                kept += 1
            if (depth > 0.0 and after < 0.0) or (depth < 0.0 and after > 0.0):
                clipped[kept] = here + (there - here) * (depth / (depth - after))
                kept += 1
        corners, clipped, count = clipped, corners, kept
    if count == 0:
        return 0
    for along in range(2):
        if corners[:count, along].max() - corners[:count, along].min() < SLIVER:
            return 0
    filled = 0
    for n in range(count):
        gap = corners[n, 2]
        if gap <= reach and filled < MOST:
            found[filled, 0:3] = p_r + corners[n, 0] * turn_r[:, first] + corners[n, 1] * turn_r[:, second]
            found[filled, 0:3] += (half_r[axis] + 0.5 * gap) * normal
            found[filled, 3:6] = sign * normal
            found[filled, 6] = gap
            filled += 1
    return filled


@njit(cache=True)
def dot(one: Array, other: Array) -> float:
    """Return the dot product of two vectors (3,) of any memory layout: the library's needs contiguous ones."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
