"""Removals from a standing structure: possible single removals, the longest order, and the earliest fall.

The longest order is bounded from both sides: from below by computed orders, with each intermediate part proven; from
above by the smallest remainder. A remainder must stand, and each proven fall excludes all parts for which it holds, so
the smallest set of bricks that no fall excludes has at most as many bricks as any standing part. These sets are judged,
and their falls exclude more sets, until one stands or none is left.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from stability.analysis.subset_search import (
    Clause,
    OnProgress,
    Part,
    Subsets,
    descend,
    from_the_top,
    ignore_progress,
    smallest,
)
from stability.model import BodyId
from stability.name_order import in_order
from stability.problem import Contact, Stability, Verdict
from stability.statics.assembly import Assembly

WALL = 0.01  # vertical part of a normal up to which a contact is with a wall: half a degree
MOST_ABREAST = 3
MOST_ROUNDS = 60  # of the integer program
MOST_DESCENTS = 20  # remainders for which an order is searched


@dataclass(frozen=True, slots=True)
class Pull:
    """Result of removing one brick from the whole structure."""

    brick: BodyId
    carries: bool  # whether another brick rests on it
    verdict: Verdict  # of all other bricks


@dataclass(frozen=True, slots=True)
class LongestOrder:
    """Longest order of pulls with a standing remainder after each pull."""

    order: tuple[BodyId, ...]
    at_most: int  # upper bound on the pulls of any such order, proven
    reason: str = ""  # why the order is not proven to be the longest

    @property
    def proven(self) -> bool:
        """Return whether no order is longer."""
        return len(self.order) == self.at_most


@dataclass(frozen=True, slots=True)
class EarliestFall:
    """Least number of pulls that bring the structure down."""

    at_least: int  # lower bound on the pulls before a fall, for any order, proven
    order: tuple[BodyId, ...] = ()  # pulls of which the last causes the fall; empty if none was found
    undecided: int = 0  # pulls of up to this number of bricks for which nothing was proven


def carrying(design: Assembly) -> list[BodyId]:
    """Return the bricks on which others rest or lean, in natural order."""
    return in_order([name for name in design.bricks if any(_bears(c, name) for c in design.contacts(name))])


def _bears(contact: Contact, brick: BodyId) -> bool:
    """Return whether a contact pushes the other brick upwards by more than a wall does."""
    return contact.lower == brick and max(normal[2] for normal in contact.normals_W) > WALL


def single_pulls(design: Assembly) -> Iterator[Pull]:
    """Yield the verdict on all other bricks, for each brick of a standing assembly."""
    load_bearing = set(carrying(design))
    for name in in_order(design.bricks):
        yield Pull(name, name in load_bearing, design.would_without([name]))


def longest_order(parts: Subsets, may_go: Part, most: int, on_progress: OnProgress = ignore_progress) -> LongestOrder:
    """Return the longest order of pulls of given bricks from a standing design, with at most `most` verdicts."""
    return LongestSearch(parts, may_go, most, on_progress).run()


class LongestSearch:
    """Search for the longest order from both sides; after an interrupt `best` holds the current bounds."""

    def __init__(self, parts: Subsets, may_go: Part, most: int, on_progress: OnProgress = ignore_progress) -> None:
        """Limit the pulls to `may_go` and the search to `most` verdicts; `on_progress` is called with their number."""
        self.parts, self.may_go, self.on_progress = parts, may_go, on_progress
        self.last = parts.verdict_count + most  # limit of the number of verdicts
        self.order: tuple[BodyId, ...] = ()
        self.at_most = may_go.bit_count()
        self.clauses: list[Clause] = []  # conditions on the remainders
        self.reason = ""  # why the search stopped
        self.used = 0  # number of the falls in `clauses`
        self.descents = 0
        self.bounded = True  # whether all excluded sets were excluded by a proof

    @property
    def best(self) -> LongestOrder:
        """Return the current bounds."""
        reason = self.reason or ("" if self.closed else "the search ended before the bounds met")
        return LongestOrder(self.order, max(self.at_most, len(self.order)), reason)

    @property
    def closed(self) -> bool:
        """Return whether no order is longer."""
        return len(self.order) >= self.at_most

    def run(self) -> LongestOrder:
        """Search to the end."""
        self._pull_greedily()
        if not self.closed:
            self.clauses = [
                Clause(self.parts.part_of([n])) for n in self.parts.names_of(self.parts.whole & ~self.may_go)
            ]
            _learn_of_rows(self.parts, self.last)
        for _ in range(MOST_ROUNDS):
            if self.closed or self.reason:
                break
            self._step()
        return self.best

    def _pull_greedily(self) -> None:
        """Store the longer of two orders, which pull the highest or the lowest removable brick each time."""
        parts = self.parts
        names = from_the_top(parts, self.may_go)
        for turn in (names, names[::-1]):
            part, order, tried = parts.whole, list[BodyId](), True
            while tried:
                tried = False
                for name in turn:
                    less = part & ~parts.part_of([name])
                    if less == part or parts.verdict_count >= self.last:
                        continue
                    if parts.ask(less, part).stability is Stability.STABLE:
                        part, tried = less, True
                        order.append(name)
                        self.order = max(self.order, tuple(order), key=len)
                    self.on_progress(parts.verdict_count)

    def _step(self) -> None:
        """Judge the smallest possible remainder."""
        parts, count = self.parts, len(self.parts.names)
        self.clauses += [Clause(fall.absent, fall.moving) for fall in parts.falls[self.used :]]
        self.used = len(parts.falls)
        kept = smallest(count, self.clauses)
        if self.bounded:
            self.at_most = min(self.at_most, count - kept.at_least)
        if kept.chosen is None or len(self.order) >= count - kept.chosen.bit_count():
            self.reason = "" if self.closed else "no longer order was found, but some verdicts were not proven"
            return
        if parts.verdict_count >= self.last:
            self.reason = "the limit of verdicts was reached"
            return
        stands = parts.ask(kept.chosen).stability is Stability.STABLE
        self.on_progress(parts.verdict_count)
        if not stands:
            parts.learn(kept.chosen)
            if len(parts.falls) > self.used:
                return
        if stands and self._way_to(kept.chosen):
            return
        self.bounded &= stands
        self.clauses.append(Clause(parts.whole & ~kept.chosen, kept.chosen))  # exclude this set from now on

    def _way_to(self, kept: Part) -> bool:
        """Search for an order that leaves exactly this remainder; return whether there is one."""
        self.descents += 1
        if self.descents > MOST_DESCENTS:
            self.reason = "a smaller remaining structure was found, but no order that leads to it"
        search = descend(self.parts, self.parts.whole, kept, self.last - self.parts.verdict_count, self.on_progress)
        self.bounded &= search.order is not None or search.impossible
        self.order = search.order or self.order
        return search.order is not None


def _learn_of_rows(parts: Subsets, last: int) -> None:
    """Learn the falls of unsupported bricks: single ones, and two or three side by side."""
    beside = {name: parts.part_of(_beside(parts, name)) for name in parts.names}
    rows = {parts.part_of([name]) for name in parts.names}
    for _ in range(MOST_ABREAST - 1):
        wider = set()
        for row in rows:
            neighbours = 0
            for name in parts.names_of(row):
                neighbours |= beside[name]
            wider |= {row | parts.part_of([name]) for name in parts.names_of(neighbours & ~row)}
        rows |= wider
    for row in sorted(rows):
        if parts.verdict_count >= last:
            break
        parts.learn(row)


def _beside(parts: Subsets, name: BodyId) -> list[BodyId]:
    contacts = parts.design.contacts(name)
    walls = [c for c in contacts if not _bears(c, c.lower)]
    return [body for contact in walls for body in (contact.lower, contact.upper) if body != name]


def soonest_fall(parts: Subsets, may_go: Part, most: int, on_progress: OnProgress = ignore_progress) -> EarliestFall:
    """Return the fewest pulls that bring a standing design down, with at most `most` verdicts."""
    last, undecided = parts.verdict_count + most, 0
    names = from_the_top(parts, may_go)[::-1]
    for count in range(1, len(names) + 1):
        for chosen in combinations(names, count):
            part = parts.whole & ~parts.part_of(chosen)
            if parts.verdict_count >= last:
                return EarliestFall(1 if undecided else count, (), undecided)
            answer = parts.ask(part, part | parts.part_of(chosen[-1:]))
            on_progress(parts.verdict_count)
            if answer.stability is Stability.UNSTABLE:
                return EarliestFall(1 if undecided else count, chosen, undecided)
            undecided += answer.stability is Stability.UNDECIDED
    return EarliestFall(len(names) + 1, (), undecided)
