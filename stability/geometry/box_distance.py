"""Distances between boxes, planes and convex bodies, and the one definition of touching."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import hypot, inf
from typing import TypeAlias

from stability.geometry.vectors import add, body_axes, cross, dot, rotate, scale, subtract
from stability.model import HalfSpace, Plane, Pose, Vec3

# The separating axes of two boxes (Gottschalk, Lin and Manocha, 1996): 3 + 3 face normals and 9 products of edges.
#
# How far apart two boxes are, how they touch, and where one that moves meets the other are all read off these. A box is
# given by its axes in W and its half lengths along them; `turn` holds the cosines between the axes of a (rows) and of
# b.


Axes: TypeAlias = tuple[Vec3, Vec3, Vec3]
Matrix: TypeAlias = tuple[Vec3, Vec3, Vec3]
# One product of edges: the number of the edge of a and of b, the cosine and sine that `along_product` takes, its length
# as a vector, and how far both boxes reach along it, in so many times that length.
EdgeProduct: TypeAlias = tuple[int, int, float, float, float, float]

PARALLEL = 1e-9  # sine below which two edges give no direction of their own


def coordinates(vector_W: Vec3, axes: Axes) -> Vec3:
    """A vector along three axes."""
    # Written out, as much of the time of a comparison is spent here.
    x, y, z = vector_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    return (x * ux + y * uy + z * uz, x * vx + y * vy + z * vz, x * wx + y * wy + z * wz)


def cosines(axes_a: Axes, axes_b: Axes) -> Matrix:
    """Between the axes of a (rows) and those of b."""
    u, v, w = axes_a
    return (coordinates(u, axes_b), coordinates(v, axes_b), coordinates(w, axes_b))


def transposed(m: Matrix) -> Matrix:
    """Rows for columns."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))


def face_gaps(along: Vec3, half: Vec3, other: Vec3, turn: Matrix) -> Vec3:
    """The gaps along the three face normals of a box, for centres so far apart along them [m].

    Rows of `turn` are the cosines of these normals with the axes of the other box.
    """
    a, b, c = other
    (u0, u1, u2), (v0, v1, v2), (w0, w1, w2) = turn
    return (
        abs(along[0]) - half[0] - a * abs(u0) - b * abs(u1) - c * abs(u2),
        abs(along[1]) - half[1] - a * abs(v0) - b * abs(v1) - c * abs(v2),
        abs(along[2]) - half[2] - a * abs(w0) - b * abs(w1) - c * abs(w2),
    )


def edge_products(turn: Matrix, half_a: Vec3, half_b: Vec3) -> Iterator[EdgeProduct]:
    """The products of edges that are not parallel."""
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
    """A vector, given by its coordinates along the axes of a, along a product of edges, in so many times its length."""
    return along_a[i - 1] * c - along_a[i - 2] * s


def half_extent(axes: Axes, half: Vec3, direction_W: Vec3) -> float:
    """How far a box reaches from its centre along a unit direction [m]."""
    x, y, z = direction_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    a, b, c = half
    return a * abs(ux * x + uy * y + uz * z) + b * abs(vx * x + vy * y + vz * z) + c * abs(wx * x + wy * y + wz * z)


# Separation of two boxes, or of a box and a plane: distance and direction.
#
# It is the largest gap over the separating axes. Where the boxes overlap, it is minus the shortest way out. Where they
# are apart, it is a lower bound of the distance, exact when a face is closest.


ORIGIN: Vec3 = (0.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)
UNTURNED: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


@dataclass(frozen=True, slots=True)
class Separation:
    """The gap between two bodies, and the way to widen it."""

    gap: float  # [m], negative where they overlap
    normal_BA_W: Vec3  # unit, from the second body towards the first


@dataclass(frozen=True, slots=True)
class Block:
    """A box with what a comparison with many others needs of it."""

    p_WC: Vec3  # its centre [m]
    axes_W: Axes
    half: Vec3  # half lengths along these axes [m]
    half_edges_W: tuple[Vec3, Vec3, Vec3]  # half of each edge, along its axis [m]
    reach: Vec3  # half of the upright box around it [m]
    thickness: float  # its smallest side [m]

    @property
    def is_level(self) -> bool:
        """Whether its third axis is vertical, as that of a plank that lies flat."""
        return self.axes_W[2] == UP

    @property
    def middle_W(self) -> Vec3:
        """The middle of the upright box around it [m]."""
        return self.p_WC

    @property
    def low_W(self) -> Vec3:
        """The lowest corner of the upright box around it [m]."""
        return subtract(self.p_WC, self.reach)

    @property
    def high_W(self) -> Vec3:
        """The highest corner of it [m]."""
        return add(self.p_WC, self.reach)


def block(size: Vec3, pose: Pose) -> Block:
    """A box of full lengths `size`, worked out."""
    axes = body_axes(pose.orientation)
    half = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2])
    a, b, c = ((length * x, length * y, length * z) for length, (x, y, z) in zip(half, axes, strict=True))
    reach = (abs(a[0]) + abs(b[0]) + abs(c[0]), abs(a[1]) + abs(b[1]) + abs(c[1]), abs(a[2]) + abs(b[2]) + abs(c[2]))
    return Block(pose.position_W, axes, half, (a, b, c), reach, min(size))


def boxes_apart(size_a: Vec3, pose_a: Pose, size_b: Vec3, pose_b: Pose) -> Separation:
    """The separation of box a from box b."""
    return blocks_apart(block(size_a, pose_a), block(size_b, pose_b))


def blocks_apart(a: Block, b: Block) -> Separation:
    """The separation of box a from box b."""
    p_BA = subtract(a.p_WC, b.p_WC)
    if a.axes_W == b.axes_W == UNTURNED:
        return _untouched_by_turns(p_BA, a.half, b.half)
    along_a, along_b = coordinates(p_BA, a.axes_W), coordinates(p_BA, b.axes_W)
    turn = cosines(a.axes_W, b.axes_W)
    gaps = (*face_gaps(along_a, a.half, b.half, turn), *face_gaps(along_b, b.half, a.half, transposed(turn)))
    best, normal = -inf, UP
    for gap, along, axis in zip(gaps, (*along_a, *along_b), (*a.axes_W, *b.axes_W), strict=True):
        # Faces come first and win ties: an edge product is never a better normal where a face does.
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    if a.is_level and b.is_level:  # every product of their edges is a face normal again
        return Separation(best, normal)
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        gap = (abs(along) - extent) / length
        if gap > best + PARALLEL:
            best, normal = gap, scale((1.0 if along >= 0.0 else -1.0) / length, cross(a.axes_W[i], b.axes_W[j]))
    return Separation(best, normal)


def _untouched_by_turns(p_BA: Vec3, half_a: Vec3, half_b: Vec3) -> Separation:
    """The same of boxes that are not turned, by the same sums to the last bit: most are so, and it takes a quarter."""
    best, normal = -inf, UP
    for along, a, b, axis in zip(p_BA, half_a, half_b, UNTURNED, strict=True):
        gap = abs(along) - a - b
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    return Separation(best, normal)


def meeting(moving: Block, fixed: Block, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """How far along a unit direction a box goes until it touches another, and until it leaves it; None if it passes.

    Exact: by translation, two boxes meet where they come to overlap along every separating axis. What would touch the
    other by less than `graze` [m] sideways passes by it.
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
    """Along each separating axis: how far b is ahead of a [m], a unit of the direction, and how far both reach [m]."""
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
    """The separation of a box from a half-space."""
    return block_above_plane(block(size, pose), plane)


def block_above_plane(above: Block, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    height = dot(subtract(above.p_WC, plane.point_W), plane.normal_W)
    return Separation(height - half_extent(above.axes_W, above.half, plane.normal_W), plane.normal_W)


def in_world(shape: HalfSpace, pose: Pose) -> Plane:
    """A half-space as the plane that bounds it in W; it knows of no friction."""
    return Plane("", pose.position_W, rotate(pose.orientation, shape.normal), friction=0.0)


# The points of two convex bodies that are nearest to each other, and so the shortest way between them.
#
# The shortest vector of the difference of both bodies, of which nothing is asked but which point of each lies farthest
# along a direction (Wolfe's algorithm, 1976, on the supports of Gilbert, Johnson and Keerthi, 1988). It ends after a
# few supports, also where edges or faces are almost parallel and going to and fro between two bodies would take
# thousands.


Support: TypeAlias = Callable[[Vec3], Vec3]  # from a direction to the point of a body that lies farthest along it [m]

ENOUGH = 1e-10  # of the square of the distance: a further corner that shortens it by less ends the search
ROUNDING = 1e-14  # of the square of how far the farthest corner is: what is shortened by less may be rounding
OVERLAPPING = 1e-7  # of how far that corner is: what is nearer overlaps
MOST_SUPPORTS = 64  # boxes take four to eight
A_TRIANGLE = 3  # corners

# A corner of the difference of both bodies, and the points of both of which it is that.
_Corner: TypeAlias = tuple[Vec3, Vec3, Vec3]


def nearest_points(support_a: Support, support_b: Support, start_W: Vec3) -> tuple[Vec3, Vec3] | None:
    """The points of two bodies that are nearest to each other; None if the bodies overlap.

    `start_W` is any vector towards the first from the second, such as that between their middles.
    """
    corners = [_corner(support_a, support_b, start_W)]
    shares: Sequence[float] = (1.0,)
    far = dot(corners[0][0], corners[0][0])  # [m2] of the farthest corner
    for _ in range(MOST_SUPPORTS):
        shortest = _mixed(shares, [corner[0] for corner in corners])
        square = dot(shortest, shortest)
        ahead = _corner(support_a, support_b, shortest)
        far = max(far, dot(ahead[0], ahead[0]))
        if square <= OVERLAPPING**2 * far:
            return None
        reached = min(dot(shortest, corner[0]) for corner in corners)  # the square, but for rounding
        if reached - dot(shortest, ahead[0]) <= ENOUGH * square + ROUNDING * far:
            break
        corners.append(ahead)
        shares, corners = _inside(corners, (*shares, 0.0))
        if len(corners) > A_TRIANGLE:
            return None
    return _mixed(shares, [corner[1] for corner in corners]), _mixed(shares, [corner[2] for corner in corners])


def _corner(support_a: Support, support_b: Support, away_W: Vec3) -> _Corner:
    """The corner of the difference that lies least along a direction."""
    on_a, on_b = support_a(scale(-1.0, away_W)), support_b(away_W)
    return subtract(on_a, on_b), on_a, on_b


def _inside(corners: list[_Corner], shares: Sequence[float]) -> tuple[Sequence[float], list[_Corner]]:
    """The shares of those of some corners between which the shortest vector to all lies, and these corners."""
    while True:
        wanted = _affine_shares([corner[0] for corner in corners])
        if min(wanted) >= 0.0:
            return wanted, corners
        # As far towards that as all shares stay; the first that is used up goes.
        changes = list(zip(shares, wanted, strict=True))
        part, drops = min((has / (has - to), i) for i, (has, to) in enumerate(changes) if to < 0.0)
        shares = [has + part * (to - has) for has, to in changes]
        shares = [max(share, 0.0) for i, share in enumerate(shares) if i != drops]
        corners = [corner for i, corner in enumerate(corners) if i != drops]


def _affine_shares(points: Sequence[Vec3]) -> Sequence[float]:
    """The shares, of a sum of one, of up to four points whose mixture is the shortest vector of all they span."""
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
            two = -dot(cross(first, v), across) / area, -dot(cross(u, first), across) / area
            return 1.0 - (two[0] + two[1]), *two
        case [u, v, w]:
            across = cross(v, w)
            volume = dot(u, across)
            three = (
                -dot(first, across) / volume,
                -dot(u, cross(first, w)) / volume,
                -dot(u, cross(v, first)) / volume,
            )
            return 1.0 - (three[0] + three[1] + three[2]), *three
        case _:
            raise ValueError("corners in space span a tetrahedron at most")


def _mixed(shares: Sequence[float], points: Sequence[Vec3]) -> Vec3:
    """The mean of points, by their shares."""
    x = y = z = 0.0
    for share, (a, b, c) in zip(shares, points, strict=True):
        x, y, z = x + share * a, y + share * b, z + share * c
    return x, y, z


# The one definition of touching, used by statics, both methods, the compiler and `explain`.
#
# Two bodies touch if they are no further apart, and no deeper in each other, than their reach, a share of the smallest
# side of the thinner one. So a scene touches where it did when all of it is made larger or smaller.
#
# A gap below a body closes as the body comes down; one beside it does not, and no force crosses it. So a gap along an
# inclined normal may be as wide as what closes when the body comes down by the reach, and beside a body hardly at all.
# This is asked of each point of a contact, not of the nearest alone, and along each direction in which two bodies are
# apart. Whoever wants fewer gaps to count says how wide they may be (`within`); how deep bodies may be in each other is
# the reach in any case.


# Share of the smallest side: what engines leave. Less than a fifth of a millimetre for a plank of 7.8 mm, below the
# 0.2 mm that walls leave between the ends of planks.
TOUCHING = 0.02
# Share of the reach that is left beside a body: a thousandth of its smallest side, for what a file is written to. What
# an engine presses against something from the side is in it by a ten-thousandth, not apart from it.
BESIDE = 0.05
LIMIT_ITSELF = 1.0 + 1e-9  # so that what is written as the limit touches, whatever rounding makes of it
# Share of the reach up to which a gap is none: a millionth of the smallest side, 8 nm of a plank of 7.8 mm. It is a
# hundred times what sums of lengths leave, and more than the nanometres by which processors differ.
NO_GAP = 5e-5


def reach_between(thickness: float, other: float = inf, share: float = TOUCHING) -> float:
    """How far apart two bodies still touch [m], by the smallest side of each [m]; a plane has none, and is the default.

    No body reaches farther than to a plane, so whatever a body may touch is that near to it.
    """
    return LIMIT_ITSELF * share * (thickness if thickness < other else other)


def gap_bridged(reach: float, upward: float, within: float = inf) -> float:
    """The widest gap [m] that counts as contact, from the reach [m] and the z of the (unit) normal across the gap.

    If `within` [m] is less than the reach, it takes the place of the reach; at 0 only what is no gap counts.
    """
    share = min(1.0, max(BESIDE, upward, -upward))
    return min(reach * share, within * share + NO_GAP * reach)
