"""Rows of the arrays of bodies and solids, made from bricks and welded groups."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stability.contact_law import Friction, Surface
from stability.dynamics.rigid_group import RigidGroup, member_state
from stability.engines.protocol import Guided
from stability.engines.rigid.arrays import Array, Bodies, Solids
from stability.engines.rigid.solving import place_axes
from stability.geometry.placed_shape import principal_turn
from stability.geometry.rows import Array as Rows
from stability.geometry.vectors import body_axes, dot, inverse, multiply
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, Brick, Plane, Pose, Vec3

FIRST_ROOM = 16
MOST_ROUNDED = 0.02  # largest edge radius, as a share of a brick's least thickness


def single(brick: Brick, pose: Pose) -> RigidGroup:
    """Return a brick as a group, whose axes are the principal axes of inertia of the brick."""
    frame = Pose(pose.position_W, principal_turn(brick.shape, pose.orientation))
    place = Pose(AT_REST, inverse(brick.shape.principal_axes))
    return RigidGroup({brick.id: brick}, {brick.id: place}, frame, brick.mass, brick.shape.moments(brick.mass))


@dataclass
class BodyRows:
    """The bodies of a world, a row each, with the brick or the bricks of each."""

    groups: list[RigidGroup] = field(default_factory=list, init=False)
    row: dict[BodyId, int] = field(default_factory=dict, init=False)  # of the body of each brick
    arrays: Bodies = field(init=False)  # of all bodies, and of the world in the last row
    _all: Bodies = field(init=False)  # with room for more

    def __post_init__(self) -> None:
        self._all = _room(FIRST_ROOM)
        self.arrays = _first(self._all, 1)

    def add(self, group: RigidGroup, state: BodyState) -> None:
        """Add a body; `state` is that of its only brick, or of frame G of a group."""
        row = len(self.groups)
        if row + 2 > len(self._all.reach):
            longer = _room(2 * row)
            for old, new in zip(self._all, longer, strict=True):
                new[:row] = old[:row]
            self._all = longer
        self.groups.append(group)
        self.row |= dict.fromkeys(group.bricks, row)
        self.arrays = _first(self._all, row + 2)
        corners = [_corners(group, name) for name in group.bricks]
        self.arrays.reach[row] = max(float(np.linalg.norm(each, axis=1).max()) for each in corners)
        self.arrays.inverse_moments[row] = 1.0 / np.array(group.moments)
        self.release(row)
        self.put(row, state.pose)
        self.arrays.motion[row] = *state.velocity_W, *state.angular_velocity_W

    def drop(self, row: int) -> None:
        """Remove a body."""
        last = len(self.groups) - 1
        for column in self._all:
            column[row:last] = column[row + 1 : last + 1]
            column[last] = 0.0
        del self.groups[row]
        self.row = {name: number for number, group in enumerate(self.groups) for name in group.bricks}
        self.arrays = _first(self._all, last + 1)

    def put(self, row: int, pose: Pose) -> None:
        """Move a body to a pose of its only brick, or of frame G of a group."""
        group, turn = self.groups[row], pose.orientation
        if len(group.bricks) == 1:
            (place,) = group.places_G.values()
            turn = multiply(turn, inverse(place.orientation))
        self.arrays.position[row], self.arrays.turn[row] = pose.position_W, turn
        place_axes(self.arrays, row)

    def hold(self, row: int) -> None:
        """Freeze a body at rest."""
        self.arrays.inverse_mass[row] = self.arrays.motion[row] = 0.0

    def release(self, row: int) -> None:
        """Let a body move freely."""
        self.arrays.inverse_mass[row] = 1.0 / self.groups[row].mass
        self.arrays.guide[row] = 0.0

    def guide(self, row: int, motion: Guided, state: BodyState) -> None:
        """Prescribe the motion of a body in the next step: nothing deflects a carried one, and a slid one tilts."""
        velocity_W, spin_W = motion.motion(state)
        self.arrays.motion[row] = *velocity_W, *spin_W
        if motion.free_W is None:
            self.arrays.inverse_mass[row] = 0.0
        else:
            self.arrays.guide[row] = 1.0, *motion.velocity_W, *motion.free_W

    def state(self, brick: BodyId) -> BodyState:
        """Return pose and motion of a brick."""
        row = self.row[brick]
        group, bodies = self.groups[row], self.arrays
        (x, y, z), (a, b, c, d) = bodies.position[row].tolist(), bodies.turn[row].tolist()
        u, v, w, p, q, r = bodies.motion[row].tolist()
        body, place = BodyState(Pose((x, y, z), (a, b, c, d)), (u, v, w), (p, q, r)), group.places_G[brick]
        return body if place.orientation == IDENTITY and len(group.bricks) == 1 else member_state(body, place)


def _room(most: int) -> Bodies:
    widths = (3, 4, 6, 9, None, 3, 6, 3, 3, None, 7)
    return Bodies(*(np.zeros(most if width is None else (most, width)) for width in widths))


def _first(rows: Bodies, count: int) -> Bodies:
    return Bodies(*(column[:count] for column in rows))


def _corners(group: RigidGroup, name: BodyId) -> Array:
    """Return the corners of a brick (n, 3), in axes of its body [m]."""
    place = group.places_G[name]
    turned = np.array(group.bricks[name].shape.corners) @ np.array(body_axes(place.orientation))
    corners: Array = turned + np.array(place.position_W)
    return corners


# Solids: the shapes of the bricks, in axes of their bodies.


@dataclass(frozen=True, slots=True, eq=False)
class _Solid:
    """Shape of a brick, in axes of its body."""

    radius: float  # of its edges [m]
    corners: Rows  # (n, 3) [m]
    normals: Rows  # (f, 3)
    loops: Sequence[Sequence[int]]
    edges: Sequence[tuple[int, int]]

    @property
    def heights(self) -> Rows:
        """Heights of the faces over the centre of mass of the body (f,) [m]."""
        heights: Rows = np.sum(self.normals * self.corners[[loop[0] for loop in self.loops]], axis=1)
        return heights

    @property
    def cores(self) -> Rows:
        """Corners if all faces are moved inwards by the edge radius (n, 3) [m]."""
        inwards = np.zeros_like(self.corners)
        for corner in range(len(self.corners)):
            faces = self.normals[[face for face, loop in enumerate(self.loops) if corner in loop]]
            inwards[corner] = np.linalg.lstsq(faces, np.full(len(faces), self.radius), rcond=None)[0]
        cores: Rows = self.corners - inwards
        return cores


def _solid(group: RigidGroup, name: BodyId, radius: float) -> _Solid:
    shape, place = group.bricks[name].shape, group.places_G[name]
    normals = np.array([face.normal for face in shape.faces]) @ np.array(body_axes(place.orientation))
    loops = [face.corners for face in shape.faces]
    return _Solid(min(radius, MOST_ROUNDED * shape.least_thickness), _corners(group, name), normals, loops, shape.edges)


def solids_of(bodies: BodyRows, planes: Collection[Plane], friction: Friction, radius: float) -> Solids:
    """Return the solids of all bricks, in the order of the bodies, with edges of a radius [m], and the half-spaces."""
    names, kinds = list(bodies.row), _kinds(bodies.row, friction)
    solids = [_solid(bodies.groups[bodies.row[name]], name, radius) for name in names]
    kind = {name: number for number, members in enumerate(kinds) for name in members}
    rubbing = [[friction.of(one[0], other[-1]) for other in kinds] for one in kinds]
    on_planes = [[friction.on(one[0], plane) for plane in planes] for one in kinds]
    return Solids(
        np.array([bodies.row[name] for name in names], np.int64),
        np.array([kind[name] for name in names], np.int64),
        np.array([solid.radius for solid in solids], np.float64),
        _starts([len(solid.corners) for solid in solids]),
        _joined([solid.corners for solid in solids]),
        _joined([solid.cores for solid in solids]),
        _starts([len(solid.normals) for solid in solids]),
        _joined([solid.normals for solid in solids]),
        np.concatenate([np.zeros(0), *(solid.heights for solid in solids)]),
        _starts([len(loop) for solid in solids for loop in solid.loops]),
        np.array([corner for solid in solids for loop in solid.loops for corner in loop], np.int64),
        _starts([len(solid.edges) for solid in solids]),
        np.array([edge for solid in solids for edge in solid.edges], np.int64).reshape(-1, 2),
        np.array(rubbing, np.float64).reshape(len(kinds), len(kinds)),
        np.array([[*p.normal_W, dot(p.normal_W, p.point_W)] for p in planes], np.float64).reshape(-1, 4),
        np.array(on_planes, np.float64).reshape(len(kinds), len(planes)),
    )


def _kinds(names: Collection[BodyId], friction: Friction) -> list[list[BodyId]]:
    """Return the bricks with equal friction on all others together."""
    kinds: Mapping[Surface, list[BodyId]] = defaultdict(list)
    for name in names:
        kinds[friction.surface_of(name)].append(name)
    return list(kinds.values())


def _starts(lengths: Sequence[int]) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    return np.concatenate(([0], np.cumsum(lengths, dtype=np.int64)))


def _joined(rows: Sequence[Rows]) -> Rows:
    return np.concatenate([np.zeros((0, 3)), *rows])


def extent(group: RigidGroup, name: BodyId) -> tuple[Vec3, Vec3]:
    """Return the middle and half the sides of the box around a brick along its body axes [m]."""
    corners = group.bricks[name].shape.corners
    (a, b, c), (x, y, z) = np.min(corners, axis=0).tolist(), np.max(corners, axis=0).tolist()
    return (0.5 * (a + x), 0.5 * (b + y), 0.5 * (c + z)), (0.5 * (x - a), 0.5 * (y - b), 0.5 * (z - c))
