"""Timeline -> trace: steps the world, calls the stabilizer, and decides when the run ends."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, TypeAlias

from stability.engines.scene_scale import SAMPLING
from stability.geometry.vectors import add
from stability.model import GROUND, BodyId
from stability.problem import Stability
from stability.process_settings import one_thread, rarely_collected
from stackdsl.simulation.after_collapse import after_collapse, last_arrival, time_of
from stackdsl.simulation.brick_tracks import (
    Blocked,
    BlockedPlacementError,
    EventLog,
    OnEvent,
    edges_of,
    require_clearance,
    tracks_of,
)
from stackdsl.simulation.islands import Island, Islands, Pieces, names_of
from stackdsl.simulation.measurements import ForceMeter, RunMeasurements
from stackdsl.simulation.systems import AS_WRITTEN, Method, System, as_played
from stackdsl.simulation.worlds import load
from stackdsl.timeline import (
    Action,
    Arrival,
    HoldAction,
    JointsAction,
    LoadsAction,
    Moment,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import NO_PART, STAND, BrickState, Collapse, Cost, EarlyEnd, Event, EventKind, Trace
from stackdsl.wording import level_text, shaking_text

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder


# End of a run: some time after the last action or after a collapse, or as soon as every claim is decided.
#
# A run without a collapse goes on to its planned end. After a collapse a run goes on for at least `FOLLOWED` seconds,
# since golden files and reports contain the fall. Then it ends as soon as no later event can change a claim.


FOLLOWED = 1.0  # [s] after a collapse, in any case: golden files contain the bricks that fell by then
CHECK_INTERVAL = 0.1  # [s] between evaluations of the stop condition, each as slow as several looks
StopCondition: TypeAlias = Callable[[Trace], bool]  # whether no later event can change the result of a run


def never_stop_early(_trace: Trace) -> bool:
    """Stop condition that is never met: the run goes on to its planned end."""
    return False


@dataclass
class StopRule:
    """Determines when a run ends."""

    timeline: Timeline
    may_stop: StopCondition
    last_action: float = 0.0  # [s]
    last_arrival: float = 0.0  # of flying bricks at the structure [s]
    early: EarlyEnd | None = None
    _checked: float = 0.0  # when the stop condition was last evaluated [s]

    def acted(self, moment: Moment) -> None:
        """Note the time of an action and of its arrival at the structure."""
        self.last_action = time_of(moment)
        self.last_arrival = max(self.last_arrival, last_arrival(moment))

    def until(self, collapse: Collapse | None, hit: bool) -> float:
        """Return the planned end of the run [s]; `hit` is true once an impact has hit the structure."""
        if self.early is not None:
            return self.early.time
        if collapse is None:
            return self.timeline.end
        aftermath = collapse.time + (self.timeline.followed if self.timeline.aftermath else 0.0)
        goes_on = hit or self.last_action > collapse.time
        return max(aftermath, self.last_arrival + self.timeline.hold) if goes_on else aftermath

    def check_is_due(self, now: float, collapse: Collapse | None) -> bool:
        """Return whether to evaluate the stop condition now."""
        if collapse is None or self.early is not None:
            return False
        return now >= max(collapse.time + FOLLOWED, self._checked + CHECK_INTERVAL)

    def check(self, so_far: Trace, planned: float, remaining: Sequence[Moment]) -> None:
        """End the run now if its stop condition is met; `planned` is its end without the `remaining` moments [s]."""
        early = self.early_end(so_far, planned, remaining)
        self._checked = early.time
        if early.planned > early.time and self.may_stop(replace(so_far, early_end=early)):
            self.early = early

    def early_end(self, so_far: Trace, planned: float, remaining: Sequence[Moment]) -> EarlyEnd:
        """Return the description of an end now: the planned end, and the actions that would be left out."""
        if remaining:
            planned = max(planned, max(map(last_arrival, remaining)) + self.timeline.hold)
        return EarlyEnd(so_far.cost.simulated_time, planned, tuple(_actions(remaining)))


def _actions(moments: Iterable[Moment]) -> Iterable[Action]:
    for moment in moments:
        yield from moment if isinstance(moment, tuple) else (moment,)


# Timeline -> trace: the only stage that steps a world.
#
# Time in which nothing can move is skipped: before the first brick, and whenever the extension has frozen all bricks. A
# collapse ends the build, and the run follows the fall for a while. Impacts and removals still take place until every
# claim is decided.


CLOSE_SAMPLING = 0.002  # [s] between looks while an onset of a fall or a landing is measured
FORCE_WINDOW = 0.25  # [s] at the end of a run over which the contact forces of a bare engine are averaged


@one_thread()
@rarely_collected()
def play(
    timeline: Timeline,
    system: System,
    on_event: OnEvent = lambda event: None,
    may_stop: StopCondition = never_stop_early,
    recorder: "Recorder | None" = None,
) -> Trace:
    """Play a timeline on a system, in a new world; after a collapse, until `may_stop` is true for the trace so far.

    A `recorder` gets the states of all moving bricks at every look.
    """
    _require_played(timeline, system)
    load(system)
    timeline = as_played(timeline, system.modification)
    started = perf_counter()
    log = EventLog(on_event)
    measures = RunMeasurements(timeline, system.engine.most_gain, recorder=recorder)
    islands = Islands(timeline, system, measures, log)
    try:
        run = _Run(timeline, islands, measures, log, StopRule(timeline, may_stop))
        run.play()
        return run.trace(perf_counter() - started)
    finally:
        islands.close()


def _require_played(timeline: Timeline, system: System) -> None:
    """Raise BlockedPlacementError if the system does not play the joints, loads or strengths of a timeline."""
    plays = system.method is Method.PROVEN and system.engine.records_steps and system.modification == AS_WRITTEN
    what = "joints" if timeline.world.has_joints else "loads" if timeline.has_loads else ""
    what = what or ("strengths" if timeline.world.strengths else "ties" if timeline.world.ties else "")
    if what and not plays:
        first = timeline.placements[0]
        unplayed = f"the system '{system.name}' plays no {what}"
        raise BlockedPlacementError(Blocked(first.brick.id, first.time, first.brick.id, 0.0, unplayed=unplayed))


@dataclass
class _Run:
    timeline: Timeline
    islands: Islands
    measures: RunMeasurements
    log: EventLog
    ending: StopRule
    collapse: Collapse | None = None
    forces: ForceMeter = field(default_factory=ForceMeter)
    one_by_one: int = 0
    shift_before: float = 0.0  # largest shift of any brick at the last action before a collapse [m]
    passed: int = 0  # number of moments that are over
    built: bool = False  # whether the build was finished when it fell
    before_fault: Trace | None = None  # the trace until the engine first added a notable share of energy

    def __post_init__(self) -> None:
        self.moments = tuple(self.timeline.moments())
        self.watch = self.measures.watch

    def play(self) -> None:
        for moment in self.moments:
            for _ in range(2):  # a collapse ends the first call
                if self._takes_place(moment) is not None:
                    self._advance(time_of(moment))
            action = None if self._ended_early() else self._takes_place(moment)
            if action is not None:
                self._act(action)
            self.islands.done(self.passed)
            self.passed += 1
            if (self.islands.undecided and not self.timeline.watched) or self._crushed():
                return
            self._require_rest(moment)
        self._advance(self._end())
        if self.collapse:
            self._advance(self._end())
        for island in self.islands:
            self._look(island)
        self._close_placement()

    def _takes_place(self, moment: Moment) -> Moment | None:
        if self.ending.early is not None:
            return None
        return moment if self.collapse is None else after_collapse(moment, self.watch.present)

    def _act(self, moment: Moment) -> None:
        if self.collapse is None:
            self._close_placement()
            self.shift_before = self.watch.largest_shift
        pieces = self.islands.pieces(moment)
        for island, piece in pieces:
            island.prepare(piece, time_of(moment))
        match moment:
            case Removal():
                self._remove(moment, pieces)
            case JointsAction():
                self._rejoin(moment, pieces)
            case LoadsAction():
                self._load(moment)
            case PushAction():
                self._push(moment, pieces)
            case ShakeAction():
                self._shake(moment, pieces)
            case MoveAction() | HoldAction() | ReleaseAction():
                self.islands.of(names_of(moment)[0]).hands.act(moment)
            case _:
                self._place(moment, pieces)
        pieces = self.islands.pieces(moment)  # again, as islands may have merged meanwhile
        for island, _ in pieces:
            island.stabilizer.let_go()
        self.ending.acted(moment)
        self._look_at_all(pieces)

    def _look_at_all(self, acted: Pieces) -> None:
        """Look at all moving bricks after an action."""
        seen = {island: island.moving() for island in self.islands}
        for island, states in seen.items():
            self.measures.see(island.time, states)
        for island, _ in acted:
            if island.hit:
                island.set_max_speed(seen[island])  # until the next look
        for island, _ in acted:
            self.islands.look(island, seen[island])
        extension = self.islands.extension
        everything = {name: state for states in seen.values() for name, state in states.items()}
        self.measures.acted(everything, extension.verdict() if extension is not None else None)

    def _require_rest(self, moment: Moment) -> None:
        """Raise BlockedPlacementError if bricks have to be played that are tied or may crush."""
        ties, strengths = self.timeline.world.ties, self.timeline.world.strengths
        extension = self.islands.extension if (ties or strengths) and self.timeline.watched else None
        verdict = extension.verdict() if extension is not None else None
        if verdict is None or verdict.stability is Stability.STABLE:
            return
        first, now = self.timeline.placements[0].brick.id, time_of(moment)
        judged = f"is {verdict.stability.upper()} at {now:g} s: {verdict.reason}"
        if ties:
            limited = f"ties such as '{ties[0].name}' are judged at rest only, and not played"
            unplayed = f"the tied structure {judged}; {limited}"
        elif verdict.stability is Stability.UNDECIDED:
            unplayed = f"the structure {judged}; crushing is judged at rest only, and not played"
        else:
            return
        raise BlockedPlacementError(Blocked(first, now, first, 0.0, unplayed=unplayed))

    def _crushed(self) -> bool:
        """End the run if a brick crushes under the last change: the motion that follows is not modelled."""
        extension = self.islands.extension if self.timeline.world.strengths and self.collapse is None else None
        verdict = extension.verdict() if extension is not None else None
        if verdict is None or verdict.crushing is None:
            return False
        now, last, crushing = self.islands.now, self.watch.last_built(), verdict.crushing
        self.collapse = Collapse(now, last.level, crushing.brick, crushing.brick, last.step, crushing=crushing)
        self.log.add(Event(now, EventKind.CRUSHED, (crushing.brick,), crushing.need))
        return True

    def _end(self) -> float:
        """Return the planned end of the run [s]."""
        return self.ending.until(self.collapse, self.watch.hit)

    def _ended_early(self) -> bool:
        """Return whether the run ends now, as its stop condition is met."""
        if self.ending.check_is_due(self.islands.now, self.collapse):
            self.ending.check(self._so_far(), self._end(), self._remaining())
        return self.ending.early is not None

    def _remaining(self) -> Sequence[Moment]:
        """Return the moments that would still take place."""
        remaining = (self._takes_place(moment) for moment in self.moments[self.passed :])
        return [moment for moment in remaining if moment is not None]

    def _place(self, group: Sequence[Placement], pieces: Pieces) -> None:
        of = {placement.brick.id: island for island, piece in pieces if isinstance(piece, tuple) for placement in piece}
        for placement in group:
            require_clearance(placement, self.watch)
            island = of[placement.brick.id]
            island.add(placement)
            self.measures.add(placement)
            if placement.arrival is Arrival.BY_HAND:
                island.hands.bring(placement.brick.id)
        placed = tuple(placement.brick.id for placement in group if placement.arrival is not Arrival.BY_HAND)
        if placed:
            flying = tuple(placement.brick.id for placement in group if placement.hits)
            self.log.add(Event(group[0].time, EventKind.PLACED, placed, flying=flying))
        for island, _ in pieces:
            self.islands.look(island, {})
        for island, piece in self.islands.pieces(tuple(group)):
            if isinstance(piece, tuple):
                island.stabilizer.set_down(placement.brick.id for placement in piece if placement.at_rest)

    def _remove(self, removal: Removal, pieces: Pieces) -> None:
        for brick in removal.bricks:
            self.islands.of(brick).world.remove_brick(brick)
        for island, _ in pieces:
            island.hands.removed(removal.bricks)
            island.first_contacts.removed(removal.bricks)
        self.measures.remove(removal.time, removal.bricks)
        self.forces = ForceMeter()  # the forces so far belong to the structure before the removal
        self.log.add(Event(removal.time, EventKind.REMOVED, removal.bricks))
        for island, piece in pieces:
            if isinstance(piece, Removal):
                island.stabilizer.taken_out(piece.bricks)

    def _rejoin(self, change: JointsAction, pieces: Pieces) -> None:
        self.log.add(Event(change.time, EventKind(change.change.value), change.bricks))
        for island in self.islands:
            island.stabilizer.rejoined(change.joints)

    def _load(self, change: LoadsAction) -> None:
        if change.bricks:
            self.log.add(Event(change.time, EventKind.LOADED, change.bricks))
        for island in self.islands:
            island.stabilizer.loaded(change.course)

    def _push(self, push: PushAction, pieces: Pieces) -> None:
        self.watch.struck()
        self.log.add(Event(push.time, EventKind.PUSHED, (push.brick,)))
        for island, _ in pieces:
            if island.stabilizer.struck(push.brick, push.impulse_W, push.offset_W):
                centre_W = island.world.states([push.brick])[push.brick].pose.position_W
                island.world.push(push.brick, push.impulse_W, add(centre_W, push.offset_W))

    def _shake(self, shake: ShakeAction, pieces: Pieces) -> None:
        self.watch.struck()
        self.log.add(Event(shake.time, EventKind.SHAKEN, (GROUND,), shaking_text(shake.motion)))
        self.measures.shaken(shake.motion)
        for island, _ in pieces:
            island.ground.motion = shake.motion
            island.stabilizer.shaken(shake.motion)

    def _close_placement(self) -> None:
        if (extension := self.islands.extension) is not None:
            self.log.close_placement(extension, self.watch)

    def _advance(self, until: float) -> None:
        """Let time pass up to a time [s], to the first collapse, or to an early end."""
        had_collapsed = self.collapse is not None
        while (island := self.islands.behind(until)) is not None:
            if self._advance_island(island, self.islands.bound(island, until, self._end())) and (
                not had_collapsed or self._ended_early()
            ):
                return
        self.islands.reached(until)

    def _advance_island(self, island: Island, until: float) -> bool:
        """Advance an island, at most to its next look; return whether the structure has collapsed."""
        if island.resting:
            island.wait(until)
            if island.hands.busy:
                self._look(island)
            island.stabilizer.judge()
            return False
        left, step = until - island.time, island.world.settings.time_step
        every, closely = (max(1, round(s / step)) for s in (SAMPLING, CLOSE_SAMPLING))
        look = closely if self.measures.close else every
        island.pass_on(min(look - island.ticks % look, max(1, round(left / step))))
        if island.ticks % every == 0:
            return self._look(island)
        if island.ticks % closely == 0 and self.measures.close:
            island.seen = island.moving()
            self.measures.look_closely(island.time, self.islands.seen(island))
        return False

    def _look(self, island: Island) -> bool:
        """Look at all moving bricks of an island; return whether the structure has collapsed."""
        now = island.time
        island.hands.look()
        moving = island.stabilizer.moving()
        states = island.world.states(list(dict.fromkeys([*moving, *island.hands.in_hand])))
        island.seen, island.one_by_one = states, len(moving) - island.stabilizer.riding()
        self.one_by_one = max(self.one_by_one, sum(each.one_by_one for each in self.islands))
        driven = island.hands.busy or island.stabilizer.moves_under_loads()
        self.measures.weigh(now, states, driven=driven)
        self._notice_fault()
        self.measures.look(now, states, self.islands.seen(island))
        island.edges.look(now, states)
        island.look(states)
        self.islands.look(island, states)
        if island.extension is None and now >= self._end() - FORCE_WINDOW:
            for brick in moving:
                self.forces.add(brick, island.world.contacts(brick))
        if self.collapse is None and (first := self.watch.first_to_leave()) is not None:
            self._collapsed(now, first)
        return self.collapse is not None

    def _notice_fault(self) -> None:
        """Keep the trace so far when this look first shows that the engine has added energy."""
        if self.before_fault is None and self.measures.energy.notably_gained:
            so_far = self._so_far()
            self.before_fault = replace(so_far, early_end=self.ending.early_end(so_far, self._end(), self._remaining()))

    def _collapsed(self, now: float, first: BodyId) -> None:
        last, gave_way = self.watch.last_built(), self.islands.of(first).stabilizer.gave_way
        by = self.watch.bricks[first].left_by
        self.collapse = Collapse(now, last.level, first, gave_way, last.step, self._broke(gave_way), by)
        self.built = self._is_built()
        level = "" if self.built else f"; {level_text(last.level, last.step)} under construction"
        self.log.add(Event(now, EventKind.COLLAPSED, (first,), f"{first} has {by}{level}"))

    def _broke(self, gave_way: BodyId | None) -> int | None:
        """Return the level that gave way, unless the last action was part of the build."""
        return None if gave_way is None or self._building() else self.watch.bricks[gave_way].placement.level

    def _building(self) -> bool:
        """Return whether the last action was part of the build."""
        placed = self.log.last_placed()
        return bool(placed) and all(self.watch.bricks[brick].placement.builds for brick in placed)

    def _is_built(self) -> bool:
        """Return whether the build is finished and was followed by another action."""
        builds = any(isinstance(m, tuple) and any(each.builds for each in m) for m in self.moments[self.passed :])
        return not builds and not self._building()

    def trace(self, wall_time: float) -> Trace:
        """Return the trace of the finished run."""
        so_far = self._so_far()
        standing = [name for name, track in so_far.tracks.items() if track.state in STAND]
        extension = self.islands.extension
        shares = extension.shares() if extension is not None else self.forces.shares(standing)
        edges = tuple(edge for name in standing for edge in edges_of(name, shares.get(name, {})))
        unknown = frozenset(standing) - self.forces.loaded if extension is None else frozenset()
        cost = replace(so_far.cost, wall_time=wall_time, updates=self.islands.updates())
        return replace(so_far, edges=edges, unknown_loads=unknown, cost=cost, assembly=self.islands.assembly())

    def _so_far(self) -> Trace:
        """Return the trace up to now, without support edges."""
        extension, now, collapsed = self.islands.extension, self.islands.now, self.collapse is not None
        unplayed = None if self.timeline.watched or not self.islands.undecided else BrickState.UNWATCHED
        crushed = self.collapse is not None and self.collapse.crushing is not None
        tracks = tracks_of(self.timeline, self.watch, extension, unplayed, collapsed and not crushed)
        collapse = self.collapse
        if collapse is not None and self.built:
            parts = {name: track.state for name, track in tracks.items() if track.state not in NO_PART}
            fallen = tuple(name for name, state in parts.items() if state is BrickState.FALLEN)
            collapse = replace(collapse, fallen=fallen, bricks=len(parts))
        moving, loose = self.measures.motion.moving(now), (BrickState.FALLEN, BrickState.THROWN)
        in_place = self.measures.motion.in_place(now)
        return Trace(
            events=self.log.in_order() if self.islands.split else tuple(self.log.events),
            tracks=tracks,
            edges=(),
            collapse=collapse,
            cost=Cost(0.0, now, self.islands.steps, self.islands.judgements, self.log.proofs(), self.one_by_one),
            edges_when_placed=self.log.edges_when_placed,
            world=self.timeline.final_world,
            last_arrival=self.ending.last_arrival,
            statics=extension.verdict() if extension is not None else None,
            energy=self.measures.energy.energy(),
            onset=self.measures.onset.onset,
            wrong_edges=self.islands.edges(),
            wrong_friction=self.islands.friction(),
            passed_through=self.measures.passing.passed,
            shift_before=self.shift_before,
            sway=self.measures.swayed,
            penetration=self.measures.overlapped,
            landing=self.measures.landing([n for n, track in tracks.items() if track.state is BrickState.FALLEN]),
            moving=moving,
            rocking=tuple(name for name in moving if name in in_place and tracks[name].state in loose),
            early_end=self.ending.early,
            before_fault=self.before_fault,
        )
