"""What a brick is made to: its shape, the box around it, and which of its points an author means by its place."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, TypeAlias

from stability.geometry.vectors import scale, subtract
from stability.model import ConvexShape, Vec3
from stability.shapes.box import Box
from stability.shapes.not_a_solid import NotASolidError
from stability.shapes.off_centre_box import MIDDLE, OffCentreBox
from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.obj_text import obj_mesh
from stackdsl.supervising.executors import supervised
from stackdsl.supervising.memory_limit import memory_limited
from stackdsl.supervising.worker import Task, TaskStatus

if TYPE_CHECKING:
    from stability.shapes.solid_making import Made

KEPT: Final = 4096  # forms that are worked out once
MOST_AT_ONCE: Final = 200  # corners of which a solid is made in milliseconds, whatever they are
TIME_LIMIT: Final = 20.0  # [s] of wall time for one of more corners; of a thousand that are no solid, Qhull takes two
MEMORY_LIMIT: Final = 1 << 30  # [bytes] for it
METRES: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}

Outline: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Form:
    """The form of a brick. Ways lead from its centre of mass, in its own axes [m]."""

    shape: ConvexShape
    size: Vec3  # of the box around it, along its own axes [m]
    middle: Vec3 = MIDDLE  # to the middle of that box, which layouts, `on` and `beside` go by
    origin: Vec3 = MIDDLE  # to what `at` says the place of: of a box its middle, of a solid where it is written from


def box_form(size: Vec3, centre_of_mass: Vec3 | None = None) -> Form:
    """A box, its centre of mass seen from its middle [m]. Raises MistakeError."""
    if centre_of_mass is None or centre_of_mass == MIDDLE:
        return Form(Box(size), size)
    if any(abs(part) >= 0.5 * side for part, side in zip(centre_of_mass, size, strict=True)):
        message = "the centre of mass lies outside of the box"
        raise MistakeError("SD104", message, "write it as seen from the middle of the box, inside of it")
    back = subtract(MIDDLE, centre_of_mass)
    return Form(OffCentreBox(size, centre_of_mass), size, back, back)


@lru_cache(maxsize=KEPT)
def prism_form(outline: Outline, depth: float, centre_of_mass: Vec3 | None = None) -> Form:
    """A prism. Raises MistakeError."""
    from stability.shapes.solid_making import prism  # noqa: PLC0415 -- boxes do without scipy

    try:
        made = prism(outline, depth, centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def hull_form(points: tuple[Vec3, ...], centre_of_mass: Vec3 | None = None) -> Form:
    """The hull of points. Raises MistakeError."""
    from stability.shapes.solid_making import solid_of_corners  # noqa: PLC0415 -- boxes do without scipy

    try:
        made = _solid(solid_of_corners, points, centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def mesh_form(text: str, file: str, unit: str, centre_of_mass: Vec3 | None = None) -> Form:
    """The solid of the text of an OBJ file. Raises MistakeError."""
    from stability.shapes.solid_making import solid_of_mesh  # noqa: PLC0415 -- boxes do without scipy

    mesh = obj_mesh(text, file)
    try:
        points = tuple(scale(METRES[unit], point) for point in mesh.points)
        made = _solid(solid_of_mesh, points, tuple(mesh.loops), centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", f"{file}: {error.message}", error.hint) from error
    return _form(made.shape, made.centre_of_mass)


def _solid(make: "Callable[..., Made]", points: tuple[Vec3, ...], *others: object) -> "Made":
    """The solid that a function makes of points. Raises NotASolidError.

    Of many it is made in a supervised process: for points on a circle Qhull takes their square, and no signal ends it.
    """
    if len(points) <= MOST_AT_ONCE:
        return make(points, *others)
    made = _made_apart(make, points, *others)
    if isinstance(made, tuple):
        raise NotASolidError(*made)
    return made


@lru_cache(maxsize=KEPT)
def _made_apart(make: "Callable[..., Made]", *arguments: object) -> "Made | tuple[str, str, int | None]":
    done = supervised(Task(_made_or_why, (make, *arguments), TIME_LIMIT))
    if done.status is TaskStatus.DONE:
        return done.value  # type: ignore[return-value]  # it is what the function returns
    broken = "take too long" if done.status is TaskStatus.TIMED_OUT else "break Qhull"
    return f"its corners {broken}: {done.message}", "write a simpler solid, close to it", None


def _made_or_why(make: "Callable[..., Made]", *arguments: object) -> "Made | tuple[str, str, int | None]":
    """What the worker does: make a solid, or say why there is none."""
    with memory_limited(MEMORY_LIMIT):
        try:
            return make(*arguments)
        except NotASolidError as error:
            return error.message, error.hint, error.number


def _form(shape: ConvexShape, centre_of_mass: Vec3) -> Form:
    lows, highs = zip(*((min(along), max(along)) for along in zip(*shape.corners, strict=True)), strict=True)
    (ax, ay, az), (bx, by, bz) = lows, highs
    middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
    return Form(shape, (bx - ax, by - ay, bz - az), middle, subtract(MIDDLE, centre_of_mass))


def laid(form: Form, spec: BrickSpec) -> Form:
    """What a layout lays of bricks of a form: whole ones, pieces, or stones of its own. Raises MistakeError."""
    if spec.outline is None:
        return cut_to(form, spec.size or form.size)
    return prism_form(spec.outline, spec.depth)


def cut_to(form: Form, size: Vec3) -> Form:
    """The same material in another size, as at the ends of a wall: of boxes only."""
    if size == form.size:
        return form
    match form.shape:
        case Box():
            return Form(Box(size), size)
        case OffCentreBox(whole, centre):
            x, y, z = (part * side / full for part, side, full in zip(centre, size, whole, strict=True))
            return box_form(size, (x, y, z))
    raise MistakeError(
        "SD104", "the layout lays pieces of bricks, and a solid cannot be cut", "take boxes, given by their `size`"
    )
