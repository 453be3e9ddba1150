"""Timeline -> trace: steps the world, calls the stabilizer, and decides when the run ends."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, TypeAlias

from stability.engines.scene_scale import SAMPLING
from stability.geometry.vectors import add
from stability.model import GROUND, BodyId
from stability.process_settings import one_thread, rarely_collected
from stackdsl.simulation.after_collapse import after_collapse, last_arrival, time_of
from stackdsl.simulation.brick_tracks import EventLog, OnEvent, edges_of, require_clearance, tracks_of
from stackdsl.simulation.islands import Island, Islands, Pieces, names_of
from stackdsl.simulation.measurements import ForceMeter, RunMeasurements
from stackdsl.simulation.systems import System, as_played
from stackdsl.simulation.worlds import load
from stackdsl.timeline import (
    Action,
    Arrival,
    HoldAction,
    LetGo,
    Moment,
    MoveAction,
    Placement,
    PushAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import STAND, BrickState, Collapse, Cost, EarlyEnd, Event, EventKind, Trace
from stackdsl.wording import level_text, shaking_text

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder


# When does a run end? So long after what is done last, or after a collapse, or as soon as all that is asked is known.
#
# A collapse is what everybody asks about first, so a run that has none goes on to its end. One that has is followed for
# a while in any case: what fell is kept in golden files, and told. Beyond, it goes on for what is still asked alone.


KEPT = 1.0  # [s] after a collapse that are seen in any case: golden files keep what fell by then
BETWEEN_QUESTIONS = 0.1  # [s] between asking whether all is known, which takes as long as some looks do
Known: TypeAlias = Callable[[Trace], bool]  # whether nothing that may still happen changes what is asked of a run


def never_stop_early(_trace: Trace) -> bool:
    """Of a run of which nothing is asked, everything is worth seeing."""
    return False


@dataclass
class Ending:
    """Until when one run goes on."""

    timeline: Timeline
    is_known: Known
    last_action: float = 0.0  # [s]
    last_arrival: float = 0.0  # of what has to fly to the structure [s]
    early: EarlyEnd | None = None
    _asked: float = 0.0  # when it was last asked whether all is known [s]
    _planned: float = field(init=False)  # when it ends if nothing collapses [s]

    def __post_init__(self) -> None:
        self._planned = self.timeline.end  # which is asked for at every step

    def acted(self, moment: Moment) -> None:
        """Something was done."""
        self.last_action = time_of(moment)
        self.last_arrival = max(self.last_arrival, last_arrival(moment))

    def until(self, collapse: Collapse | None, hit: bool) -> float:
        """Until when there is something to see, as far as is known by now [s]; `hit`: something hit the structure."""
        if self.early is not None:
            return self.early.time
        if collapse is None:
            return self._planned
        aftermath = collapse.time + (self.timeline.followed if self.timeline.aftermath else 0.0)
        goes_on = hit or self.last_action > collapse.time
        return max(aftermath, self.last_arrival + self.timeline.hold) if goes_on else aftermath

    def may_be_early(self, now: float, collapse: Collapse | None) -> bool:
        """Whether it is worth asking if all is known."""
        if collapse is None or self.early is not None:
            return False
        return now >= max(collapse.time + KEPT, self._asked + BETWEEN_QUESTIONS)

    def ask(self, so_far: Trace, planned: float, to_come: Sequence[Moment]) -> None:
        """End now if all is known; `to_come` is what is still to be done, `planned` when it ends without that [s]."""
        early = self.if_it_ended(so_far, planned, to_come)
        self._asked = early.time
        if early.planned > early.time and self.is_known(replace(so_far, early_end=early)):
            self.early = early

    def if_it_ended(self, so_far: Trace, planned: float, to_come: Sequence[Moment]) -> EarlyEnd:
        """What an end now would leave out."""
        if to_come:
            planned = max(planned, max(map(last_arrival, to_come)) + self.timeline.hold)
        return EarlyEnd(so_far.cost.simulated_time, planned, tuple(_actions(to_come)))


def _actions(moments: Iterable[Moment]) -> Iterable[Action]:
    for moment in moments:
        yield from moment if isinstance(moment, tuple) else (moment,)


# Timeline -> trace: the one stage that steps a world.
#
# Time in which nothing can move is skipped: before the first brick, and whenever the extension has frozen all there
# are. A collapse ends the build, and is followed for a while to see what falls. Hits go on, and so does pulling bricks
# out, until all that is asked is known.


CLOSE_SAMPLING = 0.002  # [s] between looks while it is asked how something begins to fall, or where it lands
FORCE_WINDOW = 0.25  # [s] at the end over which a bare engine's contact forces are averaged


@one_thread()
@rarely_collected()
def play(
    timeline: Timeline,
    system: System,
    on_event: OnEvent = lambda event: None,
    is_known: Known = never_stop_early,
    recorder: "Recorder | None" = None,
) -> Trace:
    """Play a timeline on a system, in a world of its own; once it has collapsed, until all that is asked is known.

    A `recorder` is shown where all that moves is, whenever the run looks.
    """
    load(system)
    timeline = as_played(timeline, system.modification)
    started = perf_counter()
    log = EventLog(on_event)
    measures = RunMeasurements(timeline, recorder=recorder)
    parts = Islands(timeline, system, measures, log)
    try:
        run = _Run(timeline, parts, measures, log, Ending(timeline, is_known))
        run.play()
        return run.trace(perf_counter() - started)
    finally:
        parts.close()


@dataclass
class _Run:
    timeline: Timeline
    parts: Islands
    measures: RunMeasurements
    log: EventLog
    ending: Ending
    collapse: Collapse | None = None
    forces: ForceMeter = field(default_factory=ForceMeter)
    one_by_one: int = 0
    shift_before: float = 0.0  # largest of any brick when something was last done before a collapse [m]
    passed: int = 0  # moments
    before_fault: Trace | None = None  # the run so far when the engine had first added a notable share of energy

    def __post_init__(self) -> None:
        self.moments = tuple(self.timeline.moments())
        self.watch = self.measures.watch

    def play(self) -> None:
        for moment in self.moments:
            for _ in range(2):  # a collapse stops the first
                if self._takes_place(moment) is not None:
                    self._advance(time_of(moment))
            doing = None if self._all_is_known() else self._takes_place(moment)
            if doing is not None:
                self._act(doing)
            self.parts.done(self.passed)
            self.passed += 1
            if not self.timeline.watched and self.parts.undecided:
                return
        self._advance(self._end())
        if self.collapse:
            self._advance(self._end())
        for part in self.parts:
            self._look(part)
        self._close_placement()

    def _takes_place(self, moment: Moment) -> Moment | None:
        if self.ending.early is not None:
            return None
        return moment if self.collapse is None else after_collapse(moment, self.watch.present)

    def _act(self, moment: Moment) -> None:
        if self.collapse is None:
            self._close_placement()
            self.shift_before = self.watch.largest_shift
        pieces = self.parts.pieces(moment)
        for part, piece in pieces:
            part.prepare(piece, time_of(moment))
        match moment:
            case Removal():
                self._remove(moment, pieces)
            case PushAction():
                self._push(moment, pieces)
            case ShakeAction():
                self._shake(moment, pieces)
            case MoveAction() | HoldAction() | LetGo():
                self.parts.of(names_of(moment)[0]).hands.act(moment)
            case _:
                self._place(moment, pieces)
        pieces = self.parts.pieces(moment)  # some may have come near to others by that
        for part, _ in pieces:
            part.answers.let_go()
        self.ending.acted(moment)
        self._see_all(pieces)

    def _see_all(self, acted: Pieces) -> None:
        """Look at all that moves, once something was done."""
        seen = {part: part.moving() for part in self.parts}
        for part, states in seen.items():
            self.measures.saw(part.time, states)
        for part, _ in acted:
            if part.hit:
                part.set_max_speed(seen[part])  # until the next look
        for part, _ in acted:
            self.parts.look(part, seen[part])
        told = self.parts.extension
        everything = {name: state for states in seen.values() for name, state in states.items()}
        self.measures.acted(everything, told.verdict() if told is not None else None)

    def _end(self) -> float:
        """Until when there is something to see, as far as is known by now."""
        return self.ending.until(self.collapse, self.watch.hit)

    def _all_is_known(self) -> bool:
        """Whether nothing that may still happen changes what is asked."""
        if self.ending.may_be_early(self.parts.now, self.collapse):
            self.ending.ask(self._so_far(), self._end(), self._to_come())
        return self.ending.early is not None

    def _to_come(self) -> Sequence[Moment]:
        """What is still to be done."""
        to_come = (self._takes_place(moment) for moment in self.moments[self.passed :])
        return [moment for moment in to_come if moment is not None]

    def _place(self, group: Sequence[Placement], pieces: Pieces) -> None:
        of = {placement.brick.id: part for part, piece in pieces if isinstance(piece, tuple) for placement in piece}
        for placement in group:
            require_clearance(placement, self.watch)
            part = of[placement.brick.id]
            part.add(placement)
            self.measures.add(placement)
            if placement.arrival is Arrival.BY_HAND:
                part.hands.bring(placement.brick.id)
        placed = tuple(placement.brick.id for placement in group if placement.arrival is not Arrival.BY_HAND)
        if placed:
            self.log.tell(Event(group[0].time, EventKind.PLACED, placed))
        for part, _ in pieces:
            self.parts.look(part, {})
        for part, piece in self.parts.pieces(tuple(group)):
            if isinstance(piece, tuple):
                part.answers.set_down(placement.brick.id for placement in piece if placement.at_rest)

    def _remove(self, removal: Removal, pieces: Pieces) -> None:
        for brick in removal.bricks:
            self.parts.of(brick).world.remove_brick(brick)
        for part, _ in pieces:
            part.hands.gone(removal.bricks)
        self.measures.remove(removal.time, removal.bricks)
        self.forces = ForceMeter()  # what was measured before is of another structure
        self.log.tell(Event(removal.time, EventKind.REMOVED, removal.bricks))
        for part, piece in pieces:
            if isinstance(piece, Removal):
                part.answers.taken_out(piece.bricks)

    def _push(self, push: PushAction, pieces: Pieces) -> None:
        self.watch.struck()
        self.log.tell(Event(push.time, EventKind.PUSHED, (push.brick,)))
        for part, _ in pieces:
            if part.answers.struck(push.brick, push.impulse_W):
                centre_W = part.world.states([push.brick])[push.brick].pose.position_W
                part.world.push(push.brick, push.impulse_W, add(centre_W, push.offset_W))

    def _shake(self, shake: ShakeAction, pieces: Pieces) -> None:
        self.watch.struck()
        self.log.tell(Event(shake.time, EventKind.SHAKEN, (GROUND,), shaking_text(shake.motion)))
        self.measures.shaken(shake.motion)
        for part, _ in pieces:
            part.ground.motion = shake.motion
            part.answers.shaken(shake.motion)

    def _close_placement(self) -> None:
        if (told := self.parts.extension) is not None:
            self.log.close_placement(told, self.watch)

    def _advance(self, until: float) -> None:
        """Let time pass up to a time, or to the first collapse, or until all is known."""
        had_collapsed = self.collapse is not None
        while (part := self.parts.behind(until)) is not None:
            if self._go_on(part, self.parts.bound(part, until, self._end())) and (
                not had_collapsed or self._all_is_known()
            ):
                return
        self.parts.reached(until)

    def _go_on(self, part: Island, until: float) -> bool:
        """Let a part go on, to its next look at most; whether that has shown a collapse."""
        if part.resting:
            part.wait(until)
            if part.hands.busy:
                self._look(part)
            part.answers.judge()
            return False
        left, step = until - part.time, part.world.settings.time_step
        every, closely = (max(1, round(s / step)) for s in (SAMPLING, CLOSE_SAMPLING))
        look = closely if self.measures.close else every
        part.pass_on(min(look - part.ticks % look, max(1, round(left / step))))
        if part.ticks % every == 0:
            return self._look(part)
        if part.ticks % closely == 0 and self.measures.close:
            part.seen = part.moving()
            self.measures.look_closely(part.time, self.parts.seen(part))
        return False

    def _look(self, part: Island) -> bool:
        """See all of a part that moves; True if a collapse is known."""
        now = part.time
        part.hands.look()
        moving = part.answers.moving()
        states = part.world.states(list(dict.fromkeys([*moving, *part.hands.in_hand])))
        part.seen, part.one_by_one = states, len(moving) - part.answers.riding()
        self.one_by_one = max(self.one_by_one, sum(each.one_by_one for each in self.parts))
        self.measures.weigh(now, states, in_hands=part.hands.busy)
        self._notice_fault()
        self.measures.look(now, states, self.parts.seen(part))
        part.edges.look(now, states)
        part.look(states)
        self.parts.look(part, states)
        if part.extension is None and now >= self._end() - FORCE_WINDOW:
            for brick in moving:
                self.forces.add(brick, part.world.contacts(brick))
        if self.collapse is None and (first := self.watch.first_to_leave()) is not None:
            self._collapsed(now, first)
        return self.collapse is not None

    def _notice_fault(self) -> None:
        """Keep the run as it was before this look, if the engine is seen to have added energy by it."""
        if self.before_fault is None and self.measures.energy.notably_gained:
            so_far = self._so_far()
            self.before_fault = replace(so_far, early_end=self.ending.if_it_ended(so_far, self._end(), self._to_come()))

    def _collapsed(self, now: float, first: BodyId) -> None:
        youngest, gave_way = self.watch.youngest(), self.parts.of(first).answers.gave_way
        self.collapse = Collapse(now, youngest.level, first, gave_way, youngest.step, self._broke(gave_way))
        under = f"{level_text(youngest.level, youngest.step)} under construction"
        self.log.tell(Event(now, EventKind.COLLAPSED, (first,), under))

    def _broke(self, gave_way: BodyId | None) -> int | None:
        """The level at which it broke, if the last that was done set nothing down."""
        building = any(self.watch.bricks[brick].placement.builds for brick in self.log.last_placed())
        return None if gave_way is None or building else self.watch.bricks[gave_way].placement.level

    def trace(self, wall_time: float) -> Trace:
        """What happened, once it is over."""
        so_far = self._so_far()
        standing = [name for name, track in so_far.tracks.items() if track.state in STAND]
        told = self.parts.extension
        shares = told.shares() if told is not None else self.forces.shares(standing)
        edges = tuple(edge for name in standing for edge in edges_of(name, shares.get(name, {})))
        cost = replace(so_far.cost, wall_time=wall_time, updates=self.parts.updates())
        return replace(so_far, edges=edges, cost=cost)

    def _so_far(self) -> Trace:
        """What has happened, but for who carries whom."""
        told, now, fell = self.parts.extension, self.parts.now, self.collapse is not None
        unproven = not self.timeline.watched and self.parts.undecided
        tracks = tracks_of(self.timeline, self.watch, told, unproven, fell)
        return Trace(
            events=self.log.in_order() if self.parts.split else tuple(self.log.events),
            tracks=tracks,
            edges=(),
            collapse=self.collapse,
            cost=Cost(0.0, now, self.parts.steps, self.parts.judgements, self.log.proofs(), self.one_by_one),
            edges_when_placed=self.log.carried_at_first,
            world=self.timeline.world,
            last_arrival=self.ending.last_arrival,
            statics=told.verdict() if told is not None else None,
            energy=self.measures.energy.energy(),
            onset=self.measures.onset.onset,
            wrong_edges=self.parts.edges(),
            wrong_friction=self.parts.friction(),
            passed_through=self.measures.passing.passed,
            shift_before=self.shift_before,
            sway=self.measures.swayed,
            penetration=self.measures.overlapped,
            landing=self.measures.landing([n for n, track in tracks.items() if track.state is BrickState.FALLEN]),
            moving=self.measures.motion.moving(now),
            early_end=self.ending.early,
            before_fault=self.before_fault,
        )
