"""Contact points of boxes with each other and with half-spaces: corners on faces, and crossing edges.

It is independent of `stability`, whose motion it verifies. It is compiled by numba, as it runs at every step.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., Any])

MOST_POINTS = 400  # contact points at the same time
NEAR = 2e-4  # [m] gap up to which bodies may meet within a step
DEEP = 2e-3  # [m] a corner with a larger overlap does not lie on a face
GRAZING = 1e-9  # sine, or share of a half length: accepted distance of a point beside a face
PARALLEL = 1e-6  # sine: edges with a smaller angle do not cross
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


class Bodies(NamedTuple):
    """Boxes with their poses and motions."""

    half: Array
    mass: Array
    position: Array
    turn: Array
    velocity: Array
    spin: Array
    inverse: Array  # (n, 3, 3) inverse inertia about the centre, in W


class Planes(NamedTuple):
    """Half-spaces."""

    point: Array
    normal: Array
    friction: Array


class Points(NamedTuple):
    """Contact points: `body` touches `on` (-1: a plane); the normal points from `on` to `body`."""

    on: Ints
    body: Ints
    point: Array
    normal: Array
    gap: Array
    friction: Array
    key: Ints  # identifies the pair of features in all steps
    impulse: Array  # (c, 3) normal and two tangents


def compiled(function: Function) -> Function:
    """Return the function as machine code."""
    return cast("Function", njit(cache=True)(function))


@compiled
def contacts(bodies: Bodies, planes: Planes, friction: float) -> Points:
    """Return all points at which boxes touch or may touch within a step, without impulses."""
    points = Points(
        np.zeros(MOST_POINTS, np.int64),
        np.zeros(MOST_POINTS, np.int64),
        np.zeros((MOST_POINTS, 3)),
        np.zeros((MOST_POINTS, 3)),
        np.zeros(MOST_POINTS),
        np.full(MOST_POINTS, friction),
        np.zeros(MOST_POINTS, np.int64),
        np.zeros((MOST_POINTS, 3)),
    )
    n, count = len(bodies.mass), 0
    for i in range(n):
        count = _on_planes(bodies, planes, i, points, count)
        for j in range(n):
            reach = np.sqrt(np.sum(bodies.half[i] ** 2)) + np.sqrt(np.sum(bodies.half[j] ** 2)) + NEAR
            if i == j or np.sum((bodies.position[i] - bodies.position[j]) ** 2) > reach**2:
                continue
            count = _corners_on_faces(bodies, i, j, points, count)
            if i < j:
                count = _crossing_edges(bodies, i, j, points, count)
    return Points(
        points.on[:count],
        points.body[:count],
        points.point[:count],
        points.normal[:count],
        points.gap[:count],
        points.friction[:count],
        points.key[:count],
        points.impulse[:count],
    )


@compiled
def _on_planes(bodies: Bodies, planes: Planes, i: int, points: Points, count: int) -> int:
    for c in range(8):
        corner = bodies.position[i] + bodies.turn[i] @ (CORNERS[c] * bodies.half[i])
        for p in range(len(planes.friction)):
            height = np.sum((corner - planes.point[p]) * planes.normal[p])
            if height < NEAR:
                points.on[count], points.body[count], points.key[count] = -1, i, ((i * 64 + p) * 8 + c) * 4
                points.point[count], points.normal[count] = corner, planes.normal[p]
                points.gap[count], points.friction[count] = height, planes.friction[p]
                count += 1
    return count


@compiled
def _corners_on_faces(bodies: Bodies, i: int, j: int, points: Points, count: int) -> int:
    """Add the corners of j that lie on faces of i, each on the face with the least overlap."""
    for c in range(8):
        corner = bodies.position[j] + bodies.turn[j] @ (CORNERS[c] * bodies.half[j])
        local = bodies.turn[i].T @ (corner - bodies.position[i])
        out = np.abs(local) - bodies.half[i]
        axis = np.argmax(out)
        gap = out[axis]
        out[axis] = 0.0
        if np.max(out / bodies.half[i]) > GRAZING or gap > NEAR or gap < -DEEP:
            continue
        points.on[count], points.body[count], points.key[count] = i, j, (((i + 1) * 100 + j + 1) * 8 + c) * 4 + 1
        points.point[count], points.normal[count] = corner, np.sign(local[axis]) * bodies.turn[i][:, axis]
        points.gap[count] = gap
        count += 1
    return count


@compiled
def _crossing_edges(bodies: Bodies, i: int, j: int, points: Points, count: int) -> int:
    for a in range(12):
        for b in range(12):
            found, where, gap, normal = _crossing(bodies, (i, a), (j, b))
            if found and abs(gap) < NEAR:
                points.on[count], points.body[count] = i, j
                points.key[count] = (((i + 1) * 100 + j + 1) * 144 + a * 12 + b) * 4 + 2
                points.point[count], points.normal[count], points.gap[count] = where, normal, gap
                count += 1
    return count


@compiled
def _crossing(bodies: Bodies, one: tuple[int, int], other: tuple[int, int]) -> tuple[bool, Array, float, Array]:
    """Return the crossing of two edges, unless a face of one of the boxes lies between them."""
    nowhere, axis_a, axis_b = np.zeros(3), one[1] // 4, other[1] // 4
    turn_a, turn_b, half_a, half_b = (
        bodies.turn[one[0]],
        bodies.turn[other[0]],
        bodies.half[one[0]],
        bodies.half[other[0]],
    )
    u, v = np.ascontiguousarray(turn_a[:, axis_a]), np.ascontiguousarray(turn_b[:, axis_b])
    across = np.cross(u, v)
    sine = np.sqrt(np.sum(across**2))
    if sine < PARALLEL:
        return False, nowhere, 0.0, nowhere
    sign_a, sign_b = _signs(axis_a, one[1] % 4), _signs(axis_b, other[1] % 4)
    # The normal must lie between the normals of the two faces at the edge of each box.
    normal = np.sign(np.sum(across * (turn_a @ sign_a))) * across / sine
    if np.min(sign_a * (turn_a.T @ normal)) < -GRAZING or np.max(sign_b * (turn_b.T @ normal)) > GRAZING:
        return False, nowhere, 0.0, nowhere
    mid_a = bodies.position[one[0]] + turn_a @ (sign_a * half_a)
    mid_b = bodies.position[other[0]] + turn_b @ (sign_b * half_b)
    apart = mid_b - mid_a
    cosine, along_u, along_v = np.sum(u * v), np.sum(apart * u), np.sum(apart * v)
    s, t = (along_u - cosine * along_v) / sine**2, (cosine * along_u - along_v) / sine**2
    if abs(s) > half_a[axis_a] * (1.0 + GRAZING) or abs(t) > half_b[axis_b] * (1.0 + GRAZING):
        return False, nowhere, 0.0, nowhere
    return True, 0.5 * (mid_a + s * u + mid_b + t * v), np.sum(apart * normal), normal


@compiled
def _signs(axis: int, number: int) -> Array:
    signs = np.zeros(3)
    signs[(axis + 1) % 3] = 1.0 if number % 2 else -1.0
    signs[(axis + 2) % 3] = 1.0 if number // 2 else -1.0
    return signs
