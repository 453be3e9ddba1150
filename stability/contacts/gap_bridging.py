"""Decides which gaps between near bodies count as contact, and which flush sides carry nothing."""

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import cos, pi, sin

from stability.geometry.box_distance import NO_GAP, gap_bridged
from stability.geometry.vectors import dot
from stability.model import Vec3

# Decides whether the gaps between two near bodies count as contact.
#
# A direction in which two bodies are further apart than counts along it parts them, whatever is nearer elsewhere: no
# corner that lies beside another body holds it up. Where they do touch, each point of the contact is asked again.


def all_bridged(apart: Iterable[tuple[float, Vec3]], reach: float, within: float) -> bool:
    """Whether bodies touch that are so far apart [m] along these (unit) directions, as their reach bridges it."""
    return all(gap <= 0.0 or gap <= gap_bridged(reach, way[2], within) for gap, way in apart)


def gaps_of(heights: Sequence[float], reach: float) -> tuple[float, ...]:
    """How far bodies are apart at each point of a contact [m]: 0 where it is rounding, and nothing if it is so at all.

    `heights` are those of the one body above the other at these points [m].
    """
    if max(heights, default=0.0) <= NO_GAP * reach:
        return ()
    return tuple(float(height) if height > NO_GAP * reach else 0.0 for height in heights)


# Decides whether two bodies run flush: they touch where each can move past the other, so nothing is carried there.
#
# Cartons that stand side by side in columns touch across from each other too, along the edge of four. The plane of a
# top keeps the upper one of two such cartons from the lower one, and so does the plane of their sides. Either is
# enough: the upper one can slide down past that side, so the top holds it by no force that every motion must work
# against, nor does the side. So nothing is carried, unless they overlap by more than rounding (docs/design/contacts.md).
#
# Where the planes are not square to each other, or both lean, as between planks that lean on each other, the load
# presses one body against the other whichever plane it passes: these touch.


SQUARE = sin(pi / 36.0)  # cosine between the normals of planes that are square to each other, to 5 degrees
NEAR_UPRIGHT, NEAR_LEVEL = (
    cos(pi / 6.0),
    sin(pi / 6.0),
)  # rise of a unit normal above which, and below which, it counts as such


def run_flush(faces: Iterable[tuple[float, Vec3]], overlap: float) -> bool:
    """Whether two bodies carry nothing where they touch, if they overlap by no more than this [m].

    `faces` are those of both: the gap along the normal [m], and that normal, unit and from the one body to the other.
    """
    parting = [normal for gap, normal in faces if gap >= -overlap]
    return any(_lead_past(one, other) for one, other in combinations(parting, 2))


def _lead_past(one: Vec3, other: Vec3) -> bool:
    steepest = max(abs(one[2]), abs(other[2]))
    return abs(dot(one, other)) < SQUARE and (steepest > NEAR_UPRIGHT or steepest < NEAR_LEVEL)
