"""Calls the stabilizer during a run, logs its updates, and starts motions."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from statistics import median
from time import perf_counter
from typing import Final, ParamSpec

from stability.dynamics.ground_motion import GroundMotion
from stability.engines.protocol import World
from stability.geometry.vectors import dot
from stability.joints import Joints
from stability.loads import LoadCourse
from stability.model import BodyId, BodyState, Vec3
from stability.problem import Stability, Verdict
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer, Update
from stackdsl.simulation.brick_tracks import EventLog
from stackdsl.simulation.measurements import RunMeasurements
from stackdsl.trace import Updates

# Decides whether the onset of a motion needs sub-steps.
#
# Collisions between moving bricks get no sub-steps. If the brick that hits frozen bricks has only a small share of the
# energy of all moving bricks, sub-steps would hardly reduce the error of those collisions, but every moving brick would
# pay for them. After a crowd of bricks has fallen, the last one that slides has most of the remaining energy, but
# almost none of the energy of the fall. The positions of the others have the error of their collisions anyway.


LEAST_SHARE: Final = 0.02  # of the kinetic energy; the foremost of a row of dominoes has more
# Number of moving bricks above which their largest kinetic energy so far counts. The sub-steps of one contact then take
# as long as a third of a second of the motion, and where one of hundreds of bricks comes to rest is chance.
CROWD: Final = 200


@dataclass
class EaseInPolicy:
    """Compares the energy of bricks that hit frozen ones with that of all moving bricks."""

    world: World
    _most: float = field(default=0.0, init=False)  # twice the largest energy of a crowd since the last action [J]

    def reset(self) -> None:
        """Forget the energy of earlier falls before a new action."""
        self._most = 0.0

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks."""
        if len(states) > CROWD:
            self._most = max(self._most, sum(self._energies(states).values()))

    def matters(self, update: Update, moving: Collection[BodyId]) -> bool:
        """Return whether the bricks that hit or press the woken ones have a notable share of the kinetic energy."""
        moves = [brick for brick in moving if brick not in update.woken]
        if not update.by or not moves:
            return True
        energies = self._energies(self.world.states(moves))
        total = sum(energies.values())
        reference = max(total, self._most) if len(moves) > CROWD else total
        return sum(energies.get(brick, 0.0) for brick in update.by) >= LEAST_SHARE * reference

    def absorb(self, other: "EaseInPolicy") -> None:
        """Add the largest energy of another island, whose bricks are now in this world."""
        self._most += other._most

    def _energies(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, float]:
        """Return twice the translational energy of each brick [J]."""
        masses = self.world.masses()
        return {brick: masses[brick] * dot(state.velocity_W, state.velocity_W) for brick, state in states.items()}


# Wall time of single updates of the extension. In an interactive program the user waits for each of them.


Params = ParamSpec("Params")


@dataclass
class UpdateClock:
    """Times every update of one run."""

    _took: list[float] = field(default_factory=list)  # [s]

    def timed(self, update: Callable[Params, Update], *args: Params.args, **kwargs: Params.kwargs) -> Update:
        """Carry out an update and store its wall time."""
        began = perf_counter()
        result = update(*args, **kwargs)
        self._took.append(perf_counter() - began)
        return result

    def absorb(self, other: "UpdateClock") -> None:
        """Add the times of another clock."""
        self._took += other._took

    def updates(self) -> Updates | None:
        """Return the median and worst time; None if there was no update."""
        return Updates(median(self._took), max(self._took)) if self._took else None


# Calls of the extension of a run, and the effects of its updates. Without an extension, every brick moves at all times.


@dataclass
class StabilizerDriver:
    """Calls the extension, and passes its updates on to the event log, the measurements and the falling parts."""

    extension: Stabilizer | None
    world: World
    measures: RunMeasurements
    log: EventLog
    falling: FallingParts
    gave_way: BodyId | None = None
    judgements: int = 0
    clock: UpdateClock = field(default_factory=UpdateClock)
    ease_in: EaseInPolicy = field(init=False)

    def __post_init__(self) -> None:
        self.ease_in = EaseInPolicy(self.world)

    def absorb(self, other: "StabilizerDriver") -> None:
        """Take over the bricks of another island."""
        self.gave_way = self.gave_way or other.gave_way
        self.judgements += other.judgements
        self.clock.absorb(other.clock)
        self.ease_in.absorb(other.ease_in)

    def moving(self) -> Sequence[BodyId]:
        """Return the bricks that may move."""
        return self.extension.awake() if self.extension is not None else list(self.measures.watch.present)

    def riding(self) -> int:
        """Return how many bricks move as rigid bodies on others."""
        return len(self.extension.riding()) if self.extension is not None else 0

    def nothing_can_move(self) -> bool:
        """Return whether every brick is frozen, or there is none."""
        return not self.measures.watch.present or (self.extension is not None and not self.extension.awake())

    def verdict(self) -> Verdict | None:
        """Return the verdict when bricks were last set down or removed; None without proofs."""
        return self.extension.verdict() if self.extension is not None else None

    def unproven(self) -> bool:
        """Return whether the bricks that were set down are not proven to stand."""
        verdict = self.verdict()
        return verdict is not None and verdict.stability is not Stability.STABLE

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """Set bricks down at rest, and judge them level by level before any step."""
        if self.extension is not None:
            self.extension.set_down(bricks)
            while self.judge():
                pass

    def shaken(self, motion: GroundMotion) -> None:
        """Begin to shake the ground."""
        if self.extension is not None and self.extension.proves:
            self.extension.shaken(motion)
            self.judge()

    def grasp(self, brick: BodyId) -> None:
        """Give a brick into a hand."""
        if self.extension is not None:
            self._apply(self.clock.timed(self.extension.grasp, brick))

    def hold(self, bricks: Collection[BodyId]) -> None:
        """Hold bricks at rest in hands."""
        if self.extension is not None:
            self._process(self.clock.timed(self.extension.hold, bricks))

    def set_handled(self, bricks: Collection[BodyId], reason: str) -> None:
        """Set the bricks that hands may push now, in place of those before."""
        if self.extension is not None:
            self._apply(self.clock.timed(self.extension.set_handled, bricks, reason))

    def let_go_by_hands(self, bricks: Collection[BodyId], set_down: bool) -> None:
        """Let bricks go; `set_down` if hands brought them."""
        if self.extension is not None:
            self._process(self.clock.timed(self.extension.let_go, bricks, set_down))
            while self.judge():
                pass

    def still_for(self) -> float:
        """Return how long all frozen bricks stay at rest [s]; inf if forever."""
        if self.extension is None:
            return inf
        return max(0.0, self.extension.holds_until() - self.world.time())

    def taken_out(self, bricks: Collection[BodyId]) -> None:
        """Report the removal of bricks to the extension."""
        if self.extension is not None:
            self._apply(self.clock.timed(self.extension.taken_out, bricks))

    def rejoined(self, joints: Joints) -> None:
        """Report other joints to an extension that judges them."""
        if self.extension is not None:
            self._apply(self.clock.timed(self.extension.rejoined, joints))

    def loaded(self, course: LoadCourse) -> None:
        """Report other loads to an extension that judges them."""
        if self.extension is not None:
            self._apply(self.clock.timed(self.extension.loaded, course))

    def moves_under_loads(self) -> bool:
        """Return whether loads act on bricks in motion."""
        return self.extension is not None and self.extension.moves_under_loads()

    def needs_engine(self) -> bool:
        """Return whether forces act on bricks in motion that motions without an engine do not cover."""
        return self.extension is not None and self.extension.needs_engine()

    def struck(self, brick: BodyId, impulse_W: Vec3, offset_W: Vec3) -> bool:
        """Announce an impulse on a brick [N s] at an offset from its centre [m]; return whether it is free to move."""
        if self.extension is None:
            return True
        self._apply(self.clock.timed(self.extension.struck, brick, impulse_W, offset_W))
        return not self.extension.is_frozen(brick)

    def about_to_step(self) -> None:
        """Announce a step of the engine."""
        if self.extension is not None:
            self.extension.about_to_step()

    def opened(self) -> bool:
        """Return whether the last step was taken back, as joints did not bear it."""
        update = None if self.extension is None else self.extension.opened()
        if update is None:
            return False
        self._process(update)
        return True

    def moved_without_engine(self) -> None:
        """Announce a motion without the engine."""
        if self.extension is not None:
            self.extension.moved_without_engine()

    def landed(self, bricks: Collection[BodyId]) -> None:
        """Judge bricks that came to rest after a motion without an engine."""
        if bricks and self.extension is not None and self.extension.proves:
            update = self.clock.timed(self.extension.landed, bricks)
            self._process(update)
            if len(update.frozen) < len(bricks):
                self.falling.end()

    def let_go(self) -> None:
        """Start falls of bricks that the last action may have let go in the air."""
        if self.extension is not None and self.extension.proves:
            self.falling.let_go(self.moving())

    def judge(self) -> bool:
        """Run one pass of the extension; return whether it froze a brick and woke none."""
        if self.extension is None:
            return False
        update = self.clock.timed(self.extension.update)
        self._process(update)
        return bool(update.frozen) and not update.woken

    def _process(self, update: Update) -> None:
        """Process the update of a pass of the extension."""
        self.judgements += 1
        if update != Update():
            # Frozen bricks are not looked at again, so their final poses are read here. All other moving bricks are
            # read at the next look.
            changed = self.world.states([*update.frozen, *update.woken])
            self.measures.judged(self.world.time(), changed, update.frozen)
            self._apply(update)

    def _apply(self, update: Update) -> None:
        self.log.add_update(self.world.time(), update, self.measures.watch)
        if update.failed:
            self._let_fall()
        elif update.woken and self.ease_in.matters(update, self.moving()):
            self.world.substep_next_contact()
        if update.failed and self.gave_way is None:
            self.gave_way = min(update.failed, key=list(self.measures.watch.bricks).index)

    def _let_fall(self) -> None:
        verdict = self.verdict()
        if verdict is not None:
            self.falling.woken(self.moving(), verdict.motion)
