"""Moves hands, the bricks in them, and the shaking ground during a run."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import Guided, World
from stability.engines.scene_scale import SAMPLING
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import apart, apart_from_plane
from stability.geometry.vectors import add, add_scaled, dot, norm, scale, subtract
from stability.model import AT_REST, BodyId, Plane, Pose, Vec3, convex
from stability.work_limit import PAIR, add_work
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError, BrickTracker, EventLog, require_clearance
from stackdsl.simulation.stabilizer_calls import StabilizerDriver
from stackdsl.timeline import HandAction, HoldAction, MoveAction, ReleaseAction
from stackdsl.trace import Event, EventKind
from stackdsl.wording import moving_text

# The hands of one run: the bricks in them, their prescribed motion, and the bricks that they push.
#
# A hand has no body and unlimited strength. A carried brick follows its course without turning, whatever it touches,
# and is fixed at the end. A slid brick keeps its weight and its load, and may tip over an edge; the hand only
# prescribes its speed along the course. The engine gets this speed before each step. Friction slows a slid brick, so
# the speed that it lost in the step before is added. If all other bricks are proven to stand, a brick lowered through
# free air needs no engine: it is put at its place on the course.


AHEAD = 2.0 * SAMPLING  # [s] before a hand reaches a brick, the brick is woken
# Share of the smallest side by which a pressed brick may overlap an obstacle. `stock` reaches 3 % with a pushed plank.
MOST_OVERLAP = 0.15
# Weight of a new measurement of the lost speed. With a weight of 1 a pile of five planks jerks, and those on top lag by
# 6 of 30 mm; with 0.1 none lags by more than 0.1 mm.
LEARNS = 0.1


@dataclass(frozen=True, slots=True)
class _GuidedBrick:
    """A brick that a hand moves."""

    move: MoveAction
    start_W: Vec3  # centre when the hand took it [m]

    def at(self, time: float) -> Vec3:
        """Return the prescribed centre at a time [s]."""
        return add(self.start_W, self.move.course.at(time - self.move.time))


@dataclass(frozen=True, slots=True)
class _Guidance:
    """The velocity that the engine was given for a slid brick before a step."""

    centre_W: Vec3  # before the step [m]
    velocity_W: Vec3  # [m/s]
    lost_W: Vec3  # expected loss of velocity [m/s]

    def lost(self, centre_W: Vec3, step: float) -> Vec3:
        """Return the new estimate of the loss of velocity [m/s], given the centre after the step [m]."""
        lost_W = subtract(self.velocity_W, scale(1.0 / step, subtract(centre_W, self.centre_W)))
        return add_scaled(self.lost_W, LEARNS, subtract(lost_W, self.lost_W))


@dataclass
class HandMover:
    """All hands of a run."""

    world: World
    watch: BrickTracker
    stabilizer: StabilizerDriver
    log: EventLog
    planes: Sequence[Plane]
    in_hand: dict[BodyId, None] = field(default_factory=dict, init=False)
    looks: int = field(default=0, init=False)  # number of looks at moved bricks
    _moving: dict[BodyId, _GuidedBrick] = field(default_factory=dict, init=False)
    _guidance: dict[BodyId, _Guidance] = field(default_factory=dict, init=False)  # of slid bricks
    _brought: set[BodyId] = field(default_factory=set, init=False)  # bricks that are not yet part of the structure
    _reached: frozenset[BodyId] = field(default=frozenset(), init=False)  # bricks that are woken for the hands

    @property
    def busy(self) -> bool:
        """Whether any brick is in a hand."""
        return bool(self.in_hand or self._moving)

    @property
    def push(self) -> bool:
        """Whether any hand pushes other bricks."""
        return any(not guided.move.lowers for guided in self._moving.values())

    @property
    def steps(self) -> bool:
        """Whether a hand needs an engine: a pushing hand does, and without an extension every hand does."""
        return self.push or (bool(self._moving) and self.stabilizer.extension is None)

    def busy_for(self) -> float:
        """Return for how long a brick still moves in a hand [s]."""
        ends = (guided.move.time + guided.move.course.duration for guided in self._moving.values())
        return max(0.0, max(ends, default=0.0) - self.world.time())

    def still_for(self) -> float:
        """Return how long no hand needs a look, while nothing else moves [s]."""
        return SAMPLING if self._moving else inf

    # --- actions ------------------------------------------------------------------------------------------------------

    def act(self, action: HandAction) -> None:
        """Begin or end an action of a hand."""
        match action:
            case MoveAction():
                self._move(action)
            case HoldAction():
                self._hold(action)
            case ReleaseAction():
                self._let_go(action)

    def bring(self, brick: BodyId) -> None:
        """Take a new brick that comes in a hand."""
        self._brought.add(brick)
        self._take(brick)

    def _move(self, move: MoveAction) -> None:
        if not move.lowers:
            self.watch.struck()
            self.log.add(Event(move.time, EventKind.TAKEN, (move.brick,), moving_text(move.course)))
        if move.free_W is None and move.brick not in self.in_hand:
            self._take(move.brick)
        start_W = self.world.states([move.brick])[move.brick].pose.position_W
        self._moving[move.brick] = _GuidedBrick(move, start_W)
        if move.free_W is None and (not move.lowers or self.stabilizer.extension is None):
            self.world.wake(move.brick)
        self._reach()

    def _hold(self, hold: HoldAction) -> None:
        bricks = hold.bricks
        new = tuple(brick for brick in bricks if brick not in self.in_hand and brick not in self._moving)
        if new:
            self.log.add(Event(hold.time, EventKind.TAKEN, new, "held"))
        for brick in bricks:
            self._stop(brick)
            if brick not in self.in_hand:
                self._keep(brick)
        self._reach()
        self.stabilizer.hold(bricks)

    def _let_go(self, let_go: ReleaseAction) -> None:
        bricks = let_go.bricks
        brought = self._brought.issuperset(bricks)
        self.log.add(Event(let_go.time, EventKind.PLACED if brought else EventKind.LET_GO, bricks))
        for brick in bricks:
            self._stop(brick)
            if brought:
                require_clearance(replace(self.watch.bricks[brick].placement, came=None), self.watch)
        self._reach()
        carried = [brick for brick in bricks if brick in self.in_hand]
        for brick in carried:
            self.world.wake(brick)
            del self.in_hand[brick]
        if carried:
            self.watch.let_go(carried, self.world.states(carried))
            self.stabilizer.let_go_by_hands(carried, brought)
        self._brought.difference_update(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Forget bricks that were removed."""
        for brick in bricks:
            self.in_hand.pop(brick, None)
            self._moving.pop(brick, None)

    def _take(self, brick: BodyId) -> None:
        """Take a brick that will be moved."""
        self.stabilizer.grasp(brick)
        self._keep(brick)

    def _keep(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.in_hand[brick] = None
        self.watch.take(brick)
        self.world.freeze(brick)

    def _stop(self, brick: BodyId) -> None:
        """End the motion of a brick, at the end of its course."""
        guided = self._moving.pop(brick, None)
        self._guidance.pop(brick, None)
        if guided is None or guided.move.free_W is not None:
            return
        self.world.freeze(brick)
        if guided.move.lowers and self.stabilizer.extension is not None:
            self._put(brick, guided.at(inf))

    # --- motion -------------------------------------------------------------------------------------------------------

    def guided(self) -> Mapping[BodyId, Guided]:
        """Return the prescribed motions of guided bricks in the next step."""
        now, step = self.world.time(), self.world.settings.time_step
        names = [name for name in self._moving if not self.world.holds(name)]
        states = self.world.states(names)
        motions = {}
        for name in names:
            guided, centre_W = self._moving[name], states[name].pose.position_W
            velocity_W = scale(1.0 / step, subtract(guided.at(now + step), centre_W))
            if guided.move.free_W is not None:
                lost_W = self._guidance[name].lost(centre_W, step) if name in self._guidance else AT_REST
                velocity_W = add(velocity_W, lost_W)
                self._guidance[name] = _Guidance(centre_W, velocity_W, lost_W)
            motions[name] = Guided(velocity_W, guided.move.free_W)
        return motions

    def look(self) -> None:
        """Put lowered bricks at their current place on the course, and wake bricks that others may reach soon."""
        now = self.world.time()
        self.looks += len(self._moving)
        for name, guided in self._moving.items():
            if self.world.holds(name):
                self._put(name, guided.at(now))
            elif guided.move.free_W is not None:
                self._follow(name, guided, guided.move.free_W)
        self._reach()

    def _follow(self, brick: BodyId, guided: _GuidedBrick, free_W: Vec3) -> None:
        """Raise BlockedPlacementError if a slid brick lags behind its course, as an obstacle does not give way."""
        behind_W = subtract(guided.at(self.world.time()), self.world.states([brick])[brick].pose.position_W)
        behind = norm(add_scaled(behind_W, -dot(free_W, behind_W), free_W))
        if behind > MOST_OVERLAP * self.watch.bodies[brick].shape.least_thickness:
            raise BlockedPlacementError(Blocked(brick, self.world.time(), brick, behind, pressed=brick))

    def _put(self, brick: BodyId, centre_W: Vec3) -> None:
        self.world.put_at(brick, Pose(centre_W, self.world.states([brick])[brick].pose.orientation))

    def _reach(self) -> None:
        """Wake all bricks that a hand may push now, directly or through others; they are not judged until they rest."""
        pushing = {name: guided for name, guided in self._moving.items() if not guided.move.lowers}
        if not pushing and not self._reached:
            return
        within = max((AHEAD * guided.move.course.speed for guided in pushing.values()), default=0.0)
        pushed = dict.fromkeys(pushing)
        front, by = list(pushing), next(iter(pushing), "")
        while front:
            beside = dict.fromkeys(other for brick in front for other in self._beside(brick, within, by))
            front = [brick for brick in beside if brick not in pushed]
            pushed |= dict.fromkeys(front)
        self._reached = frozenset(pushed.keys() - self.in_hand.keys())
        self.stabilizer.set_handled(self._reached, f"{', '.join(pushing)} moved by hand")

    def _beside(self, brick: BodyId, within: float, by: BodyId) -> Iterator[BodyId]:
        """Yield the bricks that touch a brick or are within a distance of it [m].

        Raises BlockedPlacementError if the hand with `by` has pressed the brick into another body.
        """
        own = convex(self.world.shape(brick))
        near = [
            other
            for other in self.world.neighbours(
                brick, within + (reach_between(own.least_thickness) if own is not None else 0.0)
            )
            if other in self.watch.present
        ]
        add_work(PAIR * len(near))
        states = self.world.states([brick, *near])
        if own is None:
            return
        for plane in self.planes:
            self._keep_apart(by, brick, plane.id, apart_from_plane(own, states[brick].pose, plane).gap)
        for other in near:
            shape = convex(self.world.shape(other))
            if shape is not None:
                reach = reach_between(own.least_thickness, shape.least_thickness)
                gap = apart(own, states[brick].pose, shape, states[other].pose).gap
                self._keep_apart(by, brick, other, gap)
                if gap <= within + reach:
                    yield other

    def _keep_apart(self, by: BodyId, brick: BodyId, other: BodyId, gap: float) -> None:
        if -gap > MOST_OVERLAP * self.watch.bodies[brick].shape.least_thickness:
            raise BlockedPlacementError(Blocked(by, self.world.time(), other, -gap, pressed=brick))


# The ground of one run, which may shake.


@dataclass
class ShakingGround:
    """The ground; at rest while `motion` is None."""

    world: World
    gravity: float  # [m/s2]
    motion: GroundMotion | None = None

    @property
    def pull(self) -> float:
        """Largest acceleration of a free body relative to the ground [m/s2]."""
        if self.motion is None:
            return self.gravity
        return self.motion.most_pull(self.gravity, self.world.time())

    def acceleration_W(self) -> Vec3 | None:
        """Return the mean acceleration of the ground in the next step [m/s2]; None while it does not shake."""
        now = self.world.time()
        if self.motion is not None and now >= self.motion.ends:
            self.motion = None
        return self.motion.mean_W(now, self.world.settings.time_step) if self.motion is not None else None
