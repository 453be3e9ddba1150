"""The bricks of earlier steps, on which an imported load settles."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import atan2, degrees
from typing import Final, TypeAlias

from stability.geometry.box import MIDDLE, Box, OffCentreBox
from stability.geometry.compound import parts_of
from stability.geometry.placed_shape import bounds_W, middle_pose, part_pose
from stability.geometry.vectors import subtract
from stability.model import ConvexShape, Pose, Vec3
from stackdsl.compiler.bricks import EarlierBricks, WrittenBrick, bricks_of
from stackdsl.compiler.schedule import planes_of
from stackdsl.diagnostics import Span
from stackdsl.importers.load import ImportedBox, ImportedLoad
from stackdsl.importers.settling import RIGHT_ANGLE, PlanRectangle, outline, overlap_in_plan
from stackdsl.language.quantities import InputError
from stackdsl.language.validation import validate
from stackdsl.language.variants import expand
from stackdsl.language.yaml.source import Plain, Source

Bounds: TypeAlias = tuple[Vec3, Vec3]
# Keys of a scenario that places of bricks may depend on, or that these keys need.
KEPT: Final = (
    *("scenario", "brick_types", "brick", "world", "let"),
    *("uncertain", "matrix", "cases", "exclude", "samples"),
)
SQUARE: Final = 1e-9  # [deg] rounding error of a turn by a right angle
DIGITS: Final = 12  # decimals of a metre


@dataclass(frozen=True, slots=True)
class PlacedBefore:
    """What lies below a load."""

    boxes: tuple[ImportedBox, ...] = ()  # upright boxes, and those that bricks consist of
    others: tuple[tuple[str, Bounds], ...] = ()  # names and bounds of bricks of other shapes [m]


def placed_before(source: Source, steps: Sequence[Plain]) -> PlacedBefore:
    """Return the bricks of these steps of a scenario; none if they have mistakes, which are reported elsewhere.

    Raises InputError if their places depend on the variant.
    """
    if not steps:
        return PlacedBefore()
    values: dict[str, Plain] = {key: source.values[key] for key in KEPT if key in source.values}
    alone = replace(source, values={**values, "build": list(steps)})
    variants, _ = expand(alone)
    found: PlacedBefore | None = None
    for variant in variants:
        scenario, _ = validate(variant.source, variant)
        if scenario is None:
            continue
        bricks = bricks_of(scenario, EarlierBricks(tuple(planes_of(scenario))))
        own = _sorted_out(bricks)
        if found is not None and own != found:
            message = "the load settles on bricks of earlier steps, whose places depend on the variant"
            raise InputError("SD115", message, "place them at fixed places, or write `settle: as written`")
        found = own
    return found or PlacedBefore()


def odd_support(load: ImportedLoad, before: PlacedBefore) -> tuple[ImportedBox, str] | None:
    """Return a box of a load and the name of a brick below or beside it that is no upright box; None if there is none.

    Bricks count with their bounding boxes.
    """
    for box in load.boxes:
        own = outline(box)
        for name, (low, high) in before.others:
            if overlap_in_plan(own, _rectangle(low, high)) > 0:
                return box, name
    return None


def _rectangle(low: Vec3, high: Vec3) -> PlanRectangle:
    (x, to_x), (y, to_y) = ((_exact(low[axis]), _exact(high[axis])) for axis in (0, 1))
    return PlanRectangle(((x + to_x) / 2, (y + to_y) / 2), ((to_x - x) / 2, (to_y - y) / 2), None)


def _sorted_out(bricks: Sequence[WrittenBrick]) -> PlacedBefore:
    boxes: list[ImportedBox] = []
    others: list[tuple[str, Bounds]] = []
    for number, brick in enumerate(bricks, 1):
        if brick.lost is not None:
            continue
        parts = list(_upright(brick.shape, brick.pose))
        if None in parts:
            others.append((brick.name or f"brick {number}", bounds_W(brick.shape, brick.pose)))
        else:
            boxes += [part for part in parts if part is not None]
    return PlacedBefore(tuple(boxes), tuple(others))


def _upright(shape: ConvexShape, pose: Pose) -> Iterator[ImportedBox | None]:
    """Yield the upright boxes that a brick consists of, and None for each part of another shape."""
    for part in parts_of(shape):
        own = part_pose(part, pose)
        if isinstance(part.shape, OffCentreBox):
            own = middle_pose(subtract(MIDDLE, part.shape.centre_of_mass), own)
        x, y, z, w = own.orientation
        if not isinstance(part.shape, Box | OffCentreBox) or max(abs(x), abs(y)) > SQUARE:
            yield None
            continue
        yaw = degrees(2.0 * atan2(z, w))
        square = RIGHT_ANGLE * round(yaw / RIGHT_ANGLE)
        turn = Fraction(square) if abs(yaw - square) <= SQUARE else Fraction(yaw)
        length, width, height = map(_exact, part.shape.size)
        a, b, c = map(_exact, own.position_W)
        yield ImportedBox(
            None, (length, width, height), (a, b, c), Fraction(1), Span("", 1, 1, 1), (Fraction(0), Fraction(0), turn)
        )


def _exact(length: float) -> Fraction:
    """Return a length without the rounding error of sums of decimals [m]."""
    return Fraction(repr(round(length, DIGITS)))
