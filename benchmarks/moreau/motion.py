"""Moves rigid boxes on the ground by steps of equal length: Moreau's time stepping, until all are at rest.

Velocities are updated first, with gravity, impacts and friction of the whole step at once; then positions. A gap that
would close within a step is closed by exactly this step, so overlaps arise only from the rotation within one step.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from benchmarks.moreau.box_contacts import MOST, Array, dot, touching
from benchmarks.moreau.impact_law import solve
from stability.geometry.box import Box
from stability.model import Pose, Vec3
from stability.problem import Placed

# For rigid bodies the load of a plank on two others is not uniquely shared, and so neither is its friction: shares from
# an impact then persist. Wood is slightly elastic, which makes the shares unique: the stiffness of a point [N/m], and
# the time in which it settles [s]. With ten times the stiffness, a hit differs by 3 %.
STIFFNESS, RELAXATION = 2e6, 5e-4
FASTEST_RECOVERY = 0.01  # [m/s] speed at which an overlap is removed
NEAR = 0.0005  # [m] contacts with a larger gap than this, plus the part closed in a step, are ignored
TOLERANCE = 0.01  # accuracy of the impact law, as a share of the velocity by gravity in a step
SWEEPS = 1000  # at most


@dataclass
class Boxes:
    """Boxes under gravity on the ground z = 0, with one coefficient of friction."""

    placed: Sequence[Placed]
    gravity: float  # [m/s2]
    friction: float
    places: Array = field(init=False)  # (n, 3) [m]
    turns: Array = field(init=False)  # (n, 3, 3), from body axes to W
    speeds: Array = field(init=False)  # (n, 6): velocity [m/s], angular velocity [rad/s], W
    halves: Array = field(init=False)  # (n, 3) [m]
    masses: Array = field(init=False)  # [kg]
    stiffness: float = STIFFNESS  # of a contact point [N/m]
    unsolved: int = field(default=0, init=False)  # steps whose impact law was not solved to the tolerance
    _kept: Array = field(init=False)  # of the last step: bodies, point, impulse in W

    def __post_init__(self) -> None:
        self.places = np.array([one.pose.position_W for one in self.placed])
        self.turns = np.array([_matrix(one.pose) for one in self.placed])
        self.speeds = np.zeros((len(self.placed), 6))
        self.halves = np.array([0.5 * np.array(_size(one)) for one in self.placed])
        self.masses = np.array([one.brick.mass for one in self.placed])
        self._kept = np.zeros((0, 8))

    def throw(self, number: int, velocity_W: Vec3) -> None:
        """Set the velocity of a box."""
        self.speeds[number, :3] = velocity_W

    def put(self, number: int, position_W: Vec3) -> None:
        """Move a box to a place, at rest."""
        self.places[number], self.speeds[number] = position_W, 0.0

    def step(self, duration: float) -> None:
        """Advance by a duration [s]."""
        self._kept, sweeps = _step(
            self.places, self.turns, self.speeds, self.halves, self.masses, self.gravity, self.friction, duration,
            self.stiffness, TOLERANCE * self.gravity * duration, self._kept,
        )  # fmt: skip
        self.unsolved += sweeps >= SWEEPS

    def fastest(self, but: int) -> float:
        """Return the speed of the fastest of all boxes except one [m/s], including the tips of rotating boxes."""
        radius = np.linalg.norm(self.halves, axis=1)
        all_of_them = np.linalg.norm(self.speeds[:, :3], axis=1) + radius * np.linalg.norm(self.speeds[:, 3:], axis=1)
        return float(np.delete(all_of_them, but).max())


# A thrown box: until all others rest again.

SETTLED, QUIET, AT_REST, LONGEST = 0.01, 0.03, 0.002, 1.0  # [s], [s], [m/s], [s]


def shifts_by_throw(boxes: Boxes, velocity_W: Vec3, arrives: float, steps: int, longest: float = LONGEST) -> Array:
    """Throw the last box at the others, and return their largest shifts [m], at a number of steps per second.

    It arrives after `arrives` [s]. The loads of the others settle before the throw. The boxes end at their last places.
    """
    thrown, step = len(boxes.placed) - 1, 1.0 / steps
    start = boxes.placed[thrown].pose.position_W
    for _ in range(round(SETTLED * steps)):
        boxes.step(step)
        boxes.put(thrown, start)
    began, most, quiet = boxes.places.copy(), np.zeros(thrown), 0.0
    # Half a step of gravity more, so that the discrete path follows the parabola.
    boxes.throw(thrown, (*velocity_W[:2], velocity_W[2] + 0.5 * boxes.gravity * step))
    for number in range(round(longest * steps)):
        boxes.step(step)
        most = np.maximum(most, np.linalg.norm((boxes.places - began)[:thrown], axis=1))
        quiet = quiet + step if boxes.fastest(but=thrown) < AT_REST else 0.0
        if quiet > QUIET and number * step > 3.0 * arrives:
            break
    return most


def _size(one: Placed) -> Vec3:
    if not isinstance(one.brick.shape, Box):
        raise TypeError(f"{one.brick.id}: the reference moves boxes only")
    return one.brick.shape.size


def _matrix(pose: Pose) -> Array:
    x, y, z, w = pose.orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@njit(cache=True)
def _step(
    places: Array, turns: Array, speeds: Array, halves: Array, masses: Array, gravity: float, friction: float,
    duration: float, stiffness: float, tolerance: float, kept: Array,
) -> tuple[Array, int]:  # fmt: skip
    bodies = len(places)
    inverse_mass, inverse_inertia = 1.0 / masses, np.zeros((bodies, 3, 3))
    for b in range(bodies):
        x, y, z = halves[b]
        moments = masses[b] / 3.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
        inverse_inertia[b] = (turns[b] / moments) @ turns[b].T
        spin = speeds[b, 3:].copy()
        momentum = (turns[b] * moments) @ (turns[b].T @ spin)
        speeds[b, 3:] -= duration * (inverse_inertia[b] @ np.cross(spin, momentum))
        speeds[b, 2] -= duration * gravity
    most = 64 * bodies
    pairs, points, gaps = np.zeros((most, 2), np.int64), np.zeros((most, 6)), np.zeros(most)
    count = _contacts(places, turns, speeds, halves, duration, pairs, points, gaps)
    softness = 1.0 / (duration * stiffness * (duration + RELAXATION))
    frames, arms, wanted = np.zeros((count, 3, 3)), np.zeros((count, 2, 3)), np.zeros(count)
    impulses = np.zeros((count, 3))
    for c in range(count):
        normal = points[c, 3:6]
        least = np.argmin(np.abs(normal))
        other = np.zeros(3)
        other[least] = 1.0
        first = np.cross(normal, other)
        first = first / np.sqrt(dot(first, first))
        frames[c, 0], frames[c, 1], frames[c, 2] = normal, first, np.cross(normal, first)
        for s in range(2):
            if pairs[c, s] >= 0:
                arms[c, s] = points[c, 0:3] - places[pairs[c, s]]
        deep = gaps[c] < 0.0
        wanted[c] = min(-gaps[c] / (duration + RELAXATION), FASTEST_RECOVERY) if deep else -gaps[c] / duration
        nearest, found = 1e-6, -1
        for k in range(len(kept)):
            if kept[k, 0] == pairs[c, 0] and kept[k, 1] == pairs[c, 1]:
                off = kept[k, 2:5] - points[c, 0:3]
                if dot(off, off) < nearest:
                    nearest, found = dot(off, off), k
        if found >= 0:
            impulses[c] = frames[c] @ kept[found, 5:8]
    sweeps = solve(
        pairs[:count], frames, arms, wanted, softness, friction, inverse_mass, inverse_inertia, speeds, impulses,
        tolerance, SWEEPS,
    )  # fmt: skip
    remembered = np.zeros((count, 8))
    for c in range(count):
        remembered[c, 0], remembered[c, 1] = pairs[c, 0], pairs[c, 1]
        remembered[c, 2:5] = points[c, 0:3]
        remembered[c, 5:8] = frames[c].T @ impulses[c]
    for b in range(bodies):
        places[b] += duration * speeds[b, :3]
        turns[b] = _turned(speeds[b, 3:] * duration) @ turns[b]
    return remembered, sweeps


@njit(cache=True)
def _contacts(
    places: Array, turns: Array, speeds: Array, halves: Array, duration: float, pairs: Array, points: Array, gaps: Array
) -> int:
    bodies, count = len(places), 0
    around, reaches = np.zeros((bodies, 3)), np.zeros(bodies)
    for b in range(bodies):
        around[b] = np.abs(turns[b]) @ halves[b]
        radius = np.sqrt(dot(halves[b], halves[b]))
        speed = np.sqrt(dot(speeds[b, :3], speeds[b, :3])) + radius * np.sqrt(dot(speeds[b, 3:], speeds[b, 3:]))
        reaches[b] = NEAR + 1.5 * speed * duration
    found = np.zeros((MOST, 7))
    for b in range(bodies):
        if places[b, 2] - around[b, 2] < reaches[b]:
            for corner in range(8):
                at = places[b].copy()
                for k in range(3):
                    at += turns[b][:, k] * (halves[b, k] if corner >> k & 1 else -halves[b, k])
                if at[2] < reaches[b]:
                    pairs[count, 0], pairs[count, 1] = -1, b
                    points[count, 0:3] = at
                    points[count, 5] = 1.0
                    gaps[count] = at[2]
                    count += 1
        for other in range(b + 1, bodies):
            reach = max(reaches[b], reaches[other])
            near = True
            for k in range(3):
                near = near and abs(places[b, k] - places[other, k]) < around[b, k] + around[other, k] + reach
            if near:
                filled = touching(
                    places[b], turns[b], halves[b], places[other], turns[other], halves[other], reach, found
                )
                for k in range(filled):
                    pairs[count, 0], pairs[count, 1] = b, other
                    points[count] = found[k, 0:6]
                    gaps[count] = found[k, 6]
                    count += 1
    return count


@njit(cache=True)
def _turned(by: Array) -> Array:
    """Return the matrix of a rotation vector (Rodrigues)."""
    angle = np.sqrt(dot(by, by))
    k = np.array([[0.0, -by[2], by[1]], [by[2], 0.0, -by[0]], [-by[1], by[0], 0.0]])
    if angle < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(angle) / angle * k + (1.0 - np.cos(angle)) / (angle * angle) * (k @ k)
