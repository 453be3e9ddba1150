"""What frozen bricks press on woken ones with: the forces of the proof that held while all was frozen.

What lies above a brick in the middle of a wall stands without it if it has to, as an arch, and so it stays frozen when
the brick is hit. But it lies on that brick with all its weight, and friction under this weight is what holds the brick.
To an engine a frozen brick has no weight, so its force is exerted in its stead, where the two are in touch, with its
friction, for as long as they are. It keeps its size: what is frozen does not follow what gives way, and does not shift
its weight elsewhere before it has lost its support.
"""

from collections import defaultdict
from collections.abc import Collection, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from stability.engines.protocol import Engine, Pressing
from stability.geometry.vectors import add, dot, norm, scale
from stability.mechanics.rubbing import Pressed
from stability.model import BodyId, BodyState, ContactPoint, Vec3
from stability.statics.certificate import Tally
from stability.statics.contacts.solids import solid
from stability.statics.contacts.touch import contact_between
from stability.statics.facts import Contact, Placed, Tolerances
from stability.watching.life_cycle import BrickObserver

NOTHING: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Load:
    """What a frozen brick presses on a woken one with."""

    by: Placed
    size: float  # along the normal of their contact [N]
    friction: float  # Coulomb coefficient

    def on(self, carrying: Placed) -> list[Pressed]:
        """What acts on the brick that carries, where it is; nothing where the two are not in touch any more."""
        contact = contact_between(solid(carrying), solid(self.by), self.friction, Tolerances())
        if contact is None:
            return []
        down_W = _normal(contact, seen_from=self.by.brick.id)
        force_W = scale(self.size / len(contact.points_W), down_W)
        return [Pressed(force_W, at_W, self.friction) for at_W in contact.points_W]


@dataclass
class DeadLoads(BrickObserver):
    """The loads of frozen bricks on the woken ones of one engine."""

    engine: Engine
    presser: Pressing | None  # None: what is frozen presses with nothing
    _carrying: dict[BodyId, Placed] = field(default_factory=dict, init=False)  # woken bricks, where they were frozen
    _loads: dict[BodyId, list[Load]] = field(default_factory=dict, init=False)  # by the brick that carries them

    def take_over(self, forces: Tally, woken: Iterable[Placed], frozen: Mapping[BodyId, Placed]) -> None:
        """Bricks are woken that carried frozen ones with these forces."""
        for placed in woken:
            loads = list(_loads_on(placed.brick.id, forces, frozen))
            if loads and self.presser is not None:
                self._loads[placed.brick.id], self._carrying[placed.brick.id] = loads, placed

    def exert(self) -> None:
        """Tell the engine what acts in the coming step."""
        if self.presser is None or not self._loads:
            return
        for brick, state in self._states().items():
            carrying = replace(self._carrying[brick], pose=state.pose)
            self.presser.press(brick, [each for load in self._loads[brick] for each in load.on(carrying)])

    def reactions(self) -> Mapping[BodyId, list[ContactPoint]]:
        """What the woken bricks press back with on the frozen ones that they still carry."""
        found: dict[BodyId, list[ContactPoint]] = defaultdict(list)
        for brick, state in self._states().items():
            carrying = replace(self._carrying[brick], pose=state.pose)
            for load in self._loads[brick]:
                by = load.by.brick.id
                for each in load.on(carrying):
                    size = norm(each.force_W)
                    found[by].append(
                        ContactPoint(by, brick, each.at_W, scale(-1.0 / size, each.force_W), 0.0, size, NOTHING)
                    )
        return found

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._loads |= other._loads
        self._carrying |= other._carrying

    def _states(self) -> Mapping[BodyId, BodyState]:
        return self.engine.states(sorted(self._loads))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What is frozen carries by its proof."""
        for brick in bricks:
            self._loads.pop(brick, None)
            self._carrying.pop(brick, None)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """What is woken presses by its own weight."""
        self._leave_out(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone neither presses nor carries."""
        self.frozen(bricks)
        self._leave_out(bricks)

    def _leave_out(self, pressing: Container[BodyId]) -> None:
        for brick, loads in self._loads.items():
            self._loads[brick] = [load for load in loads if load.by.brick.id not in pressing]


def _loads_on(brick: BodyId, forces: Tally, frozen: Mapping[BodyId, Placed]) -> Iterator[Load]:
    """What presses on a brick by the forces of a proof."""
    for contact, at_points in forces.onto(brick):
        up_W, size = _normal(contact, seen_from=brick), 0.0
        for in_cones in at_points:
            for force_W in in_cones:
                size += dot(force_W, up_W)
        if contact.upper in frozen and size > 0.0:
            yield Load(frozen[contact.upper], size, contact.friction)


def _normal(contact: Contact, seen_from: BodyId) -> Vec3:
    """The middle of the normals of a contact [unit, W], away from one of its bodies."""
    total = NOTHING
    for normal in contact.normals_W:
        total = add(total, normal)
    return scale((1.0 if contact.lower == seen_from else -1.0) / norm(total), total)
