"""The planes of a PyBullet world.

PyBullet's own half-spaces give a box one contact point a step, and a large box gives it all four at once, but contacts
of hulls with it lose their precision. So a plane may be two bodies, told apart by collision groups.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import dist, sqrt

from stability.engines.pybullet.body_making import HALF_SPACES, ROUNDED, SHARP, BodyMaker
from stability.geometry.rotations import body_axes, rotate
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import BodyId, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.shapes.box import Box

# Half the side of the box that stands for a half-space [m]. A box, because PyBullet gives a box on a plane one contact
# point a step, and a box on a box all four at once.
HALF_SPACE = 1e5
# [engine m] The same beside bricks with rounded edges, about the place of the first: contacts with a larger box lose
# their precision. At twenty times as much a V stands with 10 % too little friction.
LEAST_REACH = 500.0
# How many times further than any brick is such a box must reach, or it is made anew, twice as large as that.
ROOM = 2.0
# A brick lies square if the cosine of an axis of it to the vertical, or to the normal of a slope, is more than this: by
# 0.1 deg.
SQUARE = 1.0 - 1.5e-6
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass
class Planes:
    """Ground and walls. They are made as bodies, and made anew where bricks come near their ends."""

    maker: BodyMaker
    planes: dict[BodyId, Plane]  # by name, as the world has them
    _half_spaces: list[int] = field(default_factory=list, init=False)  # the bodies that stand for planes beside hulls
    _reach: float = field(default=HALF_SPACE, init=False)  # half the side of the boxes that stand for planes [m]
    _middle_W: Vec3 = field(default=(0.0, 0.0, 0.0), init=False)  # their middles are right below it, or beside it [m]
    _lively: bool = field(default=False, init=False)  # whether something is fast

    def __post_init__(self) -> None:
        if self.maker.settings.edge_rounding:
            self._reach = LEAST_REACH / self.maker.settings.scale

    def add(self, plane: Plane) -> None:
        """Put up a plane that the world has taken in."""
        if self.maker.settings.half_spaces:
            self._put_up_half_space(plane)
        self._put_up(plane)
        self.choose(self._lively)

    def shape(self) -> Box:
        """The shape of each."""
        side = 2.0 * self._reach
        return Box((side, side, side))

    def begin_about(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes lie about the first brick of all, if that is far from their middles."""
        if self._needed(brick, position_W) > self._reach:
            self._middle_W = position_W
            self._renew_boxes()

    def reach_beyond(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes reach farther if a brick comes near their ends."""
        needed = self._needed(brick, position_W)
        if needed > self._reach:
            self._reach = 2.0 * needed
            self._renew_boxes()

    def choose(self, lively: bool) -> None:
        """Let rounded bricks meet half-spaces while all is slow, and boxes while something is fast.

        A half-space takes a brick that lands on an edge at one end of it, and throws it round; a box does not.
        """
        self._lively = lively
        if not self._half_spaces:
            return
        boxes = [self.maker.bodies.numbers[plane] for plane in self.planes]
        self.maker.meet(boxes, SHARP, SHARP | ROUNDED if lively else SHARP)
        self.maker.meet(self._half_spaces, HALF_SPACES, 0 if lively else ROUNDED)

    def lies_square(self, pose: Pose, shape: ConvexShape) -> bool:
        """Whether a brick lies square to the vertical or to a slope."""
        slopes = (plane.normal_W for plane in self.planes.values() if plane.normal_W[2] > 0.0)
        return lies_square(pose, shape, (UP, *slopes))

    def _needed(self, brick: Brick, position_W: Vec3) -> float:
        """How far the boxes that stand for planes must reach for a brick to be well within [m]."""
        return ROOM * (dist(self._middle_W, position_W) + brick.shape.length)

    def _renew_boxes(self) -> None:
        """PyBullet cannot change the size of a box: put up others."""
        for plane in self.planes.values():
            self.maker.bodies.remove(plane.id)
            self._put_up(plane)
        self.choose(self._lively)

    def _put_up(self, plane: Plane) -> None:
        """Put up the box that stands for a plane."""
        times = self.maker.bodies.scale
        depth = self._reach * times
        above = dot(subtract(self._middle_W, plane.point_W), plane.normal_W)
        nearest = add_scaled(self._middle_W, -above, plane.normal_W)  # of the plane
        centre = add_scaled(scale(times, nearest), -depth, plane.normal_W)
        box = self.maker.solids.box((depth, depth, depth))
        self.maker.plane(plane.id, box, plane.friction, centre, _turning_z_to(plane.normal_W))

    def _put_up_half_space(self, plane: Plane) -> None:
        """Put up what stands for a plane beside bricks with rounded edges; the box tells whether it is near."""
        position, turn = scale(self.maker.bodies.scale, plane.point_W), _turning_z_to(plane.normal_W)
        body = self.maker.plane(plane.id, self.maker.solids.half_space(), plane.friction, position, turn)
        self._half_spaces.append(body)
        self.maker.bodies.unseen.add(body)  # its bounds meet everything


def _turning_z_to(normal_W: Vec3) -> Quaternion:
    """The shortest turn that takes the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)


def lies_square(pose: Pose, shape: ConvexShape, ups_W: Iterable[Vec3] = (UP,)) -> bool:
    """Whether a face of a brick is level, or along a slope: it may touch others with its faces, not lean."""
    normals_W: Iterable[Vec3] = body_axes(pose.orientation)  # of a box
    if not isinstance(shape, Box):
        normals_W = [rotate(pose.orientation, face.normal) for face in shape.faces]
    return any(abs(dot(normal_W, up_W)) > SQUARE for normal_W in normals_W for up_W in ups_W)
