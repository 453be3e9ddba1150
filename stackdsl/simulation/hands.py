"""Moves hands, the bricks in them, and the shaking ground during a run."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf

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
from stackdsl.timeline import Handled, HoldAction, LetGo, MoveAction
from stackdsl.trace import Event, EventKind
from stackdsl.wording import moving_text

# The hands of one run: which bricks are in them, how these move, and what they move by that.
#
# A hand has no body, and is as strong as it has to be. What it carries goes its way, whatever it meets, without
# turning, and once it is there, nothing moves it. What it slides keeps its weight and all that rests on it, and may tip
# over an edge: the hand only sees to it that it goes along. Where an engine steps, it is told before each step how fast
# that is; friction takes some of the speed of what is slid, so that it is given what it lost in the step before as
# well. Where all else is proven to stand, a brick that is lowered through free air needs no engine: it is put where it
# is by then.


AHEAD = 2.0 * SAMPLING  # [s] so long before it is reached, what is in the way is woken
# Share of its smallest side by which a brick that is pressed may be inside what does not give way. A plank that `stock`
# pushes is so by 3 %.
MOST_OVERLAP = 0.15
# Share of what is new about a loss of speed that is believed at once. Taken for certain it makes a pile of five planks
# jerk, and those on top lag by 6 of 30 mm; so none does by more than 0.1 mm.
LEARNS = 0.1


@dataclass(frozen=True, slots=True)
class _OnItsWay:
    """A brick that a hand moves."""

    move: MoveAction
    start_W: Vec3  # where its centre was when the hand took it [m]

    def at(self, time: float) -> Vec3:
        """Where its centre is to be at a time [s]."""
        return add(self.start_W, self.move.course.at(time - self.move.time))


@dataclass(frozen=True, slots=True)
class _Told:
    """What an engine was told of a brick before a step."""

    centre_W: Vec3  # where it was [m]
    velocity_W: Vec3  # [m/s]
    lost_W: Vec3  # that it was expected to lose [m/s]

    def lost(self, centre_W: Vec3, step: float) -> Vec3:
        """How much of its speed it loses in a step, as far as is known once it has got somewhere in one [s, m/s]."""
        lost_W = subtract(self.velocity_W, scale(1.0 / step, subtract(centre_W, self.centre_W)))
        return add_scaled(self.lost_W, LEARNS, subtract(lost_W, self.lost_W))


@dataclass
class HandMover:
    """All hands of a run."""

    world: World
    watch: BrickTracker
    answers: StabilizerDriver
    log: EventLog
    planes: Sequence[Plane]
    in_hand: dict[BodyId, None] = field(default_factory=dict, init=False)
    looks: int = field(default=0, init=False)  # at bricks on their way
    _moving: dict[BodyId, _OnItsWay] = field(default_factory=dict, init=False)
    _told: dict[BodyId, _Told] = field(default_factory=dict, init=False)  # of what is slid
    _brought: set[BodyId] = field(default_factory=set, init=False)  # those that are no part of the structure yet
    _reached: frozenset[BodyId] = field(default=frozenset(), init=False)  # what is woken for them

    @property
    def busy(self) -> bool:
        """Whether any brick is in a hand."""
        return bool(self.in_hand or self._moving)

    @property
    def push(self) -> bool:
        """Whether any hand moves what is in its way."""
        return any(not one.move.lowers for one in self._moving.values())

    @property
    def steps(self) -> bool:
        """Whether a hand needs an engine: one that pushes does, and without an extension all do."""
        return self.push or (bool(self._moving) and self.answers.extension is None)

    def busy_for(self) -> float:
        """For how long some brick is still on its way [s]."""
        ends = (one.move.time + one.move.course.duration for one in self._moving.values())
        return max(0.0, max(ends, default=0.0) - self.world.time())

    def still_for(self) -> float:
        """How long no hand needs to be looked at, while nothing else moves [s]."""
        return SAMPLING if self._moving else inf

    # --- what they begin and end --------------------------------------------------------------------------------------

    def act(self, done: Handled) -> None:
        """Hands begin or end something."""
        match done:
            case MoveAction():
                self._move(done)
            case HoldAction():
                self._hold(done)
            case LetGo():
                self._let_go(done)

    def bring(self, brick: BodyId) -> None:
        """A brick has come in a hand."""
        self._brought.add(brick)
        self._take(brick)

    def _move(self, move: MoveAction) -> None:
        if not move.lowers:
            self.watch.struck()
            self.log.tell(Event(move.time, EventKind.TAKEN, (move.brick,), moving_text(move.course)))
        if move.free_W is None and move.brick not in self.in_hand:
            self._take(move.brick)
        start_W = self.world.states([move.brick])[move.brick].pose.position_W
        self._moving[move.brick] = _OnItsWay(move, start_W)
        if move.free_W is None and (not move.lowers or self.answers.extension is None):
            self.world.wake(move.brick)
        self._reach()

    def _hold(self, hold: HoldAction) -> None:
        bricks = hold.bricks
        new = tuple(brick for brick in bricks if brick not in self.in_hand and brick not in self._moving)
        if new:
            self.log.tell(Event(hold.time, EventKind.TAKEN, new, "held"))
        for brick in bricks:
            self._stop(brick)
            if brick not in self.in_hand:
                self._keep(brick)
        self._reach()
        self.answers.held(bricks)

    def _let_go(self, let_go: LetGo) -> None:
        bricks = let_go.bricks
        brought = self._brought.issuperset(bricks)
        self.log.tell(Event(let_go.time, EventKind.PLACED if brought else EventKind.LET_GO, bricks))
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
            self.answers.let_go_by_hands(carried, brought)
        self._brought.difference_update(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """These were taken out."""
        for brick in bricks:
            self.in_hand.pop(brick, None)
            self._moving.pop(brick, None)

    def _take(self, brick: BodyId) -> None:
        """Take a brick that is to be moved."""
        self.answers.taken(brick)
        self._keep(brick)

    def _keep(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.in_hand[brick] = None
        self.watch.taken(brick)
        self.world.freeze(brick)

    def _stop(self, brick: BodyId) -> None:
        """End its way, where it ends."""
        one = self._moving.pop(brick, None)
        self._told.pop(brick, None)
        self.world.prescribed.guided.pop(brick, None)
        if one is None or one.move.free_W is not None:
            return
        self.world.freeze(brick)
        if one.move.lowers and self.answers.extension is not None:
            self._put(brick, one.at(inf))

    # --- while they move ----------------------------------------------------------------------------------------------

    def guide(self) -> None:
        """Say how fast bricks move in the coming step."""
        now, step = self.world.time(), self.world.settings.time_step
        guided = [name for name in self._moving if not self.world.holds(name)]
        states = self.world.states(guided)
        for name in guided:
            one, centre_W = self._moving[name], states[name].pose.position_W
            velocity_W = scale(1.0 / step, subtract(one.at(now + step), centre_W))
            if one.move.free_W is not None:
                lost_W = self._told[name].lost(centre_W, step) if name in self._told else AT_REST
                velocity_W = add(velocity_W, lost_W)
                self._told[name] = _Told(centre_W, velocity_W, lost_W)
            self.world.prescribed.guided[name] = Guided(velocity_W, one.move.free_W)

    def look(self) -> None:
        """Put what is lowered where it is by now, and wake what others may reach soon."""
        now = self.world.time()
        self.looks += len(self._moving)
        for name, one in self._moving.items():
            if self.world.holds(name):
                self._put(name, one.at(now))
            elif one.move.free_W is not None:
                self._follow(name, one, one.move.free_W)
        self._reach()

    def _follow(self, brick: BodyId, one: _OnItsWay, free_W: Vec3) -> None:
        """Raise the error if what is slid is left behind, so that the hand pushes against what does not give way."""
        behind_W = subtract(one.at(self.world.time()), self.world.states([brick])[brick].pose.position_W)
        behind = norm(add_scaled(behind_W, -dot(free_W, behind_W), free_W))
        if behind > MOST_OVERLAP * self.watch.made_of[brick].shape.least_thickness:
            raise BlockedPlacementError(Blocked(brick, self.world.time(), brick, behind, pressed=brick))

    def _put(self, brick: BodyId, centre_W: Vec3) -> None:
        self.world.put_at(brick, Pose(centre_W, self.world.states([brick])[brick].pose.orientation))

    def _reach(self) -> None:
        """Wake all that hands may move by now, directly or through others; nothing of it is judged until they rest."""
        pushing = {name: one for name, one in self._moving.items() if not one.move.lowers}
        if not pushing and not self._reached:
            return
        within = max((AHEAD * one.move.course.speed for one in pushing.values()), default=0.0)
        found = dict.fromkeys(pushing)
        front, by = list(pushing), next(iter(pushing), "")
        while front:
            beside = dict.fromkeys(other for brick in front for other in self._beside(brick, within, by))
            front = [brick for brick in beside if brick not in found]
            found |= dict.fromkeys(front)
        self._reached = frozenset(found.keys() - self.in_hand.keys())
        self.answers.handled(self._reached, f"{', '.join(pushing)} moved by hand")

    def _beside(self, brick: BodyId, within: float, by: BodyId) -> Iterator[BodyId]:
        """The bricks that are so near to one, or touch it. Raises the error if `by` has pressed it into something."""
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
        if -gap > MOST_OVERLAP * self.watch.made_of[brick].shape.least_thickness:
            raise BlockedPlacementError(Blocked(by, self.world.time(), other, -gap, pressed=brick))


# The ground of one run, which may shake: what the world is told of it before each step.


@dataclass
class ShakingGround:
    """At rest, until it begins to shake."""

    world: World
    gravity: float  # [m/s2]
    motion: GroundMotion | None = None  # None while it does not shake

    @property
    def pull(self) -> float:
        """How fast what is free gets faster at most, as seen from the ground [m/s2]."""
        if self.motion is None:
            return self.gravity
        return hypot(self.gravity, *self.motion.extremes(self.world.time()))

    def shake(self) -> bool:
        """Tell the world how the ground moves in its coming step; whether it does."""
        if self.motion is None:
            return False
        now = self.world.time()
        if now >= self.motion.ends:
            self.motion = None
            self.world.prescribed.acceleration_W = AT_REST
            return False
        self.world.prescribed.acceleration_W = self.motion.mean_W(now, self.world.settings.time_step)
        return True
