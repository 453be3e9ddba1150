"""Which bricks that an engine moves may be put to the proof: solids that touch nothing of which statics is silent."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from stability.engines.protocol import Engine
from stability.friction_law import GivenFriction, law_of
from stability.geometry.separation import in_world
from stability.geometry.touching import reach_between
from stability.model import BodyId, BodyState, Brick, HalfSpace, Plane, convex
from stability.shapes.apart import apart
from stability.statics.facts import Placed

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
    strange = {brick: [o for o in engine.near(brick, _reach(at)) if o not in known] for brick, at in resting.items()}
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
        replace(in_world(shape, poses[body]), id=body, friction=law_of(friction).usual)
        for body, shape in shapes.items()
        if isinstance(shape, HalfSpace)
    ]
    tables = [(body, table) for body, shape in shapes.items() if (table := convex(shape)) is not None]
    return tuple(planes), tuple(Placed(Brick(body, table, NO_MASS), poses[body]) for body, table in tables)
