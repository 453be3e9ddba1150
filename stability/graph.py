"""Orders and neighbourhoods of the support graph. Nodes are bricks, edges point down to supports."""

from collections.abc import Callable, Collection, Iterable, Mapping
from heapq import heapify, heappop, heappush

from stability.model import BodyId


def carried_by(rests_on: Mapping[BodyId, Iterable[BodyId]]) -> dict[BodyId, list[BodyId]]:
    """Return for each brick the bricks that rest directly on it, sorted by name; the ground is no brick."""
    above: dict[BodyId, list[BodyId]] = {brick: [] for brick in rests_on}
    for upper in sorted(rests_on):
        for lower in rests_on[upper]:
            if lower in above:
                above[lower].append(upper)
    return above


def from_the_top(rests_on: Mapping[BodyId, Iterable[BodyId]]) -> list[BodyId]:
    """Sort bricks so that each comes after all that it carries, to sum loads in one pass; ties by name."""
    waiting = {lower: len(uppers) for lower, uppers in carried_by(rests_on).items()}
    ready = [brick for brick, count in waiting.items() if count == 0]
    heapify(ready)
    order = []
    while ready:
        brick = heappop(ready)
        order.append(brick)
        for lower in rests_on[brick]:
            if lower in waiting:
                waiting[lower] -= 1
                if waiting[lower] == 0:
                    heappush(ready, lower)
    return order


def with_all_above(rests_on: Mapping[BodyId, Iterable[BodyId]], roots: Iterable[BodyId]) -> set[BodyId]:
    """Return `roots` and all bricks that rest on them, directly or through others."""
    return reached(roots, carried_by(rests_on).__getitem__)


def reached(roots: Iterable[BodyId], onwards: Callable[[BodyId], Iterable[BodyId]]) -> set[BodyId]:
    """Return `roots` and all nodes that are reachable from them by `onwards`."""
    visited: set[BodyId] = set()
    waiting = list(roots)
    while waiting:
        brick = waiting.pop()
        if brick not in visited:
            visited.add(brick)
            waiting.extend(onwards(brick))
    return visited


def components(bricks: Collection[BodyId], touching: Callable[[BodyId], Iterable[BodyId]]) -> list[set[BodyId]]:
    """Divide bricks into connected components, whose bricks touch directly or through others."""
    remaining, groups = set(bricks), list[set[BodyId]]()
    for brick in sorted(bricks):
        if brick in remaining:
            groups.append(reached([brick], lambda name: [other for other in touching(name) if other in bricks]))
            remaining -= groups[-1]
    return groups
