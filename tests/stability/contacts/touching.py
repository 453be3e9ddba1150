"""Pairs of bricks for tests of contacts, with detection and comparison of contacts."""

from collections.abc import Sequence
from math import asin, cos, degrees, dist, pi, sin

from stability.contacts.bodies import BoxSolid, box_solid
from stability.contacts.detection import contact_between
from stability.geometry.vectors import rotate
from stability.model import IDENTITY, Plane, Pose, Quaternion, Vec3
from stability.problem import Contact, Tolerances

L, W, T = PLANK = (0.1176, 0.0234, 0.0078)
CUBE = (1.0, 1.0, 1.0)
UP = (0.0, 0.0, 1.0)
GROUND = Plane("ground", (0.0, 0.0, 0.0), UP, 0.5)
TOLERANCES = Tolerances()


def about(axis: Vec3, angle: float) -> Quaternion:
    s = sin(0.5 * angle)
    return (s * axis[0], s * axis[1], s * axis[2], cos(0.5 * angle))


def yawed(angle: float) -> Quaternion:
    return about(UP, angle)


def pitched(angle: float) -> Quaternion:
    """A turn that lifts the end at +x."""
    return about((0.0, -1.0, 0.0), angle)


def brick(name: str, size: Vec3, position: Vec3, orientation: Quaternion = IDENTITY) -> BoxSolid:
    return box_solid(name, size, Pose(position, orientation))


def plank(name: str, position: Vec3, orientation: Quaternion = IDENTITY) -> BoxSolid:
    return brick(name, PLANK, position, orientation)


def touch(a: BoxSolid, b: BoxSolid) -> Contact | None:
    """The contact of two bricks, which must be the same seen from either."""
    found = contact_between(a, b, 0.5, TOLERANCES)
    assert found == contact_between(b, a, 0.5, TOLERANCES)
    return found


def contact(a: BoxSolid, b: BoxSolid) -> Contact:
    found = touch(a, b)
    assert found is not None
    return found


def same_points(found: Sequence[Vec3], expected: Sequence[Vec3], within: float) -> bool:
    """Whether the two are the same points, in whatever order."""
    return len(found) == len(expected) and all(min(dist(p, q) for q in found) <= within for p in expected)


def elevations(found: Contact) -> list[float]:
    """Of the normals, from the horizontal [deg]."""
    return sorted(degrees(asin(max(-1.0, min(1.0, normal[2])))) for normal in found.normals_W)


# --- edges and corners ----------------------------------------------------------------------------------------------


def ladder(theta: float) -> BoxSolid:
    """A plank whose lower face's edges touch the floor z = 0 and the wall x = L cos(theta)."""
    centre = rotate(pitched(theta), (L / 2, 0.0, T / 2))
    return plank("ladder", centre, pitched(theta))


def leaning_pair(theta: float) -> tuple[BoxSolid, BoxSolid]:
    """An inverted V whose upper edges meet at the origin."""
    x, z = L / 2 * cos(theta) + T / 2 * sin(theta), L / 2 * sin(theta) - T / 2 * cos(theta)
    return plank("a", (-x, 0.0, -z), pitched(theta)), plank("b", (x, 0.0, -z), pitched(pi - theta))
