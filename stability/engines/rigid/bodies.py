"""Rows of the arrays of bodies and solids, made from bricks and welded groups."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate, chain, product

import numpy as np

from stability.contact_law import Friction, Surface
from stability.dynamics.rigid_group import RigidGroup, member_state
from stability.engines.protocol import FIRM, Guided
from stability.engines.rigid.mechanics import (
    ALIKE_FAR,
    AXES,
    BODY_WIDTH,
    CARRIED,
    GUIDE,
    INVERSE_MASS,
    MOTION,
    POSITION,
    REACH,
    RESPONSE,
    ROUND_WIDTH,
    SLID,
    SPIN,
    TURN,
    Array,
    Ints,
    Solids,
    place_axes,
)
from stability.geometry.compound import parts_of
from stability.geometry.placed_shape import part_pose, principal_turn
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import body_axes, dot, inverse, multiply
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, Brick, ConvexShape, Plane, Pose

FIRST_ROOM = 16
MOST_SHAPES = 256  # different ones that are kept
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
    arrays: Array = field(init=False)  # (n, BODY_WIDTH) of all bodies, and of the world in the last row
    _all: Array = field(init=False)  # with room for more

    def __post_init__(self) -> None:
        self._all = np.zeros((FIRST_ROOM, BODY_WIDTH))
        self.arrays = self._all[:1]

    def add(self, group: RigidGroup, state: BodyState) -> None:
        """Add a body; `state` is that of its only brick, or of frame G of a group."""
        row = len(self.groups)
        if row + 2 > len(self._all):
            self._all = np.concatenate((self._all[:row], np.zeros((row + 2, BODY_WIDTH))))
        self.groups.append(group)
        self.row |= dict.fromkeys(group.bricks, row)
        self.arrays = self._all[: row + 2]
        corners = [_corners(group.bricks[name].shape, place) for name, place in group.places_G.items()]
        self.arrays[row, REACH] = max(float(np.linalg.norm(each, axis=1).max()) for each in corners)
        self.put(row, state.pose)
        self.release(row)
        self.move(row, state)

    def drop(self, row: int) -> None:
        """Remove a body."""
        last = len(self.groups) - 1
        self._all[row:last] = self._all[row + 1 : last + 1]
        self._all[last] = 0.0
        del self.groups[row]
        self.row = {name: number for number, group in enumerate(self.groups) for name in group.bricks}
        self.arrays = self._all[: last + 1]

    def put(self, row: int, pose: Pose) -> None:
        """Move a body to a pose of its only brick, or of frame G of a group."""
        group, turn = self.groups[row], pose.orientation
        if len(group.bricks) == 1:
            (place,) = group.places_G.values()
            turn = multiply(turn, inverse(place.orientation))
        self.arrays[row, POSITION:MOTION] = *pose.position_W, *turn
        place_axes(self.arrays, row)

    def move(self, row: int, state: BodyState) -> None:
        """Give a body the motion of a state."""
        self.arrays[row, MOTION:AXES] = *state.velocity_W, *state.angular_velocity_W

    def hold(self, row: int) -> None:
        """Freeze a body at rest."""
        self.arrays[row, MOTION:AXES] = self.arrays[row, INVERSE_MASS] = 0.0

    def release(self, row: int) -> None:
        """Let a body move freely."""
        self._weigh(row, 1.0)
        self.arrays[row, GUIDE:] = 0.0

    def _weigh(self, row: int, factor: float) -> None:
        """Set the inertia of a body, multiplied by a factor."""
        group = self.groups[row]
        self.arrays[row, INVERSE_MASS:RESPONSE] = 1.0 / (factor * np.array((group.mass, *group.moments)))
        place_axes(self.arrays, row)

    def guide(self, row: int, motion: Guided, state: BodyState) -> None:
        """Prescribe the motion of a body in the next step: only what does not move deflects a carried one."""
        velocity_W, spin_W = motion.motion(state)
        self.arrays[row, MOTION:AXES] = *velocity_W, *spin_W
        self.arrays[row, GUIDE:] = (
            (CARRIED, *velocity_W, *AT_REST) if motion.free_W is None else (SLID, *motion.velocity_W, *motion.free_W)
        )
        self._weigh(row, FIRM if motion.carried else 1.0)

    def state(self, brick: BodyId) -> BodyState:
        """Return pose and motion of a brick."""
        row = self.row[brick]
        group = self.groups[row]
        x, y, z, a, b, c, d, u, v, w, p, q, r = self.arrays[row, POSITION:AXES].tolist()
        body, place = BodyState(Pose((x, y, z), (a, b, c, d)), (u, v, w), (p, q, r)), group.places_G[brick]
        return body if place.orientation == IDENTITY and len(group.bricks) == 1 else member_state(body, place)

    def in_order(self) -> tuple[list[BodyId], Array]:
        """Return the bricks in the order in which their contacts are solved, and what sorts the points of a contact.

        The result of a scene must not depend on the order in which its bricks were added, nor on its direction. So
        bricks are sorted by height, and those of one height by their distance from the fastest body, which disturbs
        them, then along its motion. Only if they are mirror images of each other, their addition decides.
        """
        place_W, along_W = self._disturbed()
        apart = {name: np.array(self.state(name).pose.position_W) - place_W for name in self.row}

        def rank(name: BodyId) -> tuple[int, ...]:
            far = apart[name]
            return tuple(round(float(size) / ALIKE_FAR) for size in (far[2], np.linalg.norm(far), far @ along_W))

        names = sorted(self.row, key=rank)
        # A point on no plane of symmetry tells mirror images apart.
        shares = 1.0 / np.arange(1.0, len(names) + 1.0)
        aside_W = place_W + sum(share * apart[name] for share, name in zip(shares, names, strict=True)) / shares.sum()
        return names, np.concatenate((place_W if along_W.any() else aside_W, along_W, aside_W))

    def _disturbed(self) -> tuple[Array, Array]:
        """Return the place of the fastest body [m], and a direction that follows from its motion; zeros if all rest."""
        speeds = np.linalg.norm(self.arrays[:, MOTION:SPIN], axis=1)
        body, speed = self.arrays[speeds.argmax()], speeds.max()
        if speed == 0.0:
            return np.zeros(3), np.zeros(3)
        along_W = body[MOTION:SPIN] / speed
        a, b, c, d, e, f = body[RESPONSE:REACH] / np.linalg.norm(body[RESPONSE:REACH])
        # With its spin and its inertia, so that both sides of a body that turns, or comes askew, differ.
        turned_W = body[REACH] / speed * np.cross(body[SPIN:AXES], along_W)
        return body[POSITION:TURN], along_W + turned_W + np.array([[a, b, c], [b, d, e], [c, e, f]]) @ along_W


def _corners(shape: ConvexShape, place: Pose) -> Array:
    """Return the corners of a shape at its place in a body (n, 3), in axes of the body [m]."""
    turned = np.array(shape.corners) @ np.array(body_axes(place.orientation))
    corners: Array = turned + np.array(place.position_W)
    return corners


# Solids: the shapes of the bricks, in axes of their bodies.


@dataclass(frozen=True, slots=True, eq=False)
class _Solid:
    """Shape of a brick, in axes of its body."""

    radius: float  # of its edges [m]
    corners: Array  # (n, 6) corners, and those after all faces are moved inwards by the edge radius [m]
    faces: Array  # (f, 4) normals, and heights over the centre of mass of the body [m]
    loops: Sequence[Sequence[int]]
    edges: Sequence[tuple[int, int]]
    round: Sequence[float]  # (ROUND_WIDTH,) as in `Solids.rounds`


@lru_cache(maxsize=MOST_SHAPES)
def _solid(shape: ConvexShape, place: Pose, radius: float) -> _Solid:
    """Return a shape at its place in a body, with edges of a radius [m]."""
    radius = min(radius, MOST_ROUNDED * shape.least_thickness)
    if isinstance(shape, RoundSolid):
        return _round(shape, place, radius)
    corners = _corners(shape, place)
    normals = np.array([face.normal for face in shape.faces]) @ np.array(body_axes(place.orientation))
    heights = np.sum(normals * corners[[face.corners[0] for face in shape.faces]], axis=1)
    inwards = np.zeros_like(corners)
    for corner in range(len(corners)):
        faces = normals[[number for number, face in enumerate(shape.faces) if corner in face.corners]]
        inwards[corner] = np.linalg.lstsq(faces, np.full(len(faces), radius), rcond=None)[0]
    cores, loops = corners - inwards, [face.corners for face in shape.faces]
    faces = np.column_stack((normals, heights))
    return _Solid(radius, np.hstack((corners, cores)), faces, loops, shape.edges, [0.0] * ROUND_WIDTH)


def _round(shape: RoundSolid, place: Pose, radius: float) -> _Solid:
    """Return a round solid at its place in a body, with the corners of the box around it."""
    axes, half, wide = np.array(body_axes(place.orientation)), 0.5 * shape.height, shape.widest
    middle = np.array(place.position_W) - np.array(shape.centre_of_mass) @ axes
    signs = np.array([*product((-1.0, 1.0), repeat=3)])
    corners = middle + signs * np.array((wide, wide, half + shape.rounding)) @ axes
    aside, _, axis = axes
    discs = *(middle - half * axis), *(middle + half * axis)
    row = *discs, *shape.radii, shape.rounding, *(axis if half else np.zeros(3)), *aside
    return _Solid(radius, np.hstack((corners, corners)), np.zeros((0, 4)), (), (), row)


def solids_of(
    bodies: BodyRows, planes: Collection[Plane], friction: Friction, radius: float
) -> tuple[tuple[BodyId, ...], Solids]:
    """Return the brick of each solid in the order of contacts, the solids, and the half-spaces.

    The solids have edges of a radius [m]. A compound has several solids in a row.
    """
    bricks, origin = bodies.in_order()
    kinds = _kinds(bodies.row, friction)
    names: list[BodyId] = []
    solids: list[_Solid] = []
    for name in bricks:
        group = bodies.groups[bodies.row[name]]
        for part in parts_of(group.bricks[name].shape):
            names.append(name)
            place = part_pose(part, group.places_G[name])
            solids.append(_solid(part.shape, place, radius))  # type: ignore[arg-type]  # shapes are frozen
    kind = {name: number for number, members in enumerate(kinds) for name in members}
    rubbing = [[friction.of(one[0], other[-1]) for other in kinds] for one in kinds]
    on_planes = [[friction.on(one[0], plane) for plane in planes] for one in kinds]
    ranges = zip(
        [*(bodies.row[name] for name in names), 0],
        [*(kind[name] for name in names), 0],
        _starts(len(solid.corners) for solid in solids),
        _starts(len(solid.faces) for solid in solids),
        _starts(len(solid.edges) for solid in solids),
        strict=True,
    )
    return tuple(names), Solids(
        np.array(list(ranges), np.int64),
        np.array([solid.radius for solid in solids], np.float64),
        np.concatenate([np.zeros((0, 6)), *(solid.corners for solid in solids)]),
        np.concatenate([np.zeros((0, 4)), *(solid.faces for solid in solids)]),
        _padded([loop for solid in solids for loop in solid.loops]),
        np.array([*chain(*(solid.edges for solid in solids))], np.int64).reshape(-1, 2),
        np.array([solid.round for solid in solids], np.float64).reshape(-1, ROUND_WIDTH),
        np.array(rubbing, np.float64).reshape(len(kinds), len(kinds)),
        np.array([[*p.normal_W, dot(p.normal_W, p.point_W)] for p in planes], np.float64).reshape(-1, 4),
        np.array(on_planes, np.float64).reshape(len(kinds), len(planes)),
        origin,
    )


def _kinds(names: Collection[BodyId], friction: Friction) -> list[list[BodyId]]:
    """Return the bricks with equal friction on all others together."""
    kinds: Mapping[Surface, list[BodyId]] = defaultdict(list)
    for name in names:
        kinds[friction.surface_of(name)].append(name)
    return list(kinds.values())


def _starts(lengths: Iterable[int]) -> Iterable[int]:
    return accumulate(lengths, initial=0)


def _padded(loops: Sequence[Sequence[int]]) -> Ints:
    """Return the loops as rows that start with their lengths."""
    padded = np.zeros((len(loops), 1 + max(map(len, loops), default=0)), np.int64)
    for row, loop in enumerate(loops):
        padded[row, : 1 + len(loop)] = len(loop), *loop
    return padded
