"""Contact points and motion of rigid bodies in arrays, as machine code.

All compiled functions and the columns of their arrays are in this file, since machine code is kept until the file that
it was made from changes. Compiled functions take few arrays, as each costs time at every call and at compilation. So
what belongs together is in columns of one array. All quantities are in SI units.
"""

from collections.abc import Callable
from math import cos, pi, sin, sqrt
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Return the function as machine code, which is kept for later processes."""
    return cast("Function", njit(cache=True, error_model="numpy")(function))


# Columns of a rigid body: a brick, a welded group, or in the last row the world, which rests and has no mass.
# Body axes are the principal axes of inertia.
POSITION = 0  # 3: of the centre of mass, W [m]
TURN = 3  # 4: from body axes to W: x, y, z, w
MOTION = 7  # 6: velocity [m/s] and spin [rad/s], W
SPIN = 10
AXES = 13  # 9: rotation matrix by rows
INVERSE_MASS = 22  # [1/kg]; 0 of frozen bodies
INVERSE_MOMENTS = 23  # 3: [1/(kg m2)]
RESPONSE = 26  # 6: inverse inertia in W: xx, xy, xz, yy, yz, zz
REACH = 32  # of the farthest corner from the centre [m]
GUIDE = (
    33  # 7: 0, SLID or CARRIED; the prescribed velocity [m/s], and the unit axis along which a slid body moves freely
)
SLID, CARRIED = 1.0, 2.0
BODY_WIDTH = 40


class Solids(NamedTuple):
    """Convex solids of the bodies, in body axes, and half-spaces. Corners are counted from the first of their solid."""

    table: Ints  # (s + 1, 5) columns below; each range ends where that of the next row starts
    radius: Array  # (s,) of the edges [m]
    corners: Array  # (c, 6) corners, and those of the solid without its rounded edges [m]
    faces: Array  # (f, 4) outward normals, and heights over the centre of mass of the body [m]
    loops: Ints  # (f, ...) number of corners of a face, and these, counter-clockwise seen from outside
    edges: Ints  # (e, 2) corners at both ends
    friction: Array  # (k, k) of surfaces on each other
    planes: Array  # (p, 4) outward normals and heights of half-spaces
    on_planes: Array  # (k, p) friction of surfaces on half-spaces
    origin: Array  # (9,) a point [m], a direction and another point, by which the points of a pair are sorted, W


# Columns of `Solids.table`.
BODY, SURFACE = 0, 1  # row of the body, and of `friction`
CORNER, FACE, EDGE = 2, 3, 4  # first one


class Points(NamedTuple):
    """Contact points, sorted by pair of solids, those on half-spaces first."""

    ids: Ints  # (n, 4) columns below
    row: Array  # (n, WIDTH) all else, in the columns below


# Columns of `Points.ids`.
FIRST, SECOND = 0, 1  # solids that touch; the first is -1, -2, ... for half-spaces
ON_BODY, ON_OTHER = 2, 3  # rows of their bodies; the first is the world for half-spaces

# Columns of `Points.row`. The normal points from the first to the second body; the frame is in W.
NORMAL, ALONG, ACROSS = 0, 3, 6
ON_FIRST, ON_SECOND = 9, 12  # the point in axes of either body [m]
OFFSET = 15  # gap less the distance of the two points along the normal [m]
FRICTION = 16
RANK = 20  # 3: before the points are solved, then free
PRESSES, RUBS, RUBS_ACROSS = 17, 18, 19  # impulses [N s]
MASS, MASS_ACROSS = 20, 21  # effective masses [kg]
ARM_FIRST, ARM_SECOND = 22, 25  # from the centres, W [m]
GAP = 28  # [m]
EARLIER = 29  # impulse along the normal at the start of the sub-step [N s]
DRAGS, DRAGS_ACROSS = 30, 31  # slips along the two tangents after a unit of normal impulse [1/kg]
TURNS = 32  # spins of the first, then of the second body after unit impulses along the three axes [1/(kg m)]
SOFTNESS = 50  # share of the impulse that an overlap takes up
AT = 51  # the point on the second body at the start of the last sub-step, W [m]
WIDTH = 54

# Columns of links, after those of points: two bodies hold together at a point by a bounded force. The impulse along the
# normal is negative where it pulls.
TENSION, COHESION, SHEAR = 54, 55, 56  # [N]
PULLED, DRAGGED = 57, 58  # impulses along the normal and the tangents in earlier sub-steps of this time step [N s]
LINK_WIDTH = 59


class Pairs(NamedTuple):
    """Pairs of solids whose bounding boxes overlap, sorted."""

    code: Ints  # (n,) number of the first solid, times the number of all solids, plus that of the second
    axis: Array  # (n, 3) unit axis from the first to the second along which they were apart, W; 0 if unknown


def no_points(most: int) -> Points:
    """Return room for contact points."""
    return Points(np.zeros((most, 4), np.int64), np.zeros((most, WIDTH)))


def no_links(count: int = 0) -> Points:
    """Return room for links."""
    return Points(np.zeros((count, 4), np.int64), np.zeros((count, LINK_WIDTH)))


def no_pairs() -> Pairs:
    """Return no pairs."""
    return Pairs(np.zeros(0, np.int64), np.zeros((0, 3)))


# Contact points of convex solids with each other and with half-spaces.
#
# Model: edges are slightly rounded. If one solid lies on a face of another, the normal is that of the face, and the
# points are the corners of the common area. Otherwise edges meet, and the normal joins the nearest points of the two
# solids without their rounded edges, which is also right for parallel edges.


MOST_CORNERS = 128  # of a common area
FLAT = 0.9998  # cosine of the angle between two faces that touch along an area
LINE = 2  # corners of an area without width
NARROW = 2.0  # edge radii, for areas of two flat faces
SLIGHT = 0.01  # times the edge radius
SAME = 1e-9  # [m] accepted distance of a corner beyond the side of a face
EITHER = 1e-7  # [m] within which the face of the first solid is taken, if two solids are equally far from each other's
PARALLEL = 0.997  # squared cosine of the angle between two edges that touch along a line
SIDEWAYS = 0.7  # cosine: a normal closer than that to an axis takes another axis as the reference of its tangents
FAVOURED = 0.999  # factor of the squared distance of parallel edges
COMMON = 0.02  # least common part of parallel edges, as a share of the first
WARPED = 0.3  # times the edge radius by which an edge may be warped against a face that it lies in
ALIKE = 0.98  # cosine of the angle between the normals of two points of such an edge
SHARP = 4.0  # times the edge radius within which cores are, when sharp edges touch
DEEP = 0.05  # times the edge radius: cores that are closer have no normal
ALIKE_FAR = 1e-7  # [m] difference below which two points are equally far from a disturbance

# Columns of placed corners, in W.
CORE, HEIGHT = 3, 6  # after the corner: that without rounded edges [m], and its height along an axis [m]
PLACED_WIDTH = 7

# Rows of the scratch space of a pair.
LOWER_PLANE, UPPER_PLANE, NEAREST, CANDIDATE = 0, 1, 2, 3


@compiled
def contacts(
    bodies: Array,
    solids: Solids,
    points: Points,
    order: Ints,
    earlier: Pairs,
    duration: float,
    near: float,
    sharp: bool,
) -> tuple[int, Pairs]:
    """Find all points at which bodies touch or may touch within a duration [s].

    Return their number, and the pairs that were compared. The points are in `points`, if there is room for all. `near`
    is the least gap at which a point counts [m]. `order` are the solids, sorted along an axis the last time; `earlier`
    are the pairs of the last time. Edges are `sharp` before the first hit. Later they are rounded, so that a brick that
    is thrown into a gap of its own thickness may slip in.
    """
    table, n = solids.table, len(solids.table) - 1
    placed, reach = placed_corners(bodies, table, solids.corners), np.empty(n)
    boxes = bounding_boxes(table, placed)
    for i in range(n):
        b = table[i, BODY]
        speed, spin = _length(bodies[b, MOTION:SPIN]), _length(bodies[b, SPIN:AXES])
        reach[i] = near + duration * (speed + bodies[b, REACH] * spin)
        for k in range(3):
            boxes[i, k] -= reach[i]
            boxes[i, 3 + k] += reach[i]
    count = int(np.int64(0))  # no literal, for which numba would compile the functions below once more
    for i in range(n):
        if bodies[table[i, BODY], INVERSE_MASS] > 0.0:
            for p in range(len(solids.planes)):
                rubbing, known = solids.on_planes[table[i, SURFACE], p], count
                count = _on_plane(bodies, table, i, placed, solids.planes, p, rubbing, reach[i], points, count)
                _sort_points(bodies, points, known, count, solids.origin)
    polygons = np.empty((2, MOST_CORNERS, 3))
    scratch, codes = np.empty((4, 8)), _close_pairs(bodies, table, boxes, order)
    axes, start = np.zeros((len(codes), 3)), 0
    for k in range(len(codes)):
        while start < len(earlier.code) and earlier.code[start] < codes[k]:
            start += 1
        i, j = codes[k] // n, codes[k] % n
        within, radius = reach[i] + reach[j], min(solids.radius[i], solids.radius[j])
        rounded = 0.0 if sharp else radius
        if start < len(earlier.code) and earlier.code[start] == codes[k]:
            for axis in range(3):
                axes[k, axis] = earlier.axis[start, axis]
            if _separation(table, i, j, placed, axes, k) > within:
                continue
        rubbing, known = solids.friction[table[i, SURFACE], table[j, SURFACE]], count
        for attempt in range(
            2
        ):  # the second if the solids are so deep in each other that the nearest edges tell nothing
            count = _along_faces(
                bodies,
                solids,
                i,
                j,
                placed,
                within,
                radius,
                rubbing,
                axes,
                k,
                points,
                known,
                polygons,
                scratch,
                attempt,
            )
            if count < 0:
                count = _where_edges_meet(
                    bodies, solids, i, j, placed, within, radius, rounded, rubbing, axes, k, points, known, scratch
                )
            if count >= 0:
                break
        _sort_points(bodies, points, known, count, solids.origin)
    return count, Pairs(codes, axes)


@compiled
def _sort_points(bodies: Array, points: Points, start: int, end: int, origin: Array) -> None:
    """Sort the points of a pair by where they are.

    In the order of the corners of a shape, the result would depend on how a shape is turned or mirrored.
    """
    ids, row = points.ids, points.row
    if end > len(ids):
        return
    for c in range(start, end):
        b = ids[c, ON_OTHER]
        x, y, z = row[c, ON_SECOND], row[c, ON_SECOND + 1], row[c, ON_SECOND + 2]
        far = along = aside = 0.0
        for k in range(3):
            column = AXES + 3 * k
            turned = bodies[b, column] * x + bodies[b, column + 1] * y + bodies[b, column + 2] * z
            at = bodies[b, POSITION + k] + turned
            far += (at - origin[k]) ** 2
            along += (at - origin[k]) * origin[3 + k]
            aside += (at - origin[6 + k]) ** 2
        # In columns that are not in use yet.
        row[c, RANK], row[c, RANK + 1], row[c, RANK + 2] = sqrt(far), along, sqrt(aside)
        k = c
        while k > start and _comes_later(row, k - 1, k):
            for column in range(4):
                ids[k - 1, column], ids[k, column] = ids[k, column], ids[k - 1, column]
            for column in range(RANK + 3):
                row[k - 1, column], row[k, column] = row[k, column], row[k - 1, column]
            k -= 1


@compiled
def _comes_later(row: Array, a: int, b: int) -> bool:
    """Compare the ranks of two points; almost equal numbers count as equal."""
    for column in range(RANK, RANK + 3):
        more: float = row[a, column] - row[b, column]
        if abs(more) > ALIKE_FAR:
            return more > 0.0
    return False


@compiled
def _length(vector: Array) -> float:
    return sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


@compiled
def placed_corners(bodies: Array, table: Ints, corners: Array) -> Array:
    """Return the corners of all solids in W, with and without rounded edges (c, 7) [m]; the last column is free."""
    placed = np.empty((len(corners), PLACED_WIDTH))
    for i in range(len(table) - 1):
        b = table[i, BODY]
        for c in range(table[i, CORNER], table[i + 1, CORNER]):
            for k in range(3):
                x, y, z = bodies[b, AXES + 3 * k], bodies[b, AXES + 3 * k + 1], bodies[b, AXES + 3 * k + 2]
                at = bodies[b, POSITION + k]
                placed[c, k] = at + x * corners[c, 0] + y * corners[c, 1] + z * corners[c, 2]
                placed[c, 3 + k] = at + x * corners[c, 3] + y * corners[c, 4] + z * corners[c, 5]
    return placed


@compiled
def bounding_boxes(table: Ints, placed: Array) -> Array:
    """Return the lowest and the highest coordinates of all solids (n, 6), from their placed corners [m]."""
    boxes = np.empty((len(table) - 1, 6))
    for i in range(len(boxes)):
        for k in range(3):
            low, high = np.inf, -np.inf
            for c in range(table[i, CORNER], table[i + 1, CORNER]):
                low, high = min(low, placed[c, k]), max(high, placed[c, k])
            boxes[i, k], boxes[i, 3 + k] = low, high
    return boxes


@compiled
def near_boxes(boxes: Array, planes: Array, i: int, within: float) -> Ints:
    """Return the numbers of the boxes within a distance [m] of box i, itself included; -1, -2, ... for half-spaces."""
    found, count = np.empty(len(boxes) + len(planes), np.int64), 0
    for p in range(len(planes)):
        height = -planes[p, 3]
        for k in range(3):
            height += planes[p, k] * (boxes[i, k] if planes[p, k] > 0.0 else boxes[i, 3 + k])
        if height <= within:
            found[count] = -1 - p
            count += 1
    for j in range(len(boxes)):
        if _overlap(boxes, i, j, within):
            found[count] = j
            count += 1
    return found[:count]


@compiled
def _overlap(boxes: Array, i: int, j: int, within: float) -> bool:
    apart = False
    for k in range(3):
        apart = apart or boxes[i, k] - within > boxes[j, 3 + k] or boxes[j, k] > boxes[i, 3 + k] + within
    return not apart


@compiled
def _close_pairs(bodies: Array, table: Ints, boxes: Array, order: Ints) -> Ints:
    """Return the pairs of solids whose bounding boxes overlap, as i n + j with i < j, sorted."""
    n = len(order)
    axis, widest = 0, -1.0
    for k in range(3):
        mean = spread = 0.0
        for i in range(n):
            mean += boxes[i, k] / n
        for i in range(n):
            spread += (boxes[i, k] - mean) ** 2
        if spread > widest:
            axis, widest = k, spread
    for i in range(1, n):  # insertion sort: the order hardly changes between steps
        moved, j = order[i], i - 1
        while j >= 0 and boxes[order[j], axis] > boxes[moved, axis]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = moved
    pairs, count = np.empty(8 * n + 8, np.int64), 0
    for one in range(n):
        i = order[one]
        still = bodies[table[i, BODY], INVERSE_MASS] == 0.0
        for another in range(one + 1, n):
            j = order[another]
            if boxes[j, axis] > boxes[i, 3 + axis]:
                break
            if table[i, BODY] == table[j, BODY] or (still and bodies[table[j, BODY], INVERSE_MASS] == 0.0):
                continue
            if not _overlap(boxes, i, j, 0.0):
                continue
            if count == len(pairs):
                longer = np.empty(2 * count, np.int64)
                for k in range(count):
                    longer[k] = pairs[k]
                pairs = longer
            pairs[count] = min(i, j) * n + max(i, j)
            count += 1
    _sort(pairs, count)
    return pairs[:count]


@compiled
def _sort(numbers: Ints, count: int) -> None:
    """Sort the first numbers (Shell's method: that of the library takes two seconds to compile)."""
    gap = count // 2
    while gap > 0:
        for i in range(gap, count):
            moved, j = numbers[i], i
            while j >= gap and numbers[j - gap] > moved:
                numbers[j] = numbers[j - gap]
                j -= gap
            numbers[j] = moved
        gap //= 2


@compiled
def _add(
    bodies: Array,
    points: Points,
    count: int,
    solids: tuple[int, int],
    on: tuple[int, int],
    normal: tuple[float, float, float],
    at: tuple[float, float, float],
    gap: float,
    friction: float,
) -> int:
    """Add a point of W in the middle of a gap [m]; return the number of points."""
    index, r = points.ids, points.row
    if count >= len(index):
        return count + 1
    r[count, PRESSES] = r[count, RUBS] = r[count, RUBS_ACROSS] = 0.0
    index[count, FIRST], index[count, SECOND] = solids
    index[count, ON_BODY], index[count, ON_OTHER] = on
    x, y, z = normal
    r[count, 0], r[count, 1], r[count, 2] = x, y, z
    if abs(y) < SIDEWAYS:
        a, b, c = z, 0.0, -x
    else:
        a, b, c = 0.0, -z, y
    long = 1.0 / sqrt(a * a + b * b + c * c)
    a, b, c = long * a, long * b, long * c
    r[count, 3], r[count, 4], r[count, 5] = a, b, c
    r[count, 6], r[count, 7], r[count, 8] = y * c - z * b, z * a - x * c, x * b - y * a
    for side in range(2):
        i = on[side]  # the axes of the world are 0, so that the offset holds its part of the gap
        u, v, w = at[0] - bodies[i, POSITION], at[1] - bodies[i, POSITION + 1], at[2] - bodies[i, POSITION + 2]
        for k in range(3):
            column = AXES + k
            r[count, 9 + 3 * side + k] = bodies[i, column] * u + bodies[i, column + 3] * v + bodies[i, column + 6] * w
    r[count, OFFSET], r[count, FRICTION] = gap, friction
    return count + 1


@compiled
def load(bodies: Array, points: Points, count: int, loads: Array, slack: float) -> int:
    """Add points that bear given forces, after the contact points; return the number of all points.

    Each load (m, 9) has the row of its body, its force [N], the direction in which it presses, its place in W [m], and
    its friction. The points rub like contacts, on bodies at rest. A body at rest from which a load comes is kept at a
    distance [m]: it would press beside its load, and jam the body.
    """
    total = np.zeros((len(bodies), 3))
    for k in range(len(loads)):
        for axis in range(3):
            total[int(loads[k, 0]), axis] += loads[k, 1] * loads[k, 2 + axis]
    for c in range(count):
        a, b, r = points.ids[c, ON_BODY], points.ids[c, ON_OTHER], points.row[c]
        on_a = total[a, 0] * r[0] + total[a, 1] * r[1] + total[a, 2] * r[2]
        on_b = total[b, 0] * r[0] + total[b, 1] * r[1] + total[b, 2] * r[2]
        from_b = on_a < -SIDEWAYS * _length(total[a]) and bodies[b, INVERSE_MASS] == 0.0
        if from_b or (on_b > SIDEWAYS * _length(total[b]) and bodies[a, INVERSE_MASS] == 0.0):
            r[OFFSET] += slack
    for k in range(len(loads)):
        s, on = loads[k], int(loads[k, 0])
        place = (s[5], s[6], s[7])
        count = _add(bodies, points, count, (on, on), (len(bodies) - 1, on), (s[2], s[3], s[4]), place, s[1], s[8])
    return count


@compiled
def _on_plane(
    bodies: Array,
    table: Ints,
    i: int,
    placed: Array,
    planes: Array,
    p: int,
    rubbing: float,
    reach: float,
    points: Points,
    count: int,
) -> int:
    """Add the corners of a solid that are within reach of a half-space [m]."""
    x, y, z = planes[p, 0], planes[p, 1], planes[p, 2]
    for c in range(table[i, CORNER], table[i + 1, CORNER]):
        u, v, w = placed[c, 0], placed[c, 1], placed[c, 2]
        if x * u + y * v + z * w - planes[p, 3] < reach:
            on = (len(bodies) - 1, table[i, BODY])
            count = _add(bodies, points, count, (-1 - p, i), on, (x, y, z), (u, v, w), -planes[p, 3], rubbing)
    return count


@compiled
def _separation(table: Ints, i: int, j: int, placed: Array, axes: Array, k: int) -> float:
    """Return the gap between two solids along an axis from the first to the second [m]."""
    x, y, z, top, bottom = axes[k, 0], axes[k, 1], axes[k, 2], -np.inf, np.inf
    for c in range(table[i, CORNER], table[i + 1, CORNER]):
        top = max(top, x * placed[c, 0] + y * placed[c, 1] + z * placed[c, 2])
    for c in range(table[j, CORNER], table[j + 1, CORNER]):
        bottom = min(bottom, x * placed[c, 0] + y * placed[c, 1] + z * placed[c, 2])
    return bottom - top


@compiled
def _facing(bodies: Array, table: Ints, faces: Array, i: int, j: int, placed: Array, plane: Array) -> tuple[float, int]:
    """Return the largest distance of solid j from the plane of a face of solid i [m], with that face.

    The plane is stored.
    """
    b, other = table[i, BODY], table[j, BODY]
    p, q, r = bodies[b, POSITION], bodies[b, POSITION + 1], bodies[b, POSITION + 2]
    s, t, o = bodies[other, POSITION], bodies[other, POSITION + 1], bodies[other, POSITION + 2]
    farthest, face = -np.inf, -1
    for f in range(table[i, FACE], table[i + 1, FACE]):
        u, v, w = faces[f, 0], faces[f, 1], faces[f, 2]
        x = bodies[b, AXES] * u + bodies[b, AXES + 1] * v + bodies[b, AXES + 2] * w
        y = bodies[b, AXES + 3] * u + bodies[b, AXES + 4] * v + bodies[b, AXES + 5] * w
        z = bodies[b, AXES + 6] * u + bodies[b, AXES + 7] * v + bodies[b, AXES + 8] * w
        height = faces[f, 3] + x * p + y * q + z * r
        if x * s + y * t + z * o - height + bodies[other, REACH] < farthest:
            continue
        lowest = np.inf
        for c in range(table[j, CORNER], table[j + 1, CORNER]):
            lowest = min(lowest, x * placed[c, 0] + y * placed[c, 1] + z * placed[c, 2])
        if lowest - height > farthest:
            farthest, face = lowest - height, f
            plane[0], plane[1], plane[2], plane[3] = x, y, z, height
    return farthest, face


@compiled
def _opposite(bodies: Array, table: Ints, faces: Array, j: int, scratch: Array, plane: int) -> tuple[float, int]:
    """Return the cosine between the normal of a plane and the most opposite normal of a solid, with that face."""
    b, u, v, w = table[j, BODY], scratch[plane, 0], scratch[plane, 1], scratch[plane, 2]
    x = bodies[b, AXES] * u + bodies[b, AXES + 3] * v + bodies[b, AXES + 6] * w
    y = bodies[b, AXES + 1] * u + bodies[b, AXES + 4] * v + bodies[b, AXES + 7] * w
    z = bodies[b, AXES + 2] * u + bodies[b, AXES + 5] * v + bodies[b, AXES + 8] * w
    least, face = np.inf, -1
    for f in range(table[j, FACE], table[j + 1, FACE]):
        cosine = x * faces[f, 0] + y * faces[f, 1] + z * faces[f, 2]
        if cosine < least:
            least, face = cosine, f
    return least, face


@compiled
def _common_area(
    table: Ints,
    loops: Ints,
    i: int,
    face: int,
    j: int,
    other: int,
    placed: Array,
    scratch: Array,
    plane: int,
    inset: float,
    polygons: Array,
) -> int:
    """Clip a face of solid j by the sides of a face of solid i, moved inwards; return the number of corners left.

    They are in the first of the two polygons.
    """
    count, of_i, of_j = loops[other, 0], table[i, CORNER], table[j, CORNER]
    p, q, r = scratch[plane, 0], scratch[plane, 1], scratch[plane, 2]
    for k in range(count):
        corner = loops[other, 1 + k]
        for axis in range(3):
            polygons[0, k, axis] = placed[of_j + corner, axis]
    sides = loops[face, 0]
    for side in range(sides):
        v, w = of_i + loops[face, 1 + side], of_i + loops[face, 1 + (side + 1) % sides]
        a, b, c = placed[w, 0] - placed[v, 0], placed[w, 1] - placed[v, 1], placed[w, 2] - placed[v, 2]
        x, y, z = b * r - c * q, c * p - a * r, a * q - b * p
        long = 1.0 / sqrt(x * x + y * y + z * z)
        x, y, z = long * x, long * y, long * z
        height, kept = x * placed[v, 0] + y * placed[v, 1] + z * placed[v, 2] - inset, 0
        there = x * polygons[0, 0, 0] + y * polygons[0, 0, 1] + z * polygons[0, 0, 2] - height
        for k in range(count):
            following, here = (k + 1) % count, there
            there = (
                x * polygons[0, following, 0] + y * polygons[0, following, 1] + z * polygons[0, following, 2] - height
            )
            if here <= SAME:
                for axis in range(3):
                    polygons[1, kept, axis] = polygons[0, k, axis]
                kept += 1
            if (here <= SAME) != (there <= SAME) and kept < MOST_CORNERS:
                share = (here - SAME) / (here - there)
                for axis in range(3):
                    polygons[1, kept, axis] = (1.0 - share) * polygons[0, k, axis] + share * polygons[
                        0, following, axis
                    ]
                kept += 1
        count = min(kept, MOST_CORNERS - 1)
        for k in range(count):
            for axis in range(3):
                polygons[0, k, axis] = polygons[1, k, axis]
        if count == 0:
            break
    return int(count)


@compiled
def _without_flat_corners(polygons: Array, count: int, slight: float) -> int:
    """Remove the corners of an area that lie within a distance [m] of the line between their neighbours.

    Where sides of two faces are almost flush, they cross anywhere, and a point there would jump from step to step.
    """
    c = 0
    while c < count and count > LINE:
        before, after = (c + count - 1) % count, (c + 1) % count
        x, y, z = polygons[0, before, 0], polygons[0, before, 1], polygons[0, before, 2]
        a, b, d = polygons[0, after, 0] - x, polygons[0, after, 1] - y, polygons[0, after, 2] - z
        x, y, z = polygons[0, c, 0] - x, polygons[0, c, 1] - y, polygons[0, c, 2] - z
        p, q, r = y * d - z * b, z * a - x * d, x * b - y * a
        if p * p + q * q + r * r > slight * slight * (a * a + b * b + d * d):
            c += 1
            continue
        for k in range(c, count - 1):
            for axis in range(3):
                polygons[0, k, axis] = polygons[0, k + 1, axis]
        count -= 1
    return int(count)


@compiled
def _is_narrow(polygons: Array, count: int, normal: tuple[float, float, float], radius: float) -> bool:
    """Check that an area is hardly wider than the rounded edges of a face: two edges meet there."""
    x, y, z = normal
    double, around = 0.0, 0.0
    for c in range(count):
        after = (c + 1) % count
        a, b, d = polygons[0, c, 0], polygons[0, c, 1], polygons[0, c, 2]
        e, f, g = polygons[0, after, 0] - a, polygons[0, after, 1] - b, polygons[0, after, 2] - d
        a, b, d = a - polygons[0, 0, 0], b - polygons[0, 0, 1], d - polygons[0, 0, 2]
        double += x * (b * g - d * f) + y * (d * e - a * g) + z * (a * f - b * e)
        around += sqrt(e * e + f * f + g * g)
    return abs(double) < NARROW * radius * around


@compiled
def _along_faces(
    bodies: Array,
    solids: Solids,
    i: int,
    j: int,
    placed: Array,
    reach: float,
    radius: float,
    rubbing: float,
    axes: Array,
    k: int,
    points: Points,
    count: int,
    polygons: Array,
    scratch: Array,
    attempt: int,
) -> int:
    """Add the points of two solids of which one lies on a face of the other; return the number of points.

    Return -1 if their edges may meet, at the first attempt; the plane of the face is then the first row of the scratch
    space. If the face is further away than `reach` [m], its normal is stored as axis k.
    """
    table, faces = solids.table, solids.faces
    from_i, face_i = _facing(bodies, table, faces, i, j, placed, scratch[LOWER_PLANE])
    if from_i > reach:
        for axis in range(3):
            axes[k, axis] = scratch[LOWER_PLANE, axis]
        return count
    from_j, face_j = _facing(bodies, table, faces, j, i, placed, scratch[UPPER_PLANE])
    if from_j > reach:
        for axis in range(3):
            axes[k, axis] = -scratch[UPPER_PLANE, axis]
        return count
    on_i = from_i >= from_j - EITHER
    lower, upper, face, plane = (i, j, face_i, LOWER_PLANE) if on_i else (j, i, face_j, UPPER_PLANE)
    sign, apart = (1.0, from_i) if on_i else (-1.0, from_j)
    cosine, opposite = _opposite(bodies, table, faces, upper, scratch, plane)
    # A rounded edge is no part of a face. Two flat faces may be warped against each other by their edge radius.
    inset, accepted = (0.0, radius) if cosine < -FLAT else (radius, SLIGHT * radius)
    area = _common_area(table, solids.loops, lower, face, upper, opposite, placed, scratch, plane, inset, polygons)
    area = _without_flat_corners(polygons, area, SLIGHT * radius)
    x, y, z, height = scratch[plane, 0], scratch[plane, 1], scratch[plane, 2], scratch[plane, 3]
    nearest_corner = np.inf
    for c in range(area):
        gap = x * polygons[0, c, 0] + y * polygons[0, c, 1] + z * polygons[0, c, 2] - height
        nearest_corner = min(nearest_corner, gap)
    is_line = cosine < -FLAT and _is_narrow(polygons, area, (x, y, z), radius)
    if attempt == 0 and (is_line or nearest_corner > apart + accepted):
        scratch[LOWER_PLANE, 0], scratch[LOWER_PLANE, 1], scratch[LOWER_PLANE, 2] = sign * x, sign * y, sign * z
        return -1
    for c in range(area):
        u, v, w = polygons[0, c, 0], polygons[0, c, 1], polygons[0, c, 2]
        gap = x * u + y * v + z * w - height
        if gap < reach:
            half = 0.5 * gap
            count = _add(
                bodies,
                points,
                count,
                (i, j),
                (table[i, BODY], table[j, BODY]),
                (sign * x, sign * y, sign * z),
                (u - half * x, v - half * y, w - half * z),
                gap,
                rubbing,
            )
    return count


@compiled
def _where_edges_meet(
    bodies: Array,
    solids: Solids,
    i: int,
    j: int,
    placed: Array,
    reach: float,
    radius: float,
    rounded: float,
    rubbing: float,
    axes: Array,
    k: int,
    points: Points,
    count: int,
    scratch: Array,
) -> int:
    """Add the points at which the edges of two solids are within reach [m]; their normal is stored as axis k.

    Return -1 if the solids without their rounded edges overlap.
    """
    table, edges = solids.table, solids.edges
    x, y, z, within = axes[k, 0], axes[k, 1], axes[k, 2], reach + SHARP * radius
    if x == 0.0 and y == 0.0 and z == 0.0:  # along an axis that may be poor, all edges are compared
        x, y, z, within = scratch[LOWER_PLANE, 0], scratch[LOWER_PLANE, 1], scratch[LOWER_PLANE, 2], np.inf
    _heights(table, i, j, placed, x, y, z)
    distance, a, b = _nearest_edges(table, edges, i, j, placed, within, scratch)
    if a < 0:
        return count
    p, q, r = scratch[NEAREST, 0], scratch[NEAREST, 1], scratch[NEAREST, 2]
    s, t, o = scratch[NEAREST, 3], scratch[NEAREST, 4], scratch[NEAREST, 5]
    deep = distance < DEEP * radius  # so deep that only a face has a normal
    if deep:
        x, y, z = scratch[LOWER_PLANE, 0], scratch[LOWER_PLANE, 1], scratch[LOWER_PLANE, 2]
    else:
        x, y, z = (s - p) / distance, (t - q) / distance, (o - r) / distance
        axes[k, 0], axes[k, 1], axes[k, 2] = x, y, z
        _heights(table, i, j, placed, x, y, z)
        if _between(table, i, j, placed) < 0.5 * distance:
            axes[k, 0] = axes[k, 1] = axes[k, 2] = 0.0
            return -1
    pair, on = (i, j), (table[i, BODY], table[j, BODY])
    v, w = table[i, CORNER] + edges[a, 0], table[j, CORNER] + edges[b, 0]
    d, e, f = _along(placed, v, table[i, CORNER] + edges[a, 1])
    g, h, m = _along(placed, w, table[j, CORNER] + edges[b, 1])
    square, cosine = d * d + e * e + f * f, d * g + e * h + f * m
    if not deep and cosine * cosine > PARALLEL * square * (g * g + h * h + m * m):  # two points at the ends of a line
        start = _share(placed, v, w, (d, e, f), square)
        end = start + cosine / square
        low, high = max(0.0, min(start, end)), min(1.0, max(start, end))
        if high - low > COMMON:
            for side in range(2):
                share = low if side == 0 else high
                other = (share - start) / (end - start)
                gap, at = _edge_gap(table, edges, i, j, a, b, placed, share, other, (x, y, z), rounded)
                if gap < reach:
                    count = _add(bodies, points, count, pair, on, (x, y, z), at, gap, rubbing)
            return count
    gap, at = _edge_gap(table, edges, i, j, a, b, placed, scratch[NEAREST, 6], scratch[NEAREST, 7], (x, y, z), rounded)
    if gap > reach:
        return count
    count = _add(bodies, points, count, pair, on, (x, y, z), at, gap, rubbing)
    if deep:
        return count
    distance, a, b = _farthest_edges(table, edges, i, j, placed, distance, radius, (x, y, z), scratch)
    if a < 0:
        return count
    p, q, r = scratch[NEAREST, 0], scratch[NEAREST, 1], scratch[NEAREST, 2]
    s, t, o = scratch[NEAREST, 3], scratch[NEAREST, 4], scratch[NEAREST, 5]
    normal = ((s - p) / distance, (t - q) / distance, (o - r) / distance)
    gap, at = _edge_gap(table, edges, i, j, a, b, placed, scratch[NEAREST, 6], scratch[NEAREST, 7], normal, rounded)
    return count if gap > reach else _add(bodies, points, count, pair, on, normal, at, gap, rubbing)


@compiled
def _edge_gap(
    table: Ints,
    edges: Ints,
    i: int,
    j: int,
    a: int,
    b: int,
    placed: Array,
    share: float,
    other: float,
    normal: tuple[float, float, float],
    rounded: float,
) -> tuple[float, tuple[float, float, float]]:
    """Return the gap along a normal between two edges at shares of their lengths, and the point between [m].

    If they are not rounded by a radius, rounding only gives the normal. With rounded edges, planks that lean on each
    other would fall by a tenth of a millimetre before they touch.
    """
    v, w = table[i, CORNER] + edges[a, 0], table[i, CORNER] + edges[a, 1]
    u, z = table[j, CORNER] + edges[b, 0], table[j, CORNER] + edges[b, 1]
    first = CORE if rounded > 0.0 else 0
    p = (1.0 - share) * placed[v, first] + share * placed[w, first]
    q = (1.0 - share) * placed[v, first + 1] + share * placed[w, first + 1]
    r = (1.0 - share) * placed[v, first + 2] + share * placed[w, first + 2]
    s = (1.0 - other) * placed[u, first] + other * placed[z, first]
    t = (1.0 - other) * placed[u, first + 1] + other * placed[z, first + 1]
    o = (1.0 - other) * placed[u, first + 2] + other * placed[z, first + 2]
    gap = (normal[0] * (s - p) + normal[1] * (t - q) + normal[2] * (o - r)) - 2.0 * rounded
    return gap, (0.5 * (p + s), 0.5 * (q + t), 0.5 * (r + o))


@compiled
def _heights(table: Ints, i: int, j: int, placed: Array, x: float, y: float, z: float) -> None:
    """Store the heights of the corners of two solids without rounded edges along an axis [m]."""
    for c in range(table[i, CORNER], table[i + 1, CORNER]):
        placed[c, HEIGHT] = x * placed[c, 3] + y * placed[c, 4] + z * placed[c, 5]
    for c in range(table[j, CORNER], table[j + 1, CORNER]):
        placed[c, HEIGHT] = x * placed[c, 3] + y * placed[c, 4] + z * placed[c, 5]


@compiled
def _between(table: Ints, i: int, j: int, placed: Array) -> float:
    """Return the gap between the heights of two solids without rounded edges [m]."""
    top, bottom = -np.inf, np.inf
    for c in range(table[i, CORNER], table[i + 1, CORNER]):
        top = max(top, placed[c, HEIGHT])
    for c in range(table[j, CORNER], table[j + 1, CORNER]):
        bottom = min(bottom, placed[c, HEIGHT])
    return bottom - top


@compiled
def _along(placed: Array, v: int, w: int) -> tuple[float, float, float]:
    """Return the edge between two corners without rounded edges [m]."""
    return placed[w, 3] - placed[v, 3], placed[w, 4] - placed[v, 4], placed[w, 5] - placed[v, 5]


@compiled
def _share(placed: Array, v: int, w: int, edge: tuple[float, float, float], square: float) -> float:
    """Return where corner w lies along an edge that starts at corner v, as a share of its length."""
    x, y, z = _along(placed, v, w)
    return (x * edge[0] + y * edge[1] + z * edge[2]) / square


@compiled
def _nearest_edges(
    table: Ints, edges: Ints, i: int, j: int, placed: Array, reach: float, scratch: Array
) -> tuple[float, int, int]:
    """Return the distance of the nearest edges of two solids without rounded edges [m], and these.

    Their nearest points are in the scratch space. Edges whose heights differ by more than `reach` [m] are left out; the
    edges are -1 if all are.
    """
    least, shortest, first, second = np.inf, np.inf, -1, -1
    for a in range(table[i, EDGE], table[i + 1, EDGE]):
        v, w = table[i, CORNER] + edges[a, 0], table[i, CORNER] + edges[a, 1]
        top = max(placed[v, HEIGHT], placed[w, HEIGHT])
        for b in range(table[j, EDGE], table[j + 1, EDGE]):
            p, q = table[j, CORNER] + edges[b, 0], table[j, CORNER] + edges[b, 1]
            if min(placed[p, HEIGHT], placed[q, HEIGHT]) - top > reach:
                continue
            square, parallel = _apart(placed, v, w, p, q, scratch)
            preferred = FAVOURED * square if parallel else square  # parallel edges touch others at their ends, too
            if preferred < least:
                least, shortest, first, second = preferred, square, a, b
                reach = min(reach, sqrt(square))
                for k in range(8):
                    scratch[NEAREST, k] = scratch[CANDIDATE, k]
    return sqrt(shortest), first, second


@compiled
def _farthest_edges(
    table: Ints,
    edges: Ints,
    i: int,
    j: int,
    placed: Array,
    distance: float,
    radius: float,
    normal: tuple[float, float, float],
    scratch: Array,
) -> tuple[float, int, int]:
    """Return the distance of two other edges that touch together with the nearest ones [m], and these.

    An edge that lies almost in a face crosses two edges of the face. Both crossings support it, so a second point is
    taken as far from the first as possible. The edges are -1 if there are none. Their nearest points replace those of
    the nearest edges, along whose normal the heights of the corners are given.
    """
    slack = WARPED * radius
    most, farthest = distance + slack, (2.0 * radius) ** 2
    x, y, z = scratch[NEAREST, 0], scratch[NEAREST, 1], scratch[NEAREST, 2]
    shortest, first, second = np.inf, -1, -1
    for a in range(table[i, EDGE], table[i + 1, EDGE]):
        v, w = table[i, CORNER] + edges[a, 0], table[i, CORNER] + edges[a, 1]
        top = max(placed[v, HEIGHT], placed[w, HEIGHT])
        for b in range(table[j, EDGE], table[j + 1, EDGE]):
            p, q = table[j, CORNER] + edges[b, 0], table[j, CORNER] + edges[b, 1]
            if min(placed[p, HEIGHT], placed[q, HEIGHT]) - top > most:
                continue
            square, parallel = _apart(placed, v, w, p, q, scratch)
            apart = sqrt(square)
            from_first = (scratch[CANDIDATE, 0] - x) ** 2
            from_first += (scratch[CANDIDATE, 1] - y) ** 2 + (scratch[CANDIDATE, 2] - z) ** 2
            if parallel or apart > most or from_first <= farthest:
                continue
            d = (scratch[CANDIDATE, 3] - scratch[CANDIDATE, 0]) / apart
            e = (scratch[CANDIDATE, 4] - scratch[CANDIDATE, 1]) / apart
            f = (scratch[CANDIDATE, 5] - scratch[CANDIDATE, 2]) / apart
            if d * normal[0] + e * normal[1] + f * normal[2] < ALIKE:
                continue
            highest, lowest = -np.inf, np.inf
            for c in range(table[i, CORNER], table[i + 1, CORNER]):
                highest = max(highest, d * placed[c, 3] + e * placed[c, 4] + f * placed[c, 5])
            for c in range(table[j, CORNER], table[j + 1, CORNER]):
                lowest = min(lowest, d * placed[c, 3] + e * placed[c, 4] + f * placed[c, 5])
            if lowest - highest >= apart - slack:
                farthest, shortest, first, second = from_first, apart, a, b
                for k in range(8):
                    scratch[NEAREST, k] = scratch[CANDIDATE, k]
    return shortest, first, second


@compiled
def _apart(placed: Array, v: int, w: int, p: int, q: int, scratch: Array) -> tuple[float, bool]:
    """Return the squared distance of two edges by their corners [m2], and whether they are parallel.

    Their nearest points are in the scratch space (Ericson, "Real-Time Collision Detection", 5.1.9).
    """
    dx, dy, dz = _along(placed, v, w)
    ex, ey, ez = _along(placed, p, q)
    rx, ry, rz = _along(placed, p, v)
    dd, ee, de = dx * dx + dy * dy + dz * dz, ex * ex + ey * ey + ez * ez, dx * ex + dy * ey + dz * ez
    dr, er = dx * rx + dy * ry + dz * rz, ex * rx + ey * ry + ez * rz
    flat = dd * ee - de * de
    s = min(1.0, max(0.0, (de * er - dr * ee) / flat)) if flat > 1e-12 * dd * ee else 0.0
    t = (de * s + er) / ee
    if t < 0.0:
        s, t = min(1.0, max(0.0, -dr / dd)), 0.0
    elif t > 1.0:
        s, t = min(1.0, max(0.0, (de - dr) / dd)), 1.0
    a, b, c = placed[v, 3] + s * dx, placed[v, 4] + s * dy, placed[v, 5] + s * dz
    d, e, f = placed[p, 3] + t * ex, placed[p, 4] + t * ey, placed[p, 5] + t * ez
    scratch[CANDIDATE, 0], scratch[CANDIDATE, 1], scratch[CANDIDATE, 2] = a, b, c
    scratch[CANDIDATE, 3], scratch[CANDIDATE, 4], scratch[CANDIDATE, 5] = d, e, f
    scratch[CANDIDATE, 6], scratch[CANDIDATE, 7] = s, t
    return (a - d) ** 2 + (b - e) ** 2 + (c - f) ** 2, de * de > PARALLEL * dd * ee


@compiled
def carry_over(points: Points, count: int, before: Points, earlier: int, within: float) -> None:
    """Start the points with the impulses of those that were at most `within` [m] from their places in the last step.

    Places are compared on both bodies, as the corners of a common area move with one of them. Corners of flush faces
    would have other names in each step.
    """
    index, index_before, rows, rows_before = points.ids, before.ids, points.row, before.row
    start = 0
    for c in range(count):
        i, j = index[c, FIRST], index[c, SECOND]
        while start < earlier and _comes_before(index_before[start, FIRST], index_before[start, SECOND], i, j):
            start += 1
        k, nearest, least = start, -1, within * within
        while k < earlier and index_before[k, FIRST] == i and index_before[k, SECOND] == j:
            on_first = on_second = 0.0
            for axis in range(3):
                on_first += (rows[c, ON_FIRST + axis] - rows_before[k, ON_FIRST + axis]) ** 2
                on_second += (rows[c, ON_SECOND + axis] - rows_before[k, ON_SECOND + axis]) ** 2
            apart = on_second if i < 0 else min(on_first, on_second)
            if apart < least and rows_before[k, SOFTNESS] > 0.0:
                nearest, least = k, apart
            k += 1
        if nearest >= 0:
            r, s = rows[c], rows_before[nearest]
            x = s[RUBS] * s[3] + s[RUBS_ACROSS] * s[6]
            y = s[RUBS] * s[4] + s[RUBS_ACROSS] * s[7]
            z = s[RUBS] * s[5] + s[RUBS_ACROSS] * s[8]
            r[PRESSES] = s[PRESSES]
            r[RUBS] = x * r[3] + y * r[4] + z * r[5]
            r[RUBS_ACROSS] = x * r[6] + y * r[7] + z * r[8]
            s[SOFTNESS] = 0.0  # no other point takes its impulse


@compiled
def _comes_before(a: int, b: int, i: int, j: int) -> bool:
    """Compare two pairs in the order of `contacts`: half-spaces by solid and number, then solids."""
    if a < 0 and i < 0:
        return b < j or (b == j and a > i)
    if a < 0 or i < 0:
        return a < 0
    return a < i or (a == i and b < j)


# Velocities and positions after a time step: Gauss-Seidel over the contact points with exact friction cones.
#
# A time step is split into sub-steps of a few tenths of a millisecond, whose sweeps start from the impulses of the last
# sub-step (Macklin et al., "Small steps in physics simulation", SCA 2019). An open gap may close within a sub-step and
# no more. An overlap is removed at a limited speed, which a last sweep takes out of the velocities again, so that it
# adds no energy (Catto, "Solver2D", 2024).
#
# Until the first hit contacts are hard and solved accurately, as small errors grow in a fall: with soft contacts a
# column near its limit falls 10 % too early. After it they are soft, as hard ones leave open which of many points
# carries a load: with them a plank that is hit in a wall moves by 13 % too little.


# A soft overlap is a damped spring of a quarter of the frequency of the sub-steps, with ten times critical damping.
PHASE, DAMPING = 0.5 * pi, 10.0
RATE = PHASE / (2.0 * DAMPING + PHASE)  # share of an overlap that a sub-step removes
SOFT = PHASE * (2.0 * DAMPING + PHASE) / (1.0 + PHASE * (2.0 * DAMPING + PHASE))
SMALL = 0.1  # share of the accuracy: changes of a body that affect others
MORE = 10  # times the sweeps and the accuracy in a sub-step with a hit
FEWEST = 4  # sweeps of a sub-step, of however many points: with two, walls of 500 bricks tremble for ever
SWEPT = 4000  # points that the sweeps of a sub-step without hits may solve, as those of tall towers converge slowly
UNCHANGED = 1e-300  # [kg] effective mass at a point whose force is given
STRAIGHT = 1e-4  # [rad] below which sine and cosine are those of their series


@compiled
def advance(
    bodies: Array,
    points: Points,
    count: int,
    ends: int,
    links: Points,
    timing: tuple[float, int, float],
    falling: tuple[int, float],
    struck: tuple[int, float],
    was_struck: bool,
    hit: float,
    recovery: float,
    depth: float,
    gravity_W: Array,
) -> bool:
    """Advance all bodies by a time step [s] in a number of sub-steps; return whether a hit has taken place so far.

    Before and after the first hit, each sub-step has at most a number of sweeps, until one changes all closing speeds
    by at most an accuracy [m/s]. A hit changes one by more than `hit` [m/s]. The points keep the impulses of the last
    sub-step. `recovery` is the speed at which overlaps are removed [m/s], `depth` the
    overlap of a body at rest at a soft point [m]. From point `count` to the end each point
    bears a given force. `timing` is the duration, the number of sub-steps, and the time since the mean forces of links
    are bounded [s].
    """
    duration, parts, since = timing
    h, moving, row = duration / parts, len(bodies) - 1, points.row
    index = points.ids
    stopped, moved, before = np.zeros(moving + 1, np.int64), np.full(moving + 1, -1), np.empty((moving, 6))
    weight = _weight(bodies, gravity_W)
    for c in range(count, ends):
        weight += row[c, OFFSET]
    for part in range(parts):
        for i in range(moving):
            stopped[i], moved[i] = 0, -1
            for k in range(6):
                before[i, k] = bodies[i, MOTION + k]
            if bodies[i, INVERSE_MASS] > 0.0:
                for k in range(3):
                    bodies[i, MOTION + k] += h * gravity_W[k]
                _spin_on(bodies, i, h)
                if bodies[i, GUIDE] == CARRIED:
                    for k in range(3):
                        bodies[i, MOTION + k], bodies[i, SPIN + k] = bodies[i, GUIDE + 1 + k], 0.0
        _follow_guides(bodies)
        tied, passed = len(links.ids), since + (part + 1) * h
        if tied > 0:
            _tie_again(bodies, links, passed)
        if ends > 0 or tied > 0:
            _prepare(bodies, index, row, ends)
            for c in range(count, ends):
                row[c, GAP], row[c, MASS], row[c, PRESSES] = 1.0, UNCHANGED, h * row[c, OFFSET]
            if was_struck:
                _soften(bodies, index, row, ends, h * weight, h, depth)
            else:
                for c in range(ends):
                    row[c, SOFTNESS] = 1.0
            _press_again(bodies, index, row, ends)
            _follow_guides(bodies)
            most, accuracy = struck if was_struck else falling
            k, change, hits, left, tying = 0, np.inf, False, SWEPT, 0.0
            while max(change, tying) > accuracy and k < most and (k < FEWEST or left > 0 or hits):
                change, solved = _sweep(bodies, index, row, ends, h, recovery, (k + part) % 2 == 1, k, accuracy, moved)
                tying = _tie(bodies, links, passed, k, accuracy, moved)
                _follow_guides(bodies)
                k, left = k + 1, left - solved
                if change > hit and not hits:
                    hits = True
                    most, accuracy = MORE * struck[0], MORE * struck[1]
                    if not was_struck:
                        was_struck = True
                        _soften(bodies, index, row, ends, h * weight, h, depth)
            _stop(index, row, ends, hit, stopped)
        for i in range(moving):
            # Bodies move by their mean velocity, which is exact in falls and slides, and after a hit by the new one.
            share = 0.0 if stopped[i] == 1 or bodies[i, GUIDE] > 0.0 else 0.5
            for k in range(6):
                before[i, k] = bodies[i, MOTION + k] + share * (before[i, k] - bodies[i, MOTION + k])
            for k in range(3):
                bodies[i, POSITION + k] += h * before[i, k]
            _turn(bodies, i, before, h)
            place_axes(bodies, i)
        if ends > 0 or tied > 0:
            _sweep(bodies, index, row, ends, h, 0.0, part % 2 == 0, 0, 0.0, moved)
            _follow_guides(bodies)
        _add_passed(links)
    return was_struck


@compiled
def _stop(index: Ints, row: Array, ends: int, hit: float, stopped: Ints) -> None:
    """Mark the bodies whose closing speed at a point a hit has changed by more than `hit` [m/s]."""
    for c in range(ends):
        if row[c, PRESSES] - row[c, EARLIER] > hit * row[c, MASS]:
            stopped[index[c, ON_BODY]] = stopped[index[c, ON_OTHER]] = 1


@compiled
def _press_again(bodies: Array, index: Ints, row: Array, ends: int) -> None:
    """Apply the impulses of the last sub-step at all points."""
    for c in range(ends):
        row[c, EARLIER] = row[c, PRESSES]
        if row[c, PRESSES] > 0.0:
            pressing, along, across = row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS]
            _push(bodies, index[c, ON_BODY], index[c, ON_OTHER], row, c, pressing, along, across)


# Links: a joint that yields holds two bodies together by a bounded force. Its points pull, as contact points push;
# along the tangents they bear the cohesion, less the friction that their pull takes away. The bounds are those of the
# mean force since a time step began, as joints yield by the means of their loads over a step. So a hit in the last
# sub-step of a step is passed on like one in the first.


@compiled
def _add_passed(links: Points) -> None:
    """Add the impulses of a sub-step to those that count towards the bounds of the rest of the time step."""
    row = links.row
    for c in range(len(links.ids)):
        row[c, PULLED] -= row[c, PRESSES]
        row[c, DRAGGED] += sqrt(row[c, RUBS] ** 2 + row[c, RUBS_ACROSS] ** 2)


@compiled
def _tie_again(bodies: Array, links: Points, passed: float) -> None:
    """Apply the impulses of the last sub-step at all links, as far as their bounds admit."""
    _prepare(bodies, links.ids, links.row, len(links.ids))
    for c in range(len(links.ids)):
        row = links.row
        pulls = max(row[c, PRESSES], _least_pull(row, c, passed))
        along, across, most = row[c, RUBS], row[c, RUBS_ACROSS], _most_drag(row, c, passed, pulls)
        size = sqrt(along * along + across * across)
        if size > most:
            along, across = most / size * along, most / size * across
        row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS] = pulls, along, across
        _push(bodies, links.ids[c, ON_BODY], links.ids[c, ON_OTHER], row, c, pulls, along, across)


@compiled
def _least_pull(row: Array, c: int, passed: float) -> float:
    """Return the bound of the impulse along the normal in this sub-step, at most 0 [N s]."""
    tension: float = row[c, TENSION]
    if row[c, FRICTION] * tension > row[c, COHESION]:
        tension = row[c, COHESION] / row[c, FRICTION]
    least: float = min(0.0, row[c, PULLED] - passed * tension)
    return least


@compiled
def _most_drag(row: Array, c: int, passed: float, pulls: float) -> float:
    """Return the bound of the impulse along the tangents in this sub-step, for an impulse along the normal [N s]."""
    sheared = passed * row[c, COHESION] + row[c, FRICTION] * (pulls - row[c, PULLED])
    most: float = max(0.0, min(sheared, passed * row[c, SHEAR]) - row[c, DRAGGED])
    return most


@compiled
def _tie(bodies: Array, links: Points, passed: float, number: int, accuracy: float, moved: Ints) -> float:
    """Solve the laws of one link after the other; return the largest change of a speed [m/s]."""
    row, change = links.row, 0.0
    for c in range(len(links.ids)):
        i, j = links.ids[c, ON_BODY], links.ids[c, ON_OTHER]
        x, y, z, a, b, d = row[c, 25], row[c, 26], row[c, 27], row[c, 22], row[c, 23], row[c, 24]
        v, w = bodies[i, MOTION:AXES], bodies[j, MOTION:AXES]
        p = (w[0] - v[0]) + ((w[4] * z - w[5] * y) - (v[4] * d - v[5] * b))
        q = (w[1] - v[1]) + ((w[5] * x - w[3] * z) - (v[5] * a - v[3] * d))
        r = (w[2] - v[2]) + ((w[3] * y - w[4] * x) - (v[3] * b - v[4] * a))
        before = row[c, PRESSES]
        opening = (p * row[c, 0] + q * row[c, 1]) + r * row[c, 2]
        pulls = min(0.0, max(before - row[c, MASS] * opening, _least_pull(row, c, passed)))
        more, rubs, rubs_across = pulls - before, row[c, RUBS], row[c, RUBS_ACROSS]
        along = rubs - row[c, MASS_ACROSS] * ((p * row[c, 3] + q * row[c, 4]) + (r * row[c, 5] + more * row[c, DRAGS]))
        across = rubs_across - row[c, MASS_ACROSS] * (
            (p * row[c, 6] + q * row[c, 7]) + (r * row[c, 8] + more * row[c, DRAGS_ACROSS])
        )
        size, most = sqrt(along * along + across * across), _most_drag(row, c, passed, pulls)
        if size > most:
            along, across = most / size * along, most / size * across
        row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS] = pulls, along, across
        _push(bodies, i, j, row, c, more, along - rubs, across - rubs_across)
        largest = max(abs(more), abs(along - rubs), abs(across - rubs_across))
        change = max(
            change, abs(more) / row[c, MASS], max(abs(along - rubs), abs(across - rubs_across)) / row[c, MASS_ACROSS]
        )
        if largest > SMALL * accuracy * row[c, MASS]:
            moved[i] = number if bodies[i, INVERSE_MASS] > 0.0 else -1
            moved[j] = number if bodies[j, INVERSE_MASS] > 0.0 else -1
    return change


@compiled
def place_axes(bodies: Array, i: int) -> None:
    """Compute the rotation matrix of a body and its response to torques from its quaternion."""
    x, y, z, w = bodies[i, TURN], bodies[i, TURN + 1], bodies[i, TURN + 2], bodies[i, TURN + 3]
    r, a = bodies[i, AXES:INVERSE_MASS], bodies[i, RESPONSE:REACH]
    r[0], r[1], r[2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r[3], r[4], r[5] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r[6], r[7], r[8] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    p, q, s = bodies[i, INVERSE_MOMENTS], bodies[i, INVERSE_MOMENTS + 1], bodies[i, INVERSE_MOMENTS + 2]
    a[0] = r[0] * r[0] * p + r[1] * r[1] * q + r[2] * r[2] * s
    a[1] = r[0] * r[3] * p + r[1] * r[4] * q + r[2] * r[5] * s
    a[2] = r[0] * r[6] * p + r[1] * r[7] * q + r[2] * r[8] * s
    a[3] = r[3] * r[3] * p + r[4] * r[4] * q + r[5] * r[5] * s
    a[4] = r[3] * r[6] * p + r[4] * r[7] * q + r[5] * r[8] * s
    a[5] = r[6] * r[6] * p + r[7] * r[7] * q + r[8] * r[8] * s


@compiled
def _follow_guides(bodies: Array) -> None:
    """Give slid bodies their prescribed velocities, except along their free axes, and no spin about these axes."""
    for i in range(len(bodies) - 1):
        if bodies[i, GUIDE] == SLID:
            m, g = bodies[i, MOTION:AXES], bodies[i, GUIDE:]
            x, y, z = g[4], g[5], g[6]
            along = (m[0] - g[1]) * x + (m[1] - g[2]) * y + (m[2] - g[3]) * z
            about = m[3] * x + m[4] * y + m[5] * z
            for k in range(3):
                m[k] = g[1 + k] + along * g[4 + k]
                m[3 + k] -= about * g[4 + k]


@compiled
def _spin_on(bodies: Array, i: int, h: float) -> None:
    """Change a spin by Euler's equations, with the implicit midpoint rule."""
    r, w = bodies[i, AXES:INVERSE_MASS], bodies[i, SPIN:AXES]
    x, y, z = w[0], w[1], w[2]
    m, n = 1.0 / bodies[i, INVERSE_MOMENTS], 1.0 / bodies[i, INVERSE_MOMENTS + 1]
    o = 1.0 / bodies[i, INVERSE_MOMENTS + 2]
    u0, v0, w0 = r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z
    u, v, s = u0, v0, w0
    for _ in range(3):
        um, vm, sm = 0.5 * (u + u0), 0.5 * (v + v0), 0.5 * (s + w0)
        u = u0 + h * (n - o) / m * vm * sm
        v = v0 + h * (o - m) / n * sm * um
        s = w0 + h * (m - n) / o * um * vm
    w[0], w[1], w[2] = r[0] * u + r[1] * v + r[2] * s, r[3] * u + r[4] * v + r[5] * s, r[6] * u + r[7] * v + r[8] * s


@compiled
def _turn(bodies: Array, i: int, motion: Array, h: float) -> None:
    """Rotate a body by its mean spin for a time [s]."""
    q = bodies[i, TURN:MOTION]
    a, b, c = 0.5 * h * motion[i, 3], 0.5 * h * motion[i, 4], 0.5 * h * motion[i, 5]
    angle = sqrt(a * a + b * b + c * c)
    if angle < STRAIGHT:
        sine, cosine = 1.0 - angle * angle / 6.0, 1.0 - angle * angle / 2.0
    else:
        sine, cosine = sin(angle) / angle, cos(angle)
    a, b, c = sine * a, sine * b, sine * c
    x, y, z, w = q[0], q[1], q[2], q[3]
    q[0] = cosine * x + a * w + b * z - c * y
    q[1] = cosine * y + b * w + c * x - a * z
    q[2] = cosine * z + c * w + a * y - b * x
    q[3] = cosine * w - a * x - b * y - c * z
    length = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for k in range(4):
        q[k] *= length


@compiled
def _prepare(bodies: Array, index: Ints, row: Array, count: int) -> None:
    """Compute arms, gaps, effective masses and responses of all points at the current poses."""
    for c in range(count):
        gap = row[c, OFFSET]
        normal = along = across = both = drags = drags_across = 0.0
        for side in range(2):
            i, on, arm, turns = index[c, ON_BODY + side], 9 + 3 * side, 22 + 3 * side, 32 + 9 * side
            sign = 2.0 * side - 1.0
            u, v, w = row[c, on], row[c, on + 1], row[c, on + 2]
            x = bodies[i, AXES] * u + bodies[i, AXES + 1] * v + bodies[i, AXES + 2] * w
            y = bodies[i, AXES + 3] * u + bodies[i, AXES + 4] * v + bodies[i, AXES + 5] * w
            z = bodies[i, AXES + 6] * u + bodies[i, AXES + 7] * v + bodies[i, AXES + 8] * w
            row[c, arm], row[c, arm + 1], row[c, arm + 2] = x, y, z
            p, q, r = x + bodies[i, POSITION], y + bodies[i, POSITION + 1], z + bodies[i, POSITION + 2]
            row[c, AT], row[c, AT + 1], row[c, AT + 2] = p, q, r  # of the second body in the end
            gap += sign * (row[c, 0] * p + row[c, 1] * q + row[c, 2] * r)
            m = bodies[i, INVERSE_MASS]
            if m == 0.0:
                for column in range(turns, turns + 9):
                    row[c, column] = 0.0
                continue
            for axis in range(0, 9, 3):
                a, b, d, to = row[c, axis], row[c, axis + 1], row[c, axis + 2], turns + axis
                t, u, v = y * d - z * b, z * a - x * d, x * b - y * a
                p = bodies[i, RESPONSE] * t + bodies[i, RESPONSE + 1] * u + bodies[i, RESPONSE + 2] * v
                q = bodies[i, RESPONSE + 1] * t + bodies[i, RESPONSE + 3] * u + bodies[i, RESPONSE + 4] * v
                r = bodies[i, RESPONSE + 2] * t + bodies[i, RESPONSE + 4] * u + bodies[i, RESPONSE + 5] * v
                row[c, to], row[c, to + 1], row[c, to + 2] = p, q, r
                along_axis = m + t * p + u * q + v * r
                coupled = t * row[c, turns] + u * row[c, turns + 1] + v * row[c, turns + 2]
                if axis == NORMAL:
                    normal += along_axis
                elif axis == ALONG:
                    along, drags = along + along_axis, drags + coupled
                else:
                    across, drags_across = across + along_axis, drags_across + coupled
                    both += t * row[c, turns + 3] + u * row[c, turns + 4] + v * row[c, turns + 5]
        # The least mass of all tangents, so that their choice does not matter.
        slackest = 0.5 * (along + across) + sqrt(0.25 * (along - across) ** 2 + both * both)
        row[c, GAP], row[c, MASS], row[c, MASS_ACROSS] = gap, 1.0 / normal, 1.0 / slackest
        row[c, DRAGS], row[c, DRAGS_ACROSS] = drags, drags_across


@compiled
def _weight(bodies: Array, gravity_W: Array) -> float:
    """Return the weight of all bodies that move freely [N]."""
    mass = 0.0
    for i in range(len(bodies) - 1):
        if bodies[i, INVERSE_MASS] > 0.0:
            mass += 1.0 / bodies[i, INVERSE_MASS]
    return mass * sqrt(gravity_W[0] ** 2 + gravity_W[1] ** 2 + gravity_W[2] ** 2)


@compiled
def _soften(bodies: Array, index: Ints, row: Array, count: int, most: float, h: float, depth: float) -> None:
    """Let the overlaps of all points take up a share of the impulses.

    A point stiffens if a body much heavier than its own presses on it, which would sink deeper than `depth` [m]. No
    point at rest bears more than the impulse of all loads, `most` [N s]: the impulse at an overlap that cannot be
    removed, of a body between two that do not move, would grow without bound.
    """
    for c in range(count):
        # A hand may press with any force, which must not push a body into the ground.
        carried = bodies[index[c, ON_BODY], GUIDE] == CARRIED or bodies[index[c, ON_OTHER], GUIDE] == CARRIED
        soft = SOFT
        if row[c, PRESSES] > 0.0:
            borne = min(row[c, PRESSES], most)
            soft = max(soft, borne / (borne + row[c, MASS] * RATE * depth / h))
        row[c, SOFTNESS] = 1.0 if carried else soft


@compiled
def _push(
    bodies: Array, first: int, second: int, row: Array, c: int, pressing: float, along: float, across: float
) -> None:
    """Apply an impulse at a point to the second body, and its opposite to the first."""
    for k in range(3):
        push = (pressing * row[c, k] + along * row[c, 3 + k]) + across * row[c, 6 + k]
        bodies[first, MOTION + k] -= bodies[first, INVERSE_MASS] * push
        bodies[second, MOTION + k] += bodies[second, INVERSE_MASS] * push
        bodies[first, SPIN + k] -= (pressing * row[c, 32 + k] + along * row[c, 35 + k]) + across * row[c, 38 + k]
        bodies[second, SPIN + k] += (pressing * row[c, 41 + k] + along * row[c, 44 + k]) + across * row[c, 47 + k]


@compiled
def _sweep(
    bodies: Array,
    index: Ints,
    row: Array,
    count: int,
    h: float,
    recovery: float,
    backwards: bool,
    number: int,
    accuracy: float,
    moved: Ints,
) -> tuple[float, int]:
    """Solve Signorini's and Coulomb's laws at one point after the other.

    Return the largest change of a closing speed [m/s], and the number of points. From the second sweep on they are
    those of the bodies that have moved since the sweep before, by a tenth of the accuracy [m/s].
    """
    rate, change, solved = 1.0 / h, 0.0, 0
    for k in range(count):
        c = count - 1 - k if backwards else k
        i, j = index[c, ON_BODY], index[c, ON_OTHER]
        if number > 0 and moved[i] < number - 1 and moved[j] < number - 1:
            continue
        solved += 1
        x, y, z, a, b, d = row[c, 25], row[c, 26], row[c, 27], row[c, 22], row[c, 23], row[c, 24]
        v, w = bodies[i, MOTION:AXES], bodies[j, MOTION:AXES]
        p = (w[0] - v[0]) + ((w[4] * z - w[5] * y) - (v[4] * d - v[5] * b))
        q = (w[1] - v[1]) + ((w[5] * x - w[3] * z) - (v[5] * a - v[3] * d))
        r = (w[2] - v[2]) + ((w[3] * y - w[4] * x) - (v[3] * b - v[4] * a))
        before, gap = row[c, PRESSES], row[c, GAP]
        opening = (p * row[c, 0] + q * row[c, 1]) + r * row[c, 2]
        if gap > 0.0:
            pressing = before - row[c, MASS] * (opening + gap * rate)
        elif recovery > 0.0:
            soft = row[c, SOFTNESS]
            pressing = soft * before - soft * row[c, MASS] * (opening + max(RATE * gap * rate, -recovery))
        else:
            pressing = before - row[c, MASS] * opening
        if pressing <= 0.0:
            if before == 0.0:
                continue
            pressing = 0.0
        more, rubs, rubs_across = pressing - before, row[c, RUBS], row[c, RUBS_ACROSS]
        along = rubs - row[c, MASS_ACROSS] * ((p * row[c, 3] + q * row[c, 4]) + (r * row[c, 5] + more * row[c, DRAGS]))
        across = rubs_across - row[c, MASS_ACROSS] * (
            (p * row[c, 6] + q * row[c, 7]) + (r * row[c, 8] + more * row[c, DRAGS_ACROSS])
        )
        size, most = along * along + across * across, row[c, FRICTION] * pressing
        if size > most * most:
            share = most / sqrt(size)
            along, across = share * along, share * across
        row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS] = pressing, along, across
        _push(bodies, i, j, row, c, more, along - rubs, across - rubs_across)
        change = max(change, abs(more) / row[c, MASS])
        if max(abs(more), abs(along - rubs), abs(across - rubs_across)) > SMALL * accuracy * row[c, MASS]:
            moved[i] = number if bodies[i, INVERSE_MASS] > 0.0 else -1
            moved[j] = number if bodies[j, INVERSE_MASS] > 0.0 else -1
    return change, solved
