"""Distances between boxes, planes and convex bodies, and the definition of contact."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import hypot, inf
from typing import TypeAlias

from stability.geometry.vectors import add, body_axes, cross, dot, rotate, scale, subtract
from stability.model import HalfSpace, Plane, Pose, Vec3

# The separating axes of two boxes (Gottschalk, Lin and Manocha, 1996): 3 + 3 face normals and 9 products of edges.
#
# They give the distance of two boxes, their contact, and the collision of a moving box. A box is given by its axes in W
# and its half lengths; `turn` holds the cosines between the axes of a (rows) and b.


Axes: TypeAlias = tuple[Vec3, Vec3, Vec3]
Matrix: TypeAlias = tuple[Vec3, Vec3, Vec3]
# Product of two edges: the numbers of the edges of a and b, the cosine and sine for `along_product`, the length of the
# product, and the extent of both boxes along it, times that length.
EdgeProduct: TypeAlias = tuple[int, int, float, float, float, float]

PARALLEL = 1e-9  # sine of the angle below which edges count as parallel


def coordinates(vector_W: Vec3, axes: Axes) -> Vec3:
    """Return the coordinates of a vector along three axes."""
    # Written out for speed: this takes a large part of the time of a comparison.
    x, y, z = vector_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    return (x * ux + y * uy + z * uz, x * vx + y * vy + z * vz, x * wx + y * wy + z * wz)


def cosines(axes_a: Axes, axes_b: Axes) -> Matrix:
    """Return the cosines between the axes of a (rows) and those of b."""
    u, v, w = axes_a
    return (coordinates(u, axes_b), coordinates(v, axes_b), coordinates(w, axes_b))


def transposed(m: Matrix) -> Matrix:
    """Return the transposed matrix."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))


def face_gaps(along: Vec3, half: Vec3, other: Vec3, turn: Matrix) -> Vec3:
    """Return the gaps along the three face normals of a box, from the distances `along` of the centres [m].

    The rows of `turn` are the cosines of these normals with the axes of the other box.
    """
    a, b, c = other
    (u0, u1, u2), (v0, v1, v2), (w0, w1, w2) = turn
    return (
        abs(along[0]) - half[0] - a * abs(u0) - b * abs(u1) - c * abs(u2),
        abs(along[1]) - half[1] - a * abs(v0) - b * abs(v1) - c * abs(v2),
        abs(along[2]) - half[2] - a * abs(w0) - b * abs(w1) - c * abs(w2),
    )


def edge_products(turn: Matrix, half_a: Vec3, half_b: Vec3) -> Iterator[EdgeProduct]:
    """Yield the products of edges that are not parallel."""
    for i in range(3):
        row, next_row, last_row = turn[i], turn[i - 2], turn[i - 1]
        half_next, half_last = half_a[i - 2], half_a[i - 1]
        for j, k, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # In the frame of a, with axis i first, the product of edges i and j is (0, -s, c).
            c, s = next_row[j], last_row[j]
            length = hypot(c, s)
            if length > PARALLEL:
                extent = half_next * abs(s) + half_last * abs(c) + half_b[k] * abs(row[m]) + half_b[m] * abs(row[k])
                yield i, j, c, s, length, extent


def along_product(along_a: Vec3, i: int, c: float, s: float) -> float:
    """Return the component of a vector in coordinates of a along a product of edges, times the product's length."""
    return along_a[i - 1] * c - along_a[i - 2] * s


def half_extent(axes: Axes, half: Vec3, direction_W: Vec3) -> float:
    """Return the extent of a box from its centre along a unit direction [m]."""
    x, y, z = direction_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    a, b, c = half
    return a * abs(ux * x + uy * y + uz * z) + b * abs(vx * x + vy * y + vz * z) + c * abs(wx * x + wy * y + wz * z)


# Separation of two boxes, or of a box and a plane: distance and direction.
#
# It is the largest gap over the separating axes. For overlapping boxes it is minus the penetration depth. For others it
# is a lower bound of the distance, and exact if a face is closest.


ORIGIN: Vec3 = (0.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)
UNTURNED: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


class InBounds:
    """Body in a bounding box along the axes of W, relative to the centre of mass."""

    __slots__ = ()
    low_W: Vec3
    high_W: Vec3

    @property
    def middle_W(self) -> Vec3:
        """The centre of the bounding box [m]."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        return (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))

    @property
    def reach(self) -> Vec3:
        """The half size of the bounding box [m]."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        return (0.5 * (bx - ax), 0.5 * (by - ay), 0.5 * (bz - az))


@dataclass(frozen=True, slots=True)
class Separation:
    """Gap between two bodies, and the direction that widens it."""

    gap: float  # [m], negative where they overlap
    normal_BA_W: Vec3  # unit, from the second body towards the first


@dataclass(frozen=True, slots=True)
class Block:
    """Box at a pose, with values for fast comparisons with other boxes."""

    p_WC: Vec3  # centre [m]
    axes_W: Axes
    half: Vec3  # half lengths along these axes [m]
    half_edges_W: tuple[Vec3, Vec3, Vec3]  # half of each edge vector [m]
    reach: Vec3  # half size of the bounding box [m]
    thickness: float  # smallest side [m]

    @property
    def is_level(self) -> bool:
        """Whether the third axis is vertical, as that of a flat plank."""
        return self.axes_W[2] == UP

    @property
    def middle_W(self) -> Vec3:
        """The centre of the bounding box [m]."""
        return self.p_WC

    @property
    def low_W(self) -> Vec3:
        """The lowest corner of the bounding box [m]."""
        return subtract(self.p_WC, self.reach)

    @property
    def high_W(self) -> Vec3:
        """The highest corner of the bounding box [m]."""
        return add(self.p_WC, self.reach)


def block(size: Vec3, pose: Pose) -> Block:
    """Create the block of a box with full lengths `size` at a pose."""
    axes = body_axes(pose.orientation)
    half = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2])
    a, b, c = ((length * x, length * y, length * z) for length, (x, y, z) in zip(half, axes, strict=True))
    reach = (abs(a[0]) + abs(b[0]) + abs(c[0]), abs(a[1]) + abs(b[1]) + abs(c[1]), abs(a[2]) + abs(b[2]) + abs(c[2]))
    return Block(pose.position_W, axes, half, (a, b, c), reach, min(size))


def boxes_apart(size_a: Vec3, pose_a: Pose, size_b: Vec3, pose_b: Pose) -> Separation:
    """Return the separation of box a from box b."""
    return blocks_apart(block(size_a, pose_a), block(size_b, pose_b))


def blocks_apart(a: Block, b: Block) -> Separation:
    """Return the separation of box a from box b."""
    p_BA = subtract(a.p_WC, b.p_WC)
    if a.axes_W == b.axes_W == UNTURNED:
        return _unrotated_separation(p_BA, a.half, b.half)
    along_a, along_b = coordinates(p_BA, a.axes_W), coordinates(p_BA, b.axes_W)
    turn = cosines(a.axes_W, b.axes_W)
    gaps = (*face_gaps(along_a, a.half, b.half, turn), *face_gaps(along_b, b.half, a.half, transposed(turn)))
    best, normal = -inf, UP
    for gap, along, axis in zip(gaps, (*along_a, *along_b), (*a.axes_W, *b.axes_W), strict=True):
        # Faces come first and win ties: an edge product is never a better normal than that of a face.
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    if a.is_level and b.is_level:  # all products of their edges are face normals
        return Separation(best, normal)
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        gap = (abs(along) - extent) / length
        if gap > best + PARALLEL:
            best, normal = gap, scale((1.0 if along >= 0.0 else -1.0) / length, cross(a.axes_W[i], b.axes_W[j]))
    return Separation(best, normal)


def _unrotated_separation(p_BA: Vec3, half_a: Vec3, half_b: Vec3) -> Separation:
    """Return the separation of boxes along the axes of W: most are, and it takes a quarter of the time.

    The sums are those of the general case, to the last bit.
    """
    best, normal = -inf, UP
    for along, a, b, axis in zip(p_BA, half_a, half_b, UNTURNED, strict=True):
        gap = abs(along) - a - b
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    return Separation(best, normal)


def meeting(moving: Block, fixed: Block, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """Return the travel along a unit direction at which a box enters and leaves another [m]; None if it misses it.

    Exact: translated boxes collide when they overlap along every separating axis. An overlap across the direction
    of less than `graze` [m] counts as a miss.
    """
    enters, leaves = -inf, inf
    for ahead, speed, reach in _along_all_axes(moving, fixed, direction_W):
        if abs(speed) > PARALLEL:
            first, last = sorted(((ahead - reach) / speed, (ahead + reach) / speed))
            enters, leaves = max(enters, first), min(leaves, last)
        elif abs(ahead) > reach - graze:
            return None
    return (enters, leaves) if enters < leaves else None


def _along_all_axes(a: Block, b: Block, direction_W: Vec3) -> Iterator[tuple[float, float, float]]:
    """Yield for each separating axis the distance from a to b [m], the direction's component, and both extents [m]."""
    p_AB, turn = subtract(b.p_WC, a.p_WC), cosines(a.axes_W, b.axes_W)
    ahead_a, speed_a = coordinates(p_AB, a.axes_W), coordinates(direction_W, a.axes_W)
    reach_a = (-gap for gap in face_gaps(ORIGIN, a.half, b.half, turn))
    yield from zip(ahead_a, speed_a, reach_a, strict=True)
    reach_b = (-gap for gap in face_gaps(ORIGIN, b.half, a.half, transposed(turn)))
    yield from zip(coordinates(p_AB, b.axes_W), coordinates(direction_W, b.axes_W), reach_b, strict=True)
    if not (a.is_level and b.is_level):
        for i, _, c, s, length, extent in edge_products(turn, a.half, b.half):
            yield along_product(ahead_a, i, c, s) / length, along_product(speed_a, i, c, s) / length, extent / length


def box_above_plane(size: Vec3, pose: Pose, plane: Plane) -> Separation:
    """Return the separation of a box from a half-space."""
    return block_above_plane(block(size, pose), plane)


def block_above_plane(above: Block, plane: Plane) -> Separation:
    """Return the separation of a box from a half-space."""
    height = dot(subtract(above.p_WC, plane.point_W), plane.normal_W)
    return Separation(height - half_extent(above.axes_W, above.half, plane.normal_W), plane.normal_W)


def in_world(shape: HalfSpace, pose: Pose) -> Plane:
    """Return the bounding plane of a half-space in W, without friction."""
    return Plane("", pose.position_W, rotate(pose.orientation, shape.normal), friction=0.0)


# Nearest points of two convex bodies.
#
# They give the shortest vector of the Minkowski difference of both bodies, found from support points alone (Wolfe's
# algorithm, 1976, with the support functions of Gilbert, Johnson and Keerthi, 1988). It takes few support points, even
# for nearly parallel edges or faces, where alternating projections take thousands.


Support: TypeAlias = Callable[[Vec3], Vec3]  # support function: a body's farthest point along a direction [m]

ENOUGH = 1e-10  # relative improvement of the squared distance that ends the search
ROUNDING = 1e-14  # the same, relative to the squared distance of the farthest corner: rounding
OVERLAPPING = 1e-7  # distance of overlapping bodies, relative to that of the farthest corner
MOST_SUPPORTS = 64  # boxes take four to eight
A_TRIANGLE = 3  # corners

# A corner of the Minkowski difference, with the point of each body.
_Corner: TypeAlias = tuple[Vec3, Vec3, Vec3]


def nearest_points(support_a: Support, support_b: Support, start_W: Vec3) -> tuple[Vec3, Vec3] | None:
    """Return the nearest points of two bodies; None if the bodies overlap.

    `start_W` is any vector from the second towards the first, such as that between their centres.
    """
    corners = [_corner(support_a, support_b, start_W)]
    shares: Sequence[float] = (1.0,)
    farthest_square = dot(corners[0][0], corners[0][0])  # [m2] of the farthest corner
    for _ in range(MOST_SUPPORTS):
        shortest = _mixed(shares, [corner[0] for corner in corners])
        square = dot(shortest, shortest)
        ahead = _corner(support_a, support_b, shortest)
        farthest_square = max(farthest_square, dot(ahead[0], ahead[0]))
        if square <= OVERLAPPING**2 * farthest_square:
            return None
        nearest_component = min(dot(shortest, corner[0]) for corner in corners)  # the square, but for rounding
        if nearest_component - dot(shortest, ahead[0]) <= ENOUGH * square + ROUNDING * farthest_square:
            break
        corners.append(ahead)
        shares, corners = _inside(corners, (*shares, 0.0))
        if len(corners) > A_TRIANGLE:
            return None
    return _mixed(shares, [corner[1] for corner in corners]), _mixed(shares, [corner[2] for corner in corners])


def _corner(support_a: Support, support_b: Support, away_W: Vec3) -> _Corner:
    """Return the corner of the Minkowski difference with the smallest component along a direction."""
    on_a, on_b = support_a(scale(-1.0, away_W)), support_b(away_W)
    return subtract(on_a, on_b), on_a, on_b


def _inside(corners: list[_Corner], shares: Sequence[float]) -> tuple[Sequence[float], list[_Corner]]:
    """Return the corners whose hull contains the shortest vector, with its weights."""
    while True:
        target = _affine_shares([corner[0] for corner in corners])
        if min(target) >= 0.0:
            return target, corners
        # Move towards these weights until one becomes 0, and drop its corner.
        changes = list(zip(shares, target, strict=True))
        step, dropped = min((old / (old - new), i) for i, (old, new) in enumerate(changes) if new < 0.0)
        shares = [old + step * (new - old) for old, new in changes]
        shares = [max(share, 0.0) for i, share in enumerate(shares) if i != dropped]
        corners = [corner for i, corner in enumerate(corners) if i != dropped]


def _affine_shares(points: Sequence[Vec3]) -> Sequence[float]:
    """Return the weights, with sum 1, of up to four points for the shortest vector of their affine hull."""
    first, *others = points
    match [subtract(other, first) for other in others]:
        case []:
            return (1.0,)
        case [u]:
            share = -dot(first, u) / dot(u, u)
            return 1.0 - share, share
        case [u, v]:
            across = cross(u, v)
            area = dot(across, across)
            of_u, of_v = -dot(cross(first, v), across) / area, -dot(cross(u, first), across) / area
            return 1.0 - (of_u + of_v), of_u, of_v
        case [u, v, w]:
            across = cross(v, w)
            volume = dot(u, across)
            weights = (
                -dot(first, across) / volume,
                -dot(u, cross(first, w)) / volume,
                -dot(u, cross(v, first)) / volume,
            )
            return 1.0 - (weights[0] + weights[1] + weights[2]), *weights
        case _:
            raise ValueError("a simplex in space has at most four corners")


def _mixed(shares: Sequence[float], points: Sequence[Vec3]) -> Vec3:
    """Return the weighted sum of points."""
    x = y = z = 0.0
    for share, (a, b, c) in zip(shares, points, strict=True):
        x, y, z = x + share * a, y + share * b, z + share * c
    return x, y, z


# The definition of contact, used by statics, both methods, the compiler and `explain`.
#
# Two bodies touch if their gap and their overlap are within their reach, a share of the smallest side of the thinner
# one. So contacts do not depend on the scale of a scene.
#
# A gap below a body closes when the body moves down; a gap beside it does not, and no force crosses it. So the largest
# gap along an inclined normal is the one that a downward motion by the reach closes, and beside a body it is nearly 0.
# This applies to each point of a contact and to each separating direction of two bodies. `within` can limit gaps
# further; the limit of overlaps is always the reach.


# Share of the smallest side: gaps that engines leave. Less than a fifth of a millimetre for a plank of 7.8 mm, below
# the 0.2 mm between the ends of planks in walls.
TOUCHING = 0.02
# Share of the reach for gaps beside a body: a thousandth of its smallest side, the precision of files. Bodies that an
# engine presses together sideways overlap by a ten-thousandth.
BESIDE = 0.05
LIMIT_ITSELF = 1.0 + 1e-9  # so that a gap written as the limit is a contact in spite of rounding
# Share of the reach up to which a gap counts as 0: a millionth of the smallest side, 8 nm for a plank of 7.8 mm. It is
# a hundred times the rounding of sums of lengths, and more than the nanometres by which processors differ.
NO_GAP = 5e-5


def reach_between(thickness: float, other: float = inf, share: float = TOUCHING) -> float:
    """Return the largest gap of a contact [m] from the smallest sides of both bodies [m]; the default is a plane.

    The reach to a plane is the largest of a body, so it bounds the distance of all bodies that it may touch.
    """
    return LIMIT_ITSELF * share * (thickness if thickness < other else other)


def gap_bridged(reach: float, upward: float, within: float = inf) -> float:
    """Return the largest gap of a contact [m] from the reach [m] and the z component of the unit normal.

    A `within` [m] below the reach replaces the reach; 0 allows no gap.
    """
    share = min(1.0, max(BESIDE, upward, -upward))
    return min(reach * share, within * share + NO_GAP * reach)
