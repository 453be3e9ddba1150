"""Which gravity an extension reckons with: what its engine says, where that says anything."""

from math import hypot, isclose

from stability.engines.protocol import Engine, TellsGravity
from stability.geometry.given_numbers import admit_number
from stability.model import EARTH

SAME = 1e-6  # of the size of gravity: what an engine may round, and how far it may lean


def gravity_of(engine: Engine, given: float | None) -> float:
    """The gravity along -z to reckon with [m/s2]: that of the engine, or the one that is given.

    Of an engine that tells of none, or has none as its owner applies it otherwise, it is the given one, or EARTH.

    Raises ValueError where the engine has other gravity than is given, where it has none and none is given, and where
    its gravity leans. Raises TypeError for what is no engine.
    """
    if not callable(getattr(engine, "masses", None)):
        raise TypeError(f"expected an engine, such as PyBulletBodies(client), not {engine!r}")
    if given is not None:
        admit_number("the gravity is", given, "write m/s2, as a number that is more than 0")
    if not isinstance(engine, TellsGravity):
        return EARTH if given is None else given
    x, y, z = engine.gravity_W()
    if x == y == z == 0.0:
        if given is None:
            raise ValueError("the engine has no gravity: set it before (in PyBullet: p.setGravity(0, 0, -9.81))")
        return given
    if z >= 0.0 or hypot(x, y) > SAME * -z:
        raise ValueError(f"the engine's gravity is ({x:g}, {y:g}, {z:g}) m/s2: proofs are for gravity along -z alone")
    if given is not None and not isclose(given, -z, rel_tol=SAME):
        raise ValueError(f"gravity={given:g} is not that of the engine, {-z:g} m/s2: leave it out, or mend one of both")
    return -z
