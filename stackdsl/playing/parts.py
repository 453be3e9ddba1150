"""All parts of a scene: whose turn it is, with which of them something is done, and who comes near to whom."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from stability.engines.friction_told import WrongFriction, wrong_friction_of
from stability.model import BodyId, BodyState
from stability.watching.extension import Extension
from stackdsl.playing.after_collapse import time_of
from stackdsl.playing.edges import EdgeWatch
from stackdsl.playing.effort import Effort
from stackdsl.playing.event_log import EventLog
from stackdsl.playing.far_apart import far_apart
from stackdsl.playing.measuring import Measures
from stackdsl.playing.part import Part, names_of
from stackdsl.playing.together import Together
from stackdsl.playing.update_clock import UpdateClock
from stackdsl.systems.systems import Method, System
from stackdsl.systems.worlds import extension_for, opened_world
from stackdsl.timeline import Moment, Placement, Removal, Timeline
from stackdsl.trace import Updates, WrongEdges

Pieces: TypeAlias = Sequence[tuple[Part, Moment]]  # what is done with each part


@dataclass
class Parts:
    """The parts of one run; close them after use."""

    timeline: Timeline
    system: System
    measures: Measures
    log: EventLog
    found: list[Part] = field(default_factory=list, init=False)  # those that are left, by their first bricks
    _coming: dict[tuple[float, BodyId], Part] = field(default_factory=dict, init=False)  # who comes where
    _of: dict[BodyId, Part] = field(default_factory=dict, init=False)  # where each is that has come
    _acted: list[Part] = field(default_factory=list, init=False)  # those with which something was done last
    _reached: float = field(default=0.0, init=False)  # up to when all has been idle [s]

    def __post_init__(self) -> None:
        # Only what a system proves is held, and known to go without an engine where it is.
        apart = self.system.method is Method.PROVEN and self.timeline.watched and self.system.modification.size == 1.0
        split = far_apart(self.timeline) if apart else [list(self.timeline.placements)]
        try:
            for placements in split:
                self._open(placements)
        except BaseException:
            self.close()
            raise
        self.effort = Effort(self.system)
        self.split = self.several
        if self.split:
            self._tell_when()

    def _open(self, placements: Sequence[Placement]) -> None:
        whole = len(placements) == len(self.timeline.placements)
        own = self.timeline if whole else replace(self.timeline, actions=tuple(placements))
        world = opened_world(own, self.system)
        part = Part(world, extension_for(own, self.system, world), own.world, self.measures, self.log)
        self.found.append(part)
        self._coming |= {(each.time, each.brick.id): part for each in placements}

    def _tell_when(self) -> None:
        """Tell each part when something is to be done with it."""
        of: dict[BodyId, Part] = {}
        for number, moment in enumerate(self.timeline.moments()):
            if isinstance(moment, tuple):
                of |= {each.brick.id: self._coming[each.time, each.brick.id] for each in moment}
            for part in {id(of[name]): of[name] for name in names_of(moment) if name in of}.values():
                part.to_come.append((number, time_of(moment)))

    def close(self) -> None:
        """End all of them."""
        for part in self.found:
            part.world.close()

    @property
    def several(self) -> bool:
        """Whether there is more than one."""
        return len(self.found) > 1

    @property
    def extension(self) -> "Extension | Together | None":
        """What is held, and why, of the whole scene."""
        if not self.several:
            return self.found[0].extension
        every, acted = (
            [part.extension for part in some if part.extension is not None] for some in (self.found, self._acted)
        )
        return Together(lambda name: self._of[name].extension, every, acted)

    def of(self, brick: BodyId) -> Part:
        """The part that has a brick."""
        return self._of[brick] if self.several else self.found[0]

    # --- time ---------------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """What time it is, in the part that has come farthest [s]."""
        return max(self._reached, *(part.time for part in self.found)) if self.several else self.found[0].time

    def behind(self, until: float) -> Part | None:
        """The part whose turn it is, of those in which something happens before a time [s]."""
        lagging = [part for part in self.found if part.lags(until)]
        if self.several:
            for part in self.found:
                part.rest()
        return min(lagging, key=lambda part: part.time, default=None)

    def bound(self, part: Part, until: float, end: float) -> float:
        """Up to when a part goes on by itself, whatever is done elsewhere at a time, before the run ends [s]."""
        if not self.several:
            return until
        return max(until, part.to_come[0][1] if part.to_come else end)

    def reached(self, until: float) -> None:
        """All has happened that happens before a time [s]."""
        if not self.several:
            self.found[0].wait(until)
        elif all(part.idle for part in self.found):
            self._reached = until

    # --- what is done -------------------------------------------------------------------------------------------------

    def pieces(self, moment: Moment) -> Pieces:
        """What is done with each part."""
        self._acted = []
        if not self.several:
            self._acted = self.found[:1]
            return [(self.found[0], moment)]
        if isinstance(moment, tuple):
            for each in moment:
                self._of[each.brick.id] = self._coming[each.time, each.brick.id]
        concerned = {id(self._of[name]): self._of[name] for name in names_of(moment)}
        self._acted = list(concerned.values())
        return [(part, self._piece(moment, part)) for part in self._acted]

    def _piece(self, moment: Moment, part: Part) -> Moment:
        match moment:
            case Removal():
                return replace(moment, bricks=tuple(name for name in moment.bricks if self._of[name] is part))
            case tuple():
                return tuple(each for each in moment if self._of[each.brick.id] is part)
            case _:
                return moment

    def done(self, number: int) -> None:
        """A moment of this number is over, whether it took place or not."""
        for part in self.found:
            while part.to_come and part.to_come[0][0] <= number:
                part.to_come.popleft()

    def __iter__(self) -> Iterator[Part]:
        """Those that are left when it is their turn."""
        return (part for part in tuple(self.found) if part in self.found)

    # --- who meets whom -----------------------------------------------------------------------------------------------

    def look(self, part: Part, states: Mapping[BodyId, BodyState]) -> None:
        """See where a part may be soon, and let it take in those that it may come near to.

        Raises BlockedPlacementError where what moves takes too much work.
        """
        self.effort.look(self.found, part, self.timeline.end)
        if not self.several or part not in self.found:
            return
        part.space.follows(self.measures.watch.made_of, states, self.timeline.world.gravity)
        while (other := self._met(part)) is not None:
            self._merge(part, other)

    def _met(self, part: Part) -> Part | None:
        return next((other for other in self.found if other is not part and other.space.meets(part.space)), None)

    def _merge(self, part: Part, other: Part) -> None:
        """Let a part take in another one; clocks agree to within half a step by then."""
        self._keep_step(part, other)
        self.found.remove(other)
        part.absorb(other)
        self._coming |= {key: part for key, at in self._coming.items() if at is other}
        self._of |= {name: part for name, at in self._of.items() if at is other}
        self._acted = list(dict.fromkeys(part if at is other else at for at in self._acted))

    @staticmethod
    def _keep_step(part: Part, other: Part) -> None:
        """Let the one that is behind catch up."""
        for behind, ahead in ((part, other), (other, part)):
            if not ahead.idle:
                while behind.lags(ahead.time) and not behind.idle:
                    behind.pass_on(1)
                behind.wait(ahead.time)

    # --- what is told of all ------------------------------------------------------------------------------------------

    def edges(self) -> WrongEdges | None:
        """What was seen of wrong normals in all of them."""
        seen = EdgeWatch(self.found[0].world, self.timeline.world.gravity)
        for part in self.found:
            seen.absorb(part.edges)
        return seen.wrong()

    def friction(self) -> WrongFriction | None:
        """The worst friction that any of them has had."""
        told = filter(None, (wrong_friction_of(part.world) for part in self.found))
        return max(told, key=lambda wrong: wrong.error, default=None)

    @property
    def undecided(self) -> bool:
        """Whether something that was set down is not proven to stand."""
        return any(part.answers.only_an_engine_knows_more() for part in self.found)

    def seen(self, part: Part) -> Mapping[BodyId, BodyState]:
        """All that moves, as it was seen last, once that of one part was."""
        if not self.several:
            return part.seen
        return {name: state for each in self.found if not each.resting for name, state in each.seen.items()}

    @property
    def steps(self) -> int:
        """How many time steps engines took."""
        return sum(part.steps for part in self.found)

    @property
    def judgements(self) -> int:
        """How often extensions were asked."""
        return sum(part.answers.judgements for part in self.found)

    def updates(self) -> Updates | None:
        """What the updates of all of them took."""
        clock = UpdateClock()
        for part in self.found:
            clock.absorb(part.answers.clock)
        return clock.updates()
