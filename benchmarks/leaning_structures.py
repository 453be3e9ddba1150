"""Random structures that lean, and random ones that fall in several parts, for measurements of slips and falls.

Planks have random sides, densities, angles and directions, and meet edge on face or corner on face, so that their
contacts are known. Everything is plane geometry across the leaning: x is the direction of leaning, z up, y along the
edges.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator
TOUCHES = 1e-9  # [m]
EDGE_AT = (0.02, 0.42)  # shares of a plank from its middle: range in which it lies over an edge
WITHIN = 0.04  # share of a side: least distance of a contact from the end of a face


@dataclass(frozen=True, slots=True)
class Bar:
    """Box at a pose."""

    name: str
    size: Array  # (3,) [m]
    mass: float  # [kg]
    centre: Array  # (3,) [m]
    turn: Array  # (3, 3) body axes, by columns

    def corners(self) -> Array:
        """Return the corners (8, 3) [m]."""
        signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        return self.centre + (signs * self.size) @ self.turn.T

    def shifted(self, *by: float) -> "Bar":
        """Return the bar moved by a vector [m]."""
        return replace(self, centre=self.centre + np.array(by))


@dataclass(frozen=True, slots=True)
class Wall:
    """Fixed half-space."""

    name: str
    point: Array  # (3,) [m]
    normal: Array  # (3,) unit, outward
    friction: float | None  # None for that between bricks


@dataclass(frozen=True, slots=True)
class Structure:
    """Boxes, and the fixed bodies that they stand on and lean against."""

    family: str
    number: int
    bars: Sequence[Bar]
    walls: Sequence[Wall]


def about_y(angle: float) -> Array:
    """Return the rotation that raises the x axis by an angle [rad]."""
    return np.array([[cos(angle), 0.0, -sin(angle)], [0.0, 1.0, 0.0], [sin(angle), 0.0, cos(angle)]])


def about_z(angle: float) -> Array:
    """Return the rotation about the vertical by an angle [rad]."""
    return np.array([[cos(angle), -sin(angle), 0.0], [sin(angle), cos(angle), 0.0], [0.0, 0.0, 1.0]])


def plank(rng: Rng, name: str, angle: float, twist: float = 0.0, length: float | None = None) -> Bar:
    """Return a plank that rises towards +x by an angle [rad], its lowest point at z = 0, and is rotated by `twist`."""
    size = np.array([length or rng.uniform(0.08, 0.15), rng.uniform(0.018, 0.034), rng.uniform(0.006, 0.011)])
    mass = float(np.prod(size) * rng.uniform(400.0, 900.0))
    bar = Bar(name, size, mass, np.zeros(3), about_z(twist) @ about_y(angle))
    return bar.shifted(0.0, 0.0, -bar.corners()[:, 2].min())


def mirrored(bar: Bar) -> Bar:
    """Return the mirror image, which rises towards -x."""
    half = about_z(pi)
    return replace(bar, centre=half @ bar.centre, turn=half @ bar.turn)


def up_to(bar: Bar, point: Array, normal: Array) -> Bar:
    """Return the bar moved along x until it touches the front of a plane, whose `normal` points to the bar."""
    gaps = (bar.corners() - point) @ normal
    return bar.shifted(-float(gaps.min() / normal[0]), 0.0, 0.0)


def face(bar: Bar, direction: Array) -> tuple[Array, Array]:
    """Return a point and the normal of the face of a bar that faces a direction most."""
    cosines = bar.turn.T @ direction
    axis = int(np.argmax(np.abs(cosines)))
    normal = np.sign(cosines[axis]) * bar.turn[:, axis]
    return bar.centre + 0.5 * bar.size[axis] * normal, normal


def touches_within(one: Bar, other: Bar, direction: Array) -> bool:
    """Return whether the corners of one bar that touch a face of another lie well within it."""
    point, normal = face(other, direction)
    gaps = (one.corners() - point) @ normal
    local = np.abs((one.corners()[gaps < TOUCHES] - other.centre) @ other.turn) / other.size
    axis = int(np.argmax(np.abs(other.turn.T @ normal)))
    return bool(np.delete(local, axis, axis=1).max() < 0.5 - WITHIN)


GROUND = Wall("ground", np.zeros(3), np.array([0.0, 0.0, 1.0]), None)


def ladder(rng: Rng, twist: float = 0.0) -> Structure | None:
    """Return a plank that leans on a slightly rough wall."""
    wall = Wall("wall", np.zeros(3), np.array([-1.0, 0.0, 0.0]), float(rng.uniform(0.0, 0.25)))
    bar = up_to(plank(rng, "ladder", radians(rng.uniform(40.0, 75.0)), twist), wall.point, wall.normal)
    return Structure("ladder", 0, [bar], [GROUND, wall])


def askew(rng: Rng) -> Structure | None:
    """Return a ladder that is not square to its wall: a corner leans."""
    leaning = ladder(rng, radians(rng.uniform(4.0, 30.0)) * rng.choice((-1.0, 1.0)))
    return leaning and replace(leaning, family="askew ladder")


def against_block(rng: Rng) -> Structure | None:
    """Return a plank that leans on the side of a heavy block."""
    angle = radians(rng.uniform(40.0, 70.0))
    bar = plank(rng, "plank", angle)
    height = rng.uniform(1.05, 1.5) * float(bar.corners()[:, 2].max())
    block = plank(rng, "block", pi / 2.0, length=height)
    size = np.array([height, 0.05, rng.uniform(0.03, 0.05)])
    block = replace(block, size=size, mass=float(np.prod(size) * rng.uniform(900.0, 2500.0)))
    block = block.shifted(-float(block.corners()[:, 0].min()), 0.0, -float(block.corners()[:, 2].min()))
    point, normal = face(block, np.array([-1.0, 0.0, 0.0]))
    return Structure("against a block", 0, [up_to(bar, point, normal), block], [GROUND])


def over_an_edge(rng: Rng) -> Structure | None:
    """Return a plank that stands on the ground and lies over the edge of a block, or of planks."""
    block = plank(rng, "block", 0.0)
    size = np.array([rng.uniform(0.03, 0.06), rng.uniform(0.04, 0.08), rng.uniform(0.008, 0.06)])
    block = replace(block, size=size, mass=float(np.prod(size) * rng.uniform(900.0, 2500.0)))
    block = block.shifted(0.5 * float(size[0]), 0.0, 0.5 * float(size[2]) - float(block.centre[2]))
    twist = radians(rng.choice((0.0, 1.0)) * rng.uniform(-8.0, 8.0))
    bar = plank(rng, "plank", radians(rng.uniform(12.0, 60.0)), twist)
    if bar.size[1] > 0.8 * size[1]:
        return None
    # The edge runs across the lower face, and a rotated plank meets it with one of its own long edges.
    along, across, _ = bar.turn.T
    shifts = []
    for side in (-0.5, 0.5):
        below = bar.centre + side * bar.size[1] * across - 0.5 * bar.size[2] * bar.turn[:, 2]
        shifts.append(-float((below + (size[2] - below[2]) / along[2] * along)[0]))
    bar = bar.shifted(min(shifts), 0.0, 0.0)
    where = (np.array([0.0, 0.0, size[2]]) - bar.centre) @ bar.turn[:, 0] / bar.size[0]
    if not EDGE_AT[0] <= where < EDGE_AT[1]:
        return None
    return Structure("over an edge", 0, [bar, block], [GROUND])


def unlike_v(rng: Rng, twist: float = 0.0) -> Structure | None:
    """Return a plank that leans on the lower face of a plank that leans on it."""
    one, other = (plank(rng, name, radians(rng.uniform(45.0, 72.0)), t) for name, t in (("a", twist), ("b", 0.0)))
    other = mirrored(other)
    point, normal = face(other, np.array([-1.0, 0.0, -0.5]))
    one = up_to(one, point, normal)
    if not touches_within(one, other, np.array([-1.0, 0.0, -0.5])):
        return None
    return Structure("unlike V", 0, [one, other], [GROUND])


def askew_v(rng: Rng) -> Structure | None:
    """Return the same with one plank rotated against the other: a corner leans."""
    leaning = unlike_v(rng, radians(rng.uniform(3.0, 12.0)) * rng.choice((-1.0, 1.0)))
    return leaning and replace(leaning, family="askew V")


def chain(rng: Rng) -> Structure | None:
    """Return such a V with a third plank that leans on its back."""
    leaning = unlike_v(rng)
    if leaning is None:
        return None
    third = mirrored(plank(rng, "c", radians(rng.uniform(30.0, 50.0)), length=float(rng.uniform(0.06, 0.09))))
    point, normal = face(leaning.bars[1], np.array([1.0, 0.0, 0.5]))
    third = up_to(third, point, normal)
    if not touches_within(third, leaning.bars[1], np.array([1.0, 0.0, 0.5])):
        return None
    return Structure("V under load", 0, [*leaning.bars, third], [GROUND])


def rider(rng: Rng) -> Structure | None:
    """Return a shallow ladder with a plank on its back."""
    wall = Wall("wall", np.zeros(3), np.array([-1.0, 0.0, 0.0]), float(rng.uniform(0.0, 0.2)))
    angle = radians(rng.uniform(22.0, 34.0))
    bar = up_to(plank(rng, "ladder", angle), wall.point, wall.normal)
    load = plank(rng, "load", angle, length=float(rng.uniform(0.03, 0.05)))
    out = bar.turn @ np.array([rng.uniform(-0.1, 0.2) * bar.size[0], 0.0, 0.5 * (bar.size[2] + load.size[2])])
    return Structure("ladder under load", 0, [bar, replace(load, centre=bar.centre + out)], [GROUND, wall])


LEANING: Sequence[Callable[[Rng], Structure | None]] = (
    ladder,
    askew,
    against_block,
    over_an_edge,
    unlike_v,
    askew_v,
    chain,
    rider,
)


def structure(family: Callable[[Rng], Structure | None], number: int) -> Structure:
    """Return the structure of a family with a number, always the same, rotated as a whole about the vertical."""
    rng = np.random.default_rng([number, len(family.__name__), sum(map(ord, family.__name__))])
    leaning = None
    while leaning is None:
        leaning = family(rng)
    yaw = about_z(float(rng.uniform(0.0, 2.0 * pi)))
    bars = [replace(bar, centre=yaw @ bar.centre, turn=yaw @ bar.turn) for bar in leaning.bars]
    walls = [replace(wall, normal=yaw @ wall.normal) for wall in leaning.walls]
    return replace(leaning, number=number, bars=bars, walls=walls)


def quaternion(turn: Array) -> tuple[float, float, float, float]:
    """Return the quaternion x, y, z, w of a rotation."""
    values, vectors = np.linalg.eigh(_symmetric(turn))
    x, y, z, w = vectors[:, int(np.argmax(values))]
    size = sqrt(x * x + y * y + z * z + w * w)
    return (float(x / size), float(y / size), float(z / size), float(w / size))


def _symmetric(r: Array) -> Array:
    """Return Bar-Itzhack's matrix, whose first eigenvector is the quaternion."""
    return np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
