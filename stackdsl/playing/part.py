"""A part of a scene: bricks that are far from all others, with a world, an extension and a clock of their own.

What is done elsewhere, and what moves there, asks nothing of it: it is stepped, looked at and judged as if it were all
there is, so that not a digit of it depends on others. Most scenes are one part.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from stability.engines.lazy_world import RestingWorld
from stability.engines.protocol import World
from stability.model import BodyId, BodyState
from stability.motion.known_motion import FallingParts
from stability.watching.extension import Absorbs, Extension
from stackdsl.playing.concerned import concerned
from stackdsl.playing.edges import EdgeWatch
from stackdsl.playing.event_log import EventLog
from stackdsl.playing.extension_answers import Answers
from stackdsl.playing.ground import Ground
from stackdsl.playing.hands import Hands
from stackdsl.playing.measuring import Measures
from stackdsl.playing.space import Space
from stackdsl.playing.travel import limit_travel
from stackdsl.timeline import Moment, Move, Placement, Push, Shake
from stackdsl.timeline import World as Scene


@dataclass(eq=False)
class Part:
    """One part, and what is known of how it moves."""

    world: World
    extension: Extension | None
    scene: Scene
    measures: Measures
    log: EventLog
    ticks: int = 0  # time steps that passed while something could move
    steps: int = 0  # of them, those that an engine took
    known: int = 0  # and those of a motion that is known without one
    splits: int = 1  # into how many parts the coming steps are split for what is fast
    hit: bool = False  # whether something has hit it
    to_come: deque[tuple[int, float]] = field(default_factory=deque)  # what is done with it: which moment, and when [s]
    seen: Mapping[BodyId, BodyState] = field(default_factory=dict)  # what moved when that was looked at last
    resting: bool = True  # whether it was idle when that was asked last
    one_by_one: int = 0  # bricks that the engine moved one by one then
    space: Space = field(default_factory=Space)  # in which it has moved, and moves soon

    def __post_init__(self) -> None:
        scene = self.scene
        self.ground = Ground(self.world, scene.gravity)
        self.edges = EdgeWatch(self.world, scene.gravity)
        self.falling = FallingParts(self.world, scene.planes, scene.friction, scene.gravity)
        self.answers = Answers(self.extension, self.world, self.measures, self.log, self.falling)
        self.hands = Hands(self.world, self.measures.watch, self.answers, self.log, scene.planes)

    # --- its clock ----------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """What time it is here [s]; where nothing moves, the clock stands until something is done."""
        return self.world.time()

    @property
    def idle(self) -> bool:
        """Whether nothing here can move."""
        return self.answers.nothing_can_move() and not self.hands.steps

    def still_for(self, most: float) -> float:
        """For how much of a time nothing here needs to be looked at, as long as it is idle [s]."""
        return min(most, self.answers.still_for(), self.hands.still_for())

    def lags(self, until: float) -> bool:
        """Whether something happens here before a time [s]."""
        self.resting, left = self.idle, until - self.time
        if left <= 0.0:
            return False
        return self.still_for(left) < left if self.resting else left > 0.5 * self.world.settings.time_step

    def wait(self, until: float) -> None:
        """Let time pass in which nothing moves, up to a time [s] if it is idle until then."""
        left = until - self.time
        if left > 0.0 and self.idle:
            self.world.skip(self.still_for(left))

    def pass_on(self, most: int) -> None:
        """Let a time step pass, or up to so many while what moves needs no engine."""
        shaken = self.ground.shake()
        passed = self.falling.advance(most, driven=shaken or self.hands.busy)
        self.ticks += passed or 1
        self.known += passed
        if passed:
            self.answers.landed(self.falling.landed)
            return
        self.hands.guide()
        self.world.step()
        self.steps += 1
        self.answers.judge()

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves here, as it moves now, and step it as finely as that asks for until the next look."""
        self.answers.beginnings.look(states)
        self.limit_travel(states)

    def limit_travel(self, states: Mapping[BodyId, BodyState]) -> None:
        """Let it be stepped as finely as what moves asks for, until the next look."""
        self.splits = limit_travel(self.world, states, self.ground.pull)

    # --- what is done with it -----------------------------------------------------------------------------------------

    def prepare(self, moment: Moment, time: float) -> None:
        """Something is about to be done with it at a time [s]."""
        self.wait(time)
        if self.answers.nothing_can_move():
            self.answers.gave_way = None  # what failed before has come to rest again, and is not what fails now
        self.answers.beginnings.done()
        self.falling.disturbed(concerned(moment, self.measures.watch.bricks))
        self.hit = self.hit or _hits(moment)

    def add(self, placement: Placement) -> None:
        """A brick comes."""
        came = placement.came or placement.pose
        self.world.add_brick(placement.brick, came, placement.velocity_W)
        self.space.takes(placement.brick, BodyState(came, placement.velocity_W), self.scene.gravity)

    def moving(self) -> Mapping[BodyId, BodyState]:
        """All that may move, as it moves now."""
        return self.world.states(self.answers.moving())

    def absorb(self, other: "Part") -> None:
        """Take in another part that has come near."""
        self.falling.end()
        other.falling.end()
        if isinstance(self.world, RestingWorld) and isinstance(other.world, RestingWorld):
            self.world.engine.absorb(other.world.engine)
        if isinstance(self.extension, Absorbs) and other.extension is not None:
            self.extension.absorb(other.extension)
        self.answers.absorb(other.answers)
        self.steps += other.steps
        self.known += other.known
        self.falling.proven += other.falling.proven
        self.hands.looks += other.hands.looks
        self.hit = self.hit or other.hit
        self.to_come = deque(sorted([*self.to_come, *other.to_come]))
        self.space.joins(other.space)
        self.edges.absorb(other.edges)

    def rest(self) -> None:
        """Give its engine back if it is not needed any more."""
        if isinstance(self.world, RestingWorld) and self.resting and not self.to_come:
            self.world.engine.give_back()


def _hits(moment: Moment) -> bool:
    """Whether what is done strikes the structure."""
    match moment:
        case Push() | Shake():
            return True
        case Move():
            return not moment.lowers
        case tuple():
            return any(placement.hits for placement in moment)
        case _:
            return False


def names_of(moment: Moment) -> Sequence[BodyId]:
    """The bricks that something is done with; none where that is the ground."""
    match moment:
        case Push() | Move():
            return [moment.brick]
        case Shake():
            return []
        case tuple():
            return [placement.brick.id for placement in moment]
        case _:
            return moment.bricks
