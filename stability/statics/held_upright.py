"""Do upright forces, passed down brick by brick, balance a problem? If so no motion lowers it, and none is looked for.

Weight propagation, with all that is no brick of the problem held fixed. A failure proves nothing.
"""

from collections.abc import Mapping

from stability.graph import from_the_top
from stability.model import BodyId
from stability.statics.facts import ZERO, Contact, Problem, Wrench
from stability.statics.load_core import carries_upright
from stability.statics.propagation import Failure, VerticalLoad, propagate


def is_held_upright(problem: Problem) -> bool:
    """Whether weight propagation balances all loads of a problem, which must be weights."""
    weights = _weights(problem)
    if weights is None:
        return False
    supports: dict[BodyId, list[Contact]] = {name: [] for name in problem.bricks}
    for contact in problem.contacts:
        if contact.upper in supports and carries_upright(contact):
            supports[contact.upper].append(contact)
    if not all(supports.values()):
        return False
    order = from_the_top({name: [c.lower for c in below if c.lower in supports] for name, below in supports.items()})
    if len(order) < len(supports):
        return False  # bricks that rest on one another in a ring
    return not isinstance(propagate(order, weights, supports, {}), Failure)


def _weights(problem: Problem) -> Mapping[BodyId, VerticalLoad] | None:
    """The loads as weights at the centres of mass; None if one of them is not a weight."""
    weights = {}
    for name, placed in problem.bricks.items():
        load = problem.loads.get(name, Wrench(ZERO))
        x, y, z = load.force_W
        if x != 0.0 or y != 0.0 or not z < 0.0 or load.torque_W != ZERO:
            return None
        weights[name] = VerticalLoad(-z, placed.pose.position_W[:2])
    return weights
