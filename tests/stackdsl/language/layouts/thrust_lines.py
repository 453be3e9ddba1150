"""Does an arch stand, by its line of thrust? A linear programme in three unknowns, and nothing of `stability`.

Model (Heyman's, without an end to friction where none is given): at each joint the force from one side passes between
the inner and the outer end, and presses. All of these follow from that at the first joint and from the weights.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
from scipy.optimize import brentq, linprog, minimize_scalar

MUCH = 1.0  # room that is enough: where a straight line fits into an arch, any force may press along it
Point = tuple[float, float]
MILANKOVITCH = (
    0.10748  # the least thickness of a semicircular arch of many stones, in its mean radii (Milankovitch 1907)
)


def joints_of(span: float, rise: float, thickness: float, stones: int) -> list[tuple[Point, Point]]:
    """The inner and the outer end of each joint, from the left springing to the right one [m]."""
    half = 0.5 * span
    radius = (half * half + rise * rise) / (2.0 * rise)
    middle, opening = rise - radius, 2.0 * np.arcsin(min(1.0, half / radius))
    angles = [0.5 * pi + opening * (0.5 - number / stones) for number in range(stones + 1)]
    return [
        (
            (radius * cos(a), middle + radius * sin(a)),
            ((radius + thickness) * cos(a), middle + (radius + thickness) * sin(a)),
        )
        for a in angles
    ]


def area_and_centre(corners: Sequence[Point]) -> tuple[float, float]:
    """The area of a polygon [m2], and how far to the right its centre is [m]."""
    area = moment = 0.0
    for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
        part = 0.5 * (ax * by - bx * ay)
        area, moment = area + part, moment + part * (ax + bx) / 3.0
    return abs(area), moment / area


def room(joints: Sequence[tuple[Point, Point]], friction: float | None = None) -> float:
    """How much of the joints is left beside the line of thrust: the least moment about an end; less than 0 if none can.

    In weights of the arch times its span, to make numbers near one.
    """
    weights = [area_and_centre([a[0], a[1], b[1], b[0]]) for a, b in pairwise(joints)]
    total = sum(area for area, _ in weights)
    span = joints[-1][1][0] - joints[0][1][0]
    rows, limits = [], []
    # Unknown: the force of the springing on the arch, (h, v) through the origin, its moment there, and the room.
    for number, ((ix, iy), (ox, oy)) in enumerate(joints):
        before = weights[:number]
        weight, moment = sum(a for a, _ in before) / total, sum(a * x for a, x in before) / total
        # The force on what follows is (h, v - weight); its moment about a point p is m - moment_of_weights - p x force.
        for sign, (px, py) in ((1.0, (ox, oy)), (-1.0, (ix, iy))):
            row = np.array((py, -px, 1.0))
            # m + py h - px (v - weight) - (-moment) has one sign about the outer end, the other about the inner one.
            constant = px * weight - moment
            rows.append([*(-sign * row / span), 1.0])
            limits.append(sign * constant / span)
        if friction is not None:
            nx, ny = _normal((ix, iy), (ox, oy))
            for side in (1.0, -1.0):
                tx, ty = side * -ny, side * nx
                rows.append([tx - friction * nx, ty - friction * ny, 0.0, 0.0])
                limits.append(weight * (ty - friction * ny))
    found = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=rows,
        b_ub=limits,
        bounds=[(0.0, None), (None, None), (None, None), (None, MUCH)],
        method="highs",
    )
    return -1.0 if found.x is None else float(found.x[3])


def _normal(inner: Point, outer: Point) -> Point:
    """Of a joint, towards the stones that follow, which are to the right of it going up, unit."""
    dx, dy = outer[0] - inner[0], outer[1] - inner[1]
    length = (dx * dx + dy * dy) ** 0.5
    return (dy / length, -dx / length)


def least_thickness(span: float, rise: float, stones: int, friction: float | None = None) -> float:
    """Below which an arch falls [m]."""
    return float(
        brentq(lambda t: room(joints_of(span, rise, t, stones), friction), 1e-4 * span, 0.3 * span, xtol=1e-10 * span)
    )


def milankovitch(half_angle: float) -> float:
    """The least thickness of an arch of very many stones between springings so far from the crown [rad], in mean radii.

    Closed: it has hinges at the crown and the springings on the outer side, and between them on the inner one, where
    the thrust that they need is greatest (Milankovitch 1907; Cocchetti, Colasante and Rizzi 2011).
    """

    def lacking(thickness: float) -> float:
        inner, outer, centres = 1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness, 1.0 + thickness**2 / 12.0

        def thrust(hinge: float, radius: float) -> float:
            """The level force at the crown that holds the part up to a hinge, in weights of a radian."""
            moment = radius * hinge * sin(hinge) - centres * (1.0 - cos(hinge))
            return moment / (outer - radius * cos(hinge))

        haunch = minimize_scalar(lambda hinge: -thrust(hinge, inner), bounds=(1e-3, half_angle), method="bounded")
        return -float(haunch.fun) - thrust(half_angle, outer)

    return float(brentq(lacking, 1e-6, 0.3, xtol=1e-12))
