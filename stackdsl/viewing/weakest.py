"""Where a structure that is proven to stand is nearest to tipping: the brick whose centre has least room.

Room is how deep the centre of a brick lies inside what carries it down to the ground, in plan. Of a brick that stands
by friction alone, or by the weight of others, that says nothing, and it is passed over.
"""

from dataclasses import dataclass

from stability.model import BodyId
from stackdsl.viewing.shown_proofs import ShownProof


@dataclass(frozen=True, slots=True)
class Weakest:
    """One brick of a proven structure."""

    brick: BodyId
    depth: float  # [m]


def weakest_of(proof: ShownProof) -> Weakest | None:
    """The brick with least room, the lowest-named of several; None where room is told of none."""
    told = [(brick.depth, name) for name, brick in proof.bricks.items() if brick.depth is not None]
    return Weakest(min(told)[1], min(told)[0]) if told else None
