"""The planes of a PyBullet world, and what its bodies have in common.

PyBullet's own half-spaces give a box one contact point a step, and a large box gives it all four at once, but contacts
of hulls with it lose their precision. So a plane may be two bodies, told apart by collision groups.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import dist, sqrt

from stability.engines.pybullet.client import PyBulletBodies
from stability.engines.pybullet.parameters import body_parameters
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.pybullet.shapes import Solids
from stability.engines.settings import EngineSettings
from stability.geometry.rotations import body_axes
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import BodyId, Brick, Plane, Pose, Quaternion, Vec3

# Combined friction is the product of two bodies' own; this stands for "none" where a partner must still reach its own.
FRICTIONLESS = 1e-6
# Half the side of the box that stands for a half-space [m]. A box, because PyBullet gives a box on a plane one contact
# point a step, and a box on a box all four at once.
HALF_SPACE = 1e5
# [engine m] The same beside bricks with rounded edges, about the place of the first: contacts with a larger box lose
# their precision. At twenty times as much a V stands with 10 % too little friction.
LEAST_REACH = 500.0
# How many times further than any brick is such a box must reach, or it is made anew, twice as large as that.
ROOM = 2.0
# Collision groups, and the mask of what meets all: PyBullet's own of what is made with mass, and two more.
SHARP, ROUNDED, HALF_SPACES, ALL = 1, 64, 128, -1
# A brick lies square if the cosine of an axis of it to the vertical, or to the normal of a slope, is more than this: by
# 0.1 deg.
SQUARE = 1.0 - 1.5e-6
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass
class PlanesWorld(PyBulletBodies):
    """A world with ground and walls, and no bricks yet."""

    settings: EngineSettings = field(kw_only=True)
    friction: float = field(kw_only=True)  # Coulomb coefficient of brick on brick
    _solids: Solids = field(init=False)
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _half_spaces: list[int] = field(default_factory=list, init=False)  # the bodies that stand for planes beside hulls
    _reach: float = field(default=HALF_SPACE, init=False)  # half the side of the boxes that stand for planes [m]
    _middle_W: Vec3 = field(default=(0.0, 0.0, 0.0), init=False)  # their middles are right below it, or beside it [m]
    _lively: bool = field(default=False, init=False)  # whether something is fast

    def __post_init__(self) -> None:
        self._solids = Solids(self.client)
        if self.settings.edge_rounding:
            self._reach = LEAST_REACH / self.settings.scale

    def add_plane(self, plane: Plane) -> None:
        """Put up the ground or a wall."""
        self._planes[plane.id] = plane
        self._fixed |= {plane.id}
        if self.settings.half_spaces:
            self._put_up_half_space(plane)
        self._put_up(plane)
        self._choose_planes(self._lively)

    def _around(self, low: Sequence[float], high: Sequence[float]) -> set[BodyId]:
        # The bounds of a half-space meet everything; the box that also stands for it tells whether it is near.
        around = pybullet.getOverlappingObjects(low, high, physicsClientId=self.client)
        return {self.names[body] for body, _ in around or () if body not in self._half_spaces}

    def _begin_about(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes lie about the first brick of all, if that is far from their middles."""
        if self._needed(brick, position_W) > self._reach:
            self._middle_W = position_W
            self._renew_boxes()

    def _reach_beyond(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes reach farther if a brick comes near their ends."""
        needed = self._needed(brick, position_W)
        if needed > self._reach:
            self._reach = 2.0 * needed
            self._renew_boxes()

    def _needed(self, brick: Brick, position_W: Vec3) -> float:
        """How far the boxes that stand for planes must reach for a brick to be well within [m]."""
        return ROOM * (dist(self._middle_W, position_W) + brick.shape.length)

    def _renew_boxes(self) -> None:
        """PyBullet cannot change the size of a box: put up others."""
        for plane in self._planes.values():
            body = self._bodies.pop(plane.id)
            pybullet.removeBody(body, self.client)
            del self.names[body]
            self._put_up(plane)
        self._choose_planes(self._lively)

    def _put_up(self, plane: Plane) -> None:
        """Put up the box that stands for a plane."""
        depth = self._reach * self.scale
        above = dot(subtract(self._middle_W, plane.point_W), plane.normal_W)
        nearest = add_scaled(self._middle_W, -above, plane.normal_W)  # of the plane
        centre = add_scaled(scale(self.scale, nearest), -depth, plane.normal_W)
        body = self._body(0.0, self._solids.box((depth, depth, depth)), centre, _turning_z_to(plane.normal_W))
        self._name(body, plane.id, plane.friction / self._own_friction())

    def _put_up_half_space(self, plane: Plane) -> None:
        """Put up what stands for a plane beside bricks with rounded edges."""
        position = scale(self.scale, plane.point_W)
        body = self._body(0.0, self._solids.half_space(), position, _turning_z_to(plane.normal_W))
        self._name(body, plane.id, plane.friction / self._own_friction())
        self._half_spaces.append(body)

    def _choose_planes(self, lively: bool) -> None:
        """Let rounded bricks meet half-spaces while all is slow, and boxes while something is fast.

        A half-space takes a brick that lands on an edge at one end of it, and throws it round; a box does not.
        """
        self._lively = lively
        if not self._half_spaces:
            return
        for plane in self._planes:
            self._meets(self._bodies[plane], SHARP, SHARP | ROUNDED if lively else SHARP)
        for body in self._half_spaces:
            self._meets(body, HALF_SPACES, 0 if lively else ROUNDED)

    def _meets(self, body: int, group: int, mask: int) -> None:
        """Put a body into a collision group, and say which groups it meets."""
        pybullet.setCollisionFilterGroupMask(body, -1, group, mask, self.client)

    def _square(self, pose: Pose) -> bool:
        """Whether a brick lies square to the vertical or to a slope."""
        slopes = (plane.normal_W for plane in self._planes.values() if plane.normal_W[2] > 0.0)
        return lies_square(pose, (UP, *slopes))

    def _body(self, mass: float, shape: int, position: Vec3, orientation: Quaternion) -> int:
        """The number of a new body of a mass [kg], at a place in engine metres."""
        return int(
            pybullet.createMultiBody(
                baseMass=mass * self._mass_unit,
                baseCollisionShapeIndex=shape,
                basePosition=position,
                baseOrientation=orientation,
                useMaximalCoordinates=int(self.settings.maximal_coordinates),
                physicsClientId=self.client,
            )
        )

    def _own_friction(self) -> float:
        return max(sqrt(self.friction), FRICTIONLESS)

    def _name(self, body: int, name: BodyId, own_friction: float) -> None:
        parameters = body_parameters(self.settings, own_friction)
        pybullet.changeDynamics(body, -1, **parameters, physicsClientId=self.client)
        self.names[body] = name
        self._bodies[name] = body


def _turning_z_to(normal_W: Vec3) -> Quaternion:
    """The shortest turn that takes the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)


def lies_square(pose: Pose, ups_W: Iterable[Vec3] = (UP,)) -> bool:
    """Whether an axis of a brick is vertical, or square to a slope: it may touch others with its faces, not lean."""
    axes_W = body_axes(pose.orientation)
    return any(abs(dot(axis_W, up_W)) > SQUARE for axis_W in axes_W for up_W in ups_W)
