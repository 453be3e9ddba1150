"""Scenes whose bricks and contacts are written by hand, for what must not depend on the detection of contacts.

All lie along x or lean within the plane of x and z; east is towards positive x.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import cos, sin
from typing import TypeAlias

from stability.contact_law import Coulomb
from stability.geometry.box import Box, as_box
from stability.model import GROUND, BodyId, Brick, Pose, Quaternion, Vec3
from stability.problem import UP, Contact, Placed, Problem, Wrench

GRAVITY = 9.81  # [m/s^2]
LENGTH, WIDTH, THICKNESS = 0.12, 0.024, 0.008  # of a plank [m]
SIZE: Vec3 = (LENGTH, WIDTH, THICKNESS)
MASS = 0.012  # of a plank [kg]
EAST: Vec3 = (1.0, 0.0, 0.0)
WEST: Vec3 = (-1.0, 0.0, 0.0)

Span: TypeAlias = tuple[float, float]  # from, to [m]


def about_y(angle: float) -> Quaternion:
    """The turn that dips the x axis by an angle [rad]."""
    return (0.0, sin(angle / 2.0), 0.0, cos(angle / 2.0))


def plank(name: BodyId, centre_W: Vec3, mass: float = MASS, size: Vec3 = SIZE, dip: float = 0.0) -> Placed:
    """A brick whose length lies along x, dipped towards positive x by an angle [rad]."""
    return Placed(Brick(name, Box(size), mass), Pose(centre_W, about_y(dip)))


def weighed(bricks: Iterable[Placed], contacts: Sequence[Contact]) -> Problem:
    """These bricks, loaded by their weights alone."""
    by_name = {placed.brick.id: placed for placed in bricks}
    loads = {name: Wrench((0.0, 0.0, -GRAVITY * placed.brick.mass)) for name, placed in by_name.items()}
    return Problem(by_name, contacts, loads)


def rectangle(along_x: Span, along_y: Span, z: float) -> tuple[Vec3, ...]:
    """The corners of a level rectangle, counter-clockwise seen from above."""
    (west, east), (front, back) = along_x, along_y
    return ((west, front, z), (east, front, z), (east, back, z), (west, back, z))


def level_patch(along_x: Span, z: float, width: float = WIDTH) -> tuple[Vec3, ...]:
    """The corners of a level patch whose middle line is in the plane y = 0."""
    return rectangle(along_x, (-width / 2.0, width / 2.0), z)


def wall_patch(x: float, along_z: Span, width: float = WIDTH) -> tuple[Vec3, ...]:
    """The corners of an upright patch that looks east or west, counter-clockwise seen from the east."""
    side, (low, high) = width / 2.0, along_z
    return ((x, -side, low), (x, side, low), (x, side, high), (x, -side, high))


def edge(x: float, z: float, width: float) -> tuple[Vec3, ...]:
    """The ends of an edge along y."""
    return ((x, -width / 2.0, z), (x, width / 2.0, z))


def column(offsets: Sequence[float], masses: Sequence[float] | None = None, friction: float = 0.5) -> Problem:
    """Planks p01, p02, ... on the ground and on each other, their centres at these x [m]."""
    bricks, contacts = [], []
    lower, below = GROUND, offsets[0]
    for level, x in enumerate(offsets):
        name, z = f"p{level + 1:02}", level * THICKNESS
        mass = MASS if masses is None else masses[level]
        bricks.append(plank(name, (x, 0.0, z + THICKNESS / 2.0), mass))
        shared = (max(x, below) - LENGTH / 2.0, min(x, below) + LENGTH / 2.0)
        contacts.append(Contact(lower, name, level_patch(shared, z), (UP,), Coulomb(friction)))
        lower, below = name, x
    return weighed(bricks, contacts)


def stepped(count: int, step: float) -> Problem:
    """A column of planks, each a step further east than the one below: it stands while count * step <= LENGTH."""
    return column([level * step for level in range(count)])


def harmonic(count: int, share: float) -> Problem:
    """A column that hangs over as far as it can, all its overhangs times a share: it stands up to a share of 1.

    The k planks on top have their centre above the end of the next, which so hangs over by LENGTH / (2 k).
    """
    offsets = [0.0]
    for above in range(count - 1, 0, -1):
        offsets.append(offsets[-1] + share * LENGTH / (2.0 * above))
    return column(offsets)


def on_a_slope(angle: float, friction: float, size: Vec3 = SIZE) -> Problem:
    """A block on a slope that falls off towards the east by an angle [rad]; the middle of its face is the origin."""
    down, normal = (cos(angle), 0.0, -sin(angle)), (sin(angle), 0.0, cos(angle))
    length, width, height = size
    corners: tuple[Vec3, ...] = tuple(
        (x * down[0], y, x * down[2])
        for x, y, _ in rectangle((-length / 2.0, length / 2.0), (-width / 2.0, width / 2.0), 0.0)
    )
    centre = (height / 2.0 * normal[0], 0.0, height / 2.0 * normal[2])
    block = plank("block", centre, size=size, dip=angle)
    return weighed([block], [Contact("slope", "block", corners, (normal,), Coulomb(friction))])


def ladder(angle: float, friction: float, wall_friction: float = 0.0, size: Vec3 = SIZE) -> Problem:
    """A plank on the ground at x = 0 that leans east against a wall; angle to the ground [rad].

    Both touch edges of its lower face. If the wall is smooth it stands while tan(angle) >= 1 / (2 mu + t / L).
    """
    length, width, _ = size
    head = edge(length * cos(angle), length * sin(angle), width)
    ground = Contact(GROUND, "ladder", edge(0.0, 0.0, width), (UP,), Coulomb(friction))
    wall = Contact("wall", "ladder", head, (WEST,), Coulomb(wall_friction))
    return weighed([plank("ladder", _leaning_centre(angle, size), size=size, dip=-angle)], [ground, wall])


def inverted_v(angle: float, friction: float, size: Vec3 = SIZE) -> Problem:
    """Two planks that lean against each other; angle to the ground [rad], `left` with its foot at x = 0.

    They touch the ground and each other with edges of their lower faces: mu >= (cot(angle) - t / L) / 2.
    """
    length, width, _ = size
    x, y, z = _leaning_centre(angle, size)
    top, height = length * cos(angle), length * sin(angle)
    left = plank("left", (x, y, z), size=size, dip=-angle)
    right = plank("right", (2.0 * top - x, y, z), size=size, dip=angle)
    contacts = [
        Contact(GROUND, "left", edge(0.0, 0.0, width), (UP,), Coulomb(friction)),
        Contact(GROUND, "right", edge(2.0 * top, 0.0, width), (UP,), Coulomb(friction)),
        Contact("left", "right", edge(top, height, width), (EAST,), Coulomb(friction)),
    ]
    return weighed([left, right], contacts)


def _leaning_centre(angle: float, size: Vec3) -> Vec3:
    """Of a plank that leans east, the west edge of its lower face at the origin."""
    along, across = size[0] / 2.0, size[2] / 2.0
    return (along * cos(angle) - across * sin(angle), 0.0, along * sin(angle) + across * cos(angle))


def between_walls(problem: Problem, friction: float = 0.5) -> Problem:
    """Each of these level bricks between a wall at its west end and one at its east end; their contacts come last."""
    contacts = list(problem.contacts)
    for name, placed in problem.bricks.items():
        (x, _, z), (length, width, height) = placed.pose.position_W, as_box(placed.brick.shape, "a wall at an end").size
        for wall, end, normal in (("west wall", x - length / 2.0, EAST), ("east wall", x + length / 2.0, WEST)):
            face = wall_patch(end, (z - height / 2.0, z + height / 2.0), width)
            contacts.append(Contact(wall, name, face, (normal,), Coulomb(friction)))
    return replace(problem, contacts=contacts)


def moved_by(problem: Problem, shift_W: Vec3) -> Problem:
    """All of it, elsewhere."""

    def moved(point: Vec3) -> Vec3:
        return (point[0] + shift_W[0], point[1] + shift_W[1], point[2] + shift_W[2])

    bricks = {
        name: replace(placed, pose=replace(placed.pose, position_W=moved(placed.pose.position_W)))
        for name, placed in problem.bricks.items()
    }
    contacts = [replace(contact, points_W=tuple(map(moved, contact.points_W))) for contact in problem.contacts]
    return Problem(bricks, contacts, problem.loads)


def side_by_side(first: Problem, second: Problem, distance: float) -> Problem:
    """Two scenes on one ground, the second further back by a distance [m] and its bricks named q instead of p."""
    other = moved_by(second, (0.0, distance, 0.0))
    names = {name: f"q{name[1:]}" for name in other.bricks}
    bricks = {names[n]: replace(p, brick=replace(p.brick, id=names[n])) for n, p in other.bricks.items()}
    contacts = [
        replace(contact, lower=names.get(contact.lower, contact.lower), upper=names.get(contact.upper, contact.upper))
        for contact in other.contacts
    ]
    loads = {names[name]: load for name, load in other.loads.items()}
    return Problem({**first.bricks, **bricks}, [*first.contacts, *contacts], {**first.loads, **loads})
