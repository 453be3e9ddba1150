"""Chooses the moving bricks that may be frozen, restores their rest poses, and prunes what is not proven."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

from stability.contact_law import GivenFriction, as_friction
from stability.dynamics.onset import as_it_begins
from stability.engines.protocol import Engine
from stability.geometry.box_distance import in_world, reach_between
from stability.geometry.placed_shape import apart
from stability.geometry.vectors import turn_between
from stability.model import BodyId, BodyState, Brick, HalfSpace, Plane, Pose, convex
from stability.problem import Placed, Stability, Verdict
from stability.stabilizers.protocol import BrickObserver
from stability.statics.assembly import Assembly

# Moving bricks that may be judged: they touch nothing that statics does not know.


NO_MASS = 0.0  # of what is fixed; nobody weighs it
ON_TOP = -0.5  # z of the normal from one body towards another that it lies on


def solids(engine: Engine, states: Mapping[BodyId, BodyState]) -> Iterator[tuple[BodyId, Placed]]:
    """Those of the bricks whose shape is known, where they are."""
    masses = engine.masses()
    for brick, state in states.items():
        shape = convex(engine.shape(brick))
        if shape is not None:
            yield brick, Placed(Brick(brick, shape, masses[brick]), state.pose)


def clear_of_strangers(
    engine: Engine, resting: Mapping[BodyId, Placed], known: Collection[BodyId], states: Mapping[BodyId, BodyState]
) -> list[Placed]:
    """Those of the resting bricks that touch only each other and what is known: no robots, and nothing that moves."""
    strange = {
        brick: [o for o in engine.neighbours(brick, _reach(at)) if o not in known] for brick, at in resting.items()
    }
    kept = dict(resting)
    while True:
        out = [b for b in kept if any(o not in kept and _hangs_on(engine, kept[b], o, states) for o in strange[b])]
        if not out:
            return list(kept.values())
        for brick in out:
            del kept[brick]


def _hangs_on(engine: Engine, placed: Placed, other: BodyId, states: Mapping[BodyId, BodyState]) -> bool:
    own = placed.brick.shape
    shape = convex(engine.shape(other)) if other in states else None
    if shape is not None:
        between = apart(own, placed.pose, shape, states[other].pose)
        reach = reach_between(own.least_thickness, shape.least_thickness)
        # What still moves on top of a brick is a load to come: it is judged when it has come to rest.
        return between.gap <= reach and between.normal_BA_W[2] > ON_TOP
    contacts = engine.contacts(placed.brick.id)
    return any(other in (point.a, point.b) and point.gap <= _reach(placed) for point in contacts)


def _reach(placed: Placed) -> float:
    return reach_between(placed.brick.shape.least_thickness)


def fixed_bodies(engine: Engine, friction: GivenFriction) -> tuple[tuple[Plane, ...], tuple[Placed, ...]]:
    """The fixed bodies of an engine, as statics knows them: half-spaces and convex solids."""
    shapes = {body: engine.shape(body) for body in sorted(engine.fixed())}
    poses = {body: state.pose for body, state in engine.states(shapes).items()}
    planes = [
        replace(in_world(shape, poses[body]), id=body, friction=as_friction(friction).usual)
        for body, shape in shapes.items()
        if isinstance(shape, HalfSpace)
    ]
    tables = [(body, table) for body, shape in shapes.items() if (table := convex(shape)) is not None]
    return tuple(planes), tuple(Placed(Brick(body, table, NO_MASS), poses[body]) for body, table in tables)


# Puts bricks that were woken and hardly moved back where they were, because engines let every brick creep a little.
#
# What was struck is the exception: a tap moves it by little, and a hundred taps by a lot. It stays where it comes to
# rest.


# Shares of the smallest side, for a plank 0.3 and 0.02 mm. If all that was woken has moved less than the first, the hit
# moved nothing; if something did move, only what the engine's creep has moved goes back.
HIT_NOTHING = 0.04
CREPT = 0.0026
DRIVEN = 5e-4  # 4 micrometres: what a hand may have moved and did not move further has crept; hands push slowly
NOTHING = 1e-4  # a micrometre: what was struck and did not move even so far was not moved


@dataclass
class RestPoses(BrickObserver):
    """Where bricks stood when a hit woke them."""

    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)
    _struck: set[BodyId] = field(default_factory=set, init=False)  # those of them that were pushed along the ground
    _driven: set[BodyId] = field(default_factory=set, init=False)  # those that a hand may have moved, by however little

    def remember(self, poses: Mapping[BodyId, Pose], struck: Collection[BodyId] = ()) -> None:
        """Remember where bricks stand that a hit wakes, and which of them it meant to move along the ground.

        A brick that has not come to rest since an earlier hit keeps the rest pose that it had before that one.
        """
        self._poses = {**poses, **self._poses}
        self._struck.update(struck)

    def remember_driven(self, poses: Mapping[BodyId, Pose]) -> None:
        """The same of bricks that a hand may move: what it pushes keeps its shift, however little that is."""
        self.remember(poses)
        self._driven.update(poses)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Where bricks are frozen again is where they stand."""
        for brick in bricks:
            self._poses.pop(brick, None)
        self._struck.difference_update(bricks)
        self._driven.difference_update(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone has no place to go back to."""
        self.frozen(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._poses |= other._poses
        self._struck |= other._struck
        self._driven |= other._driven

    def __contains__(self, brick: object) -> bool:
        return brick in self._poses

    def put_back(self, coming: Sequence[Placed]) -> list[Placed]:
        """The bricks that come to rest; each that hardly moved, and was not struck, is at its rest pose."""
        moves = {placed.brick.id: self._moved(placed) for placed in coming if placed.brick.id in self._poses}
        limit = HIT_NOTHING if all(move <= HIT_NOTHING for move in moves.values()) else CREPT
        limits = {brick: NOTHING if brick in self._struck else limit for brick in moves}
        limits |= {brick: min(DRIVEN, limits[brick]) for brick in moves if brick in self._driven}
        return [
            replace(placed, pose=self._poses[placed.brick.id])
            if placed.brick.id in moves and moves[placed.brick.id] <= limits[placed.brick.id]
            else placed
            for placed in coming
        ]

    def _moved(self, placed: Placed) -> float:
        """How far any point of a brick may have moved, as a share of its smallest side."""
        home, shape = self._poses[placed.brick.id], placed.brick.shape
        shift = dist(home.position_W, placed.pose.position_W) + 0.5 * shape.length * turn_between(home, placed.pose)
        return shift / shape.least_thickness


# Bricks that move, or are in doubt, are taken out of an assembly until what is left of it is proven.


@dataclass(frozen=True, slots=True)
class Judgement:
    """What came of a verdict: which bricks an assembly had to release, and what was proven of the rest."""

    first: Verdict
    last: Verdict  # STABLE, of the bricks that stay
    released: Mapping[BodyId, Pose]  # the bricks that do not stay, and where they are
    lowest: tuple[BodyId, ...]  # the lowest brick that the first verdict names; empty if it names none


def release_until_stable(assembly: Assembly, verdict: Verdict, *, names_smallest: bool = True) -> Judgement:
    """Take out of an assembly what begins to move or is in doubt, until what is left is proven; see `add_all`."""
    first = verdict = as_it_begins(assembly, verdict)
    released: dict[BodyId, Pose] = {}
    lowest: tuple[BodyId, ...] = ()
    while verdict.stability is not Stability.STABLE:
        moving = verdict.moving or tuple(assembly.bricks)
        poses = {brick: assembly.bricks[brick].pose for brick in moving}
        lowest = lowest or (min(moving, key=lambda brick: (poses[brick].position_W[2], brick)),)
        released |= poses
        verdict = as_it_begins(assembly, assembly.remove(moving, names_smallest=names_smallest))
    return Judgement(first, verdict, released, lowest)
