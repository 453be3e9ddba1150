"""Do two bodies touch? The one definition: statics, both methods, the compiler and `explain` all take it from here.

Two bodies touch if they are no further apart, and no deeper in each other, than their reach, a share of the smallest
side of the thinner one. So a scene touches where it did when all of it is made larger or smaller.
"""

from math import inf

# Share of the smallest side: what engines leave. Less than a fifth of a millimetre for a plank of 7.8 mm, below the
# 0.2 mm that walls leave between the ends of planks.
TOUCHING = 0.02
LIMIT_ITSELF = 1.0 + 1e-9  # so that what is written as the limit touches, whatever rounding makes of it


def reach_between(thickness: float, other: float = inf, share: float = TOUCHING) -> float:
    """How far apart two bodies still touch [m], by the smallest side of each [m]; a plane has none, and is the default.

    No body reaches farther than to a plane, so whatever a body may touch is that near to it.
    """
    return LIMIT_ITSELF * share * (thickness if thickness < other else other)
