"""Measures a run: energy, sway, landing, onset, overlap, support shares, tunnelling."""

from collections import defaultdict
from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import dist, hypot, radians, sqrt
from typing import TYPE_CHECKING

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.edge_normals import WrongNormal, wrong_normals
from stability.engines.protocol import World
from stability.engines.scene_scale import SAMPLING, USUAL_GRAVITY
from stability.geometry.placed_shape import InPlace, apart_from_plane, bodies_apart, in_place, inertia_times
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import add, cross, dot, inverse, norm, rotate, scale, subtract, turn_between
from stability.model import BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Vec3
from stability.problem import Contact, Motion, Placed, Tolerances, Verdict
from stability.stabilizers.rest import RestLimits, relative_size
from stackdsl.simulation.brick_tracks import NOT_MOVING, BrickTracker
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import NOTABLE_GAIN, Energy, Landing, Onset, Passed, Penetration, Sway, WrongEdges

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder


# The work that shaking ground does on bricks, as seen from the ground: it is none that an engine added by itself.
#
# There a brick of mass m feels -m a, so that it gets -m a dx on its way. Between two looks at it, its way is the cubic
# through both places and speeds, in as many parts as it takes for the acceleration to be nearly even in each.


PARTS = 4  # of the time between two looks, of some 10 ms each


@dataclass
class GroundWork:
    """What was done on each brick since something was done last."""

    motion: GroundMotion | None = None  # None while the ground does not shake
    given: dict[BodyId, float] = field(default_factory=dict)  # [J]
    passed: dict[BodyId, float] = field(default_factory=dict)  # to and fro, all counted as more than zero [J]
    _seen: dict[BodyId, tuple[float, float, float]] = field(default_factory=dict)  # time, and place and speed along it

    def start(self) -> None:
        """Count from now on."""
        self.given, self.passed = {}, {}

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        if self.motion is None:
            return
        for name, state in states.items():
            along = self.motion.direction_W
            here = (time, dot(along, state.pose.position_W), dot(along, state.velocity_W))
            before, self._seen[name] = self._seen.get(name, here), here
            if before[0] < time and before[0] < self.motion.ends:
                work = -bricks[name].mass * self._weighed(before, here)
                self.given[name] = self.given.get(name, 0.0) + work
                self.passed[name] = self.passed.get(name, 0.0) + abs(work)

    def forget(self, brick: BodyId) -> None:
        """A brick is gone."""
        self._seen.pop(brick, None)

    def _weighed(self, before: tuple[float, float, float], here: tuple[float, float, float]) -> float:
        """The acceleration of the ground times the way through it, summed [m2/s2]."""
        assert self.motion is not None
        part, found, last = (here[0] - before[0]) / PARTS, 0.0, before[1]
        for number in range(1, PARTS + 1):
            place = _cubic_between(before, here, number / PARTS)
            found += self.motion.mean(before[0] + (number - 1) * part, part) * (place - last)
            last = place
        return found


def _cubic_between(before: tuple[float, float, float], here: tuple[float, float, float], share: float) -> float:
    """Where the cubic through two places with their speeds is after a share of the time."""
    (t0, x0, v0), (t1, x1, v1) = before, here
    s, span = share, t1 - t0
    return x0 + (x1 - x0) * s * s * (3.0 - 2.0 * s) + span * (v0 * s * (1.0 - s) ** 2 - v1 * s * s * (1.0 - s))


# Kinetic and potential energy of all bricks, so that what an engine adds by itself shows.
#
# Exact; of the poses and velocities that the engine has at one time. What is not looked at does not move.


ROSE = 1e-3  # share of the smallest side, 8 micrometres for a plank: what creeps stays within it


def kinetic_energy(brick: Brick, state: BodyState) -> float:
    """Of translation and rotation [J]."""
    spin_W = state.angular_velocity_W
    rotation = dot(inertia_times(brick, state.pose.orientation, spin_W), spin_W)
    return 0.5 * (brick.mass * dot(state.velocity_W, state.velocity_W) + rotation)


@dataclass(frozen=True, slots=True)
class _Seen:
    """What a brick had when it was seen last."""

    energy: float = 0.0  # kinetic + potential, heights straight down [J]
    by_distance: float = 0.0  # the same, heights as distances from the ground [J]
    height: float = 0.0  # [m]


NOTHING_SEEN = _Seen()


@dataclass
class EnergyMeter:
    """Adds up what is seen of the bricks; the ground is the level that potential energy counts from.

    A gain is that of those that moved, as a share of what they had: a large block elsewhere would hide it. They have
    got too far between two looks to be at rest, or have risen or sunk since the last action. Of that share, height
    counts as distance from the ground, which is small on a steep slope, too.
    """

    gravity: float  # [m/s2], along -z
    ground: Plane
    now: float = 0.0  # kinetic + potential energy of all bricks [J]
    outside: GroundWork = field(default_factory=GroundWork)  # what is done from outside
    _of: dict[BodyId, _Seen] = field(default_factory=dict)
    _start: float | None = None  # of all, once something was done [J]
    _at_start: dict[BodyId, _Seen] = field(default_factory=dict)  # of what was seen since
    _moved: dict[BodyId, None] = field(default_factory=dict)  # since
    _risen: float = 0.0  # how much more these had at most [J]
    _gained_before: float = 0.0  # the largest gain until then, as a share

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        self.outside.see(time, bricks, states)
        for name, state in states.items():
            brick = bricks[name]
            weight, centre_W = brick.mass * self.gravity, subtract(state.pose.position_W, self.ground.point_W)
            kinetic, was, height = kinetic_energy(brick, state), self._of.get(name, NOTHING_SEEN), centre_W[2]
            by_distance = kinetic + weight * dot(self.ground.normal_W, centre_W)
            self._of[name] = own = _Seen(kinetic + weight * height, by_distance, height)
            self.now += own.energy - was.energy
            if abs(height - self._at_start.setdefault(name, was).height) > ROSE * brick.shape.least_thickness:
                self._moved[name] = None

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out, and their energy with them."""
        for name in bricks:
            self.now -= self._of.pop(name).energy
            self.outside.forget(name)

    def start(self, by_hand: bool = False) -> None:
        """Something was done, and all was seen since: what comes now comes by itself.

        What came `by_hand` until now is no gain.
        """
        if not by_hand and (until_now := self.energy()) is not None:
            self._gained_before = max(self._gained_before, until_now.gain)
        self._start, self._at_start, self._moved, self._risen = self.now, {}, {}, 0.0
        self.outside.start()

    def look(self, moved: Iterable[BodyId]) -> None:
        """All that moves has been seen, and of that these got too far to be at rest."""
        self._moved |= dict.fromkeys(moved)
        given = self.outside.given
        more = sum(self._of[name].energy - self._at_start[name].energy - given.get(name, 0.0) for name in self._moved)
        self._risen = max(self._risen, more)

    @property
    def notably_gained(self) -> bool:
        """Whether so much was gained since the last action that it is a fault; what came before it was told then."""
        energy = self.energy()
        return energy is not None and energy.gain > NOTABLE_GAIN

    def energy(self) -> Energy | None:
        """What it was after the last action, and has been at most since; None if nothing was ever done."""
        if self._start is None:
            return None
        had = sum((self._at_start[name].by_distance for name in self._moved), 0.0)
        had += sum(self.outside.passed.get(name, 0.0) for name in self._moved)
        return Energy(self._start, self._risen, had, self._gained_before)


# How far, and how fast, does a brick go to and fro? Swaying is no creep and no shift: what sways comes back.
#
# Of every brick that has come to rest, the way of its centre is followed along x and along y, and cut where it turns. A
# swing is one way out and the way back after it; half of the shorter of both is its amplitude, and both together take
# its period. So a brick that creeps has none, however far it gets. The largest swing of all bricks tells.


TREMBLE = 1e-4  # of a brick's smallest side: who comes back by less has not turned; a micrometre of a plank


@dataclass
class _Way:
    """Of one brick along one axis: where it turned last, and before that, and the farthest since."""

    noise: float  # [m]
    before: tuple[float, float]  # time [s] and place [m] of the last turn but one; at first, of rest
    turned: tuple[float, float] | None = None  # of the last turn
    farthest: tuple[float, float] = (0.0, 0.0)  # since
    forth: float = 0.0  # 1 or -1: which way it goes since then; 0 as long as it trembles

    def see(self, time: float, place: float) -> tuple[float, float]:
        """Amplitude [m] and period [s] of the swing that it is in, or has just ended; none of it at first."""
        if self.forth == 0.0:
            if abs(place - self.before[1]) <= self.noise:
                self.before = (time, self.before[1])
                return 0.0, 0.0
            self.forth, self.farthest = 1.0 if place > self.before[1] else -1.0, (time, place)
        if self.forth * (place - self.farthest[1]) >= 0.0:
            self.farthest = (time, place)
        elif abs(place - self.farthest[1]) > self.noise:
            self.before, self.turned = self.turned or self.before, self.farthest
            self.farthest, self.forth = (time, place), -self.forth
        if self.turned is None:
            return 0.0, 0.0
        out, back = abs(self.turned[1] - self.before[1]), abs(self.farthest[1] - self.turned[1])
        return 0.5 * min(out, back), self.farthest[0] - self.before[0]


@dataclass
class SwayMeter:
    """Looks for the largest swing, until something has left its place."""

    watch: BrickTracker
    sway: Sway | None = None
    _ways: dict[BodyId, tuple[_Way, _Way]] = field(default_factory=dict)
    _looked: float = 0.0  # when that was last done [s]

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if self.watch.first_to_leave() is not None:
            return
        for name, state in states.items():
            watched = self.watch.bricks[name]
            if watched.rest is None:  # nor will it ever be of what is thrown
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


# Where does what fell come down? The common centre of mass at the moment when what falls is fastest.
#
# A tower that tips strikes the ground with its top first and all along within moments, and slides and scatters after
# it. Its kinetic energy rises until the ground begins to take it. So the peak of the kinetic energy of all bricks that
# have left their places tells the moment of landing, without knowing which contact was the landing.


OVER = 0.01  # share of the largest kinetic energy; with less, what fell rocks and slides on, and brings nothing down
LANDED = 0.5  # share of the largest kinetic energy so far; below, the ground has taken the rest


@dataclass
class LandingWatch:
    """Looks for the peak while something falls."""

    watch: BrickTracker
    falling: bool = False  # whether the peak may be near
    _now: float = 0.0  # kinetic energy of what has left its place [J]
    _most: float = 0.0  # kinetic energy of what had left its place, at the peak so far [J]
    _time: float = 0.0  # of the peak [s]
    _at: dict[BodyId, Vec3] = field(default_factory=dict)  # where all that moved was then

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        bricks = self.watch.bricks
        energy = sum(kinetic_energy(bricks[name].placement.brick, states[name]) for name in self.watch.left(states))
        self._now = energy
        self.falling = energy > LANDED * self._most
        if energy > self._most:
            self._most, self._time = energy, time
            self._at = {name: state.pose.position_W for name, state in states.items()}

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """The landing of these bricks; one that stood still at that moment counts with the place where it stood."""
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


# How does what statics proves to fall begin to fall? Its bricks before, and when the first has turned by 5 deg.


BEGUN = radians(5.0)  # a turn that shows how something falls, before what it meets changes that
STUCK = 1e-2  # share of the largest speed: a point that moves less against what stands still is turned about


@dataclass
class OnsetWatch:
    """Follows the bricks that the last proof of a fall names."""

    motion: Motion | None = None
    onset: Onset | None = None
    _start: dict[BodyId, Pose] = field(default_factory=dict)
    _about: tuple[BodyId, ...] = ()

    @property
    def waiting(self) -> bool:
        """Whether something is about to fall, and has not turned far enough."""
        return self.onset is None and self.motion is not None

    def proven(
        self,
        verdict: Verdict,
        bricks: Mapping[BodyId, Placed],
        planes: Sequence[Plane],
        awake: Container[BodyId],
    ) -> None:
        """Something was set down, or taken out, and judged; `bricks` are all that are there, some of them `awake`."""
        if self.onset is not None or verdict.motion is self.motion:
            return
        if verdict.motion is None and any(name in awake for name in self._start):
            return  # what stands elsewhere holds up nothing of what has begun to fall
        self.motion = verdict.motion
        self._start = {}
        if self.motion is not None:
            self._start = {name: bricks[name].pose for name in self.motion.velocity}
            self._about = turned_about(self.motion, bricks, planes)

    def see(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if self.motion is None or self.onset is not None:
            return
        poses = {name: (pose, states[name].pose) for name, pose in self._start.items() if name in states}
        if max((turn_between(*pair) for pair in poses.values()), default=0.0) >= BEGUN:
            self.onset = Onset(self.motion, poses, self._about)


def turned_about(motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]) -> tuple[BodyId, ...]:
    """What stands still where something that moves touches it and does not slip, by name."""
    fastest = max((_speed(motion, bricks[name]) for name in motion.velocity), default=0.0)
    found = set()
    for mover, other, contact in _contacts(motion, bricks, planes):
        velocity, spin = motion.velocity[mover]
        centre = bricks[mover].pose.position_W
        slips = (norm(add(velocity, cross(spin, subtract(point, centre)))) for point in contact.points_W)
        if min(slips) <= STUCK * fastest:
            found.add(other)
    return tuple(sorted(found))


def _speed(motion: Motion, placed: Placed) -> float:
    """At most, of any point of a brick."""
    velocity, spin = motion.velocity[placed.brick.id]
    return norm(velocity) + norm(spin) * placed.brick.shape.bounding_radius


def _contacts(
    motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]
) -> Iterable[tuple[BodyId, BodyId, Contact]]:
    """Each contact of a brick that moves with a body that does not: the brick, the body, and where they touch."""
    from stability.contacts.bodies import solid  # noqa: PLC0415 -- where nothing is proven, nobody needs it
    from stability.contacts.detection import contact_between, contact_with_plane  # noqa: PLC0415 -- where nothing is proven, nobody needs it

    still = [solid(placed) for name, placed in bricks.items() if name not in motion.velocity]
    tolerances, any_friction = Tolerances(), 0.0
    for name in motion.velocity:
        mover = solid(bricks[name])
        touching = [(plane.id, contact_with_plane(mover, plane, tolerances)) for plane in planes]
        touching += [(other.id, contact_between(mover, other, any_friction, tolerances)) for other in still]
        yield from ((name, other, contact) for other, contact in touching if contact is not None)


# How deep are bodies in each other? By their shapes alone, whatever an engine takes for a contact.
#
# Exact for every shape; of where bricks are at one time. What is not looked at does not move.


@dataclass
class OverlapMeter:
    """Looks for the two bodies that are deepest in each other."""

    planes: Sequence[Plane]
    penetration: Penetration | None = None  # None before anything was placed
    _blocks: dict[BodyId, InPlace] = field(default_factory=dict)
    _near: Neighbours[BodyId] = field(default_factory=Neighbours)

    def see(self, time: float, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        self.put(bricks, poses)
        for name, pose in poses.items():
            self._compare(time, bricks[name], pose, poses)

    def put(self, bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose]) -> None:
        """Some are here by now. What moves beside them was seen before, so that nothing is compared yet."""
        for name, pose in poses.items():
            self.forget([name])
            block = self._blocks[name] = in_place(bricks[name].shape, pose)
            self._near.add(name, block.low_W, block.high_W)

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out."""
        for name in bricks:
            if self._blocks.pop(name, None) is not None:
                self._near.remove(name)

    def _compare(self, time: float, brick: Brick, pose: Pose, moving: Mapping[BodyId, Pose]) -> None:
        for plane in self.planes:
            self._found(time, brick.id, plane.id, -apart_from_plane(brick.shape, pose, plane).gap)
        for other in self._near.neighbours(brick.id, 0.0):
            if other not in moving or brick.id < other:  # each pair once
                self._found(time, brick.id, other, -bodies_apart(self._blocks[brick.id], self._blocks[other]).gap)

    def _found(self, time: float, brick: BodyId, other: BodyId, depth: float) -> None:
        if depth > (self.penetration.depth if self.penetration is not None else -1.0):
            self.penetration = Penetration(max(0.0, depth), brick, other, time)


# Which bricks still move? Those that got too far between two looks, within the last tenth of a second, to be at rest.
#
# The limits are those beyond which nothing is frozen (`RestLimits`): 5 mm/s and 0.1 rad/s for a KAPLA plank on earth,
# ten times the noise of a solver. They go with each brick's own size and with gravity (Froude): speeds with the root of
# size times gravity, times with that of size by gravity. So long, since what rocks stands still where it turns back.
# Between looks, since what a solver shakes within a step is fast and gets nowhere.


@dataclass
class MotionWatch:
    """When each brick was last seen to move."""

    gravity: float  # [m/s2]
    _seen: dict[BodyId, tuple[float, Pose]] = field(default_factory=dict)  # last [s]
    _limits: dict[BodyId, RestLimits] = field(default_factory=dict)
    _moved_at: dict[BodyId, float] = field(default_factory=dict)  # [s]

    def add(self, brick: Brick) -> None:
        """A brick has come."""
        size = relative_size(brick.shape)
        self._limits[brick.id] = RestLimits().scaled(size, sqrt(size * USUAL_GRAVITY / self.gravity))

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """Take in all that may move; returns what did."""
        moved = []
        for name, state in states.items():
            if name in self._seen and not self._limits[name].slow(_state_between(*self._seen[name], time, state.pose)):
                self._moved_at[name] = time
                moved.append(name)
            self._seen[name] = (time, state.pose)
        return moved

    def stopped(self, bricks: Iterable[BodyId]) -> None:
        """These are held fixed, or gone."""
        for name in bricks:
            self._moved_at.pop(name, None)
            self._seen.pop(name, None)

    def moving(self, now: float) -> tuple[BodyId, ...]:
        """Those that still move, in the order in which they came."""
        moved_at, limits = self._moved_at, self._limits
        return tuple(name for name in limits if name in moved_at and now - moved_at[name] < limits[name].hold_off)


def _state_between(before: float, then: Pose, now: float, here: Pose) -> BodyState:
    """As fast as it was on the way from one pose to the other, at these times [s]."""
    per_second = 1.0 / (now - before) if now > before else 0.0
    velocity_W = scale(per_second, subtract(here.position_W, then.position_W))
    return BodyState(here, velocity_W, (0.0, 0.0, per_second * turn_between(then, here)))


# Which contacts of what leans an engine gives a wrong normal while a timeline is played.


QUIET = 5e-3  # [m/s] normals of slower bricks hardly change: they are looked at less often
THOROUGH = 10  # at every such look all of them are


@dataclass
class NormalErrorMonitor:
    """Looks at contacts as often as the runner looks at bricks."""

    world: World
    gravity: float  # [m/s2]
    _looks: int = field(default=0, init=False)
    _seen: set[tuple[BodyId, BodyId]] = field(default_factory=set, init=False)
    _first: float | None = field(default=None, init=False)  # [s]
    _most: tuple[WrongNormal, float] | None = field(default=None, init=False)  # and when it was seen [s]

    def look(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in the contacts of all that moves."""
        thorough, self._looks = self._looks % THOROUGH == 0, self._looks + 1
        moving = {brick: state for brick, state in states.items() if thorough or hypot(*state.velocity_W) > QUIET}
        for wrong in wrong_normals(self.world, moving, self.gravity):
            self._seen.add((wrong.upper, wrong.lower))
            self._first = time if self._first is None else self._first
            if self._most is None or wrong.angle > self._most[0].angle:
                self._most = wrong, time

    def absorb(self, other: "NormalErrorMonitor") -> None:
        """Know what another one has seen."""
        self._seen |= other._seen
        first = [seen for seen in (self._first, other._first) if seen is not None]
        self._first = min(first, default=None)
        if other._most is not None and (self._most is None or other._most[0].angle > self._most[0].angle):
            self._most = other._most

    def wrong(self) -> WrongEdges | None:
        """All that was seen; None if nothing was."""
        if self._most is None or self._first is None:
            return None
        most, time = self._most
        return WrongEdges(len(self._seen), most.upper, most.lower, most.angle, time, self._first)


# Who carries a brick, as a bare engine's contact forces say: the measure of `rests_on` where no model answers it.


UPWARD = 0.5  # z of a contact normal towards the carried brick; steeper touches are at its side
LEAST_SHARE = 1e-3  # a support that takes less than this share is touched, not rested on


@dataclass
class ForceMeter:
    """Sums what each brick was pressed up with by each other body. Engines scatter load, so average over many steps."""

    upward: dict[BodyId, dict[BodyId, float]] = field(default_factory=lambda: defaultdict(lambda: defaultdict(float)))

    def add(self, brick: BodyId, contacts: Iterable[ContactPoint]) -> None:
        """Take in the contacts of a brick in one step: those that press it up."""
        for point in contacts:
            other, z = (point.b, point.normal_BA_W[2]) if point.a == brick else (point.a, -point.normal_BA_W[2])
            if z >= UPWARD:
                self.upward[brick][other] += point.normal_force * z

    def shares(self, bricks: Iterable[BodyId]) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """The supports of these bricks and their shares."""
        return {brick: self._shares(self.upward.get(brick, {})) for brick in bricks}

    def _shares(self, forces: Mapping[BodyId, float]) -> Mapping[BodyId, float]:
        total = sum(forces.values())
        return {on: force / total for on, force in forces.items() if force > LEAST_SHARE * total} if total > 0.0 else {}


# Tunnelling: does a thrown brick pass through another one, because its engine steps too coarsely for its speed?
#
# The centre of a rigid convex body can be in no other one. Between two looks that of a thrown brick is followed along a
# straight line, as seen from the other brick; that errs by much less than the half thickness that any true way keeps.


@dataclass
class PassingWatch:
    """Looks for the first thrown brick that passes through another."""

    watch: BrickTracker  # where all was when it was looked at last
    passed: Passed | None = None  # None while none has

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in what moves as it is now [s], before the watch does."""
        if self.passed is not None or not self.watch.dropped:
            return
        now = {name: state.pose for name, state in states.items()}
        self.passed = min(self._passed(time, now), default=(0.0, None), key=lambda each: each[0])[1]

    def _passed(self, time: float, now: Mapping[BodyId, Pose]) -> Iterator[tuple[float, Passed]]:
        """Each pair, with the share of the way after which the one enters the other."""
        for thrown in self.watch.dropped:
            name = thrown.placement.brick.id
            if not thrown.placement.hits or name not in now:
                continue
            before, after = thrown.last.position_W, now[name].position_W
            travel = dist(before, after)
            if travel <= 0.5 * thrown.placement.brick.shape.least_thickness:
                continue  # so slow that the engine sees the contact
            for other in self.watch.present:
                shape, was = self.watch.made_of[other].shape, self.watch.bricks[other].last
                pose = now.get(other, was)
                if other == name or dist(pose.position_W, after) > travel + shape.bounding_radius:
                    continue
                share = entry(shape, _seen_from(was, before), _seen_from(pose, after))
                if share is not None:
                    yield share, Passed(name, other, time, travel)


def entry(shape: ConvexShape, start: Vec3, end: Vec3) -> float | None:
    """The share of the straight way between two points, in body axes [m], after which it is inside a shape, if ever."""
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


# All that is measured of a run by looks at what moves: places, energy, how a fall begins and where it ends.


@dataclass
class RunMeasurements:
    """What is told of one run."""

    timeline: Timeline
    watch: BrickTracker = field(init=False)
    energy: EnergyMeter = field(init=False)
    onset: OnsetWatch = field(default_factory=OnsetWatch)
    motion: MotionWatch = field(init=False)
    passing: PassingWatch = field(init=False)
    _landing: LandingWatch = field(init=False)
    sway: SwayMeter | None = None  # None unless it is asked for
    overlap: OverlapMeter | None = None  # likewise
    recorder: "Recorder | None" = None  # likewise

    def __post_init__(self) -> None:
        gravity = self.timeline.world.gravity
        self.watch = BrickTracker(not_moving=NOT_MOVING.scaled(lengths=1.0, times=sqrt(USUAL_GRAVITY / gravity)))
        self.passing = PassingWatch(self.watch)
        self.energy = EnergyMeter(gravity, self.timeline.world.planes[0])
        self.motion = MotionWatch(gravity)
        self._landing = LandingWatch(self.watch)
        if "sway" in self.timeline.measures:
            self.sway = SwayMeter(self.watch)
        if "penetration" in self.timeline.measures:
            self.overlap = OverlapMeter(self.timeline.world.planes)

    @property
    def swayed(self) -> Sway | None:
        """The largest swing, if it was asked for."""
        return self.sway.sway if self.sway is not None else None

    @property
    def overlapped(self) -> Penetration | None:
        """The deepest overlap, if it was asked for."""
        return self.overlap.penetration if self.overlap is not None else None

    @property
    def close(self) -> bool:
        """Whether to look more often than usual."""
        return self.onset.waiting or self._landing.falling

    def add(self, placement: Placement) -> None:
        """A brick has come."""
        self.watch.add(placement)
        self.motion.add(placement.brick)
        state = BodyState(placement.came or placement.pose, placement.velocity_W)
        self._see(placement.time, {placement.brick.id: state})
        if self.recorder is not None:
            self.recorder.add(placement.time, placement.brick, state)
        if self.overlap is not None:
            self.overlap.see(placement.time, self.watch.made_of, {placement.brick.id: state.pose})

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        """These were pulled out at a time [s]."""
        bricks = tuple(bricks)
        self.watch.remove(bricks)
        self.motion.stopped(bricks)
        self.energy.forget(bricks)
        if self.overlap is not None:
            self.overlap.forget(bricks)
        if self.recorder is not None:
            self.recorder.remove(time, bricks)

    def shaken(self, motion: GroundMotion) -> None:
        """The ground begins to shake."""
        self.energy.outside.motion = motion

    def saw(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Some of what may move is as told at a time [s]."""
        self._see(time, states)
        self._record(time, states)

    def acted(self, states: Mapping[BodyId, BodyState], verdict: Verdict | None) -> None:
        """Something was done, and judged; all that may move was seen as told."""
        self.energy.start()
        if verdict is not None and self.timeline.closely:
            self.onset.proven(verdict, self.watch.where(), self.timeline.world.planes, states)

    def judged(self, time: float, states: Mapping[BodyId, BodyState], frozen: Iterable[BodyId]) -> None:
        """These bricks move from now on, or did until now; what was frozen is not looked at any more."""
        frozen = tuple(frozen)
        self.watch.see(time, states)
        self._see(time, states)
        self._record(time, states)
        if self.overlap is not None:
            self.overlap.put(self.watch.made_of, {name: state.pose for name, state in states.items()})
        self.watch.freeze(frozen)
        self.motion.stopped(frozen)

    def weigh(self, time: float, states: Mapping[BodyId, BodyState], in_hands: bool) -> None:
        """Take in the energy of what moves of one part; `in_hands` if hands may be at work on it."""
        self.saw(time, states)
        self.energy.look(self.motion.see(time, states))
        if in_hands:
            self.energy.start(by_hand=True)  # it is told from what an engine adds only once they have let go

    def look(self, time: float, states: Mapping[BodyId, BodyState], everything: Mapping[BodyId, BodyState]) -> None:
        """Take in where that is which moves of one part, and all that does."""
        self.passing.see(time, states)
        self.watch.see(time, states)
        if self.sway is not None:
            self.sway.see(time, states)
        if self.overlap is not None:
            self.overlap.see(time, self.watch.made_of, {name: state.pose for name, state in states.items()})
        self.look_closely(time, everything)

    def look_closely(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """The same between two looks. What has left its place is told by those alone, however closely one looks."""
        if self.timeline.closely:
            self.onset.see(states)
            self._landing.see(time, states)

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """Where these bricks came down."""
        return self._landing.landing(fallen)

    def _record(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        if self.recorder is not None:
            self.recorder.see(time, states)

    def _see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        self.energy.see(time, self.watch.made_of, states)
