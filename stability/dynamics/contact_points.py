"""Contact points of moving bricks, each with its own gap, and the neighbours that a dropped brick may meet."""

from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from stability.contact_law import Friction
from stability.contacts.bodies import HullSolid, Solid, solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.contacts.filled_gaps import thin_ones, without_filled
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import InPlace, apart_from_plane, bodies_apart, in_place, meeting
from stability.geometry.rows import Array, cross_rows
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import about, add_scaled, dot, multiply, norm, scale, subtract, unit
from stability.graph import reached
from stability.model import BodyId, Plane, Pose, Vec3
from stability.problem import Contact, Placed, Tolerances
from stability.statics.wrench_matrix import Cones

# The points at which bricks in motion touch, each with its own gap: what lies on a face may lift off at one corner.


EDGEWISE = 1e-6  # cosine: a line along a face does not enter there


@dataclass(frozen=True, slots=True)
class ContactScene:
    """Where bricks are, and what they may touch."""

    bricks: Mapping[BodyId, Placed]  # free to move, by name
    fixed: Mapping[BodyId, Placed]
    planes: Mapping[BodyId, Plane]
    friction: Friction
    solids: Mapping[BodyId, Solid]  # all of them

    def after(self, duration: float, velocities: Array, movers: Collection[BodyId]) -> "ContactScene | None":
        """The same a short time [s] later, with (6 n,) velocities and spins, of which those of the movers count.

        None if one is so fast that it might pass through another.
        """
        moved = {}
        for (name, placed), (a, b, c, d, e, f) in zip(
            self.bricks.items(), velocities.reshape(-1, 6).tolist(), strict=True
        ):
            if name not in movers:
                continue
            speed, shape = norm((d, e, f)), placed.brick.shape
            if duration * (norm((a, b, c)) + speed * shape.bounding_radius) > 0.5 * shape.least_thickness:
                return None
            turn = placed.pose.orientation
            if speed > 0.0:
                turn = multiply(about(scale(1.0 / speed, (d, e, f)), speed * duration), turn)
            moved[name] = Placed(placed.brick, Pose(add_scaled(placed.pose.position_W, duration, (a, b, c)), turn))
        solids = {**self.solids, **{name: solid(placed) for name, placed in moved.items()}}
        return replace(self, bricks={**self.bricks, **moved}, solids=solids)

    def with_fixed(self, others: Iterable[Placed]) -> "ContactScene":
        """The same with what else there is, as far as it is none of the bricks."""
        fixed = {placed.brick.id: placed for placed in others if placed.brick.id not in self.bricks}
        solids = {**self.solids, **{name: solid(placed) for name, placed in fixed.items()}}
        return replace(self, fixed={**self.fixed, **fixed}, solids=solids)


@dataclass(frozen=True, slots=True)
class Touching:
    """All contacts of bricks that may move."""

    moving: Sequence[Contact]  # those of what falls
    resting: Sequence[Contact]  # those of what stands, which stay as they are
    falling: Collection[BodyId]
    offsets: Mapping[tuple[BodyId, BodyId], float]  # gaps that count as none, of those that touched at first [m]
    before: Set[Set[BodyId]] = frozenset()  # those that have touched before, and those that rest

    def then(self, place: ContactScene) -> "Touching | None":
        """Those of later; None if one brick has come to be inside of another."""
        moving = _contacts_of(self.falling, place)
        met = _pairs_of(self.moving, self.resting)
        return None if moving is None else replace(self, moving=moving, before=self.before | met)

    def touched(self, one: BodyId, other: BodyId) -> bool:
        """Whether two bodies were in touch before."""
        return frozenset((one, other)) in self.before

    def gaps(self, moving: Sequence[Contact], place: ContactScene) -> Array:
        """How far the bodies are from each other at each point and normal of these contacts [m]."""
        return np.array([gap - self.offsets.get((c.lower, c.upper), 0.0) for c in moving for gap in _gaps(c, place)])

    def deepest(self, place: ContactScene) -> float:
        """How far one body is in another, as a gap [m]; 0 if none is."""
        return float(self.gaps([alternatives(contact)[0] for contact in self.moving], place).min(initial=0.0))


def touching(place: ContactScene, falling: Collection[BodyId]) -> Touching | None:
    """What touches as things begin to fall; that is taken to touch, whatever rounding or an engine has left between."""
    moving = _contacts_of(falling, place)
    if moving is None:
        return None
    standing = [name for name in place.bricks if name not in falling]
    pairs = [(name, other) for name in standing for other in (*standing, *place.fixed) if name != other]
    resting = [_between(*pair, place) for pair in pairs if pair[0] < pair[1] or pair[1] in place.fixed]
    resting += [_with_plane(name, plane, place) for name in standing for plane in place.planes.values()]
    offsets = {(contact.lower, contact.upper): min(_gaps(contact, place)) for contact in moving}
    still = _unfilled([contact for contact in resting if contact is not None], standing, place)
    return Touching(moving, still, falling, offsets, _pairs_of(moving, still))


def _pairs_of(*several: Iterable[Contact]) -> frozenset[Set[BodyId]]:
    return frozenset(frozenset((contact.lower, contact.upper)) for contacts in several for contact in contacts)


def alternatives(contact: Contact) -> list[Contact]:
    """A contact with each normal that it may have by itself.

    Edges that lie along each other press along any normal between two: first along the middle one, for as long as they
    do not slip on each other; then one of them slides down the face of the other.
    """
    normals = contact.normals_W
    if len(normals) == 1:
        return [contact]
    middle = unit((sum(n[0] for n in normals), sum(n[1] for n in normals), sum(n[2] for n in normals)))
    return [replace(contact, normals_W=(normal,)) for normal in (middle, *normals)]


def cones_in(contact: Contact) -> int:
    """How many points and normals a contact has."""
    return len(contact.points_W) * len(contact.normals_W)


def _contacts_of(falling: Collection[BodyId], place: ContactScene) -> list[Contact] | None:
    """All contacts of what falls; None if some of it is deeper in something than what touches may be.

    Nor is anything known once a gap closes that a thin body filled: what tips over a sheet comes down beside it.
    """
    found, names = [], sorted(falling)
    for number, name in enumerate(names):
        own = place.solids[name]
        for plane in place.planes.values():
            found.append(_with_plane(name, plane, place))
            placed = place.bricks[name]
            if apart_from_plane(placed.brick.shape, placed.pose, plane).gap < -reach_between(own.shortest):
                return None
        for other in (*names[number + 1 :], *(o for o in (*place.bricks, *place.fixed) if o not in falling)):
            contact = _between(name, other, place)
            if contact is None and _is_inside(own, place.solids[other], place):
                return None
            found.append(contact)
    near = [contact for contact in found if contact is not None]
    left = _unfilled(near, falling, place)
    closed = len(left) < len(near) and any(min(_gaps(each, place)) < 0.0 for each in near if each not in left)
    return None if closed else left


def _unfilled(contacts: list[Contact], known: Collection[BodyId], place: ContactScene) -> list[Contact]:
    """Those whose gaps nothing fills; `known` are the bodies that they are all contacts of."""
    thin = thin_ones(place.solids)
    if not thin:
        return contacts
    beside = [name for name in thin if name not in known]
    others = [_between(name, other, place) for name in beside for other in place.solids if other != name]
    others += [_with_plane(name, plane, place) for name in beside for plane in place.planes.values()]
    return without_filled(contacts, [contact for contact in others if contact is not None], place.solids)


def _between(one: BodyId, other: BodyId, place: ContactScene) -> Contact | None:
    return contact_between(place.solids[one], place.solids[other], place.friction.of(one, other), Tolerances())


def _with_plane(name: BodyId, plane: Plane, place: ContactScene) -> Contact | None:
    return contact_with_plane(place.solids[name], plane, Tolerances(), place.friction.on(name, plane))


def _is_inside(one: Solid, other: Solid, place: ContactScene) -> bool:
    if any(a > d or b < c for a, b, c, d in zip(one.low_W, one.high_W, other.low_W, other.high_W, strict=True)):
        return False
    shapes = ({**place.bricks, **place.fixed}[body.id] for body in (one, other))
    return bodies_apart(*(in_place(placed.brick.shape, placed.pose) for placed in shapes)).gap < 0.0


def _gaps(contact: Contact, place: ContactScene) -> Iterator[float]:
    """How far apart the bodies are at each point along each normal [m]."""
    for point_W in contact.points_W:
        for normal_W in contact.normals_W:
            upper = _begins(place.solids[contact.upper], point_W, normal_W)
            if contact.lower in place.planes:
                plane = place.planes[contact.lower]
                yield upper - dot(subtract(plane.point_W, point_W), plane.normal_W)
            else:
                yield upper + _begins(place.solids[contact.lower], point_W, scale(-1.0, normal_W))


def _begins(body: Solid, point_W: Vec3, along_W: Vec3) -> float:
    """How far along a line from a point a body begins [m]: at the last of the faces that look against the line."""
    first, away = -inf, subtract(point_W, body.pose.position_W)
    if isinstance(body, HullSolid):
        for normal, reach in zip(body.hull.normals.tolist(), body.hull.mesh.reaches.tolist(), strict=True):
            cosine = dot(normal, along_W)
            if cosine < -EDGEWISE:
                first = max(first, (reach - dot(normal, away)) / cosine)
        return first
    for axis, half in zip(body.axes, body.half, strict=True):
        cosine = dot(axis, along_W)
        if abs(cosine) > EDGEWISE:
            first = max(first, -half / abs(cosine) - dot(axis, away) / cosine)
    return first


def slip_matrix(cones: Cones, place: ContactScene) -> Array:
    """From velocities of bricks, (6 n,) with spins, to relative ones of points: normal and two tangents each."""
    count, bricks = len(cones.lower), len(place.bricks)
    centres = np.array([*(placed.pose.position_W for placed in place.bricks.values()), (0.0, 0.0, 0.0)])
    rows, each = np.zeros((count, bricks + 1, 3, 6)), np.arange(count)
    for bodies, sign in ((cones.upper, 1.0), (cones.lower, -1.0)):
        arms = cones.points_W - centres[bodies]
        rows[each, bodies, :, :3] += sign * cones.axes_W
        turning = cross_rows(np.repeat(arms, 3, axis=0), cones.axes_W.reshape(-1, 3))
        rows[each, bodies, :, 3:] += sign * turning.reshape(-1, 3, 3)
    matrix: Array = rows[:, :bricks].transpose(0, 2, 1, 3).reshape(3 * count, 6 * bricks)
    return matrix


# Bricks that stand about: which of them may touch a brick, and which of them it meets on its way straight down.


DOWN: Vec3 = (0.0, 0.0, -1.0)
LEVEL = 1e-9  # height of a unit normal: a face that leans by less is a wall, which bears nothing
PASSES = 1e-6  # share of the smallest side: what would touch by less sideways slides past


class Crowd:
    """Bricks, found by where they are."""

    def __init__(self, bricks: Iterable[Placed] = ()) -> None:
        """Nobody is there but these."""
        self.bricks: dict[BodyId, Placed] = {}
        self._blocks: dict[BodyId, InPlace] = {}
        self._in_space = Neighbours[BodyId]()
        self._in_plan = Neighbours[BodyId]()
        for placed in bricks:
            self.add(placed)

    def add(self, placed: Placed) -> None:
        """Take in a brick; its name must be new."""
        name = placed.brick.id
        self.bricks[name] = placed
        block = self._blocks[name] = in_place(placed.brick.shape, placed.pose)
        self._in_space.add(name, block.low_W, block.high_W)
        self._in_plan.add(name, *_in_plan(block))

    def around(self, placed: Placed) -> list[BodyId]:
        """Those that may touch a brick, by name."""
        block = in_place(placed.brick.shape, placed.pose)
        return self._in_space.around(block.low_W, block.high_W, reach_between(block.thickness))

    def connected(self, bricks: Iterable[Placed]) -> list[Placed]:
        """Those that may touch one of these bricks, directly or through each other, by name."""
        first = {name for placed in bricks for name in self.around(placed)}
        return [self.bricks[name] for name in sorted(reached(first, lambda name: self.around(self.bricks[name])))]

    def below(self, placed: Placed) -> Iterator[tuple[BodyId, float]]:
        """Those that a brick meets on its way straight down, and how far down that is [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if (depth := _drop(own, self._blocks[name])) is not None:
                yield name, depth

    def above(self, placed: Placed, of: Container[BodyId]) -> Iterator[tuple[BodyId, float]]:
        """Those of some that meet a brick on their way straight down, and how far down that is [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if name in of and (depth := _drop(self._blocks[name], own)) is not None:
                yield name, depth


def _drop(upper: InPlace, lower: InPlace) -> float | None:
    """How far a body is above another one, straight down [m]; None if it is not, or has passed it."""
    met = meeting(upper, lower, DOWN, PASSES * upper.thickness)
    if met is None or met[1] <= 0.0:
        return None
    if met[0] <= 0.0 and abs(bodies_apart(upper, lower).normal_BA_W[2]) < LEVEL:
        return None  # a wall beside it, into which it may be written by as much as counts as contact
    return max(0.0, met[0])


def _in_plan(block: InPlace) -> tuple[Vec3, Vec3]:
    """What a block covers, seen from above, as an upright box of one height for all."""
    (ax, ay, _), (bx, by, _) = block.low_W, block.high_W
    return (ax, ay, 0.0), (bx, by, 1.0)
