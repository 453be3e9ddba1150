"""What statics takes in: bodies whose numbers mean something. Anything else is an error with its remedy."""

from collections.abc import Collection, Iterable, Sequence
from math import isfinite

from stability.model import BodyId, ConvexShape, Plane
from stability.shapes.box import Box
from stability.statics.facts import Placed

UNIT = 1e-6  # how far the length of a quaternion or a normal may be from 1
SHORTEST, LONGEST = 1e-9, 1e9  # [m] of sides and distances: beyond, their squares and products lose their digits
LIGHTEST, HEAVIEST = 1e-60, 1e60  # [kg]


def admit_brick(placed: Placed) -> None:
    """Raise ValueError for a brick whose size, mass or place means nothing."""
    if _is_usual(placed):
        return
    brick, name = placed.brick, placed.brick.id
    _admit_shape("brick", name, brick.shape)
    if not LIGHTEST <= brick.mass <= HEAVIEST:
        raise ValueError(f"brick '{name}' has the mass {brick.mass}; it is from {LIGHTEST:g} to {HEAVIEST:g} kg")
    admit_place(placed)


def _is_usual(placed: Placed) -> bool:
    """Whether a brick is admitted, by the quickest test there is, since every brick that is set down passes it."""
    brick, pose = placed.brick, placed.pose
    if not isinstance(brick.shape, Box):
        return False  # it takes the longer way
    size = brick.shape.size
    if not (len(size) == len(pose.position_W) == 3 and len(pose.orientation) == 4):  # noqa: PLR2004 -- as they are
        return False
    (a, b, c), (x, y, z), (i, j, k, w) = size, pose.position_W, pose.orientation
    return (
        SHORTEST <= a <= LONGEST
        and SHORTEST <= b <= LONGEST
        and SHORTEST <= c <= LONGEST
        and LIGHTEST <= brick.mass <= HEAVIEST
        and -LONGEST <= x <= LONGEST
        and -LONGEST <= y <= LONGEST
        and -LONGEST <= z <= LONGEST
        and -UNIT <= i * i + j * j + k * k + w * w - 1.0 <= UNIT
    )


def admit_place(placed: Placed) -> None:
    """Raise ValueError for a pose that means nothing."""
    name, pose = placed.brick.id, placed.pose
    _admit(name, "position", pose.position_W, 3, "write x, y and z in metres")
    if not all(-LONGEST <= part <= LONGEST for part in pose.position_W):
        raise ValueError(f"brick '{name}' is at {pose.position_W}; put it within {LONGEST:g} m of the origin")
    _admit(name, "orientation", pose.orientation, 4, "write a quaternion x, y, z, w")
    if abs(sum(part * part for part in pose.orientation) - 1.0) > UNIT:
        raise ValueError(f"brick '{name}' has the orientation {pose.orientation}; divide it by its length")


def admit_site(planes: Sequence[Plane], tables: Sequence[Placed], friction: float, gravity: float) -> None:
    """Raise ValueError for fixed bodies, a friction or a gravity that mean nothing."""
    if not 0.0 <= friction < float("inf"):
        raise ValueError(f"the friction is {friction}; it is 0 or more")
    if not 0.0 < gravity < float("inf"):
        raise ValueError(f"the gravity is {gravity} m/s2; it is more than 0, and points down")
    for plane in planes:
        _admit_plane(plane)
    for table in tables:
        _admit_shape("table", table.brick.id, table.brick.shape)
        admit_place(table)
    names = [plane.id for plane in planes] + [table.brick.id for table in tables]
    admit_names(names, ())


def _admit_shape(what: str, name: BodyId, shape: ConvexShape) -> None:
    limits = f"from {SHORTEST:g} to {LONGEST:g} m"
    match shape:
        case Box(size):
            _admit(name, "size", size, 3, "write length, width and thickness in metres")
            if not all(SHORTEST <= side <= LONGEST for side in size):
                raise ValueError(f"{what} '{name}' has the size {size}; each side is {limits}")
        case tuple():
            raise ValueError(f"{what} '{name}' has the shape {shape}; write Box({shape})")
        case _ if not SHORTEST <= shape.least_thickness <= shape.length <= LONGEST:
            across = f"{shape.least_thickness} to {shape.length} m"
            raise ValueError(f"{what} '{name}' measures {across}; each measure is {limits}")


def _admit_plane(plane: Plane) -> None:
    _admit(plane.id, "point", plane.point_W, 3, "write x, y and z in metres")
    _admit(plane.id, "normal", plane.normal_W, 3, "write x, y and z of the way out of the solid")
    if abs(sum(part * part for part in plane.normal_W) - 1.0) > UNIT:
        raise ValueError(f"plane '{plane.id}' has the normal {plane.normal_W}; divide it by its length")
    if not 0.0 <= plane.friction < float("inf"):
        raise ValueError(f"plane '{plane.id}' has the friction {plane.friction}; it is 0 or more")


def admit_names(coming: Iterable[BodyId], known: Collection[BodyId]) -> None:
    """Raise ValueError for a name that something has already."""
    among: set[BodyId] = set()
    for name in coming:
        if name in known or name in among:
            raise ValueError(f"there are two bodies called '{name}'; give each a name of its own")
        among.add(name)


def _admit(name: BodyId, what: str, numbers: Sequence[float], count: int, remedy: str) -> None:
    if len(numbers) != count or not all(map(isfinite, numbers)):
        raise ValueError(f"'{name}' has the {what} {tuple(numbers)}; {remedy}")
