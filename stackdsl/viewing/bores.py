"""Pipes as they are drawn: with their bore, which their convex shape for contacts leaves out."""

from itertools import product
from math import cos, pi, sin

from stability.geometry.round_solid import SIDES, RoundSolid
from stability.geometry.vectors import subtract
from stability.model import ConvexShape, Vec3

Ring = tuple[Vec3, ...]  # counter-clockwise from above [m]


def bore_rims(shape: ConvexShape) -> tuple[Ring, ...]:
    """Return the rims of a bore at the lower and the upper end, from the centre of mass; none without a bore."""
    if not isinstance(shape, RoundSolid) or not shape.bore:
        return ()
    return tuple(_ring(shape, shape.bore, height) for height in (-0.5 * shape.height, 0.5 * shape.height))


def surface_of_pipe(pipe: RoundSolid) -> tuple[tuple[Vec3, ...], tuple[tuple[int, int, int, int], ...]]:
    """Return corners and faces of both walls and both ends, counter-clockwise from outside of the material.

    The ends have their own corners, so that viewers which smooth the walls draw the ends flat.
    """
    half = 0.5 * pipe.height
    low, high = (_ring(pipe, pipe.widest, height) for height in (-half, half))
    inner_low, inner_high = bore_rims(pipe)
    bands = ((low, high), (inner_high, inner_low), (inner_low, low), (high, inner_high))
    corners = tuple(corner for band in bands for ring in band for corner in ring)
    faces = []
    for band, side in product(range(len(bands)), range(SIDES)):
        first, after = 2 * SIDES * band, (side + 1) % SIDES
        faces.append((first + side, first + after, first + SIDES + after, first + SIDES + side))
    return corners, tuple(faces)


def _ring(pipe: RoundSolid, radius: float, height: float) -> Ring:
    angles = [2.0 * pi * side / SIDES for side in range(SIDES)]
    return tuple(subtract((radius * cos(a), radius * sin(a), height), pipe.centre_of_mass) for a in angles)
