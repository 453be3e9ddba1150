"""Compares broadside hits on `exact` with two rigid rectangles in a vertical plane, a reference independent of engines.

A plank comes broadside at the long side of a plank that ends flush with its support. Nothing depends on the position
along the two planks, so the hit is planar: the struck one slides over a floor, and the thrown one follows onto the end
of the floor. Corners are sharp, impacts plastic, friction is Coulomb's; contacts are solved as velocities, by
Gauss-Seidel. Neither geometry nor solver is shared with an engine or with the boxes of this package. Run it with
`python -m benchmarks.moreau.planar_hits`.
"""

from math import cos, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.hits import DISTANCE, GRAVITY
from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH
from benchmarks.turned_hits import FRICTION, TurnedHit, by_impact_law, of_exact

Array = NDArray[np.float64]

STEP = 1e-5  # [s] with four times or a quarter of it, all shifts agree to 0.1 %
LONGEST, AT_REST, ARRIVED = 0.6, 1e-4, 0.03  # [s], [m/s], [s]
# [m] bodies with a larger gap are ignored; bodies with a smaller horizontal overlap do not touch
REACH, HAIR = 1e-3, 1e-9
SWEEPS, SOLVED, RECOVERY = 400, 1e-9, 0.002  # at most, [m/s], [m/s] speed at which an overlap is removed


def shift(speed: float, above: float = 2e-5, floor: bool = True, thrown: float = WIDTH, step: float = STEP) -> float:
    """Return the shift of the struck plank [m]; `above`: height of the thrown plank above level at arrival [m].

    `floor`: whether the support of the struck plank may carry the thrown one too; `thrown`: its length along its path
    [m].
    """
    halves = 0.5 * np.array([[WIDTH, THICKNESS], [thrown, THICKNESS]])
    return float(_shift(speed, above, floor, halves, GRAVITY, FRICTION, DISTANCE, step))


def falls_past(speed: float) -> float:
    """Return the shift [m] of a plank pushed by an equal one that falls past it without rotation: a closed form.

    After a plastic impact both have half of the speed; N = mu m g / (2 - mu^2) decelerates the thrown one, whose fall
    is decelerated by mu N in turn, until it is below by a thickness; from then on the struck one slides alone.
    """
    push = FRICTION / (2.0 - FRICTION**2)  # share of the weight
    half = 0.5 * speed
    past = (2.0 * THICKNESS / (GRAVITY * (1.0 - FRICTION * push))) ** 0.5
    past = min(past, half / (push * GRAVITY))
    after = half - push * GRAVITY * past
    return 0.5 * (half + after) * past + after**2 / (2.0 * FRICTION * GRAVITY)


@njit(cache=True)
def _shift(
    speed: float, above: float, floor: bool, halves: Array, gravity: float, friction: float, distance: float,
    step: float,
) -> float:  # fmt: skip
    moments = (halves[:, 0] ** 2 + halves[:, 1] ** 2) / 3.0  # of bodies of unit mass
    places, speeds = np.zeros((2, 3)), np.zeros((2, 3))  # (y, z, rotation) of the struck and of the thrown plank
    places[0, 0], places[0, 1] = -halves[0, 0], halves[0, 1]
    places[1, 0], places[1, 1] = distance + halves[1, 0], halves[1, 1] + above
    speeds[1, 0], speeds[1, 1] = -speed, 0.5 * gravity * distance / speed
    start, most = places[0].copy(), 0.0
    pairs, points, impulses = np.zeros((40, 2), np.int64), np.zeros((40, 5)), np.zeros((40, 2))
    for number in range(int(LONGEST / step)):
        speeds[:, 1] -= gravity * step
        count = _contacts(places, halves, floor, pairs, points)
        impulses[:] = 0.0
        for _ in range(SWEEPS):
            changed = 0.0
            for c in range(count):
                changed = max(changed, _push(pairs[c], points[c], places, moments, friction, step, speeds, impulses[c]))
            if changed < SOLVED:
                break
        places += step * speeds
        most = max(most, np.hypot(places[0, 0] - start[0], places[0, 1] - start[1]))
        if number * step > ARRIVED and abs(speeds[0, 0]) < AT_REST:
            break
    return most


@njit(cache=True)
def _push(
    pair: Array, point: Array, places: Array, moments: Array, friction: float, step: float, speeds: Array,
    impulse: Array,
) -> float:  # fmt: skip
    """Solve one contact, normal before friction; return the change of velocity there."""
    changed = 0.0
    for direction in range(2):
        axis = (point[2], point[3]) if direction == 0 else (-point[3], point[2])
        speed, answer = 0.0, 0.0
        for side in range(2):
            b = pair[side]
            if b >= 0:
                lever = (point[0] - places[b, 0]) * axis[1] - (point[1] - places[b, 1]) * axis[0]
                own = speeds[b, 0] * axis[0] + speeds[b, 1] * axis[1] + speeds[b, 2] * lever
                speed += own if side == 0 else -own
                answer += 1.0 + lever * lever / moments[b]
        if direction == 0:
            gap = point[4]
            wanted = -gap / step if gap > 0.0 else min(-0.1 * gap / step, RECOVERY)
            after = max(0.0, impulse[0] + (wanted - speed) / answer)
        else:
            limit = friction * impulse[0]
            after = min(limit, max(-limit, impulse[1] - speed / answer))
        more = after - impulse[direction]
        impulse[direction] = after
        changed = max(changed, abs(more) * answer)
        for side in range(2):
            b = pair[side]
            if b >= 0:
                lever = (point[0] - places[b, 0]) * axis[1] - (point[1] - places[b, 1]) * axis[0]
                signed = more if side == 0 else -more
                speeds[b, 0] += signed * axis[0]
                speeds[b, 1] += signed * axis[1]
                speeds[b, 2] += signed * lever / moments[b]
    return changed


@njit(cache=True)
def _contacts(places: Array, halves: Array, floor: bool, pairs: Array, points: Array) -> int:
    """Fill the bodies (-1: the floor) and points (y, z, normal onto the first body, gap); return their number."""
    count = 0
    for b in range(2):
        for corner in range(4):
            y, z = _corner(places[b], halves[b], corner)
            if b == 0:  # it lies on the floor, and moves away from its end
                count = _add(pairs, points, count, 0, -1, y, z, 0.0, 1.0, z)
            elif floor and y <= 0.0:
                count = _add(pairs, points, count, 1, -1, y, z, 0.0, 1.0, z)
            elif floor and z < 0.0:
                count = _add(pairs, points, count, 1, -1, y, z, 1.0, 0.0, y)
            # A corner touches the face of the other body with the least overlap, within the ends of the face.
            other = 1 - b
            u, v = _within(places[other], y, z)
            beside, over = abs(u) - halves[other, 0], abs(v) - halves[other, 1]
            c, s = cos(places[other, 2]), sin(places[other, 2])
            if beside >= over - 1e-7 and over < HAIR:
                way = 1.0 if u > 0.0 else -1.0
                count = _add(pairs, points, count, b, other, y, z, way * c, way * s, beside)
            elif over > beside and beside < -HAIR:
                way = 1.0 if v > 0.0 else -1.0
                count = _add(pairs, points, count, b, other, y, z, -way * s, way * c, over)
    if floor:  # the end of the floor, against the lower and the front face of the thrown body
        u, v = _within(places[1], 0.0, 0.0)
        beside, over = abs(u) - halves[1, 0], abs(v) - halves[1, 1]
        c, s = cos(places[1, 2]), sin(places[1, 2])
        if over >= beside and beside < -HAIR and v < 0.0:
            count = _add(pairs, points, count, 1, -1, 0.0, 0.0, -s, c, over)
        elif beside > over and over < -HAIR and u < 0.0:
            count = _add(pairs, points, count, 1, -1, 0.0, 0.0, c, s, beside)
    return count


@njit(cache=True)
def _add(
    pairs: Array, points: Array, count: int, a: int, b: int, y: float, z: float, n_y: float, n_z: float, gap: float
) -> int:
    if abs(gap) >= REACH:
        return count
    pairs[count, 0], pairs[count, 1] = a, b
    points[count, 0], points[count, 1], points[count, 2], points[count, 3], points[count, 4] = y, z, n_y, n_z, gap
    return count + 1


@njit(cache=True)
def _corner(place: Array, half: Array, number: int) -> tuple[float, float]:
    u = half[0] if number in (0, 3) else -half[0]
    v = half[1] if number < 2 else -half[1]
    c, s = cos(place[2]), sin(place[2])
    return place[0] + c * u - s * v, place[1] + s * u + c * v


@njit(cache=True)
def _within(place: Array, y: float, z: float) -> tuple[float, float]:
    """Return a point in the axes of a body."""
    c, s = cos(place[2]), sin(place[2])
    y, z = y - place[0], z - place[1]
    return c * y + s * z, -s * y + c * z


def main() -> None:
    """Print broadside hits by all references, and the closed form for a thrown plank that falls past."""
    table = Table(
        "m/s", "planar, mm", "impact law, mm", "exact, mm", "falls past: end-on, planar", "in one piece, by hand"
    )
    for speed in (0.5, 1.0, 1.5):
        hit = TurnedHit(90.0, speed, above=5e-4)
        planar = shift(speed, above=5e-4)
        found = (
            planar,
            by_impact_law(hit, 8000),
            of_exact(hit),
            shift(speed, floor=False, thrown=LENGTH),
            falls_past(speed),
        )
        table.add_row(f"{speed:g}", *(f"{1000.0 * value:.2f}" for value in found))
    Console(width=130).print(table)


if __name__ == "__main__":
    main()
