"""On what may a brick lean? All that it touches, with exact contact points and normals.

The engine says which bodies are near; geometry says where they touch and along which normal, since engines give edges
that meet the normal of a face (docs/decisions/0009). Only convex solids and half-spaces are known: if anything else is
near, nothing is told, and the brick stays with the engine.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from stability.engines.protocol import Engine
from stability.friction_law import Friction
from stability.geometry.separation import in_world
from stability.geometry.vectors import scale, unit
from stability.model import BodyId, Brick, ConvexShape, HalfSpace, Plane, Pose, Shape, convex
from stability.published.leaning import LeaningArea
from stability.published.resting import reach_of
from stability.statics.contacts.touch import Solid, contact_between, contact_with_plane, solid
from stability.statics.facts import Contact, Placed, Tolerances

NO_MASS = 0.0  # nobody weighs a contact
# z of the normal from another body towards the brick: below it that body lies on the brick, as the base model has it.
ON_TOP = -0.5


@dataclass(frozen=True, slots=True)
class Surfaces:
    """How bricks rub on each other, and on what never moves."""

    friction: Friction
    planes: Mapping[BodyId, Plane] = field(default_factory=dict)

    def between(self, brick: BodyId, body: BodyId) -> float:
        """The Coulomb coefficient of a brick on this body; that of a brick where nothing is known of the body."""
        plane = self.planes.get(body)
        return self.friction.of(brick, body) if plane is None else self.friction.on(brick, plane)


def smallest_side(engine: Engine, brick: BodyId) -> float | None:
    """The smallest side of a brick [m]; None if its shape is not known."""
    shape = convex(engine.shape(brick))
    return None if shape is None else shape.least_thickness


def touching_areas(engine: Engine, brick: BodyId, surfaces: Surfaces) -> Sequence[LeaningArea]:
    """Where a brick touches what does not lie on it, bricks and fixed bodies; none if some shape near is not known."""
    known = engine.masses().keys() | engine.fixed()
    shape = engine.shape(brick)
    near = engine.near(brick, reach_of(shape))
    if not known.issuperset(near):
        return ()
    states = engine.states([brick, *near])
    own = _solid(brick, shape, states[brick].pose)
    found = []
    for body in near:
        other, pose = engine.shape(body), states[body].pose
        if own is None or other is None:
            return ()
        contact = _contact(own, body, other, pose, surfaces.between(brick, body))
        if contact:
            found.append(_area(contact, brick))
    return [area for area in found if area.normal_W[2] > ON_TOP]


def _solid(body: BodyId, shape: Shape, pose: Pose) -> Solid | None:
    known = convex(shape)
    return None if known is None else solid(Placed(Brick(body, known, NO_MASS), pose))


def _contact(own: Solid, body: BodyId, shape: ConvexShape | HalfSpace, pose: Pose, friction: float) -> Contact | None:
    if not isinstance(shape, HalfSpace):
        return contact_between(own, solid(Placed(Brick(body, shape, NO_MASS), pose)), friction, Tolerances())
    surface = in_world(shape, pose)
    return contact_with_plane(own, Plane(body, surface.point_W, surface.normal_W, friction), Tolerances())


def _area(contact: Contact, brick: BodyId) -> LeaningArea:
    """A contact as the brick sees it. Of the normals of edges that meet it takes the middle one."""
    x, y, z = (sum(parts) for parts in zip(*contact.normals_W, strict=True))
    upper = contact.upper == brick
    normal_W = scale(1.0 if upper else -1.0, unit((x, y, z)))
    return LeaningArea(contact.lower if upper else contact.upper, contact.points_W, normal_W, contact.friction)
