"""Sections 3.3.3 and 3.3.4 of the thesis step by step, against hulls in plan (docs/design/contacts.md).

The text is followed with z upright: gift wrapping seen from above, a mesh over what it finds, and a ray straight down.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf
from random import Random

import pytest

from stability.geometry.polygons import Point2, straightened
from stability.model import Vec3
from stability.stabilizers.published.support import lies_above, plan_hull

SEEDS = range(200)


def left_of(point: Vec3, start: Vec3, end: Vec3) -> float:
    """Positive to the left of a line seen from above."""
    return (end[0] - start[0]) * (point[1] - start[1]) - (end[1] - start[1]) * (point[0] - start[0])


def gift_wrapped(points: Sequence[Vec3], random: Random) -> list[Vec3]:
    """Return the periphery from the point of lowest x; clockwise, as points to the left of an edge come first."""
    first = min(points)
    periphery = [first]
    while True:
        last = periphery[-1]
        test = random.choice([point for point in points if point[:2] != last[:2]])
        for point in points:
            if left_of(point, last, test) > 0.0:
                test = point
        if test == first:
            return periphery
        periphery.append(test)


def ray_meets_mesh(x: float, y: float, periphery: Sequence[Vec3]) -> bool:
    """A ray straight down, against the fan of triangles about the first corner."""
    return any(height(x, y, (periphery[0], b, c)) > -inf for b, c in pairwise(periphery[1:]))


def height(x: float, y: float, triangle: tuple[Vec3, Vec3, Vec3]) -> float:
    """Where a vertical line goes through a triangle; -inf if it goes past."""
    a, b, c = triangle
    foot = (x, y, 0.0)
    parts = [left_of(foot, b, c), left_of(foot, c, a), left_of(foot, a, b)]
    whole = left_of(c, a, b)
    if whole == 0.0 or any(part / whole < 0.0 for part in parts):
        return -inf
    return sum(part / whole * corner[2] for part, corner in zip(parts, triangle, strict=True))


def scattered(random: Random) -> list[Vec3]:
    """Contact points on supports of different heights [m]."""
    return [(random.uniform(-0.06, 0.06), random.uniform(-0.02, 0.02), random.uniform(0.0, 0.02)) for _ in range(8)]


def flush(random: Random) -> list[Vec3]:
    """Two squares with edges in line, as under a plank of a four-stack, and points amid their edges [m]."""
    sides, along = (-0.0117, 0.0, 0.0117), (-0.0588, -0.0354, 0.0354, 0.0588)
    points = [(x, y, 0.0078) for x in along for y in sides]
    random.shuffle(points)
    return points


def seen_from_above(periphery: Sequence[Vec3]) -> tuple[Point2, ...]:
    """Counter-clockwise, and without points amid an edge."""
    return straightened(tuple((x, y) for x, y, _ in reversed(periphery)))


def cases() -> Iterator[tuple[int, list[Vec3]]]:
    for seed in SEEDS:
        yield seed, scattered(Random(seed))
        yield seed, flush(Random(seed))


def test_gift_wrapping_finds_the_hull_that_is_taken() -> None:
    for seed, points in cases():
        assert set(seen_from_above(gift_wrapped(points, Random(seed)))) == set(plan_hull(points))


def test_a_ray_meets_a_mesh_that_is_not_planar_where_the_hull_lies_below() -> None:
    met = 0
    for seed, points in cases():
        random = Random(seed)
        periphery = gift_wrapped(points, random)
        for _ in range(20):
            x, y = random.uniform(-0.07, 0.07), random.uniform(-0.03, 0.03)
            assert ray_meets_mesh(x, y, periphery) is lies_above((x, y), plan_hull(points))
            met += ray_meets_mesh(x, y, periphery)
    assert met > len(SEEDS)  # cases on both sides


def test_the_mesh_of_bricks_at_different_heights_is_not_planar() -> None:
    periphery = gift_wrapped(scattered(Random(1)), Random(1))
    x, y = (sum(corner[axis] for corner in periphery) / len(periphery) for axis in (0, 1))
    heights = {
        max(height(x, y, (turned[0], b, c)) for b, c in pairwise(turned[1:]))
        for turned in (periphery, [*periphery[1:], periphery[0]])
    }
    assert min(heights) != pytest.approx(max(heights), abs=1e-4)
