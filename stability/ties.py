"""Ties: straps, bands and rods, as cables without friction that pull bricks together.

The tension of a tie is the same along its whole length. It is at least that with which the tie was put on, and at most
its strength: a tie that has reached it keeps this force, as in limit analysis. Rigid bricks do not stretch a tie, so
any tension in between is admissible, as the pressure of a contact is.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from stability.geometry.compound import parts_of
from stability.geometry.placed_shape import corners_W, part_pose
from stability.geometry.polygons import Polygon, clip, doubled_area, extent, hull
from stability.geometry.vectors import (
    add,
    add_scaled,
    admit_number,
    cross,
    dot,
    inverse,
    norm,
    rotate,
    scale,
    short_repr,
    subtract,
    unit,
)
from stability.loads import Load, Loads, admit_loads
from stability.model import BodyId, Vec3
from stability.problem import Placed, Wrench

STRAIGHT: Final = 1e-9  # sine of a turn below which a cable passes a corner without a force
ONE_PLACE: Final = 1e-9  # share of the length of a tie: corners that are closer are one place
STRONGEST: Final = 1e60  # [N]


@dataclass(frozen=True, slots=True)
class Tie:
    """Cable around bricks, or between them. It holds from the moment when all of its bricks are placed."""

    name: str
    around: frozenset[BodyId]
    pulls: tuple[Load, ...]  # on these bricks, at a tension of 1 N
    tension: float  # with which it is put on [N]
    strength: float  # at least `tension` [N]
    course_W: tuple[Vec3, ...] = ()  # its corners, in order, and the first one again if it is closed [m]

    @property
    def is_ranged(self) -> bool:
        """Return whether its tension is not known."""
        return self.strength > self.tension

    def loads(self) -> Iterator[Load]:
        """Yield its pulls at the tension with which it is put on."""
        return (pull.times(self.tension) for pull in self.pulls) if self.tension else iter(())

    def pull_on(self, placed: Placed) -> Wrench | None:
        """Return its pull on a brick at a tension of 1 N; None if there is none."""
        return Loads(self.pulls).wrench(placed)


@dataclass(frozen=True, slots=True)
class CablePoint:
    """Place at which a cable pulls a body."""

    body: BodyId
    point_W: Vec3  # [m]
    pull_W: Vec3  # at a tension of 1 N


@dataclass(frozen=True, slots=True)
class Cable:
    """Course of a cable, and its pulls."""

    course_W: tuple[Vec3, ...]  # corners, in order, and the first one again if it is closed [m]
    points: tuple[CablePoint, ...]


def loop_around(bricks: Sequence[Placed], normal_W: Vec3, offset: float, anchors_W: Sequence[Vec3] = ()) -> Cable:
    """Return the shortest closed cable around bricks in the plane of points p with `normal_W @ p` = `offset` [m].

    `normal_W` is a unit vector. `anchors_W` are points of the plane that are fixed: the cable ends at them. The cable
    is empty if the plane cuts no brick. Where corners of several bricks are one place, they share the pull equally.
    """
    axes = _axes(normal_W)
    places: list[tuple[tuple[float, float], Vec3, BodyId]] = []
    for placed in bricks:
        places += [(_flat(point, axes), point, placed.brick.id) for point in _section(placed, normal_W, offset)]
    if not places:
        return Cable((), ())
    corners = hull([place for place, _, _ in places] + [_flat(point, axes) for point in anchors_W])
    length = max(max(abs(x), abs(y)) for x, y in (_minus(corner, corners[0]) for corner in corners)) or 1.0
    fixed = [_flat(point, axes) for point in anchors_W]
    course: list[Vec3] = []
    points: list[CablePoint] = []
    for number, corner in enumerate(corners):
        before, after = corners[number - 1], corners[(number + 1) % len(corners)]
        back, on = _unit(_minus(before, corner)), _unit(_minus(after, corner))
        if abs(back[0] * on[1] - back[1] * on[0]) <= STRAIGHT:
            continue
        at_W = add(scale(offset, normal_W), add(scale(corner[0], axes[0]), scale(corner[1], axes[1])))
        course.append(at_W)
        pull_W = add(scale(back[0] + on[0], axes[0]), scale(back[1] + on[1], axes[1]))
        if any(_near(corner, place, length) for place in fixed):
            continue
        here = sorted({name for place, _, name in places if _near(corner, place, length)})
        points += [CablePoint(name, at_W, scale(1.0 / len(here), pull_W)) for name in here]
    return Cable((*course, course[0]) if course else (), tuple(points))


def straight_between(one: BodyId, first_W: Vec3, other: BodyId, last_W: Vec3) -> Cable:
    """Return the straight cable between points of two bodies."""
    along_W = unit(subtract(last_W, first_W))
    ends = CablePoint(one, first_W, along_W), CablePoint(other, last_W, scale(-1.0, along_W))
    return Cable((first_W, last_W), ends)


def pulls_of(cable: Cable, bricks: Iterable[Placed]) -> tuple[Load, ...]:
    """Return the pulls of a cable on bricks at a tension of 1 N, as loads."""
    poses = {placed.brick.id: placed.pose for placed in bricks}
    return tuple(
        Load(
            each.body,
            each.pull_W,
            rotate(inverse(poses[each.body].orientation), subtract(each.point_W, poses[each.body].position_W)),
        )
        for each in cable.points
        if each.body in poses
    )


def length_of(course_W: Sequence[Vec3]) -> float:
    """Return the length of a course [m]."""
    return sum(norm(subtract(after, before)) for before, after in pairwise(course_W))


def crosses(placed: Placed, normal_W: Vec3, offset: float, course_W: Sequence[Vec3], least: float) -> bool:
    """Return whether a closed cable in a plane passes through a brick, deeper than `least` [m]."""
    axes = _axes(normal_W)
    section = hull([_flat(point, axes) for point in _section(placed, normal_W, offset)])
    outline = tuple(_flat(point, axes) for point in course_W[:-1])
    if not section or max(_beyond(point, outline) for point in section) <= least:
        return False
    return _doubled_area(clip(section, outline)) > least * extent(section)


def _doubled_area(polygon: Polygon) -> float:
    return doubled_area(polygon)[0] if len(polygon) > 2 else 0.0  # noqa: PLR2004 -- others have no area


def _beyond(point: tuple[float, float], outline: Sequence[tuple[float, float]]) -> float:
    """Return the greatest distance of a point beyond a side of a convex outline, counter-clockwise [m]."""
    beyond = []
    for number, corner in enumerate(outline):
        x, y = _unit(_minus(outline[(number + 1) % len(outline)], corner))
        dx, dy = _minus(point, corner)
        beyond.append(y * dx - x * dy)
    return max(beyond)


def _section(placed: Placed, normal_W: Vec3, offset: float) -> Iterator[Vec3]:
    """Yield points whose convex hull is the cut of a plane through a brick [m]."""
    for part in parts_of(placed.brick.shape):
        pose = part_pose(part, placed.pose)
        corners = corners_W(part.shape, pose)
        heights = [dot(normal_W, corner) - offset for corner in corners]
        yield from (corner for corner, height in zip(corners, heights, strict=True) if height == 0.0)
        for face in part.shape.faces:
            for one, other in zip(face.corners, (*face.corners[1:], face.corners[0]), strict=True):
                if heights[one] * heights[other] < 0.0:
                    share = heights[one] / (heights[one] - heights[other])
                    yield add_scaled(corners[one], share, subtract(corners[other], corners[one]))


def _axes(normal_W: Vec3) -> tuple[Vec3, Vec3]:
    """Return two unit vectors that span a plane."""
    reference = (0.0, 0.0, 1.0) if abs(normal_W[2]) < 0.5 else (1.0, 0.0, 0.0)  # noqa: PLR2004 -- any other axis
    first = unit(subtract(reference, scale(dot(reference, normal_W), normal_W)))
    return first, cross(normal_W, first)


def _flat(point_W: Vec3, axes: tuple[Vec3, Vec3]) -> tuple[float, float]:
    return dot(axes[0], point_W), dot(axes[1], point_W)


def _minus(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    return a[0] - b[0], a[1] - b[1]


def _unit(a: tuple[float, float]) -> tuple[float, float]:
    size = norm((*a, 0.0))
    return a[0] / size, a[1] / size


def _near(one: tuple[float, float], other: tuple[float, float], length: float) -> bool:
    x, y = _minus(one, other)
    return max(abs(x), abs(y)) <= ONE_PLACE * length


def admit_ties(ties: object) -> None:
    """Raise TypeError for anything but ties, ValueError for tensions out of range or a name that is used twice."""
    known: set[str] = set()
    if not isinstance(ties, Iterable):
        raise TypeError(f"expected ties, such as [Tie(...)], not {short_repr(ties)}")
    for tie in ties:
        if not isinstance(tie, Tie):
            raise TypeError(f"expected Tie(name, around, pulls, tension, strength), not {short_repr(tie)}")
        admit_loads(Loads(tie.pulls))
        for what, number in (("tension", tie.tension), ("strength", tie.strength)):
            admit_number(f"the {what} of the tie '{tie.name}' is", number, "write a number of at least 0, in newtons")
        if not 0.0 <= tie.tension <= tie.strength <= STRONGEST:
            bounds = f"a tension of {short_repr(tie.tension)} N and a strength of {short_repr(tie.strength)} N"
            remedy = f"write a tension of at least 0, and a strength from there to {STRONGEST:g}"
            raise ValueError(f"the tie '{tie.name}' has {bounds}; {remedy}")
        if tie.name in known:
            raise ValueError(f"there are two ties with the name '{tie.name}'; give each a different name")
        known.add(tie.name)
