"""Steps of a PyBullet client: step size, parameters, sliding friction, friction anchors, free fall."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import ceil, hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stability.engines.pressing import AppliedLoads
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.client import ClientBodies
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.rows import Array
from stability.geometry.vectors import add
from stability.model import AT_REST, BodyId, BodyState, Vec3

# Choice of the step size from the awake bricks.
#
# Model: with an iterative contact solver a light brick under a heavy one yields in proportion to their mass ratio and
# to the square of the step. Bodies that already overlap at their first contact detection are pushed apart at high
# speed. The solver starts from the last step's impulses for lasting contacts, and from 0 for an impact.


MOST_PARTS_OF_HITS = 32  # 8 m/s at steps of 1/960 s


@dataclass(frozen=True, slots=True)
class AwakeBodies:
    """Properties of the awake bodies."""

    fastest: float = 0.0  # [m/s] maximum speed of the bodies before the next check
    mass_ratio: float = 1.0  # of the heaviest to the lightest
    begins: bool = False  # whether there are new contacts


@dataclass(frozen=True, slots=True)
class Stepping:
    """Sub-steps and iterations of one time step."""

    parts: int  # engine steps in it
    iterations: int  # of the contact solver in each
    lively: bool  # whether bodies are fast enough to hit others
    may_hit: bool = False  # whether they may make new contacts


def stepping(settings: PyBulletSettings, awake: AwakeBodies) -> Stepping:
    """Choose sub-steps and iterations for the awake bodies."""
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
    """Return the number of sub-steps with which a body does not miss another that it hits with a narrow overlap."""
    if settings.first_travel is None:
        return 1
    return max(1, min(MOST_PARTS_OF_HITS, ceil(fastest * settings.time_step / settings.first_travel)))


def _for_masses(settings: PyBulletSettings, ratio: float) -> int:
    """Return the number of sub-steps with which a light brick does not yield under a heavy one."""
    if settings.most_mass_ratio is None:
        return 1
    return max(1, min(settings.most_parts, ceil(sqrt(ratio / settings.most_mass_ratio))))


# All parameters of a client and its bodies, so that no default and no earlier run affects results.


# [engine m/s] Largest speed of bodies and joints. PyBullet's default of 100 is 10 m/s at scale 100.
TOP_SPEED = 1e4

# Parameters common to all systems; most belong to the process and outlive the client.
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
    """Return all arguments of `setPhysicsEngineParameter`.

    Some, such as `contactBreakingThreshold`, belong to the process and outlive the client.
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


# More sub-steps occur only for bodies near a sliver. There PyBullet detects corners late, some hundredths of a
# millimetre deep, and pushes them out at metres a second: a plank that tipped over one gained 30 rad/s in one step
# (heap 385 of `benchmarks.energy`).
MOST_PUSHING = 16


def step_parameters(settings: PyBulletSettings, how: Stepping) -> dict[str, float]:
    """Return the arguments of `setPhysicsEngineParameter` that depend on the stepping."""
    parameters = {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale) / how.parts,
        "numSolverIterations": how.iterations,
    }
    if settings.maximal_coordinates:
        # A split impulse removes overlaps without adding velocity. It makes stacks at rest creep.
        parted = how.lively or how.parts > MOST_PUSHING
        parameters |= {"useSplitImpulse": int(parted), "splitImpulsePenetrationThreshold": 0.0}
        parameters["globalCFM"] = settings.first_cfm if how.may_hit else 0.0
    if settings.maximal_coordinates and not how.lively:
        # The velocity that removes a share of an overlap in one step grows with the number of sub-steps and ejects
        # deeply overlapping bodies. Division by the number itself would let light bricks yield under heavy ones.
        parameters["contactERP"] = settings.contact_erp / sqrt(how.parts)
    elif settings.maximal_coordinates:
        parameters["contactERP"] = settings.contact_erp
    return parameters


def body_parameters(settings: PyBulletSettings, own_friction: float) -> dict[str, float]:
    """Return all arguments of `changeDynamics` for a body except its mass."""
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


# Coulomb's cone for the friction on sliding bricks, directed against the sliding.
#
# PyBullet has two friction forces at a contact point, one against the sliding before the step and one across it, each
# limited by Coulomb's law alone. The force across prevents a contact from turning the sliding direction: a plank that
# turns does not drag a sliding plank above it aside, and a plank is slowed by up to 1.4 times the true friction.
#
# The engine's normal impulses p_n stay. The friction impulses outside their cones start a projected Jacobi iteration,
# with the masses split among the points of a body (Tonge, Benevolenski, Voroshilov, "Mass splitting for jitter-free
# parallel rigid body simulation", ACM Transactions on Graphics 31, 2012). With the sliding v of a point after the step,
# and its share m of the masses,
#
#     p_t  <-  the nearest to  p_t - m v  with  |p_t| <= mu p_n.


MOST_BODIES = 64  # in a larger engine reading the contacts takes longer than the step (docs/design/friction.md)
BEYOND = 1.005  # tolerated ratio of the friction to its limit
LEVEL = 0.5**0.5  # vertical component of a normal below which a contact presses more sideways than down
SWEEPS = 8  # Jacobi iterations; with one, planks hit at 1 m/s slide up to 13 % too far, with four 5 %
TINY = np.finfo(float).tiny
# By axis of a unit impulse along W: the two axes that it turns a body about, the part of the arm that it acts on, and
# the sign; the lower axis first.
ABOUT = np.array([[1, 0, 0], [2, 2, 1]])
ARM = np.array([[2, 2, 1], [1, 0, 0]])
SIGN = np.array([[1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]])[:, :, None]
AXES = np.arange(3)
ORDER = np.array([0, 2, 1])  # order of the sum of products along the axes
# Parts of a body's speed that move a point along each axis of W: the velocity, and two parts of the angular velocity.
SEEN = np.array([AXES, *(3 + ABOUT)])[:, :, None]
ALL_PARTS = np.arange(6)[:, None]  # of a speed
MASS, FRICTION, MOMENTS = 0, 1, 2  # items of `getDynamicsInfo`
# Items of a point of `getContactPoints`.
A, B, ON_A, ON_B, NORMAL, PRESSES, ALONG, WAY, ACROSS, OTHER_WAY = 1, 2, 5, 6, 7, 9, 10, 11, 12, 13


@dataclass(slots=True)
class SlidingFriction:
    """Corrects sliding friction; caches the properties of the bodies between changes."""

    client: int
    _infos: dict[int, Sequence[Any]] = field(default_factory=dict, init=False)
    _friction: dict[int, float] = field(default_factory=dict, init=False)
    _held: set[int] = field(default_factory=set, init=False)

    def begin(self) -> None:
        """Clear the cache: call this before a series of engine steps, as bodies may have changed."""
        self._infos.clear()
        self._friction.clear()
        self._held.clear()

    def turn(self, duration: float) -> None:
        """Correct the velocities after a step of a duration [engine s] to those of friction within its cones.

        Does nothing with more than `MOST_BODIES`, where the final place of a brick is random anyway.
        """
        client, frictions, frozen = self.client, self._friction, self._held
        if pybullet.getNumBodies(physicsClientId=client) > MOST_BODIES:
            return
        points = pybullet.getContactPoints(physicsClientId=client) or ()
        for body in {point[end] for point in points for end in (A, B)} - frictions.keys():
            self._infos[body] = info = pybullet.getDynamicsInfo(body, -1, client)
            frictions[body] = info[FRICTION]
            if info[MASS] == 0.0:
                frozen.add(body)
        beyond = [
            point
            for point in points
            if hypot(point[ALONG], point[ACROSS]) > BEYOND * frictions[point[A]] * frictions[point[B]] * point[PRESSES]
            and not (point[A] in frozen and point[B] in frozen)  # frozen bodies keep the values from before
        ]
        if beyond:
            bodies = _Bodies.of(client, beyond, self._infos)
            limits = np.array([frictions[point[A]] * frictions[point[B]] * point[PRESSES] for point in beyond])
            _project(bodies, beyond, duration, duration * limits)
            bodies.move(client)


def presses_sideways(client: int) -> bool:
    """Check that two free bodies pressed on each other more sideways than down in the last step.

    Returns False with more than `MOST_BODIES`, where the check takes too long.
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
    """Bodies of a client, one per column."""

    columns: dict[int, int]  # by number
    places: Array  # (3, n) centres
    speeds: Array  # (6, n) velocity and angular velocity, W
    inverse_masses: Array  # (n,) inverse masses; 0 of frozen bodies
    inverse_inertias: Array  # (n, 3, 3) inverse inertias, W; 0 of frozen bodies

    @classmethod
    def of(cls, client: int, points: Sequence[Sequence[Any]], infos: Mapping[int, Sequence[Any]]) -> "_Bodies":
        """Read the bodies of some contact points; `infos` is the result of `getDynamicsInfo` by body."""
        numbers = dict.fromkeys(point[end] for point in points for end in (A, B))
        poses = [pybullet.getBasePositionAndOrientation(body, client) for body in numbers]
        motions = [pybullet.getBaseVelocity(body, client) for body in numbers]
        axes = np.array([pybullet.getMatrixFromQuaternion(orientation) for _, orientation in poses]).reshape(-1, 3, 3)
        masses = np.array([infos[body][MASS] for body in numbers])
        free = masses > 0.0
        inverse_masses, inverse_inertias = np.zeros(len(masses)), np.zeros_like(axes)
        inverse_masses[free] = 1.0 / masses[free]
        moments = np.array([infos[body][MOMENTS] for body in numbers])
        inverse_inertias[free] = axes[free] / moments[free, None] @ axes[free].transpose(0, 2, 1)
        return cls(
            {body: column for column, body in enumerate(numbers)},
            np.array([position for position, _ in poses]).T,
            np.array([(*velocity, *spin) for velocity, spin in motions]).T.copy(),
            inverse_masses,
            inverse_inertias,
        )

    def pairs(self, points: Sequence[Sequence[Any]]) -> NDArray[np.intp]:
        """Return the columns of the bodies of some points, (points, 2)."""
        columns = (self.columns[point[end]] for point in points for end in (A, B))
        return np.fromiter(columns, np.intp, 2 * len(points)).reshape(-1, 2)

    def move(self, client: int) -> None:
        """Write the velocities to the client."""
        free, speeds = self.inverse_masses.tolist(), self.speeds.T.tolist()
        for body, column in self.columns.items():
            if free[column] > 0.0:
                velocity, spin = speeds[column][:3], speeds[column][3:]
                pybullet.resetBaseVelocity(body, velocity, spin, physicsClientId=client)


def _project(bodies: _Bodies, points: Sequence[Sequence[Any]], duration: float, limits: Array) -> None:
    """Project the friction of some points into cones with these limits [engine N s], and change the bodies' speeds.

    The last axis of arrays is that of the points, or of the two bodies of each: numpy is many times faster along it
    than along an axis of three. Explicit sums make the last bit independent of the machine.
    """
    pairs, number = bodies.pairs(points), len(bodies.columns)
    ends = pairs.ravel()  # of the first point, then of the second, and so on
    places, normals, ways, other_ways, along, across = _point_arrays(points)
    arms = places.transpose(1, 2, 0).reshape(3, -1) - bodies.places[:, ends]
    signs = np.tile((1.0, -1.0), len(points))  # with which sign an impulse acts on the body
    levers = SIGN * arms[ARM] * signs  # (2, 3, ends): the moments of a unit of impulse along each axis of W
    responses = _responses(bodies, ends, levers, signs)
    compliances = _compliances(normals, levers, responses, np.bincount(ends, minlength=number)[ends])
    # (2 bodies, 3 parts of a speed, 3, points): indices of the speeds that slide a point along each axis, and factors.
    slides = number * SEEN + pairs.T[:, None, None]
    shares = np.concatenate((np.broadcast_to(signs, (1, 3, len(ends))), levers)).reshape(3, 3, -1, 2)
    shares = shares.transpose(3, 0, 1, 2).copy()
    impulses = duration * (along * ways + across * other_ways)  # on the first body
    on_both = np.arange(impulses.size).reshape(3, 1, -1).repeat(2, axis=2)[ORDER]
    responses, changed = responses[:, ORDER].transpose(1, 0, 2).copy(), (number * ALL_PARTS + ends).ravel()
    speeds = bodies.speeds.reshape(-1)
    for _ in range(SWEEPS):
        parts = (speeds.take(slides) * shares).reshape(6, 3, -1)
        sliding = np.add.reduce(parts, axis=0, initial=0.0)
        x, y, z = sliding * normals
        sliding -= (x + z + y) * normals
        projected = impulses - sliding / compliances
        sizes = np.sqrt(np.add.reduce(projected * projected, axis=0))
        projected *= np.minimum(1.0, limits / np.maximum(sizes, TINY))
        changes = responses * (projected - impulses).take(on_both)
        np.add.at(speeds, changed, np.add.reduce(changes, axis=0, initial=0.0).ravel())
        impulses = projected


def _point_arrays(points: Sequence[Sequence[Any]]) -> tuple[Array, ...]:
    """Return positions on both bodies, normals, friction directions, and friction forces along these of points."""
    values = (p[ON_A] + p[ON_B] + p[NORMAL] + p[WAY] + p[OTHER_WAY] + (p[ALONG], p[ACROSS]) for p in points)
    rows = np.fromiter(chain.from_iterable(values), float, 17 * len(points)).reshape(-1, 17).T.copy()
    return rows[:6].reshape(2, 3, -1), rows[6:9], rows[9:12], rows[12:15], rows[15], rows[16]


def _responses(bodies: _Bodies, ends: NDArray[np.intp], levers: Array, signs: Array) -> Array:
    """Return the speeds that a unit impulse along each axis of W gives the body of each end, (6, 3, ends)."""
    moments, inverse_inertias = np.zeros((len(ends), 3, 3)), np.zeros((6, 3, len(ends)))
    for about, lever in zip(ABOUT, levers, strict=True):
        moments[:, about, AXES] = lever.T
    inverse_inertias[AXES, AXES] = bodies.inverse_masses[ends] * signs
    inverse_inertias[3:] = (bodies.inverse_inertias[ends] @ moments).transpose(1, 2, 0)
    return inverse_inertias


def _compliances(normals: Array, levers: Array, responses: Array, shared: NDArray[np.intp]) -> Array:
    """Return upper bounds of the points' tangential compliance, with each mass split among a body's points."""
    parts = np.empty((3, 3, 3, len(shared)))
    np.multiply(np.abs(responses[:3]), shared, out=parts[0])
    np.multiply(levers[:, :, None] * responses[3 + ABOUT], shared, out=parts[1:])
    one_by_one = parts.reshape(3, 9, -1, 2).transpose(3, 0, 1, 2).reshape(6, 9, -1)
    lighter = np.add.reduce(one_by_one, axis=0, initial=0.0)
    beside = (normals[:, None] * lighter.reshape(3, 3, -1) * normals).reshape(9, -1)
    compliances: Array = lighter[0] + lighter[4] + lighter[8] - np.add.reduce(beside, axis=0)
    return compliances


@dataclass
class Anchors:
    """Friction anchors: springs that hold resting contacts in place while all bodies are slow.

    Only bricks that lie square have them; a leaning brick would stand where it should slip.
    """

    bodies: ClientBodies
    enabled: bool  # whether the settings use anchors
    _quiet: bool = field(default=True, init=False)
    _bricks: set[BodyId] = field(default_factory=set, init=False)

    def add(self, brick: BodyId) -> None:
        """Anchor a new brick while all bodies are slow."""
        if self.enabled:
            self._bricks.add(brick)
            self._tell([brick])

    def remove(self, brick: BodyId) -> None:
        """Remove a brick."""
        self._bricks.discard(brick)

    def renew(self, brick: BodyId) -> None:
        """Anchor the new body of a brick, if the old one was anchored."""
        if brick in self._bricks:
            self._tell([brick])

    def choose(self, lively: bool) -> None:
        """Switch all anchors off while bodies are fast, and on otherwise."""
        self._quiet = not lively
        self._tell(sorted(self._bricks, key=self.bodies.numbers.__getitem__))

    def _tell(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            body = self.bodies.numbers[brick]
            pybullet.changeDynamics(body, -1, frictionAnchor=int(self._quiet), physicsClientId=self.bodies.client)


# Exact free fall of released bodies.
#
# PyBullet moves a body by its velocity after the step. So velocities belong to the middle of a step, and gravity acts
# from there to the middle of the next: for half a step on a released body, and for the mean of two steps where their
# durations differ.


@dataclass
class FreeFall:
    """Released bodies without contacts, and the gravity of the engine."""

    bodies: ClientBodies
    gravity: float  # [m/s2] along -z
    exact: bool
    flying: set[BodyId] = field(default_factory=set, init=False)  # released, and without contacts since
    _let_go: set[BodyId] = field(default_factory=set, init=False)  # released since the last step
    acceleration_W: Vec3 = field(default=AT_REST, init=False)  # of the ground [m/s2]
    _pulls: Vec3 = field(init=False)  # last gravity of the engine [m/s2]
    _last_step: float = field(default=0.0, init=False)  # duration of the last engine step [s]
    # Called before each engine step with its gravity [m/s2] and its duration [s].
    before: Callable[[Vec3, float], None] = field(default=lambda _pull_W, _duration: None, init=False)

    def __post_init__(self) -> None:
        self._pulls = (0.0, 0.0, -self.gravity)

    def begin(self, body: BodyId) -> None:
        """Record the release of a body."""
        if self.exact:
            self._let_go.add(body)

    def end(self, body: BodyId) -> None:
        """Record that a body needs no correction: it does not fall, or its velocity is already corrected."""
        self._let_go.discard(body)
        self.flying.discard(body)

    def step(self, duration: float) -> None:
        """Advance by an engine step of a duration [s], including the bodies released since the last."""
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
        """Advance by another engine step of the same duration [s]."""
        self.before(self._pulls, duration)
        pybullet.stepSimulation(self.bodies.client)

    def _pull(self, gravity: float) -> None:
        """Set the engine's gravity, including the inertial acceleration from the ground's motion [m/s2]."""
        x, y, z = self.acceleration_W
        pull = (-x, -y, -gravity - z)
        # A released body keeps the gravity of the time when it was frozen, so it is set again.
        if pull != self._pulls or self.acceleration_W != AT_REST:
            pybullet.setGravity(*pull, self.bodies.client)
            self._pulls = pull

    def _lift(self, speed: float) -> None:
        """Add an upward velocity [m/s] to the released bodies."""
        for name in sorted(self._let_go, key=self.bodies.numbers.__getitem__):
            (vx, vy, vz), angular_velocity = self.bodies.raw_motion(name)
            lifted = (vx, vy, vz + speed * sqrt(self.bodies.scale))
            self.bodies.set_raw_motion(name, lifted, angular_velocity)
        self.flying |= self._let_go
        self._let_go.clear()

    def corrected(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, BodyState]:
        """Correct the velocities of falling bodies: the engine's are those of the middle of the last step."""
        corrected = dict(states)
        for name in self.flying & corrected.keys():
            if self.bodies.raw_contacts(name):
                self.flying.discard(name)
            else:
                since = (0.0, 0.0, -0.5 * self.gravity * self._last_step)
                corrected[name] = replace(corrected[name], velocity_W=add(corrected[name].velocity_W, since))
        return corrected


@dataclass
class Stepper:
    """Clock of a world, and the sub-steps of its next step."""

    client: int
    settings: PyBulletSettings
    fall: FreeFall
    presses: AppliedLoads = field(default_factory=AppliedLoads, init=False)
    sliding: SlidingFriction = field(init=False)
    time: float = field(default=0.0, init=False)  # [s]
    _fastest: float = field(default=0.0, init=False)  # [m/s]
    _new_contact_steps: int = field(default=0, init=False)  # remaining steps with new contacts
    _up_to_date: bool = field(default=False, init=False)  # False after a change of the awake bodies
    _stepping: Stepping = field(init=False)  # as set in the engine

    def __post_init__(self) -> None:
        self._stepping = stepping(self.settings, AwakeBodies())
        self.sliding = SlidingFriction(self.client)

    @property
    def lively(self) -> bool:
        """Whether bodies are fast enough to hit others, as of the last update."""
        return self._stepping.lively

    @property
    def part(self) -> float:
        """Duration of an engine step [s], as of the last update."""
        return self.settings.time_step / self._stepping.parts

    def set_max_speed(self, fastest: float) -> None:
        """Set the maximum speed of the bodies in the next steps [m/s]."""
        self._fastest, self._up_to_date = fastest, False

    def substep_next_contact(self) -> None:
        """Split the next steps as the settings require for new contacts.

        A body is woken some ten steps before it is hit, and may be pushed for twice as many, so the number is doubled.
        """
        self._new_contact_steps, self._up_to_date = 2 * self.settings.first_steps, False

    def on_awake_changed(self) -> None:
        """Record a change of the awake bodies."""
        self._up_to_date = False

    def update(self, mass_ratio: Callable[[], float]) -> bool:
        """Update the engine's stepping for the awake bodies; return whether `lively` has changed.

        `mass_ratio` returns the ratio of the largest to the smallest mass of the awake bodies.
        """
        if self._up_to_date:
            return False
        before = self._stepping
        ratio = 1.0 if self.settings.most_mass_ratio is None else mass_ratio()
        self._stepping = stepping(self.settings, AwakeBodies(self._fastest, ratio, self._new_contact_steps > 0))
        self._up_to_date = True
        if self._stepping != before:
            parameters = step_parameters(self.settings, self._stepping)
            pybullet.setPhysicsEngineParameter(**parameters, physicsClientId=self.client)
        return self._stepping.lively != before.lively

    def step(self) -> None:
        """Advance by one time step, in its sub-steps."""
        parts = self.pass_step()
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
        if self._new_contact_steps:
            self._new_contact_steps -= 1
            if self._new_contact_steps == self.settings.first_steps and not self._pushes_on():
                self._new_contact_steps = 0
            self._up_to_date = self._up_to_date and self._new_contact_steps > 0

    def pass_step(self) -> int:
        """Advance the clock by a step; return its number of sub-steps."""
        self.time += self.settings.time_step
        return self._stepping.parts

    def _pushes_on(self) -> bool:
        """Check that a thrown or falling body still pushes the body that it hit."""
        return self._stepping.may_hit and presses_sideways(self.client)

    def _exert(self, duration: float) -> None:
        """Apply the loads on bodies in the next engine step of a duration [s].

        They act as changes of velocity: PyBullet omits the torque of forces when it solves friction, so that a brick
        that is loaded on one side would slide away.
        """
        for acting in self.presses.acting(self.fall.bodies, duration):
            after = acting.pushed()
            self.fall.bodies.set_motion(acting.brick.id, after.velocity_W, after.angular_velocity_W)
