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
    """Convex solids of the bodies, in body axes, and half-spaces. Corners are counted from the first of their solid.

    A round solid has no faces and edges, and the corners of the box around it.
    """

    table: Ints  # (s + 1, 5) columns below; each range ends where that of the next row starts
    radius: Array  # (s,) of the edges [m]
    corners: Array  # (c, 6) corners, and those of the solid without its rounded edges [m]
    faces: Array  # (f, 4) outward normals, and heights over the centre of mass of the body [m]
    loops: Ints  # (f, ...) number of corners of a face, and these, counter-clockwise seen from outside
    edges: Ints  # (e, 2) corners at both ends
    rounds: Array  # (s, ROUND_WIDTH) discs of round solids, in the columns below; 0 for solids with flat faces
    friction: Array  # (k, k) of surfaces on each other
    planes: Array  # (p, 4) outward normals and heights of half-spaces
    on_planes: Array  # (k, p) friction of surfaces on half-spaces
    origin: Array  # (9,) a point [m], a direction and another point, by which the points of a pair are sorted, W


# Columns of `Solids.table`.
BODY, SURFACE = 0, 1  # row of the body, and of `friction`
CORNER, FACE, EDGE = 2, 3, 4  # first one

# Columns of `Solids.rounds`. A round solid is the convex hull of two discs across its axis, rounded by a ball.
DISC = 0  # 3 each: the centres of the lower and of the upper disc [m]
RADIUS = 6  # 1 each: their radii [m]
BALL = 8  # radius [m]
AXIS, ASIDE = 9, 12  # 3 each: unit vectors along the axis from the lower disc to the upper one, and across it
ROUND_WIDTH = 15


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
BENT = 54  # 0: both surfaces are flat, or turn little in a step; ROUND; BALLS: two balls, whose normal turns
BEND = (
    55  # 5 for either body, whose point is then a centre: radii of a ring and of a ball around it [m], axis of the ring
)
WIDTH = 65
ROUND, BALLS = 1.0, 2.0

# Columns of links, after those of points: two bodies hold together at a point by a bounded force. The impulse along the
# normal is negative where it pulls.
TENSION, COHESION, SHEAR = 65, 66, 67  # [N]
PULLED, DRAGGED = 68, 69  # impulses along the normal and the tangents in earlier sub-steps of this time step [N s]
LINK_WIDTH = 70


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
    boxes, rounds = bounding_boxes(table, placed), _placed_rounds(bodies, table, solids.rounds)
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
                if _is_round(rounds, i):
                    count = _round_on_plane(
                        bodies, table, i, rounds, solids.planes, p, rubbing, reach[i], points, count
                    )
                else:
                    count = _on_plane(bodies, table, i, placed, solids.planes, p, rubbing, reach[i], points, count)
                _sort_points(bodies, points, known, count, solids.origin)
    polygons, simplex = np.empty((2, MOST_CORNERS, 3)), np.empty((6, 10))
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
        if _is_round(rounds, i) or _is_round(rounds, j):
            count = _with_round(
                bodies, solids, rounds, i, j, placed, within, radius, rubbing, axes, k, points, known, simplex
            )
            _sort_points(bodies, points, known, count, solids.origin)
            continue
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
            if row[k - 1, BENT] + row[k, BENT] > 0.0:
                for column in range(BENT, WIDTH):
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
    _put_frame(r, count, normal[0], normal[1], normal[2])
    for side in range(2):
        i = on[side]  # the axes of the world are 0, so that the offset holds its part of the gap
        u, v, w = at[0] - bodies[i, POSITION], at[1] - bodies[i, POSITION + 1], at[2] - bodies[i, POSITION + 2]
        for k in range(3):
            column = AXES + k
            r[count, 9 + 3 * side + k] = bodies[i, column] * u + bodies[i, column + 3] * v + bodies[i, column + 6] * w
    r[count, OFFSET], r[count, FRICTION], r[count, BENT] = gap, friction, 0.0
    return count + 1


@compiled
def _put_frame(r: Array, count: int, x: float, y: float, z: float) -> None:
    """Store the normal of a point and two tangents."""
    r[count, 0], r[count, 1], r[count, 2] = x, y, z
    if abs(y) < SIDEWAYS:
        a, b, c = z, 0.0, -x
    else:
        a, b, c = 0.0, -z, y
    long = 1.0 / sqrt(a * a + b * b + c * c)
    a, b, c = long * a, long * b, long * c
    r[count, 3], r[count, 4], r[count, 5] = a, b, c
    r[count, 6], r[count, 7], r[count, 8] = y * c - z * b, z * a - x * c, x * b - y * a


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


# Contact points of round solids: of the true surface, without an inscribed polygon.
#
# A normal of a face or of a disc is taken if the two solids overlap along it. Otherwise the normal joins the nearest
# points of two cores (Gilbert, Johnson and Keerthi, 1988). The core of a ball or a capsule is its axis, and so is that
# of the side of a cylinder. Where a rim meets an edge or another rim, both cores are the solids without their rounded
# edges. Points of a side, a rim and a ball follow the surface within a step: they are held by a centre that is fixed in
# the body. A disc that lies flat touches at points of its rim, and where it crosses edges and rims. If it leans, its
# lowest point is one of them, so it rocks about its true rim.


RIM_POINTS = 16  # of a flat disc: until it leans, it tips by up to 1 - cos(pi / 16) = 2 % of its radius too early
FACING = 0.98  # cosine of the angle between a normal and the axis of a disc that may lie flat
LEANS = 1e-9  # sine of the angle between a disc and a face from which its lowest point is known
ROLLS = 1e-6  # the same, from which the lowest point turns with the body within a step
SIDE = 1e-6  # largest cosine of the angle between an axis and a normal of the side of a cylinder
STEEP = 0.1  # least cosine of the angle between a normal and a face
SHORT = 1e-6  # share of the length of a line: two points that are closer are one
SHARPER = 1e-13  # relative accuracy of the squared distance of two cores
MOST_ROUNDS = 64  # of the search for it
THIN = 1e-12  # squared sine of the angle of a triangle without an area
CORNERS = 4  # of a simplex
LAST_CORES = 3  # attempt with the last kind of cores
SHARP_CORE, INSET_CORE, AXIS_CORE = 0, 1, 2  # the solid; that without rounded edges; the line between its discs

FIRST_TURN, LAST_TURN = 0.3, 1e-4  # [rad] steps of the search for the normal of a deep overlap
WAYS = 8  # directions of a step

# Rows of the simplex of `_core_distance` after its corners, and columns of these rows.
RESULT = 4  # the vector from the first to the second core (3), and their nearest points (3 each) [m]
SPARE = 5

Vector = tuple[float, float, float]


@compiled
def _placed_rounds(bodies: Array, table: Ints, rounds: Array) -> Array:
    """Return the round solids in W, in the columns of `Solids.rounds`."""
    placed = np.zeros((len(rounds), ROUND_WIDTH))
    for i in range(len(rounds)):
        if not _is_round(rounds, i):
            continue
        b = table[i, BODY]
        for first in (DISC, DISC + 3, AXIS, ASIDE):
            for k in range(3):
                x, y, z = bodies[b, AXES + 3 * k], bodies[b, AXES + 3 * k + 1], bodies[b, AXES + 3 * k + 2]
                turned = x * rounds[i, first] + y * rounds[i, first + 1] + z * rounds[i, first + 2]
                placed[i, first + k] = turned + (bodies[b, POSITION + k] if first < RADIUS else 0.0)
        for k in range(RADIUS, AXIS):
            placed[i, k] = rounds[i, k]
    return placed


@compiled
def _is_round(rounds: Array, i: int) -> bool:
    found: bool = rounds[i, RADIUS] + rounds[i, RADIUS + 1] + rounds[i, BALL] > 0.0
    return found


@compiled
def _vector(row: Array, first: int) -> Vector:
    return row[first], row[first + 1], row[first + 2]


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def _plus(a: Vector, share: float, b: Vector) -> Vector:
    """Return a vector plus a multiple of another."""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]


@compiled
def _crossed(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def _outwards(row: Array, towards: Vector) -> tuple[Vector, float]:
    """Return the unit direction across the axis that reaches farthest towards a unit direction.

    The second number is the sine of the angle between axis and direction; the first is zero if both are parallel.
    """
    axis = _vector(row, AXIS)
    across = _plus(towards, -_dot(towards, axis), axis)
    sine = sqrt(_dot(across, across))
    if sine < LEANS:
        return (0.0, 0.0, 0.0), sine
    return (across[0] / sine, across[1] / sine, across[2] / sine), sine


@compiled
def _on_line(row: Array, share: float, towards: Vector, outwards: Vector) -> Vector:
    """Return the farthest point in a direction at a share of the line from the lower to the upper disc [m]."""
    low, high = _vector(row, DISC), _vector(row, DISC + 3)
    radius = row[RADIUS] + share * (row[RADIUS + 1] - row[RADIUS])
    return _plus(_plus(_plus(low, share, _less(high, low)), radius, outwards), row[BALL], towards)


@compiled
def _held(row: Array, share: float, towards: Vector, outwards: Vector, sine: float) -> tuple[Vector, Array]:
    """Return where a body holds the point of `_on_line`, and its bend: a centre, or the point itself without a bend."""
    bend = np.zeros(5)
    if row[BALL] == 0.0 and sine < ROLLS:
        return _on_line(row, share, towards, outwards), bend
    low = _vector(row, DISC)
    bend[0], bend[1] = row[RADIUS] + share * (row[RADIUS + 1] - row[RADIUS]), row[BALL]
    for k in range(3):
        bend[2 + k] = row[AXIS + k]
    return _plus(low, share, _less(_vector(row, DISC + 3), low)), bend


@compiled
def _facing_disc(row: Array, towards: Vector) -> int:
    """Return the disc, 0 or 1, that may lie flat on what is in a direction, or -1."""
    cosine = _dot(_vector(row, AXIS), towards)
    disc = 1 if cosine > 0.0 else 0
    return disc if row[BALL] == 0.0 and abs(cosine) > FACING and row[RADIUS + disc] > 0.0 else -1


@compiled
def _rim_point(row: Array, disc: int, number: int) -> Vector:
    """Return one of the rim points of a disc, which are fixed in the body."""
    angle = 2.0 * pi * number / RIM_POINTS
    aside, axis = _vector(row, ASIDE), _vector(row, AXIS)
    across = _crossed(axis, aside)
    radius = row[RADIUS + disc]
    return _plus(_plus(_vector(row, DISC + 3 * disc), radius * cos(angle), aside), radius * sin(angle), across)


@compiled
def _farthest(table: Ints, placed: Array, rounds: Array, i: int, core: int, radius: float, towards: Vector) -> Vector:
    """Return the farthest point of a core in a direction [m]; `radius` is that of the edges."""
    if not _is_round(rounds, i):
        first = CORE if core == INSET_CORE else 0
        most, best = -np.inf, table[i, CORNER]
        for c in range(table[i, CORNER], table[i + 1, CORNER]):
            along = (
                towards[0] * placed[c, first] + towards[1] * placed[c, first + 1] + towards[2] * placed[c, first + 2]
            )
            if along > most:
                most, best = along, c
        return _vector(placed[best], first)
    row = rounds[i]
    axis, low, high = _vector(row, AXIS), _vector(row, DISC), _vector(row, DISC + 3)
    bottom, top = (0.0, 0.0) if core == AXIS_CORE else (row[RADIUS], row[RADIUS + 1])
    if core == INSET_CORE and row[BALL] == 0.0:
        height = _dot(_less(high, low), axis)
        slope = (top - bottom) / height
        inwards = radius * sqrt(1.0 + slope * slope)
        bottom, top = max(0.0, bottom + slope * radius - inwards), max(0.0, top - slope * radius - inwards)
        low, high = _plus(low, radius, axis), _plus(high, -radius, axis)
    along = _dot(axis, towards)
    across = _plus(towards, -along, axis)
    sine = sqrt(_dot(across, across))
    if _dot(high, towards) + top * sine >= _dot(low, towards) + bottom * sine:
        low, bottom = high, top
    return _plus(low, bottom / sine, across) if sine > 0.0 else low


@compiled
def _extent(table: Ints, placed: Array, rounds: Array, i: int, towards: Vector) -> float:
    """Return how far a solid reaches in a unit direction, from the origin of W [m]."""
    far, ball = _dot(_farthest(table, placed, rounds, i, SHARP_CORE, 0.0, towards), towards), float(rounds[i, BALL])
    return far + ball


@compiled
def _core_distance(
    table: Ints,
    placed: Array,
    rounds: Array,
    solids: tuple[int, int],
    cores: tuple[int, int],
    radius: float,
    start: Vector,
    simplex: Array,
) -> float:
    """Return the distance of two cores [m], 0 if they overlap; the rest is in row RESULT of the simplex.

    The search starts in a direction from the first to the second.
    """
    i, j = solids
    way, square, count = start, np.inf, 0
    for _ in range(MOST_ROUNDS):
        a = _farthest(table, placed, rounds, i, cores[0], radius, way)
        b = _farthest(table, placed, rounds, j, cores[1], radius, (-way[0], -way[1], -way[2]))
        w = _less(b, a)
        if count > 0 and square - _dot(way, w) <= SHARPER * square:
            break
        for k in range(3):
            simplex[count, k], simplex[count, 3 + k], simplex[count, 6 + k] = w[k], a[k], b[k]
        kept = _nearest_in_simplex(simplex, count + 1)
        way = _vector(simplex[SPARE], 0)
        shorter = _dot(way, way)
        if kept == CORNERS or shorter == 0.0:
            return 0.0
        if shorter >= square:
            break
        square, count = shorter, kept
        for k in range(9):
            simplex[RESULT, k] = simplex[SPARE, k]
    return sqrt(square)


@compiled
def _nearest_in_simplex(simplex: Array, count: int) -> int:  # noqa: PLR0915 -- a case for each number of corners
    """Reduce a simplex to the corners around its point that is nearest to the origin; return their number.

    The point, which is a mean of the corners, is stored in row SPARE. All parts that have the last corner are tried.
    """
    last, least, best = count - 1, np.inf, 1
    shares, found = np.zeros(CORNERS), np.zeros(CORNERS)
    newest = _vector(simplex[last], 0)
    for part in range(1 << last):
        members = 0
        for k in range(last):
            members += (part >> k) & 1
        p = q = -1
        for k in range(last):
            if (part >> k) & 1:
                if p < 0:
                    p = k
                elif q < 0:
                    q = k
        for k in range(CORNERS):
            shares[k] = 0.0
        if members == 0:
            shares[last] = 1.0
        elif members == 1:
            e = _less(_vector(simplex[p], 0), newest)
            square = _dot(e, e)
            if square == 0.0:
                continue
            shares[p] = -_dot(newest, e) / square
        elif members == LINE:
            e, f = _less(_vector(simplex[p], 0), newest), _less(_vector(simplex[q], 0), newest)
            ee, ff, ef = _dot(e, e), _dot(f, f), _dot(e, f)
            flat = ee * ff - ef * ef
            if flat <= THIN * ee * ff:
                continue
            ne, nf = -_dot(newest, e), -_dot(newest, f)
            shares[p], shares[q] = (ne * ff - nf * ef) / flat, (nf * ee - ne * ef) / flat
        else:
            e, f = _less(_vector(simplex[0], 0), newest), _less(_vector(simplex[1], 0), newest)
            g = _less(_vector(simplex[2], 0), newest)
            volume = _dot(e, _crossed(f, g))
            if volume * volume <= THIN * _dot(e, e) * _dot(f, f) * _dot(g, g):
                continue
            shares[0] = -_dot(newest, _crossed(f, g)) / volume
            shares[1] = -_dot(newest, _crossed(g, e)) / volume
            shares[2] = -_dot(newest, _crossed(e, f)) / volume
        rest, inside = 1.0, True
        for k in range(last):
            rest -= shares[k]
            inside = inside and (((part >> k) & 1) == 0 or shares[k] > 0.0)
        shares[last] = rest
        if not inside or rest <= 0.0:
            continue
        x = y = z = 0.0
        if members < CORNERS - 1:
            for k in range(count):
                x, y, z = x + shares[k] * simplex[k, 0], y + shares[k] * simplex[k, 1], z + shares[k] * simplex[k, 2]
        square = x * x + y * y + z * z
        if square < least:
            least, best = square, members + 1
            for k in range(CORNERS):
                found[k] = shares[k]
            simplex[SPARE, 0], simplex[SPARE, 1], simplex[SPARE, 2] = x, y, z
    for column in range(3, 9):
        mean = 0.0
        for k in range(count):
            mean += found[k] * simplex[k, column]
        simplex[SPARE, column] = mean
    kept = 0
    for k in range(count):
        if found[k] > 0.0:
            for column in range(9):
                simplex[kept, column] = simplex[k, column]
            kept += 1
    return best


@compiled
def _put(
    bodies: Array,
    points: Points,
    count: int,
    pair: tuple[int, int],
    on: tuple[int, int],
    swapped: bool,
    normal: Vector,
    low: Vector,
    low_bend: Array,
    high: Vector,
    high_bend: Array,
    offset: float,
    friction: float,
) -> int:
    """Add a point between a lower and a higher surface along a normal; return the number of points.

    The places are points of W or, with a bend, centres. The pair is that of the first and the second solid, of which
    the higher one is the first if they are `swapped`.
    """
    if swapped:
        normal, low, high = (-normal[0], -normal[1], -normal[2]), high, low
        low_bend, high_bend = high_bend, low_bend
    count = _add(bodies, points, count, pair, on, normal, low, offset, friction)
    if count > len(points.ids):
        return count
    r, b = points.row[count - 1], on[1]
    x, y, z = high[0] - bodies[b, POSITION], high[1] - bodies[b, POSITION + 1], high[2] - bodies[b, POSITION + 2]
    for k in range(3):
        r[ON_SECOND + k] = bodies[b, AXES + k] * x + bodies[b, AXES + 3 + k] * y + bodies[b, AXES + 6 + k] * z
    r[BENT] = ROUND
    for side in range(2):
        bend, to, b = (low_bend, BEND, on[0]) if side == 0 else (high_bend, BEND + 5, on[1])
        r[to], r[to + 1] = bend[0], bend[1]
        for k in range(3):
            turned = (
                bodies[b, AXES + k] * bend[2] + bodies[b, AXES + 3 + k] * bend[3] + bodies[b, AXES + 6 + k] * bend[4]
            )
            r[to + 2 + k] = turned
    return count


@compiled
def _surface(bodies: Array, i: int, row: Array, c: int, side: int, x: float, y: float, z: float) -> Vector:
    """Return the arm of the point of a surface along a normal, from the arm of its centre [m]."""
    first = BEND + 5 * side
    ring, ball = row[c, first], row[c, first + 1]
    sign = 1.0 - 2.0 * side
    normal = _vector(row[c], NORMAL)
    x, y, z = x + sign * ball * normal[0], y + sign * ball * normal[1], z + sign * ball * normal[2]
    if ring > 0.0:
        u, v, w = row[c, first + 2], row[c, first + 3], row[c, first + 4]
        axis = (
            bodies[i, AXES] * u + bodies[i, AXES + 1] * v + bodies[i, AXES + 2] * w,
            bodies[i, AXES + 3] * u + bodies[i, AXES + 4] * v + bodies[i, AXES + 5] * w,
            bodies[i, AXES + 6] * u + bodies[i, AXES + 7] * v + bodies[i, AXES + 8] * w,
        )
        across = _plus(normal, -_dot(normal, axis), axis)
        sine = sqrt(_dot(across, across))
        if sine > LEANS:
            share = sign * ring / sine
            x, y, z = x + share * across[0], y + share * across[1], z + share * across[2]
    return x, y, z


@compiled
def _turn_normal(bodies: Array, index: Ints, row: Array, c: int) -> None:
    """Turn the normal of two balls into the line between their centres."""
    centre = np.zeros(3)
    for side in range(2):
        i, on, sign = index[c, ON_BODY + side], ON_FIRST + 3 * side, 2.0 * side - 1.0
        u, v, w = row[c, on], row[c, on + 1], row[c, on + 2]
        for k in range(3):
            x, y, z = bodies[i, AXES + 3 * k], bodies[i, AXES + 3 * k + 1], bodies[i, AXES + 3 * k + 2]
            centre[k] += sign * (bodies[i, POSITION + k] + x * u + y * v + z * w)
    far = _length(centre)
    if far > 0.0:
        _put_frame(row, c, centre[0] / far, centre[1] / far, centre[2] / far)


@compiled
def _round_on_plane(
    bodies: Array,
    table: Ints,
    i: int,
    rounds: Array,
    planes: Array,
    p: int,
    rubbing: float,
    reach: float,
    points: Points,
    count: int,
) -> int:
    """Add the lowest points of a round solid that are within reach of a half-space [m]."""
    row, normal, height, none = rounds[i], _vector(planes[p], 0), planes[p, 3], np.zeros(5)
    down = (-normal[0], -normal[1], -normal[2])
    pair, on, origin = (-1 - p, i), (len(bodies) - 1, table[i, BODY]), (0.0, 0.0, 0.0)
    outwards, sine = _outwards(row, down)
    disc = _facing_disc(row, down)
    ends = 1 if row[AXIS] == row[AXIS + 1] == row[AXIS + 2] == 0.0 else 2
    for end in range(ends):
        if disc >= 0 and sine < LEANS:
            break
        if _dot(_on_line(row, float(end), down, outwards), normal) - height < reach:
            at, bend = _held(row, float(end), down, outwards, sine)
            count = _put(bodies, points, count, pair, on, False, normal, origin, none, at, bend, -height, rubbing)
    if disc >= 0:
        for number in range(RIM_POINTS):
            at = _rim_point(row, disc, number)
            if _dot(at, normal) - height < reach:
                count = _put(bodies, points, count, pair, on, False, normal, origin, none, at, none, -height, rubbing)
    return count


@compiled
def _with_round(
    bodies: Array,
    solids: Solids,
    rounds: Array,
    i: int,
    j: int,
    placed: Array,
    reach: float,
    radius: float,
    rubbing: float,
    axes: Array,
    k: int,
    points: Points,
    known: int,
    simplex: Array,
) -> int:
    """Add the points of two solids, of which one is round, within reach [m]; their normal is stored as axis k.

    Return the number of points.
    """
    table, count, nearest = solids.table, known, np.inf
    apart, face, is_flat = _best_face(bodies, solids, rounds, i, j, placed)
    if apart > reach:
        _store(axes, k, face)
        return known
    # A deep overlap along a face tells little: two cylinders side by side overlap in all of their height.
    if apart > -radius:
        count, nearest = _along_normal(bodies, solids, rounds, i, j, placed, face, reach, rubbing, points, known)
        if nearest <= apart + (radius if is_flat else WARPED * radius):
            _store(axes, k, face)
            return count
    normal, core, outer = _normal_of_cores(table, placed, rounds, i, j, radius, _vector(axes[k], 0), simplex)
    gap = -_extent(table, placed, rounds, i, normal)
    gap -= _extent(table, placed, rounds, j, (-normal[0], -normal[1], -normal[2]))
    if core[0] < 0:
        normal, gap = (face, apart) if apart > gap else (normal, gap)
        normal, gap = _least_overlap(table, placed, rounds, i, j, normal, gap)
    _store(axes, k, normal)
    if gap > reach:
        return known
    count, nearest = _along_normal(bodies, solids, rounds, i, j, placed, normal, reach, rubbing, points, known)
    if nearest <= gap + SLIGHT * radius:
        return count
    if core[0] < 0:
        count = _in_overlap(bodies, table, placed, rounds, i, j, normal, gap, rubbing, points, count)
    else:
        count = _at_cores(
            bodies, table, rounds, i, j, core, outer, normal, gap, radius, rubbing, points, count, simplex
        )
    return count


@compiled
def _store(axes: Array, k: int, normal: Vector) -> None:
    axes[k, 0], axes[k, 1], axes[k, 2] = normal


@compiled
def _best_face(
    bodies: Array, solids: Solids, rounds: Array, i: int, j: int, placed: Array
) -> tuple[float, Vector, bool]:
    """Return the largest gap of two solids along the normal of a face or a disc [m], and this normal, from i to j.

    The third value tells that a disc lies flat on a face or another disc. Without faces and discs the gap is -inf.
    """
    table, faces = solids.table, solids.faces
    most, best = -np.inf, (0.0, 0.0, 0.0)
    for side in range(2):
        one, other, sign = (i, j, 1.0) if side == 0 else (j, i, -1.0)
        b = table[one, BODY]
        for f in range(table[one, FACE], table[one + 1, FACE]):
            u, v, w = faces[f, 0], faces[f, 1], faces[f, 2]
            x = bodies[b, AXES] * u + bodies[b, AXES + 1] * v + bodies[b, AXES + 2] * w
            y = bodies[b, AXES + 3] * u + bodies[b, AXES + 4] * v + bodies[b, AXES + 5] * w
            z = bodies[b, AXES + 6] * u + bodies[b, AXES + 7] * v + bodies[b, AXES + 8] * w
            height = faces[f, 3] + x * bodies[b, POSITION] + y * bodies[b, POSITION + 1] + z * bodies[b, POSITION + 2]
            gap = -_extent(table, placed, rounds, other, (-x, -y, -z)) - height
            if gap > most + EITHER:
                most, best = gap, (sign * x, sign * y, sign * z)
        if rounds[one, BALL] == 0.0:
            for disc in range(2):
                if rounds[one, RADIUS + disc] > 0.0:
                    out = 2.0 * disc - 1.0
                    x, y, z = out * rounds[one, AXIS], out * rounds[one, AXIS + 1], out * rounds[one, AXIS + 2]
                    height = _dot(_vector(rounds[one], DISC + 3 * disc), (x, y, z))
                    gap = -_extent(table, placed, rounds, other, (-x, -y, -z)) - height
                    if gap > most + EITHER:
                        most, best = gap, (sign * x, sign * y, sign * z)
    flat = True
    for side in range(2):
        one, sign = (i, 1.0) if side == 0 else (j, -1.0)
        if _is_round(rounds, one):
            cosine = abs(_dot(_vector(rounds[one], AXIS), best))
            flat = flat and rounds[one, BALL] == 0.0 and cosine > FLAT
    return most, best, flat


@compiled
def _normal_of_cores(
    table: Ints,
    placed: Array,
    rounds: Array,
    i: int,
    j: int,
    radius: float,
    known: Vector,
    simplex: Array,
) -> tuple[Vector, tuple[int, int], tuple[float, float]]:
    """Return the unit normal of two solids whose edges, rims or sides meet, from the first to the second.

    With it come their cores, and the distances of these from the surfaces [m]. If all cores overlap, the normal is the
    known one, or that between the middles of the solids, and the cores are -1.
    """
    start = known if _dot(known, known) > 0.0 else _less(_middle(table, placed, j), _middle(table, placed, i))
    if _dot(start, start) == 0.0:
        start = (0.0, 0.0, 1.0)
    for attempt in range(LAST_CORES + 1):
        cores, outer = np.zeros(2, np.int64), np.zeros(2)
        for side in range(2):
            one = i if side == 0 else j
            ball, low, high = rounds[one, BALL], rounds[one, RADIUS], rounds[one, RADIUS + 1]
            is_ball, is_cylinder = ball > 0.0, low > 0.0 and low == high
            if is_ball or (is_cylinder and (attempt == 0 or attempt == 1 + side)):
                cores[side], outer[side] = AXIS_CORE, ball + low
            elif attempt == LAST_CORES:
                cores[side], outer[side] = INSET_CORE, radius
        if cores[0] == cores[1] == SHARP_CORE:
            continue
        if attempt == LAST_CORES and (rounds[i, BALL] > 0.0 or rounds[j, BALL] > 0.0):
            continue
        core = (cores[0], cores[1])
        far = _core_distance(table, placed, rounds, (i, j), core, radius, start, simplex)
        if far <= DEEP * radius:
            continue
        way = _vector(simplex[RESULT], 0)
        normal, is_right = (way[0] / far, way[1] / far, way[2] / far), True
        for side in range(2):
            one = i if side == 0 else j
            if cores[side] == AXIS_CORE and rounds[one, BALL] == 0.0:
                is_right = is_right and abs(_dot(_vector(rounds[one], AXIS), normal)) < SIDE
        if is_right:
            return normal, core, (outer[0], outer[1])
    long = 1.0 / sqrt(_dot(start, start))
    return (long * start[0], long * start[1], long * start[2]), (-1, -1), (0.0, 0.0)


@compiled
def _least_overlap(
    table: Ints, placed: Array, rounds: Array, i: int, j: int, normal: Vector, gap: float
) -> tuple[Vector, float]:
    """Return the normal near another one along which two deep solids overlap least, and the gap along it [m]."""
    step = FIRST_TURN
    while step > LAST_TURN:
        first = _crossed(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < SIDEWAYS else (0.0, 1.0, 0.0))
        long = 1.0 / sqrt(_dot(first, first))
        first = (long * first[0], long * first[1], long * first[2])
        second = _crossed(normal, first)
        best, most = normal, gap
        for way in range(WAYS):
            angle = 2.0 * pi * way / WAYS
            tried = _plus(_plus(normal, step * cos(angle), first), step * sin(angle), second)
            long = 1.0 / sqrt(_dot(tried, tried))
            tried = (long * tried[0], long * tried[1], long * tried[2])
            found = -_extent(table, placed, rounds, i, tried)
            found -= _extent(table, placed, rounds, j, (-tried[0], -tried[1], -tried[2]))
            if found > most:
                best, most = tried, found
        if most > gap:
            normal, gap = best, most
        else:
            step *= 0.5
    return normal, gap


@compiled
def _in_overlap(
    bodies: Array,
    table: Ints,
    placed: Array,
    rounds: Array,
    i: int,
    j: int,
    normal: Vector,
    gap: float,
    rubbing: float,
    points: Points,
    count: int,
) -> int:
    """Add a point amid the points of two solids that are farthest in each other."""
    back, none = (-normal[0], -normal[1], -normal[2]), np.zeros(5)
    a = _plus(_farthest(table, placed, rounds, i, SHARP_CORE, 0.0, normal), rounds[i, BALL], normal)
    b = _plus(_farthest(table, placed, rounds, j, SHARP_CORE, 0.0, back), rounds[j, BALL], back)
    middle = _plus(a, 0.5, _less(b, a))
    low, high = _plus(middle, -0.5 * gap, normal), _plus(middle, 0.5 * gap, normal)
    on = (table[i, BODY], table[j, BODY])
    return _put(bodies, points, count, (i, j), on, False, normal, low, none, high, none, 0.0, rubbing)


@compiled
def _middle(table: Ints, placed: Array, i: int) -> Vector:
    """Return the mean of the corners of a solid [m]."""
    x, y, z, share = 0.0, 0.0, 0.0, 1.0 / (table[i + 1, CORNER] - table[i, CORNER])
    for c in range(table[i, CORNER], table[i + 1, CORNER]):
        x, y, z = x + share * placed[c, 0], y + share * placed[c, 1], z + share * placed[c, 2]
    return x, y, z


@compiled
def _at_cores(
    bodies: Array,
    table: Ints,
    rounds: Array,
    i: int,
    j: int,
    core: tuple[int, int],
    outer: tuple[float, float],
    normal: Vector,
    apart: float,
    radius: float,
    rubbing: float,
    points: Points,
    count: int,
    simplex: Array,
) -> int:
    """Add the point at which two cores are nearest, with the gap of the solids along the normal [m]."""
    bends, balls = np.zeros((2, 5)), 0
    places = np.zeros((2, 3))
    gap = apart
    for side in range(2):
        one, sign = (i, 1.0) if side == 0 else (j, -1.0)
        towards = (sign * normal[0], sign * normal[1], sign * normal[2])
        on_core = _vector(simplex[RESULT], 3 + 3 * side)
        at = on_surface = _plus(on_core, outer[side], towards)
        row = rounds[one]
        if core[side] == AXIS_CORE:
            at = on_core
            bends[side, 0], bends[side, 1] = outer[side] - row[BALL], row[BALL]
            for k in range(3):
                bends[side, 2 + k] = row[AXIS + k]
            if row[BALL] > 0.0 and _dot(_vector(row, AXIS), _vector(row, AXIS)) == 0.0:
                balls += 1
        elif _is_round(rounds, one):
            outwards, sine = _outwards(row, towards)
            for end in range(2):
                on_rim = _on_line(row, float(end), towards, outwards)
                off = _less(on_rim, on_surface)
                if sine > ROLLS and _dot(off, off) < (SHARP * radius) ** 2:
                    at, bend = _held(row, float(end), towards, outwards, sine)
                    on_surface = on_rim
                    for k in range(5):
                        bends[side, k] = bend[k]
        gap += sign * _dot(on_surface, normal)
        places[side, 0], places[side, 1], places[side, 2] = at
    on, low, high = (table[i, BODY], table[j, BODY]), _vector(places[0], 0), _vector(places[1], 0)
    # The surfaces are those of sharp edges, so their distance along the normal may differ from that of the cores.
    count = _put(bodies, points, count, (i, j), on, False, normal, low, bends[0], high, bends[1], gap, rubbing)
    if balls == 2 and count <= len(points.ids):  # noqa: PLR2004 -- both
        points.row[count - 1, BENT] = BALLS
    return count


@compiled
def _along_normal(
    bodies: Array,
    solids: Solids,
    rounds: Array,
    i: int,
    j: int,
    placed: Array,
    normal: Vector,
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add the points at which two solids face each other along a normal; return their number, and the least gap [m]."""
    table = solids.table
    pair, on = (i, j), (table[i, BODY], table[j, BODY])
    if not _is_round(rounds, i):
        return _on_face(bodies, solids, i, placed, rounds[j], normal, pair, on, False, reach, rubbing, points, count)
    if not _is_round(rounds, j):
        back = (-normal[0], -normal[1], -normal[2])
        return _on_face(bodies, solids, j, placed, rounds[i], back, pair, on, True, reach, rubbing, points, count)
    return _between_rounds(bodies, rounds, normal, pair, on, reach, rubbing, points, count)


@compiled
def _on_face(  # noqa: PLR0915 -- points of a line, a rim and a face
    bodies: Array,
    solids: Solids,
    i: int,
    placed: Array,
    row: Array,
    normal: Vector,
    pair: tuple[int, int],
    on: tuple[int, int],
    swapped: bool,
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add the points at which a round solid lies on the face of a solid that faces it along a normal."""
    table, faces, loops, none = solids.table, solids.faces, solids.loops, np.zeros(5)
    b = table[i, BODY]
    steepest, face, plane = STEEP, -1, (0.0, 0.0, 0.0)
    for f in range(table[i, FACE], table[i + 1, FACE]):
        u, v, w = faces[f, 0], faces[f, 1], faces[f, 2]
        x = bodies[b, AXES] * u + bodies[b, AXES + 1] * v + bodies[b, AXES + 2] * w
        y = bodies[b, AXES + 3] * u + bodies[b, AXES + 4] * v + bodies[b, AXES + 5] * w
        z = bodies[b, AXES + 6] * u + bodies[b, AXES + 7] * v + bodies[b, AXES + 8] * w
        if _dot((x, y, z), normal) > steepest:
            steepest, face, plane = _dot((x, y, z), normal), f, (x, y, z)
    if face < 0:
        return count, np.inf
    sides, origin = loops[face, 0], _vector(placed[table[i, CORNER] + loops[face, 1]], 0)
    down, nearest = (-normal[0], -normal[1], -normal[2]), np.inf
    outwards, sine = _outwards(row, down)
    disc = _facing_disc(row, down)
    if disc < 0 or sine >= LEANS:
        start, end = _on_line(row, 0.0, down, outwards), _on_line(row, 1.0, down, outwards)
        low, high = 0.0, 1.0
        for side in range(sides):
            corner, following = _side(table, loops, i, face, placed, side)
            out = _crossed(_less(following, corner), normal)
            long = 1.0 / sqrt(_dot(out, out))
            low, high = _clipped(
                low, high, long * _dot(out, _less(start, corner)), long * _dot(out, _less(end, corner))
            )
        length = _less(end, start)
        apart = (high - low) * sqrt(_dot(length, length))
        number = 0 if low > high else (2 if apart > SHORT * sqrt(_dot(length, length)) else 1)
        for point in range(number):
            share = low if point == 0 else high
            at = _on_line(row, share, down, outwards)
            gap = _dot(_less(at, origin), plane) / steepest
            nearest = min(nearest, gap)
            if gap < reach:
                held, bend = _held(row, share, down, outwards, sine)
                below = _plus(at, -gap, normal)
                count = _put(bodies, points, count, pair, on, swapped, normal, below, none, held, bend, 0.0, rubbing)
    if disc < 0:
        return count, nearest
    axis, centre, radius = _vector(row, AXIS), _vector(row, DISC + 3 * disc), row[RADIUS + disc]
    upright = _dot(axis, normal)
    for number in range(RIM_POINTS):
        at = _rim_point(row, disc, number)
        gap = _dot(_less(at, origin), plane) / steepest
        inside = gap < reach
        for side in range(sides):
            if inside:
                corner, following = _side(table, loops, i, face, placed, side)
                out = _crossed(_less(following, corner), normal)
                inside = _dot(out, _less(at, corner)) <= EITHER * sqrt(_dot(out, out))
        if inside:
            nearest = min(nearest, gap)
            below = _plus(at, -gap, normal)
            count = _put(bodies, points, count, pair, on, swapped, normal, below, none, at, none, 0.0, rubbing)
    for side in range(sides):  # corners of the face in the disc, and where its sides cross the rim
        corner, following = _side(table, loops, i, face, placed, side)
        p = _plus(corner, _dot(_less(centre, corner), axis) / upright, normal)
        q = _plus(following, _dot(_less(centre, following), axis) / upright, normal)
        low, high = _in_circle(p, q, centre, radius)
        for point in range(3):
            share = 0.0 if point == 0 else (low if point == 1 else high)
            if (point == 0 and low == 0.0 and high > 0.0) or (point > 0 and low < high and 0.0 < share < 1.0):
                below, at = _plus(corner, share, _less(following, corner)), _plus(p, share, _less(q, p))
                gap = _dot(_less(at, below), normal)
                nearest = min(nearest, gap)
                if gap < reach:
                    count = _put(bodies, points, count, pair, on, swapped, normal, below, none, at, none, 0.0, rubbing)
    return count, nearest


@compiled
def _side(table: Ints, loops: Ints, i: int, face: int, placed: Array, side: int) -> tuple[Vector, Vector]:
    """Return the two ends of a side of a face [m]."""
    sides, first = loops[face, 0], table[i, CORNER]
    corner, following = loops[face, 1 + side], loops[face, 1 + (side + 1) % sides]
    return _vector(placed[first + corner], 0), _vector(placed[first + following], 0)


@compiled
def _clipped(low: float, high: float, start: float, end: float) -> tuple[float, float]:
    """Return the part of a range of a line that is inside a border, by the heights of its ends over it [m]."""
    if start <= EITHER and end <= EITHER:
        return low, high
    if start > EITHER and end > EITHER:
        return 1.0, 0.0
    share = min(1.0, max(0.0, start / (start - end)))
    return (low, min(high, share)) if end > start else (max(low, share), high)


@compiled
def _in_circle(p: Vector, q: Vector, centre: Vector, radius: float) -> tuple[float, float]:
    """Return the part of a line within a circle in its plane, as shares of its length; (1, 0) if it is outside."""
    way, start = _less(q, p), _less(p, centre)
    a, b, c = _dot(way, way), _dot(way, start), _dot(start, start) - radius * radius
    if a == 0.0:
        return (0.0, 1.0) if c <= 0.0 else (1.0, 0.0)
    root = b * b - a * c
    if root < 0.0:
        return 1.0, 0.0
    root = sqrt(root)
    low, high = max(0.0, (-b - root) / a), min(1.0, (-b + root) / a)
    return (low, high) if low <= high else (1.0, 0.0)


@compiled
def _between_rounds(
    bodies: Array,
    rounds: Array,
    normal: Vector,
    pair: tuple[int, int],
    on: tuple[int, int],
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add the points at which two round solids face each other along a normal."""
    i, j = pair
    down = (-normal[0], -normal[1], -normal[2])
    on_low, on_high = _facing_disc(rounds[i], normal), _facing_disc(rounds[j], down)
    nearest = np.inf
    if on_low < 0 and on_high < 0:
        return _along_lines(bodies, rounds, normal, pair, on, reach, rubbing, points, count)
    if on_low >= 0:
        count, nearest = _line_on_disc(
            bodies, rounds[i], on_low, rounds[j], normal, pair, on, False, reach, rubbing, points, count
        )
    if on_high >= 0:
        count, gap = _line_on_disc(
            bodies, rounds[j], on_high, rounds[i], down, pair, on, True, reach, rubbing, points, count
        )
        nearest = min(nearest, gap)
    if on_low >= 0 and on_high >= 0:
        count, gap = _on_discs(bodies, rounds, (on_low, on_high), normal, pair, on, reach, rubbing, points, count)
        nearest = min(nearest, gap)
    return count, nearest


@compiled
def _line_on_disc(
    bodies: Array,
    low: Array,
    disc: int,
    row: Array,
    normal: Vector,
    pair: tuple[int, int],
    on: tuple[int, int],
    swapped: bool,
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add the points at which the line of a round solid nearest to a disc lies within the disc."""
    down, none, nearest = (-normal[0], -normal[1], -normal[2]), np.zeros(5), np.inf
    outwards, sine = _outwards(row, down)
    if _facing_disc(row, down) >= 0 and sine < LEANS:
        return count, nearest
    axis, centre = _vector(low, AXIS), _vector(low, DISC + 3 * disc)
    upright = _dot(axis, normal)
    start, end = _on_line(row, 0.0, down, outwards), _on_line(row, 1.0, down, outwards)
    p = _plus(start, _dot(_less(centre, start), axis) / upright, normal)
    q = _plus(end, _dot(_less(centre, end), axis) / upright, normal)
    from_, to = _in_circle(p, q, centre, low[RADIUS + disc] + EITHER)
    number = 0 if from_ > to else (2 if to - from_ > SHORT and _dot(_less(q, p), _less(q, p)) > 0.0 else 1)
    for point in range(number):
        share = from_ if point == 0 else to
        at, below = _on_line(row, share, down, outwards), _plus(p, share, _less(q, p))
        gap = _dot(_less(at, below), normal)
        nearest = min(nearest, gap)
        if gap < reach:
            held, bend = _held(row, share, down, outwards, sine)
            count = _put(bodies, points, count, pair, on, swapped, normal, below, none, held, bend, 0.0, rubbing)
    return count, nearest


@compiled
def _on_discs(
    bodies: Array,
    rounds: Array,
    discs: tuple[int, int],
    normal: Vector,
    pair: tuple[int, int],
    on: tuple[int, int],
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add the points of two discs that lie on each other: rim points in the other disc, and where the rims cross."""
    none, nearest = np.zeros(5), np.inf
    rows = (rounds[pair[0]], rounds[pair[1]])
    centres = (_vector(rows[0], DISC + 3 * discs[0]), _vector(rows[1], DISC + 3 * discs[1]))
    axes = (_vector(rows[0], AXIS), _vector(rows[1], AXIS))
    radii = (rows[0][RADIUS + discs[0]], rows[1][RADIUS + discs[1]])
    for side in range(2):
        other = 1 - side
        upright = _dot(axes[other], normal)
        for number in range(RIM_POINTS):
            at = _rim_point(rows[side], discs[side], number)
            there = _plus(at, _dot(_less(centres[other], at), axes[other]) / upright, normal)
            off = _less(there, centres[other])
            low, high = (at, there) if side == 0 else (there, at)
            gap = _dot(_less(high, low), normal)
            # Where both rims are flush, the points of one of them are enough.
            if _dot(off, off) <= (radii[other] + (EITHER if side == 0 else -EITHER)) ** 2:
                nearest = min(nearest, gap)
                if gap < reach:
                    count = _put(bodies, points, count, pair, on, False, normal, low, none, high, none, 0.0, rubbing)
    upright = _dot(axes[0], normal)
    middle = _plus(centres[1], _dot(_less(centres[0], centres[1]), axes[0]) / upright, normal)
    way = _less(middle, centres[0])
    far = sqrt(_dot(way, way))
    if far <= EITHER:
        return count, nearest
    along = 0.5 * (far * far + radii[0] ** 2 - radii[1] ** 2) / far
    square = radii[0] ** 2 - along * along
    if square <= 0.0:
        return count, nearest
    way = (way[0] / far, way[1] / far, way[2] / far)
    across = _crossed(axes[0], way)
    for side in range(2):
        half = sqrt(square) * (2.0 * side - 1.0)
        low = _plus(_plus(centres[0], along, way), half, across)
        high = _plus(low, _dot(_less(centres[1], low), axes[1]) / _dot(axes[1], normal), normal)
        gap = _dot(_less(high, low), normal)
        nearest = min(nearest, gap)
        if gap < reach:
            count = _put(bodies, points, count, pair, on, False, normal, low, none, high, none, 0.0, rubbing)
    return count, nearest


@compiled
def _along_lines(
    bodies: Array,
    rounds: Array,
    normal: Vector,
    pair: tuple[int, int],
    on: tuple[int, int],
    reach: float,
    rubbing: float,
    points: Points,
    count: int,
) -> tuple[int, float]:
    """Add both ends of the common part of the lines of two solids that lie side by side."""
    nearest, low, high = np.inf, rounds[pair[0]], rounds[pair[1]]
    down = (-normal[0], -normal[1], -normal[2])
    out_low, sine_low = _outwards(low, normal)
    out_high, sine_high = _outwards(high, down)
    a, b = _on_line(low, 0.0, normal, out_low), _on_line(low, 1.0, normal, out_low)
    p, q = _on_line(high, 0.0, down, out_high), _on_line(high, 1.0, down, out_high)
    own, other = _less(b, a), _less(q, p)
    square, cosine = _dot(own, own), _dot(own, other)
    if square == 0.0 or cosine * cosine <= PARALLEL * square * _dot(other, other):
        return count, nearest
    first, last = _dot(_less(p, a), own) / square, _dot(_less(q, a), own) / square
    start, end = max(0.0, min(first, last)), min(1.0, max(first, last))
    if end - start <= SHORT:
        return count, nearest
    for side in range(2):
        share = start if side == 0 else end
        across = (share - first) / (last - first)
        gap = _dot(_less(_on_line(high, across, down, out_high), _on_line(low, share, normal, out_low)), normal)
        nearest = min(nearest, gap)
        if gap < reach:
            held_low, bend_low = _held(low, share, normal, out_low, sine_low)
            held_high, bend_high = _held(high, across, down, out_high, sine_high)
            count = _put(
                bodies, points, count, pair, on, False, normal, held_low, bend_low, held_high, bend_high, 0.0, rubbing
            )
    return count, nearest


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
        if row[c, BENT] == BALLS:
            _turn_normal(bodies, index, row, c)
        normal = along = across = both = drags = drags_across = 0.0
        for side in range(2):
            i, on, arm, turns = index[c, ON_BODY + side], 9 + 3 * side, 22 + 3 * side, 32 + 9 * side
            sign = 2.0 * side - 1.0
            u, v, w = row[c, on], row[c, on + 1], row[c, on + 2]
            x = bodies[i, AXES] * u + bodies[i, AXES + 1] * v + bodies[i, AXES + 2] * w
            y = bodies[i, AXES + 3] * u + bodies[i, AXES + 4] * v + bodies[i, AXES + 5] * w
            z = bodies[i, AXES + 6] * u + bodies[i, AXES + 7] * v + bodies[i, AXES + 8] * w
            if row[c, BENT] > 0.0:
                x, y, z = _surface(bodies, i, row, c, side, x, y, z)
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
