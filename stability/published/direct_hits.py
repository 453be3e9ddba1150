"""Which hits does the published method see? Those of bricks that are no second impact objects, each once.

Source: the stack-stability thesis, section 3.6.1: "only the direct impacts will be accounted for, and no force from
second impact objects". Unless it is read otherwise (`SecondObjects`), what has been part of the stack and falls on what
still stands is such a second object.

A hit must be seen before it happens: when an engine reports the contact, its solver has taken the speed away.
"""

from collections.abc import Collection, Container, Iterable
from dataclasses import dataclass, field

from stability.engines.protocol import Engine
from stability.model import BodyId, Vec3
from stability.published.readings import SecondObjects
from stability.watching.approach import Approaches, Attention
from stability.watching.life_cycle import BrickObserver
from stability.watching.rest import RestLimits


@dataclass(frozen=True, slots=True)
class DirectHit:
    """A brick of the stack is about to be hit."""

    by: BodyId
    brick: BodyId
    velocity_W: Vec3  # of the hitting brick, before the hit [m/s]


@dataclass
class DirectHits(BrickObserver):
    """Follows the bricks of one engine that may hit its stack."""

    engine: Engine
    rest: RestLimits
    second: SecondObjects = SecondObjects.EVER_STACKED
    _approaches: Approaches = field(init=False)
    _stacked: set[BodyId] = field(default_factory=set, init=False)  # second objects: are, or once were, in the stack
    _reported: set[tuple[BodyId, BodyId]] = field(
        default_factory=set, init=False
    )  # who was about to hit whom, last time

    def __post_init__(self) -> None:
        self._approaches = Approaches(self.engine, lambda _: Attention(self.rest.dwell, self.rest.speed))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What has become part of the stack may be a second object from now on, also when it falls off."""
        if self.second is SecondObjects.EVER_STACKED:
            self._stacked.update(bricks)
        self._approaches.frozen(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """A name may come back with another brick, which has never been part of the stack."""
        self._stacked.difference_update(bricks)
        self._approaches.gone(bricks)

    def coming(self, awake: Iterable[BodyId], stack: Container[BodyId]) -> list[DirectHit]:
        """The hits on bricks of the stack that the next step will bring, and that were not told of yet."""
        states = self.engine.states([brick for brick in awake if brick not in self._stacked])
        hits = self._approaches.hits(states, stack)
        told, self._reported = self._reported, {(hit.by, hit.brick) for hit in hits}
        return [
            DirectHit(hit.by, hit.brick, states[hit.by].velocity_W) for hit in hits if (hit.by, hit.brick) not in told
        ]
