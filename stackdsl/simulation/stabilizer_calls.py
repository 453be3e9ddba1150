"""Calls the stabilizer during a run: its updates, its answers, and the onset of motions."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from statistics import median
from time import perf_counter
from typing import Final, ParamSpec

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import World
from stability.geometry.vectors import dot
from stability.model import BodyId, BodyState, Vec3
from stability.problem import Stability, Verdict
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer, SupportsHands, SupportsLandings, SupportsShaking, Update
from stackdsl.simulation.brick_tracks import EventLog
from stackdsl.simulation.measurements import RunMeasurements
from stackdsl.trace import Updates

# Does it matter how what begins to move begins? Only then is it worth an engine's finest steps.
#
# Bricks that move collide among themselves without being eased in. What hits frozen bricks with a small share of the
# energy of all that moves adds no more than that to the error of those collisions, but all pay for its steps. When a
# crowd has come down, its last brick that still slides has most of the energy that is left, but next to none of what
# the crowd fell with: where the others lie, and so what is hit, is known no better than those collisions were.


LEAST_SHARE: Final = 0.02  # of the energy of motion; the foremost of a row of dominoes has more than that
# Bricks that move at once: of more, what they had at most counts as well. To ease one of so many in takes as long as
# they take for a third of a second, and where one of hundreds comes to lie is chance.
CROWD: Final = 200


@dataclass
class EaseInPolicy:
    """Looks at what moves in a world, and knows what a crowd has had."""

    world: World
    _most: float = field(default=0.0, init=False)  # of a crowd, since something was done with it; twice that [J]

    def done(self) -> None:
        """Something is done: how it goes on has nothing to do with what fell before."""
        self._most = 0.0

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if len(states) > CROWD:
            self._most = max(self._most, sum(self._energies(states).values()))

    def matters(self, update: Update, moving: Collection[BodyId]) -> bool:
        """Whether what hits or presses the woken bricks has a share of the energy of motion which counts."""
        moves = [brick for brick in moving if brick not in update.woken]
        if not update.by or not moves:
            return True
        energies = self._energies(self.world.states(moves))
        there_is = sum(energies.values())
        all_of_it = max(there_is, self._most) if len(moves) > CROWD else there_is
        return sum(energies.get(brick, 0.0) for brick in update.by) >= LEAST_SHARE * all_of_it

    def absorb(self, other: "EaseInPolicy") -> None:
        """Know what the bricks of another have had, which are of this world by now."""
        self._most += other._most

    def _energies(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, float]:
        """Twice the energy of each by its velocity [J]."""
        masses = self.world.masses()
        return {brick: masses[brick] * dot(state.velocity_W, state.velocity_W) for brick, state in states.items()}


# How long does one update of the extension take? Whoever plays with bricks while it watches them waits for each.


Asked = ParamSpec("Asked")


@dataclass
class UpdateClock:
    """Times every update of one run."""

    _took: list[float] = field(default_factory=list)  # [s]

    def timed(self, update: Callable[Asked, Update], *asked: Asked.args, **more: Asked.kwargs) -> Update:
        """Carry out an update."""
        began = perf_counter()
        done = update(*asked, **more)
        self._took.append(perf_counter() - began)
        return done

    def absorb(self, other: "UpdateClock") -> None:
        """Count those of another one as well."""
        self._took += other._took

    def updates(self) -> Updates | None:
        """What they took; None if there were none."""
        return Updates(median(self._took), max(self._took)) if self._took else None


# What the extension of a run is asked, and what follows from its answers; without one, all moves all the time.


@dataclass
class StabilizerDriver:
    """Passes on what the extension freezes and wakes: to the events, to what is measured, and to what falls."""

    extension: Stabilizer | None
    world: World
    measures: RunMeasurements
    log: EventLog
    falling: FallingParts
    gave_way: BodyId | None = None
    judgements: int = 0
    clock: UpdateClock = field(default_factory=UpdateClock)
    beginnings: EaseInPolicy = field(init=False)

    def __post_init__(self) -> None:
        self.beginnings = EaseInPolicy(self.world)

    def absorb(self, other: "StabilizerDriver") -> None:
        """Go on with the bricks of another one, which have come near."""
        self.gave_way = self.gave_way or other.gave_way
        self.judgements += other.judgements
        self.clock.absorb(other.clock)
        self.beginnings.absorb(other.beginnings)

    def moving(self) -> Sequence[BodyId]:
        """The bricks that may move."""
        return self.extension.awake() if self.extension is not None else list(self.measures.watch.present)

    def riding(self) -> int:
        """How many of them move as rigid bodies on others."""
        return len(self.extension.riding()) if self.extension is not None else 0

    def nothing_can_move(self) -> bool:
        """Whether all is frozen, or nothing there."""
        return not self.measures.watch.present or (self.extension is not None and not self.extension.awake())

    def verdict(self) -> Verdict | None:
        """What was proven of the structure when bricks were last set down or taken out; None where nothing proves."""
        return self.extension.verdict() if self.extension is not None else None

    def only_an_engine_knows_more(self) -> bool:
        """Whether what was set down is not proven to stand."""
        verdict = self.verdict()
        return verdict is not None and verdict.stability is not Stability.STABLE

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """The author sets bricks down at rest, so they are judged as they stand, level by level, before any step."""
        if self.extension is not None:
            self.extension.set_down(bricks)
            while self.judge():
                pass

    def shaken(self, motion: GroundMotion) -> None:
        """The ground begins to shake."""
        if isinstance(self.extension, SupportsShaking):
            self.extension.shaken(motion)
            self.judge()

    def taken(self, brick: BodyId) -> None:
        """A hand takes a brick."""
        if isinstance(self.extension, SupportsHands):
            self._tell(self.clock.timed(self.extension.taken, brick))

    def held(self, bricks: Collection[BodyId]) -> None:
        """Hands hold bricks at rest."""
        if isinstance(self.extension, SupportsHands):
            self._hear(self.clock.timed(self.extension.held, bricks))

    def handled(self, bricks: Collection[BodyId], reason: str) -> None:
        """Hands may move these bricks by now, and no others."""
        if isinstance(self.extension, SupportsHands):
            self._tell(self.clock.timed(self.extension.handled, bricks, reason))

    def let_go_by_hands(self, bricks: Collection[BodyId], set_down: bool) -> None:
        """Hands let bricks go; `set_down` if they brought them."""
        if isinstance(self.extension, SupportsHands):
            self._hear(self.clock.timed(self.extension.let_go, bricks, set_down))
            while self.judge():
                pass

    def still_for(self) -> float:
        """How long nothing can move, while nothing can [s]; inf if that is for good."""
        if not isinstance(self.extension, SupportsShaking):
            return inf
        return max(0.0, self.extension.holds_until() - self.world.time())

    def taken_out(self, bricks: Collection[BodyId]) -> None:
        """Bricks were pulled out."""
        if self.extension is not None:
            self._tell(self.clock.timed(self.extension.taken_out, bricks))

    def struck(self, brick: BodyId, impulse_W: Vec3) -> bool:
        """A brick is about to be pushed [N s]; whether it is free to move."""
        if self.extension is None:
            return True
        self._tell(self.clock.timed(self.extension.struck, brick, impulse_W))
        return not self.extension.is_frozen(brick)

    def landed(self, bricks: Collection[BodyId]) -> None:
        """Bricks whose motion was known without an engine have come to rest."""
        if bricks and isinstance(self.extension, SupportsLandings):
            update = self.clock.timed(self.extension.landed, bricks)
            self._hear(update)
            if len(update.frozen) < len(bricks):
                self.falling.end()

    def let_go(self) -> None:
        """Something was done, so that some may have been let go in the air."""
        if isinstance(self.extension, SupportsLandings):
            self.falling.let_go(self.moving())

    def judge(self) -> bool:
        """One pass of the extension; whether it froze anything."""
        if self.extension is None:
            return False
        update = self.clock.timed(self.extension.update)
        self._hear(update)
        return bool(update.frozen) and not update.woken

    def _hear(self, update: Update) -> None:
        """Take in what a pass of the extension changed."""
        self.judgements += 1
        if update != Update():
            # A frozen brick is not looked at any more, so this is the last chance to see where it stands. What else
            # moves is seen when all of it is looked at: what is frozen elsewhere changes nothing of that.
            changed = self.world.states([*update.frozen, *update.woken])
            self.measures.judged(self.world.time(), changed, update.frozen)
            self._tell(update)

    def _tell(self, update: Update) -> None:
        self.log.tell_update(self.world.time(), update)
        if update.failed:
            self._let_fall()
        elif update.woken and self.beginnings.matters(update, self.moving()):
            self.world.substep_next_contact()
        if update.failed and self.gave_way is None:
            self.gave_way = min(update.failed, key=list(self.measures.watch.bricks).index)

    def _let_fall(self) -> None:
        verdict = self.verdict()
        if verdict is not None:
            self.falling.woken(self.moving(), verdict.motion)
