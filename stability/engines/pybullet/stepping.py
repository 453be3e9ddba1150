"""Steps a PyBullet client: step size, parameters, sliding friction, anchors of resting contacts, free fall."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import ceil, hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stability.engines.pressing import Presses
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.client import ClientBodies
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.rows import Array
from stability.geometry.vectors import add
from stability.model import AT_REST, BodyId, BodyState, Vec3

# Chooses the step size from the bricks that are awake.
#
# Model: an iterative contact solver lets a light brick under a heavy one give way in proportion to their ratio of
# masses and to the square of the step; a body that is inside another when the engine first sees them is pushed out of
# it, and flies off; contacts that last from step to step are solved from where they were left, those of an impact from
# nothing.


MOST_PARTS_OF_HITS = 32  # 8 m/s at steps of 1/960 s


@dataclass(frozen=True, slots=True)
class Awake:
    """What is known of the bodies that move, or may."""

    fastest: float = 0.0  # [m/s] no body will be faster before the next look
    mass_ratio: float = 1.0  # of the heaviest to the lightest
    begins: bool = False  # whether bodies that did not press on each other begin to


@dataclass(frozen=True, slots=True)
class Stepping:
    """How one time step is taken."""

    parts: int  # engine steps in it
    iterations: int  # of the contact solver in each
    lively: bool  # whether something may hit something
    may_hit: bool = False  # whether that is about to be, for the first time


def stepping(settings: PyBulletSettings, awake: Awake) -> Stepping:
    """How to step what is awake with these settings."""
    lively = settings.lively_speed is not None and awake.fastest > settings.lively_speed
    may_hit = lively and awake.begins
    parts = (
        settings.parts_for_travel(awake.fastest),
        _for_hits(settings, awake.fastest) if may_hit else 1,
        _for_masses(settings, awake.mass_ratio),
        settings.first_parts if awake.begins else 1,
        settings.lively_parts if lively else 1,
    )
    iterations = settings.lively_iterations if lively else settings.iterations
    if may_hit:
        iterations = max(iterations, settings.first_iterations)
    return Stepping(max(parts), iterations, lively, may_hit)


def _for_hits(settings: PyBulletSettings, fastest: float) -> int:
    """Into how many parts, so that what hits something by a narrow overlap does not slip past it."""
    if settings.first_travel is None:
        return 1
    return max(1, min(MOST_PARTS_OF_HITS, ceil(fastest * settings.time_step / settings.first_travel)))


def _for_masses(settings: PyBulletSettings, ratio: float) -> int:
    """Into how many parts, so that a light brick stays firm under a heavy one."""
    if settings.most_mass_ratio is None:
        return 1
    return max(1, min(settings.most_parts, ceil(sqrt(ratio / settings.most_mass_ratio))))


# Sets every parameter of a client and its bodies; nothing is left to defaults or to earlier runs.


# [engine m/s], for bodies as well as joints. By default PyBullet clamps speeds at 100, which is 10 m/s at scale 100.
TOP_SPEED = 1e4

# What all systems have in common; most of it belongs to the process and outlives its client.
ALIKE = {
    "restitutionVelocityThreshold": 0.2,
    "globalCFM": 0.0,
    "enableConeFriction": 1,
    "deterministicOverlappingPairs": 1,
    "constraintSolverType": pybullet.CONSTRAINT_SOLVER_LCP_SI,
    "enableSAT": 0,
    "collisionFilterMode": 0,
    "minimumSolverIslandSize": 128,
    "allowedCcdPenetration": 0.04,
}


def engine_parameters(settings: PyBulletSettings) -> dict[str, float]:
    """All that `setPhysicsEngineParameter` must be told: each belongs to the client or, worse, to the process.

    `contactBreakingThreshold` belongs to the process and outlives its client.
    """
    return {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale),
        "numSolverIterations": settings.iterations,
        "numSubSteps": 0,
        "contactERP": settings.contact_erp,
        "erp": settings.contact_erp,
        "frictionERP": settings.friction_erp,
        "contactBreakingThreshold": settings.breaking_threshold,
        "contactSlop": settings.contact_slop,
        "solverResidualThreshold": settings.residual_threshold,
        "useSplitImpulse": 0 if settings.maximal_coordinates else 1,
        "warmStartingFactor": settings.warm_start,
        **ALIKE,
    }


# In more parts than these only what moves beside a sliver is stepped. There a corner that PyBullet finds late, some
# hundredths of a millimetre deep, is parted from a face at metres a second: a plank that tipped over one turned faster
# by 30 rad/s at once (heap 385 of `benchmarks.energy`).
MOST_PUSHING = 16


def step_parameters(settings: PyBulletSettings, how: Stepping) -> dict[str, float]:
    """What `setPhysicsEngineParameter` must be told when the stepping changes."""
    parameters = {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale) / how.parts,
        "numSolverIterations": how.iterations,
    }
    if settings.maximal_coordinates:
        # What overlaps is then parted without being given speed. Stacks at rest creep by it.
        parted = how.lively or how.parts > MOST_PUSHING
        parameters |= {"useSplitImpulse": int(parted), "splitImpulsePenetrationThreshold": 0.0}
        parameters["globalCFM"] = settings.first_cfm if how.may_hit else 0.0
    if settings.maximal_coordinates and not how.lively:
        # The speed by which a share of an overlap is taken back in a step grows with the parts: what slips deep into
        # another is shot out. Divided by all of them, light bricks give way under heavy ones.
        parameters["contactERP"] = settings.contact_erp / sqrt(how.parts)
    elif settings.maximal_coordinates:
        parameters["contactERP"] = settings.contact_erp
    return parameters


def body_parameters(settings: PyBulletSettings, own_friction: float) -> dict[str, float]:
    """All that `changeDynamics` must be told of a body but its mass."""
    return {
        "lateralFriction": own_friction,
        "rollingFriction": 0.0,
        "spinningFriction": 0.0,
        "restitution": 0.0,
        "linearDamping": settings.linear_damping,
        "angularDamping": settings.angular_damping,
        "maxJointVelocity": TOP_SPEED,
        "frictionAnchor": 0,
        "activationState": pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
    }


# Limits the friction on sliding bricks to Coulomb's cone, directed against the sliding.
#
# PyBullet has two friction forces at a contact point, one against the sliding as it was before the step and one across
# it, and each may be as strong as Coulomb allows by itself. The one across lets no contact turn the sliding: a plank
# that slides is not dragged aside by another that turns below it, and is slowed by up to 1.4 times the friction that
# there is.
#
# The impulses p_n that the engine found along the normals stand. From those of friction that are outside of their cones
# on, projected Jacobi is iterated, with masses split among the points of a body (Tonge, Benevolenski, Voroshilov, "Mass
# splitting for jitter-free parallel rigid body simulation", ACM Transactions on Graphics 31, 2012). With the sliding v
# of a point after the step, and with its share m of the masses,
#
#     p_t  <-  the nearest to  p_t - m v  with  |p_t| <= mu p_n.


MOST_BODIES = 64  # in an engine: to ask what touches in a crowd takes longer than its step (docs/design/friction.md)
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


# Springs that hold the resting contacts of bricks in place, while all is quiet.


@dataclass
class Anchors:
    """Which bricks are anchored: those that lie square, as those that lean would stand where they should slip."""

    bodies: ClientBodies
    wanted: bool  # whether any brick is to be anchored
    _quiet: bool = field(default=True, init=False)
    _bricks: set[BodyId] = field(default_factory=set, init=False)

    def add(self, brick: BodyId) -> None:
        """Anchor a new brick, as long as all is quiet."""
        if self.wanted:
            self._bricks.add(brick)
            self._tell([brick])

    def remove(self, brick: BodyId) -> None:
        """Forget a brick."""
        self._bricks.discard(brick)

    def renew(self, brick: BodyId) -> None:
        """Anchor a brick that has got another body, if it was anchored."""
        if brick in self._bricks:
            self._tell([brick])

    def choose(self, lively: bool) -> None:
        """Hold all of them while nothing is fast."""
        self._quiet = not lively
        self._tell(sorted(self._bricks, key=self.bodies.numbers.__getitem__))

    def _tell(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            body = self.bodies.numbers[brick]
            pybullet.changeDynamics(body, -1, frictionAnchor=int(self._quiet), physicsClientId=self.bodies.client)


# Bodies that are let go, so that the way that they fall is exact.
#
# PyBullet moves a body on by the speed that it will have. So speeds belong to the middle of a step, and gravity acts
# from there to the middle of the next: for half a step on what was let go, and for the mean of two steps where they
# change.


@dataclass
class FreeFall:
    """Which bodies have just been let go, and which fly."""

    bodies: ClientBodies
    gravity: float  # [m/s2] along -z
    exact: bool
    flying: set[BodyId] = field(default_factory=set, init=False)  # let go, and not seen to touch anything since
    _let_go: set[BodyId] = field(default_factory=set, init=False)  # since the last step
    acceleration_W: Vec3 = field(default=AT_REST, init=False)  # of the ground [m/s2]
    _pulls: Vec3 = field(init=False)  # as the engine was told last [m/s2]
    _last_step: float = field(default=0.0, init=False)  # how long the last engine step was [s]
    # What is done before each engine step: it is told how all is pulled in it [m/s2], and how long it is [s].
    before: Callable[[Vec3, float], None] = field(default=lambda _pull_W, _duration: None, init=False)

    def __post_init__(self) -> None:
        self._pulls = (0.0, 0.0, -self.gravity)

    def begin(self, body: BodyId) -> None:
        """Note that a body is awake from now on."""
        if self.exact:
            self._let_go.add(body)

    def end(self, body: BodyId) -> None:
        """Note that a body does not fall any more, or does so already."""
        self._let_go.discard(body)
        self.flying.discard(body)

    def step(self, duration: float) -> None:
        """Take an engine step of a duration [s], the first after what was let go since the last."""
        last, self._last_step = self._last_step or duration, duration
        if self._let_go:
            self._lift(0.5 * self.gravity * last)
        if last == duration or not self.exact:
            self._pull(self.gravity)
            self.go_on(duration)
            return
        self._pull(0.5 * self.gravity * (last + duration) / duration)
        self.go_on(duration)
        self._pull(self.gravity)

    def go_on(self, duration: float) -> None:
        """Take another engine step [s], after one of the same duration."""
        self.before(self._pulls, duration)
        pybullet.stepSimulation(self.bodies.client)

    def _pull(self, gravity: float) -> None:
        """Let the engine pull with so much gravity, and with what bodies feel of the ground [m/s2]."""
        x, y, z = self.acceleration_W
        pull = (-x, -y, -gravity - z)
        # What is let go remembers how it was pulled when it was held.
        if pull != self._pulls or self.acceleration_W != AT_REST:
            pybullet.setGravity(*pull, self.bodies.client)
            self._pulls = pull

    def _lift(self, speed: float) -> None:
        """Throw what was let go upwards [m/s]."""
        for name in sorted(self._let_go, key=self.bodies.numbers.__getitem__):
            (vx, vy, vz), angular_velocity = self.bodies.raw_motion(name)
            lifted = (vx, vy, vz + speed * sqrt(self.bodies.scale))
            self.bodies.set_raw_motion(name, lifted, angular_velocity)
        self.flying |= self._let_go
        self._let_go.clear()

    def corrected(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, BodyState]:
        """States as of now: the engine's speed of what flies is that of the middle of the last step."""
        found = dict(states)
        for name in self.flying & found.keys():
            if self.bodies.raw_contacts(name):
                self.flying.discard(name)
            else:
                since = (0.0, 0.0, -0.5 * self.gravity * self._last_step)
                found[name] = replace(found[name], velocity_W=add(found[name].velocity_W, since))
        return found


# Steps a client as finely as what is awake asks for, and knows the time.


@dataclass
class Stepper:
    """The clock of a world, and how its next step is taken."""

    client: int
    settings: PyBulletSettings
    fall: FreeFall
    presses: Presses = field(default_factory=Presses, init=False)
    sliding: SlidingFriction = field(init=False)
    time: float = field(default=0.0, init=False)  # [s]
    _fastest: float = field(default=0.0, init=False)  # [m/s]
    _eased: int = field(default=0, init=False)  # steps to come in which bodies begin to press, or push on
    _suited: bool = field(default=False, init=False)  # False: something else is awake, look again
    _stepping: Stepping = field(init=False)  # what the engine knows

    def __post_init__(self) -> None:
        self._stepping = stepping(self.settings, Awake())
        self.sliding = SlidingFriction(self.client)

    @property
    def lively(self) -> bool:
        """Whether something may hit something, as far as the engine knows."""
        return self._stepping.lively

    @property
    def part(self) -> float:
        """How long a step of the engine is [s], as far as it knows."""
        return self.settings.time_step / self._stepping.parts

    def set_max_speed(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s]; steps are taken to suit that."""
        self._fastest, self._suited = fastest, False

    def substep_next_contact(self) -> None:
        """Say that bodies which did not press on each other begin to: split the first steps, as the settings say.

        What is hit is woken some ten of them before, and may be pushed for twice as many: then as many follow.
        """
        self._eased, self._suited = 2 * self.settings.first_steps, False

    def look_again(self) -> None:
        """Note that something else is awake than before."""
        self._suited = False

    def suit(self, mass_ratio: Callable[[], float]) -> bool:
        """Let the engine step as suits what is awake; returns whether `lively` has changed.

        `mass_ratio` says how many times the mass of the lightest body that is awake the heaviest has.
        """
        if self._suited:
            return False
        before = self._stepping
        ratio = 1.0 if self.settings.most_mass_ratio is None else mass_ratio()
        self._stepping = stepping(self.settings, Awake(self._fastest, ratio, self._eased > 0))
        self._suited = True
        if self._stepping != before:
            parameters = step_parameters(self.settings, self._stepping)
            pybullet.setPhysicsEngineParameter(**parameters, physicsClientId=self.client)
        return self._stepping.lively != before.lively

    def step(self) -> None:
        """Let one time step pass, in the parts that it was suited to."""
        parts = self._stepping.parts
        duration = self.settings.time_step / parts
        self.sliding.begin()
        for part in range(parts):
            self._exert(duration)
            if part == 0:
                self.fall.step(duration)
            else:
                self.fall.go_on(duration)
            if self.settings.sliding_cones and self.lively:
                self.sliding.turn(duration * sqrt(self.settings.scale))
        if self._eased:
            self._eased -= 1
            if self._eased == self.settings.first_steps and not self._pushes_on():
                self._eased = 0
            self._suited = self._suited and self._eased > 0
        self.time += self.settings.time_step

    def _pushes_on(self) -> bool:
        """True while a thrown or falling body still pushes the body that it hit."""
        return self._stepping.may_hit and presses_sideways(self.client)

    def _exert(self, duration: float) -> None:
        """Let what presses on bodies act in the coming engine step of a duration [s].

        As a change of motion: PyBullet leaves the torque of forces out when it works out what friction must stop, and a
        brick that is pressed on one side slides away.
        """
        for acting in self.presses.acting(self.fall.bodies, duration):
            after = acting.pushed()
            self.fall.bodies.set_motion(acting.brick.id, after.velocity_W, after.angular_velocity_W)
