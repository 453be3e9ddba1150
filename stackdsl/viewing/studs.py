"""Studs of toy bricks as they are drawn: round knobs on the upper face."""

from collections.abc import Iterator, Mapping
from itertools import product
from math import cos, pi, sin
from typing import Final

from stability.geometry.box import box_of
from stability.joints import Joints, Studs
from stability.model import BodyId, ConvexShape, Vec3

SIDES: Final = 12
RADIUS, HEIGHT = 0.3, 0.2125  # of the pitch: 2.4 and 1.7 mm at 8 mm
MOST: Final = 1024  # studs of a brick; more are too small to see

Stud = tuple[tuple[Vec3, ...], tuple[Vec3, ...]]  # the rings of its foot and its top, counter-clockwise from above


def pitches(joints: Joints) -> Mapping[BodyId, float]:
    """Return the pitch of the studs of each body that has some on its upper face [m]."""
    found: dict[BodyId, float] = {}
    for rule in joints.rules:
        if isinstance(rule.joint, Studs):
            for names in rule.between:
                found |= {name: rule.joint.pitch for name in names if name not in found.keys() | rule.joint.smooth}
    return found


def studs_of(shape: ConvexShape, pitch: float | None) -> Iterator[Stud]:
    """Yield the studs of a box in its axes [m]; none for other shapes, or without a pitch."""
    box = box_of(shape)
    if pitch is None or box is None:
        return
    (x, y, z), size = box[1], box[0].size
    counts = round(size[0] / pitch), round(size[1] / pitch)
    if counts[0] * counts[1] > MOST:
        return
    foot = z + 0.5 * size[2]
    angles = [(2 * side + 1) * pi / SIDES for side in range(SIDES)]
    for i, j in product(range(counts[0]), range(counts[1])):
        at_x, at_y = (
            x + (i - 0.5 * (counts[0] - 1)) * pitch,
            y + (j - 0.5 * (counts[1] - 1)) * pitch,
        )
        ring = [(at_x + RADIUS * pitch * cos(angle), at_y + RADIUS * pitch * sin(angle)) for angle in angles]
        yield tuple((*point, foot) for point in ring), tuple((*point, foot + HEIGHT * pitch) for point in ring)
