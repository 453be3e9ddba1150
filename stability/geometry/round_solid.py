"""Solids of revolution: cylinders, cone frustums, pipes, spheres and capsules, with exact extents and inertia.

A round solid is the convex hull of two discs across its z axis, rounded by a ball: a cylinder has two equal discs, a
sphere two points in one place. Its corners, edges and faces describe an inscribed polyhedron for drawing only. Contacts
and distances use the exact surface (`stability.geometry.round_distance`).
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Final, TypeGuard, final

from stability.geometry.convex_solid import NotASolidError
from stability.geometry.vectors import norm, scale, subtract, unit
from stability.model import IDENTITY, ConvexShape, Face, Quaternion, Vec3

SIDES: Final = 48  # of the drawn rims
RINGS: Final = 12  # of a drawn sphere, from pole to pole
KEPT: Final = 256  # cache size
LEVEL: Final = 1.0 - 1e-12  # least vertical part of the normal of an end
MIDDLE: Vec3 = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, slots=True)
class RoundSolid:
    """Convex hull of two discs across the z axis, rounded by a ball, relative to its centre of mass.

    A bore along the axis takes mass from it, but the solid is convex for contacts: nothing fits inside.
    """

    radii: tuple[float, float]  # of the disc at the lower and at the upper end of the axis [m]
    height: float  # between the discs [m]
    rounding: float = 0.0  # radius of the ball [m]
    bore: float = 0.0  # radius of a bore along the axis [m]
    centre_of_mass: Vec3 = MIDDLE  # from the middle between the discs [m]

    @property
    def corners(self) -> tuple[Vec3, ...]:
        """The corners of the drawn polyhedron, from the centre of mass [m]."""
        return _drawn(self)[0]

    @property
    def faces(self) -> tuple[Face, ...]:
        """The faces of the drawn polyhedron."""
        return _drawn(self)[1]

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """The edges of the drawn polyhedron."""
        return _drawn(self)[2]

    @property
    def flat_faces(self) -> tuple[Face, ...]:
        """The faces of the drawn polyhedron that stand for its flat ends."""
        return tuple(face for face in self.faces if not self.rounding and abs(face.normal[2]) > LEVEL)

    def end(self, face: Face) -> tuple[Vec3, float]:
        """Return the centre of a flat end, from the centre of mass [m], and its area [m2]."""
        upper = face.normal[2] > 0.0
        centre = (0.0, 0.0, 0.5 * self.height if upper else -0.5 * self.height)
        return subtract(centre, self.centre_of_mass), pi * (self.radii[upper] ** 2 - self.bore**2)

    @property
    def tapers(self) -> bool:
        """True for a cone, whose ends differ in size."""
        return self.radii[0] != self.radii[1]

    @property
    def slope(self) -> float:
        """The component along the axis of the unit normals of its side."""
        low, high = self.radii
        fall = low - high
        return fall / hypot(self.height, fall) if fall else 0.0

    @property
    def widest(self) -> float:
        """The largest radius [m]."""
        return max(self.radii) + self.rounding

    @property
    def least_thickness(self) -> float:
        """The least distance of two parallel planes that enclose it [m]: its ends, or planes along its side."""
        across = self.slope
        side = ((1.0 - across * across) ** 0.5, 0.0, across)
        return min(self.height + 2.0 * self.rounding, self.reach(side) + self.reach(scale(-1.0, side)))

    @property
    def length(self) -> float:
        """The longest side of the box around it along its body axes [m]."""
        return max(self.height + 2.0 * self.rounding, 2.0 * self.widest)

    @property
    def bounding_radius(self) -> float:
        """The distance of its farthest point from the centre of mass [m]."""
        x, y, z = self.centre_of_mass
        off = hypot(x, y)
        ends = zip(self.radii, (-0.5 * self.height, 0.5 * self.height), strict=True)
        return self.rounding + max(hypot(off + radius, end - z) for radius, end in ends)

    @property
    def volume(self) -> float:
        """The volume of its material [m3]."""
        return sum(part[0] for part in _parts(self))

    @property
    def principal_axes(self) -> Quaternion:
        """The identity: the body axes are principal axes."""
        return IDENTITY

    def moments(self, mass: float) -> Vec3:
        """Return the moments of inertia of uniform density about its own centroid, at a mass [kg m2]."""
        across, along = _unit_moments(self)
        return (mass * across, mass * across, mass * along)

    def reach(self, direction: Vec3) -> float:
        """Return the extent from the centre of mass along a direction, times the length of the direction [m]."""
        x, y, z = direction
        (a, b, c), across, half = self.centre_of_mass, hypot(x, y), 0.5 * self.height
        ends = max(self.radii[1] * across + half * z, self.radii[0] * across - half * z)
        return ends + self.rounding * norm(direction) - (a * x + b * y + c * z)

    def support(self, direction: Vec3) -> Vec3:
        """Return the farthest point along a direction [m]; of several, one on the axis or at the upper end."""
        x, y, z = direction
        across, half = hypot(x, y), 0.5 * self.height
        upper = self.radii[1] * across + half * z >= self.radii[0] * across - half * z
        radius = self.radii[1] if upper else self.radii[0]
        point = (0.0, 0.0, half if upper else -half)
        if across > 0.0:
            point = (radius * x / across, radius * y / across, point[2])
        if self.rounding:
            nx, ny, nz = unit(direction)
            point = (point[0] + self.rounding * nx, point[1] + self.rounding * ny, point[2] + self.rounding * nz)
        return subtract(point, self.centre_of_mass)


def is_straight(shape: ConvexShape) -> TypeGuard[RoundSolid]:
    """Return whether a shape is a cylinder, pipe, sphere or capsule: round, but no cone."""
    return isinstance(shape, RoundSolid) and not shape.tapers


def cylinder(radius: float, height: float, centre_of_mass: Vec3 | None = None) -> RoundSolid:
    """Return a cylinder of uniform density, its axis along z [m]."""
    return frustum(radius, radius, height, centre_of_mass)


def frustum(bottom: float, top: float, height: float, centre_of_mass: Vec3 | None = None) -> RoundSolid:
    """Return the frustum of a cone with the radii of its ends [m]; one of these may be 0. Raises NotASolidError."""
    _require(bottom >= 0.0 and top >= 0.0 and max(bottom, top) > 0.0, "both ends of the cone are points")
    return _with_centre(RoundSolid((bottom, top), height), centre_of_mass)


def pipe(radius: float, wall: float, height: float, centre_of_mass: Vec3 | None = None) -> RoundSolid:
    """Return a pipe by its outer radius and the thickness of its wall [m]. Raises NotASolidError."""
    _require(0.0 < wall < radius, "the wall of the pipe is as thick as its radius or thicker")
    return _with_centre(RoundSolid((radius, radius), height, bore=radius - wall), centre_of_mass)


def sphere(radius: float, centre_of_mass: Vec3 | None = None) -> RoundSolid:
    """Return a sphere of uniform density [m]."""
    return _with_centre(RoundSolid((0.0, 0.0), 0.0, rounding=radius), centre_of_mass)


def capsule(radius: float, height: float, centre_of_mass: Vec3 | None = None) -> RoundSolid:
    """Return a cylinder of a height [m] between two half balls."""
    return _with_centre(RoundSolid((0.0, 0.0), height, rounding=radius), centre_of_mass)


def scaled_round(solid: RoundSolid, factor: float) -> RoundSolid:
    """Return a round solid with all lengths multiplied by a factor."""
    low, high = solid.radii
    return RoundSolid(
        (factor * low, factor * high),
        factor * solid.height,
        factor * solid.rounding,
        factor * solid.bore,
        scale(factor, solid.centre_of_mass),
    )


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise NotASolidError(message, "check its radii")


def _with_centre(solid: RoundSolid, centre_of_mass: Vec3 | None) -> RoundSolid:
    """Return a solid with its centre of mass in the middle of its material, or at a point inside it."""
    if centre_of_mass is not None:
        around = RoundSolid(solid.radii, solid.height, solid.rounding, solid.bore)
        if not _holds(around, centre_of_mass):
            message = "the centre of mass lies outside the solid"
            raise NotASolidError(message, "write a point inside it, relative to the middle of its height")
        centre = centre_of_mass
    else:
        centre = (0.0, 0.0, _middle_height(solid))
    return RoundSolid(solid.radii, solid.height, solid.rounding, solid.bore, centre)


def _holds(solid: RoundSolid, point: Vec3) -> bool:
    """Return whether a point, from the middle between the discs, lies inside the convex surface."""
    (x, y, z), half, (low, high) = point, 0.5 * solid.height, solid.radii
    across = hypot(x, y)
    if low == high == 0.0:
        return hypot(across, max(abs(z) - half, 0.0)) < solid.rounding
    return abs(z) < half and across < low + (high - low) * (z + half) / solid.height


# Mass properties: parts of a solid as (volume, height of the centroid above the middle, square radii of gyration across
# and along the axis through the centroid); the volume of a bore is negative.

Part = tuple[float, float, float, float]


@lru_cache(maxsize=KEPT)
def _parts(solid: RoundSolid) -> tuple[Part, ...]:
    (low, high), height, ball, half = solid.radii, solid.height, solid.rounding, 0.5 * solid.height
    if ball and low == high == 0.0:
        round_ends: Part = (4.0 / 3.0 * pi * ball**3, 0.0, 0.4 * ball**2 + half**2 + 0.75 * half * ball, 0.4 * ball**2)
        return (_frustum_part(ball, ball, height), round_ends) if height else (round_ends,)
    own = _frustum_part(low, high, height)
    if not solid.bore:
        return (own,)
    volume, middle, across, along = _frustum_part(solid.bore, solid.bore, height)
    return own, (-volume, middle, across, along)


def _frustum_part(low: float, high: float, height: float) -> Part:
    """Return the mass properties of a frustum, by integrals of its radius over its height."""
    square = (low**2 + low * high + high**2) / 3.0
    first = (low**2 + 2.0 * low * high + 3.0 * high**2) / 12.0 / square
    second = (low**2 + 3.0 * low * high + 6.0 * high**2) / 30.0 / square
    fourth = (low**4 + low**3 * high + low**2 * high**2 + low * high**3 + high**4) / 5.0 / square
    return (
        pi * height * square,
        height * (first - 0.5),
        0.25 * fourth + height**2 * (second - first**2),
        0.5 * fourth,
    )


def _middle_height(solid: RoundSolid) -> float:
    parts = _parts(RoundSolid(solid.radii, solid.height, solid.rounding, solid.bore))
    return sum(volume * middle for volume, middle, _, _ in parts) / sum(part[0] for part in parts)


@lru_cache(maxsize=KEPT)
def _unit_moments(solid: RoundSolid) -> tuple[float, float]:
    """Return the moments of inertia across and along the axis through the centroid, at a mass of 1 [m2]."""
    centre, parts = _middle_height(solid), _parts(solid)
    total = sum(part[0] for part in parts)
    across = sum(volume * (square + (middle - centre) ** 2) for volume, middle, square, _ in parts) / total
    return across, sum(volume * along for volume, _, _, along in parts) / total


# The drawn polyhedron: rings of corners, or a single corner at a point, from below upwards.

Polyhedron = tuple[tuple[Vec3, ...], tuple[Face, ...], tuple[tuple[int, int], ...]]


@lru_cache(maxsize=KEPT)
def _drawn(solid: RoundSolid) -> Polyhedron:
    corners: list[Vec3] = []
    rings: list[list[int]] = []
    for radius, height in _profile(solid):
        count = SIDES if radius > 0.0 else 1
        angles = [2.0 * pi * side / SIDES for side in range(count)]
        rings.append([len(corners) + number for number in range(count)])
        corners += [subtract((radius * cos(a), radius * sin(a), height), solid.centre_of_mass) for a in angles]
    loops = [tuple(reversed(rings[0])), tuple(rings[-1])]
    for below, above in pairwise(rings):
        for side in range(SIDES):
            after = (side + 1) % SIDES
            quad = (below[side % len(below)], below[after % len(below)], above[after % len(above)])
            loops.append(tuple(dict.fromkeys((*quad, above[side % len(above)]))))
    loops = [loop for loop in loops if len(loop) > 2]  # noqa: PLR2004 -- a face has three corners
    faces = tuple(Face(_normal([corners[corner] for corner in loop]), loop) for loop in loops)
    sides = {tuple(sorted(pair)) for loop in loops for pair in pairwise((*loop, loop[0]))}
    return tuple(corners), faces, tuple(sorted((a, b) for a, b in sides))


def _profile(solid: RoundSolid) -> list[tuple[float, float]]:
    """Return the radii and heights of the rings, from the middle between the discs, from below upwards [m]."""
    half, ball = 0.5 * solid.height, solid.rounding
    if not ball:
        return [(solid.radii[0], -half), (solid.radii[1], half)]
    angles = [pi * (ring / RINGS - 0.5) for ring in range(RINGS + 1)]
    lower = [(ball * cos(a), ball * sin(a) - half) for a in angles[1 : RINGS // 2 + 1]]
    upper = [(ball * cos(a), ball * sin(a) + half) for a in angles[RINGS // 2 if half else RINGS // 2 + 1 : -1]]
    return [(0.0, -half - ball), *lower, *upper, (0.0, half + ball)]


def _normal(points: list[Vec3]) -> Vec3:
    """Return the unit normal of a convex loop, by the sum of the products of its sides (Newell)."""
    x = y = z = 0.0
    for (ax, ay, az), (bx, by, bz) in pairwise((*points, points[0])):
        x += (ay - by) * (az + bz)
        y += (az - bz) * (ax + bx)
        z += (ax - bx) * (ay + by)
    return unit((x, y, z))
