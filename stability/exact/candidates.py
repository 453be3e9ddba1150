"""Which bricks that an engine moves may be put to the proof: boxes that touch nothing of which statics is silent."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from stability.engines.protocol import Engine
from stability.geometry.separation import boxes_apart, in_world
from stability.geometry.touching import reach_between
from stability.model import BodyId, BodyState, Box, Brick, HalfSpace, Plane
from stability.statics.facts import Placed

NO_MASS = 0.0  # of what is fixed; nobody weighs it
ON_TOP = -0.5  # z of the normal from one body towards another that it lies on


def boxes(engine: Engine, states: Mapping[BodyId, BodyState]) -> Iterator[tuple[BodyId, Placed]]:
    """Those of the bricks that are boxes, where they are."""
    masses = engine.masses()
    for brick, state in states.items():
        shape = engine.shape(brick)
        if isinstance(shape, Box):
            yield brick, Placed(Brick(brick, shape.size, masses[brick]), state.pose)


def clear_of_strangers(
    engine: Engine, resting: Mapping[BodyId, Placed], known: Collection[BodyId], states: Mapping[BodyId, BodyState]
) -> list[Placed]:
    """Those of the resting bricks that touch only each other and what is known: no robots, and nothing that moves."""
    strange = {brick: [o for o in engine.near(brick, _reach(at)) if o not in known] for brick, at in resting.items()}
    kept = dict(resting)
    while True:
        out = [b for b in kept if any(o not in kept and _hangs_on(engine, kept[b], o, states) for o in strange[b])]
        if not out:
            return list(kept.values())
        for brick in out:
            del kept[brick]


def _hangs_on(engine: Engine, placed: Placed, other: BodyId, states: Mapping[BodyId, BodyState]) -> bool:
    size = placed.brick.size
    shape = engine.shape(other) if other in states else None
    if isinstance(shape, Box):
        apart = boxes_apart(size, placed.pose, shape.size, states[other].pose)
        # What still moves on top of a brick is a load to come: it is judged when it has come to rest.
        return apart.gap <= reach_between(min(size), min(shape.size)) and apart.normal_BA_W[2] > ON_TOP
    contacts = engine.contacts(placed.brick.id)
    return any(other in (point.a, point.b) and point.gap <= _reach(placed) for point in contacts)


def _reach(placed: Placed) -> float:
    return reach_between(min(placed.brick.size))


def fixed_bodies(engine: Engine, friction: float) -> tuple[tuple[Plane, ...], tuple[Placed, ...]]:
    """The fixed bodies of an engine, as statics knows them: half-spaces and boxes."""
    shapes = {body: engine.shape(body) for body in sorted(engine.fixed())}
    poses = {body: state.pose for body, state in engine.states(shapes).items()}
    planes = [
        replace(in_world(shape, poses[body]), id=body, friction=friction)
        for body, shape in shapes.items()
        if isinstance(shape, HalfSpace)
    ]
    tables = [(body, shape) for body, shape in shapes.items() if isinstance(shape, Box)]
    return tuple(planes), tuple(Placed(Brick(body, box.size, NO_MASS), poses[body]) for body, box in tables)
