"""Contact normals of two bricks that touch edge on edge, and a check of an engine's normals against them.

Model: every edge is slightly rounded, and the normal joins the nearest points of the two boxes without their rounding.
A face contact keeps the normal of the face; the normal of two edges lies between the normals of the adjacent faces.
Engines with sharp boxes use the normal of one of these faces where the edges are parallel (docs/design/engines.md).
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from math import acos, ceil, cos, radians
from typing import TypeAlias

from stability.engines.protocol import World
from stability.geometry.box import Box
from stability.geometry.box_distance import Block, block, blocks_apart, nearest_points
from stability.geometry.vectors import add, add_scaled, body_axes, cross, dot, norm, scale, subtract
from stability.model import BodyId, BodyState, ContactPoint, Pose, Vec3

EDGE_RADIUS = 1e-4  # [m] assumed edge radius
MOST_ROUNDED = 0.02  # upper bound of the radius, as a share of a brick's smallest side; applies below 5 mm
LEANS = cos(radians(1.0))  # a brick leans if the cosine between its most upright axis and the vertical is smaller
WRONG = cos(radians(10.0))  # a normal is wrong if the cosine of its angle to the true normal is smaller
FACE_ON = cos(radians(5.0))  # a normal belongs to a face if the cosine of its angle to the face normal is larger
LOADED = 0.01  # the least normal force of a loaded contact, as a share of the lighter brick's weight
ROUNDS = 2  # alternating projections between two boxes
TOUCHING = 1.05  # times the sum of both radii: the cores of touching boxes are no further apart
MOST_BEFORE = 64  # earlier positions in the last time step at which the engine may have found a contact
TURNS = 0.15  # allowed slip of crossing edges, as a share of the radius: normals turn by 4 deg
NEAR = 0.005  # times the sum of both radii: cores that are closer have no normal

# Edge radii of two bodies [m].
Radii: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class WrongNormal:
    """Loaded contact of two bricks whose normal from the engine contradicts the geometry."""

    upper: BodyId
    lower: BodyId
    angle: float  # from the true normal to that of the engine [rad]


def edge_radius(size: Vec3, radius: float = EDGE_RADIUS) -> float:
    """Return the assumed edge radius of a brick [m]."""
    return min(radius, MOST_ROUNDED * min(size))


def leans(pose: Pose) -> bool:
    """Check that no axis of a brick is vertical."""
    return all(abs(axis_W[2]) < LEANS for axis_W in body_axes(pose.orientation))


def true_normals(a: Block, b: Block, touching_W: Vec3, radii: Radii) -> Iterator[Vec3]:
    """Yield the unit normals from b to a that a contact of two boxes with rounded edges may have.

    First the normal between the points nearest to the contact, if the boxes touch there: slightly twisted edges touch
    along their whole length. Then the normal between the nearest points of the boxes. If the boxes overlap by more
    than their radii, also the normal for larger radii. Yields nothing if the overlap is too deep.
    """
    yield from BoxPair(a, b).true_normals(touching_W, radii)


@dataclass(slots=True)
class BoxPair:
    """Two touching boxes, with cached values that all their contact points share."""

    a: Block
    b: Block
    _cores: dict[Radii, "tuple[_Core, _Core]"] = field(default_factory=dict, init=False)
    _nearest: dict[Radii, tuple[Vec3, Vec3] | None] = field(default_factory=dict, init=False)
    _gap: float | None = field(default=None, init=False)

    def true_normals(self, touching_W: Vec3, radii: Radii) -> Iterator[Vec3]:
        """Yield the possible unit normals from b to a at a contact, as the function `true_normals` does."""
        (core_a, core_b), on_a = self._without(radii), touching_W
        for _ in range(ROUNDS):
            on_b = core_b.nearest(on_a)
            on_a = core_a.nearest(on_b)
        if norm(subtract(on_a, on_b)) < TOUCHING * sum(radii):
            yield from _normal(on_a, on_b, radii)
        # Iterating on to the nearest points of the boxes takes thousands of rounds if edges cross at a few degrees.
        yield from self._normal_of_all(radii)
        if self._gap is None:
            self._gap = blocks_apart(self.a, self.b).gap
        more = -2.0 * self._gap / sum(radii)
        if more > 1.0:
            yield from self._normal_of_all((more * radii[0], more * radii[1]))

    def _without(self, radii: Radii) -> "tuple[_Core, _Core]":
        """Return the cores of both boxes."""
        if radii not in self._cores:
            self._cores[radii] = _Core(self.a, radii[0]), _Core(self.b, radii[1])
        return self._cores[radii]

    def _normal_of_all(self, radii: Radii) -> Iterator[Vec3]:
        if radii not in self._nearest:
            a, b = self._without(radii)
            self._nearest[radii] = nearest_points(a.farthest, b.farthest, subtract(a.middle_W, b.middle_W))
        nearest = self._nearest[radii]
        if nearest is not None:
            yield from _normal(*nearest, radii)


def _normal(on_a: Vec3, on_b: Vec3, radii: Radii) -> Iterator[Vec3]:
    """Yield the unit normal between two points, unless they are too close to define one."""
    between = subtract(on_a, on_b)
    distance = norm(between)
    if distance > NEAR * sum(radii):
        yield scale(1.0 / distance, between)


def nearest_of(a: Block, b: Block, radius: float) -> tuple[Vec3, Vec3] | None:
    """Return the nearest points of the cores of two boxes [m]; None if the cores overlap."""
    core_a, core_b = _Core(a, radius), _Core(b, radius)
    return nearest_points(core_a.farthest, core_b.farthest, subtract(a.p_WC, b.p_WC))


class _Core:
    """Core of a box: the box shrunk by its edge radius, as its centre and half sizes.

    Both methods are the inner loop, so they use plain floats and no loops.
    """

    __slots__ = ("axes_W", "half", "middle_W")

    def __init__(self, box: Block, radius: float) -> None:
        """Shrink a box by a radius [m] on all sides."""
        self.middle_W, self.axes_W = box.p_WC, box.axes_W
        x, y, z = box.half
        self.half = (max(x - radius, 0.0), max(y - radius, 0.0), max(z - radius, 0.0))

    def nearest(self, point_W: Vec3) -> Vec3:
        """Return the point of the core that is nearest to a point."""
        x, y, z = self.middle_W
        (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = self.axes_W
        most_u, most_v, most_w = self.half
        from_x, from_y, from_z = point_W[0] - x, point_W[1] - y, point_W[2] - z
        u = from_x * ux + from_y * uy + from_z * uz
        u = most_u if u > most_u else -most_u if u < -most_u else u
        v = from_x * vx + from_y * vy + from_z * vz
        v = most_v if v > most_v else -most_v if v < -most_v else v
        w = from_x * wx + from_y * wy + from_z * wz
        w = most_w if w > most_w else -most_w if w < -most_w else w
        return x + u * ux + v * vx + w * wx, y + u * uy + v * vy + w * wy, z + u * uz + v * vz + w * wz

    def farthest(self, along_W: Vec3) -> Vec3:
        """Return the corner of the core that lies farthest along a direction."""
        a, b, c = along_W
        x, y, z = self.middle_W
        (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = self.axes_W
        u, v, w = self.half
        u = u if ux * a + uy * b + uz * c > 0.0 else -u
        v = v if vx * a + vy * b + vz * c > 0.0 else -v
        w = w if wx * a + wy * b + wz * c > 0.0 else -w
        return x + u * ux + v * vx + w * wx, y + u * uy + v * vy + w * wy, z + u * uz + v * vz + w * wz


def wrong_normals(engine: World, states: Mapping[BodyId, BodyState], gravity: float) -> Iterator[WrongNormal]:
    """Yield the wrong normals at loaded contacts of the leaning bricks among these, at most one per pair of bricks."""
    checked_pairs = set()
    for name, state in states.items():
        if not leans(state.pose):
            continue
        for pair, points in _by_pair(engine.contacts(name)).items():
            if pair not in checked_pairs and engine.masses().keys() >= set(pair):
                checked_pairs.add(pair)
                yield from _of_pair(engine, points, gravity)


def _by_pair(points: Collection[ContactPoint]) -> dict[tuple[BodyId, BodyId], list[ContactPoint]]:
    pairs: dict[tuple[BodyId, BodyId], list[ContactPoint]] = {}
    for point in points:
        pairs.setdefault((min(point.a, point.b), max(point.a, point.b)), []).append(point)
    return pairs


def _of_pair(engine: World, points: Collection[ContactPoint], gravity: float) -> Iterator[WrongNormal]:
    """Yield at most one wrong normal: at the contact point with the largest force."""
    point = max(points, key=lambda point: point.normal_force)
    masses = engine.masses()
    if point.normal_force < LOADED * gravity * min(masses[point.a], masses[point.b]):
        return
    a, b = engine.shape(point.a), engine.shape(point.b)
    states = engine.states([point.a, point.b])
    if not (isinstance(a, Box) and isinstance(b, Box)):
        return
    best_cosine = None
    for cosine in _agreements(point, (a, states[point.a]), (b, states[point.b]), engine.settings.time_step):
        best_cosine = cosine if best_cosine is None else max(best_cosine, cosine)
        if best_cosine >= WRONG:
            return
    if best_cosine is not None:
        a_above = states[point.a].pose.position_W[2] >= states[point.b].pose.position_W[2]
        upper, lower = (point.a, point.b) if a_above else (point.b, point.a)
        yield WrongNormal(upper, lower, acos(max(best_cosine, -1.0)))


def _agreements(
    point: ContactPoint, a: tuple[Box, BodyState], b: tuple[Box, BodyState], time_step: float
) -> Iterator[float]:
    """Yield cosines of the angle between the engine's normal and the true one, at the current and earlier positions.

    An engine detects contacts before it moves the bodies, in steps of its own.
    """
    (box_a, state_a), (box_b, state_b) = a, b
    radii = _radii(point, min(edge_radius(box_a.size), edge_radius(box_b.size)))
    middle_W = add_scaled(point.position_W, 0.5 * point.gap, point.normal_BA_W)
    slip_W = subtract(velocity_at(state_a, middle_W), velocity_at(state_b, middle_W))
    resting = block(box_b.size, state_b.pose)
    places = min(max(2, ceil(norm(slip_W) * time_step / (TURNS * 0.5 * sum(radii)))), MOST_BEFORE)
    for place in range(places + 1):
        where = add_scaled(state_a.pose.position_W, -place / places * time_step, slip_W)
        moved = block(box_a.size, Pose(where, state_a.pose.orientation))
        for normal in true_normals(moved, resting, middle_W, radii):
            yield dot(normal, point.normal_BA_W)


def _radii(point: ContactPoint, sharp: float) -> Radii:
    """Return the edge radii of both bodies of a contact [m]; `sharp` stands for sharp edges.

    A deeper overlap enlarges both, so that the cores stay apart.
    """
    a, b = point.rounded
    radii = a or sharp, b or sharp
    deeper = max(1.0, -2.0 * point.gap / sum(radii))
    return deeper * radii[0], deeper * radii[1]


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of a contact's normal with the current poses of its two boxes."""

    cosine: float  # of the angle to the true normal; 1 if the overlap is too deep to define one
    holds_for: float  # slip of the boxes within which the true normal does not change [m]


def agreement(point: ContactPoint, pair: BoxPair, rounding: float) -> Agreement:
    """Compare the normal of a contact with its two boxes; `rounding` is the assumed radius of sharp edges [m]."""
    radii = _radii(point, rounding)
    radius = 0.5 * sum(radii)
    middle_W = add_scaled(point.position_W, 0.5 * point.gap, point.normal_BA_W)
    within_a, outside_a = _on_face(point.normal_BA_W, middle_W, pair.a)
    within_b, outside_b = _on_face(point.normal_BA_W, middle_W, pair.b)
    within = max(within_a, within_b)
    if within > 2.0 * max(radii) and max(outside_a, outside_b) < radius:
        return Agreement(1.0, within)
    cosine, normal = 1.0, None
    for normal in pair.true_normals(middle_W, radii):
        cosine = dot(normal, point.normal_BA_W)
        if cosine > FACE_ON:
            break
    if normal is None:
        return Agreement(1.0, radius)
    on_face = any(abs(dot(axis, normal)) > FACE_ON for axis in (*pair.a.axes_W, *pair.b.axes_W))
    return Agreement(cosine, radius if on_face else TURNS * radius)


def _on_face(normal_W: Vec3, touching_W: Vec3, box: Block) -> tuple[float, float]:
    """Return a face contact's distance from the rim of the face, and the contact's distance outside the box [m].

    The first is negative beyond the rim and if the normal is no face normal; the second is negative inside the box.
    """
    a, b, c = normal_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = box.axes_W
    half_u, half_v, half_w = box.half
    x, y, z = subtract(touching_W, box.p_WC)
    u, v, w = abs(x * ux + y * uy + z * uz), abs(x * vx + y * vy + z * vz), abs(x * wx + y * wy + z * wz)
    outside = max(u - half_u, v - half_v, w - half_w)
    across_u, across_v = abs(ux * a + uy * b + uz * c), abs(vx * a + vy * b + vz * c)
    across_w = abs(wx * a + wy * b + wz * c)
    if max(across_u, across_v, across_w) < FACE_ON:
        return -1.0, outside
    edge_u, edge_v, edge_w = map(dot, box.half_edges_W, box.axes_W)
    if across_u >= across_v and across_u >= across_w:
        return min(edge_v - v, edge_w - w), outside
    if across_v >= across_w:
        return min(edge_u - u, edge_w - w), outside
    return min(edge_u - u, edge_v - v), outside


def velocity_at(state: BodyState, point_W: Vec3) -> Vec3:
    """Return the velocity of a point of a body [m/s]."""
    return add(state.velocity_W, cross(state.angular_velocity_W, subtract(point_W, state.pose.position_W)))
