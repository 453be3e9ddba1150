"""Decision which gaps between near bodies are contacts, and which flush contacts transfer no force."""

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import cos, pi, sin

from stability.geometry.box_distance import NO_GAP, gap_bridged
from stability.geometry.vectors import dot
from stability.model import Vec3

# Contacts across gaps.
#
# Two bodies are apart if the gap along any separating direction is too large, even if others are smaller: a corner
# beside another body does not support it. The gap of each point of a contact is tested again.


def all_bridged(separations: Iterable[tuple[float, Vec3]], reach: float, within: float) -> bool:
    """Check that all gaps [m] along these (unit) directions are small enough for a contact."""
    return all(gap <= 0.0 or gap <= gap_bridged(reach, direction[2], within) for gap, direction in separations)


def gaps_of(heights: Sequence[float], reach: float) -> tuple[float, ...]:
    """Return the gaps at the points of a contact [m], with 0 for rounding; empty if all are 0.

    `heights` are those of one body above the other at these points [m].
    """
    if max(heights, default=0.0) <= NO_GAP * reach:
        return ()
    return tuple(float(height) if height > NO_GAP * reach else 0.0 for height in heights)


# Flush contacts: two bodies that touch where each can move past the other, so that no force is transferred.
#
# In columns of cartons side by side, diagonal neighbours touch along the common edge of four. The plane of a top
# separates the upper carton of such a pair from the lower one, and so does the plane of a side. Either suffices: the
# upper carton can slide down along the side, so neither top nor side resists every motion. So the contact transfers no
# force, unless the bodies overlap by more than rounding (docs/design/contacts.md).
#
# If the planes are not perpendicular, or if both lean, as between planks that lean on each other, the load presses the
# bodies together along either plane, and the contact transfers force.


SQUARE = sin(pi / 36.0)  # largest cosine between the normals of perpendicular planes (5 degrees)
# Vertical component of a unit normal above which it counts as vertical, and below which as horizontal.
NEAR_UPRIGHT, NEAR_LEVEL = cos(pi / 6.0), sin(pi / 6.0)


def run_flush(faces: Iterable[tuple[float, Vec3]], overlap: float) -> bool:
    """Check that a contact of two bodies that overlap by at most `overlap` [m] transfers no force.

    `faces` are those of both: the gap along the normal [m], and the unit normal from one body to the other.
    """
    separating = [normal for gap, normal in faces if gap >= -overlap]
    return any(_are_perpendicular(first, second) for first, second in combinations(separating, 2))


def _are_perpendicular(first: Vec3, second: Vec3) -> bool:
    steepest = max(abs(first[2]), abs(second[2]))
    return abs(dot(first, second)) < SQUARE and (steepest > NEAR_UPRIGHT or steepest < NEAR_LEVEL)
