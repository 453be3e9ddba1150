"""Distances of round solids from each other and from polyhedra, by their exact surfaces.

Two convex bodies are separated by the largest gap over all directions. Few directions need a test: the normals of ends
and faces, those of a side that are perpendicular to an edge or to another side, and those from one point to another.
The rims of two bodies, or a rim and an edge, may be separated along other directions only: where all those fail, a
search on the sphere of directions follows.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import sqrt
from operator import itemgetter
from typing import Final, TypeAlias

import numpy as np

from stability.geometry.box_distance import Axes, InBounds
from stability.geometry.polyhedra import Hull, between, vector
from stability.geometry.round_solid import RoundSolid
from stability.geometry.rows import Array
from stability.geometry.vectors import scale
from stability.model import Vec3

PARALLEL: Final = 1e-9  # sine of the angle below which directions count as parallel
TIE: Final = 1e-12  # share of a length: of directions with nearly equal gaps the first is taken
SAMPLES: Final = 128  # of directions of a family
CLOSER: Final = 9  # the same, near the best one
ZOOMS: Final = 16  # of that search
STEPS: Final = 48  # of the search on the sphere
FIRST_STEP: Final = 0.3  # [rad]
COMPASS: Final = 16  # directions of one step
OVERLAP: Final = 1e-9  # share of a length: a smaller overlap needs no search


@dataclass(frozen=True, slots=True, eq=False)
class PlacedRound(InBounds):
    """Round solid at a pose. Vectors are in W, positions relative to the centre of mass."""

    solid: RoundSolid
    p_WC: Vec3  # centre of mass [m]
    axes_W: Axes  # body axes
    axis: Array  # (3,) its axis
    middle: Array  # (3,) the middle between its discs [m]
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    thickness: float  # least thickness [m]
    length: float  # longest side of the box around the solid along its body axes [m]

    def end(self, upper: bool) -> Array:
        """Return the centre of the disc at an end of the axis [m]."""
        half = 0.5 * self.solid.height
        centre: Array = self.middle + (half if upper else -half) * self.axis
        return centre

    def extents(self, normals: Array) -> Array:
        """Return the extents along unit directions (k, 3), from the centre of mass (k,) [m]."""
        along = normals @ self.axis
        across = np.linalg.norm(normals - np.outer(along, self.axis), axis=1)
        low, high = self.solid.radii
        half = 0.5 * self.solid.height
        ends = np.maximum(high * across + half * along, low * across - half * along)
        total: Array = normals @ self.middle + ends + self.solid.rounding
        return total

    def points(self) -> Array:
        """Return the ends of the axis that are no discs, from the centre of mass (k, 3) [m]."""
        ends = [self.end(upper) for upper in (False, True) if self.solid.radii[upper] == 0.0]
        return np.array(ends).reshape(-1, 3)

    def rims(self) -> list[tuple[Array, float]]:
        """Return the centre, from the centre of mass, and the radius of each disc [m]."""
        return [(self.end(upper), self.solid.radii[upper]) for upper in (False, True) if self.solid.radii[upper]]

    def sides_towards(self, points: Array) -> Array:
        """Return the normals of the side in the planes of its axis and of points off the axis (k, 3)."""
        offsets = points - self.middle
        radial = offsets - np.outer(offsets @ self.axis, self.axis)
        lengths = np.linalg.norm(radial, axis=1)
        off = lengths > TIE * (self.length + np.abs(points).max(initial=0.0))
        slope = self.solid.slope
        sides: Array = sqrt(1.0 - slope * slope) * radial[off] / lengths[off, None] + slope * self.axis
        return sides


Convex = PlacedRound | Hull


def placed_round(solid: RoundSolid, p_WC: Vec3, axes_W: Axes) -> PlacedRound:
    """Create the placed solid with this centre of mass [m] and these body axes."""
    turn = np.array(axes_W)
    axis, middle = turn[2], -np.array(solid.centre_of_mass) @ turn
    unbounded = PlacedRound(solid, p_WC, axes_W, axis, middle, p_WC, p_WC, solid.least_thickness, solid.length)
    sides = np.identity(3)
    high, low = unbounded.extents(sides).tolist(), unbounded.extents(-sides).tolist()
    (x, y, z), (a, b, c), (d, e, f) = p_WC, low, high
    return PlacedRound(
        solid,
        p_WC,
        axes_W,
        axis,
        middle,
        (x - a, y - b, z - c),
        (x + d, y + e, z + f),
        solid.least_thickness,
        solid.length,
    )


def extents(body: Convex, normals: Array) -> Array:
    """Return the extents of a body along unit directions (k, 3), from its centre of mass (k,) [m]."""
    if isinstance(body, PlacedRound):
        return body.extents(normals)
    most: Array = (body.corners @ normals.T).max(axis=0)
    return most


def gaps(a: Convex, b: Convex, p_AB: Array, normals: Array) -> Array:
    """Return the gaps of two bodies along unit directions from a towards b (k,) [m]."""
    gap: Array = normals @ p_AB - extents(a, normals) - extents(b, -normals)
    return gap


def separation(a: Convex, b: Convex) -> tuple[float, Vec3]:
    """Return the largest gap of two bodies [m], negative if they overlap, and its unit normal from b towards a."""
    gap, normal = widest_gap(a, b, between_centres(a, b))
    return gap, scale(-1.0, vector(normal))


def between_centres(a: Convex, b: Convex) -> Array:
    """Return the vector from the centre of mass of a to that of b [m]."""
    return between(a, b)  # type: ignore[arg-type]  # it only reads the centres


def widest_gap(a: Convex, b: Convex, p_AB: Array) -> tuple[float, Array]:
    """Return the largest gap of two bodies [m] and its unit normal from a towards b; one of them is round."""
    normals = np.concatenate([*face_normals(a, b), *_others(a, b, p_AB)])
    values = gaps(a, b, p_AB, normals)
    size = a.length + b.length
    best = int(np.flatnonzero(values >= values.max() - TIE * size)[0])
    gap, normal = float(values[best]), normals[best]
    if gap < -OVERLAP * size and _has_rims(a) and not _is_ball(b) and not _is_ball(a):
        # Without a rim all directions of separation are tested above.
        for family in _families(a, b):
            gap, normal = max((gap, normal), _best_of(a, b, p_AB, family), key=itemgetter(0))
        if isinstance(a, PlacedRound) and isinstance(b, PlacedRound):
            return _climbed(a, b, p_AB, normal, gap)
    return gap, normal


# Directions of which one parameter is free, as (part along an axis, two directions across it): those perpendicular to
# an edge, for an edge and a rim, and the normals of a side, for a side and a rim.

Family: TypeAlias = tuple[Array, Array, Array]


def _families(a: Convex, b: Convex) -> Iterator[Family]:
    for body, sign in ((a, 1.0), (b, -1.0)):
        if isinstance(body, Hull):
            for edge in body.directions:
                first = np.cross(edge, np.identity(3)[int(np.abs(edge).argmin())])
                first /= np.linalg.norm(first)
                yield np.zeros(3), first, np.cross(edge, first)
        else:
            slope = body.solid.slope
            across = sqrt(1.0 - slope * slope)
            first, second = np.array(body.axes_W[0]), np.array(body.axes_W[1])
            yield sign * slope * body.axis, sign * across * first, sign * across * second


def _best_of(a: Convex, b: Convex, p_AB: Array, family: Family) -> tuple[float, Array]:
    """Return the largest gap along the directions of a family, and its normal."""
    along, first, second = family
    low, high = 0.0, 2.0 * np.pi
    count = SAMPLES
    for _ in range(ZOOMS):
        angles = np.linspace(low, high, count)
        normals = along + np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)
        values = gaps(a, b, p_AB, normals)
        best = int(values.argmax())
        step = (high - low) / (count - 1)
        low, high, count = angles[best] - step, angles[best] + step, CLOSER
    return float(values[best]), normals[best]


def face_normals(a: Convex, b: Convex) -> Iterator[Array]:
    """Yield the normals, from a towards b, of the faces and ends of both."""
    for body, sign in ((a, 1.0), (b, -1.0)):
        if isinstance(body, Hull):
            yield sign * body.normals
        elif body.solid.height:
            yield np.array([body.axis, -body.axis])


def side_normals(a: Convex, b: Convex, p_AB: Array) -> Array:
    """Return the normals, from a towards b, of the sides of round bodies that meet the other body along a line."""
    rows = []
    for body, other, sign, p_BO in ((a, b, 1.0, p_AB), (b, a, -1.0, -p_AB)):
        if isinstance(body, PlacedRound) and body.solid.height:
            rows.append(sign * body.sides_towards(_marks(other) + p_BO))
    return np.concatenate([np.zeros((0, 3)), *rows])


def _marks(body: Convex) -> Array:
    """Return points of a body in which sides of another may meet it, from its centre of mass [m]."""
    if isinstance(body, Hull):
        return body.corners
    return np.array([body.end(False), body.end(True)])


def _others(a: Convex, b: Convex, p_AB: Array) -> Iterator[Array]:
    """Yield all further directions, from a towards b, that may separate two bodies."""
    yield side_normals(a, b, p_AB)
    for body, other, sign, p_BO in ((a, b, 1.0, p_AB), (b, a, -1.0, -p_AB)):
        if isinstance(body, PlacedRound):
            if isinstance(other, Hull):
                yield sign * _across(body, other.directions)
                yield sign * _from_points(body.points(), other, p_BO)
            elif sign > 0.0:
                yield _of_two_sides(body, other)
                yield _units(other.points()[None, :, :] + p_BO - body.points()[:, None, :])
            if isinstance(other, PlacedRound):
                yield from (sign * _to_rim(body.points(), other, rim, p_BO) for rim in other.rims())
                yield sign * body.sides_towards(other.points() + p_BO)


def _across(body: PlacedRound, directions: Array) -> Array:
    """Return the normals of a side that are perpendicular to edges."""
    axis, slope = body.axis, body.solid.slope
    if not body.solid.height:
        return np.zeros((0, 3))
    part = axis - (directions @ axis)[:, None] * directions
    sines = np.linalg.norm(part, axis=1)
    crossing = sines > max(PARALLEL, abs(slope))
    first = part[crossing] / sines[crossing, None]
    second = np.cross(directions[crossing], first)
    along = slope / sines[crossing]
    beside = np.sqrt(1.0 - along * along)
    return np.concatenate([along[:, None] * first + sign * beside[:, None] * second for sign in (1.0, -1.0)])


def _of_two_sides(a: PlacedRound, b: PlacedRound) -> Array:
    """Return the common normals of two sides, from a towards b."""
    if not (a.solid.height and b.solid.height):
        return np.zeros((0, 3))
    product, cosine = np.cross(a.axis, b.axis), float(a.axis @ b.axis)
    square = float(product @ product)
    if square <= PARALLEL * PARALLEL:
        return np.zeros((0, 3))
    s, t = a.solid.slope, -b.solid.slope
    own, other = (s - t * cosine) / square, (t - s * cosine) / square
    flat = own * a.axis + other * b.axis
    rest = (1.0 - float(flat @ flat)) / square
    if rest < 0.0:
        return np.zeros((0, 3))
    return np.array([flat + sign * sqrt(rest) * product for sign in (1.0, -1.0)])


def _from_points(points: Array, other: Hull, p_BO: Array) -> Array:
    """Return the directions from points to the corners of a hull, and to the feet of perpendiculars on its edges."""
    corners = other.corners + p_BO
    to_corners = corners[None, :, :] - points[:, None, :]
    starts = corners[other.mesh.edges[:, 0]][None, :, :] - points[:, None, :]
    along = np.einsum("ijk,jk->ij", starts, other.directions)
    feet = starts - along[:, :, None] * other.directions[None, :, :]
    return np.concatenate([_units(to_corners), _units(feet)])


def _to_rim(points: Array, other: PlacedRound, rim: tuple[Array, float], p_BO: Array) -> Array:
    """Return the directions from points to the nearest points of a rim of another body."""
    centre, radius = rim
    offsets = points - (centre + p_BO)
    radial = offsets - np.outer(offsets @ other.axis, other.axis)
    lengths = np.linalg.norm(radial, axis=1)
    off = lengths > TIE * other.length
    return _units((radius * radial[off] / lengths[off, None] - offsets[off])[None, :, :])


def _units(rows: Array) -> Array:
    flat = rows.reshape(-1, 3)
    lengths = np.linalg.norm(flat, axis=1)
    longest = lengths.max(initial=0.0)
    apart = lengths > TIE * longest
    units: Array = flat[apart] / lengths[apart, None]
    return units


def _has_rims(body: Convex) -> bool:
    return isinstance(body, Hull) or bool(body.rims())


def _is_ball(body: Convex) -> bool:
    return isinstance(body, PlacedRound) and not body.rims()


def _climbed(a: Convex, b: Convex, p_AB: Array, normal: Array, gap: float) -> tuple[float, Array]:
    """Return the largest gap near a direction and its normal, by ever smaller steps on the sphere of directions."""
    angles = 2.0 * np.pi * np.arange(COMPASS) / COMPASS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    step = FIRST_STEP
    for _ in range(STEPS):
        first = np.cross(normal, np.identity(3)[int(np.abs(normal).argmin())])
        first /= np.linalg.norm(first)
        tried = normal + step * ways @ np.stack([first, np.cross(normal, first)])
        tried /= np.linalg.norm(tried, axis=1)[:, None]
        values = gaps(a, b, p_AB, tried)
        best = int(values.argmax())
        if values[best] > gap:
            gap, normal = float(values[best]), tried[best]
        else:
            step *= 0.5
    return gap, normal


def distance_outside(body: PlacedRound, point_W: Vec3) -> float:
    """Return the distance of a point outside the surface [m]; negative inside."""
    point = np.array(point_W) - np.array(body.p_WC)
    rows = [
        np.array([body.axis, -body.axis]),
        body.sides_towards(point[None, :]),
        _units(point[None, :] - body.points()),
    ]
    for centre, radius in body.rims():
        offset = point - centre
        radial = offset - (offset @ body.axis) * body.axis
        length = np.linalg.norm(radial)
        if length > radius:
            rows.append(_units((offset - radius * radial / length)[None, :]))
    normals = np.concatenate(rows)
    return float((normals @ point - body.extents(normals)).max())


MOST_TRIALS: Final = 60  # of travels on each side
SHARE: Final = 1e-12  # of a length: accepted error of a travel


def passage(moving: Convex, fixed: Convex, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """Return the travel along a unit direction at which a body enters and leaves another [m]; None if it misses it.

    The largest gap is a convex function of the travel, so each of its two roots follows from tangents. An overlap
    across the direction of less than `graze` [m] counts as a miss.
    """
    direction, start = np.array(direction_W), between_centres(moving, fixed)
    size = moving.length + fixed.length

    def gap_at(travel: float) -> tuple[float, float]:
        gap, normal = widest_gap(moving, fixed, start - travel * direction)
        return gap, -float(normal @ direction)

    middle = float(start @ direction)
    low, high = middle - 2.0 * size, middle + 2.0 * size
    for _ in range(MOST_TRIALS):  # the deepest overlap lies where the slope changes its sign
        middle = 0.5 * (low + high)
        gap, slope = gap_at(middle)
        if gap < -graze or slope == 0.0:
            break
        low, high = (middle, high) if slope < 0.0 else (low, middle)
    if gap >= -graze:
        return None
    return _root(gap_at, low, middle, size), _root(gap_at, high, middle, size)


def _root(gap_at: Callable[[float], tuple[float, float]], apart: float, inside: float, size: float) -> float:
    """Return the travel without gap between one apart and one inside, by tangents of a convex function."""
    at = apart
    for _ in range(MOST_TRIALS):
        gap, slope = gap_at(at)
        if abs(gap) <= SHARE * size or slope == 0.0:
            break
        step = at - gap / slope
        at = min(max(step, min(apart, inside)), max(apart, inside))
    return at
