"""Bricks at rest on bricks that are at rest without a proof: the engine holds them until a brick that they touch moves.

A fallen domino leans on the next one, and this on the next, up to the front of the wave. None of them is proven before
the wave ends. A dozing brick is proven to stand for as long as the bricks that it touches stay where they are. On those
that may move it presses by the contact forces that it had when it came to rest.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Self

from stability.contact_law import GivenFriction, as_friction
from stability.engines.protocol import Engine
from stability.model import BodyId, BodyState, Plane
from stability.problem import Placed, Tolerances
from stability.stabilizers.exact.candidates import moved_share, release_until_stable, solids
from stability.stabilizers.exact.woken_region import DeadLoad, DeadLoads
from stability.stabilizers.protocol import BrickObserver
from stability.stabilizers.rest import MOVED, LimitsOf
from stability.statics.assembly import Assembly


@dataclass(frozen=True, slots=True)
class _Asleep:
    """A dozing brick, and its normal forces on the bricks that it touches [N]."""

    placed: Placed
    presses: Mapping[BodyId, float]


@dataclass
class Dozing(BrickObserver):
    """The dozing bricks of one engine. To the other observers they are awake."""

    engine: Engine
    limits_of: LimitsOf
    loads: DeadLoads
    friction: GivenFriction
    gravity: float  # [m/s2]
    tolerances: Tolerances
    _asleep: dict[BodyId, _Asleep] = field(default_factory=dict, init=False)
    # By touched brick: where it was when the first of the bricks that touch it fell asleep, and these bricks.
    _touched: dict[BodyId, tuple[Placed, set[BodyId]]] = field(default_factory=dict, init=False)
    _looked: float = field(default=0.0, init=False)  # time of the last search for bricks that may doze [s]

    def __contains__(self, brick: object) -> bool:
        return brick in self._asleep

    def __iter__(self) -> Iterator[BodyId]:
        return iter(self._asleep)

    def __len__(self) -> int:
        return len(self._asleep)

    def is_due(self, bricks: Collection[BodyId]) -> bool:
        """Return whether it is time to look for bricks that may doze: once per hold-off."""
        now = self.engine.time()
        due = bool(bricks) and now >= self._looked + min(self.limits_of(brick).hold_off for brick in bricks)
        if due:
            self._looked = now
        return due

    def fall_asleep(
        self,
        resting: Sequence[Placed],
        moving: Collection[BodyId],
        planes: Sequence[Plane],
        tables: Sequence[Placed] = (),
    ) -> None:
        """Hold those bricks at rest that touch no moving brick, if they stand on what they touch."""
        touching = {placed.brick.id: self._forces_by_touched(placed.brick.id) for placed in resting}
        candidates = [placed for placed in resting if not touching[placed.brick.id].keys() & moving]
        names = {placed.brick.id for placed in candidates}
        beside = sorted({other for name in names for other in touching[name]} & self.engine.masses().keys() - names)
        held = dict(solids(self.engine, self.engine.states(beside)))
        carrying = (*tables, *held.values())
        assembly = Assembly(planes, self.friction, self.gravity, self.tolerances, carrying, overlap=inf)
        release_until_stable(assembly, assembly.add_all(candidates, names_smallest=False), names_smallest=False)
        poses = {**held, **{placed.brick.id: placed for placed in candidates}}
        for name, placed in assembly.bricks.items():
            presses = {other: force for other, force in touching[name].items() if other in poses}
            self._asleep[name] = _Asleep(placed, presses)
            for other in presses:
                self._touched.setdefault(other, (poses[other], set()))[1].add(name)
        for name in assembly.bricks:
            self.loads.frozen([name])
            self.engine.freeze(name)
            self._press(name, self._asleep[name].presses.keys() - self._asleep.keys())

    def disturbed(self, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """Return the dozing bricks that touch a brick in `states` which has moved since they fell asleep."""
        moved = (
            touching
            for other, (placed, touching) in self._touched.items()
            if (state := states.get(other)) is not None and moved_share(placed, state.pose) > MOVED
        )
        return sorted(set[BodyId]().union(*moved))

    def touched_anew(self, moving: Iterable[BodyId]) -> list[BodyId]:
        """Return the dozing bricks that moving bricks have come to touch since they fell asleep."""
        touched = {
            other
            for brick in moving
            for point in self.engine.contacts(brick)
            for other in (point.a, point.b)
            if other in self._asleep and brick not in self._asleep[other].presses
        }
        return sorted(touched)

    def wake(self, bricks: Iterable[BodyId] | None = None) -> None:
        """Let dozing bricks move again; all of them by default."""
        woken = sorted(self._asleep if bricks is None else self._asleep.keys() & bricks)
        if not woken:
            return
        for name in woken:
            del self._asleep[name]
            self.engine.wake(name)
        self._forget(woken)
        self._press_on(woken)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Wake the bricks that touched removed ones."""
        touching = [name for brick in bricks if brick in self._touched for name in self._touched[brick][1]]
        lost = [brick for brick in bricks if self._asleep.pop(brick, None) is not None]
        self._forget(lost)
        self.wake(touching)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Wake the bricks that touch frozen ones, as they may be proven on these."""
        self.removed(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Press on bricks that were proven before."""
        self._press_on(bricks)

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Wake all bricks, as these may lie on them."""
        self.wake()

    def absorb(self, other: Self) -> None:
        """Wake all bricks of both engines."""
        for name in other._asleep:
            self.engine.wake(name)
        self.wake()

    def _forget(self, bricks: Sequence[BodyId]) -> None:
        """Drop what these bricks touched, and their loads."""
        self.loads.drop_from(bricks)
        for other, (_, touching) in list(self._touched.items()):
            touching.difference_update(bricks)
            if not touching:
                del self._touched[other]

    def _forces_by_touched(self, brick: BodyId) -> dict[BodyId, float]:
        """Return the normal force on each body that a brick touches [N]."""
        forces: defaultdict[BodyId, float] = defaultdict(float)
        for point in self.engine.contacts(brick):
            forces[point.b if point.a == brick else point.a] += point.normal_force
        return forces

    def _press_on(self, bricks: Iterable[BodyId]) -> None:
        """Let all dozing bricks press on bricks that have woken."""
        for brick in bricks:
            for name in sorted(self._touched[brick][1]) if brick in self._touched else ():
                self._press(name, [brick])

    def _press(self, name: BodyId, others: Iterable[BodyId]) -> None:
        """Let a dozing brick press on bricks that may move."""
        asleep = self._asleep[name]
        for other in sorted(others):
            size, friction = asleep.presses[other], as_friction(self.friction).of(name, other)
            if size > 0.0 and not self.engine.holds(other):
                self.loads.add(self._touched[other][0], DeadLoad(asleep.placed, size, friction))
