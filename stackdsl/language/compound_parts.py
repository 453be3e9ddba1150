"""Boxes that make up bricks of a common section, hollow blocks and tables.

The frame of each is that of its bounding box: the origin in the middle, x along the width, y along the length, z up.
"""

from collections.abc import Mapping
from typing import Final, Literal, TypeAlias

from stability.geometry.box import Box
from stability.model import Pose, Vec3
from stackdsl.language.quantities import InputError
from stackdsl.wording import mm

Boxes: TypeAlias = tuple[tuple[Box, Pose], ...]
Rectangles: TypeAlias = tuple[tuple[float, float, float, float], ...]  # x and z of two opposite corners [m]
SectionShape: TypeAlias = Literal["L", "T", "U", "I", "channel"]
MOST_CELLS: Final = 50


def section_boxes(shape: SectionShape, size: Vec3, thickness: float) -> Boxes:
    """Return the boxes of a brick with a constant section of this thickness [m]. Raises InputError."""
    width, length, height = size
    across, up = {"L": (1, 1), "T": (1, 1), "U": (2, 1), "I": (1, 2), "channel": (1, 2)}[shape]
    for side, count, name in ((width, across, "width"), (height, up, "height")):
        if count * thickness >= side:
            message = f"a thickness of {mm(thickness)} leaves nothing of the {name} of {mm(side)}"
            raise InputError("SD104", message, f"write a thickness below {mm(side / count)}")
    x, z, t = 0.5 * width, 0.5 * height, thickness
    base, top = (-x, -z, x, t - z), (-x, z - t, x, z)
    sections: Mapping[SectionShape, Rectangles] = {
        "L": (base, (-x, t - z, t - x, z)),
        "T": ((-0.5 * t, -z, 0.5 * t, z - t), top),
        "U": (base, (-x, t - z, t - x, z), (x - t, t - z, x, z)),
        "I": (base, (-0.5 * t, t - z, 0.5 * t, z - t), top),
        "channel": (base, (-x, t - z, t - x, z - t), top),
    }
    return tuple(_box((ax, -0.5 * length, az), (bx, 0.5 * length, bz)) for ax, az, bx, bz in sections[shape])


def hollow_block_boxes(size: Vec3, wall: float, cells: int) -> Boxes:
    """Return the walls of a block with cells in a row along x that are open above and below. Raises InputError."""
    (x, y, z), (length, width, _) = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2]), size
    for side, count, name in ((length, cells + 1, "length"), (width, 2, "width")):
        if count * wall >= side:
            message = f"{count} walls of {mm(wall)} leave no cell in the {name} of {mm(side)}"
            raise InputError("SD104", message, f"write a wall below {mm(side / count)}, or fewer cells")
    step = (length - wall) / cells
    between = [(n * step - x, n * step + wall - x) for n in range(cells)] + [(x - wall, x)]
    long = (_box((-x, -y, -z), (x, wall - y, z)), _box((-x, y - wall, -z), (x, y, z)))
    return (*long, *(_box((start, wall - y, -z), (end, y - wall, z)) for start, end in between))


def table_boxes(size: Vec3, top: float, leg: float) -> Boxes:
    """Return the top of a table and its four square legs at the corners. Raises InputError."""
    x, y, z = (0.5 * side for side in size)
    if top >= size[2]:
        raise InputError("SD104", f"a top of {mm(top)} leaves no legs in the height of {mm(size[2])}", "write less")
    if 2.0 * leg >= min(size[:2]):
        message = f"two legs of {mm(leg)} leave no room between them in {mm(min(size[:2]))}"
        raise InputError("SD104", message, f"write a leg below {mm(0.5 * min(size[:2]))}")
    corners = [(sx * (x - leg), sy * (y - leg)) for sx in (-1.0, 1.0) for sy in (-1.0, 1.0)]
    legs = (
        _box(
            (min(ax, ax + (leg if ax > 0.0 else -leg)), min(ay, ay + (leg if ay > 0.0 else -leg)), -z),
            (max(ax, ax + (leg if ax > 0.0 else -leg)), max(ay, ay + (leg if ay > 0.0 else -leg)), z - top),
        )
        for ax, ay in corners
    )
    return (_box((-x, -y, z - top), (x, y, z)), *legs)


def _box(low: Vec3, high: Vec3) -> tuple[Box, Pose]:
    (ax, ay, az), (bx, by, bz) = low, high
    middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
    return Box((bx - ax, by - ay, bz - az)), Pose(middle)
