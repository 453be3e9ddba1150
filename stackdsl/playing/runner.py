"""Timeline -> trace: the one stage that steps a world.

Time in which nothing can move is skipped: before the first brick, and whenever the extension has frozen all there are.
A collapse ends the build, and is followed for a while to see what falls. Hits go on, and so does pulling bricks out,
until all that is asked is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING

from stability.engines.friction_told import wrong_friction_of
from stability.engines.protocol import World
from stability.engines.scene_scale import SAMPLING
from stability.garbage import rarely_collected
from stability.geometry.vectors import add
from stability.model import GROUND, BodyId
from stability.motion.known_motion import FallingParts
from stability.watching.extension import Extension
from stackdsl.playing.after_collapse import after_collapse, time_of
from stackdsl.playing.carrying import ForceMeter
from stackdsl.playing.clearance import keep_clear
from stackdsl.playing.concerned import concerned
from stackdsl.playing.edges import EdgeWatch
from stackdsl.playing.ending import Ending, Known, nothing_is_known
from stackdsl.playing.event_log import EventLog, OnEvent, edges_of
from stackdsl.playing.extension_answers import Answers
from stackdsl.playing.ground import Ground
from stackdsl.playing.hands import Hands
from stackdsl.playing.measuring import Measures
from stackdsl.playing.tracks import tracks_of
from stackdsl.playing.travel import limit_travel
from stackdsl.systems.modification import as_played
from stackdsl.systems.systems import System
from stackdsl.systems.worlds import extension_for, load, opened_world
from stackdsl.timeline import Arrival, Hold, LetGo, Moment, Move, Placement, Push, Removal, Shake, Timeline
from stackdsl.trace import STAND, BrickState, Collapse, Cost, Event, EventKind, Trace
from stackdsl.wording import level_text, shaking_text

if TYPE_CHECKING:
    from stackdsl.recording.recorder import Recorder

CLOSE_SAMPLING = 0.002  # [s] between looks while it is asked how something begins to fall, or where it lands
FORCE_WINDOW = 0.25  # [s] at the end over which a bare engine's contact forces are averaged


@rarely_collected()
def play(
    timeline: Timeline,
    system: System,
    on_event: OnEvent = lambda event: None,
    is_known: Known = nothing_is_known,
    recorder: "Recorder | None" = None,
) -> Trace:
    """Play a timeline on a system, in a world of its own; once it has collapsed, until all that is asked is known.

    A `recorder` is shown where all that moves is, whenever the run looks.
    """
    load(system)
    timeline = as_played(timeline, system.modification)
    started = perf_counter()
    world = opened_world(timeline, system)
    try:
        extension = extension_for(timeline, system, world)
        run = _Run(timeline, world, extension, EventLog(on_event), Ending(timeline, is_known), recorder)
        run.play()
        return run.trace(perf_counter() - started)
    finally:
        world.close()


@dataclass
class _Run:
    timeline: Timeline
    world: World
    extension: Extension | None
    log: EventLog
    ending: Ending
    recorder: "Recorder | None" = None
    collapse: Collapse | None = None
    forces: ForceMeter = field(default_factory=ForceMeter)
    ticks: int = 0  # time steps that passed while something could move
    steps: int = 0  # of them, those that an engine took
    one_by_one: int = 0
    shift_before: float = 0.0  # largest of any brick when something was last done before a collapse [m]
    passed: int = 0  # moments

    def __post_init__(self) -> None:
        self.moments = tuple(self.timeline.moments())
        self.measures = Measures(self.timeline, recorder=self.recorder)
        self.watch = self.measures.watch
        scene = self.timeline.world
        self.ground = Ground(self.world, scene.gravity)
        self.edges = EdgeWatch(self.world, scene.gravity)
        self.falling = FallingParts(self.world, scene.planes, scene.friction, scene.gravity)
        self.answers = Answers(self.extension, self.world, self.measures, self.log, self.falling)
        self.hands = Hands(self.world, self.watch, self.answers, self.log, scene.planes)

    def play(self) -> None:
        for moment in self.moments:
            for _ in range(2):  # a collapse stops the first
                if self._takes_place(moment) is not None:
                    self._advance(time_of(moment))
            doing = None if self._all_is_known() else self._takes_place(moment)
            if doing is not None:
                self._act(doing)
            self.passed += 1
            if self.answers.only_an_engine_knows_more() and not self.timeline.watched:
                return
        self._advance(self._end())
        if self.collapse:
            self._advance(self._end())
        self._look()
        self._close_placement()

    def _takes_place(self, moment: Moment) -> Moment | None:
        if self.ending.early is not None:
            return None
        return moment if self.collapse is None else after_collapse(moment, self.watch.present)

    def _act(self, moment: Moment) -> None:
        if self.collapse is None:
            self._close_placement()
            self.shift_before = self.watch.largest_shift
        if self.answers.nothing_can_move():
            self.answers.gave_way = None  # what failed before has come to rest again, and is not what fails now
        self.falling.disturbed(concerned(moment, self.watch.bricks))
        match moment:
            case Removal():
                self._remove(moment)
            case Push():
                self._push(moment)
            case Shake():
                self._shake(moment)
            case Move() | Hold() | LetGo():
                self.hands.act(moment)
            case _:
                self._place(moment)
        self.answers.let_go()
        self.ending.acted(moment)
        states = self.world.states(self.answers.moving())
        self.measures.acted(self.world.time(), states, self.answers.verdict())
        if self.watch.hit:
            limit_travel(self.world, states, self.ground.pull)  # until the next look

    def _end(self) -> float:
        """Until when there is something to see, as far as is known by now."""
        return self.ending.until(self.collapse, self.watch.hit)

    def _all_is_known(self) -> bool:
        """Whether nothing that may still happen changes what is asked."""
        if self.ending.may_be_early(self.world.time(), self.collapse):
            to_come = (self._takes_place(moment) for moment in self.moments[self.passed :])
            self.ending.ask(self._so_far(), self._end(), [moment for moment in to_come if moment is not None])
        return self.ending.early is not None

    def _place(self, group: Sequence[Placement]) -> None:
        for placement in group:
            keep_clear(placement, self.watch)
            self.world.add_brick(placement.brick, placement.came or placement.pose, placement.velocity_W)
            self.measures.add(placement)
            if placement.arrival is Arrival.BY_HAND:
                self.hands.bring(placement.brick.id)
        placed = tuple(placement.brick.id for placement in group if placement.arrival is not Arrival.BY_HAND)
        if placed:
            self.log.tell(Event(group[0].time, EventKind.PLACED, placed))
        self.answers.set_down(placement.brick.id for placement in group if placement.at_rest)

    def _remove(self, removal: Removal) -> None:
        for brick in removal.bricks:
            self.world.remove_brick(brick)
        self.hands.gone(removal.bricks)
        self.measures.remove(removal.time, removal.bricks)
        self.forces = ForceMeter()  # what was measured before is of another structure
        self.log.tell(Event(removal.time, EventKind.REMOVED, removal.bricks))
        self.answers.taken_out(removal.bricks)

    def _push(self, push: Push) -> None:
        self.watch.struck()
        self.log.tell(Event(push.time, EventKind.PUSHED, (push.brick,)))
        if self.answers.struck(push.brick, push.impulse_W):
            centre_W = self.world.states([push.brick])[push.brick].pose.position_W
            self.world.push(push.brick, push.impulse_W, add(centre_W, push.offset_W))

    def _shake(self, shake: Shake) -> None:
        self.watch.struck()
        self.log.tell(Event(shake.time, EventKind.SHAKEN, (GROUND,), shaking_text(shake.motion)))
        self.ground.motion = shake.motion
        self.measures.shaken(shake.motion)
        self.answers.shaken(shake.motion)

    def _close_placement(self) -> None:
        if self.extension is not None:
            self.log.close_placement(self.extension, self.watch)

    def _advance(self, until: float) -> None:
        """Let time pass up to a time, or to the first collapse, or until all is known."""
        had_collapsed = self.collapse is not None
        while (left := until - self.world.time()) > 0.0:
            if self.answers.nothing_can_move() and not self.hands.steps:
                still = min(left, self.answers.still_for(), self.hands.still_for())
                self.world.skip(still)
                if still == left:
                    return
                if self.hands.busy:
                    self._look()
                self.answers.judge()
                continue
            if left <= 0.5 * (step := self.world.settings.time_step):
                return
            every, closely = (max(1, round(s / step)) for s in (SAMPLING, CLOSE_SAMPLING))
            look = closely if self.measures.close else every
            self._pass(min(look - self.ticks % look, round(left / step)))
            if self.ticks % every == 0:
                if self._look() and (not had_collapsed or self._all_is_known()):
                    return
            elif self.ticks % closely == 0 and self.measures.close:
                self.measures.look_closely(self.world.time(), self.world.states(self.answers.moving()))

    def _pass(self, most: int) -> None:
        """Let a time step pass, or up to so many while what moves needs no engine."""
        shaken = self.ground.shake()
        passed = self.falling.advance(most, driven=shaken or self.hands.busy)
        self.ticks += passed or 1
        if passed:
            self.answers.landed(self.falling.landed)
            return
        self.hands.guide()
        self.world.step()
        self.steps += 1
        self.answers.judge()

    def _look(self) -> bool:
        """See all that moves; True if a collapse is known."""
        now = self.world.time()
        self.hands.look()
        moving = self.answers.moving()
        states = self.world.states(list(dict.fromkeys([*moving, *self.hands.in_hand])))
        self.one_by_one = max(self.one_by_one, len(moving) - self.answers.riding())
        self.measures.look(now, states, in_hands=self.hands.busy)
        self.edges.look(now, states)
        limit_travel(self.world, states, self.ground.pull)
        if self.extension is None and now >= self._end() - FORCE_WINDOW:
            for brick in moving:
                self.forces.add(brick, self.world.contacts(brick))
        if self.collapse is None and (first := self.watch.first_to_leave()) is not None:
            youngest = self.watch.youngest()
            gave_way = self.answers.gave_way
            self.collapse = Collapse(now, youngest.level, first, gave_way, youngest.step, self._broke(gave_way))
            self.log.tell(
                Event(
                    now,
                    EventKind.COLLAPSED,
                    (first,),
                    f"{level_text(youngest.level, youngest.step)} under construction",
                )
            )
        return self.collapse is not None

    def _broke(self, gave_way: BodyId | None) -> int | None:
        """The level at which it broke, if the last that was done set nothing down."""
        building = any(self.watch.bricks[brick].placement.builds for brick in self.log.last_placed())
        return None if gave_way is None or building else self.watch.bricks[gave_way].placement.level

    def trace(self, wall_time: float) -> Trace:
        """What happened, once it is over."""
        so_far = self._so_far()
        standing = [name for name, track in so_far.tracks.items() if track.state in STAND]
        shares = self.extension.shares() if self.extension is not None else self.forces.shares(standing)
        edges = tuple(edge for name in standing for edge in edges_of(name, shares.get(name, {})))
        cost = replace(so_far.cost, wall_time=wall_time, updates=self.answers.clock.updates())
        return replace(so_far, edges=edges, cost=cost)

    def _so_far(self) -> Trace:
        """What has happened, but for who carries whom."""
        unproven = not self.timeline.watched and self.answers.only_an_engine_knows_more()
        tracks = tracks_of(self.timeline, self.watch, self.extension, unproven, self.collapse is not None)
        return Trace(
            events=tuple(self.log.events),
            tracks=tracks,
            edges=(),
            collapse=self.collapse,
            cost=Cost(0.0, self.world.time(), self.steps, self.answers.judgements, self.log.proofs(), self.one_by_one),
            edges_when_placed=self.log.carried_at_first,
            world=self.timeline.world,
            last_arrival=self.ending.last_arrival,
            statics=self.answers.verdict(),
            energy=self.measures.energy.energy(),
            onset=self.measures.onset.onset,
            wrong_edges=self.edges.wrong(),
            wrong_friction=wrong_friction_of(self.world),
            shift_before=self.shift_before,
            sway=self.measures.swayed,
            penetration=self.measures.overlapped,
            landing=self.measures.landing([n for n, track in tracks.items() if track.state is BrickState.FALLEN]),
            moving=self.measures.motion.moving(self.world.time()),
            early_end=self.ending.early,
        )
