"""Candidates for freezing: selection, rest poses, and removal of unproven bricks from an assembly."""

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
from stability.statics.opened_joints import Pair, held_pairs, joined_pairs

# Selection of the bricks that may be judged: those that touch only bodies that statics supports.


NO_MASS = 0.0  # of a fixed body, whose mass has no effect
ON_TOP = -0.5  # the other body lies on the brick if the z component of the normal towards the brick is smaller


def solids(engine: Engine, states: Mapping[BodyId, BodyState]) -> Iterator[tuple[BodyId, Placed]]:
    """Yield the bricks with convex shapes, at their poses."""
    masses = engine.masses()
    for brick, state in states.items():
        shape = convex(engine.shape(brick))
        if shape is not None:
            yield brick, Placed(Brick(brick, shape, masses[brick]), state.pose)


def judgeable_bricks(
    engine: Engine, resting: Mapping[BodyId, Placed], supported: Collection[BodyId], states: Mapping[BodyId, BodyState]
) -> list[Placed]:
    """Return the resting bricks that touch only each other and `supported` bodies: no robots and no moving bricks."""
    near: dict[BodyId, list[BodyId]] = {brick: [] for brick in resting}  # resting bricks that may hang on each
    clear, unclear = dict(resting), []
    for brick, placed in resting.items():
        unsupported = [other for other in engine.neighbours(brick, _reach(placed)) if other not in supported]
        for other in unsupported:
            if other in resting:
                near[other].append(brick)
        if any(other not in resting and _hangs_on(engine, placed, other, states) for other in unsupported):
            unclear.append(brick)
            del clear[brick]
    while unclear:
        other = unclear.pop()
        for brick in near[other]:
            if brick in clear and _hangs_on(engine, clear[brick], other, states):
                unclear.append(brick)
                del clear[brick]
    return list(clear.values())


def _hangs_on(engine: Engine, placed: Placed, other: BodyId, states: Mapping[BodyId, BodyState]) -> bool:
    own = placed.brick.shape
    shape = convex(engine.shape(other)) if other in states else None
    if shape is not None:
        between = apart(own, placed.pose, shape, states[other].pose)
        reach = reach_between(own.least_thickness, shape.least_thickness)
        # A brick that still moves on top is a future load, which is judged when it comes to rest.
        return between.gap <= reach and between.normal_BA_W[2] > ON_TOP
    contacts = engine.contacts(placed.brick.id)
    return any(other in (point.a, point.b) and point.gap <= _reach(placed) for point in contacts)


def _reach(placed: Placed) -> float:
    return reach_between(placed.brick.shape.least_thickness)


def fixed_bodies(engine: Engine, friction: GivenFriction) -> tuple[tuple[Plane, ...], tuple[Placed, ...]]:
    """Return the fixed bodies of an engine that statics supports: half-spaces and convex solids."""
    shapes = {body: engine.shape(body) for body in sorted(engine.fixed())}
    poses = {body: state.pose for body, state in engine.states(shapes).items()}
    planes = [
        replace(in_world(shape, poses[body]), id=body, friction=as_friction(friction).usual)
        for body, shape in shapes.items()
        if isinstance(shape, HalfSpace)
    ]
    tables = [(body, table) for body, shape in shapes.items() if (table := convex(shape)) is not None]
    return tuple(planes), tuple(Placed(Brick(body, table, NO_MASS), poses[body]) for body, table in tables)


# Rest poses: woken bricks that hardly moved return to their former poses, as engines let every brick creep slightly.
#
# Struck bricks stay where they come to rest, as a single tap moves a brick by little, and a hundred taps by a lot.


# Shares of the smallest side, for a plank 0.3 and 0.02 mm. If no woken brick has moved further than the first, the hit
# moved none and all return; otherwise only bricks within the second, the creep of an engine, return.
HIT_NOTHING = 0.04
CREPT = 0.0026
DRIVEN = 5e-4  # 4 micrometres: creep limit of bricks that hands, which push slowly, may have moved
NOTHING = 1e-4  # a micrometre: creep limit of struck bricks


@dataclass
class RestPoses(BrickObserver):
    """Poses of woken bricks before they were disturbed."""

    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)
    _struck: set[BodyId] = field(default_factory=set, init=False)  # bricks struck along the ground
    _driven: set[BodyId] = field(default_factory=set, init=False)  # bricks that a hand may have moved

    def remember(self, poses: Mapping[BodyId, Pose], struck: Collection[BodyId] = ()) -> None:
        """Store the poses of bricks that a hit wakes; `struck` are those that it strikes along the ground.

        A brick that has not come to rest since an earlier hit keeps its rest pose from before that hit.
        """
        self._poses = {**poses, **self._poses}
        self._struck.update(struck)

    def store_driven(self, poses: Mapping[BodyId, Pose]) -> None:
        """Store the poses of bricks that a hand may move: a pushed brick keeps even a small shift."""
        self.remember(poses)
        self._driven.update(poses)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Drop the old poses of bricks that were frozen again."""
        for brick in bricks:
            self._poses.pop(brick, None)
        self._struck.difference_update(bricks)
        self._driven.difference_update(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the poses of removed bricks."""
        self.frozen(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the poses of another instance."""
        self._poses |= other._poses
        self._struck |= other._struck
        self._driven |= other._driven

    def __contains__(self, brick: object) -> bool:
        return brick in self._poses

    def put_back(self, resting: Sequence[Placed]) -> list[Placed]:
        """Return the bricks that came to rest, with the rest pose of each that only crept."""
        moved_by = {
            placed.brick.id: moved_share(placed, self._poses[placed.brick.id])
            for placed in resting
            if placed.brick.id in self._poses
        }
        limit = HIT_NOTHING if all(move <= HIT_NOTHING for move in moved_by.values()) else CREPT
        limits = {brick: NOTHING if brick in self._struck else limit for brick in moved_by}
        limits |= {brick: min(DRIVEN, limits[brick]) for brick in moved_by if brick in self._driven}
        return [
            replace(placed, pose=self._poses[placed.brick.id])
            if placed.brick.id in moved_by and moved_by[placed.brick.id] <= limits[placed.brick.id]
            else placed
            for placed in resting
        ]


def moved_share(placed: Placed, pose: Pose) -> float:
    """Return an upper bound of the distances of a brick's points from those at another pose, by its smallest side."""
    shape = placed.brick.shape
    shift = dist(pose.position_W, placed.pose.position_W) + 0.5 * shape.length * turn_between(pose, placed.pose)
    return shift / shape.least_thickness


@dataclass(frozen=True, slots=True)
class Judgement:
    """Result of judging an assembly: the released bricks, and the verdict on the others."""

    first: Verdict
    last: Verdict  # STABLE, of the remaining bricks
    released: Mapping[BodyId, Pose]  # the released bricks with their poses
    lowest: tuple[BodyId, ...]  # the lowest brick that the first verdict names; empty if it is STABLE
    held: frozenset[Pair] = frozenset()  # pairs of released bricks whose joint does not open
    opened: frozenset[Pair] = frozenset()  # pairs of bodies, released ones among them, whose joint opens


def release_until_stable(assembly: Assembly, verdict: Verdict, *, names_smallest: bool = True) -> Judgement:
    """Remove bricks that move or are undecided from an assembly until the rest is proven; see `Assembly.add_all`."""
    first = verdict = as_it_begins(assembly, verdict)
    released: dict[BodyId, Pose] = {}
    lowest: tuple[BodyId, ...] = ()
    held, joined = set[Pair](), set[Pair]()
    while verdict.stability is not Stability.STABLE:
        moving = verdict.moving or tuple(assembly.bricks)
        poses = {brick: assembly.bricks[brick].pose for brick in moving}
        lowest = lowest or (min(moving, key=lambda brick: (poses[brick].position_W[2], brick)),)
        released |= poses
        if assembly.joints.rules:
            problem = assembly.problem(moving)
            joined |= joined_pairs(problem.contacts)
            held |= held_pairs(problem, verdict.motion)
        verdict = as_it_begins(assembly, assembly.remove(moving, names_smallest=names_smallest))
    return Judgement(first, verdict, released, lowest, frozenset(held), frozenset(joined - held))
