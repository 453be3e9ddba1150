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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
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
TINY = np.finfo(float).tiny
# Of a unit of impulse along each axis of W: about which axes it turns a body, by which part of its arm, and its sign.
# There are two for each, the lower first.
ABOUT = np.array([[1, 0, 0], [2, 2, 1]])
ARM = np.array([[2, 2, 1], [1, 0, 0]])
SIGN = np.array([[1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]])[:, :, None]
AXES = np.arange(3)
ORDER = np.array([0, 2, 1])  # in which products along the axes are added up
# What of a speed makes a point slide along each axis of W: the velocity, and two parts of the angular velocity.
SEEN = np.array([AXES, *(3 + ABOUT)])[:, :, None]
ALL_PARTS = np.arange(6)[:, None]  # of a speed
MASS, FRICTION, MOMENTS = 0, 1, 2  # of what is told of a body
A, B, ON_A, ON_B, NORMAL, PRESSES, ALONG, WAY, ACROSS, OTHER_WAY = 1, 2, 5, 6, 7, 9, 10, 11, 12, 13  # of a point


@dataclass(slots=True)
class SlidingFriction:
    """Knows what the bodies of a client are, as long as nobody changes that."""

    client: int
    _told: dict[int, Sequence[Any]] = field(default_factory=dict, init=False)
    _friction: dict[int, float] = field(default_factory=dict, init=False)
    _held: set[int] = field(default_factory=set, init=False)

    def begin(self) -> None:
        """Note that bodies may have been changed: call it before a series of engine steps."""
        self._told.clear()
        self._friction.clear()
        self._held.clear()

    def turn(self, duration: float) -> None:
        """Change how bodies move after a step of a duration [engine s], as if friction had been in its cones in it.

        In a crowd it is left as the engine has it: where one of hundreds comes to lie is chance.
        """
        client, own, held = self.client, self._friction, self._held
        if pybullet.getNumBodies(physicsClientId=client) > MOST_BODIES:
            return
        points = pybullet.getContactPoints(physicsClientId=client) or ()
        for body in {point[end] for point in points for end in (A, B)} - own.keys():
            self._told[body] = told = pybullet.getDynamicsInfo(body, -1, client)
            own[body] = told[FRICTION]
            if told[MASS] == 0.0:
                held.add(body)
        beyond = [
            point
            for point in points
            if hypot(point[ALONG], point[ACROSS]) > BEYOND * own[point[A]] * own[point[B]] * point[PRESSES]
            and not (point[A] in held and point[B] in held)  # what they tell is of when they were let go
        ]
        if beyond:
            bodies = _Bodies.of(client, beyond, self._told)
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
    """Some bodies of a client, each in a column."""

    columns: dict[int, int]  # by number
    places: Array  # (3, n) of their centres
    speeds: Array  # (6, n) velocity and angular velocity, W
    lightness: Array  # (n,) inverses of their masses; 0 of what is held
    answers: Array  # (n, 3, 3) inverses of their inertia, W; 0 of what is held

    @classmethod
    def of(cls, client: int, points: Sequence[Sequence[Any]], told: Mapping[int, Sequence[Any]]) -> "_Bodies":
        """The bodies of some contact points, of which the client has told this."""
        numbers = dict.fromkeys(point[end] for point in points for end in (A, B))
        poses = [pybullet.getBasePositionAndOrientation(body, client) for body in numbers]
        motions = [pybullet.getBaseVelocity(body, client) for body in numbers]
        axes = np.array([pybullet.getMatrixFromQuaternion(orientation) for _, orientation in poses]).reshape(-1, 3, 3)
        masses = np.array([told[body][MASS] for body in numbers])
        free = masses > 0.0
        lightness, answers = np.zeros(len(masses)), np.zeros_like(axes)
        lightness[free] = 1.0 / masses[free]
        moments = np.array([told[body][MOMENTS] for body in numbers])
        answers[free] = axes[free] / moments[free, None] @ axes[free].transpose(0, 2, 1)
        return cls(
            {body: column for column, body in enumerate(numbers)},
            np.array([position for position, _ in poses]).T,
            np.array([(*velocity, *spin) for velocity, spin in motions]).T.copy(),
            lightness,
            answers,
        )

    def pairs(self, points: Sequence[Sequence[Any]]) -> NDArray[np.intp]:
        """(points, 2): the columns of the bodies of some points."""
        columns = (self.columns[point[end]] for point in points for end in (A, B))
        return np.fromiter(columns, np.intp, 2 * len(points)).reshape(-1, 2)

    def move(self, client: int) -> None:
        """Tell the client their speeds."""
        free, speeds = self.lightness.tolist(), self.speeds.T.tolist()
        for body, column in self.columns.items():
            if free[column] > 0.0:
                velocity, spin = speeds[column][:3], speeds[column][3:]
                pybullet.resetBaseVelocity(body, velocity, spin, physicsClientId=client)


def _project(bodies: _Bodies, points: Sequence[Sequence[Any]], duration: float, limits: Array) -> None:
    """Bring the friction of some points into cones with these limits [engine N s], and change the bodies' speeds.

    Arrays have the points, or the two bodies of each, along their last axis: numpy goes along that many times faster
    than along three. Each sum is written out, so that its last bit is the same wherever it is worked out.
    """
    pairs, number = bodies.pairs(points), len(bodies.columns)
    ends = pairs.ravel()  # of the first point, then of the second, and so on
    places, normals, ways, other_ways, along, across = _told(points)
    arms = places.transpose(1, 2, 0).reshape(3, -1) - bodies.places[:, ends]
    first = np.tile((1.0, -1.0), len(points))  # with which sign an impulse acts on the body
    levers = SIGN * arms[ARM] * first  # (2, 3, ends): the moments of a unit of impulse along each axis of W
    answers = _answers(bodies, ends, levers, first)
    gives = _give(normals, levers, answers, np.bincount(ends, minlength=number)[ends])
    # (2 bodies, 3 parts of a speed, 3, points): what a point slides by along each axis of W, and how much of it.
    slides = number * SEEN + pairs.T[:, None, None]
    shares = np.concatenate((np.broadcast_to(first, (1, 3, len(ends))), levers)).reshape(3, 3, -1, 2)
    shares = shares.transpose(3, 0, 1, 2).copy()
    impulses = duration * (along * ways + across * other_ways)  # on the first body
    on_both = np.arange(impulses.size).reshape(3, 1, -1).repeat(2, axis=2)[ORDER]
    answers, changed = answers[:, ORDER].transpose(1, 0, 2).copy(), (number * ALL_PARTS + ends).ravel()
    speeds = bodies.speeds.reshape(-1)
    for _ in range(SWEEPS):
        parts = (speeds.take(slides) * shares).reshape(6, 3, -1)
        sliding = np.add.reduce(parts, axis=0, initial=0.0)
        x, y, z = sliding * normals
        sliding -= (x + z + y) * normals
        wanted = impulses - sliding / gives
        sizes = np.sqrt(np.add.reduce(wanted * wanted, axis=0))
        wanted *= np.minimum(1.0, limits / np.maximum(sizes, TINY))
        changes = answers * (wanted - impulses).take(on_both)
        np.add.at(speeds, changed, np.add.reduce(changes, axis=0, initial=0.0).ravel())
        impulses = wanted


def _told(points: Sequence[Sequence[Any]]) -> tuple[Array, ...]:
    """Where points are on both bodies, their normals and ways, and their friction along these."""
    told = (p[ON_A] + p[ON_B] + p[NORMAL] + p[WAY] + p[OTHER_WAY] + (p[ALONG], p[ACROSS]) for p in points)
    found = np.fromiter(chain.from_iterable(told), float, 17 * len(points)).reshape(-1, 17).T.copy()
    return found[:6].reshape(2, 3, -1), found[6:9], found[9:12], found[12:15], found[15], found[16]


def _answers(bodies: _Bodies, ends: NDArray[np.intp], levers: Array, first: Array) -> Array:
    """(6, 3, ends): the speeds that a unit of impulse along each axis of W gives the body of an end."""
    moments, answers = np.zeros((len(ends), 3, 3)), np.zeros((6, 3, len(ends)))
    for about, lever in zip(ABOUT, levers, strict=True):
        moments[:, about, AXES] = lever.T
    answers[AXES, AXES] = bodies.lightness[ends] * first
    answers[3:] = (bodies.answers[ends] @ moments).transpose(1, 2, 0)
    return answers


def _give(normals: Array, levers: Array, answers: Array, shared: NDArray[np.intp]) -> Array:
    """As much as points may give way along any direction of their planes, with masses split among those of a body."""
    parts = np.empty((3, 3, 3, len(shared)))
    np.multiply(np.abs(answers[:3]), shared, out=parts[0])
    np.multiply(levers[:, :, None] * answers[3 + ABOUT], shared, out=parts[1:])
    one_by_one = parts.reshape(3, 9, -1, 2).transpose(3, 0, 1, 2).reshape(6, 9, -1)
    lighter = np.add.reduce(one_by_one, axis=0, initial=0.0)
    beside = (normals[:, None] * lighter.reshape(3, 3, -1) * normals).reshape(9, -1)
    gives: Array = lighter[0] + lighter[4] + lighter[8] - np.add.reduce(beside, axis=0)
    return gives
