"""Bricks that lie flat, in many samples of one design at once: where each lies, and whether two overlap in plan.

A box lies flat if one of its axes is upright. In plan it is a rectangle, turned; everything here is plan geometry, and
arrays have a row a brick and a column a sample, so that what is asked of one brick is asked of all samples together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]

SQUARE = sqrt(0.5)  # cosine of the angle from which the other side of a rectangle is the nearer one
THIN = 0.01  # of the least half length: a patch is not taken to be thinner


@dataclass(slots=True)
class FlatSamples:
    """Boxes in many samples; a row a brick, a column a sample."""

    half: Sequence[tuple[float, float]]  # by brick [m]
    x: Array  # of the centre, in plan [m]
    y: Array
    cos: Array  # of the turn from +x to the first level axis
    sin: Array

    def inside(self, bricks: Sequence[int], x: Array, y: Array) -> Mask:
        """Whether points in plan, a row a brick, lie within the outlines of these bricks, borders included."""
        rows = list(bricks)
        dx, dy, cos, sin = x - self.x[rows], y - self.y[rows], self.cos[rows], self.sin[rows]
        half = np.array([self.half[brick] for brick in rows]).reshape(-1, 2)
        return (np.abs(dx * cos + dy * sin) <= half[:, :1]) & (np.abs(dy * cos - dx * sin) <= half[:, 1:])

    def patch(self, upper: int, lower: int) -> tuple[Array, Array, Array]:
        """About where two outlines overlap: its middle along the axes of the upper one, seen from there [m].

        And the mean square of how far its points are from there along an axis [m2]. Exact where their sides are
        parallel. If `lower` is negative, it has no outline, and all of the upper one is meant.
        """
        one, two = self.half[upper]
        none = np.zeros_like(self.x[upper])
        if lower < 0:
            return none, none, none + (one * one + two * two) / 6.0
        cos, sin = self.cos[upper], self.sin[upper]
        dx, dy = self.x[lower] - self.x[upper], self.y[lower] - self.y[upper]
        along, across = dx * cos + dy * sin, dy * cos - dx * sin
        alike = np.abs(cos * self.cos[lower] + sin * self.sin[lower]) >= SQUARE
        first, second = self.half[lower]
        low, high = _common(one, along, np.where(alike, first, second))
        left, right = _common(two, across, np.where(alike, second, first))
        square = ((high - low) ** 2 + (right - left) ** 2) / 24.0
        return 0.5 * (low + high), 0.5 * (left + right), np.maximum(square, (THIN * min(one, two)) ** 2)


def _common(half: float, middle: Array, other: Array) -> tuple[Array, Array]:
    """Both ends of what two stretches have in common, of which one is about 0."""
    return np.maximum(-half, middle - other), np.minimum(half, middle + other)


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A rectangle in plan, in every sample."""

    half: tuple[float, float]
    x: Array
    y: Array
    cos: Array
    sin: Array


def outlines_overlap(a: Outline, b: Outline) -> Array:
    """How far two rectangles reach into each other along the axis along which that is least [m]; negative apart."""
    dx, dy = b.x - a.x, b.y - a.y
    turn_cos = np.abs(a.cos * b.cos + a.sin * b.sin)
    turn_sin = np.abs(a.cos * b.sin - a.sin * b.cos)
    depths = [
        a.half[0] + b.half[0] * turn_cos + b.half[1] * turn_sin - np.abs(dx * a.cos + dy * a.sin),
        a.half[1] + b.half[0] * turn_sin + b.half[1] * turn_cos - np.abs(dy * a.cos - dx * a.sin),
        b.half[0] + a.half[0] * turn_cos + a.half[1] * turn_sin - np.abs(dx * b.cos + dy * b.sin),
        b.half[1] + a.half[0] * turn_sin + a.half[1] * turn_cos - np.abs(dy * b.cos - dx * b.sin),
    ]
    least: Array = np.minimum.reduce(depths)
    return least
