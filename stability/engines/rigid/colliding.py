"""Contact points of convex solids with each other and with half-spaces.

Model: edges are slightly rounded. If one solid lies on a face of another, the normal is that of the face, and the
points are the corners of the common area. Otherwise edges meet, and the normal joins the nearest points of the two
solids without their rounded edges, which is also right for parallel edges.
"""

from math import sqrt

import numpy as np

from stability.engines.rigid.arrays import (
    FRESH,
    FRICTION,
    OFFSET,
    PRESSES,
    RUBS,
    RUBS_ACROSS,
    Array,
    Bodies,
    Ints,
    Points,
    Solids,
    compiled,
)

MOST_CORNERS = 128  # of a common area
FLAT = 0.9998  # cosine of the angle between two faces that touch along an area
SLIGHT = 0.01  # times the edge radius
SAME = 1e-9  # [m] accepted distance of a corner beyond the side of a face
PARALLEL = 0.997  # squared cosine of the angle between two edges that touch along a line
SIDEWAYS = 0.7  # cosine: a normal closer than that to an axis takes another axis as the reference of its tangents
FAVOURED = 0.999  # factor of the squared distance of parallel edges
COMMON = 0.02  # least common part of parallel edges, as a share of the first
DEEP = 0.05  # times the edge radius: cores that are closer have no normal


@compiled
def contacts(bodies: Bodies, solids: Solids, points: Points, order: Ints, duration: float, near: float) -> int:
    """Find all points at which bodies touch or may touch within a duration [s]; return their number.

    They are in `points`, if there is room for all. `near` is the least gap at which a point counts [m]. `order` are the
    solids, sorted along an axis the last time.
    """
    n = len(solids.body)
    corners, cores = np.empty_like(solids.corners), np.empty_like(solids.corners)
    low, high, reach = np.empty((n, 3)), np.empty((n, 3)), np.empty(n)
    for i in range(n):
        b = solids.body[i]
        reach[i] = near + duration * (_length(bodies.motion, b, 0) + bodies.reach[b] * _length(bodies.motion, b, 3))
        _place(bodies, solids, i, corners, cores)
        for k in range(3):
            least, most = np.inf, -np.inf
            for c in range(solids.corner[i], solids.corner[i + 1]):
                least, most = min(least, corners[c, k]), max(most, corners[c, k])
            low[i, k], high[i, k] = least - reach[i], most + reach[i]
    count = 0
    for i in range(n):
        if bodies.inverse_mass[solids.body[i]] > 0.0:
            count = _on_planes(bodies, solids, i, corners, reach[i], points, count)
    polygon, other = np.empty((MOST_CORNERS, 3)), np.empty((MOST_CORNERS, 3))
    names, other_names = np.empty(MOST_CORNERS, np.int64), np.empty(MOST_CORNERS, np.int64)
    planes, nearest, heights = np.empty((2, 4)), np.empty((2, 8)), np.empty(len(corners))
    room = (polygon, other, names, other_names, planes, nearest, heights)
    pairs = _close_pairs(bodies, solids, low, high, order)
    for code in pairs:
        i, j = code // n, code % n
        count = _of_pair(bodies, solids, i, j, corners, cores, reach[i] + reach[j], points, count, room)
    return count


@compiled
def _length(motion: Array, b: int, k: int) -> float:
    return sqrt(motion[b, k] ** 2 + motion[b, k + 1] ** 2 + motion[b, k + 2] ** 2)


@compiled
def _place(bodies: Bodies, solids: Solids, i: int, corners: Array, cores: Array) -> None:
    """Compute the corners of a solid in W."""
    b = solids.body[i]
    m, p = bodies.axes, bodies.position
    for c in range(solids.corner[i], solids.corner[i + 1]):
        x, y, z = solids.corners[c, 0], solids.corners[c, 1], solids.corners[c, 2]
        u, v, w = solids.cores[c, 0], solids.cores[c, 1], solids.cores[c, 2]
        for k in range(3):
            corners[c, k] = p[b, k] + m[b, 3 * k] * x + m[b, 3 * k + 1] * y + m[b, 3 * k + 2] * z
            cores[c, k] = p[b, k] + m[b, 3 * k] * u + m[b, 3 * k + 1] * v + m[b, 3 * k + 2] * w


@compiled
def _close_pairs(bodies: Bodies, solids: Solids, low: Array, high: Array, order: Ints) -> Ints:
    """Return the pairs of solids whose bounding boxes overlap, as i n + j with i < j, sorted."""
    n = len(order)
    if n == 0:
        return order
    axis, widest = 0, -1.0
    for k in range(3):
        spread = float(np.var(low[:, k]))
        if spread > widest:
            axis, widest = k, spread
    for i in range(1, n):  # insertion sort: the order hardly changes between steps
        moved, j = order[i], i - 1
        while j >= 0 and low[order[j], axis] > low[moved, axis]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = moved
    pairs, count = np.empty(8 * n + 8, np.int64), 0
    for one in range(n):
        i = order[one]
        still = bodies.inverse_mass[solids.body[i]] == 0.0
        for another in range(one + 1, n):
            j = order[another]
            if low[j, axis] > high[i, axis]:
                break
            if solids.body[i] == solids.body[j] or (still and bodies.inverse_mass[solids.body[j]] == 0.0):
                continue
            apart = False
            for k in range(3):
                apart = apart or low[i, k] > high[j, k] or low[j, k] > high[i, k]
            if apart:
                continue
            if count == len(pairs):
                longer = np.empty(2 * count, np.int64)
                longer[:count] = pairs
                pairs = longer
            pairs[count] = min(i, j) * n + max(i, j)
            count += 1
    return np.sort(pairs[:count])


@compiled
def _add(
    bodies: Bodies,
    points: Points,
    count: int,
    solids: tuple[int, int],
    on: tuple[int, int],
    key: int,
    normal: Array,
    at: Array,
    gap: float,
    friction: float,
) -> int:
    """Add a point of W in the middle of a gap [m]; return the number of points."""
    if count >= len(points.key):
        return count + 1
    r = points.row
    for k in (PRESSES, RUBS, RUBS_ACROSS):
        r[count, k] = 0.0
    points.solids[count, 0], points.solids[count, 1] = solids
    points.bodies[count, 0], points.bodies[count, 1] = on
    points.key[count] = key
    x, y, z = normal[0], normal[1], normal[2]
    r[count, 0], r[count, 1], r[count, 2] = x, y, z
    if abs(y) < SIDEWAYS:
        a, b, c = z, 0.0, -x
    else:
        a, b, c = 0.0, -z, y
    long = 1.0 / sqrt(a * a + b * b + c * c)
    a, b, c = long * a, long * b, long * c
    r[count, 3], r[count, 4], r[count, 5] = a, b, c
    r[count, 6], r[count, 7], r[count, 8] = y * c - z * b, z * a - x * c, x * b - y * a
    m, p = bodies.axes, bodies.position
    for side in range(2):
        i = on[side]  # the axes of the world are 0, so that the offset holds its part of the gap
        u, v, w = at[0] - p[i, 0], at[1] - p[i, 1], at[2] - p[i, 2]
        for k in range(3):
            r[count, 9 + 3 * side + k] = m[i, k] * u + m[i, 3 + k] * v + m[i, 6 + k] * w
    r[count, OFFSET], r[count, FRICTION], r[count, FRESH] = gap, friction, 1.0
    return count + 1


@compiled
def _on_planes(bodies: Bodies, solids: Solids, i: int, corners: Array, reach: float, points: Points, count: int) -> int:
    for p in range(len(solids.planes)):
        plane = solids.planes[p]
        for c in range(solids.corner[i], solids.corner[i + 1]):
            height = plane[0] * corners[c, 0] + plane[1] * corners[c, 1] + plane[2] * corners[c, 2] - plane[3]
            if height < reach:
                rubbing = solids.on_planes[solids.surface[i], p]
                pair, on = (-1 - p, i), (len(bodies.reach) - 1, solids.body[i])
                count = _add(bodies, points, count, pair, on, c, plane, corners[c], -plane[3], rubbing)
    return count


@compiled
def _facing(bodies: Bodies, solids: Solids, i: int, j: int, corners: Array, plane: Array) -> tuple[float, int]:
    """Return the largest distance of solid j from the plane of a face of solid i [m], with that face."""
    b, other = solids.body[i], solids.body[j]
    m, p, q = bodies.axes[b], bodies.position[b], bodies.position[other]
    farthest, face = -np.inf, -1
    for f in range(solids.face[i], solids.face[i + 1]):
        u, v, w = solids.normals[f, 0], solids.normals[f, 1], solids.normals[f, 2]
        x, y, z = m[0] * u + m[1] * v + m[2] * w, m[3] * u + m[4] * v + m[5] * w, m[6] * u + m[7] * v + m[8] * w
        height = solids.heights[f] + x * p[0] + y * p[1] + z * p[2]
        if x * q[0] + y * q[1] + z * q[2] - height + bodies.reach[other] < farthest:
            continue
        lowest = np.inf
        for c in range(solids.corner[j], solids.corner[j + 1]):
            lowest = min(lowest, x * corners[c, 0] + y * corners[c, 1] + z * corners[c, 2])
        if lowest - height > farthest:
            farthest, face = lowest - height, f
            plane[0], plane[1], plane[2], plane[3] = x, y, z, height
    return farthest, face


@compiled
def _opposite(bodies: Bodies, solids: Solids, j: int, plane: Array) -> tuple[float, int]:
    """Return the face of a solid whose normal is most opposite to that of a plane, with the cosine."""
    m = bodies.axes[solids.body[j]]
    x = m[0] * plane[0] + m[3] * plane[1] + m[6] * plane[2]
    y = m[1] * plane[0] + m[4] * plane[1] + m[7] * plane[2]
    z = m[2] * plane[0] + m[5] * plane[1] + m[8] * plane[2]
    least, face = np.inf, -1
    for f in range(solids.face[j], solids.face[j + 1]):
        cosine = x * solids.normals[f, 0] + y * solids.normals[f, 1] + z * solids.normals[f, 2]
        if cosine < least:
            least, face = cosine, f
    return least, face


@compiled
def _common_area(
    solids: Solids,
    i: int,
    face: int,
    j: int,
    other: int,
    corners: Array,
    plane: Array,
    inset: float,
    polygon: Array,
    next_polygon: Array,
    names: Ints,
    next_names: Ints,
) -> int:
    """Clip a face of solid j by the sides of a face of solid i, moved inwards; return the number of corners left."""
    count = int(solids.loop[other + 1] - solids.loop[other])
    for k in range(count):
        corner = solids.loops[solids.loop[other] + k]
        names[k] = corner
        for axis in range(3):
            polygon[k, axis] = corners[solids.corner[j] + corner, axis]
    sides = solids.loop[face + 1] - solids.loop[face]
    for side in range(sides):
        v = solids.corner[i] + solids.loops[solids.loop[face] + side]
        w = solids.corner[i] + solids.loops[solids.loop[face] + (side + 1) % sides]
        a, b, c = corners[w, 0] - corners[v, 0], corners[w, 1] - corners[v, 1], corners[w, 2] - corners[v, 2]
        x, y, z = b * plane[2] - c * plane[1], c * plane[0] - a * plane[2], a * plane[1] - b * plane[0]
        long = 1.0 / sqrt(x * x + y * y + z * z)
        x, y, z = long * x, long * y, long * z
        height, kept = x * corners[v, 0] + y * corners[v, 1] + z * corners[v, 2] - inset, 0
        there = x * polygon[0, 0] + y * polygon[0, 1] + z * polygon[0, 2] - height
        for k in range(count):
            following, here = (k + 1) % count, there
            there = x * polygon[following, 0] + y * polygon[following, 1] + z * polygon[following, 2] - height
            if here <= SAME:
                next_names[kept] = names[k]
                for axis in range(3):
                    next_polygon[kept, axis] = polygon[k, axis]
                kept += 1
            if (here <= SAME) != (there <= SAME) and kept < MOST_CORNERS:
                share = here / (here - there)
                for axis in range(3):
                    next_polygon[kept, axis] = (1.0 - share) * polygon[k, axis] + share * polygon[following, axis]
                next_names[kept] = ((side + 1) * 4096 + names[k] % 4096) * 4096 + names[following] % 4096
                kept += 1
        count = min(kept, MOST_CORNERS - 1)
        for k in range(count):
            names[k] = next_names[k]
            for axis in range(3):
                polygon[k, axis] = next_polygon[k, axis]
        if count == 0:
            break
    return count


@compiled
def _of_pair(
    bodies: Bodies,
    solids: Solids,
    i: int,
    j: int,
    corners: Array,
    cores: Array,
    reach: float,
    points: Points,
    count: int,
    room: tuple[Array, Array, Ints, Ints, Array, Array, Array],
) -> int:
    """Add the contact points of two solids that are at most a distance apart [m]."""
    polygon, other_polygon, names, other_names, planes, nearest, heights = room
    from_i, face_i = _facing(bodies, solids, i, j, corners, planes[0])
    if from_i > reach:
        return count
    from_j, face_j = _facing(bodies, solids, j, i, corners, planes[1])
    if from_j > reach:
        return count
    on_i = from_i >= from_j - 1e-7
    lower, upper, face, plane = (i, j, face_i, planes[0]) if on_i else (j, i, face_j, planes[1])
    apart = from_i if on_i else from_j
    radius = min(solids.radius[i], solids.radius[j])
    cosine, opposite = _opposite(bodies, solids, upper, plane)
    # A rounded edge is no part of a face. Two flat faces may be warped against each other by their edge radius.
    inset, accepted = (0.0, radius) if cosine < -FLAT else (radius, SLIGHT * radius)
    area = _common_area(
        solids, lower, face, upper, opposite, corners, plane, inset, polygon, other_polygon, names, other_names
    )
    sign = 1.0 if on_i else -1.0
    nearest_corner = np.inf
    for k in range(area):
        gap = plane[0] * polygon[k, 0] + plane[1] * polygon[k, 1] + plane[2] * polygon[k, 2] - plane[3]
        nearest_corner = min(nearest_corner, gap)
    rubbing = solids.friction[solids.surface[i], solids.surface[j]]
    pair, on = (i, j), (solids.body[i], solids.body[j])
    normal, at = np.empty(3), np.empty(3)
    if nearest_corner <= apart + accepted:
        for k in range(area):
            gap = plane[0] * polygon[k, 0] + plane[1] * polygon[k, 1] + plane[2] * polygon[k, 2] - plane[3]
            if gap < reach:
                for axis in range(3):
                    normal[axis] = sign * plane[axis]
                    at[axis] = polygon[k, axis] - 0.5 * gap * plane[axis]
                key = (names[k] * 64 + (face - solids.face[lower]) % 64) * 2 + int(on_i)
                count = _add(bodies, points, count, pair, on, key, normal, at, gap, rubbing)
        return count
    return _where_edges_meet(
        bodies, solids, (i, j), cores, radius, reach, sign, plane, points, count, nearest, heights, rubbing
    )


@compiled
def _where_edges_meet(
    bodies: Bodies,
    solids: Solids,
    pair: tuple[int, int],
    cores: Array,
    radius: float,
    reach: float,
    sign: float,
    plane: Array,
    points: Points,
    count: int,
    nearest: Array,
    heights: Array,
    rubbing: float,
) -> int:
    i, j = pair
    on = (solids.body[i], solids.body[j])
    distance, a, b = _nearest_edges(solids, i, j, cores, sign, plane, reach + 2.0 * radius, nearest, heights)
    if a < 0:
        return count
    if distance - 2.0 * radius > reach:
        return count
    normal, at, found = np.empty(3), np.empty(3), nearest[0]
    key = -1 - 2 * ((a - solids.edge[i]) * 4096 + b - solids.edge[j])
    if distance < DEEP * radius:  # so deep that only a face has a normal
        for axis in range(3):
            normal[axis] = sign * plane[axis]
            at[axis] = 0.5 * (found[axis] + found[3 + axis])
        return _add(bodies, points, count, pair, on, key, normal, at, distance - 2.0 * radius, rubbing)
    for axis in range(3):
        normal[axis] = (found[3 + axis] - found[axis]) / distance
    v, w = cores[solids.corner[i] + solids.edges[a, 0]], cores[solids.corner[j] + solids.edges[b, 0]]
    d = cores[solids.corner[i] + solids.edges[a, 1]] - v
    e = cores[solids.corner[j] + solids.edges[b, 1]] - w
    dd, de, ee = np.sum(d * d), np.sum(d * e), np.sum(e * e)
    if de * de > PARALLEL * dd * ee:  # two points at the ends of the common part
        start, end = np.sum((w - v) * d) / dd, np.sum((w + e - v) * d) / dd
        low, high = max(0.0, min(start, end)), min(1.0, max(start, end))
        if high - low > COMMON:
            for side in range(2):
                share = low if side == 0 else high
                on_first, on_second = v + share * d, w + (share - start) / (end - start) * e
                gap = np.sum(normal * (on_second - on_first)) - 2.0 * radius
                if gap < reach:
                    at[:] = 0.5 * (on_first + on_second)
                    count = _add(bodies, points, count, pair, on, key - side, normal, at, gap, rubbing)
            return count
    for axis in range(3):
        at[axis] = 0.5 * (found[axis] + found[3 + axis])
    return _add(bodies, points, count, pair, on, key, normal, at, distance - 2.0 * radius, rubbing)


@compiled
def _nearest_edges(
    solids: Solids,
    i: int,
    j: int,
    cores: Array,
    sign: float,
    plane: Array,
    reach: float,
    nearest: Array,
    heights: Array,
) -> tuple[float, int, int]:
    """Return the distance of the nearest edges of two cores [m], and these; their nearest points are in `nearest[0]`.

    Edges that are further apart than `reach` [m] along the normal of a plane are left out; -1 if all are.
    """
    least, shortest, first, second = np.inf, np.inf, -1, -1
    for solid in (i, j):
        for c in range(solids.corner[solid], solids.corner[solid + 1]):
            heights[c] = sign * (plane[0] * cores[c, 0] + plane[1] * cores[c, 1] + plane[2] * cores[c, 2])
    for a in range(solids.edge[i], solids.edge[i + 1]):
        v, w = solids.corner[i] + solids.edges[a, 0], solids.corner[i] + solids.edges[a, 1]
        top = max(heights[v], heights[w])
        for b in range(solids.edge[j], solids.edge[j + 1]):
            p, q = solids.corner[j] + solids.edges[b, 0], solids.corner[j] + solids.edges[b, 1]
            if min(heights[p], heights[q]) - top > reach:
                continue
            square, parallel = _apart(cores, v, w, p, q, nearest)
            preferred = FAVOURED * square if parallel else square  # parallel edges touch others at their ends, too
            if preferred < least:
                least, shortest, first, second = preferred, square, a, b
                reach = min(reach, sqrt(square))
                for k in range(6):
                    nearest[0, k] = nearest[1, k]
    return sqrt(shortest), first, second


@compiled
def _apart(x: Array, v: int, w: int, p: int, q: int, nearest: Array) -> tuple[float, bool]:
    """Return the squared distance of two segments between points x [m2], and whether they are parallel.

    Their nearest points are in `nearest[1]` (Ericson, "Real-Time Collision Detection", 5.1.9).
    """
    dx, dy, dz = x[w, 0] - x[v, 0], x[w, 1] - x[v, 1], x[w, 2] - x[v, 2]
    ex, ey, ez = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    rx, ry, rz = x[v, 0] - x[p, 0], x[v, 1] - x[p, 1], x[v, 2] - x[p, 2]
    dd, ee, de = dx * dx + dy * dy + dz * dz, ex * ex + ey * ey + ez * ez, dx * ex + dy * ey + dz * ez
    dr, er = dx * rx + dy * ry + dz * rz, ex * rx + ey * ry + ez * rz
    flat = dd * ee - de * de
    s = min(1.0, max(0.0, (de * er - dr * ee) / flat)) if flat > 1e-12 * dd * ee else 0.0
    t = (de * s + er) / ee
    if t < 0.0:
        s, t = min(1.0, max(0.0, -dr / dd)), 0.0
    elif t > 1.0:
        s, t = min(1.0, max(0.0, (de - dr) / dd)), 1.0
    a, b, c = x[v, 0] + s * dx, x[v, 1] + s * dy, x[v, 2] + s * dz
    d, e, f = x[p, 0] + t * ex, x[p, 1] + t * ey, x[p, 2] + t * ez
    nearest[1, 0], nearest[1, 1], nearest[1, 2] = a, b, c
    nearest[1, 3], nearest[1, 4], nearest[1, 5] = d, e, f
    return (a - d) ** 2 + (b - e) ** 2 + (c - f) ** 2, de * de > PARALLEL * dd * ee


@compiled
def carry_over(points: Points, count: int, before: Points, earlier: int) -> None:
    """Start the points that were there in the last step with their impulses."""
    start = 0
    for c in range(count):
        i, j = points.solids[c]
        while start < earlier and _comes_before(before.solids[start, 0], before.solids[start, 1], i, j):
            start += 1
        k = start
        while k < earlier and before.solids[k, 0] == i and before.solids[k, 1] == j:
            if before.key[k] == points.key[c]:
                r, s = points.row[c], before.row[k]
                x = s[RUBS] * s[3] + s[RUBS_ACROSS] * s[6]
                y = s[RUBS] * s[4] + s[RUBS_ACROSS] * s[7]
                z = s[RUBS] * s[5] + s[RUBS_ACROSS] * s[8]
                r[PRESSES], r[FRESH] = s[PRESSES], 0.0
                r[RUBS] = x * r[3] + y * r[4] + z * r[5]
                r[RUBS_ACROSS] = x * r[6] + y * r[7] + z * r[8]
                break
            k += 1


@compiled
def _comes_before(a: int, b: int, i: int, j: int) -> bool:
    """Compare two pairs in the order of `contacts`: half-spaces by solid and number, then solids."""
    if a < 0 and i < 0:
        return b < j or (b == j and a > i)
    if a < 0 or i < 0:
        return a < 0
    return a < i or (a == i and b < j)
