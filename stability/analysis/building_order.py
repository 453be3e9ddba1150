"""A building order of a finished design that stands at each step, and the least props if there is none.

The choice of props is a hitting-set problem. If no order exists with some set of props, each order with other props
passes a dead end of that search, so it has a prop that resists one of the falls found there. Each failed search thus
gives a clause, and the smallest set that satisfies all clauses is tried next.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from stability.analysis.subset_search import (
    Clause,
    Descent,
    OnProgress,
    Part,
    SubsetAnswer,
    Subsets,
    descend,
    ignore_progress,
    smallest,
)
from stability.model import BodyId
from stability.problem import Stability

MOST_ROUNDS = 200  # sets of props that are tried
BRIEFLY = 3  # verdicts per brick


@dataclass(frozen=True, slots=True)
class Step:
    """Placement of one brick."""

    brick: BodyId
    propped: bool  # whether the brick is propped when it is placed
    struck: tuple[BodyId, ...] = ()  # the bricks whose props are removed after it


@dataclass(frozen=True, slots=True)
class BuildingOrder:
    """Order of steps in which a design can be built."""

    steps: tuple[Step, ...]  # empty if none was found
    impossible: bool = False  # whether no order exists with any of the allowed props, proven
    props_at_least: int = 0  # lower bound for every order, proven
    without: Descent | None = None  # the search for an order without props

    @property
    def props(self) -> tuple[BodyId, ...]:
        """Return the bricks with a temporary prop."""
        return tuple(step.brick for step in self.steps if step.propped)

    @property
    def props_at_once(self) -> int:
        """Return the largest number of props at the same time."""
        standing = most = 0
        for step in self.steps:
            standing += step.propped
            most = max(most, standing)
            standing -= len(step.struck)
        return most


def building_order(parts: Subsets, most: int, on_progress: OnProgress = ignore_progress) -> BuildingOrder:
    """Return an order with the fewest props of those that `parts` allows; the whole design must stand."""
    return OrderSearch(parts, most, on_progress).run()


class OrderSearch:
    """Search for an order with the fewest props; after an interrupt `best` holds the best result so far."""

    def __init__(self, parts: Subsets, most: int, on_progress: OnProgress = ignore_progress) -> None:
        """Limit the search to `most` verdicts, besides those for a first order with props under all bricks.

        `on_progress` is called with the number of verdicts.
        """
        self.best = BuildingOrder(())
        self._parts, self._on_progress = parts, on_progress
        self._last = parts.verdict_count + most
        self._pieces = parts.components(parts.whole)

    def run(self) -> BuildingOrder:
        """Search to the end."""
        clauses: list[Clause] = []
        bounded = True
        for _ in range(MOST_ROUNDS):
            kept = smallest(len(self._parts.names), clauses)
            if kept.chosen is None:
                self.best = replace(self.best, impossible=bounded and not self.best.steps)
                break
            if bounded:
                self.best = replace(self.best, props_at_least=max(self.best.props_at_least, kept.at_least))
            failed = self._with(kept.chosen)
            if not failed:
                return self.best
            if self._parts.verdict_count >= self._last:
                break
            bounded &= all(each.exhausted for each in failed)
            clauses += [Clause(_would_help(self._parts, each)) for each in failed]
        self._spare()
        return self.best

    def _with(self, propped: Part) -> list[Descent]:
        """Search for an order with these props. Return the failed searches; without any, `best` holds the order."""
        parts = self._parts
        parts.propped = propped
        searches = [
            descend(parts, piece, 0, self._last - parts.verdict_count, self._on_progress) for piece in self._pieces
        ]
        failed = [each for each in searches if each.order is None]
        if self.best.without is None:
            self.best = replace(self.best, without=next(iter(failed), searches[0]))
            if failed:
                self._under_all()
            parts.propped = propped
        if not failed:
            order = [name for each in searches for name in reversed(each.order or ())]
            self.best = replace(self.best, steps=_with_props(parts, order, self._on_progress))
        return failed

    def _under_all(self) -> None:
        """Search for an order with props under all bricks: it has too many props but is found early."""
        before = self._parts.verdict_count
        self._parts.propped = self._parts.part_of(self._parts.props)
        if self._parts.propped:
            self._take(self._brief())
        self._last += self._parts.verdict_count - before

    def _spare(self) -> None:
        """Remove props one after the other; the remaining ones are few, but not always the fewest."""
        parts = self._parts
        parts.propped = parts.part_of(self.best.props)
        for name in parts.names_of(parts.propped):
            before = parts.propped
            parts.propped &= ~parts.part_of([name])
            fewer = self._brief()
            if fewer is None:
                parts.propped = before
            else:
                self._take(fewer)
        if self.best.steps:
            order = [step.brick for step in self.best.steps]
            self.best = replace(self.best, steps=_with_props(parts, order, self._on_progress))

    def _take(self, order: list[BodyId] | None) -> None:
        """Store an order with all current props, which stay to the end; the design stands without them."""
        if order is None:
            return
        held = tuple(self._parts.names_of(self._parts.propped))
        steps = [Step(name, name in held) for name in order]
        self.best = replace(self.best, steps=(*steps[:-1], replace(steps[-1], struck=held)))

    def _brief(self) -> list[BodyId] | None:
        """Return an order with the current props from a short search; None if it finds none."""
        most = BRIEFLY * len(self._parts.names)
        orders = [descend(self._parts, piece, 0, most, self._on_progress).order for piece in self._pieces]
        return None if None in orders else [name for order in orders for name in reversed(order or ())]


def least_props(
    parts: Subsets, states: Sequence[Part], on_progress: OnProgress = ignore_progress
) -> tuple[BodyId, ...] | None:
    """Return the fewest bricks whose props let all these parts stand; None if there is no such set.

    Verdicts cost least if each part is a subset of the one before it.
    """
    clauses: list[Clause] = []
    for _ in range(MOST_ROUNDS):
        kept = smallest(len(parts.names), clauses)
        if kept.chosen is None:
            return None
        parts.propped = kept.chosen
        ends = _falling(parts, states, on_progress)
        if not ends:
            return tuple(parts.names_of(kept.chosen))
        clauses += [Clause(_would_help(parts, Descent(None, ends=(end,)))) for end in ends]
    return None


def _falling(parts: Subsets, states: Sequence[Part], on_progress: OnProgress) -> list[tuple[Part, SubsetAnswer]]:
    """Return the parts that do not stand, with their verdicts."""
    ends: list[tuple[Part, SubsetAnswer]] = []
    larger = parts.whole
    for part in states:
        answer = parts.ask(part, larger if part & larger == part else None)
        on_progress(parts.verdict_count)
        if answer.stability is not Stability.STABLE:
            ends.append((part, answer))
        larger = part
    return ends


def _would_help(parts: Subsets, search: Descent) -> Part:
    """Return the bricks whose prop could resist one of the falls at which a search ended."""
    every, helpful = parts.part_of(parts.props), 0
    for part, answer in search.ends:
        helpful |= answer.fall.resisting if answer.fall is not None else every & part
    return helpful & ~parts.propped


def _with_props(parts: Subsets, order: list[BodyId], on_progress: OnProgress) -> tuple[Step, ...]:
    """Return the steps, with each prop removed as soon as all later steps stand without it."""
    present = [parts.part_of(order[: turn + 1]) for turn in range(len(order))]
    held = [parts.propped & part for part in present]
    struck: list[list[BodyId]] = [[] for _ in order]
    for name in reversed(parts.names_of(parts.propped)):
        bit = parts.part_of([name])
        turn = len(order)
        while (
            turn > 0 and held[turn - 1] & bit and _stands(parts, present[turn - 1], held[turn - 1] & ~bit, on_progress)
        ):
            turn -= 1
            held[turn] &= ~bit
        if turn < len(order) and any(part & bit for part in held):
            struck[turn].append(name)
    return tuple(
        Step(name, bool(parts.part_of([name]) & held[turn]) or name in struck[turn], tuple(sorted(struck[turn])))
        for turn, name in enumerate(order)
    )


def _stands(parts: Subsets, part: Part, propped: Part, on_progress: OnProgress) -> bool:
    parts.propped = propped
    on_progress(parts.verdict_count)
    return parts.ask(part).stability is Stability.STABLE
