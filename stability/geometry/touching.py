"""Do two bodies touch? The one definition: statics, both methods, the compiler and `explain` all take it from here.

Two bodies touch if they are no further apart, and no deeper in each other, than their reach, a share of the smallest
side of the thinner one. So a scene touches where it did when all of it is made larger or smaller.

A gap below a body closes as the body comes down; one beside it does not, and no force crosses it. So a gap along an
inclined normal may be as wide as what closes when the body comes down by the reach, and beside a body hardly at all.
This is asked of each point of a contact, not of the nearest alone, and along each direction in which two bodies are
apart. Whoever wants fewer gaps to count says how wide they may be (`within`); how deep bodies may be in each other is
the reach in any case.
"""

from math import inf

# Share of the smallest side: what engines leave. Less than a fifth of a millimetre for a plank of 7.8 mm, below the
# 0.2 mm that walls leave between the ends of planks.
TOUCHING = 0.02
# Share of the reach that is left beside a body: a thousandth of its smallest side, for what a file is written to. What
# an engine presses against something from the side is in it by a ten-thousandth, not apart from it.
BESIDE = 0.05
LIMIT_ITSELF = 1.0 + 1e-9  # so that what is written as the limit touches, whatever rounding makes of it
# Share of the reach up to which a gap is none: a millionth of the smallest side, 8 nm of a plank of 7.8 mm. It is a
# hundred times what sums of lengths leave, and more than the nanometres by which processors differ.
NO_GAP = 5e-5


def reach_between(thickness: float, other: float = inf, share: float = TOUCHING) -> float:
    """How far apart two bodies still touch [m], by the smallest side of each [m]; a plane has none, and is the default.

    No body reaches farther than to a plane, so whatever a body may touch is that near to it.
    """
    return LIMIT_ITSELF * share * (thickness if thickness < other else other)


def gap_bridged(reach: float, upward: float, within: float = inf) -> float:
    """The widest gap [m] that counts as contact, from the reach [m] and the z of the (unit) normal across the gap.

    If `within` [m] is less than the reach, it takes the place of the reach; at 0 only what is no gap counts.
    """
    share = min(1.0, max(BESIDE, upward, -upward))
    return min(reach * share, within * share + NO_GAP * reach)
