"""Taking a part of a design apart, one brick at a time, so that what is left stands each time.

Depth first, the highest brick first, and no part is entered twice. What can be built up stepwise can be taken apart in
the reverse order, so this finds building orders as well. Where every way ends, there is none: each end has a proof.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from stability.model import BodyId
from stability.shapes.in_pose import top_W
from stability.statics.facts import Stability
from stability.statics.orders.parts import Answer, Part, Parts

Known = Callable[[int], None]  # is told how many verdicts were asked so far


def nobody(_: int) -> None:
    """Wants to know nothing."""


@dataclass(frozen=True, slots=True)
class Descent:
    """What came of a search."""

    order: tuple[BodyId, ...] | None  # in which bricks go; None if none was found
    exhausted: bool = True  # whether every way was gone that there is
    ends: tuple[tuple[Part, Answer], ...] = field(default=())  # parts next to those that stand, which do not

    @property
    def impossible(self) -> bool:
        """Whether it is proven that there is none."""
        return self.order is None and self.exhausted and all(a.stability is Stability.UNSTABLE for _, a in self.ends)


def descend(parts: Parts, start: Part, goal: Part, most: int, known: Known = nobody) -> Descent:
    """Take away all bricks of `start` that are not in `goal`; `start` stands. It asks for at most `most` verdicts."""
    last, ends = parts.asked + most, dict[Part, Answer]()
    path: list[BodyId] = []
    seen = {start}
    waiting = [(start, _next(parts, start, goal))]
    while waiting:
        part, smaller = waiting[-1]
        if part == goal:
            return Descent(tuple(path), ends=tuple(ends.items()))
        for name, less in smaller:
            if less in seen:
                continue
            if parts.asked >= last:
                return Descent(None, exhausted=False, ends=tuple(ends.items()))
            seen.add(less)
            answer = parts.ask(less, part)
            known(parts.asked)
            if answer.stability is Stability.STABLE:
                path.append(name)
                waiting.append((less, _next(parts, less, goal)))
                break
            ends[less] = answer
        else:
            waiting.pop()
            if path:
                path.pop()
    return Descent(None, ends=tuple(ends.items()))


def _next(parts: Parts, part: Part, goal: Part) -> Iterator[tuple[BodyId, Part]]:
    """The bricks that may go, from the top down, and what is left without each."""
    for name in from_the_top(parts, part & ~goal):
        yield name, part & ~parts.part_of([name])


def from_the_top(parts: Parts, part: Part) -> list[BodyId]:
    """Bricks by how high they reach, the highest first; ties by name."""
    bricks = parts.design.bricks
    heights = {name: top_W(bricks[name].brick.shape, bricks[name].pose) for name in parts.names_of(part)}
    return sorted(heights, key=lambda name: (-round(heights[name], 9), name))
