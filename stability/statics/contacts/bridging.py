"""Do the gaps between two bodies that are near each other count as contact? It depends on where each leads.

A direction in which two bodies are further apart than counts along it parts them, whatever is nearer elsewhere: no
corner that lies beside another body holds it up. Where they do touch, each point of the contact is asked again.
"""

from collections.abc import Iterable, Sequence

from stability.geometry.touching import NO_GAP, gap_bridged
from stability.model import Vec3


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
