"""Time stepping of rigid boxes with Coulomb friction: the reference for slips and falls.

Moreau's time stepping: velocities after a step and impulses in it obey Signorini's and Coulomb's laws at every contact
point (no restitution; the gap may close within the step), solved by projected Gauss-Seidel; then positions follow from
the new velocities. The error is of first order in the step, so half the step shows its size. Points are corners on
faces and crossing edges, each with its own gap. Source: Stewart and Trinkle (1996), Moreau (1999).

This verifies `stability.dynamics`, so it is independent of it: nothing is imported from `stability`.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.box_contacts import CORNERS, Array, Bodies, Planes, Points, compiled, contacts

SWEEPS = 3_000  # at most, of Gauss-Seidel
# [m/s] Largest speed at which overlapping boxes separate. A corner that slips past an edge suddenly lies on a face,
# micrometres deep; removing this overlap within a step would throw it off, the faster the shorter the step.
RECOVERY = 1e-3
SETTLED = 1e-8  # change of an impulse in a sweep, as a share of the largest
STUCK, CREEPS = 0.1, 1e-6  # [s], [m]: a box that moves less in this time is at rest
SIDEWAYS = 0.7  # cosine: a normal closer than that to an axis takes another axis as the reference of its tangents


@dataclass(frozen=True, slots=True)
class Boxes:
    """Boxes at rest, and the half-spaces that they may touch."""

    half: Array  # (n, 3) half lengths along the body axes [m]
    mass: Array  # (n,) [kg]
    position: Array  # (n, 3) of centres [m]
    turn: Array  # (n, 3, 3) body axes, by columns
    plane_point: Array  # (m, 3) [m]
    plane_normal: Array  # (m, 3) unit, outward
    plane_friction: Array  # (m,)
    friction: float  # between boxes
    gravity: float = 9.81  # [m/s2]


@dataclass(frozen=True, slots=True)
class Course:
    """Result, step by step."""

    time: Array  # (steps,) [s]
    moved: Array  # (steps, n) largest displacement of a corner of each box [m]
    turned: Array  # (steps, n) rotation of each box [rad]
    position: Array  # (steps, n, 3) of centres [m]
    unsettled: int  # steps whose sweeps did not converge


def course(boxes: Boxes, step: float, until: float, far: float = np.inf, turned: float = np.inf) -> Course:
    """Compute the motion from rest, with a time step [s].

    It ends at a time [s], when a corner has moved by `far` [m] or a box has rotated by `turned` [rad], or at rest.
    """
    steps, n = round(until / step), len(boxes.mass)
    while_ago = round(STUCK / step)
    still = np.zeros((n, 3))
    bodies = Bodies(
        boxes.half,
        boxes.mass,
        boxes.position.copy(),
        boxes.turn.copy(),
        still,
        still.copy(),
        np.zeros((n, 3, 3)),
    )
    planes = Planes(boxes.plane_point, boxes.plane_normal, boxes.plane_friction)
    start = Bodies(*(part.copy() for part in bodies))
    time, moved, turns, places = np.zeros(steps), np.zeros((steps, n)), np.zeros((steps, n)), np.zeros((steps, n, 3))
    points, unsettled, done = _no_points(), 0, 0
    while done < steps:
        points, settled = _stepped(bodies, planes, (boxes.friction, boxes.gravity, step), points)
        unsettled += not settled
        moved[done], turns[done] = _way(bodies, start)
        time[done], places[done] = (done + 1) * step, bodies.position
        done += 1
        if moved[done - 1].max() > far or turns[done - 1].max() > turned:
            break
        if done > while_ago and np.ptp(moved[done - while_ago : done], axis=0).max() < CREEPS:
            break
    return Course(time[:done], moved[:done], turns[:done], places[:done], unsettled)


def _no_points() -> Points:
    none, whole = np.zeros((0, 3)), np.zeros(0, np.int64)
    return Points(whole, whole, none, none, np.zeros(0), np.zeros(0), whole, none)


@compiled
def _stepped(
    bodies: Bodies, planes: Planes, setting: tuple[float, float, float], before: Points
) -> tuple[Points, bool]:
    """Compute one step of all bodies; return its contact points, and whether their impulses converged."""
    friction, gravity, h = setting
    for i in range(len(bodies.mass)):
        square = bodies.half[i] ** 2
        moments = bodies.mass[i] / 3.0 * (np.sum(square) - square)
        bodies.inverse[i] = (bodies.turn[i] / moments) @ bodies.turn[i].T
        inertia = (bodies.turn[i] * moments) @ bodies.turn[i].T
        bodies.velocity[i, 2] -= h * gravity
        bodies.spin[i] -= h * (bodies.inverse[i] @ np.cross(bodies.spin[i], inertia @ bodies.spin[i]))
    points = contacts(bodies, planes, friction)
    for c in range(len(points.key)):
        for k in range(len(before.key)):
            if before.key[k] == points.key[c]:
                points.impulse[c] = before.impulse[k]
    settled = _settled(bodies, points, h)
    for i in range(len(bodies.mass)):
        bodies.position[i] += h * bodies.velocity[i]
        bodies.turn[i] = _turned(bodies.turn[i], h * bodies.spin[i])
    return points, settled


@compiled
def _way(bodies: Bodies, start: Bodies) -> tuple[Array, Array]:
    """Return the displacement and the rotation of each box."""
    moved, turned = np.zeros(len(bodies.mass)), np.zeros(len(bodies.mass))
    for i in range(len(bodies.mass)):
        for c in range(8):
            local = CORNERS[c] * bodies.half[i]
            away = bodies.position[i] + bodies.turn[i] @ local - start.position[i] - start.turn[i] @ local
            moved[i] = max(moved[i], np.sqrt(np.sum(away**2)))
        r = bodies.turn[i] @ start.turn[i].T
        off = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
        turned[i] = np.arctan2(0.5 * np.sqrt(np.sum(off**2)), 0.5 * (np.trace(r) - 1.0))
    return moved, turned


@compiled
def _turned(turn: Array, by: Array) -> Array:
    angle = np.sqrt(np.sum(by**2))
    if angle == 0.0:
        return turn
    x, y, z = by / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    after: Array = (np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)) @ turn
    return after


@compiled
def _settled(bodies: Bodies, points: Points, h: float) -> bool:
    """Run Gauss-Seidel over the contact points with the exact cone; return whether it converged."""
    count, impulses = len(points.key), points.impulse
    rows, answers = np.zeros((count, 3, 2, 6)), np.zeros((count, 3, 2, 6))  # of slips, and the responses to an impulse
    share, wanted = np.zeros((count, 3)), np.zeros(count)
    speeds = np.concatenate((bodies.velocity, bodies.spin), axis=1)
    for c in range(count):
        wanted[c] = max(points.gap[c] / h, -RECOVERY)
        frame = _frame(points.normal[c])
        on, body = points.on[c], points.body[c]
        for side, moving in enumerate((on, body)):
            if moving < 0:
                continue
            for k in range(3):
                away = frame[k] if side else -frame[k]
                turning = np.cross(points.point[c] - bodies.position[moving], away)
                rows[c, k, side, :3], rows[c, k, side, 3:] = away, turning
                answers[c, k, side, :3] = away / bodies.mass[moving]
                answers[c, k, side, 3:] = bodies.inverse[moving] @ turning
                share[c, k] += np.sum(rows[c, k, side] * answers[c, k, side])
        for k in range(3):
            _push(speeds, on, body, answers[c, k], impulses[c, k])
    settled = count == 0
    for _sweep in range(SWEEPS):
        change, largest = 0.0, 1e-300
        for c in range(count):
            on, body = points.on[c], points.body[c]
            normal, first, second = impulses[c, 0], impulses[c, 1], impulses[c, 2]
            pressing = max(0.0, normal - (_slip(speeds, on, body, rows[c, 0]) + wanted[c]) / share[c, 0])
            _push(speeds, on, body, answers[c, 0], pressing - normal)
            across = max(share[c, 1], share[c, 2])
            one = first - _slip(speeds, on, body, rows[c, 1]) / across
            other = second - _slip(speeds, on, body, rows[c, 2]) / across
            size, most = np.sqrt(one * one + other * other), points.friction[c] * pressing
            if size > most:
                one, other = one * (most / size), other * (most / size)
            _push(speeds, on, body, answers[c, 1], one - first)
            _push(speeds, on, body, answers[c, 2], other - second)
            impulses[c, 0], impulses[c, 1], impulses[c, 2] = pressing, one, other
            change = max(change, abs(pressing - normal), abs(one - first), abs(other - second))
            largest = max(largest, pressing)
        if change <= SETTLED * largest:
            settled = True
            break
    bodies.velocity[:], bodies.spin[:] = speeds[:, :3], speeds[:, 3:]
    return settled


@compiled
def _frame(normal: Array) -> Array:
    side = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < SIDEWAYS else np.array([1.0, 0.0, 0.0])
    tangent = np.cross(side, normal)
    tangent /= np.sqrt(np.sum(tangent**2))
    frame = np.zeros((3, 3))
    frame[0], frame[1], frame[2] = normal, tangent, np.cross(normal, tangent)
    return frame


@compiled
def _slip(speeds: Array, on: int, body: int, rows: Array) -> float:
    """Return the slip of a point along one axis [m/s]; `rows` (2, 6) are for the two bodies."""
    total = 0.0
    for side, moving in enumerate((on, body)):
        if moving >= 0:
            for i in range(6):
                total += rows[side, i] * speeds[moving, i]
    return total


@compiled
def _push(speeds: Array, on: int, body: int, answers: Array, by: float) -> None:
    """Apply an impulse along one axis; `answers` (2, 6) are the responses of the two bodies to a unit impulse."""
    for side, moving in enumerate((on, body)):
        if moving >= 0:
            for i in range(6):
                speeds[moving, i] += by * answers[side, i]
