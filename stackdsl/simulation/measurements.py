"""Measures a run: energy, sway, landing, onset, overlap, support shares, tunnelling."""

from collections import defaultdict
from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import dist, hypot, radians, sqrt
from typing import TYPE_CHECKING

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.edge_normals import WrongNormal, wrong_normals
from stability.engines.protocol import EngineSettings, World
from stability.engines.scene_scale import SAMPLING, USUAL_GRAVITY
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import InPlace, apart_from_plane, bodies_apart, in_place, inertia_times
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import add, cross, dot, inverse, norm, rotate, scale, subtract, turn_between
from stability.model import BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Vec3
from stability.problem import Contact, Motion, Placed, Tolerances, Verdict
from stability.stabilizers.rest import RestLimits, relative_size
from stackdsl.simulation.brick_tracks import NOT_MOVING, BrickTracker
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import (
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    Energy,
    Landing,
    Onset,
    PassedThrough,
    Penetration,
    Sway,
    WrongEdges,
)

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder


# The work of shaking ground on bricks, in the frame of the ground. The engine does not add this energy by itself.
#
# In that frame the inertial force -m a acts on a brick of mass m and does the work -m a dx. The path between two looks
# is the cubic through both positions and velocities, in parts so short that the acceleration is nearly constant.


PARTS = 4  # of the time between two looks, of some 10 ms each


@dataclass
class GroundWork:
    """The work of the ground on each brick since the last action."""

    motion: GroundMotion | None = None  # None while the ground does not shake
    net: dict[BodyId, float] = field(default_factory=dict)  # [J]
    gross: dict[BodyId, float] = field(default_factory=dict)  # sum of absolute values [J]
    # The last time, and position and velocity then.
    _seen: dict[BodyId, tuple[float, Vec3, Vec3]] = field(default_factory=dict)

    def start(self) -> None:
        """Count from now on."""
        self.net, self.gross = {}, {}

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of bricks that may have moved; `bricks` has all of them."""
        if self.motion is None:
            return
        for name, state in states.items():
            here = (time, state.pose.position_W, state.velocity_W)
            before, self._seen[name] = self._seen.get(name, here), here
            if before[0] < time and before[0] < self.motion.ends:
                work = -bricks[name].mass * self._integral(before, here)
                self.net[name] = self.net.get(name, 0.0) + work
                self.gross[name] = self.gross.get(name, 0.0) + abs(work)

    def forget(self, brick: BodyId) -> None:
        """Forget a brick that was removed."""
        self._seen.pop(brick, None)

    def _integral(self, before: tuple[float, Vec3, Vec3], here: tuple[float, Vec3, Vec3]) -> float:
        """Return the integral of the acceleration over the path between two looks [m2/s2]."""
        assert self.motion is not None
        directions = [direction_W for _, direction_W in self.motion.components]
        ends = [
            tuple((time, dot(along, position), dot(along, velocity)) for time, position, velocity in (before, here))
            for along in directions
        ]
        part, integral, last = (here[0] - before[0]) / PARTS, 0.0, [start[1] for start, _ in ends]
        for number in range(1, PARTS + 1):
            places = [_cubic_between(start, end, number / PARTS) for start, end in ends]
            means = self.motion.means(before[0] + (number - 1) * part, part)
            integral += sum(mean * (place - old) for mean, place, old in zip(means, places, last, strict=True))
            last = places
        return integral


def _cubic_between(before: tuple[float, float, float], here: tuple[float, float, float], share: float) -> float:
    """Return the value of the cubic through two positions with their speeds, after a share of the time."""
    (t0, x0, v0), (t1, x1, v1) = before, here
    s, span = share, t1 - t0
    return x0 + (x1 - x0) * s * s * (3.0 - 2.0 * s) + span * (v0 * s * (1.0 - s) ** 2 - v1 * s * s * (1.0 - s))


# Kinetic and potential energy of all bricks, to detect energy that the engine adds by itself.
#
# Exact for the poses and velocities of the engine at one time. Bricks that are not looked at do not move.


ROSE = 1e-3  # share of the smallest side, 8 micrometres for a plank: creep stays below


def kinetic_energy(brick: Brick, state: BodyState) -> float:
    """Return the energy of translation and rotation of a brick [J]."""
    spin_W = state.angular_velocity_W
    rotation = dot(inertia_times(brick, state.pose.orientation, spin_W), spin_W)
    return 0.5 * (brick.mass * dot(state.velocity_W, state.velocity_W) + rotation)


@dataclass(frozen=True, slots=True)
class _Seen:
    """The energy of a brick at the last look."""

    energy: float = 0.0  # kinetic + potential, with vertical heights [J]
    by_distance: float = 0.0  # kinetic + potential, with distances from the ground as heights [J]
    height: float = 0.0  # [m]
    pose: Pose | None = None  # None before the first look


NOTHING_SEEN = _Seen()
TOUCHES = 0.01  # of a brick's smallest side: bodies that are nearer touch each other


@dataclass
class EnergyMeter:
    """Sums the energy of all bricks; potential energy is zero at the ground.

    The gain is that of the bricks that moved, relative to their own energy, as a large block at rest would hide it. A
    brick has moved if it was too fast to be at rest between two looks, or has risen or sunk since the last action. A
    notable gain is reduced by what others have given that are connected to these by contacts: a heavy brick that sinks
    by a micrometre can push light ones. For the relative gain, heights are distances from the ground, which are small
    on a steep slope too.
    """

    gravity: float  # [m/s2], along -z
    ground: Plane
    most_gain: float = EngineSettings.most_gain  # share of energy by which the engine may err
    now: float = 0.0  # kinetic + potential energy of all bricks [J]
    outside: GroundWork = field(default_factory=GroundWork)  # work of the shaking ground
    _bricks: Mapping[BodyId, Brick] = field(default_factory=dict)  # of the last look
    _of: dict[BodyId, _Seen] = field(default_factory=dict)
    _start: float | None = None  # energy of all bricks at the last action [J]; None before the first
    _at_start: dict[BodyId, _Seen] = field(default_factory=dict)  # of bricks seen since the last action
    _moved: dict[BodyId, None] = field(default_factory=dict)  # since the last action
    _risen: float = 0.0  # largest increase of the energy of these bricks [J]
    _gained_before: float = 0.0  # largest relative gain before the last action

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of bricks that may have moved; `bricks` has all of them."""
        self.outside.see(time, bricks, states)
        self._bricks = bricks
        for name, state in states.items():
            brick = bricks[name]
            weight, centre_W = brick.mass * self.gravity, subtract(state.pose.position_W, self.ground.point_W)
            kinetic, was, height = kinetic_energy(brick, state), self._of.get(name, NOTHING_SEEN), centre_W[2]
            by_distance = kinetic + weight * dot(self.ground.normal_W, centre_W)
            self._of[name] = own = _Seen(kinetic + weight * height, by_distance, height, state.pose)
            self.now += own.energy - was.energy
            if abs(height - self._at_start.setdefault(name, was).height) > ROSE * brick.shape.least_thickness:
                self._moved[name] = None

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """Subtract the energy of removed bricks."""
        for name in bricks:
            self.now -= self._of.pop(name).energy
            self.outside.forget(name)

    def start(self, by_hand: bool = False) -> None:
        """Count gains from now on, after an action and a look at all bricks.

        Energy that came `by_hand` until now is no gain.
        """
        if not by_hand and (until_now := self.energy()) is not None:
            self._gained_before = max(self._gained_before, until_now.gain)
        self._start, self._at_start, self._moved, self._risen = self.now, {}, {}, 0.0
        self.outside.start()

    def look(self, moved: Iterable[BodyId]) -> None:
        """Update the gain after a look at all moving bricks; `moved` were too fast to be at rest."""
        self._moved |= dict.fromkeys(moved)
        gain = sum(map(self._gain, self._moved))
        if gain > max(self._risen, self.most_gain * self._reference()):
            gain += self._given_by_touching()
        self._risen = max(self._risen, gain)

    def _gain(self, name: BodyId) -> float:
        """Return the energy that a brick has gained since the last action beyond the work done on it [J]."""
        return self._of[name].energy - self._at_start[name].energy - self.outside.net.get(name, 0.0)

    def _reference(self) -> float:
        """Return the energy of the bricks that moved at the last action, and the work done on them since [J]."""
        return sum(self._at_start[name].by_distance + self.outside.gross.get(name, 0.0) for name in self._moved)

    def _given_by_touching(self) -> float:
        """Return the gain of bricks that have hardly moved and are connected to some that moved [J], at most 0."""
        near: Neighbours[BodyId] = Neighbours()
        poses = [(name, self._of[name].pose) for name in self._at_start]
        placed = {name: in_place(self._bricks[name].shape, pose) for name, pose in poses if pose is not None}
        for name, body in placed.items():
            near.add(name, body.low_W, body.high_W)
        touching: dict[BodyId, None] = dict.fromkeys(self._moved)
        waiting = list(touching)
        while waiting:
            name = waiting.pop()
            reach = TOUCHES * self._bricks[name].shape.least_thickness
            others = [each for each in near.neighbours(name, reach) if each not in touching]
            new = [each for each in others if bodies_apart(placed[name], placed[each]).gap <= reach]
            touching |= dict.fromkeys(new)
            waiting += new
        return min(0.0, sum(self._gain(name) for name in touching if name not in self._moved))

    @property
    def notably_gained(self) -> bool:
        """Whether the gain since the last action is large enough to be a fault of the engine."""
        energy = self.energy()
        return energy is not None and energy.gain > self.most_gain

    def energy(self) -> Energy | None:
        """Return the energy after the last action and its largest increase since; None before the first action."""
        if self._start is None:
            return None
        return Energy(self._start, self._risen, self._reference(), self._gained_before, self.most_gain)


# Amplitude and frequency of swaying bricks. Swaying differs from creep and shift, as the brick comes back.
#
# For every brick that has come to rest, the path of its centre along x and along y is cut at its turning points. A
# swing is one path out and the next path back. Its amplitude is half of the shorter of both, and its period the time of
# both. So creep is no swing, however far it goes. The result is the largest swing of all bricks.


TREMBLE = 1e-4  # of a brick's smallest side: a smaller reversal is no turning point; a micrometre for a plank


@dataclass
class _Way:
    """The path of one brick along one axis; turning points as time [s] and position [m]."""

    noise: float  # [m]
    before: tuple[float, float]  # last turning point but one; the rest position at first
    turned: tuple[float, float] | None = None  # last turning point
    farthest: tuple[float, float] = (0.0, 0.0)  # farthest position since then
    direction: float = 0.0  # 1 or -1: direction since then; 0 before the first motion beyond noise

    def see(self, time: float, place: float) -> tuple[float, float]:
        """Return amplitude [m] and period [s] of the current or just ended swing; zeros before the first."""
        if self.direction == 0.0:
            if abs(place - self.before[1]) <= self.noise:
                self.before = (time, self.before[1])
                return 0.0, 0.0
            self.direction, self.farthest = 1.0 if place > self.before[1] else -1.0, (time, place)
        if self.direction * (place - self.farthest[1]) >= 0.0:
            self.farthest = (time, place)
        elif abs(place - self.farthest[1]) > self.noise:
            self.before, self.turned = self.turned or self.before, self.farthest
            self.farthest, self.direction = (time, place), -self.direction
        if self.turned is None:
            return 0.0, 0.0
        out, back = abs(self.turned[1] - self.before[1]), abs(self.farthest[1] - self.turned[1])
        return 0.5 * min(out, back), self.farthest[0] - self.before[0]


@dataclass
class SwayMeter:
    """Finds the largest swing before a brick leaves its place."""

    watch: BrickTracker
    sway: Sway | None = None
    _ways: dict[BodyId, tuple[_Way, _Way]] = field(default_factory=dict)
    _looked: float = 0.0  # time of the last look [s]

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks."""
        if self.watch.first_to_leave() is not None:
            return
        for name, state in states.items():
            watched = self.watch.bricks[name]
            if watched.rest is None:  # thrown, or dropped and not yet at rest
                continue
            if name not in self._ways:
                noise = TREMBLE * watched.placement.brick.shape.least_thickness
                x, y, _ = watched.rest.position_W
                began = max(self._looked, time - SAMPLING)
                self._ways[name] = (_Way(noise, (began, x)), _Way(noise, (began, y)))
            for way, place in zip(self._ways[name], state.pose.position_W[:2], strict=True):
                amplitude, period = way.see(time, place)
                if amplitude > (self.sway.amplitude if self.sway is not None else 0.0):
                    self.sway = Sway(amplitude, 1.0 / period, name, time)
        self._looked = time


# Landing: the common centre of mass of the fallen bricks at the moment of their largest kinetic energy.
#
# A tipping tower hits the ground with its top first and along its whole length within moments; then it slides and
# scatters. Its kinetic energy rises until the ground absorbs it. So the peak of the kinetic energy of all bricks that
# have left their places is the moment of landing, whichever contact came first.


OVER = 0.01  # share of the peak energy; with less, fallen bricks only rock and slide
LANDED = 0.5  # share of the peak energy so far; with less, the ground has absorbed the rest


@dataclass
class LandingWatch:
    """Finds the peak of the kinetic energy of bricks that have left their places."""

    watch: BrickTracker
    falling: bool = False  # whether the peak may be near
    _now: float = 0.0  # kinetic energy at the last look [J]
    _most: float = 0.0  # kinetic energy at the peak so far [J]
    _time: float = 0.0  # of the peak [s]
    _at: dict[BodyId, Vec3] = field(default_factory=dict)  # positions of all moving bricks at the peak

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks."""
        bricks = self.watch.bricks
        energy = sum(kinetic_energy(bricks[name].placement.brick, states[name]) for name in self.watch.left(states))
        self._now = energy
        self.falling = energy > LANDED * self._most
        if energy > self._most:
            self._most, self._time = energy, time
            self._at = {name: state.pose.position_W for name, state in states.items()}

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """Return the landing of these bricks; one at rest at that moment counts with its rest position."""
        if not fallen or not self._at:
            return None
        mass, x, y = 0.0, 0.0, 0.0
        for name in fallen:
            watched = self.watch.bricks[name]
            before = (watched.rest or watched.last).position_W
            then = self._at.get(name, before)
            mass += watched.placement.brick.mass
            x += watched.placement.brick.mass * (then[0] - before[0])
            y += watched.placement.brick.mass * (then[1] - before[1])
        return Landing(self._time, (x / mass, y / mass), self._now < OVER * self._most)


# Onset of a fall that statics prove: the poses of its bricks before, and when the first has turned by 5 deg.


BEGUN = radians(5.0)  # rotation that shows the mechanism of a fall, before collisions change it
STUCK = 1e-2  # share of the largest speed: a contact point that slides less is a centre of rotation


@dataclass
class OnsetWatch:
    """Follows the bricks that the last proof of a fall names."""

    motion: Motion | None = None
    onset: Onset | None = None
    _start: dict[BodyId, Pose] = field(default_factory=dict)
    _about: tuple[BodyId, ...] = ()

    @property
    def waiting(self) -> bool:
        """Whether a proven fall has not yet turned far enough."""
        return self.onset is None and self.motion is not None

    def proven(
        self,
        verdict: Verdict,
        bricks: Mapping[BodyId, Placed],
        planes: Sequence[Plane],
        awake: Container[BodyId],
    ) -> None:
        """Update with the verdict after an action; `bricks` are all present ones, some of them `awake`."""
        if self.onset is not None or verdict.motion is self.motion:
            return
        if verdict.motion is None and any(name in awake for name in self._start):
            return  # a stable verdict elsewhere does not stop a fall that has begun
        self.motion = verdict.motion
        self._start = {}
        if self.motion is not None:
            self._start = {name: bricks[name].pose for name in self.motion.velocity}
            self._about = turned_about(self.motion, bricks, planes)

    def see(self, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks."""
        if self.motion is None or self.onset is not None:
            return
        poses = {name: (pose, states[name].pose) for name, pose in self._start.items() if name in states}
        if max((turn_between(*pair) for pair in poses.values()), default=0.0) >= BEGUN:
            self.onset = Onset(self.motion, poses, self._about)


def turned_about(motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]) -> tuple[BodyId, ...]:
    """Return the resting bodies that a moving brick touches without slipping, by name."""
    fastest = max((_speed(motion, bricks[name]) for name in motion.velocity), default=0.0)
    resting = set()
    for mover, other, contact in _contacts(motion, bricks, planes):
        velocity, spin = motion.velocity[mover]
        centre = bricks[mover].pose.position_W
        slips = (norm(add(velocity, cross(spin, subtract(point, centre)))) for point in contact.points_W)
        if min(slips) <= STUCK * fastest:
            resting.add(other)
    return tuple(sorted(resting))


def _speed(motion: Motion, placed: Placed) -> float:
    """Return an upper bound of the speed of any point of a brick."""
    velocity, spin = motion.velocity[placed.brick.id]
    return norm(velocity) + norm(spin) * placed.brick.shape.bounding_radius


def _contacts(
    motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]
) -> Iterable[tuple[BodyId, BodyId, Contact]]:
    """Yield each contact of a moving brick with a resting body: the brick, the body, the contact."""
    from stability.contacts.bodies import solid  # noqa: PLC0415 -- only proofs need it
    from stability.contacts.detection import contacts_between, contacts_with_plane  # noqa: PLC0415 -- only proofs need it

    still = [solid(placed) for name, placed in bricks.items() if name not in motion.velocity]
    tolerances, any_friction = Tolerances(), 0.0
    for name in motion.velocity:
        mover = solid(bricks[name])
        touching = [(plane.id, contacts_with_plane(mover, plane, tolerances)) for plane in planes]
        touching += [(other.id, contacts_between(mover, other, any_friction, tolerances)) for other in still]
        yield from ((name, other, contact) for other, contacts in touching for contact in contacts)


# Overlap of bodies by their shapes, independent of the contacts of the engine.
#
# Exact for every shape and the poses at one time. Bricks that are not looked at do not move.


@dataclass
class OverlapMeter:
    """Finds the largest overlap of two bodies."""

    planes: Sequence[Plane]
    penetration: Penetration | None = None  # None before the first brick
    _blocks: dict[BodyId, InPlace] = field(default_factory=dict)
    _near: Neighbours[BodyId] = field(default_factory=Neighbours)

    def see(self, time: float, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Update with the poses of bricks that may have moved; `bricks` has all of them."""
        self.put(bricks, poses)
        for name, pose in poses.items():
            self._compare(time, bricks[name], pose, poses)

    def put(self, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Store new poses without a comparison, as the bricks that move beside them have older poses."""
        for name, pose in poses.items():
            self.forget([name])
            block = self._blocks[name] = in_place(bricks[name].shape, pose)
            self._near.add(name, block.low_W, block.high_W)

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """Forget removed bricks."""
        for name in bricks:
            if self._blocks.pop(name, None) is not None:
                self._near.remove(name)

    def _compare(self, time: float, brick: Brick, pose: Pose, moving: Mapping[BodyId, Pose]) -> None:
        for plane in self.planes:
            self._note(time, brick.id, plane.id, -apart_from_plane(brick.shape, pose, plane).gap)
        for other in self._near.neighbours(brick.id, 0.0):
            if other not in moving or brick.id < other:  # each pair once
                self._note(time, brick.id, other, -bodies_apart(self._blocks[brick.id], self._blocks[other]).gap)

    def _note(self, time: float, brick: BodyId, other: BodyId, depth: float) -> None:
        if depth > (self.penetration.depth if self.penetration is not None else -1.0):
            self.penetration = Penetration(max(0.0, depth), brick, other, time)


# Moving bricks: those that moved too far between two looks, within the last tenth of a second, to be at rest.
#
# The limits are those of the stabilizer for freezing (`RestLimits`): 5 mm/s and 0.1 rad/s for a KAPLA plank on earth,
# ten times the noise of a solver. They scale with the size of each brick and with gravity (Froude): speeds with the
# root of size times gravity, times with the root of size over gravity. The hold-off is so long because a rocking brick
# stands still at its turning points. Displacements between looks are used because a solver may shake a brick within a
# step at a high speed that leads nowhere.


IN_PLACE = 1.0 / 3.0  # of the limits of a fall, within which a brick stays in place
LONG = 10.0  # hold-offs of rest, 1 s for a plank, after which a brick that stays in place leaves it no more


@dataclass
class MotionWatch:
    """The last time at which each brick moved."""

    gravity: float  # [m/s2]
    _seen: dict[BodyId, tuple[float, Pose]] = field(default_factory=dict)  # time [s] and pose of the last look
    _limits: dict[BodyId, RestLimits] = field(default_factory=dict)
    _moved_at: dict[BodyId, float] = field(default_factory=dict)  # [s]
    _radius: dict[BodyId, float] = field(default_factory=dict)  # within which it stays in place [m]
    _came: dict[BodyId, tuple[float, Pose]] = field(default_factory=dict)  # since when it has stayed near this pose

    def add(self, brick: Brick) -> None:
        """Add a brick."""
        size = relative_size(brick.shape)
        self._radius[brick.id] = IN_PLACE * COLLAPSE_SHARE_OF_SMALLEST_SIDE * brick.shape.least_thickness
        self._limits[brick.id] = RestLimits().scaled(size, sqrt(size * USUAL_GRAVITY / self.gravity))

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """Update with the states of bricks that may move; return those that did."""
        moved = []
        for name, state in states.items():
            if name in self._seen and not self._limits[name].slow(_state_between(*self._seen[name], time, state.pose)):
                self._moved_at[name] = time
                moved.append(name)
            self._seen[name] = (time, state.pose)
            if name not in self._came or self._has_left(name, state.pose):
                self._came[name] = (time, state.pose)
        return moved

    def _has_left(self, name: BodyId, here: Pose) -> bool:
        then = self._came[name][1]
        far = dist(here.position_W, then.position_W) > self._radius[name]
        return far or turn_between(then, here) > IN_PLACE * COLLAPSE_TILT

    def stopped(self, bricks: Iterable[BodyId]) -> None:
        """Forget bricks that are frozen or removed."""
        for name in bricks:
            self._moved_at.pop(name, None)
            self._seen.pop(name, None)
            self._came.pop(name, None)

    def in_place(self, now: float) -> frozenset[BodyId]:
        """Return the bricks that have long stayed near one pose, although they may rock there."""
        return frozenset(
            name for name, (since, _) in self._came.items() if now - since >= LONG * self._limits[name].hold_off
        )

    def moving(self, now: float) -> tuple[BodyId, ...]:
        """Return the bricks that still move, in order of placement."""
        moved_at, limits = self._moved_at, self._limits
        return tuple(name for name in limits if name in moved_at and now - moved_at[name] < limits[name].hold_off)


def _state_between(before: float, then: Pose, now: float, here: Pose) -> BodyState:
    """Return the state at the second pose, with the mean velocity from the first; times in [s]."""
    per_second = 1.0 / (now - before) if now > before else 0.0
    velocity_W = scale(per_second, subtract(here.position_W, then.position_W))
    return BodyState(here, velocity_W, (0.0, 0.0, per_second * turn_between(then, here)))


# Contacts of leaning bricks for which the engine has a wrong normal during a run.


QUIET = 5e-3  # [m/s] contacts of slower bricks hardly change and are checked less often
THOROUGH = 10  # one in so many looks checks all contacts


@dataclass
class NormalErrorMonitor:
    """Checks contact normals at the looks of the runner."""

    world: World
    gravity: float  # [m/s2]
    _looks: int = field(default=0, init=False)
    _seen: set[tuple[BodyId, BodyId]] = field(default_factory=set, init=False)
    _first: float | None = field(default=None, init=False)  # [s]
    _most: tuple[WrongNormal, float] | None = field(default=None, init=False)  # with its time [s]

    def look(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Check the contacts of moving bricks."""
        thorough, self._looks = self._looks % THOROUGH == 0, self._looks + 1
        moving = {brick: state for brick, state in states.items() if thorough or hypot(*state.velocity_W) > QUIET}
        for wrong in wrong_normals(self.world, moving, self.gravity):
            self._seen.add((wrong.upper, wrong.lower))
            self._first = time if self._first is None else self._first
            if self._most is None or wrong.angle > self._most[0].angle:
                self._most = wrong, time

    def absorb(self, other: "NormalErrorMonitor") -> None:
        """Add the results of another monitor."""
        self._seen |= other._seen
        first = [seen for seen in (self._first, other._first) if seen is not None]
        self._first = min(first, default=None)
        if other._most is not None and (self._most is None or other._most[0].angle > self._most[0].angle):
            self._most = other._most

    def wrong(self) -> WrongEdges | None:
        """Return the summary of all wrong normals; None if there were none."""
        if self._most is None or self._first is None:
            return None
        most, time = self._most
        return WrongEdges(len(self._seen), most.upper, most.lower, most.angle, time, self._first)


# Supports of a brick by the contact forces of a bare engine: the measure of `rests_on` without a model.


UPWARD = 0.5  # least z of a contact normal towards the carried brick; others are side contacts
LEAST_SHARE = 1e-3  # a body that carries a smaller share of a brick is no support


@dataclass
class ForceMeter:
    """Sums the upward force of each body on each brick over many steps, as engines scatter the load."""

    upward: dict[BodyId, dict[BodyId, float]] = field(default_factory=lambda: defaultdict(lambda: defaultdict(float)))
    loaded: set[BodyId] = field(default_factory=set)  # bricks on which the engine has reported a force

    def add(self, brick: BodyId, contacts: Iterable[ContactPoint]) -> None:
        """Add the upward contact forces on a brick in one step."""
        for point in contacts:
            if point.normal_force > 0.0:
                self.loaded.add(brick)
            other, z = (point.b, point.normal_BA_W[2]) if point.a == brick else (point.a, -point.normal_BA_W[2])
            if z >= UPWARD:
                self.upward[brick][other] += point.normal_force * z

    def shares(self, bricks: Iterable[BodyId]) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Return the supports of these bricks with their shares."""
        return {brick: self._shares(self.upward.get(brick, {})) for brick in bricks}

    def _shares(self, forces: Mapping[BodyId, float]) -> Mapping[BodyId, float]:
        total = sum(forces.values())
        return {on: force / total for on, force in forces.items() if force > LEAST_SHARE * total} if total > 0.0 else {}


# Tunnelling: a thrown brick passes through another one if the time step of the engine is too large for its speed.
#
# The centre of a rigid convex body cannot be inside another one. Between two looks the centre of a thrown brick moves
# on a straight line in the frame of the other brick. The error of this is much smaller than half the thickness of the
# brick, the least distance that the centre keeps on a true path.


@dataclass
class PassingWatch:
    """Finds the first thrown brick that passes through another."""

    watch: BrickTracker  # has the poses of the last look
    passed: PassedThrough | None = None

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks at a time [s]; call this before `watch.see`."""
        if self.passed is not None or not self.watch.dropped:
            return
        now = {name: state.pose for name, state in states.items()}
        self.passed = min(self._passed(time, now), default=(0.0, None), key=lambda each: each[0])[1]

    def _passed(self, time: float, now: Mapping[BodyId, Pose]) -> Iterator[tuple[float, PassedThrough]]:
        """Yield each pair of bricks, with the share of the path after which one enters the other."""
        for thrown in self.watch.dropped:
            name = thrown.placement.brick.id
            if not thrown.placement.hits or name not in now:
                continue
            before, after = thrown.last.position_W, now[name].position_W
            travel = dist(before, after)
            if travel <= 0.5 * thrown.placement.brick.shape.least_thickness:
                continue  # slow enough for the engine to detect the contact
            for other in self.watch.present:
                shape, was = self.watch.bodies[other].shape, self.watch.bricks[other].last
                pose = now.get(other, was)
                if other == name or dist(pose.position_W, after) > travel + shape.bounding_radius:
                    continue
                share = entry(shape, _seen_from(was, before), _seen_from(pose, after))
                if share is not None:
                    yield share, PassedThrough(name, other, time, travel)


def entry(shape: ConvexShape, start: Vec3, end: Vec3) -> float | None:
    """Return the share of a line between two points, in body axes [m], after which it enters a shape; None if never."""
    if isinstance(shape, Compound):
        entries = [
            entry(part.shape, _seen_from(part.place, start), _seen_from(part.place, end)) for part in shape.parts
        ]
        return min((share for share in entries if share is not None), default=None)
    first, last = 0.0, 1.0
    for face in shape.faces:
        outside = dot(face.normal, subtract(start, shape.corners[face.corners[0]]))
        rises = dot(face.normal, subtract(end, start))
        if rises == 0.0:
            if outside >= 0.0:
                return None
        elif rises < 0.0:
            first = max(first, -outside / rises)
        else:
            last = min(last, -outside / rises)
    return first if first < last else None


def _seen_from(pose: Pose, point_W: Vec3) -> Vec3:
    return rotate(inverse(pose.orientation), subtract(point_W, pose.position_W))


# All measurements of a run, from looks at moving bricks: tracks, energy, onset and landing of a fall.


@dataclass
class RunMeasurements:
    """The measurements of one run."""

    timeline: Timeline
    most_gain: float = EngineSettings.most_gain  # share of energy by which the engine may err
    watch: BrickTracker = field(init=False)
    energy: EnergyMeter = field(init=False)
    onset: OnsetWatch = field(default_factory=OnsetWatch)
    motion: MotionWatch = field(init=False)
    passing: PassingWatch = field(init=False)
    _landing: LandingWatch = field(init=False)
    sway: SwayMeter | None = None  # None unless requested
    overlap: OverlapMeter | None = None  # likewise
    recorder: "Recorder | None" = None  # likewise

    def __post_init__(self) -> None:
        gravity = self.timeline.world.gravity
        self.watch = BrickTracker(not_moving=NOT_MOVING.scaled(lengths=1.0, times=sqrt(USUAL_GRAVITY / gravity)))
        self.passing = PassingWatch(self.watch)
        self.energy = EnergyMeter(gravity, self.timeline.world.planes[0], self.most_gain)
        self.motion = MotionWatch(gravity)
        self._landing = LandingWatch(self.watch)
        if "sway" in self.timeline.measures:
            self.sway = SwayMeter(self.watch)
        if "penetration" in self.timeline.measures:
            self.overlap = OverlapMeter(self.timeline.world.planes)

    @property
    def swayed(self) -> Sway | None:
        """The largest swing, if requested."""
        return self.sway.sway if self.sway is not None else None

    @property
    def overlapped(self) -> Penetration | None:
        """The largest overlap, if requested."""
        return self.overlap.penetration if self.overlap is not None else None

    @property
    def close(self) -> bool:
        """Whether to look more often than usual."""
        return self.onset.waiting or self._landing.falling

    def add(self, placement: Placement) -> None:
        """Add a placed brick."""
        self.watch.add(placement)
        self.motion.add(placement.brick)
        state = BodyState(placement.came or placement.pose, placement.velocity_W)
        self._weigh(placement.time, {placement.brick.id: state})
        if self.recorder is not None:
            self.recorder.add(placement.time, placement.brick, state)
        if self.overlap is not None:
            self.overlap.see(placement.time, self.watch.bodies, {placement.brick.id: state.pose})

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        """Remove bricks at a time [s]."""
        bricks = tuple(bricks)
        self.watch.remove(bricks)
        self.motion.stopped(bricks)
        self.energy.forget(bricks)
        if self.overlap is not None:
            self.overlap.forget(bricks)
        if self.recorder is not None:
            self.recorder.remove(time, bricks)

    def shaken(self, motion: GroundMotion) -> None:
        """Begin to count the work of the shaking ground."""
        self.energy.outside.motion = motion

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update energy and recording with the states of some bricks at a time [s]."""
        self._weigh(time, states)
        self._record(time, states)

    def acted(self, states: Mapping[BodyId, BodyState], verdict: Verdict | None) -> None:
        """Update after an action and its verdict, with the states of all bricks that may move."""
        self.energy.start()
        if verdict is not None and self.timeline.closely:
            self.onset.proven(verdict, self.watch.placed_bricks(), self.timeline.world.planes, states)

    def judged(self, time: float, states: Mapping[BodyId, BodyState], frozen: Iterable[BodyId]) -> None:
        """Update with the states of bricks that were just woken or frozen; frozen ones get no further looks."""
        frozen = tuple(frozen)
        self.watch.see(time, states)
        self._weigh(time, states)
        self._record(time, states)
        if self.overlap is not None:
            self.overlap.put(self.watch.bodies, {name: state.pose for name, state in states.items()})
        self.watch.freeze(frozen)
        self.motion.stopped(frozen)

    def weigh(self, time: float, states: Mapping[BodyId, BodyState], driven: bool) -> None:
        """Update the energy with the moving bricks of one island; `driven` if hands or loads may move some of them."""
        self.see(time, states)
        self.energy.look(self.motion.see(time, states))
        if driven:
            self.energy.start(by_hand=True)  # the work of hands and loads cannot be told from a gain of the engine

    def look(self, time: float, states: Mapping[BodyId, BodyState], everything: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of the moving bricks of one island, and of `everything` that moves."""
        self.passing.see(time, states)
        self.watch.see(time, states)
        if self.sway is not None:
            self.sway.see(time, states)
        if self.overlap is not None:
            self.overlap.see(time, self.watch.bodies, {name: state.pose for name, state in states.items()})
        self.look_closely(time, everything)

    def look_closely(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update onset and landing, also between two looks; tracks are updated at looks only."""
        if self.timeline.closely:
            self.onset.see(states)
            self._landing.see(time, states)

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """Return the landing of these bricks."""
        return self._landing.landing(fallen)

    def _record(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        if self.recorder is not None:
            self.recorder.see(time, states)

    def _weigh(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        self.energy.see(time, self.watch.bodies, states)
