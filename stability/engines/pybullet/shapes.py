"""The collision shapes of a world: boxes, boxes with rounded edges, and rounded hulls. Lengths in engine metres.

PyBullet gives two boxes that touch along an edge the normal of a face, and planks that lean on each other then need
twice the friction that they should. The convex hull of eight corners does not suffer from this: they stand a small
radius inside the box, and the collision margin of that radius makes the outer size exact (docs/decisions/0012).
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from tempfile import NamedTemporaryFile

from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add, scale
from stability.model import ConvexShape, Pose, Vec3
from stability.shapes.box import Box
from stability.shapes.in_pose import corners_W
from stability.shapes.inset import inset_corners

# [engine m] What PyBullet gives the parts of a file as collision margin. It must stay: the tree of the parts' bounds is
# made with it, and parts whose margin grows later are not noticed before they have sunk into what they touch.
PART_MARGIN = 1e-3
CORNERS_OF_A_FACE = 4


@dataclass
class Solids:
    """The shapes that bodies of one client have in common."""

    client: int
    _half_space: int | None = field(default=None, init=False)
    _boxes: dict[Vec3, int] = field(default_factory=dict, init=False)
    _hulls: dict[tuple[Vec3, float], int] = field(default_factory=dict, init=False)
    _of_shapes: dict[tuple[ConvexShape, float], int] = field(default_factory=dict, init=False)

    def box(self, half_extents: Vec3) -> int:
        """The number of a box."""
        if half_extents not in self._boxes:
            self._boxes[half_extents] = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=self.client
            )
        return self._boxes[half_extents]

    def half_space(self) -> int:
        """The number of the half-space below the origin."""
        if self._half_space is None:
            self._half_space = int(
                pybullet.createCollisionShape(
                    pybullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), physicsClientId=self.client
                )
            )
        return self._half_space

    def rounded_box(self, half_extents: Vec3, radius: float) -> int:
        """The number of a box with rounded edges; its body must be given the radius as collision margin."""
        if (half_extents, radius) not in self._hulls:
            corners = [
                [side * (half - radius) for side, half in zip(sides, half_extents, strict=True)]
                for sides in product((-1.0, 1.0), repeat=3)
            ]
            self._hulls[half_extents, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._hulls[half_extents, radius]

    def rounded_hull(self, shape: ConvexShape, radius: float, times: float) -> int:
        """The number of a solid with rounded edges, so many times as large, in the axes of its inertia.

        Its body must be given the radius as collision margin.
        """
        if (shape, radius) not in self._of_shapes:
            turn = inverse(shape.principal_axes)
            corners = [scale(times, rotate(turn, corner)) for corner in inset_corners(shape, radius / times)]
            self._of_shapes[shape, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._of_shapes[shape, radius]

    def rounded_solids(self, solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> int:
        """The number of several rounded solids in one shape, so many times as large, by their poses in it.

        PyBullet takes no more than 16 parts in a call, and drops the others without a word; from a file it takes any
        number of convex parts.
        """
        with NamedTemporaryFile("w", suffix=".obj", encoding="ascii", delete=False) as file:
            file.writelines(_obj(solids, times))
        try:
            return int(
                pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=file.name, physicsClientId=self.client)
            )
        finally:
            os.unlink(file.name)


# Corners of a box, in the order of the shape; PyBullet needs only that some face names each of them.
FACES = ((1, 2, 4, 3), (5, 6, 8, 7))


def _obj(solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> Iterable[str]:
    """The lines of a Wavefront file with the hulls of solids with rounded edges."""
    before = 0
    for part, (shape, pose) in enumerate(solids):
        corners = _inner_corners(shape, pose, times)
        faces = FACES if isinstance(shape, Box) else _naming_all(len(corners))
        yield f"o {part}\n"
        yield from (f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        yield from (f"f {' '.join(str(before + corner) for corner in face)}\n" for face in faces)
        before += len(corners)


def _inner_corners(shape: ConvexShape, pose: Pose, times: float) -> Sequence[Vec3]:
    """The corners of a part without its margin, in engine metres."""
    if isinstance(shape, Box):
        a, b, c = scale(times, shape.size)
        inner = (a - 2.0 * PART_MARGIN, b - 2.0 * PART_MARGIN, c - 2.0 * PART_MARGIN)
        return corners_W(Box(inner), Pose(scale(times, pose.position_W), pose.orientation))
    corners = inset_corners(shape, PART_MARGIN / times)
    return [scale(times, add(pose.position_W, rotate(pose.orientation, corner))) for corner in corners]


def _naming_all(count: int) -> Iterator[Sequence[int]]:
    """Four corners at a time, by number from 1; the last four share some with those before."""
    for start in range(0, count, CORNERS_OF_A_FACE):
        begin = 1 + min(start, max(count - CORNERS_OF_A_FACE, 0))
        yield range(begin, min(begin + CORNERS_OF_A_FACE, count + 1))
