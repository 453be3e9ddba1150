"""What PyBullet tells of the shape of somebody else's body, as far as it is a shape that is known here."""

from collections.abc import Mapping, Sequence
from typing import Any, Final
from warnings import warn

from stability.engines.pybullet.pybullet_binding import pybullet
from stability.model import IDENTITY, BodyId, HalfSpace, Shape
from stability.shapes.box import Box
from stability.shapes.off_centre_box import OffCentreBox

ORIGIN: Final = (0.0, 0.0, 0.0)
KNOWN_FIXED: Final = "Known are one GEOM_BOX and a GEOM_PLANE: give it such a shape, or name all ground by `planes=`"
KNOWN_BRICKS: Final = "Known is one GEOM_BOX with its frame, and the centre of its mass, in the middle"


class UnknownShapeWarning(UserWarning):
    """A body has a shape on which statics is silent: it, and all that touches it, is left to the engine."""


def shape_of(parts: Sequence[Sequence[Any]], fixed: bool) -> Shape:
    """The shape that `getCollisionShapeData` tells of a body, fixed or a brick; None if none is known here.

    A fixed box may have its frame anywhere, as that of `plane.urdf` has: nobody weighs it.
    """
    if len(parts) != 1:
        return None
    _, _, kind, dimensions, _, position, orientation = parts[0]
    if orientation != IDENTITY or (position != ORIGIN and not fixed):
        return None
    if kind == pybullet.GEOM_BOX:
        x, y, z = position
        return Box(dimensions) if position == ORIGIN else OffCentreBox(dimensions, (-x, -y, -z))
    return HalfSpace(dimensions) if kind == pybullet.GEOM_PLANE and position == ORIGIN else None


def warn_of_unknown(body: BodyId, what: str, fixed: bool) -> None:
    """Warn that a body with such a shape, in words, is left to the engine."""
    told = f"body '{body}', {'which is fixed' if fixed else 'a brick'}, is {what}: no shape that is known here"
    left = (
        "exact statics leaves it to the engine, and all that touches it; the published method takes the engine's "
        "contact points for it. Of others like it nothing will be said"
    )
    warn(UnknownShapeWarning(f"{told}; {left}. {KNOWN_FIXED if fixed else KNOWN_BRICKS}"), stacklevel=2)


def in_words(parts: Sequence[Sequence[Any]]) -> str:
    """What the shape of a body is called that is none of those that are known here."""
    if len(parts) != 1:
        return f"a compound of {len(parts)} shapes" if parts else "without a collision shape"
    _, _, kind, _, _, position, orientation = parts[0]
    called = _names().get(kind, f"of the kind {kind}")
    if orientation != IDENTITY:
        return f"a {called} that is turned in its frame (collisionFrameOrientation, or that of the inertia)"
    if position != ORIGIN:
        return f"a {called} off the middle of its frame (collisionFramePosition, or that of the inertia)"
    return f"a {called}"


def _names() -> Mapping[int, str]:
    """By number, what PyBullet calls its kinds of shapes."""
    kinds = ("BOX", "CAPSULE", "CYLINDER", "HEIGHTFIELD", "MESH", "PLANE", "SPHERE")
    return {getattr(pybullet, f"GEOM_{kind}"): f"GEOM_{kind}" for kind in kinds}
