"""What statics takes in: bodies whose numbers mean something. Anything else is an error with its remedy."""

from collections.abc import Collection, Iterable, Sequence

from stability.friction_law import GivenFriction, admit_friction
from stability.geometry.given_numbers import LONGEST, SHORTEST, admit_in_range, admit_number, admit_numbers, told
from stability.model import BodyId, Brick, ConvexShape, Plane, Pose
from stability.shapes.box import Box
from stability.shapes.off_centre_box import OffCentreBox
from stability.statics.facts import Forces, Placed, Problem

UNIT = 1e-6  # how far the length of a quaternion or a normal may be from 1
PLAIN = {float, int}  # types of numbers that need no closer look
LIGHTEST, HEAVIEST = 1e-60, 1e60  # [kg]
WEAKEST, STRONGEST = 1e-60, 1e60  # [m/s2] of gravity


def admit_brick(placed: Placed) -> None:
    """Raise ValueError for a brick whose size, mass or place means nothing, TypeError for what is none."""
    try:
        if _is_usual(placed):
            return
    except (AttributeError, TypeError):
        pass  # which is told below
    _admit_kinds(placed)
    brick, name = placed.brick, placed.brick.id
    _admit_shape("brick", name, brick.shape)
    remedy = f"write kilograms, as a number; it is from {LIGHTEST:g} to {HEAVIEST:g} kg"
    admit_in_range(f"brick '{name}' has the mass", brick.mass, LIGHTEST, HEAVIEST, remedy)
    admit_place(placed)


def _is_usual(placed: Placed) -> bool:
    """Whether a brick is admitted, by the quickest test there is, since every brick that is set down passes it."""
    brick, pose = placed.brick, placed.pose
    if not isinstance(brick.shape, Box):
        return False  # it takes the longer way
    size = brick.shape.size
    if not isinstance(brick, Brick) or not isinstance(pose, Pose) or not isinstance(brick.id, str):
        return False
    if not (len(size) == len(pose.position_W) == 3 and len(pose.orientation) == 4):  # noqa: PLR2004 -- as they are
        return False
    (a, b, c), (x, y, z), (i, j, k, w) = size, pose.position_W, pose.orientation
    return (
        PLAIN.issuperset(map(type, (a, b, c, x, y, z, i, j, k, w, brick.mass)))
        and type(size) is tuple
        and SHORTEST <= a <= LONGEST
        and SHORTEST <= b <= LONGEST
        and SHORTEST <= c <= LONGEST
        and LIGHTEST <= brick.mass <= HEAVIEST
        and -LONGEST <= x <= LONGEST
        and -LONGEST <= y <= LONGEST
        and -LONGEST <= z <= LONGEST
        and -UNIT <= i * i + j * j + k * k + w * w - 1.0 <= UNIT
    )


def _admit_kinds(placed: object) -> None:
    """Raise TypeError for what is no brick in a pose."""
    if not isinstance(placed, Placed):
        raise TypeError(f"expected Placed(brick, pose), not {told(placed)}")
    if not isinstance(placed.brick, Brick):
        raise TypeError(f"expected Brick(name, shape, mass), not {told(placed.brick)}")
    admit_name("a brick", placed.brick.id)
    if not isinstance(placed.pose, Pose):
        raise TypeError(f"brick '{placed.brick.id}' has the pose {told(placed.pose)}; write Pose((x, y, z)) in metres")


def admit_name(what: str, name: object) -> None:
    """Raise TypeError for what is no name."""
    if not isinstance(name, str):
        raise TypeError(f"{what} is called {told(name)}; write its name as a text")


def admit_place(placed: Placed) -> None:
    """Raise ValueError for a pose that means nothing, TypeError for what is none."""
    name, pose = placed.brick.id, placed.pose
    _admit(name, "position", pose.position_W, 3, "write x, y and z in metres")
    if not all(-LONGEST <= part <= LONGEST for part in pose.position_W):
        raise ValueError(f"brick '{name}' is at {told(pose.position_W)}; put it within {LONGEST:g} m of the origin")
    _admit(name, "orientation", pose.orientation, 4, "write a quaternion x, y, z, w")
    if abs(sum(part * part for part in pose.orientation) - 1.0) > UNIT:
        raise ValueError(f"brick '{name}' has the orientation {told(pose.orientation)}; divide it by its length")


def admit_site(planes: Sequence[Plane], tables: Sequence[Placed], friction: GivenFriction, gravity: float) -> None:
    """Raise ValueError for fixed bodies, a friction or a gravity that mean nothing, TypeError for what is none."""
    admit_friction(friction)
    remedy = f"write m/s2, as a number that is more than 0, from {WEAKEST:g} to {STRONGEST:g}; it points down"
    admit_in_range("the gravity is", gravity, WEAKEST, STRONGEST, remedy)
    for plane in planes:
        _admit_plane(plane)
    for table in tables:
        _admit_kinds(table)
        _admit_shape("table", table.brick.id, table.brick.shape)
        admit_place(table)
    names = [plane.id for plane in planes] + [table.brick.id for table in tables]
    admit_names(names, ())


def admit_problem(problem: object) -> None:
    """Raise TypeError for what is no problem of statics."""
    if not isinstance(problem, Problem):
        raise TypeError(f"expected the problem of an assembly, assembly.problem(), not {told(problem)}")


def admit_forces(forces: object) -> None:
    """Raise TypeError for what are no forces of a proof; None is none that are known."""
    if forces is not None and not isinstance(forces, Forces):
        raise TypeError(f"expected the forces of an assembly, assembly.forces(), not {told(forces)}")


def admit_overlap(overlap: float) -> None:
    """Raise ValueError for a depth that means nothing, TypeError for what is none."""
    admit_number("the overlap is", overlap, "write metres, as a number")
    if not overlap >= 0.0:
        raise ValueError(f"the overlap is {overlap} m; it is 0 or more")


def _admit_shape(what: str, name: BodyId, shape: ConvexShape) -> None:
    limits = f"from {SHORTEST:g} to {LONGEST:g} m"
    match shape:
        case Box(size):
            _admit_size(what, name, size)
        case tuple():
            raise ValueError(f"{what} '{name}' has the shape {told(shape)}; write Box({told(shape)})")
        case OffCentreBox(size, centre):
            _admit_size(what, name, size)
            _admit(name, "centre of mass", centre, 3, "write x, y and z from the middle of the box in metres")
            if any(abs(part) >= 0.5 * side for part, side in zip(centre, size, strict=True)) and what == "brick":
                raise ValueError(f"{what} '{name}' has its centre of mass at {centre}, which is not inside of {size}")
        case _ if not (hasattr(shape, "faces") and hasattr(shape, "least_thickness")):
            raise TypeError(
                f"{what} '{name}' has the shape {told(shape)}; write Box((length, width, thickness)) in metres"
            )
        case _ if not SHORTEST <= shape.least_thickness <= shape.length <= LONGEST:
            across = f"{shape.least_thickness} to {shape.length} m"
            raise ValueError(f"{what} '{name}' measures {across}; each measure is {limits}")


def _admit_size(what: str, name: BodyId, size: Sequence[float]) -> None:
    _admit(name, "size", size, 3, "write length, width and thickness in metres")
    if not isinstance(size, tuple):
        raise TypeError(f"{what} '{name}' has the size {told(size)}; write a tuple, as in Box((0.4, 0.3, 0.2))")
    if not all(SHORTEST <= side <= LONGEST for side in size):
        limits = f"from {SHORTEST:g} to {LONGEST:g} m"
        raise ValueError(f"{what} '{name}' has the size {told(size)}; each side is {limits}")


def _admit_plane(plane: Plane) -> None:
    if not isinstance(plane, Plane):
        raise TypeError(f"expected Plane(name, point, normal, friction), not {told(plane)}")
    admit_name("a plane", plane.id)
    admit_number(f"plane '{plane.id}' has the friction", plane.friction, "write a coefficient of 0 or more")
    _admit(plane.id, "point", plane.point_W, 3, "write x, y and z in metres")
    if not all(-LONGEST <= part <= LONGEST for part in plane.point_W):
        raise ValueError(f"plane '{plane.id}' is at {told(plane.point_W)}; put it within {LONGEST:g} m of the origin")
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
    admit_numbers(f"'{name}' has the {what}", numbers, count, remedy)
