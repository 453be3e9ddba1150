"""What moves disturbs what is frozen: by hitting it, or by pressing harder than the proof says that it can take."""

from collections.abc import Callable, Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Self

from stability.engines.protocol import Engine
from stability.exact.candidates import solids
from stability.exact.hits.borne_hits import Flying, friction_stops, reach_beside
from stability.exact.hits.holding import Holding
from stability.exact.hits.overload import Overloads
from stability.model import BodyId, BodyState, Brick, ContactPoint, Vec3, convex
from stability.statics.assembly import Assembly
from stability.watching.approach import Approaches, Attention, Hit
from stability.watching.life_cycle import BrickObserver, Observers
from stability.watching.limits_by_size import LimitsOf

NO_LINE: Vec3 = (0.0, 0.0, 0.0)  # the direction of what is pressed, not hit
# Shares of the hold-off, which is a tenth of a second for planks.
HORIZON = 0.05
AHEAD = 0.1  # a hit is told so early: contacts of woken bricks start without force, and need a while to find it
PERIOD = 0.02
PRESSES = 0.1  # a load must last so long: forces that have just begun say little
# Times the speed at rest. A plank that is hit at 20 mm/s and slides on wood moves by 0.05 mm.
HITS = 4.0
PUSHES = 1.0  # likewise: at less than 5 mm/s a plank that is pushed slides by less than three micrometres


@dataclass(frozen=True, slots=True)
class Disturbed:
    """Frozen bricks that have to be woken, each with the direction of the hit [unit, W]."""

    struck: Mapping[BodyId, Vec3]
    reason: str
    by: tuple[BodyId, ...] = ()  # the moving bricks that hit or press them; empty if it is another who does


@dataclass(frozen=True, slots=True)
class Either:
    """The bricks that one or the other knows; nothing is copied, as there may be thousands, asked for at every step."""

    one: Container[BodyId]
    other: Container[BodyId]

    def __contains__(self, brick: object) -> bool:
        return brick in self.one or brick in self.other


@dataclass
class Disturbances(BrickObserver):
    """Looks out for what disturbs the frozen bricks of one engine."""

    engine: Engine
    limits_of: LimitsOf
    gravity: float  # [m/s2]
    reactions: Callable[[], Mapping[BodyId, Sequence[ContactPoint]]]
    _approaches: Approaches = field(init=False)
    _overloads: Overloads = field(init=False)
    _holding: Holding = field(default_factory=Holding, init=False)
    _observers: Observers = field(init=False)
    _looked: float = field(default=0.0, init=False)  # when loads were last looked at [s]

    def __post_init__(self) -> None:
        self._approaches = Approaches(self.engine, self._attention, self.gravity)
        self._overloads = Overloads(self.engine, self.reactions, lambda brick: PRESSES * self.limits_of(brick).hold_off)
        self._observers = Observers((self._approaches, self._overloads, self._holding))

    def least_speed(self, brick: BodyId) -> float:
        """The speed [m/s] below which a brick that hits does nothing."""
        return HITS * self.limits_of(brick).speed

    def least_push(self, brick: BodyId) -> float:
        """The speed [m/s] below which a push leaves a brick where it is."""
        return PUSHES * self.limits_of(brick).speed

    def _attention(self, brick: BodyId) -> Attention:
        hold_off = self.limits_of(brick).hold_off
        return Attention(HORIZON * hold_off, self.least_speed(brick), AHEAD * hold_off)

    def hits(self, assembly: Assembly, states: Mapping[BodyId, BodyState], still: Container[BodyId]) -> list[Hit]:
        """Who is about to hit which of the bricks `still`, but for hits that friction stops at once."""
        found = self._approaches.hits(states, still)
        return [hit for hit in found if not self._is_borne(assembly, hit, states[hit.by])]

    def _is_borne(self, assembly: Assembly, hit: Hit, state: BodyState) -> bool:
        shape = convex(self.engine.shape(hit.by))
        if shape is None or hit.brick not in assembly.bricks:
            return False
        masses = self.engine.masses()
        flying = Flying(Brick(hit.by, shape, masses[hit.by]), state)
        within = reach_beside(assembly.bricks[hit.brick])
        near = [name for name in self.engine.near(hit.brick, within) if name not in (hit.brick, hit.by)]
        # What is fixed is no brick, and has no mass.
        beside = [placed for _, placed in solids(self.engine, self.engine.states([n for n in near if n in masses]))]
        return friction_stops(assembly, hit, flying, beside, self._holding)

    def overloaded(self, assembly: Assembly, moving: Collection[BodyId]) -> Disturbed | None:
        """The frozen bricks that are pressed away, if any are."""
        if not moving:
            return None
        step = self.engine.time() - self._looked
        period = PERIOD * min(self.limits_of(brick).hold_off for brick in moving)
        if step < period:
            return None
        self._looked = self.engine.time()
        found = self._overloads.found(assembly, moving, min(step, 2.0 * period))
        if not found:
            return None
        touched = {body for brick in found for point in self.engine.contacts(brick) for body in (point.a, point.b)}
        by = tuple(sorted(touched.intersection(moving)))
        return Disturbed(dict.fromkeys(found, NO_LINE), f"{', '.join(found)} pressed away", by)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Frozen bricks hit nothing, and there is more to be disturbed."""
        self._observers.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """There is less to be disturbed."""
        self._observers.woken(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone neither hits nor is disturbed."""
        self._observers.gone(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._observers.absorb(other._observers)


def is_level(along_W: Vec3) -> bool:
    """Whether a hit is more along the ground than up or down: it is meant to move what it strikes."""
    return hypot(along_W[0], along_W[1]) > abs(along_W[2])


def hit_by_bricks(hits: Collection[Hit]) -> Disturbed:
    """The bricks that are hit, by which, and how fast."""
    by = tuple(sorted({hit.by for hit in hits}))
    return Disturbed({hit.brick: hit.normal_W for hit in hits}, in_words(hits), by)


def in_words(hits: Iterable[Hit]) -> str:
    """Which brick hits which, and how fast."""
    told = sorted({(hit.brick, hit.by): hit.speed for hit in hits}.items())
    return ", ".join(f"{brick} hit by {by} at {speed:.3g} m/s" for (brick, by), speed in told)
