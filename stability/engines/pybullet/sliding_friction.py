"""What slides is held by no more friction than Coulomb's cone allows, and straight against its sliding.

PyBullet has two friction forces at a contact point, one against the sliding as it was before the step and one across
it, and each may be as strong as Coulomb allows by itself. The one across lets no contact turn the sliding: a plank that
slides is not dragged aside by another that turns below it, and is slowed by up to 1.4 times the friction that there is.

The impulses p_n that the engine found along the normals stand. From those of friction that are outside of their cones
on, projected Jacobi is iterated, with masses split among the points of a body (Tonge, Benevolenski, Voroshilov, "Mass
splitting for jitter-free parallel rigid body simulation", ACM Transactions on Graphics 31, 2012). With the sliding v of
a point after the step, and with its share m of the masses,

    p_t  <-  the nearest to  p_t - m v  with  |p_t| <= mu p_n.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.engines.pybullet.pybullet_binding import pybullet

Array: TypeAlias = NDArray[np.float64]

MOST_BODIES = 64  # in an engine: to ask what touches in a crowd takes longer than its step (docs/decisions/0074)
BEYOND = 1.005  # times as much friction as the cone allows: less is let be
LEVEL = 0.5**0.5  # sine of the angle of a normal from level up to which a contact presses more sideways than down
SWEEPS = 8  # of Jacobi: with one, planks that are hit at 1 m/s go up to 13 % too far, with four 5 %
ALONG_AXES = np.eye(3)
TINY = np.finfo(float).tiny
# The moment of a unit of impulse along an axis of W: about which other one, along which, and the arm with its sign.
MOMENTS = ((4, 0, 1.0, 2), (5, 0, -1.0, 1), (3, 1, -1.0, 2), (5, 1, 1.0, 0), (3, 2, 1.0, 1), (4, 2, -1.0, 0))
MASS, FRICTION = 0, 1  # of what is told of a body
A, B, ON_A, ON_B, NORMAL, PRESSES, ALONG, WAY, ACROSS, OTHER_WAY = 1, 2, 5, 6, 7, 9, 10, 11, 12, 13  # of a point


def turn_to_sliding(client: int, duration: float) -> None:
    """Change how bodies move after a step of a duration [engine s], as if friction had been in its cones in it.

    In a crowd it is left as the engine has it: where one of hundreds comes to lie is chance.
    """
    if pybullet.getNumBodies(physicsClientId=client) > MOST_BODIES:
        return
    points = pybullet.getContactPoints(physicsClientId=client) or ()
    told = {body: pybullet.getDynamicsInfo(body, -1, client) for body in {p[end] for p in points for end in (A, B)}}
    own = {body: info[FRICTION] for body, info in told.items()}
    held = {body for body, info in told.items() if info[MASS] == 0.0}
    beyond = [
        point
        for point in points
        if hypot(point[ALONG], point[ACROSS]) > BEYOND * own[point[A]] * own[point[B]] * point[PRESSES]
        and not (point[A] in held and point[B] in held)  # what they tell is of when they were let go
    ]
    if beyond:
        bodies = _Bodies.of(client, beyond)
        limits = np.array([own[point[A]] * own[point[B]] * point[PRESSES] for point in beyond])
        _project(bodies, beyond, duration, duration * limits)
        bodies.move(client)


def presses_sideways(client: int) -> bool:
    """Finds whether two free bodies pressed on each other more sideways than down in the last step.

    False in a world of more than `MOST_BODIES`, where looking would take too long.
    """
    if pybullet.getNumBodies(physicsClientId=client) > MOST_BODIES:
        return False
    return any(
        point[PRESSES] > 0.0
        and abs(point[NORMAL][2]) < LEVEL
        and all(pybullet.getDynamicsInfo(point[end], -1, client)[MASS] > 0.0 for end in (A, B))
        for point in pybullet.getContactPoints(physicsClientId=client) or ()
    )


@dataclass(frozen=True, slots=True)
class _Bodies:
    """Some bodies of a client, each in a row."""

    rows: dict[int, int]  # by number
    places: Array  # (n, 3) of their centres
    speeds: Array  # (n, 6) velocity and angular velocity, W
    answers: Array  # (n, 6, 6) to a unit of impulse and of its moment, W; 0 of what is held

    @classmethod
    def of(cls, client: int, points: Sequence[Sequence[Any]]) -> "_Bodies":
        """The bodies of some contact points."""
        rows = {body: row for row, body in enumerate(dict.fromkeys(p[end] for p in points for end in (A, B)))}
        places, speeds, answers = np.zeros((len(rows), 3)), np.zeros((len(rows), 6)), np.zeros((len(rows), 6, 6))
        for body, row in rows.items():
            mass, _, moments = pybullet.getDynamicsInfo(body, -1, client)[:3]
            places[row], orientation = pybullet.getBasePositionAndOrientation(body, client)
            speeds[row, :3], speeds[row, 3:] = pybullet.getBaseVelocity(body, client)
            if mass > 0.0:
                turn = np.array(pybullet.getMatrixFromQuaternion(orientation)).reshape(3, 3)
                answers[row, :3, :3] = ALONG_AXES / mass
                answers[row, 3:, 3:] = turn / np.array(moments) @ turn.T
        return cls(rows, places, speeds, answers)

    def move(self, client: int) -> None:
        """Tell the client their speeds."""
        for body, row in self.rows.items():
            if self.answers[row, 0, 0] > 0.0:
                velocity, spin = self.speeds[row, :3].tolist(), self.speeds[row, 3:].tolist()
                pybullet.resetBaseVelocity(body, velocity, spin, physicsClientId=client)


def _project(bodies: _Bodies, points: Sequence[Sequence[Any]], duration: float, limits: Array) -> None:
    """Bring the friction of some points into cones with these limits [engine N s], and change the bodies' speeds."""
    rows = np.array([[bodies.rows[point[A]], bodies.rows[point[B]]] for point in points])
    normals = np.array([point[NORMAL] for point in points])
    arms = np.array([(point[ON_A], point[ON_B]) for point in points]) - bodies.places[rows]
    # (points, 2 bodies, 6, 3): the impulse and its moment that a unit of impulse along each axis of W is to a body.
    acting = np.zeros((*arms.shape[:2], 6, 3))
    acting[:, :, :3] = ALONG_AXES
    for about, on_axis, sign, arm in MOMENTS:
        acting[:, :, about, on_axis] = sign * arms[:, :, arm]
    acting[:, 1] *= -1.0
    answers = bodies.answers[rows] @ acting
    shared = np.bincount(rows.ravel(), minlength=len(bodies.rows))[rows]
    lighter = np.einsum("psij,psik,ps->pjk", acting, answers, shared)
    # As much as a point may give way along any direction of its plane.
    gives = np.einsum("pjj->p", lighter) - np.einsum("pj,pjk,pk->p", normals, lighter, normals)
    along, across = (np.array([point[force] for point in points])[:, None] for force in (ALONG, ACROSS))
    ways, other_ways = (np.array([point[way] for point in points]) for way in (WAY, OTHER_WAY))
    impulses = duration * (along * ways + across * other_ways)  # on the first body
    for _ in range(SWEEPS):
        sliding = np.einsum("psij,psi->pj", acting, bodies.speeds[rows])
        sliding -= np.einsum("pj,pj->p", sliding, normals)[:, None] * normals
        wanted = impulses - sliding / gives[:, None]
        sizes = np.sqrt(np.add.reduce(wanted * wanted, axis=1))
        wanted *= np.minimum(1.0, limits / np.maximum(sizes, TINY))[:, None]
        np.add.at(bodies.speeds, rows, np.einsum("psij,pj->psi", answers, wanted - impulses))
        impulses = wanted
