"""The hands of one run: which bricks are in them, how these move, and what they move by that.

A hand has no body, and is as strong as it has to be: what is in it goes its way, whatever it meets, without turning,
and once it is there, nothing moves it. Where an engine steps, it is told before each step how fast that is. Where all
else is proven to stand, a brick that is lowered through free air needs no engine: it is put where it is by then.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from stability.engines.protocol import World
from stability.engines.scene_scale import SAMPLING
from stability.geometry.touching import reach_between
from stability.geometry.vectors import add, scale, subtract
from stability.model import BodyId, Plane, Pose, Vec3, convex
from stability.shapes.apart import apart, apart_from_plane
from stackdsl.playing.clearance import Blocked, BlockedPlacementError, keep_clear
from stackdsl.playing.event_log import EventLog
from stackdsl.playing.extension_answers import Answers
from stackdsl.playing.watch import Watch
from stackdsl.timeline import Handled, Hold, LetGo, Move
from stackdsl.trace import Event, EventKind
from stackdsl.wording import moving_text

AHEAD = 2.0 * SAMPLING  # [s] so long before it is reached, what is in the way is woken
# Share of its smallest side by which a brick that is pressed may be inside what does not give way. A plank that `stock`
# pushes is so by 3 %.
MOST_OVERLAP = 0.15


@dataclass(frozen=True, slots=True)
class _OnItsWay:
    """A brick that a hand moves."""

    move: Move
    start_W: Vec3  # where its centre was when the hand took it [m]

    def at(self, time: float) -> Vec3:
        """Where its centre is to be at a time [s]."""
        return add(self.start_W, self.move.course.at(time - self.move.time))


@dataclass
class Hands:
    """All hands of a run."""

    world: World
    watch: Watch
    answers: Answers
    log: EventLog
    planes: Sequence[Plane]
    in_hand: dict[BodyId, None] = field(default_factory=dict, init=False)
    _moving: dict[BodyId, _OnItsWay] = field(default_factory=dict, init=False)
    _brought: set[BodyId] = field(default_factory=set, init=False)  # those that are no part of the structure yet
    _reached: frozenset[BodyId] = field(default=frozenset(), init=False)  # what is woken for them

    @property
    def push(self) -> bool:
        """Whether any hand moves what is in its way."""
        return any(not one.move.lowers for one in self._moving.values())

    @property
    def steps(self) -> bool:
        """Whether a hand needs an engine: one that pushes does, and without an extension all do."""
        return self.push or (bool(self._moving) and self.answers.extension is None)

    def still_for(self) -> float:
        """How long no hand needs to be looked at, while nothing else moves [s]."""
        return SAMPLING if self._moving else inf

    # --- what they begin and end --------------------------------------------------------------------------------------

    def act(self, done: Handled) -> None:
        """Hands begin or end something."""
        match done:
            case Move():
                self._move(done)
            case Hold():
                self._hold(done)
            case LetGo():
                self._let_go(done)

    def bring(self, brick: BodyId) -> None:
        """A brick has come in a hand."""
        self._brought.add(brick)
        self._take(brick)

    def _move(self, move: Move) -> None:
        if not move.lowers:
            self.watch.struck()
            self.log.tell(Event(move.time, EventKind.TAKEN, (move.brick,), moving_text(move.course)))
        if move.brick not in self.in_hand:
            self._take(move.brick)
        start_W = self.world.states([move.brick])[move.brick].pose.position_W
        self._moving[move.brick] = _OnItsWay(move, start_W)
        if not move.lowers or self.answers.extension is None:
            self.world.wake(move.brick)

    def _hold(self, hold: Hold) -> None:
        bricks = hold.bricks
        new = tuple(brick for brick in bricks if brick not in self.in_hand)
        if new:
            self.log.tell(Event(hold.time, EventKind.TAKEN, new, "held"))
        for brick in bricks:
            if brick in new:
                self._keep(brick)
            else:
                self._stop(brick)
        self._reach()
        self.answers.held(bricks)

    def _let_go(self, let_go: LetGo) -> None:
        bricks = let_go.bricks
        brought = self._brought.issuperset(bricks)
        self.log.tell(Event(let_go.time, EventKind.PLACED if brought else EventKind.LET_GO, bricks))
        for brick in bricks:
            self._stop(brick)
            if brought:
                keep_clear(replace(self.watch.bricks[brick].placement, came=None), self.watch)
            self.world.wake(brick)
            del self.in_hand[brick]
        self._reach()
        self.watch.let_go(bricks, self.world.states(bricks))
        self.answers.let_go_by_hands(bricks, brought)
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
        self.world.prescribed.velocities_W.pop(brick, None)
        if one is None:
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
        velocities_W = self.world.prescribed.velocities_W
        for name in guided:
            way = subtract(self._moving[name].at(now + step), states[name].pose.position_W)
            velocities_W[name] = scale(1.0 / step, way)

    def look(self) -> None:
        """Put what is lowered where it is by now, and wake what others may reach soon."""
        now = self.world.time()
        for name, one in self._moving.items():
            if self.world.holds(name):
                self._put(name, one.at(now))
        self._reach()

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
            for other in self.world.near(
                brick, within + (reach_between(own.least_thickness) if own is not None else 0.0)
            )
            if other in self.watch.present
        ]
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
