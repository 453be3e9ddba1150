"""Rigid boxes with Coulomb friction, step by step: what slips and falls are measured against.

Moreau's time stepping: velocities after a step and impulses in it obey Signorini's and Coulomb's laws at every contact
point (no restitution; the gap may close within the step), solved by projected Gauss-Seidel; then places follow from
the new velocities. The error is of first order in the step, so that half the step shows how large it is. Points are
corners on faces and edges that cross, each with its own gap. Source: Stewart and Trinkle (1996), Moreau (1999).

This judges `stability.motion`, so it was written apart from it and stays so: nothing is imported from `stability`.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.box_contacts import CORNERS, Array, Bodies, Planes, Points, compiled, contacts

SWEEPS = 3_000  # at most, of Gauss-Seidel
SETTLED = 1e-8  # change of an impulse in a sweep, as a share of the largest
SIDEWAYS = 0.7  # cosine: a normal closer than that to an axis takes another one as the reference of its tangents


@dataclass(frozen=True, slots=True)
class Boxes:
    """Boxes at rest, and the half-spaces that they may touch."""

    half: Array  # (n, 3) half lengths along the body axes [m]
    mass: Array  # (n,) [kg]
    position: Array  # (n, 3) of centres [m]
    turn: Array  # (n, 3, 3) body axes, by columns
    plane_point: Array  # (m, 3) [m]
    plane_normal: Array  # (m, 3) unit, out of the solid
    plane_friction: Array  # (m,)
    friction: float  # of box on box
    gravity: float = 9.81  # [m/s2]


@dataclass(frozen=True, slots=True)
class Course:
    """What happened, step by step."""

    time: Array  # (steps,) [s]
    moved: Array  # (steps, n) how far the corner of each box that has moved most is from where it was [m]
    turned: Array  # (steps, n) by how much each box has turned [rad]
    position: Array  # (steps, n, 3) of centres [m]
    unsettled: int  # steps in which the sweeps did not settle


def course(boxes: Boxes, step: float, until: float, far: float = np.inf, turned: float = np.inf) -> Course:
    """What happens from rest, at a time step [s]: until a time [s], or until something got far [m] or turned [rad]."""
    steps, n = round(until / step), len(boxes.mass)
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
    return Course(time[:done], moved[:done], turns[:done], places[:done], unsettled)


def _no_points() -> Points:
    none, whole = np.zeros((0, 3)), np.zeros(0, np.int64)
    return Points(whole, whole, none, none, np.zeros(0), np.zeros(0), whole, none)


@compiled
def _stepped(
    bodies: Bodies, planes: Planes, setting: tuple[float, float, float], before: Points
) -> tuple[Points, bool]:
    """One step of all bodies; its points of contact, and whether their impulses settled."""
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
    """How far each has got, and by how much it has turned."""
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
    """Gauss-Seidel over the contact points, each time with the exact cone; whether it settled."""
    count = len(points.key)
    frames, share = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for c in range(count):
        frames[c] = _frame(points.normal[c])
        for k in range(3):
            for body in (points.on[c], points.body[c]):
                if body >= 0:
                    arm = np.cross(points.point[c] - bodies.position[body], frames[c, k])
                    share[c, k] += 1.0 / bodies.mass[body] + np.sum(arm * (bodies.inverse[body] @ arm))
        _push(bodies, points, c, points.impulse[c] @ frames[c])
    for _sweep in range(SWEEPS):
        change, largest = 0.0, 1e-300
        for c in range(count):
            before = points.impulse[c].copy()
            along = frames[c] @ _slip(bodies, points, c)
            points.impulse[c, 0] = max(0.0, before[0] - (along[0] + points.gap[c] / h) / share[c, 0])
            _push(bodies, points, c, (points.impulse[c, 0] - before[0]) * frames[c, 0])
            along = frames[c] @ _slip(bodies, points, c)
            trial = before[1:] - along[1:] / max(share[c, 1], share[c, 2])
            size, most = np.sqrt(np.sum(trial**2)), points.friction[c] * points.impulse[c, 0]
            points.impulse[c, 1:] = trial * (most / size) if size > most else trial
            rubs = points.impulse[c, 1:] - before[1:]
            _push(bodies, points, c, rubs[0] * frames[c, 1] + rubs[1] * frames[c, 2])
            change = max(change, np.max(np.abs(points.impulse[c] - before)))
            largest = max(largest, points.impulse[c, 0])
        if change <= SETTLED * largest:
            return True
    return count == 0


@compiled
def _frame(normal: Array) -> Array:
    side = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < SIDEWAYS else np.array([1.0, 0.0, 0.0])
    tangent = np.cross(side, normal)
    tangent /= np.sqrt(np.sum(tangent**2))
    frame = np.zeros((3, 3))
    frame[0], frame[1], frame[2] = normal, tangent, np.cross(normal, tangent)
    return frame


@compiled
def _slip(bodies: Bodies, points: Points, c: int) -> Array:
    on, body, point = points.on[c], points.body[c], points.point[c]
    slip: Array = bodies.velocity[body] + np.cross(bodies.spin[body], point - bodies.position[body])
    if on >= 0:
        slip = slip - bodies.velocity[on] - np.cross(bodies.spin[on], point - bodies.position[on])
    return slip


@compiled
def _push(bodies: Bodies, points: Points, c: int, by: Array) -> None:
    on, body, point = points.on[c], points.body[c], points.point[c]
    bodies.velocity[body] += by / bodies.mass[body]
    bodies.spin[body] += bodies.inverse[body] @ np.cross(point - bodies.position[body], by)
    if on >= 0:
        bodies.velocity[on] -= by / bodies.mass[on]
        bodies.spin[on] -= bodies.inverse[on] @ np.cross(point - bodies.position[on], by)
