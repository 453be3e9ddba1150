"""Contact points of moving bricks, each with its own gap, and a spatial index of the bricks around them."""

from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from stability.contact_law import Friction
from stability.contacts.bodies import BoxSolid, Solid, solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.contacts.filled_gaps import thin_bodies, without_filled
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import InPlace, apart_from_plane, bodies_apart, in_place, meeting
from stability.geometry.rows import Array, cross_rows
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import about, add_scaled, dot, multiply, norm, scale, subtract, unit
from stability.graph import reached
from stability.model import BodyId, Plane, Pose, Vec3
from stability.problem import Contact, Placed, Tolerances
from stability.statics.wrench_matrix import Cones

# Contact points of moving bricks, each with its own gap, as a brick may lift off at one corner of a face.


EDGEWISE = 1e-6  # cosine to a face normal below which a line counts as parallel to the face


@dataclass(frozen=True, slots=True)
class ContactScene:
    """Bricks at their poses, and the bodies that they may touch."""

    bricks: Mapping[BodyId, Placed]  # free to move, by name
    fixed: Mapping[BodyId, Placed]
    planes: Mapping[BodyId, Plane]
    friction: Friction
    solids: Mapping[BodyId, Solid]  # of all bricks and fixed bodies

    def after(self, duration: float, velocities: Array, movers: Collection[BodyId]) -> "ContactScene | None":
        """Return the scene after a short time [s], with velocities and spins (6 n,) of which only the movers' apply.

        None if a brick is so fast that it might pass through another.
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
        """Return the scene with more fixed bodies, without those that are its bricks."""
        fixed = {placed.brick.id: placed for placed in others if placed.brick.id not in self.bricks}
        solids = {**self.solids, **{name: solid(placed) for name, placed in fixed.items()}}
        return replace(self, fixed={**self.fixed, **fixed}, solids=solids)


@dataclass(frozen=True, slots=True)
class SceneContacts:
    """All contacts of the bricks of a scene."""

    moving: Sequence[Contact]  # of falling bricks
    resting: Sequence[Contact]  # between standing bodies, which do not change
    falling: Collection[BodyId]
    offsets: Mapping[tuple[BodyId, BodyId], float]  # initial gaps, which count as 0, by pair [m]
    before: Set[Set[BodyId]] = frozenset()  # pairs with an earlier contact, including those at rest

    def then(self, place: ContactScene) -> "SceneContacts | None":
        """Return the contacts of a later scene; None if bricks overlap in it."""
        moving = _contacts_of(self.falling, place)
        met = _pairs_of(self.moving, self.resting)
        return None if moving is None else replace(self, moving=moving, before=self.before | met)

    def touched(self, first: BodyId, second: BodyId) -> bool:
        """Check that two bodies were in contact before."""
        return frozenset((first, second)) in self.before

    def gaps(self, moving: Sequence[Contact], place: ContactScene) -> Array:
        """Return the gap at each point and normal of these contacts [m]."""
        return np.array([gap - self.offsets.get((c.lower, c.upper), 0.0) for c in moving for gap in _gaps(c, place)])

    def deepest(self, place: ContactScene) -> float:
        """Return the deepest overlap of two bodies as a negative gap [m]; 0 without overlap."""
        return float(self.gaps([alternatives(contact)[0] for contact in self.moving], place).min(initial=0.0))


def touching(place: ContactScene, falling: Collection[BodyId]) -> SceneContacts | None:
    """Find the contacts at the start of a fall; their gaps, from rounding or an engine, count as 0."""
    moving = _contacts_of(falling, place)
    if moving is None:
        return None
    standing = [name for name in place.bricks if name not in falling]
    pairs = [(name, other) for name in standing for other in (*standing, *place.fixed) if name != other]
    resting = [_between(*pair, place) for pair in pairs if pair[0] < pair[1] or pair[1] in place.fixed]
    resting += [_with_plane(name, plane, place) for name in standing for plane in place.planes.values()]
    offsets = {(contact.lower, contact.upper): min(_gaps(contact, place)) for contact in moving}
    still = _unfilled([contact for contact in resting if contact is not None], standing, place)
    return SceneContacts(moving, still, falling, offsets, _pairs_of(moving, still))


def _pairs_of(*several: Iterable[Contact]) -> frozenset[Set[BodyId]]:
    return frozenset(frozenset((contact.lower, contact.upper)) for contacts in several for contact in contacts)


def alternatives(contact: Contact) -> list[Contact]:
    """Return a contact with each normal that it may have alone.

    Parallel edges press on each other along any normal between two: first the mean one, as long as they do not slip;
    then one of them slides down the face of the other.
    """
    normals = contact.normals_W
    if len(normals) == 1:
        return [contact]
    middle = unit((sum(n[0] for n in normals), sum(n[1] for n in normals), sum(n[2] for n in normals)))
    return [replace(contact, normals_W=(normal,)) for normal in (middle, *normals)]


def cones_in(contact: Contact) -> int:
    """Return the number of pairs of a point and a normal of a contact."""
    return len(contact.points_W) * len(contact.normals_W)


def _contacts_of(falling: Collection[BodyId], place: ContactScene) -> list[Contact] | None:
    """Return all contacts of falling bricks; None if one overlaps a body by more than a contact may.

    Also None if a gap closes that a thin body filled, as for a brick that tips over a sheet and lands beside it.
    """
    candidates, names = [], sorted(falling)
    for number, name in enumerate(names):
        own = place.solids[name]
        for plane in place.planes.values():
            candidates.append(_with_plane(name, plane, place))
            placed = place.bricks[name]
            if apart_from_plane(placed.brick.shape, placed.pose, plane).gap < -reach_between(own.shortest):
                return None
        for other in (*names[number + 1 :], *(o for o in (*place.bricks, *place.fixed) if o not in falling)):
            contact = _between(name, other, place)
            if contact is None and _is_inside(own, place.solids[other], place):
                return None
            candidates.append(contact)
    near = [contact for contact in candidates if contact is not None]
    unfilled = _unfilled(near, falling, place)
    closed = len(unfilled) < len(near) and any(
        min(_gaps(contact, place)) < 0.0 for contact in near if contact not in unfilled
    )
    return None if closed else unfilled


def _unfilled(contacts: list[Contact], complete: Collection[BodyId], place: ContactScene) -> list[Contact]:
    """Remove the contacts whose gaps thin bodies fill; `complete` are the bodies whose contacts are all given."""
    thin = thin_bodies(place.solids)
    if not thin:
        return contacts
    beside = [name for name in thin if name not in complete]
    others = [_between(name, other, place) for name in beside for other in place.solids if other != name]
    others += [_with_plane(name, plane, place) for name in beside for plane in place.planes.values()]
    return without_filled(contacts, [contact for contact in others if contact is not None], place.solids)


def _between(first: BodyId, second: BodyId, place: ContactScene) -> Contact | None:
    return contact_between(place.solids[first], place.solids[second], place.friction.of(first, second), Tolerances())


def _with_plane(name: BodyId, plane: Plane, place: ContactScene) -> Contact | None:
    return contact_with_plane(place.solids[name], plane, Tolerances(), place.friction.on(name, plane))


def _is_inside(body_a: Solid, body_b: Solid, place: ContactScene) -> bool:
    if any(a > d or b < c for a, b, c, d in zip(body_a.low_W, body_a.high_W, body_b.low_W, body_b.high_W, strict=True)):
        return False
    shapes = ({**place.bricks, **place.fixed}[body.id] for body in (body_a, body_b))
    return bodies_apart(*(in_place(placed.brick.shape, placed.pose) for placed in shapes)).gap < 0.0


def _gaps(contact: Contact, place: ContactScene) -> Iterator[float]:
    """Yield the gap at each point along each normal [m]."""
    for point_W in contact.points_W:
        for normal_W in contact.normals_W:
            upper = _entry_distance(place.solids[contact.upper], point_W, normal_W)
            if contact.lower in place.planes:
                plane = place.planes[contact.lower]
                yield upper - dot(subtract(plane.point_W, point_W), plane.normal_W)
            else:
                yield upper + _entry_distance(place.solids[contact.lower], point_W, scale(-1.0, normal_W))


def _entry_distance(body: Solid, point_W: Vec3, along_W: Vec3) -> float:
    """Return the distance along a line from a point at which it enters a body [m], at the last face that it crosses."""
    first, offset = -inf, subtract(point_W, body.pose.position_W)
    if isinstance(body, BoxSolid):
        for axis, half in zip(body.axes, body.half, strict=True):
            cosine = dot(axis, along_W)
            if abs(cosine) > EDGEWISE:
                first = max(first, -half / abs(cosine) - dot(axis, offset) / cosine)
        return first
    for normal, reach in zip(body.hull.normals.tolist(), body.hull.mesh.reaches.tolist(), strict=True):
        cosine = dot(normal, along_W)
        if cosine < -EDGEWISE:
            first = max(first, (reach - dot(normal, offset)) / cosine)
    return first


def slip_matrix(cones: Cones, place: ContactScene) -> Array:
    """Return the matrix from velocities and spins of bricks (6 n,) to relative velocities of contact points.

    Each point has three rows: normal and two tangents.
    """
    count, bricks = len(cones.lower), len(place.bricks)
    centres = np.array([*(placed.pose.position_W for placed in place.bricks.values()), (0.0, 0.0, 0.0)])
    rows, points = np.zeros((count, bricks + 1, 3, 6)), np.arange(count)
    for bodies, sign in ((cones.upper, 1.0), (cones.lower, -1.0)):
        arms = cones.points_W - centres[bodies]
        rows[points, bodies, :, :3] += sign * cones.axes_W
        turning = cross_rows(np.repeat(arms, 3, axis=0), cones.axes_W.reshape(-1, 3))
        rows[points, bodies, :, 3:] += sign * turning.reshape(-1, 3, 3)
    matrix: Array = rows[:, :bricks].transpose(0, 2, 1, 3).reshape(3 * count, 6 * bricks)
    return matrix


# Spatial index of bricks, with queries for contacts and for bricks below and above.


DOWN: Vec3 = (0.0, 0.0, -1.0)
LEVEL = 1e-9  # vertical component of a unit normal below which a face is a wall, which carries no load
PASSES = 1e-6  # share of the smallest side: a smaller horizontal overlap is no collision


class BrickIndex:
    """Spatial index of bricks."""

    def __init__(self, bricks: Iterable[Placed] = ()) -> None:
        """Create an index of these bricks."""
        self.bricks: dict[BodyId, Placed] = {}
        self._blocks: dict[BodyId, InPlace] = {}
        self._in_space = Neighbours[BodyId]()
        self._in_plan = Neighbours[BodyId]()
        for placed in bricks:
            self.add(placed)

    def add(self, placed: Placed) -> None:
        """Add a brick with a new name."""
        name = placed.brick.id
        self.bricks[name] = placed
        block = self._blocks[name] = in_place(placed.brick.shape, placed.pose)
        self._in_space.add(name, block.low_W, block.high_W)
        self._in_plan.add(name, *_in_plan(block))

    def around(self, placed: Placed) -> list[BodyId]:
        """Return the bricks that may touch a brick, sorted by name."""
        block = in_place(placed.brick.shape, placed.pose)
        return self._in_space.around(block.low_W, block.high_W, reach_between(block.thickness))

    def connected(self, bricks: Iterable[Placed]) -> list[Placed]:
        """Return the bricks that may touch one of these bricks, directly or through others, sorted by name."""
        first = {name for placed in bricks for name in self.around(placed)}
        return [self.bricks[name] for name in sorted(reached(first, lambda name: self.around(self.bricks[name])))]

    def below(self, placed: Placed) -> Iterator[tuple[BodyId, float]]:
        """Yield the bricks that a brick hits when it moves straight down, with the distances [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if (depth := _drop(own, self._blocks[name])) is not None:
                yield name, depth

    def above(self, placed: Placed, of: Container[BodyId]) -> Iterator[tuple[BodyId, float]]:
        """Yield the bricks in `of` that hit a brick when they move straight down, with the distances [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if name in of and (depth := _drop(self._blocks[name], own)) is not None:
                yield name, depth


def _drop(upper: InPlace, lower: InPlace) -> float | None:
    """Return the distance down from a body to another one [m]; None if it is not above it."""
    met = meeting(upper, lower, DOWN, PASSES * upper.thickness)
    if met is None or met[1] <= 0.0:
        return None
    if met[0] <= 0.0 and abs(bodies_apart(upper, lower).normal_BA_W[2]) < LEVEL:
        return None  # a wall beside it, which it may overlap within the tolerance of contacts
    return max(0.0, met[0])


def _in_plan(block: InPlace) -> tuple[Vec3, Vec3]:
    """Return the bounding box of a block in plan, with a common height."""
    (ax, ay, _), (bx, by, _) = block.low_W, block.high_W
    return (ax, ay, 0.0), (bx, by, 1.0)
