"""Random boxes of one width that stand only by friction, alike at every section: on planes, and on each other."""

from collections.abc import Callable, Iterator, Sequence
from math import cos, radians, sin
from random import Random
from typing import TypeAlias

from stability.analysis.margins import guarantee
from stability.model import Plane
from stability.problem import Stability
from stability.statics.assembly import Assembly
from tests.stability.analysis.leaning_scenes import box, plane

Corner: TypeAlias = tuple[float, float]
FRICTION = (0.1, 0.3, 0.5, 0.8, 1.2, 2.5)
CLEAR = 0.01  # of all other corners from a plane [m]


def that_need_friction(
    random: Random, made: Callable[[Random], Assembly | None], count: int, most_points: int = 6
) -> Iterator[Assembly]:
    """So many assemblies that stand, but not by forces along normals alone, with few points of contact in a section."""
    while count:
        assembly = made(random)
        if assembly is None or assembly.verdict().stability is not Stability.STABLE:
            continue
        problem = assembly.problem()
        few = sum(len(contact.points_W) for contact in problem.contacts) <= 2 * most_points
        plain = all(len(contact.normals_W) == 1 for contact in problem.contacts)
        if few and plain and guarantee(problem, assembly.forces()) is None:
            count -= 1
            yield assembly


def on_planes(random: Random) -> Assembly | None:
    """A box turned at random whose corners touch one to three planes; None if a plane cuts it."""
    size, angle = (1.0, random.uniform(0.1, 1.0), random.uniform(0.02, 1.2)), random.uniform(-80.0, 80.0)
    corners = _corners(size, 0.0, 1.0, angle)
    planes = _planes(random, [(corners, corners)] * random.choice([1, 2, 2, 2, 3]), 150.0)
    if planes is None:
        return None
    made = Assembly(planes)
    made.add_all([box("a", size, 0.0, 1.0, angle)])
    return made


def on_each_other(random: Random) -> Assembly | None:
    """A box with another on one of its faces, flat or by an edge, and planes at corners of both; None if one is cut."""
    width, angle = random.uniform(0.2, 1.0), random.uniform(-40.0, 40.0)
    first, second = (1.0, width, random.uniform(0.1, 1.0)), (random.uniform(0.3, 1.2), width, random.uniform(0.1, 1.0))
    side = random.choice([0.0, 90.0, -90.0])
    outwards = angle + side
    turned = outwards + random.choice([0.0, 0.0, random.uniform(-60.0, 60.0)])
    away, along = (first[2], first[0]) if side == 0.0 else (first[0], first[2])
    share = 0.5 * random.uniform(-0.9, 0.9) * along
    nx, nz = sin(radians(outwards)), cos(radians(outwards))
    at = (0.5 * away * nx + share * nz, 1.0 + 0.5 * away * nz - share * nx)
    touching = min(_corners(second, 0.0, 0.0, turned), key=lambda corner: corner[0] * nx + corner[1] * nz)
    back = (-0.5 * second[2] * nx, -0.5 * second[2] * nz) if turned == outwards else touching
    x, z = at[0] - back[0], at[1] - back[1]
    one, other = _corners(first, 0.0, 1.0, angle), _corners(second, x, z, turned)
    places = [(one, [*one, *other])] * random.choice([1, 2]) + [(other, [*one, *other])] * random.choice([0, 1, 1, 2])
    planes = _planes(random, places, 110.0)
    if planes is None:
        return None
    made = Assembly(planes, random.choice(FRICTION[:5]))
    try:
        made.add_all([box("a", first, 0.0, 1.0, angle), box("b", second, x, z, turned)])
    except ValueError:  # they overlap
        return None
    return made


def _corners(size: tuple[float, float, float], x: float, z: float, angle: float) -> list[Corner]:
    turn = radians(angle)
    return [
        (x + along * cos(turn) + up * sin(turn), z - along * sin(turn) + up * cos(turn))
        for along in (-0.5 * size[0], 0.5 * size[0])
        for up in (-0.5 * size[2], 0.5 * size[2])
    ]


def _planes(
    random: Random, places: Sequence[tuple[Sequence[Corner], Sequence[Corner]]], steepest: float
) -> list[Plane] | None:
    """Planes through a corner of the first each, in front of which are all of the second; None if one is not."""
    planes = []
    for number, (corners, others) in enumerate(places):
        x, z = random.choice(corners)
        found = plane(f"p{number}", random.uniform(-steepest, steepest), random.choice(FRICTION), x, z)
        nx, _, nz = found.normal_W
        if sorted((cx - x) * nx + (cz - z) * nz for cx, cz in others)[1] < CLEAR:
            return None
        planes.append(found)
    return planes
